//! `accuracy`: a level, and knobs that override what the level chooses.

use serde::Deserialize;

/// A level and its overrides. `accuracy: Draft` is short for `accuracy: (level: Draft)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(rename = "accuracy", deny_unknown_fields, default)]
pub struct AccuracySpec {
    /// The level; unless given, `Draft` with the preset "draft" and `Standard` otherwise.
    pub level: Option<Level>,
    /// How diffusion is stepped.
    pub integrator: Option<Integrator>,
    /// How `phi` and its flux are carried.
    pub advection: Option<Advection>,
    /// How diffusion and advection alternate.
    pub splitting: Option<Splitting>,
    /// A fixed time step \[s\].
    pub dt: Option<f64>,
    /// The time step as a multiple of h/(|u| + c), or where a fluid is solved for, of h/max|u| as it is at each step.
    pub cfl: Option<f64>,
    /// How the time step is found, instead of `dt` and `cfl`.
    pub step: Option<StepRule>,
    /// Relative residual at which a solve stops. Mass is exact at any; the energy may grow by a share of the order of its
    /// square in a step.
    pub tolerance: Option<f64>,
    /// Floating-point numbers.
    pub precision: Option<Precision>,
    /// How linear systems are solved.
    pub solver: Option<Solver>,
    /// How a solved fluid is stepped.
    pub flow: Option<FlowScheme>,
    /// What a solved fluid may gain or lose of its volume in a step: every projection ends with max|div u| dt at most this.
    pub eta_div: Option<f64>,
}

/// Documented sets of knobs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
pub enum Level {
    /// Long steps, loose solves; of first order where the medium moves.
    Draft,
    /// Second order.
    #[default]
    Standard,
    /// Small steps and tight solves.
    Accurate,
    /// Whatever reaches this relative error: the fewest cells, of those of the scene halved again and again, with as often the
    /// step of `Standard`. The error is that of the cell means of `phi` at the end, in the mean square, against ever finer runs.
    Target(f64),
}

/// A rule for the time step.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub enum StepRule {
    /// As long as the error of a step of Sdirk2, relative to the largest norm so far, is at most `tolerance`.
    Adaptive {
        /// In (0, 1).
        tolerance: f64,
    },
}

/// How diffusion is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Integrator {
    /// The paper's backward Euler: one solve a step, first order.
    PaperBe,
    /// Two solves a step, second order.
    Sdirk2,
    /// Explicit kick-drift-kick, second order; only for fourier = 0 and tau > 0.
    Kdk,
    /// Along the characteristics, upwind, for sharp fronts: explicit, second order; only for fourier = 0, tau and k above 0,
    /// a medium that is still or uniform, and no obstacles. It carries `phi` too, so that `advection` and `splitting` do
    /// not matter.
    Characteristic,
}

/// How `phi` and its flux are carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Advection {
    /// Conservative, second order.
    Muscl,
    /// Semi-Lagrangian, cubic.
    Cubic,
    /// Semi-Lagrangian, linear.
    Linear,
}

/// How diffusion and advection alternate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Splitting {
    /// Half, whole, half: second order.
    Strang,
    /// One after the other, in the paper's order: first order.
    Lie,
}

/// Floating-point numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single.
    F32,
    /// Double, with a single-precision preconditioner.
    Mixed,
    /// Double.
    F64,
}

impl Precision {
    /// Of the V-cycles.
    pub(crate) fn cycles(self) -> cf_linear::Precision {
        match self {
            Precision::Mixed => cf_linear::Precision::Single,
            Precision::F32 | Precision::F64 => cf_linear::Precision::Full,
        }
    }
}

/// How a solved fluid is stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum FlowScheme {
    /// `Cnp` in steps of up to one cell, `ReflectionExtrapolated` in longer ones.
    Auto,
    /// Second order with one projection, half of the pressure gradient carried along.
    Cnp,
    /// Second order with two projections, for long steps.
    ReflectionExtrapolated,
    /// The paper's: advection, then a projection; first order.
    Draft,
    /// Central differences that keep the energy, and RK4 with four projections.
    CentralRk4,
}

/// How linear systems are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Solver {
    /// As the plan decides.
    Auto,
    /// Conjugate gradients with a multigrid cycle.
    Multigrid,
    /// Chebyshev iteration.
    Chebyshev,
}
