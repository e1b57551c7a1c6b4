//! Incompressible inviscid flow on the MAC grid.

mod calculus;
mod carry;
mod central;
mod chunk;
mod combine;
mod emit;
mod error;
pub mod exact;
mod fill;
mod fluid;
mod gates;
mod lattice;
mod point;
mod project;
mod settings;
mod shape;
mod steps;
mod trace;
mod wall;

pub use calculus::{kinetic_energy, net_outflow};
pub use carry::Interpolation;
pub use emit::{Emission, Emitter, Jet};
pub use error::FlowError;
pub use fluid::Fluid;
pub use project::{Projected, Projection};
pub use settings::{Buoyancy, FlowObserver, FlowPhase, FlowReport, FlowSettings, Scheme};
pub use shape::{Shape, obstacles, obstacles_from_bytes};
pub use wall::FlowWall;
