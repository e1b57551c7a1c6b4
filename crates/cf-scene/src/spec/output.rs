//! `output`: what to write.

use super::Axis;
use serde::Deserialize;

/// What to write besides the summary and the report.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "output", deny_unknown_fields, default)]
pub struct Output {
    /// Files for ParaView.
    pub vtk: bool,
    /// A table of totals and extremes, one row a frame.
    pub table: bool,
    /// Pictures of `phi`.
    pub pictures: Pictures,
    /// Pictures of `phi` as a cloud, in three dimensions.
    pub volume: Option<VolumeSpec>,
    /// The fields in the files; a field that a run does not have is left out.
    pub fields: Vec<Field>,
}

impl Default for Output {
    fn default() -> Self {
        Output { vtk: true, table: true, pictures: Pictures::Auto, volume: None, fields: vec![Field::Phi] }
    }
}

/// Pictures and their colour range \[P\].
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename = "pictures", deny_unknown_fields)]
pub enum Pictures {
    /// None.
    Off,
    /// The range of the data over all frames.
    Auto,
    /// From `low` to `high`.
    Linear {
        /// The first colour.
        low: f64,
        /// The last colour.
        high: f64,
    },
    /// From `low` to `high` by the logarithm; what is not above `low` has the first colour.
    Log {
        /// The first colour, above zero.
        low: f64,
        /// The last colour.
        high: f64,
    },
}

/// How `phi` looks as a cloud.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename = "volume", deny_unknown_fields)]
pub struct VolumeSpec {
    /// What it is made of.
    pub look: Cloud,
    /// `phi` of the thickest cloud \[P\]; what is more looks the same. Unless given each run has its own, at which half of
    /// what is seen of it lies behind a cloud of optical depth 2 at most; the pictures tell it.
    pub high: Option<f64>,
    /// `phi` that cannot be seen \[P\].
    #[serde(default)]
    pub low: f64,
    /// Show the whole box, and not only the part of it where there ever is something to see.
    #[serde(default)]
    pub whole: bool,
    /// The axis that points up in the picture; y unless given.
    pub up: Option<Axis>,
    /// Where the eye is around the box, and above its middle \[degrees\].
    pub eye: Option<(f64, f64)>,
}

/// What a cloud is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Cloud {
    /// Blue-black ink in front of a light wall.
    Ink,
    /// White smoke in front of a dark one.
    Smoke,
    /// Something that glows.
    Fire,
}

/// A field that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Field {
    /// The diffusing quantity \[P\].
    #[serde(rename = "phi")]
    Phi,
    /// The flux with memory \[P m/s\].
    #[serde(rename = "q_C")]
    SlowFlux,
    /// The velocity of the medium \[m/s\].
    #[serde(rename = "u")]
    Velocity,
    /// Pressure over density of a solved fluid \[m²/s²\], where its scheme keeps it.
    #[serde(rename = "p")]
    Pressure,
}
