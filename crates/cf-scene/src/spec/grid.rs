//! `grid`: the box and its cells.

use super::Axes;
use serde::Deserialize;

/// A box of equal cubes (squares in 2D).
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "grid", deny_unknown_fields)]
pub struct GridSpec {
    /// Cells along each axis; how many numbers there are is the dimension of the scene.
    pub cells: Axes<usize>,
    /// Lengths of the box \[m\].
    pub extent: Axes<f64>,
    /// The low corner \[m\]; zero unless given.
    pub origin: Option<Axes<f64>>,
}
