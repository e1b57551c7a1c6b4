//! `model.medium: Solved(…)`: what moves a fluid that is solved for.

use super::{Axes, Shape};
use serde::Deserialize;

/// The flow's walls; those that are not given follow from the walls of `phi`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "walls", deny_unknown_fields, default)]
pub struct FlowSides {
    /// At low and high x.
    pub x: FlowEnds,
    /// At low and high y.
    pub y: FlowEnds,
    /// At low and high z.
    pub z: FlowEnds,
}

/// The flow's walls at the two ends of an axis.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "ends", deny_unknown_fields, default)]
pub struct FlowEnds {
    /// At the low end.
    pub low: Option<FlowWall>,
    /// At the high end.
    pub high: Option<FlowWall>,
}

/// One wall as the flow meets it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum FlowWall {
    /// Nothing passes, the fluid slips along it.
    Closed,
    /// Pressure 0, fluid at rest outside: what flows out leaves freely.
    Open,
    /// The fluid comes in (or goes out) with this velocity \[m/s\].
    Inflow(Axes<f64>),
}

/// Buoyancy b = strength · (phi − reference) · up.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "buoyancy", deny_unknown_fields)]
pub struct BuoyancySpec {
    /// \[m/s² per P\]; negative where what is more than the reference sinks.
    pub strength: f64,
    /// `phi` of the fluid that neither rises nor sinks \[P\].
    #[serde(default)]
    pub reference: f64,
    /// Against gravity, of any length; along y unless given.
    pub up: Option<Axes<f64>>,
}

/// A shape in which the fluid is given a velocity.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "jet", deny_unknown_fields)]
pub struct JetSpec {
    /// Where; a `Box` or a `Ball`.
    pub shape: Shape,
    /// \[m/s\]
    pub velocity: Axes<f64>,
    /// How firmly.
    #[serde(default)]
    pub how: Grip,
    /// When it begins \[s\].
    #[serde(default)]
    pub from: f64,
    /// When it ends \[s\]; never unless given.
    pub until: Option<f64>,
}

/// How firmly a jet moves the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum Grip {
    /// The faces inside hold the velocity, as walls that blow.
    #[default]
    Hold,
    /// The velocity is set before each projection, which may change it.
    Set,
}
