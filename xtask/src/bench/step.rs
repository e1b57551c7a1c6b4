//! Whole diffusion steps.

use super::problem::rough;
use super::stream::Bandwidth;
use super::{numerical, timing};
use crate::failure::Failure;
use crate::show;
use cf_diffusion::{Diffusion, Integrator, Law, Medium, Settings, Source, State};
use cf_grid::{Grid, Real, Sides, Wall};
use serde_json::{Value, json};

/// One measurement.
pub struct Step {
    what: String,
    precision: &'static str,
    seconds: f64,
    /// Explicit sub-steps or solver iterations.
    count: usize,
    /// Bytes of one array, times the count that the passes are given for.
    bytes: f64,
}

/// Both integrators in both dimensions and precisions, with the threads of the pool.
pub fn steps() -> Result<Vec<Step>, Failure> {
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
) -> Result<Step, Failure> {
    let grid = Grid::<D>::new(cells, 1.0 / cells[0] as f64).map_err(numerical)?;
    let law = Law::cattaneo(0.25, 4.0).map_err(numerical)?;
    let dt = 0.5 * grid.h() / law.speed().unwrap_or(1.0);
    let settings = Settings { integrator, ..Settings::default() };
    let mut state = State::<T, D>::new(&grid, &law);
    grid.layout().par_cells(&mut state.phi, |at| T::of(rough(&at.cell)));
    let mut diffusion = Diffusion::new(&grid, &Sides::all(Wall::CLOSED), None, law, settings).map_err(numerical)?;
    let mut count = 0;
    let seconds = timing::best(5, || {
        let report = diffusion.step(&mut state, &Medium::Still, Source::NONE, dt).map_err(numerical)?;
        count = if integrator == Integrator::Kdk { report.substeps } else { report.iterations };
        Ok(())
    })?;
    let per = if integrator == Integrator::Kdk { count.max(1) } else { 1 };
    let bytes = (grid.layout().count() * size_of::<T>() * per) as f64;
    Ok(Step { what: format!("{integrator:?} step {}", show::cells(&cells)), precision, seconds, count, bytes })
}

impl Step {
    fn passes(&self, bandwidth: f64) -> f64 {
        self.seconds * bandwidth / self.bytes
    }
}

/// A table of them.
pub fn print(rows: &[Step], threads: usize, bandwidth: &Bandwidth) {
    let table: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let ms = format!("{:.2}", 1e3 * row.seconds);
            let passes = format!("{:.1}", row.passes(bandwidth.with(threads)));
            vec![row.what.clone(), row.precision.to_owned(), ms, row.count.to_string(), passes]
        })
        .collect();
    say!("\nSteps, {threads} threads, the best of five");
    say_part!("{}", show::table(&["kernel", "numbers", "ms", "count", "passes"], &table));
    say!("\nPasses are per sub-step for Kdk (the count), per step for Sdirk2 (count: its iterations).");
}

/// For `--json`.
pub fn document(rows: &[Step], threads: usize, bandwidth: &Bandwidth) -> Vec<Value> {
    rows.iter()
        .map(|row| {
            json!({
                "kernel": row.what,
                "precision": row.precision,
                "threads": threads,
                "seconds": row.seconds,
                "count": row.count,
                "passes": row.passes(bandwidth.with(threads)),
            })
        })
        .collect()
}
