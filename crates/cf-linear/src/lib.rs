//! One elliptic operator for everything: alpha x - div(beta grad x) = b on a padded box.
//!
//! Implicit diffusion (alpha = 1), the pressure of a flow (alpha = 0), phase fields and saturation all solve this
//! equation; Fourier, Cattaneo and Jeffreys diffusion differ only in beta. [`Helmholtz`] describes the operator with
//! its walls folded in as face conductances, [`Solver`] solves it:
//!
//! * kappa = beta/h² small: Chebyshev iteration on the diagonally scaled operator, count known beforehand, no dot
//!   products; otherwise conjugate gradients with one V(1,1) multigrid cycle (red-black Gauss-Seidel, linear transfer
//!   P, restriction Pᵀ, coarsest level solved exactly). [`Plan::choose`] is a pure function and says why.
//! * Uniform coefficients on a box store nothing per cell, and a V-cycle reads and writes the finest level three times:
//!   two sweeps keep smoothing, residual, restriction and prolongation in cache (`fused`). Masks and variable
//!   coefficients store face weights, and cells near obstacles are smoothed more often (`band`).
//! * Where no wall conducts, the constant part of the solution is exact and the iteration sees only the deviation: pure
//!   Poisson problems work, and `f32` loses nothing for kappa up to 1e300.
//! * For alpha = 1 and a residual r: max|x - x_exact| <= max|r| and likewise in the 2-norm, since A is an M-matrix whose
//!   rows all sum to at least 1. [`Stop::Largest`] stops on that bound.
//! * Every solve returns [`Statistics`] or a [`SolveError`] with the residual reached. Results have the same bits for
//!   any number of threads.
//!
//! ```
//! use cf_grid::{Layout, Sides};
//! use cf_linear::{Helmholtz, Options, Solver, Stop};
//!
//! let layout = Layout::new([64, 64])?;
//! let kappa = 100.0;
//! let held_at_zero = Sides::all(2.0 * kappa);
//! let operator = Helmholtz::new(&layout, 1.0, kappa, held_at_zero);
//! let mut solver = Solver::<f64, 2>::new(&operator, Options::default())?;
//! let mut b = vec![0.0; layout.slots()];
//! b[layout.slot([20, 30])] = 1.0;
//! let mut x = vec![0.0; layout.slots()];
//! let done = solver.solve(&b, &mut x, Stop::Relative(1e-6))?;
//! assert!(done.iterations <= 8);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axis;
mod band;
mod chebyshev;
mod coarse;
mod deflate;
mod engine;
mod error;
mod fused;
mod helmholtz;
mod kernels;
mod level;
mod multigrid;
mod norms;
mod pcg;
mod plan;
mod rhs;
mod solver;
mod stencil;
mod stop;
mod task;
mod transfer;

pub use error::SolveError;
pub use helmholtz::Helmholtz;
pub use kernels::Kernel;
pub use plan::{Choice, Plan, chebyshev_count};
pub use rhs::{PIECE, RightHandSide};
pub use solver::{Options, Precision, Solver};
pub use stop::{Deviation, Statistics, Stop};
