"""The telegraph equation in other programs: error against wall seconds.

    tau phi_tt + phi_t = k lap phi      in a closed unit box, phi = exp(-(r/0.05)^2), phi_t = 0 at the start

with k = 0.05 m^2/s and tau = 0.02 s until 0.2 s. Prints one JSON list; progress goes to standard error. A program that is
not installed is left out.
"""

import argparse
import json
import sys
import time

import numpy as np
import scipy.fft

K, TAU, END, WIDTH = 0.05, 0.02, 0.2, 0.05


def start(n):
    x = (np.arange(n) + 0.5) / n - 0.5
    return np.exp(-(x[:, None] ** 2 + x[None, :] ** 2) / WIDTH**2)


def exact(n):
    """Cosines are the modes of a closed box; K^2 = (pi m)^2 is the eigenvalue of the continuous ones."""
    wave = (np.pi * np.arange(n)) ** 2
    a = 0.5 / TAU
    omega = np.sqrt((K / TAU * (wave[:, None] + wave[None, :]) - a * a).astype(complex))
    mode = np.exp(-a * END) * (np.cos(omega * END) + a * END * np.sinc(omega * END / np.pi))
    return scipy.fft.idctn(scipy.fft.dctn(start(n), type=2) * mode.real, type=2)


def report(rows, program, version, n, steps, phi, seconds, setup=0.0):
    reference = exact(n)
    error = float(np.linalg.norm(phi - reference) / np.linalg.norm(reference))
    rows.append(
        dict(program=program, version=version, cells=n, steps=steps, error=error, seconds=seconds, setup_seconds=setup)
    )
    print(f"{program}: {n}^2, {steps} steps: {error:.1e}, {seconds:.3f} s", file=sys.stderr, flush=True)


def numpy_leapfrog(rows, n, steps, runs=5):
    """phi on cells, q on faces, kick, drift, kick with exact relaxation; kicks of neighbouring steps merged; no allocation
    in the loop."""
    h, dt = 1.0 / n, END / steps
    half, full = np.exp(-0.5 * dt / TAU), np.exp(-dt / TAU)

    def solve():
        phi = start(n)
        qx, qy = np.zeros((n + 1, n)), np.zeros((n, n + 1))
        gx, gy = np.empty((n - 1, n)), np.empty((n, n - 1))
        div, more = np.empty((n, n)), np.empty((n, n))
        inner_x, inner_y = qx[1:-1], qy[:, 1:-1]

        def kick(keep):
            gain = (1.0 - keep) * K / h
            np.subtract(phi[1:], phi[:-1], out=gx)
            np.subtract(phi[:, 1:], phi[:, :-1], out=gy)
            for q, g in ((inner_x, gx), (inner_y, gy)):
                np.multiply(q, keep, out=q)
                np.multiply(g, gain, out=g)
                np.subtract(q, g, out=q)

        begun = time.perf_counter()
        kick(half)
        for step in range(steps):
            np.subtract(qx[1:], qx[:-1], out=div)
            np.subtract(qy[:, 1:], qy[:, :-1], out=more)
            np.add(div, more, out=div)
            np.multiply(div, dt / h, out=div)
            np.subtract(phi, div, out=phi)
            kick(full if step + 1 < steps else half)
        return phi, time.perf_counter() - begun

    phi, _ = solve()
    seconds = sorted(solve()[1] for _ in range(runs))[runs // 2]
    report(rows, "NumPy leapfrog", np.__version__, n, steps, phi, seconds)


def py_pde(rows, n, steps):
    """py-pde's Runge-Kutta with numba. The first call compiles; the second is timed."""
    import pde

    grid = pde.CartesianGrid([[0, 1], [0, 1]], n)
    equation = pde.PDE(
        {"u": "v", "v": f"({K} * laplace(u) - v) / {TAU}"}, bc={"derivative": 0}
    )
    state = pde.FieldCollection([pde.ScalarField(grid, start(n)), pde.ScalarField(grid, 0.0)], labels=["u", "v"])
    solver = pde.RungeKuttaSolver(equation, backend="numba")
    stepper = solver.make_stepper(state, dt=END / steps)
    begun = time.perf_counter()
    stepper(state.copy(), 0.0, 2 * END / steps)
    setup = time.perf_counter() - begun
    times = []
    for _ in range(3):
        now = state.copy()
        begun = time.perf_counter()
        result = stepper(now, 0.0, END)
        times.append(time.perf_counter() - begun)
    # Some versions of the stepper work in place and give the time alone.
    phi = now[0].data if not hasattr(result, "data") else result[0].data
    report(rows, "py-pde", pde.__version__, n, steps, phi, sorted(times)[1], setup)


def fipy(rows, n, steps):
    """FiPy, implicit Euler with phi_t eliminated, its conjugate gradients."""
    import fipy as fp

    begun = time.perf_counter()
    mesh = fp.Grid2D(nx=n, ny=n, dx=1.0 / n, dy=1.0 / n)
    dt = END / steps
    phi = fp.CellVariable(mesh=mesh, value=start(n).ravel(), hasOld=True)
    before = fp.CellVariable(mesh=mesh, value=start(n).ravel())
    equation = fp.TransientTerm(coeff=TAU / dt + 1.0) == fp.DiffusionTerm(coeff=K) + (TAU / dt) * (phi.old - before) / dt
    solver = fp.LinearPCGSolver(tolerance=1e-8, iterations=2000)
    setup = time.perf_counter() - begun
    begun = time.perf_counter()
    for _ in range(steps):
        kept = phi.value.copy()
        phi.updateOld()
        equation.solve(var=phi, dt=dt, solver=solver)
        before.setValue(kept)
    seconds = time.perf_counter() - begun
    report(rows, "FiPy", fp.__version__, n, steps, np.array(phi.value).reshape(n, n), seconds, setup)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=512)
    parser.add_argument("--reference", help="file for the reference as doubles, x contiguous")
    parser.add_argument("--quick", action="store_true", help="fewer steps of the slow ones")
    parser.add_argument("--only", default="", help="only the program whose name contains this")
    asked = parser.parse_args()
    n = asked.cells
    if asked.reference:
        exact(n).astype("<f8").tofile(asked.reference)
    # Beyond dt = h sqrt(tau / 2k) an explicit step is unstable.
    limit = int(np.ceil(END / (np.sqrt(0.5 * TAU / K) / n)))
    leaps = ((n // 4, limit // 4 + 8), (n // 2, limit // 2 + 8), (n, limit + 8), (n, 300 * n // 512))
    cases = [(numpy_leapfrog, m, s) for m, s in leaps]
    cases += [(py_pde, m, s) for m, s in ((n // 2, 100 * n // 512), (n, 200 * n // 512))]
    cases += [(fipy, n, s) for s in ((20,) if asked.quick else (20, 80))]
    rows = []
    for solve, m, steps in cases:
        if asked.only not in solve.__name__:
            continue
        try:
            solve(rows, m, steps)
        except ImportError as missing:
            print(f"left out: {missing}", file=sys.stderr, flush=True)
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
