//! The fluid: transport, a projection, whole steps of its schemes.

use super::problem::rough;
use super::stream::Bandwidth;
use super::{numerical, timing};
use crate::failure::Failure;
use crate::{pool, show};
use cf_diffusion::MediumError;
use cf_diffusion::medium::{stream_function, vector_potential};
use cf_fluid::{FlowSettings, FlowWall, Fluid, Interpolation, Projection, Scheme, Transport};
use cf_grid::{CellField, FaceField, Grid, Real, Sides};
use cf_linear::Precision;
use nalgebra::SVector;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};

/// How often each is measured; the best counts.
const RUNS: usize = 5;
/// max|u_a| dt/h: what fluid moves in a step.
const COURANT: f64 = 0.7;

/// One measurement.
pub struct Row {
    what: String,
    precision: &'static str,
    threads: usize,
    cells: usize,
    seconds: f64,
    /// Of the solver, where there is one.
    iterations: Option<usize>,
}

/// Cells per axis.
pub struct Sizes {
    /// Of transport, 3D.
    pub transport: &'static [usize],
    /// Of projections and steps in 2D and in 3D.
    pub steps: [usize; 2],
}

/// What is measured unless it is a test.
pub const SIZES: Sizes = Sizes { transport: &[128, 256], steps: [512, 128] };

/// Transport with one thread and with all, the rest with all; what was measured before `stop` became true.
pub fn measure(sizes: &Sizes, threads: usize, stop: &AtomicBool) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for &n in sizes.transport {
        for threads in [1, threads].into_iter().take(if threads > 1 { 2 } else { 1 }) {
            for walls in [Walls::Periodic, Walls::Closed] {
                for how in [Interpolation::Linear, Interpolation::Cubic] {
                    if stop.load(Ordering::Relaxed) {
                        return Ok(rows);
                    }
                    complain!("transport, {how:?}, {walls:?}, {}, {threads} threads", show::cells(&[n; 3]));
                    rows.push(pool::within(threads, || transport(n, walls, how, threads))??);
                }
            }
        }
    }
    let [flat, deep] = sizes.steps;
    pool::within(threads, || {
        solved::<f32, 2>([flat; 2], plane, threads, stop, &mut rows)?;
        solved::<f64, 2>([flat; 2], plane, threads, stop, &mut rows)?;
        solved::<f32, 3>([deep; 3], space, threads, stop, &mut rows)?;
        solved::<f64, 3>([deep; 3], space, threads, stop, &mut rows)
    })??;
    Ok(rows)
}

#[derive(Clone, Copy, Debug)]
enum Walls {
    Periodic,
    Closed,
}

/// Vortices on a box of 2 pi that no wall hinders, of two sizes, so that they change.
fn plane<T: Real>(grid: &Grid<2>) -> Result<FaceField<T, 2>, MediumError> {
    stream_function(grid, |x| x[0].sin() * x[1].sin() + 0.3 * (2.0 * x[0]).sin() * (3.0 * x[1]).sin())
}

/// The same in space.
fn space<T: Real>(grid: &Grid<3>) -> Result<FaceField<T, 3>, MediumError> {
    vector_potential(grid, |x| {
        let [[sx, cx], [sy, cy], [sz, cz]] = [0, 1, 2].map(|a| [x[a].sin(), x[a].cos()]);
        SVector::from([sy * cy * sz * cx, 0.0, sx * sy * cz])
    })
}

fn grid<const D: usize>(cells: [usize; D]) -> Result<Grid<D>, Failure> {
    Grid::new(cells, TAU / cells[0] as f64).map_err(numerical)
}

/// A scalar and three components in one sweep, f32.
fn transport(n: usize, walls: Walls, how: Interpolation, threads: usize) -> Result<Row, Failure> {
    let grid = grid([n; 3])?;
    let sides = match walls {
        Walls::Periodic => Sides::periodic(),
        Walls::Closed => Sides::all(FlowWall::Closed),
    };
    let mut by = space::<f32>(&grid).map_err(numerical)?;
    let mut u = by.clone();
    let mut phi = CellField::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| rough(&at.cell) as f32);
    let mut transport = Transport::new(&grid, &sides, None, |_, _| 0.0);
    let seconds = timing::best(RUNS, || {
        transport.all(&mut phi, &mut u, &mut by, COURANT * grid.h(), how);
        Ok(())
    })?;
    let what = format!("transport of phi and u, {how:?}, {walls:?}, {}", show::cells(&[n; 3]));
    Ok(Row { what, precision: f32::NAME, threads, cells: grid.layout().count(), seconds, iterations: None })
}

/// A projection and a step of every scheme between closed walls.
fn solved<T: Real, const D: usize>(
    cells: [usize; D],
    flow: fn(&Grid<D>) -> Result<FaceField<T, D>, MediumError>,
    threads: usize,
    stop: &AtomicBool,
    rows: &mut Vec<Row>,
) -> Result<(), Failure> {
    let grid = grid(cells)?;
    let flow = flow(&grid).map_err(numerical)?;
    let mut keep = |what: String, (seconds, iterations): (f64, usize)| {
        let (what, iterations) = (format!("{what}, {}", show::cells(&cells)), Some(iterations));
        rows.push(Row { what, precision: T::NAME, threads, cells: grid.layout().count(), seconds, iterations });
    };
    if !stop.load(Ordering::Relaxed) {
        complain!("projection, {}, {}", show::cells(&cells), T::NAME);
        keep("projection of a rough velocity".into(), projection(&grid, &flow)?);
    }
    for scheme in [Scheme::Draft, Scheme::Cnp, Scheme::ReflectionExtrapolated] {
        if !stop.load(Ordering::Relaxed) {
            complain!("{scheme:?} step, {}, {}", show::cells(&cells), T::NAME);
            keep(format!("{scheme:?} step"), step(&grid, &flow, scheme)?);
        }
    }
    Ok(())
}

