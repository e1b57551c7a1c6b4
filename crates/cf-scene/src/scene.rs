//! A scene after validation: plain numbers, every default filled in, nothing left to decide but the physics.

use crate::error::SceneError;
use crate::solid::MaskFile;
use crate::spec::{
    Advection, Axes, AxisSides, Deposit, Flow, FlowScheme, FlowWall, Grip, Integrator, JetSpec, Level, Medium, Output,
    Precision, Pulse, Shape, SingleFieldForm, Solver, SourceSpec, Splitting,
};

/// One run, ready to be built.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The run's name, used in files and claims.
    pub run: String,
    /// What pictures and reports call it.
    pub label: String,
    /// The box and its cells.
    pub grid: Grid,
    /// The walls, one entry per axis.
    pub sides: Axes<AxisSides>,
    /// The physics.
    pub model: Model,
    /// The numerics.
    pub numerics: Numerics,
    /// When to stop and when to write.
    pub schedule: Schedule,
    /// What to write.
    pub output: Output,
    /// What was written without effect, or decided otherwise than one may think.
    pub warnings: Vec<SceneError>,
}

impl Scene {
    /// A bound of the speed of the medium in the box \[m/s\]; of a solved fluid, the largest speed that it is given.
    pub fn medium_speed(&self) -> f64 {
        let grid = &self.grid;
        let medium = match &self.model {
            Model::Diffusion(model) => &model.medium,
            Model::SingleField(model) => return model.velocity.abs(),
        };
        match medium {
            Medium::Still => 0.0,
            Medium::Uniform(u) => u.iter().map(|component| component * component).sum::<f64>().sqrt(),
            Medium::Analytic(Flow::Rotation { center, rate }) => {
                let reach = |axis: usize| {
                    let middle = center.get(axis).copied().unwrap_or(0.0);
                    (middle - grid.origin[axis]).abs().max((grid.origin[axis] + grid.extent[axis] - middle).abs())
                };
                rate.abs() * reach(0).hypot(reach(1))
            }
            Medium::Analytic(Flow::Deformation { .. }) => {
                let longest = grid.extent.iter().copied().fold(0.0, f64::max);
                if grid.dimension() == 3 { 2.0 * longest } else { longest }
            }
            Medium::Solved { .. } => self.fluid().map_or(0.0, Fluid::given_speed),
        }
    }

    /// The fluid, where the medium is one that is solved for.
    pub fn fluid(&self) -> Option<&Fluid> {
        match &self.model {
            Model::Diffusion(model) => model.fluid.as_ref(),
            Model::SingleField(_) => None,
        }
    }

    /// Whether the medium moves, or may.
    pub fn moves(&self) -> bool {
        self.fluid().is_some() || self.medium_speed() > 0.0
    }
}

/// A box of equal cubes. Lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Cells along each axis.
    pub cells: Axes<usize>,
    /// The edge of a cell.
    pub spacing: f64,
    /// The low corner.
    pub origin: Axes<f64>,
    /// The lengths of the box.
    pub extent: Axes<f64>,
}

impl Grid {
    /// 1, 2 or 3.
    pub fn dimension(&self) -> usize {
        self.cells.len()
    }

    /// Whether all cells lie along x.
    pub fn is_line(&self) -> bool {
        self.cells.iter().skip(1).all(|n| *n == 1)
    }
}

/// The kinds of models.
#[allow(clippy::large_enum_variant)] // A scene has one of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Model {
    /// Cattaneo-Fourier diffusion in a medium, in two or three dimensions.
    Diffusion(Diffusion),
    /// A pulse in a one-dimensional flow.
    SingleField(SingleField),
}

/// Cattaneo-Fourier diffusion of one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Diffusion {
    /// The law.
    pub law: Law,
    /// How the medium moves.
    pub medium: Medium,
    /// What moves it, where it is solved for.
    pub fluid: Option<Fluid>,
    /// `phi` at the start, summed.
    pub initial: Vec<Deposit>,
    /// What is added while it runs.
    pub sources: Vec<SourceSpec>,
    /// Solid shapes.
    pub obstacles: Vec<Shape>,
    /// Solid cells from a file.
    pub mask: Option<MaskFile>,
}

