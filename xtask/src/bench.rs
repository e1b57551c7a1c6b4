//! `bench`: kernels against the memory bandwidth of this machine, measured in the same run.
//!
//! A pass is one read or write of one array of the grid's size. Time × bandwidth / (bytes of an array) is the number of
//! passes a kernel cost; what it must read and write at least is a fact of the method, so the ratio says how well it runs.

use crate::cli::{Bench, BenchArgs};
use crate::failure::{Exit, Failure};
use crate::{pool, show};
use cf_diffusion::{Diffusion, Integrator, Law, Medium, Settings, Source, State};
use cf_grid::{Grid, Layout, Real, Sides, Wall};
use cf_linear::{Helmholtz, Options, Plan, Solver, Stop};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::time::Instant;

/// Doubles per array of the bandwidth test: far beyond any cache.
const STREAM: usize = 1 << 24;
/// kappa of the solves: well into the range where only multigrid helps.
const KAPPA: f64 = 100.0;

/// One measurement.
struct Measured {
    what: String,
    precision: &'static str,
    seconds: f64,
    /// Solver iterations or explicit sub-steps.
    count: usize,
    /// Bytes of one array, times the count that the passes are given for.
    bytes: f64,
}

impl Measured {
    fn passes(&self, bandwidth: f64) -> f64 {
        self.seconds * bandwidth / self.bytes
    }
}

/// Measures and prints.
pub fn bench(asked: &BenchArgs) -> Result<(), Failure> {
    let threads = pool::threads(None);
    let measure = |n| pool::within(n, stream).map(|rate| (n, rate));
    let before = if threads > 1 { vec![measure(1)?, measure(threads)?] } else { vec![measure(1)?] };
    let wants = |what: Bench| asked.what == what || asked.what == Bench::All;
    let mut rows = Vec::new();
    if wants(Bench::Solver) {
        rows.extend(pool::within(threads, solves)??);
    }
    if wants(Bench::Step) {
        rows.extend(pool::within(threads, steps)??);
    }
    // Again, because other programs may have been busy before: the best of both is the machine's.
    let mut bandwidths = Vec::new();
    for (n, first) in before {
        let rate = first.max(measure(n)?.1);
        say!("stream bandwidth, {n} thread{}: {:.1} GB/s", if n == 1 { "" } else { "s" }, rate / 1e9);
        bandwidths.push((n, rate));
    }
    let bandwidth = bandwidths.iter().map(|(_, rate)| *rate).fold(0.0, f64::max);
    print(&rows, threads, bandwidth);
    if let Some(path) = &asked.json {
        let text = serde_json::to_string_pretty(&document(&bandwidths, &rows, bandwidth))
            .map_err(|e| Failure::io(e.to_string()))?;
        cf_output::write_text(path, &(text + "\n"))?;
        say!("\nwritten to {}", path.display());
    }
    Ok(())
}

/// Bytes per second of a = b + s c, three passes.
fn stream() -> f64 {
    let (mut a, b, c) = (vec![0.0_f64; STREAM], vec![1.0_f64; STREAM], vec![2.0_f64; STREAM]);
    let seconds = best(8, || {
        let rows = a.par_chunks_mut(1 << 14).zip(b.par_chunks(1 << 14)).zip(c.par_chunks(1 << 14));
        rows.for_each(|((a, b), c)| a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 0.5 * c));
        Ok(())
    });
    std::hint::black_box(&a);
    3.0 * (STREAM * size_of::<f64>()) as f64 / seconds.unwrap_or(f64::NAN)
}

/// The shortest of some runs \[s\].
fn best(runs: usize, mut work: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    let mut least = f64::INFINITY;
    for _ in 0..runs {
        let begun = Instant::now();
        work()?;
        least = least.min(begun.elapsed().as_secs_f64());
    }
    Ok(least)
}

fn numerical(error: impl std::fmt::Display) -> Failure {
    Failure::Words(Exit::Numerical, error.to_string())
}

fn solves() -> Result<Vec<Measured>, Failure> {
    Ok(vec![
        solve::<f64, 2>([1024; 2], "f64")?,
        solve::<f32, 2>([1024; 2], "f32")?,
        solve::<f64, 3>([128; 3], "f64")?,
        solve::<f32, 3>([128; 3], "f32")?,
    ])
}

