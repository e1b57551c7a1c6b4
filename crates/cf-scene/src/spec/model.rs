//! `model`: the physics. One variant per kind of model.

use super::{Axes, BuoyancySpec, FlowSides, JetSpec, Shape};
use serde::Deserialize;

/// The kinds of models.
#[allow(clippy::large_enum_variant)] // A scene has one of them.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "model", deny_unknown_fields)]
pub enum ModelSpec {
    /// Cattaneo-Fourier diffusion of one quantity `phi` in a medium that is given, or a fluid that is solved for.
    Diffusion {
        /// How `phi` spreads.
        law: LawSpec,
        /// How the medium moves.
        #[serde(default)]
        medium: Medium,
        /// `phi` at the start: the sum of these, zero elsewhere.
        #[serde(default)]
        initial: Vec<Deposit>,
        /// What is added while it runs.
        #[serde(default)]
        sources: Vec<SourceSpec>,
        /// Solid shapes, closed to `phi`.
        #[serde(default)]
        obstacles: Vec<Shape>,
        /// Solid cells from a file, besides the shapes.
        mask: Option<MaskSpec>,
    },
    /// A pulse in a uniform one-dimensional flow, by a chosen form of the equations (the paper's Appendix A).
    SingleField {
        /// Which equations.
        form: SingleFieldForm,
        /// Total diffusivity \[m²/s\].
        k: f64,
        /// Relaxation time \[s\], greater than zero.
        tau: f64,
        /// Velocity of the medium \[m/s\].
        velocity: f64,
        /// `phi` at the start.
        pulse: Pulse,
    },
}

/// How `phi` spreads. Any two of `k`, `tau` and a speed; the speed as `c`, or relative to the medium as `hc` or `cone_angle`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "law", deny_unknown_fields, default)]
pub struct LawSpec {
    /// Total diffusivity \[m²/s\].
    pub k: Option<f64>,
    /// Relaxation time \[s\]; 0 is Fourier's law.
    pub tau: Option<f64>,
    /// Wave speed √((1 − fourier)·k/tau) \[m/s\].
    pub c: Option<f64>,
    /// Speed of the medium over wave speed.
    pub hc: Option<f64>,
    /// Half angle of the wake \[degrees\]: sin(angle) = 1/hc.
    pub cone_angle: Option<f64>,
    /// The share F_T of `k` that spreads at once, without memory; from 0 (the default) to 1.
    pub fourier: f64,
}

/// How the medium moves.
#[allow(clippy::large_enum_variant)] // A scene has one of them.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "medium", deny_unknown_fields)]
pub enum Medium {
    /// Not at all.
    #[default]
    Still,
    /// With one velocity everywhere \[m/s\].
    Uniform(Axes<f64>),
    /// By a formula.
    Analytic(Flow),
    /// As an incompressible fluid without viscosity, u_t + (u·grad) u = −(1/rho) grad p + b, div u = 0.
    Solved {
        /// Its velocity at the start \[m/s\], the same everywhere; at rest unless given.
        velocity: Option<Axes<f64>>,
        /// Its walls. Unless given they are closed where nothing passes for `phi` (`Closed`, `Flux`), open elsewhere.
        #[serde(default)]
        walls: FlowSides,
        /// A force everywhere \[m/s²\].
        force: Option<Axes<f64>>,
        /// A force where `phi` is.
        buoyancy: Option<BuoyancySpec>,
        /// Where it is given a velocity.
        #[serde(default)]
        jets: Vec<JetSpec>,
    },
}

/// A file of solid cells.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "mask", deny_unknown_fields)]
pub struct MaskSpec {
    /// One byte a cell, x fastest, 0 for fluid; the path is relative to the scene's file.
    pub file: String,
    /// Its cells along each axis, those of the grid unless given. On another grid the nearest cell counts.
    pub cells: Option<Axes<usize>>,
}

/// Divergence-free flows given by a formula.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "flow", deny_unknown_fields)]
pub enum Flow {
    /// Rigid rotation in the x-y plane, counter-clockwise for a positive rate.
    Rotation {
        /// The axis of rotation \[m\]; the z coordinate, if any, is not used.
        center: Axes<f64>,
        /// Angular velocity \[rad/s\].
        rate: f64,
    },
    /// The reversing deformation flow that fills the box, ends where it began, and passes no wall: LeVeque's vortex in
    /// box lengths, (sin²(πx) sin(2πy), −sin²(πy) sin(2πx))·cos(πt/period) in two dimensions, with the factors
    /// (2 sin(2πz), sin(2πz), sin²(πz)) and a third component like the second in three.
    Deformation {
        /// Time from start to full return \[s\].
        period: f64,
    },
}

/// A shape with a value: its weight times the value is added.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "initial", deny_unknown_fields)]
pub struct Deposit {
    /// Where.
    pub shape: Shape,
    /// How much \[P\].
    pub value: f64,
}

/// A shape that emits, or in which `phi` is held.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename = "source", deny_unknown_fields)]
pub struct SourceSpec {
    /// Where.
    pub shape: Shape,
    /// How much is added \[P/s\].
    pub rate: Option<f64>,
    /// Instead of a rate, the value at which `phi` is held in cells whose centre is inside, set before each step \[P\].
    pub value: Option<f64>,
    /// When it begins \[s\].
    #[serde(default)]
    pub from: f64,
    /// When it ends \[s\]; never unless given.
    pub until: Option<f64>,
}

/// Forms of the equations compared in Appendix A; D = d/dt + V d/dx. All start with zero flux, so D phi = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum SingleFieldForm {
    /// As printed, one of the two time derivatives replaced: tau·D(phi_t) + D phi = k·phi_xx.
    Printed,
    /// Both replaced: tau·D(D phi) + D phi = k·phi_xx.
    Material,
    /// `phi` and its flux, each carried with the medium.
    TwoField,
}

/// A Gaussian of unit height.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename = "pulse", deny_unknown_fields)]
pub struct Pulse {
    /// Its middle \[m\].
    pub center: f64,
    /// Its standard deviation \[m\].
    pub width: f64,
}