/// A fluid that is solved for.
#[derive(Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Velocity at the start \[m/s\].
    pub velocity: Axes<f64>,
    /// Its walls, low and high along each axis; closed along a periodic one, where nothing meets them.
    pub walls: Vec<[FlowWall; 2]>,
    /// A force everywhere \[m/s²\].
    pub force: Axes<f64>,
    /// A force where `phi` is.
    pub buoyancy: Option<Buoyancy>,
    /// Where it is given a velocity.
    pub jets: Vec<JetSpec>,
}

/// Buoyancy b = strength · (phi − reference) · up.
#[derive(Clone, Debug, PartialEq)]
pub struct Buoyancy {
    /// \[m/s² per P\]
    pub strength: f64,
    /// \[P\]
    pub reference: f64,
    /// A unit vector.
    pub up: Axes<f64>,
}

impl Fluid {
    /// Whether jets hold faces.
    pub(crate) fn holds(&self) -> bool {
        self.jets.iter().any(|jet| jet.how == Grip::Hold)
    }

    /// The largest speed at the start, of a jet or of an inflow \[m/s\].
    pub fn given_speed(&self) -> f64 {
        let speed = |velocity: &Axes<f64>| velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let walls = self.walls.iter().flatten().map(|wall| match wall {
            FlowWall::Inflow(velocity) => speed(velocity),
            FlowWall::Closed | FlowWall::Open => 0.0,
        });
        let jets = self.jets.iter().map(|jet| speed(&jet.velocity));
        walls.chain(jets).fold(speed(&self.velocity), f64::max)
    }
}

/// A pulse by a chosen form of the equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleField {
    /// Which equations.
    pub form: SingleFieldForm,
    /// The law; its Fourier share is zero.
    pub law: Law,
    /// Velocity of the medium \[m/s\].
    pub velocity: f64,
    /// `phi` at the start.
    pub pulse: Pulse,
}

/// The numbers of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Total diffusivity \[m²/s\], at least 0.
    pub k: f64,
    /// Relaxation time \[s\], at least 0.
    pub tau: f64,
    /// The share F_T of `k` without memory, from 0 to 1.
    pub fourier: f64,
}

impl Law {
    /// Whether a flux with memory exists.
    pub fn has_memory(&self) -> bool {
        self.tau > 0.0 && self.fourier < 1.0
    }

    /// Wave speed √((1 − fourier)·k/tau) \[m/s\]; `None` without memory.
    pub fn speed(&self) -> Option<f64> {
        self.has_memory().then(|| ((1.0 - self.fourier) * self.k / self.tau).sqrt())
    }
}

/// The numerics, every knob decided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// The level that chose the knobs which the scene does not set.
    pub level: Level,
    /// How diffusion is stepped; `None` leaves it to [`Pace`](crate::Pace), which knows the time step.
    pub integrator: Option<Integrator>,
    /// How `phi` and its flux are carried.
    pub advection: Advection,
    /// How diffusion and advection alternate.
    pub splitting: Splitting,
    /// The time step.
    pub step: TimeStep,
    /// Relative residual at which a solve stops.
    pub tolerance: f64,
    /// Floating-point numbers.
    pub precision: Precision,
    /// How linear systems are solved.
    pub solver: Solver,
    /// How a solved fluid is stepped.
    pub flow: FlowScheme,
    /// The largest max|div u| dt that a projection of a solved fluid leaves.
    pub eta_div: f64,
}

/// How the time step is chosen. Frames and the end may shorten single steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// \[s\]
    Fixed(f64),
    /// This times h/(|u| + c); a law without memory counts with c = 0.
    Cfl(f64),
    /// As `Cfl`, but at most 1/64 of the run: what a level chooses.
    Bounded(f64),
    /// As long as this relative error of a step allows; only for Sdirk2.
    Adaptive(f64),
    /// As long as a solved fluid moves by at most this many cells, which is found out at each step.
    Courant(f64),
    /// The step in which transport is a shift by whole cells, exact, where there is such a step; otherwise as `Bounded`.
    Shift(f64),
}

/// When to stop and when to write. Times in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// The end.
    pub until: f64,
    /// Frames after the first; frame `i` is at `i·interval`, the last at the end.
    pub frames: u32,
    /// Time between frames; the last interval may be shorter.
    pub interval: f64,
    /// The most time steps to take.
    pub steps: Option<u64>,
}

impl Schedule {
    /// The time of a frame; frame 0 is the start.
    pub fn frame_time(&self, frame: u32) -> f64 {
        if frame >= self.frames { self.until } else { (f64::from(frame) * self.interval).min(self.until) }
    }
}
