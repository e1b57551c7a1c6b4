//! What this crate claims, measured, as [`cf_diffusion::verify`] does for diffusion.
//!
//! | function | claim |
//! |---|---|
//! | [`vortices`] | errors, orders and energies on Taylor and Green's vortices; speed and shape of a dipole |
//! | [`flows`](flows()) | energy in space and of random flows; a stream past a sphere; what is carried stays, and goes as in a given stream |
//! | [`projector`] | P P = P, orthogonality, P grad = 0; held faces exact; forces that a pressure balances move nothing |
//! | [`extremes`](extremes()) | random cases: steps from 0 to CFL_u = 1e3, boxes of one cell, pockets, jets, any eta_div |
//!
//! Nothing here is needed for a simulation, and nothing panics.

mod extremes;
mod flows;
mod projector;
mod vortices;

use std::array::from_fn;

use cf_diffusion::verify::Random;
use cf_grid::{Axis, FaceField, Layout, Mask, Real, Sides};

use crate::wall::FlowWall;

pub use extremes::{corner, corner_names, extremes, repeat};
pub use flows::{flows, random_flow};
pub use projector::projector;
pub use vortices::vortices;

/// Faces of random values in (-size, size).
fn random_faces<T: Real, const D: usize>(layout: &Layout<D>, size: f64, random: &mut Random) -> FaceField<T, D> {
    let mut u = FaceField::new(layout);
    for a in 0..D {
        layout.each_cell(layout.faces_region(a, false), |at| {
            u.axis_mut(a)[at.slot()] = T::of(random.between(-size, size));
        });
    }
    u
}

/// Random walls; only closed and periodic ones where `closed`.
fn random_sides<const D: usize>(speed: f64, closed: bool, random: &mut Random) -> Sides<FlowWall<D>, D> {
    let mut axis = || {
        if random.chance(0.3) {
            return Axis::Periodic;
        }
        let mut wall = || match random.below(if closed { 1 } else { 4 }) {
            0 => FlowWall::Closed,
            1 => FlowWall::OPEN,
            2 => FlowWall::Open(from_fn(|_| random.between(-speed, speed))),
            _ => FlowWall::Inflow(from_fn(|_| random.between(-speed, speed))),
        };
        Axis::Walls([wall(), wall()])
    };
    let mut sides = Sides::periodic();
    sides.0.iter_mut().for_each(|a| *a = axis());
    sides
}

/// Random solid cells, or none.
fn random_mask<const D: usize>(layout: &Layout<D>, random: &mut Random) -> Option<Mask<D>> {
    let share = random.pick([0.0, 0.0, 0.05, 0.3, 0.7]);
    if share == 0.0 {
        return None;
    }
    let mut solid = vec![false; layout.slots()];
    layout.each_cell(layout.cells_region(), |at| solid[at.slot()] = random.chance(share));
    Some(Mask::new(layout, |cell| !solid[layout.slot(cell)]))
}
