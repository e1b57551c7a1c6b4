//! One setting on one problem: the time it takes and what is wrong at the end.

use super::problem::Problem;
use super::setting::{Measured, Scheme, Setting};
use crate::bench::{Numbers, numerical, timing};
use crate::failure::Failure;
use crate::pool;
use cf_diffusion::{Diffusion, Front, FrontState, Integrator, Medium, Settings, Source, State};
use cf_grid::{CellField, Real};
use cf_linear::Precision;
use cf_spectral::Spectral;
use nalgebra::SVector;

/// Timed runs after one that warms up.
const RUNS: usize = 3;
/// A first run longer than this needs no warming up and counts.
const LONG: f64 = 3.0;

/// Measures; also gives phi at the end.
pub fn measure<const D: usize>(problem: &Problem<D>, setting: &Setting) -> Result<(Measured, Vec<f64>), Failure> {
    pool::within(setting.threads, || {
        let once = || match setting.numbers {
            Numbers::F32 => run::<f32, D>(problem, setting),
            Numbers::F64 | Numbers::Mixed => run::<f64, D>(problem, setting),
        };
        let first = once()?;
        let mut times: Vec<f64> = (first.seconds > LONG).then_some(first.seconds).into_iter().collect();
        while times.len() < RUNS {
            times.push(once()?.seconds);
        }
        let seconds = timing::median(times.iter().copied());
        Ok((judge(problem, setting, &first, seconds, times.len()), first.phi))
    })?
}

struct Run {
    phi: Vec<f64>,
    iterations: usize,
    seconds: f64,
}

fn run<T: Real, const D: usize>(problem: &Problem<D>, setting: &Setting) -> Result<Run, Failure> {
    let Problem { grid, sides, law, .. } = problem;
    let dt = problem.end / setting.steps as f64;
    let fill = |phi: &mut [T]| phi.iter_mut().zip(problem.start.iter()).for_each(|(p, &s)| *p = T::of(s));
    let integrator = match setting.scheme {
        Scheme::Front => {
            let mut state = FrontState::<T, D>::new(grid);
            fill(&mut state.phi);
            let (done, seconds) = timing::timed(|| {
                let front = Front::<T, D>::new(grid, sides, *law, SVector::zeros())?;
                let courant = front.speed() * dt / grid.h();
                let mut front = front.with_courant((courant * (1.0 + 1e-9)).min(1.0))?;
                (0..setting.steps).try_for_each(|_| front.step(&mut state, Source::NONE, dt).map(|_| ()))
            });
            done.map_err(numerical)?;
            return Ok(Run { phi: widened(&state.phi), iterations: 0, seconds });
        }
        Scheme::Spectral => {
            let mut state = State::<T, D>::new(grid, law);
            fill(&mut state.phi);
            let (done, seconds) = timing::timed(|| {
                let mut spectral = Spectral::new(grid, sides, *law)?;
                let mut step = || spectral.step(&mut state, &Medium::Still, Source::NONE, dt);
                (0..setting.steps).try_for_each(|_| step().map(|_| ()))
            });
            done.map_err(numerical)?;
            return Ok(Run { phi: widened(&state.phi), iterations: 0, seconds });
        }
        Scheme::PaperBe => Integrator::PaperBe,
        Scheme::Sdirk2 => Integrator::Sdirk2,
        Scheme::Kdk => Integrator::Kdk,
    };
    let precision = if setting.numbers == Numbers::Mixed { Precision::Single } else { Precision::Full };
    let settings = Settings { integrator, tolerance: setting.tolerance, precision, ..Settings::default() };
    let mut state = State::<T, D>::new(grid, law);
    fill(&mut state.phi);
    let mut iterations = 0;
    let (done, seconds) = timing::timed(|| {
        let mut diffusion = Diffusion::<T, D>::new(grid, sides, None, *law, settings)?;
        (0..setting.steps).try_for_each(|_| {
            let report = diffusion.step(&mut state, &Medium::Still, Source::NONE, dt)?;
            iterations += report.iterations;
            Ok::<_, cf_diffusion::StepError>(())
        })
    });
    done.map_err(numerical)?;
    Ok(Run { phi: widened(&state.phi), iterations, seconds })
}

fn widened<T: Real>(phi: &CellField<T>) -> Vec<f64> {
    phi.iter().map(|p| p.f64()).collect()
}

/// Sums over cells for the norms of a difference.
#[derive(Default)]
struct Norms {
    one: f64,
    two: f64,
    most: f64,
}

impl Norms {
    fn of<const D: usize>(problem: &Problem<D>, value: impl Fn(usize) -> f64) -> Norms {
        let mut norms = Norms::default();
        let layout = problem.grid.layout();
        layout.each_cell(layout.cells_region(), |at| {
            let v = value(at.slot()).abs();
            norms.one += v;
            norms.two += v * v;
            norms.most = norms.most.max(v);
        });
        norms
    }
}

fn judge<const D: usize>(problem: &Problem<D>, setting: &Setting, run: &Run, seconds: f64, runs: usize) -> Measured {
    let Problem { grid, law, exact, semi, start, .. } = problem;
    let (phi, layout) = (&run.phi, grid.layout());
    let off = Norms::of(problem, |i| phi[i] - exact[i]);
    let late = Norms::of(problem, |i| phi[i] - semi[i]);
    let (whole, discrete) = (Norms::of(problem, |i| exact[i]), Norms::of(problem, |i| semi[i]));
    let top = |values: &[f64]| layout.range(values).1;
    let (width, ringing) = problem.jump.map_or((f64::NAN, f64::NAN), |jump| shape(problem, phi, jump));
    let speed = law.k().sqrt() / law.tau().sqrt();
    Measured {
        problem: problem.name.clone(),
        cells: grid.cells().to_vec(),
        setting: *setting,
        courant: speed * problem.end / setting.steps as f64 / grid.h(),
        error: (off.two / whole.two).sqrt(),
        time_error: (late.two / discrete.two).sqrt(),
        one: off.one / whole.one,
        worst: off.most / whole.most,
        overshoot: (top(phi) - top(exact)) / top(exact),
        drift: (layout.sum(phi) - layout.sum(start)).abs() / layout.sum_abs(start),
        width,
        ringing,
        iterations: run.iterations,
        seconds,
        runs,
    }
}

/// Cells from 90 % to 10 % of the jump at the front on the right, and the largest rise over the jump.
fn shape<const D: usize>(problem: &Problem<D>, phi: &[f64], jump: f64) -> (f64, f64) {
    let layout = problem.grid.layout();
    let mut line = Vec::new();
    layout.each_cell(layout.cells_region(), |at| line.push(phi[at.slot()]));
    let (mut lowest, mut rise) = (f64::INFINITY, 0.0f64);
    for &value in &line {
        lowest = lowest.min(value);
        rise = rise.max(value - lowest);
    }
    // Where phi first exceeds a level, coming from the right, between cells.
    let crossing = |level: f64| {
        let i = (1..line.len()).rev().find(|&i| line[i] < level && line[i - 1] >= level)?;
        Some(i as f64 - (level - line[i]) / (line[i - 1] - line[i]))
    };
    let width = crossing(0.1 * jump).zip(crossing(0.9 * jump)).map_or(f64::NAN, |(foot, head)| foot - head);
    (width, rise / jump)
}

/// The relative 2-norm of the error in time alone, from a single run.
pub fn error_in_time<const D: usize>(problem: &Problem<D>, setting: &Setting) -> Result<f64, Failure> {
    let run = pool::within(setting.threads, || run::<f64, D>(problem, setting))??;
    Ok(judge(problem, setting, &run, run.seconds, 1).time_error)
}
