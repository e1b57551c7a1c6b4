//! `output`: what to write.

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
    /// The fields in the files; a field that a run does not have is left out.
    pub fields: Vec<Field>,
}

impl Default for Output {
    fn default() -> Self {
        Output { vtk: true, table: true, pictures: Pictures::Auto, fields: vec![Field::Phi] }
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
