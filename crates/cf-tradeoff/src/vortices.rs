//! P5: Taylor and Green's vortices, carried along by a stream of (1, 0.5) m/s through a periodic box of 2π m.
//!
//! u(x, t) = u_0(x − V t) + V solves Euler's equations u_t + (u·∇)u = −∇p/ρ, ∇·u = 0. Steady vortices would not do: every
//! second-order scheme keeps those.

use crate::error::TradeoffError;
use crate::measured::{Measured, median};
use crate::setting::{Numbers, Scheme, Setting};
use cf_fluid::exact::taylor_green;
use cf_fluid::{FlowSettings, FlowWall, Fluid};
use cf_grid::{Grid, Real, Sides};
use cf_linear::Precision;
use std::f64::consts::TAU;
use std::time::Instant;

/// Simulated time \[s\].
pub const END: f64 = 2.0;
/// The stream \[m/s\].
const STREAM: [f64; 2] = [1.0, 0.5];
/// max|u_a|: of the stream and of the vortices \[m/s\].
const SPEED: f64 = 2.0;

/// Steps for a Courant number max|u_a| dt/h on `n` cells per axis.
pub fn steps(n: usize, courant: f64) -> usize {
    (END * SPEED * n as f64 / (TAU * courant) - 1e-9).ceil() as usize
}

/// `n` cells per axis by the fluid scheme `setting.flow` in `setting.steps` steps, eta_div = `setting.tolerance`; the error
/// is that of the velocity, relative to the vortices without the stream.
///
/// # Errors
/// Settings without a fluid scheme, grids without cells, and what a [`Fluid`] refuses.
pub fn carried(n: usize, setting: &Setting, runs: usize) -> Result<Measured, TradeoffError> {
    let problem = "P5 vortices";
    if setting.flow.is_none() {
        return Err(TradeoffError::Unsuited { scheme: setting.scheme, problem: problem.into() });
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(setting.threads).build()?;
    let once = || match setting.numbers {
        Numbers::F32 => pool.install(|| run::<f32>(n, setting)),
        Numbers::Mixed | Numbers::F64 => pool.install(|| run::<f64>(n, setting)),
    };
    let first = once()?;
    // A run above 1 s warms up and counts.
    let mut times: Vec<f64> = (runs == 0 || first.seconds > 1.0).then_some(first.seconds).into_iter().collect();
    while times.len() < runs {
        times.push(once()?.seconds);
    }
    Ok(Measured {
        problem: problem.into(),
        cells: vec![n; 2],
        setting: Setting { scheme: Scheme::Transport, ..*setting },
        courant: SPEED * END * n as f64 / (TAU * setting.steps as f64),
        error: first.error[0],
        time_error: f64::NAN,
        one: first.error[1],
        worst: first.error[2],
        overshoot: f64::NAN,
        drift: f64::NAN,
        width: f64::NAN,
        ringing: f64::NAN,
        outside: f64::NAN,
        angle: f64::NAN,
        iterations: first.iterations,
        seconds: median(times.iter().copied()),
        runs: times.len(),
    })
}

struct Run {
    /// In the 2-norm, the 1-norm, the largest.
    error: [f64; 3],
    iterations: usize,
    seconds: f64,
}

fn run<T: Real>(n: usize, setting: &Setting) -> Result<Run, TradeoffError> {
    let grid = Grid::<2>::new([n; 2], TAU / n as f64)?;
    let precision = if setting.numbers == Numbers::Mixed { Precision::Single } else { Precision::Full };
    let scheme = setting.flow.unwrap_or_default();
    let settings = FlowSettings { scheme, eta_div: setting.tolerance, precision, ..FlowSettings::default() };
    let start = taylor_green::<T>(&grid, STREAM, 0.0)?;
    let begun = Instant::now();
    let mut fluid = Fluid::<T, 2>::new(&grid, &Sides::<FlowWall<2>, 2>::periodic(), None, settings)?;
    fluid.set_velocity(&start)?;
    let mut iterations = 0;
    for _ in 0..setting.steps {
        iterations += fluid.step(END / setting.steps as f64)?.iterations;
    }
    let seconds = begun.elapsed().as_secs_f64();
    let exact = taylor_green::<f64>(&grid, STREAM, END)?;
    let (mut off, mut whole) = ([0.0; 3], [0.0; 3]);
    for a in 0..2 {
        let (found, wanted) = (fluid.velocity().axis(a), exact.axis(a));
        grid.layout().each_cell(grid.layout().cells_region(), |at| {
            let wanted: f64 = wanted[at.slot()];
            for (sums, x) in [(&mut off, Real::f64(found[at.slot()]) - wanted), (&mut whole, wanted - STREAM[a])] {
                *sums = [sums[0] + x * x, sums[1] + x.abs(), f64::max(sums[2], x.abs())];
            }
        });
    }
    let error = [f64::sqrt(off[0] / whole[0]), off[1] / whole[1], off[2] / whole[2]];
    Ok(Run { error, iterations, seconds })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_fluid::Scheme as Flow;

    fn error(flow: Flow, n: usize) -> f64 {
        let setting =
            Setting { flow: Some(flow), tolerance: 1e-8, ..Setting::new(Scheme::Transport, steps(n, 0.5), 1) };
        carried(n, &setting, 0).unwrap().error
    }

    #[test]
    fn orders_are_those_of_the_schemes() {
        for (flow, least, most) in [
            (Flow::Draft, 0.8, 1.3),
            (Flow::Cnp, 1.9, 3.2),
            (Flow::ReflectionExtrapolated, 2.3, 3.3),
            (Flow::CentralRk4, 1.8, 2.2),
        ] {
            let order = (error(flow, 32) / error(flow, 64)).log2();
            assert!((least..most).contains(&order), "{flow:?}: {order}");
        }
    }

    #[test]
    fn a_fluid_needs_a_scheme() {
        assert!(carried(8, &Setting::new(Scheme::Transport, 1, 1), 0).is_err());
    }
}
