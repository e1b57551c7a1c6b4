//! Incompressible inviscid flow on the MAC grid, and what it carries.
//!
//! ```text
//! u_t + (u·grad) u = -(1/rho) grad p + b,   div u = 0
//! ```
//!
//! u \[m/s\] lives on faces, p/rho \[m²/s²\] in cells, div and grad are each other's negative transpose: the
//! [`Projection`] is orthogonal, and the residual of its solve is the divergence that remains (Chorin 1968; Harlow and Welch 1965).
//!
//! * [`Fluid`] steps the velocity: [`Scheme::Cnp`] up to CFL_u = 1 and [`Scheme::ReflectionExtrapolated`] above are second
//!   order, with cubic semi-Lagrangian transport that is stable for any step; [`Scheme::Draft`] is first order and
//!   [`Scheme::CentralRk4`] conserves energy, for reference. Each projection ends with max|div u| dt <= eta_div.
//! * [`FlowWall`]s are closed, open or let fluid in; solids are a mask made of [`Shape`]s or of a file's bytes. No-penetration is
//!   exact for any tolerance. Walls mirror the flow; in solids it continues a few cells, so that fluid slips along both.
//! * Each part of the fluid that no open wall touches has a pressure of its own; where what is held at its
//!   boundary does not balance, [`FlowReport::imbalance`] says so.
//! * [`Flow`] is a fluid or a prescribed velocity, for which no pressure exists; [`Coupled`] carries phi and q_C of
//!   [`cf_diffusion`] with either, in second order or in the paper's order, with [`Emitter`]s and buoyancy.
//!
//! Rows of values are interpolated together: where they come from places equally far away, the values around them are
//! contiguous too, and no gathering is needed (`chunk`). Trajectories are traced once per cell for all that is carried
//! (`paths`).
//!
//! ```
//! use cf_fluid::{FlowSettings, FlowWall, Fluid, Shape, obstacles};
//! use cf_grid::{Axis, Grid, Sides};
//!
//! let grid = Grid::<2>::new([48, 24], 1.0 / 24.0)?;
//! let ball = obstacles(&grid, &[Shape::Sphere { center: [0.6, 0.5], radius: 0.15 }])?;
//! let mut sides = Sides::all(FlowWall::Closed);
//! sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0]), FlowWall::Open([1.0, 0.0])]);
//! let mut fluid = Fluid::<f64, 2>::new(&grid, &sides, Some(&ball), FlowSettings::default())?;
//! for _ in 0..10 {
//!     let report = fluid.step(fluid.dt_for(0.8))?;
//!     assert!(report.divergence <= 1e-4 && report.imbalance == 0.0);
//! }
//! assert!(fluid.max_speed() > 1.2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

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
mod inspect;
mod lattice;
mod limit;
mod paths;
mod point;
mod project;
mod settings;
mod shape;
mod steps;
mod trace;
mod transport;
#[cfg(feature = "verify")]
pub mod verify;
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
