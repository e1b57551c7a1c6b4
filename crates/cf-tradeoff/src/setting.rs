//! What is turned.

use cf_diffusion::{Advection, Splitting};
use std::fmt;

/// How time is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Backward Euler, the paper's.
    PaperBe,
    /// Two implicit stages, second order.
    Sdirk2,
    /// Explicit leapfrog, F_T = 0.
    Kdk,
    /// Characteristic MUSCL, F_T = 0.
    Front,
    /// Transforms, exact in time, at rest.
    Spectral,
    /// Transport by the medium alone, without diffusion.
    Transport,
}

impl Scheme {
    /// All of them.
    pub const ALL: [Scheme; 6] =
        [Scheme::PaperBe, Scheme::Sdirk2, Scheme::Kdk, Scheme::Front, Scheme::Spectral, Scheme::Transport];

    /// Whether it solves linear systems.
    pub fn is_implicit(self) -> bool {
        matches!(self, Scheme::PaperBe | Scheme::Sdirk2)
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Scheme::PaperBe => "PaperBe",
            Scheme::Sdirk2 => "Sdirk2",
            Scheme::Kdk => "Kdk",
            Scheme::Front => "Front",
            Scheme::Spectral => "Spectral",
            Scheme::Transport => "Transport",
        })
    }
}

/// Floating-point numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// Single.
    F32,
    /// Double, with a single-precision preconditioner.
    Mixed,
    /// Double.
    F64,
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Numbers::F32 => "f32",
            Numbers::Mixed => "mixed",
            Numbers::F64 => "f64",
        })
    }
}

/// The accuracy levels of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Fast and first order.
    Draft,
    /// Second order.
    Standard,
    /// Small steps and tight solves.
    Accurate,
}

impl Level {
    /// All of them.
    pub const ALL: [Level; 3] = [Level::Draft, Level::Standard, Level::Accurate];
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Level::Draft => "draft",
            Level::Standard => "standard",
            Level::Accurate => "accurate",
        })
    }
}

/// One choice of every knob but the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The integrator.
    pub scheme: Scheme,
    /// Equal steps to the end; [`Scheme::Kdk`] and [`Scheme::Front`] divide them where they must.
    pub steps: usize,
    /// Precision of state and solver.
    pub numbers: Numbers,
    /// eta of the solves.
    pub tolerance: f64,
    /// How the medium carries.
    pub advection: Advection,
    /// How a fluid is stepped, where one is solved for; its eta_div is the tolerance where nothing diffuses.
    pub flow: Option<cf_fluid::Scheme>,
    /// How transport and diffusion alternate.
    pub splitting: Splitting,
    /// Worker threads.
    pub threads: usize,
    /// The level that chooses just this.
    pub level: Option<Level>,
}

impl Setting {
    /// Double precision, a tolerance of 1e-5, conservative transport, Strang splitting.
    pub fn new(scheme: Scheme, steps: usize, threads: usize) -> Self {
        Self {
            scheme,
            steps: steps.max(1),
            numbers: Numbers::F64,
            tolerance: 1e-5,
            advection: Advection::Muscl,
            flow: None,
            splitting: Splitting::Strang,
            threads,
            level: None,
        }
    }

    /// The integrator and the scheme of the fluid, of those that there are.
    pub fn method(&self) -> String {
        match (self.scheme, self.flow) {
            (Scheme::Transport, Some(flow)) => format!("{flow:?}"),
            (scheme, Some(flow)) => format!("{scheme}, {flow:?}"),
            (scheme, None) => scheme.to_string(),
        }
    }

    /// Whether it solves linear systems.
    pub fn solves(&self) -> bool {
        self.scheme.is_implicit() || self.flow.is_some()
    }
}
