//! The Cattaneo-Fourier law on a box of cells, without error in time.
//!
//! On a box without obstacles, with constant coefficients, cosines and sines are the modes of −∇²_h, and each mode of
//! (φ, D = ∇·q_C) has an exact propagator ([`cf_diffusion::exact::modes`]):
//!
//! ```text
//! φ_t + u·∇φ + ∇·q_C − k_F ∇²φ = W              φ [P], q_C [P m/s], k [m²/s], τ [s], u [m/s], W [P/s]
//! τ (q_C,t + u·∇q_C) + q_C = −k_C ∇φ            k_F = F_T k,  k_C = (1 − F_T) k
//! ```
//!
//! [`Spectral`] takes the state there by a transform per axis, lets every mode evolve, and comes back. The same
//! [`State`](cf_diffusion::State) as that of [`Diffusion`](cf_diffusion::Diffusion) goes in and out, with the whole of
//! q_C: its gradient part follows from D, the rest decays by e^{−t/τ}. A step of any size then has no error but rounding
//! against the equations that are discrete in space alone; what remains is the second order of the grid. That makes it
//! the reference for the error in time of every other scheme on the same grid, and fast where one long step will do.
//!
//! Walls: closed, valued (any constant) and periodic, and any mix of them; other walls have no such modes and are
//! refused. The medium rests, or moves uniformly along periodic axes, by trigonometric interpolation: exact for all
//! waves but the shortest of an even number of cells. The steady source W needs a medium at rest.
//!
//! [`smooth`] solves the continuous equations instead, by the same transforms: with it a scheme's whole error, in space
//! and time, can be told from its error in time alone. [`wake`] does so for a steady source in a uniform flow.
//!
//! All arithmetic is in f64; states in f32 are rounded once per step. Cost: two transforms there and two back, one
//! without memory, and an exponential or sine per mode.
//!
//! ```
//! use cf_diffusion::{Law, Medium, Source, State};
//! use cf_grid::{Grid, Sides, Wall};
//! use cf_spectral::Spectral;
//!
//! let grid = Grid::<2>::new([64, 64], 1.0 / 64.0)?;
//! let law = Law::cattaneo(0.25, 4.0)?; // c = sqrt(k/tau) = 0.25 m/s
//! let mut state = State::<f64, 2>::new(&grid, &law);
//! state.phi[grid.layout().slot([32, 32])] = 1.0;
//! let mut spectral = Spectral::new(&grid, &Sides::all(Wall::CLOSED), law)?;
//! spectral.step(&mut state, &Medium::Still, Source::NONE, 0.5)?;
//! assert!((state.mass(&grid) - grid.cell_volume()).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cells;
mod error;
mod modes;
mod shift;
mod smooth;
mod stepper;
mod transform;
mod wake;

pub use error::SpectralError;
pub use smooth::smooth;
pub use stepper::Spectral;
pub use wake::wake;
