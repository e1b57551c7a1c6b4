//! Seconds and estimated passes of the parts of one PCG-multigrid iteration on a closed Poisson box.
//!
//! `cargo run --release -p cf-linear --example timing -- 128`: cells per axis. Passes are in units of 13 GB/s.
use std::time::Instant;

use cf_grid::{Layout, Real, Sides};
use cf_linear::{Helmholtz, Options, Plan, Precision, Solver, Stop};

fn time<T: Real>(
    n: usize,
    threads: usize,
    precision: Precision,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let start = Instant::now();
    let clock = || start.elapsed().as_secs_f64();
    let layout = Layout::new([n; 3])?;
    let operator = Helmholtz::new(&layout, 0.0, 1.0, Sides::all(0.0));
    let options = Options { plan: Some(Plan::Multigrid), precision, ..Default::default() };
    let mut solver = Solver::<T, 3>::new(&operator, options)?;
    let (mut b, mut x, mut z) =
        (vec![T::ZERO; layout.slots()], vec![T::ZERO; layout.slots()], vec![T::ZERO; layout.slots()]);
    layout.par_cells(&mut b, |at| T::of(((at.slot() * 2654435761) % 1000003) as f64 / 1e6 - 0.5));
    let pass = (n * n * n * size_of::<T>()) as f64 / 13e9;
    let mut best = [f64::INFINITY; 3];
    let mut iterations = 0;
    for _ in 0..6 {
        let t0 = clock();
        let short = solver.solve(&b, &mut x, Stop::Relative(1e-2))?.iterations;
        let t1 = clock();
        iterations = solver.solve(&b, &mut x, Stop::Relative(1e-6))?.iterations;
        let t2 = clock();
        solver.precondition(&b, &mut z);
        let t3 = clock();
        solver.apply(&mut x, &mut z);
        let t4 = clock();
        let whole = ((t2 - t1) - (t1 - t0)) / (iterations - short).max(1) as f64;
        best = [best[0].min(whole), best[1].min(t3 - t2), best[2].min(t4 - t3)];
    }
    let [whole, cycle, apply] = best.map(|t| (t, t / pass));
    println!(
        "{n}^3 {} {precision:?}, {threads} thread(s), {iterations} iterations: iteration {:.4} s = {:.1} passes, V-cycle {:.4} s = {:.1}, A x and scaling {:.4} s = {:.1}",
        T::NAME,
        whole.0,
        whole.1,
        cycle.0,
        cycle.1,
        apply.0,
        apply.1
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let n = std::env::args().nth(1).map_or(Ok(128), |a| a.parse())?;
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        pool.install(|| {
            time::<f64>(n, threads, Precision::Full)?;
            time::<f64>(n, threads, Precision::Single)?;
            time::<f32>(n, threads, Precision::Full)
        })?;
    }
    Ok(())
}
