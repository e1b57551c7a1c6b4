//! PCG-multigrid iterations to a relative 2-norm residual of 1e-6 from a zero guess, on random right-hand sides.

use cf_linear::{Options, Plan, Precision, Solver, Stop};

use crate::common::*;

fn solve<const D: usize>(cells: [usize; D], mix: [Mix; D], alpha: f64, kappa: f64, precision: Precision) -> usize {
    let case = Case::new(cells, mix, alpha, kappa);
    let options = Options { plan: Some(Plan::Multigrid), precision, ..Default::default() };
    let mut solver = Solver::<f64, D>::new(&case.helmholtz(), options).unwrap();
    solve_for(&mut solver, &case, &random_field::<f64, D>(&case.layout, 7))
}

fn solve_for<const D: usize>(solver: &mut Solver<f64, D>, case: &Case<D>, b: &[f64]) -> usize {
    let mut x = vec![0.0; case.layout.slots()];
    match solver.solve(b, &mut x, Stop::Relative(1e-6)) {
        Ok(s) => s.iterations,
        Err(e) => panic!("{:?} {:?} alpha {} kappa {:e}: {e}", case.layout.cells(), case.walls, case.alpha, case.kappa),
    }
}

/// In f64, and with cycles in f32 for the strong kappa.
fn worst<const D: usize>(cells: [usize; D], mixes: &[[Mix; D]], allowed: usize) {
    let mut worst = (0, String::new());
    for &mix in mixes {
        for (alpha, kappa) in
            [1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e5, 1e8, 1e12].map(|k| (1.0, k)).into_iter().chain([(0.0, 1.0)])
        {
            for precision in [Precision::Full, Precision::Single] {
                if precision == Precision::Single && alpha > 0.0 && kappa != 1e5 {
                    continue;
                }
                let n = solve(cells, mix, alpha, kappa, precision);
                if n > worst.0 {
                    worst = (n, format!("{mix:?} alpha {alpha} kappa {kappa:e} {precision:?}"));
                }
            }
        }
    }
    println!("{cells:?}: {} at {}", worst.0, worst.1);
    assert!(worst.0 <= allowed, "{cells:?}: {} iterations at {}", worst.0, worst.1);
}

#[test]
fn even_boxes_need_at_most_8() {
    worst([128, 128], &mixes_2d(), 8);
    worst([32, 64], &mixes_2d(), 8);
    worst([32, 32, 32], &mixes_3d(), 8);
    worst([16, 32, 8], &all_mixes_3d(), 8);
    worst([64, 32, 16], &mixes_3d(), 8);
}

/// Sizes whose halves are soon odd.
#[test]
fn even_boxes_of_odd_halves_need_at_most_8() {
    worst([66, 66], &mixes_2d(), 8);
    worst([130, 50], &mixes_2d(), 8);
    worst([1000, 34], &mixes_2d()[..10], 8);
    worst([34; 3], &mixes_3d(), 8);
    worst([66; 3], &mixes_3d()[..6], 8);
    worst([130, 66, 34], &mixes_3d()[..6], 8);
    worst([50, 70, 90], &mixes_3d()[..6], 8);
    worst([10, 22, 38], &all_mixes_3d(), 8);
}

#[test]
fn other_sizes_need_at_most_10() {
    worst([97, 61], &mixes_2d(), 10);
    worst([33, 33, 33], &mixes_3d(), 10);
    worst([97, 61, 45], &mixes_3d(), 8);
    worst([3, 5, 7], &all_mixes_3d(), 10);
    worst([17, 13, 9], &all_mixes_3d(), 10);
    for n in [1, 2, 3, 5, 17, 100, 1001] {
        worst([1, n], &mixes_2d(), 10);
        worst([n, 1], &mixes_2d(), 10);
    }
    worst([1, 1, 77], &mixes_3d(), 10);
    worst([50, 3], &mixes_2d(), 10);
    worst([127, 129], &mixes_2d(), 10);
}

/// A power of two and one: every level is odd. Smooth right-hand sides and single cells are harder there than noise.
#[test]
fn a_cell_more_than_halves_evenly_needs_at_most_8() {
    fn all<const D: usize>(cells: [usize; D], mixes: &[[Mix; D]]) {
        let mut counts = Vec::new();
        for &mix in mixes {
            for (alpha, kappa) in [(1.0, 72.16), (1.0, 3.85e3), (1.0, 1e6), (0.0, 1.0)] {
                let case = Case::new(cells, mix, alpha, kappa);
                let options = Options { plan: Some(Plan::Multigrid), ..Default::default() };
                let mut solver = Solver::<f64, D>::new(&case.helmholtz(), options).unwrap();
                let mut waves = vec![0.0; case.layout.slots()];
                let wave =
                    |a: usize, i: usize| (2.0 * std::f64::consts::TAU * (i as f64 + 0.5) / cells[a] as f64).cos();
                case.layout.par_cells(&mut waves, |at| (0..D).map(|a| wave(a, at.cell[a])).product());
                let mut one = vec![0.0; case.layout.slots()];
                one[case.layout.slot(cells.map(|n| n / 3))] = 1.0;
                for b in [waves, one, random_field::<f64, D>(&case.layout, 3)] {
                    counts.push(solve_for(&mut solver, &case, &b));
                }
            }
        }
        println!("{cells:?}: {counts:?}");
        assert!(counts.iter().all(|&n| n <= 8), "{cells:?}: {counts:?}");
    }
    all([33; 3], &mixes_3d());
    all([65; 3], &mixes_3d()[1..5]);
    all([129; 3], &mixes_3d()[1..2]);
    all([257; 2], &mixes_2d());
}

#[test]
fn single_precision_cycles_need_no_more_iterations() {
    for kappa in [1.0, 1e4, 1e8] {
        for mix in [[None; 2], [Some([End::Closed; 2]); 2], [Some([End::Held; 2]); 2]] {
            let (full, single) = (
                solve([96, 64], mix, 1.0, kappa, Precision::Full),
                solve([96, 64], mix, 1.0, kappa, Precision::Single),
            );
            assert!(single <= full, "kappa {kappa:e}: {full} {single}");
        }
    }
}
