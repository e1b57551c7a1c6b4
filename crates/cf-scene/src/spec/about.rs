//! `about`: what a scene shows, and its sizes.

use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;

/// What a scene shows, and its presets.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "about", deny_unknown_fields, default)]
pub struct About {
    /// One line.
    pub title: String,
    /// The number of the figure or table in the paper, such as `"3"`.
    pub figure: Option<String>,
    /// What to look at, in a paragraph.
    pub text: String,
    /// Sizes by name: for each preset, the values it puts in the place of those written below.
    pub presets: BTreeMap<String, BTreeMap<String, Value>>,
}

/// A value of any type, kept as RON text until it is put in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Value(pub String);

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let raw = Box::<ron::value::RawValue>::deserialize(deserializer)?;
        Ok(Value(raw.get_ron().trim().to_owned()))
    }
}
