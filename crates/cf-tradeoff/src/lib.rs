//! What accuracy costs: problems of the Cattaneo-Fourier law with known solutions, and every integrator on them, timed.
//!
//! ```text
//! φ_t + div(u φ) + div q_C − k_F ∇²φ = W          φ [P], q_C [P m/s], k [m²/s], τ [s], u [m/s], W [P/s]
//! τ (q_C,t + div(q_C ⊗ u)) + q_C = −k_C ∇φ        k_F = F_T k,  k_C = (1 − F_T) k,  c = √(k_C/τ)
//! ```
//!
//! | problem | solution |
//! |---|---|
//! | [`Problem::gaussian`] P1: a Gaussian spreads in a closed box | transforms with the eigenvalues K² of continuous waves |
//! | [`Problem::line`] P2: a jump on a line | the telegraph equation's closed form with Bessel functions |
//! | [`Problem::disc`] P2: a disc with a sharp edge | its Green's function, integrated ([`disc`]) |
//! | [`Problem::wake`] P3: a steady Gaussian source in a uniform flow | one quotient per wave ([`cf_spectral::wake`]) |
//! | [`deformation`] P4: a flow that deforms and comes back | the start; with diffusion, the next finer grids |
//! | [`vortices`] P5: vortices in a stream, Euler's equations alone | the vortices, moved along |
//! | [`Problem::telegraph`]: the Gaussian that other programs are timed on | as P1 |
//!
//! [`Problem::measure`] runs one [`Setting`] and gives a [`Measured`]: errors relative to the solution in three norms,
//! overshoot, width of a front, angle of a cone, mass, and the median wall time. Nothing here is generic: what a program
//! links is compiled once, in this crate.
//!
//! ```
//! use cf_tradeoff::{Problem, Scheme, Setting};
//!
//! let problem = Problem::line(50)?;
//! let [front, be] = [(Scheme::Front, 25), (Scheme::PaperBe, 25)].map(|(scheme, steps)| {
//!     problem.measure(&Setting::new(scheme, steps, 1), 1).map(|(measured, _)| measured)
//! });
//! let (front, be) = (front?, be?);
//! assert!(front.one < 0.4 * be.one && front.ringing < 1e-12);
//! # Ok::<(), cf_tradeoff::TradeoffError>(())
//! ```

pub mod deformation;
pub mod disc;
mod error;
mod judge;
mod line;
mod measured;
mod problem;
mod run;
mod setting;
pub mod vortices;
mod wake;

pub use error::TradeoffError;
pub use measured::{Measured, best, cheapest, median};
pub use problem::Problem;
pub use setting::{Level, Numbers, Scheme, Setting};
