//! `sides`: what happens at the walls of the box.

use serde::Deserialize;

/// The walls along each axis; closed unless given.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "sides", deny_unknown_fields, default)]
pub struct SidesSpec {
    /// The walls at low and high x.
    pub x: AxisSides,
    /// The walls at low and high y.
    pub y: Option<AxisSides>,
    /// The walls at low and high z.
    pub z: Option<AxisSides>,
}

/// The two ends of an axis.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum AxisSides {
    /// What leaves at one end enters at the other.
    Periodic,
    /// Two walls.
    Walls {
        /// The wall at the low end.
        #[serde(default)]
        low: Wall,
        /// The wall at the high end.
        #[serde(default)]
        high: Wall,
    },
}

impl Default for AxisSides {
    fn default() -> Self {
        AxisSides::Walls { low: Wall::Closed, high: Wall::Closed }
    }
}

/// One wall. Outward is positive for every flux.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Wall {
    /// Nothing passes.
    #[default]
    Closed,
    /// A given total flux leaves \[P m/s\].
    Flux(f64),
    /// `phi` is held at this value on the wall \[P\].
    Value(f64),
    /// Waves leave without echo: flux = speed · (phi − far). The medium may leave here too.
    Absorbing {
        /// The value far outside \[P\].
        #[serde(default)]
        far: f64,
        /// The speed of the waves to absorb \[m/s\]; that of the law unless given. A law without waves needs one.
        #[serde(default)]
        speed: Option<f64>,
    },
    /// The medium passes, diffusion does not.
    Open {
        /// The value of `phi` that comes in with the medium \[P\].
        #[serde(default)]
        inflow: f64,
    },
}
