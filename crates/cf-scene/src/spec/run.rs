//! `run`: how long, how often to write, and in which variants.

use super::Value;
use serde::Deserialize;
use std::collections::BTreeMap;

/// How long to run and what to vary.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "run", deny_unknown_fields)]
pub struct RunSpec {
    /// The end \[s\].
    pub until: f64,
    /// How many frames to write after the first, evenly spaced; 1 unless this or `every` is given.
    pub frames: Option<u32>,
    /// The time between frames \[s\].
    pub every: Option<f64>,
    /// The most time steps to take.
    pub steps: Option<u64>,
    /// The runs of this scene; one run as written if there are none.
    #[serde(default)]
    pub variants: Vec<VariantSpec>,
}

/// One run of a scene that differs from the others.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "variant", deny_unknown_fields)]
pub struct VariantSpec {
    /// What claims, flags and files call it.
    pub name: String,
    /// What pictures and reports call it; the name unless given.
    pub label: Option<String>,
    /// The values it puts in the place of those written.
    #[serde(default)]
    pub set: BTreeMap<String, Value>,
}
