//! Solutions known in closed form or by quadrature, to hold the time steps against.
//!
//! Everything starts from one mode of the Laplacian, −∇²f = Λf. On it the law is two ordinary differential equations
//! for φ and D = ∇·q_C, and [`modes`] solves them exactly, at rest or moving, with a steady source ([`source`]);
//! their energy never grows ([`energy`]). The
//! same two numbers under one step of a scheme are a 2×2 matrix ([`amplification`]); on a box of cells the modes are
//! cosines and sines ([`axis`]), so a step of a solver can be compared with its matrix to rounding.
//!
//! Sums and integrals of modes give whole fields: a Gaussian in a box or in free space ([`gaussian`]), for every law.
//! Sharp data of Cattaneo's law in one dimension has a closed form with Bessel functions, the telegraph equation's
//! ([`telegraph`], [`bessel`]). Last, [`single_field`] solves the model of the paper's Appendix A that looks like this
//! one and is not.
//!
//! Numbers here are f64, in SI units; nothing panics, and what has no value is NaN or `None`.

pub mod amplification;
pub mod axis;
pub mod bessel;
pub mod energy;
pub mod gaussian;
pub mod modes;
mod quadrature;
pub mod single_field;
pub mod source;
pub mod telegraph;

pub use axis::{AxisModes, Walls};
pub use gaussian::Gaussian;
pub use single_field::SingleField;
pub use telegraph::Telegraph;
