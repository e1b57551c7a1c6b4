/* hypre's best solver for a box: conjugate gradients with one PFMG cycle (geometric multigrid, semicoarsening).
 *
 *   mpirun -n PROCESSES hypre_pfmg CELLS WALLS ALPHA KAPPA TOLERANCE
 *   mpirun -n 2 hypre_pfmg 128x128x128 closed 0 1 1e-6
 *
 * Solves (alpha - kappa sum of differences) x = b from zero until |b - A x| <= TOLERANCE |b| in the 2-norm, and prints one
 * line of JSON. WALLS: closed, valued (zero half a cell away: conductance 2 kappa) or periodic, on all sides. b is the
 * noise of `rough` without its mean, so that a Poisson problem between closed or periodic walls is consistent.
 *
 * Build: mpicc -O2 -I/usr/include/hypre hypre_pfmg.c -lHYPRE -lm
 */
#include <HYPRE_struct_ls.h>
#include <math.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static int rank, dim, cells[3] = {1, 1, 1}, low[3], high[3];

static void stop(const char *why) {
    if (rank == 0) fprintf(stderr, "hypre_pfmg: %s\n", why);
    MPI_Abort(MPI_COMM_WORLD, 1);
}

static double sum_over_all(double mine) {
    double all;
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    return all;
}

/* Peak resident bytes of all processes so far. */
static double peak(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return sum_over_all(1024.0 * usage.ru_maxrss);
}

/* A number between -1 and 1 that has nothing to do with its neighbours'; the same formula as in xtask's problem.rs. */
static double rough(const int *cell) {
    uint64_t h = 0x9E3779B97F4A7C15u;
    for (int a = 0; a < dim; a++) {
        h = (h ^ (uint64_t)cell[a]) * 0xBF58476D1CE4E5B9u;
        h ^= h >> 29;
    }
    return (double)(h >> 11) / 4503599627370496.0 - 1.0;
}

/* The next cell of this process's box, the first axis fastest; 0 behind the last one. */
static int next(int *cell) {
    for (int a = 0; a < dim; a++) {
        if (cell[a]++ < high[a]) return 1;
        cell[a] = low[a];
    }
    return 0;
}

/* The cells of one layer across the last axis: what is filled or read at a time, so that no copy of a field is held. */
static size_t layer(int at, int *first, int *last) {
    size_t count = 1;
    for (int a = 0; a < dim; a++) {
        first[a] = a == dim - 1 ? at : low[a];
        last[a] = a == dim - 1 ? at : high[a];
        count *= (size_t)(last[a] - first[a] + 1);
    }
    return count;
}

/* Sums of v and v squared over all cells. */
static void sums(HYPRE_StructVector v, double *values, double *one, double *two) {
    int first[3], last[3];
    *one = *two = 0.0;
    for (int at = low[dim - 1]; at <= high[dim - 1]; at++) {
        size_t count = layer(at, first, last);
        HYPRE_StructVectorGetBoxValues(v, first, last, values);
        for (size_t i = 0; i < count; i++) {
            *one += values[i];
            *two += values[i] * values[i];
        }
    }
    *one = sum_over_all(*one);
    *two = sum_over_all(*two);
}

