//! The scene as it is written: one type per section, in one fixed order.
//!
//! These types say what may be written and no more; what must hold between the numbers is checked in `check`. Lengths
//! are in metres, times in seconds, diffusivities in m²/s; `phi` carries whatever unit P the scene thinks in.

mod about;
mod accuracy;
mod axes;
mod claims;
mod fluid;
mod grid;
mod model;
mod output;
mod run;
mod shape;
mod sides;

pub use about::{About, Value};
pub use accuracy::{AccuracySpec, Advection, FlowScheme, Integrator, Level, Precision, Solver, Splitting, StepRule};
pub use axes::Axes;
pub use claims::{Claim, ClaimSource, Direction, Front, Kind, Knob, Quantity, Statement};
pub use fluid::{BuoyancySpec, FlowEnds, FlowSides, FlowWall, Grip, JetSpec};
pub use grid::GridSpec;
pub use model::{Deposit, Flow, LawSpec, MaskSpec, Medium, ModelSpec, Pulse, SingleFieldForm, SourceSpec};
pub use output::{Cloud, Field, Output, Pictures, VolumeSpec};
pub use run::{RunSpec, VariantSpec};
pub use shape::{Axis, Shape};
pub use sides::{AxisSides, SidesSpec, Wall};

use serde::Deserialize;

/// The sections of a scene, in the order in which they must stand.
pub const SECTIONS: [&str; 8] = ["about", "grid", "sides", "model", "accuracy", "run", "output", "claims"];

/// A whole scene as written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "scene", deny_unknown_fields)]
pub struct SceneSpec {
    /// What the scene shows.
    #[serde(default)]
    pub about: About,
    /// The box and its cells.
    pub grid: GridSpec,
    /// What happens at the walls.
    #[serde(default)]
    pub sides: SidesSpec,
    /// The physics.
    pub model: ModelSpec,
    /// How accurately to compute.
    #[serde(default)]
    pub accuracy: AccuracySpec,
    /// How long, and in which variants.
    pub run: RunSpec,
    /// What to write.
    #[serde(default)]
    pub output: Output,
    /// What must come out.
    #[serde(default)]
    pub claims: Vec<Claim>,
}
