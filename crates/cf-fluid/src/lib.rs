//! Incompressible inviscid flow on the MAC grid.

mod calculus;
mod error;
mod gates;
mod project;
mod shape;
mod wall;

pub use calculus::{kinetic_energy, net_outflow};
pub use error::FlowError;
pub use project::{Projected, Projection};
pub use shape::{Shape, obstacles, obstacles_from_bytes};
pub use wall::FlowWall;