int main(int argc, char **argv) {
    int processes, grid[3] = {0, 0, 0}, periods[3] = {0, 0, 0};
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &processes);
    HYPRE_Init();
    const double idle = peak();

    if (argc != 6) stop("expected CELLS WALLS ALPHA KAPPA TOLERANCE");
    dim = sscanf(argv[1], "%dx%dx%d", &cells[0], &cells[1], &cells[2]);
    const int valued = !strcmp(argv[2], "valued"), periodic = !strcmp(argv[2], "periodic");
    const double alpha = atof(argv[3]), kappa = atof(argv[4]), tolerance = atof(argv[5]);
    if (dim < 2) stop("expected two or three axes");
    if (!valued && !periodic && strcmp(argv[2], "closed")) stop("expected closed, valued or periodic walls");

    /* A box for each process; the last axis, whose layers lie together in memory, is split first. */
    MPI_Dims_create(processes, dim, grid);
    double all_cells = 1.0;
    for (int a = 0, rest = rank; a < dim; a++) {
        const int parts = grid[dim - 1 - a], part = rest % parts;
        rest /= parts;
        if (parts > cells[a]) stop("more processes than cells along an axis");
        low[a] = (int)((int64_t)cells[a] * part / parts);
        high[a] = (int)((int64_t)cells[a] * (part + 1) / parts) - 1;
        all_cells *= cells[a];
        if (periodic) periods[a] = cells[a];
    }
    HYPRE_StructGrid box;
    HYPRE_StructGridCreate(MPI_COMM_WORLD, dim, &box);
    HYPRE_StructGridSetExtents(box, low, high);
    HYPRE_StructGridSetPeriodic(box, periods);
    HYPRE_StructGridAssemble(box);

    /* The diagonal and the conductance of each high face: the matrix is symmetric and stored so. */
    HYPRE_StructStencil stencil;
    HYPRE_StructStencilCreate(dim, dim + 1, &stencil);
    int entries[4] = {0, 1, 2, 3};
    for (int e = 0; e <= dim; e++) {
        int offset[3] = {e == 1, e == 2, e == 3};
        HYPRE_StructStencilSetElement(stencil, e, offset);
    }
    HYPRE_StructMatrix A;
    HYPRE_StructMatrixCreate(MPI_COMM_WORLD, box, stencil, &A);
    HYPRE_StructMatrixSetSymmetric(A, 1);
    HYPRE_StructMatrixInitialize(A);
    HYPRE_StructVector b, x;
    HYPRE_StructVectorCreate(MPI_COMM_WORLD, box, &b);
    HYPRE_StructVectorCreate(MPI_COMM_WORLD, box, &x);
    HYPRE_StructVectorInitialize(b);
    HYPRE_StructVectorInitialize(x);

    int cell[3] = {low[0], low[1], low[2]}, from[3], to[3];
    double mean = 0.0;
    do mean += rough(cell);
    while (next(cell));
    mean = sum_over_all(mean) / all_cells;
    const size_t most = layer(low[dim - 1], from, to);
    double *values = malloc(most * (size_t)(dim + 1) * sizeof *values);
    if (!values) stop("not enough memory");
    for (int at = low[dim - 1]; at <= high[dim - 1]; at++) {
        const size_t count = layer(at, from, to);
        for (size_t i = 0; i < count; i++, next(cell)) {
            double *row = values + i * (size_t)(dim + 1);
            row[0] = alpha;
            for (int a = 0; a < dim; a++) {
                const int walls = periodic ? 0 : (cell[a] == 0) + (cell[a] == cells[a] - 1);
                row[0] += kappa * (2 - walls) + (valued ? 2.0 * kappa * walls : 0.0);
                row[1 + a] = !periodic && cell[a] == cells[a] - 1 ? 0.0 : -kappa;
            }
        }
        HYPRE_StructMatrixSetBoxValues(A, from, to, dim + 1, entries, values);
    }
    for (int at = low[dim - 1]; at <= high[dim - 1]; at++) {
        const size_t count = layer(at, from, to);
        for (size_t i = 0; i < count; i++, next(cell)) values[i] = rough(cell) - mean;
        HYPRE_StructVectorSetBoxValues(b, from, to, values);
    }
    HYPRE_StructMatrixAssemble(A);
    HYPRE_StructVectorAssemble(b);
    HYPRE_StructVectorAssemble(x);

    /* PFMG as fast as it gets on this problem: red-black Gauss-Seidel, one sweep down and up, levels that need none
     * skipped, coarse operators with the stencil of the fine one. */
    HYPRE_StructSolver pfmg, pcg;
    HYPRE_StructPFMGCreate(MPI_COMM_WORLD, &pfmg);
    HYPRE_StructPFMGSetMaxIter(pfmg, 1);
    HYPRE_StructPFMGSetTol(pfmg, 0.0);
    HYPRE_StructPFMGSetZeroGuess(pfmg);
    HYPRE_StructPFMGSetRelaxType(pfmg, 2);
    HYPRE_StructPFMGSetNumPreRelax(pfmg, 1);
    HYPRE_StructPFMGSetNumPostRelax(pfmg, 1);
    HYPRE_StructPFMGSetSkipRelax(pfmg, 1);
    HYPRE_StructPFMGSetRAPType(pfmg, 1);
    HYPRE_StructPCGCreate(MPI_COMM_WORLD, &pcg);
    HYPRE_StructPCGSetTwoNorm(pcg, 1);
    HYPRE_StructPCGSetRelChange(pcg, 0);
    HYPRE_StructPCGSetTol(pcg, tolerance);
    HYPRE_StructPCGSetPrecond(pcg, HYPRE_StructPFMGSolve, HYPRE_StructPFMGSetup, pfmg);

    MPI_Barrier(MPI_COMM_WORLD);
    double begun = MPI_Wtime();
    HYPRE_StructPCGSetup(pcg, A, b, x);
    MPI_Barrier(MPI_COMM_WORLD);
    const double setup = MPI_Wtime() - begun;

    /* An iteration that touches all memory. */
    HYPRE_StructPCGSetMaxIter(pcg, 1);
    begun = MPI_Wtime();
    HYPRE_StructPCGSolve(pcg, A, b, x);
    MPI_Barrier(MPI_COMM_WORLD);
    const double first = MPI_Wtime() - begun;
    HYPRE_ClearAllErrors();
    HYPRE_StructPCGSetMaxIter(pcg, 400);
    HYPRE_StructVectorSetConstantValues(x, 0.0);
    MPI_Barrier(MPI_COMM_WORLD);
    begun = MPI_Wtime();
    HYPRE_StructPCGSolve(pcg, A, b, x);
    MPI_Barrier(MPI_COMM_WORLD);
    const double seconds = MPI_Wtime() - begun;
    const double bytes = peak() - idle;

    /* What was solved: the true residual, and the 2-norm of x without its mean. */
    int iterations;
    double sum, square, rhs, residual;
    HYPRE_StructPCGGetNumIterations(pcg, &iterations);
    sums(b, values, &sum, &rhs);
    sums(x, values, &sum, &square);
    const double norm = sqrt(square - sum * sum / all_cells);
    HYPRE_StructMatrixMatvec(-1.0, A, x, 1.0, b);
    sums(b, values, &sum, &residual);
    if (rank == 0)
        printf("{\"iterations\": %d, \"seconds\": %.6e, \"setup_seconds\": %.6e, \"first_seconds\": %.6e, \"bytes\": %.0f, "
               "\"residual\": %.6e, \"norm\": %.15e}\n",
               iterations, seconds, setup, first, bytes, sqrt(residual / rhs), norm);

    free(values);
    HYPRE_StructPCGDestroy(pcg);
    HYPRE_StructPFMGDestroy(pfmg);
    HYPRE_StructMatrixDestroy(A);
    HYPRE_StructVectorDestroy(x);
    HYPRE_StructVectorDestroy(b);
    HYPRE_StructStencilDestroy(stencil);
    HYPRE_StructGridDestroy(box);
    HYPRE_Finalize();
    MPI_Finalize();
    return 0;
}
