//! P4: a flow that deforms whatever it carries, and brings it back.
//!
//! LeVeque's vortex in a closed unit box, ψ = sin²(πx) sin²(πy) cos(πt/2)/π, until t = 2 s, when every particle is where
//! it began. Without diffusion the start is the solution. With it there is none: three grids, each twice as fine as the one
//! before, with steps in proportion to the cells, tell the order and the error by themselves.

use crate::error::TradeoffError;
use crate::measured::{Measured, median};
use crate::problem::field;
use crate::setting::{Scheme, Setting};
use cf_diffusion::medium::stream_function;
use cf_diffusion::{Advector, Diffusion, Integrator, Law, Medium, Settings, Source, State};
use cf_grid::{CellField, FaceField, Grid, Sides, Wall};
use std::f64::consts::PI;
use std::fmt;
use std::time::Instant;

/// From the start until all is back \[s\].
pub const PERIOD: f64 = 2.0;

/// What is carried, around (0.5, 0.75) m with a radius of 0.15 m.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// (1 + cos(πr/R))/2.
    Bell,
    /// A disc of 1 with a slot of 0.05 m from its lower end up to 0.85 m.
    SlottedDisc,
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Shape::Bell => "bell",
            Shape::SlottedDisc => "slotted disc",
        })
    }
}

impl Shape {
    fn value(self, x: f64, y: f64) -> f64 {
        let r = (x - 0.5).hypot(y - 0.75) / 0.15;
        match self {
            _ if r >= 1.0 => 0.0,
            Shape::Bell => 0.5 * (1.0 + (PI * r).cos()),
            Shape::SlottedDisc => f64::from((x - 0.5).abs() >= 0.025 || y >= 0.85),
        }
    }
}

struct Flow {
    grid: Grid<2>,
    sides: Sides<Wall, 2>,
    most: FaceField<f64, 2>,
}

impl Flow {
    fn new(n: usize) -> Result<Self, TradeoffError> {
        let grid = Grid::<2>::new([n; 2], 1.0 / n as f64)?;
        let most = stream_function(&grid, |x| ((PI * x[0]).sin() * (PI * x[1]).sin()).powi(2) / PI)?;
        Ok(Self { grid, sides: Sides::all(Wall::CLOSED), most })
    }

    fn start(&self, shape: Shape) -> CellField<f64> {
        field(&self.grid, |cell| {
            let x = self.grid.centre(cell);
            shape.value(x[0], x[1])
        })
    }

    /// The velocity in the middle of a step.
    fn at(&self, t: f64) -> Medium<f64, 2> {
        let mut u = self.most.clone();
        let now = (PI * t / PERIOD).cos();
        u.axes_mut().into_iter().flatten().for_each(|u| *u *= now);
        Medium::Field(u)
    }
}

/// Transport alone, there and back in `setting.steps` steps; the wall time is that of the transport.
pub fn round_trip(shape: Shape, n: usize, setting: &Setting, runs: usize) -> Result<Measured, TradeoffError> {
    let flow = Flow::new(n)?;
    let (grid, start) = (flow.grid, flow.start(shape));
    let dt = PERIOD / setting.steps as f64;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(setting.threads).build()?;
    let once = || {
        let mut phi = start.clone();
        let mut advector = Advector::<f64, 2>::new(&grid, &flow.sides, None, setting.advection);
        let mut seconds = 0.0;
        for step in 0..setting.steps {
            let medium = flow.at((step as f64 + 0.5) * dt);
            let begun = Instant::now();
            advector.advect(&mut phi, None, &medium, dt)?;
            seconds += begun.elapsed().as_secs_f64();
        }
        Ok::<_, TradeoffError>((phi, seconds))
    };
    let (phi, first) = pool.install(once)?;
    let mut times: Vec<f64> = (runs == 0).then_some(first).into_iter().collect();
    while times.len() < runs {
        times.push(pool.install(once)?.1);
    }
    let layout = grid.layout();
    let mut sums = [0.0f64; 6];
    layout.each_cell(layout.cells_region(), |at| {
        let (now, then) = (phi[at.slot()], start[at.slot()]);
        let off = (now - then).abs();
        sums[0] += off;
        sums[1] += then.abs();
        sums[2] += off * off;
        sums[3] += then * then;
        sums[4] = sums[4].max(off);
        sums[5] = sums[5].max(then);
    });
    Ok(Measured {
        problem: format!("P4 {shape}"),
        cells: grid.cells().to_vec(),
        setting: Setting { scheme: Scheme::Transport, ..*setting },
        courant: dt / grid.h(),
        error: (sums[2] / sums[3]).sqrt(),
        time_error: f64::NAN,
        one: sums[0] / sums[1],
        worst: sums[4] / sums[5],
        overshoot: layout.range(&phi).1 - sums[5],
        drift: (layout.sum(&phi) - layout.sum(&start)) / layout.sum(&start),
        width: f64::NAN,
        ringing: f64::NAN,
        outside: f64::NAN,
        angle: f64::NAN,
        iterations: 0,
        seconds: median(times.iter().copied()),
        runs: times.len(),
    })
}