/// The flow with a number of its own on every face, to max|div u| dt = 1e-4 from no guess: seconds and iterations.
fn projection<T: Real, const D: usize>(grid: &Grid<D>, flow: &FaceField<T, D>) -> Result<(f64, usize), Failure> {
    let sides = Sides::all(FlowWall::Closed);
    let mut projection = Projection::<T, D>::new(grid, &sides, None, Precision::Full).map_err(numerical)?;
    let mut start = flow.clone();
    for axis in 0..D {
        let noise = |slot, u: &mut T| *u += T::of(rough(&[axis, slot]));
        start.axis_mut(axis).iter_mut().enumerate().for_each(|(slot, u)| noise(slot, u));
    }
    let (mut least, mut iterations) = (f64::INFINITY, 0);
    for _ in 0..RUNS {
        let (mut u, mut s) = (start.clone(), CellField::new(grid.layout()));
        let (done, seconds) = timing::timed(|| projection.project(&mut u, &mut s, COURANT * grid.h(), 1e-4));
        iterations = done.map_err(numerical)?.iterations;
        least = least.min(seconds);
    }
    Ok((least, iterations))
}

/// A step after the first two: seconds of the best, iterations of the last.
fn step<T: Real, const D: usize>(
    grid: &Grid<D>,
    flow: &FaceField<T, D>,
    scheme: Scheme,
) -> Result<(f64, usize), Failure> {
    let settings = FlowSettings { scheme, ..FlowSettings::default() };
    let mut fluid = Fluid::<T, D>::new(grid, &Sides::all(FlowWall::Closed), None, settings).map_err(numerical)?;
    fluid.set_velocity(flow).map_err(numerical)?;
    let dt = COURANT * grid.h();
    let mut iterations = 0;
    let mut step = || {
        iterations = fluid.step(dt).map_err(numerical)?.iterations;
        Ok(())
    };
    step()?;
    step()?;
    let seconds = timing::best(RUNS, step)?;
    Ok((seconds, iterations))
}

impl Row {
    fn rate(&self) -> f64 {
        self.cells as f64 / self.seconds
    }

    fn passes(&self, bandwidth: &Bandwidth) -> f64 {
        let bytes = if self.precision == f32::NAME { size_of::<f32>() } else { size_of::<f64>() };
        self.seconds * bandwidth.with(self.threads) / (self.cells * bytes) as f64
    }
}

/// A table of them.
pub fn print(rows: &[Row], bandwidth: &Bandwidth) {
    let table: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                row.what.clone(),
                row.precision.to_owned(),
                row.threads.to_string(),
                format!("{:.2}", 1e3 * row.seconds),
                row.iterations.map_or_else(|| "-".into(), |count| count.to_string()),
                format!("{:.0}", row.passes(bandwidth)),
                format!("{:.1}", 1e-6 * row.rate()),
                format!("{:.1}", 1e-6 * row.rate() / row.threads as f64),
            ]
        })
        .collect();
    say!("\nFlow at a Courant number of {COURANT}, the best of {RUNS}");
    let heads = ["kernel", "numbers", "threads", "ms", "iterations", "passes", "M cells/s", "per thread"];
    say_part!("{}", show::table(&heads, &table));
}

/// For `--json`.
pub fn document(rows: &[Row], bandwidth: &Bandwidth) -> Vec<Value> {
    rows.iter()
        .map(|row| {
            json!({
                "kernel": row.what,
                "precision": row.precision,
                "threads": row.threads,
                "seconds": row.seconds,
                "count": row.iterations,
                "passes": row.passes(bandwidth),
                "cells_per_second": row.rate(),
                "cells_per_second_and_thread": row.rate() / row.threads as f64,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Sizes = Sizes { transport: &[8], steps: [16, 8] };

    #[test]
    fn everything_is_measured_once() {
        let rows = measure(&SMALL, 2, &AtomicBool::new(false)).unwrap();
        assert_eq!(rows.len(), 2 * 2 * 2 + 4 * 4);
        let bandwidth = Bandwidth::measure(&[1, 2]).unwrap();
        for row in document(&rows, &bandwidth) {
            let number = |key: &str| row[key].as_f64().unwrap_or(f64::NAN);
            assert!(["seconds", "passes", "cells_per_second"].iter().all(|key| number(key) > 0.0), "{row:#}");
            let whole = number("cells_per_second_and_thread") * number("threads");
            assert!((whole / number("cells_per_second") - 1.0).abs() < 1e-12, "{row:#}");
            let carried = row["kernel"].as_str().unwrap().starts_with("transport");
            assert_eq!(carried, row["count"].is_null(), "{row:#}");
            assert!(carried || number("count") >= 1.0, "{row:#}");
        }
        let mut names: Vec<String> = rows.iter().map(|r| format!("{} {} {}", r.what, r.precision, r.threads)).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), rows.len());
    }

    #[test]
    fn a_stop_ends_it() {
        assert!(measure(&SMALL, 1, &AtomicBool::new(true)).unwrap().is_empty());
    }
}
