//! Diffusion at a finite speed: the Cattaneo-Fourier (C-F) law, its steps and its exact solutions.
//!
//! Fourier's law lets phi spread infinitely fast. The C-F law splits the flux into a slow part with memory and a fast
//! Fourier part,
//!
//! ```text
//! phi_t + div(u phi) + div q_C - div(k_F grad phi) = W
//! tau (q_C,t + div(q_C ⊗ u)) + q_C = - k_C grad phi          k_F = F_T k,  k_C = (1 - F_T) k
//! ```
//!
//! with phi \[P\] per cell, q_C \[P m/s\] per face, k \[m²/s\], tau \[s\], u \[m/s\], W \[P/s\]. For F_T = 0 nothing outruns
//! c = sqrt(k_C/tau); in a medium of speed |u| the number H_c = |u|/c decides between spreading everywhere and a cone of
//! half-angle asin(1/H_c) ([`Regime`]). Fourier (tau = 0 or F_T = 1), Cattaneo (F_T = 0) and Jeffreys (in between) are
//! values of one [`Law`], never different solvers.
//!
//! [`Diffusion`] steps a [`State`]: [`Integrator::PaperBe`] is the paper's scheme, [`Integrator::Sdirk2`] its
//! second-order successor at two solves, [`Integrator::Kdk`] explicit for F_T = 0; [`Adaptive`] lets a tolerance choose
//! the steps of the second. Every update is in flux form, so mass
//! is exact to rounding at any solver tolerance; walls report what leaves. A [`Medium`] carries phi and q_C
//! ([`Advection`]). [`exact`] holds the solutions all of it is tested against.
//!
//! ```
//! use cf_diffusion::{Diffusion, Law, Medium, Settings, Source, State};
//! use cf_grid::{Grid, Sides, Wall};
//!
//! let grid = Grid::<2>::new([64, 64], 1.0 / 64.0)?;
//! let law = Law::cattaneo(0.25, 4.0)?; // c = sqrt(k/tau) = 0.25 m/s
//! let mut state = State::<f64, 2>::new(&grid, &law);
//! state.phi[grid.layout().slot([32, 32])] = 1.0;
//! let mut diffusion = Diffusion::new(&grid, &Sides::all(Wall::CLOSED), None, law, Settings::default())?;
//! for _ in 0..10 {
//!     diffusion.step(&mut state, &Medium::Still, Source::NONE, 0.05)?;
//! }
//! assert!((state.mass(&grid) - grid.cell_volume()).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod advect;
pub mod energy;
pub mod exact;
pub mod front;

mod adaptive;
mod balance;
mod coefficients;
mod embedded;
mod error;
mod explicit;
mod implicit;
mod law;
mod limiter;
pub mod medium;
mod regime;
mod source;
mod state;
mod step_error;
mod stepper;
mod sweeps;
#[cfg(any(test, feature = "verify"))]
pub mod verify;
mod walls;

pub use adaptive::{Adaptive, Controller};
pub use advect::{AdvectError, Advection, Advector, Transported};
pub use coefficients::{Coefficients, Kicks, kdk_limit};
pub use error::LawError;
pub use front::{Front, FrontError, FrontState};
pub use law::Law;
pub use medium::{Medium, MediumError};
pub use regime::{CRITICAL_TOLERANCE, Regime, half_angle, hc};
pub use source::{Rate, Source};
pub use state::State;
pub use step_error::StepError;
pub use stepper::{Diffusion, Integrator, Observer, Phase, Settings, Splitting, StepReport};