/// Three grids against each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The law in words.
    pub law: String,
    /// The knobs on the coarsest grid.
    pub setting: Setting,
    /// Cells per axis of the coarsest grid.
    pub cells: usize,
    /// Of the coarsest grid to the next, and of that to the finest: 2-norms relative to the finest of the two.
    pub differences: [f64; 2],
    /// log2 of their ratio.
    pub order: f64,
    /// What the finest is still off by, if the order holds on.
    pub error: f64,
    /// Wall time on the finest grid \[s\], one run.
    pub seconds: f64,
}

/// The bell in the deforming flow under `law`, on `n`, 2n and 4n cells per axis with 1, 2 and 4 times `setting.steps`.
pub fn self_convergence(n: usize, law: Law, setting: &Setting) -> Result<Convergence, TradeoffError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(setting.threads).build()?;
    let solve =
        |finer: usize| pool.install(|| carried(finer * n, law, &Setting { steps: finer * setting.steps, ..*setting }));
    let (coarse, middle, (fine, seconds)) = (solve(1)?.0, solve(2)?.0, solve(4)?);
    let differences = [distance(n, &coarse, &middle), distance(2 * n, &middle, &fine)];
    let order = (differences[0] / differences[1]).log2();
    Ok(Convergence {
        law: format!("F_T = {}", law.fourier_share()),
        setting: *setting,
        cells: n,
        differences,
        order,
        error: differences[1] / (order.exp2() - 1.0),
        seconds,
    })
}

/// φ at the end by cell, x contiguous, and the wall time.
fn carried(n: usize, law: Law, setting: &Setting) -> Result<(Vec<f64>, f64), TradeoffError> {
    let flow = Flow::new(n)?;
    let dt = PERIOD / setting.steps as f64;
    let integrator = match setting.scheme {
        Scheme::PaperBe => Integrator::PaperBe,
        Scheme::Sdirk2 => Integrator::Sdirk2,
        Scheme::Kdk => Integrator::Kdk,
        scheme => return Err(TradeoffError::Unsuited { scheme, problem: "P4 with diffusion".into() }),
    };
    let Setting { tolerance, advection, splitting, .. } = *setting;
    let settings = Settings { integrator, tolerance, advection, splitting, ..Settings::default() };
    let mut state = State::<f64, 2>::new(&flow.grid, &law);
    state.phi.copy_from_slice(&flow.start(Shape::Bell));
    let mut diffusion = Diffusion::<f64, 2>::new(&flow.grid, &flow.sides, None, law, settings)?;
    let mut seconds = 0.0;
    for step in 0..setting.steps {
        let medium = flow.at((step as f64 + 0.5) * dt);
        let begun = Instant::now();
        diffusion.step(&mut state, &medium, Source::NONE, dt)?;
        seconds += begun.elapsed().as_secs_f64();
    }
    let layout = flow.grid.layout();
    let mut phi = Vec::with_capacity(layout.count());
    layout.each_cell(layout.cells_region(), |at| phi.push(state.phi[at.slot()]));
    Ok((phi, seconds))
}

/// 2-norm of the difference of a square of `n` by `n` cells to the means of one twice as fine, relative to those.
fn distance(n: usize, coarse: &[f64], fine: &[f64]) -> f64 {
    let (mut off, mut whole) = (0.0, 0.0);
    for (place, value) in coarse.iter().enumerate() {
        let corner = 4 * n * (place / n) + 2 * (place % n);
        let mean = 0.25 * (fine[corner] + fine[corner + 1] + fine[corner + 2 * n] + fine[corner + 2 * n + 1]);
        off += (value - mean).powi(2);
        whole += mean * mean;
    }
    (off / whole).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_diffusion::Advection;

    #[test]
    fn what_is_carried_comes_back_the_better_the_finer() {
        let setting = |steps| Setting { advection: Advection::Muscl, ..Setting::new(Scheme::Transport, steps, 1) };
        let [coarse, fine] = [32, 64].map(|n| round_trip(Shape::Bell, n, &setting(4 * n), 0).unwrap());
        assert!(fine.one < 0.6 * coarse.one, "{} {}", coarse.one, fine.one);
        assert!(fine.drift.abs() < 1e-13);
    }

    #[test]
    fn means_of_a_finer_grid_are_compared() {
        let fine: Vec<f64> = (0..16).map(f64::from).collect();
        let coarse = [2.5, 4.5, 10.5, 12.5];
        assert_eq!(distance(2, &coarse, &fine), 0.0);
    }
}
