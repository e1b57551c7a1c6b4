//! `claims`: what must come out, as statements that a program can check.

use super::{Axes, Axis};
use serde::Deserialize;

/// One checkable statement about the runs of a scene.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "claim", deny_unknown_fields)]
pub struct Claim {
    /// What reports call it.
    pub name: String,
    /// Who says so.
    pub source: ClaimSource,
    /// What follows where it does not hold.
    pub kind: Kind,
    /// The presets it is checked at; all unless given.
    pub presets: Option<Vec<String>>,
    /// The statement.
    pub statement: Statement,
}

impl Claim {
    /// Whether it is checked at a preset; a scene as written checks all.
    pub fn applies(&self, preset: Option<&str>) -> bool {
        match (&self.presets, preset) {
            (Some(presets), Some(preset)) => presets.iter().any(|name| name == preset),
            _ => true,
        }
    }
}

/// Who makes a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum ClaimSource {
    /// The paper.
    Paper,
    /// We do, beyond the paper.
    Ours,
}

/// What follows where a claim does not hold.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub enum Kind {
    /// The run counts as failed.
    Must,
    /// It is reported.
    Report,
    /// It is reported as known not to hold, for this reason.
    KnownFalse(String),
}

/// Statements. Runs are named by variant; a scene without variants has one run, `main`. Sources are counted from 0.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Statement {
    /// The ridge of a wake in a uniform flow stands at an angle: lateral maximum of each row, sub-cell parabola, line fit.
    ConeAngle {
        /// The run.
        run: String,
        /// Half angle \[degrees\].
        expected: f64,
        /// \[degrees\].
        tolerance: f64,
        /// The apex \[m\].
        source: Axes<f64>,
        /// Rows used, as distances downstream of the apex \[m\].
        rows: (f64, f64),
    },
    /// `|phi|` stays below a fraction of its maximum further upstream than some cells from the edge of a source.
    NoUpstreamTail {
        /// The run.
        run: String,
        /// Which of the model's sources.
        #[serde(default)]
        source: usize,
        /// Distance from the source's upstream edge \[cells\].
        cells: usize,
        /// Of the maximum of `|phi|`.
        fraction: f64,
    },
    /// A quantity at the end lies in a range; an end that is not given is not checked.
    Within {
        /// What is measured.
        quantity: Quantity,
        /// The run.
        run: String,
        /// At least.
        low: Option<f64>,
        /// At most.
        high: Option<f64>,
    },
    /// A quantity at the end strictly rises or falls from run to run.
    Monotone {
        /// What is measured.
        quantity: Quantity,
        /// The runs, in order.
        runs: Vec<String>,
        /// Which way.
        direction: Direction,
    },
    /// Two runs end with the same bits.
    EqualBits {
        /// The two runs.
        runs: (String, String),
    },
    /// The relative L2 distance to a reference run shrinks with a power of a parameter, fitted over the runs.
    Order {
        /// The parameter, read from each run.
        parameter: Knob,
        /// The runs, two or more.
        runs: Vec<String>,
        /// The run they approach.
        reference: String,
        /// The power.
        expected: f64,
        /// Of the power.
        tolerance: f64,
    },
    /// In every run: mass at the end = mass at the start + emitted − left through the walls, relative to the largest of the
    /// sum of |phi| at the end, what was emitted, and what was there at the start.
    MassBudget {
        /// Relative to the largest of the three.
        tolerance: f64,
    },
    /// In every run that solves for a fluid, and after every projection: max|div u| dt is at most this.
    Divergence {
        /// The bound.
        most: f64,
    },
    /// In every run: no step takes more iterations a solve of its diffusion.
    Iterations {
        /// The bound.
        most: usize,
    },
    /// In every run that solves for a fluid: no step takes more iterations a projection.
    FlowIterations {
        /// The bound.
        most: usize,
    },
    /// No run has a pressure: no bytes for a flow, and no projection.
    NoPressure,
    /// A quantity of one run divided by the same of another lies in a range.
    Ratio {
        /// What is measured.
        quantity: Quantity,
        /// Over and under the line.
        runs: (String, String),
        /// At least.
        low: Option<f64>,
        /// At most.
        high: Option<f64>,
    },
    /// At every frame, what is above a share of the largest |phi| lies no further from where it was put in than
    /// ∫ max|u| dt + c t, and some cells. For laws whose signals have a speed.
    Front {
        /// The run.
        run: String,
        /// Of the largest |phi|.
        fraction: f64,
        /// How much further \[cells\].
        cells: usize,
    },
    /// A pulse travels at a speed: from the places, at half time and at the end, of its outermost local maximum above
    /// a twentieth of the largest.
    Speed {
        /// The run.
        run: String,
        /// The one furthest along +x or along −x.
        front: Front,
        /// \[m/s\], along +x.
        expected: f64,
        /// \[m/s\].
        tolerance: f64,
    },
}

impl Statement {
    /// Whether what it measures depends on the machine and on what else it does.
    pub fn of_the_machine(&self) -> bool {
        match self {
            Statement::Within { quantity, .. }
            | Statement::Monotone { quantity, .. }
            | Statement::Ratio { quantity, .. } => quantity.of_the_machine(),
            _ => false,
        }
    }
}

/// Quantities that statements compare, of the field `phi` at the end of a run unless they say otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Quantity {
    /// Sum of phi times cell volume \[P m^D\].
    Mass,
    /// \[P\].
    Maximum,
    /// \[P\].
    Minimum,
    /// \[m\].
    RadiusOfGyration,
    /// The same across an axis: root mean square distance from the line through the centre along it \[m\].
    RadiusAbout(Axis),
    /// Mean of a coordinate, weighted by |phi| \[m\].
    Centre(Axis),
    /// Kinetic energy of a solved fluid, as a share of the work that buoyancy and force have done. At most 1 where nothing
    /// else drives it.
    EnergyPerWork,
    /// Wall seconds that the diffusion of a step takes. A measurement of the machine: it can be reported, not demanded.
    DiffusionSeconds,
    /// The most memory that the program took until the run had ended \[GB\]; the same.
    PeakMemory,
    /// Share of the sum of |phi| further upstream than some cells from the edge of a source.
    UpstreamLeak {
        /// Which of the model's sources.
        #[serde(default)]
        source: usize,
        /// Distance from the source's upstream edge \[cells\].
        cells: usize,
    },
    /// Share of the sum of |phi| outside the region that signals of the source can have reached.
    OutsideCone {
        /// Which of the model's sources.
        #[serde(default)]
        source: usize,
    },
}

impl Quantity {
    /// Whether it depends on the machine and on what else it does.
    pub fn of_the_machine(&self) -> bool {
        matches!(self, Quantity::DiffusionSeconds | Quantity::PeakMemory)
    }
}

/// A parameter read from each run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Knob {
    /// Relaxation time.
    Tau,
    /// Fourier share.
    Fourier,
    /// Cell size.
    CellSize,
    /// Time step, which must then be fixed by `accuracy.dt`.
    TimeStep,
}

/// Which way a quantity goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Direction {
    /// Up.
    Rising,
    /// Down.
    Falling,
}

/// One of the two outermost maxima of a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Front {
    /// Furthest along +x.
    Fore,
    /// Furthest along −x.
    Aft,
}
