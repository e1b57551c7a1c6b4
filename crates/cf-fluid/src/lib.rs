//! Incompressible inviscid flow on the MAC grid.

mod calculus;
mod carry;
mod central;
mod chunk;
mod combine;
mod coupled;
mod emit;
mod error;
pub mod exact;
mod fill;
mod flow;
mod fluid;
mod gates;
mod lattice;
mod point;
mod project;
mod settings;
mod shape;
mod steps;
mod trace;
mod transport;
mod wall;

pub use calculus::{kinetic_energy, net_outflow};
pub use carry::Interpolation;
pub use coupled::{Coupled, CoupledReport};
pub use emit::{Emission, Emitter, Jet};
pub use error::FlowError;
pub use flow::Flow;
pub use fluid::Fluid;
pub use project::{Projected, Projection};
pub use settings::{Buoyancy, FlowObserver, FlowPhase, FlowReport, FlowSettings, Scheme};
pub use shape::{Shape, obstacles, obstacles_from_bytes};
pub use transport::Transport;
pub use wall::FlowWall;