/// A solve to 1e-6 from a zero guess, walls of value 0, a rough right-hand side.
fn solve<T: Real, const D: usize>(cells: [usize; D], precision: &'static str) -> Result<Measured, Failure> {
    let layout = Layout::new(cells).map_err(numerical)?;
    let operator = Helmholtz::new(&layout, 1.0, KAPPA, Sides::all(2.0 * KAPPA));
    let options = Options { plan: Some(Plan::Multigrid), ..Options::default() };
    let mut solver = Solver::<T, D>::new(&operator, options).map_err(numerical)?;
    let mut b = vec![T::ZERO; layout.slots()];
    layout.par_cells(&mut b, |at| T::of(rough(&at.cell)));
    let mut x = vec![T::ZERO; layout.slots()];
    let mut iterations = 0;
    let seconds = best(5, || {
        iterations = solver.solve(&b, &mut x, Stop::Relative(1e-6)).map_err(numerical)?.iterations;
        Ok(())
    })?;
    let bytes = (layout.count() * size_of::<T>() * iterations.max(1)) as f64;
    let what = format!("PCG + V(1,1) solve {}", show::cells(&cells));
    Ok(Measured { what, precision, seconds, count: iterations, bytes })
}

/// A number between -1 and 1 that has nothing to do with its neighbours'.
fn rough(cell: &[usize]) -> f64 {
    let mixed = cell.iter().fold(0x9E37_79B9_7F4A_7C15_u64, |h, &i| {
        let h = (h ^ i as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        h ^ (h >> 29)
    });
    (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn steps() -> Result<Vec<Measured>, Failure> {
    let mut rows = Vec::new();
    for integrator in [Integrator::Kdk, Integrator::Sdirk2] {
        rows.push(step::<f64, 2>([1024; 2], integrator, "f64")?);
        rows.push(step::<f32, 2>([1024; 2], integrator, "f32")?);
        rows.push(step::<f64, 3>([128; 3], integrator, "f64")?);
        rows.push(step::<f32, 3>([128; 3], integrator, "f32")?);
    }
    Ok(rows)
}

/// Diffusion in a still medium between closed walls, F_T = 0, at half a cell per step and wave.
fn step<T: Real, const D: usize>(
    cells: [usize; D],
    integrator: Integrator,
    precision: &'static str,
) -> Result<Measured, Failure> {
    let grid = Grid::<D>::new(cells, 1.0 / cells[0] as f64).map_err(numerical)?;
    let law = Law::cattaneo(0.25, 4.0).map_err(numerical)?;
    let dt = 0.5 * grid.h() / law.speed().unwrap_or(1.0);
    let settings = Settings { integrator, ..Settings::default() };
    let mut state = State::<T, D>::new(&grid, &law);
    grid.layout().par_cells(&mut state.phi, |at| T::of(rough(&at.cell)));
    let mut diffusion = Diffusion::new(&grid, &Sides::all(Wall::CLOSED), None, law, settings).map_err(numerical)?;
    let mut count = 0;
    let seconds = best(5, || {
        let report = diffusion.step(&mut state, &Medium::Still, Source::NONE, dt).map_err(numerical)?;
        count = if integrator == Integrator::Kdk { report.substeps } else { report.iterations };
        Ok(())
    })?;
    let per = if integrator == Integrator::Kdk { count.max(1) } else { 1 };
    let bytes = (grid.layout().count() * size_of::<T>() * per) as f64;
    Ok(Measured { what: format!("{integrator:?} step {}", show::cells(&cells)), precision, seconds, count, bytes })
}

fn print(rows: &[Measured], threads: usize, bandwidth: f64) {
    if rows.is_empty() {
        return;
    }
    let table: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let ms = format!("{:.2}", 1e3 * row.seconds);
            let passes = format!("{:.1}", row.passes(bandwidth));
            vec![row.what.clone(), row.precision.to_owned(), ms, row.count.to_string(), passes]
        })
        .collect();
    say!("\n{threads} threads, the best of five");
    say_part!("{}", show::table(&["kernel", "numbers", "ms", "count", "passes"], &table));
    say!("\nPasses are per iteration for solves, per sub-step for Kdk, per step for Sdirk2 (count: its iterations).");
}

fn document(bandwidths: &[(usize, f64)], rows: &[Measured], bandwidth: f64) -> Value {
    let stream: Vec<Value> =
        bandwidths.iter().map(|(threads, rate)| json!({ "threads": threads, "bytes_per_second": rate })).collect();
    let kernels: Vec<Value> = rows
        .iter()
        .map(|row| {
            json!({
                "kernel": row.what,
                "precision": row.precision,
                "seconds": row.seconds,
                "count": row.count,
                "passes": row.passes(bandwidth),
            })
        })
        .collect();
    json!({ "version": env!("CARGO_PKG_VERSION"), "stream": stream, "kernels": kernels })
}
