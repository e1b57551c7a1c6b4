//! What passes between cells, and between cells and walls, in one stage.

use cf_grid::{Real, Wall};

use crate::walls::Walls;

/// Largest conductance between the fluid and what stands outside, beyond which nothing changes any more: the wall term
/// of the right-hand side stays finite.
fn stiffest<T: Real>() -> f64 {
    if T::EPSILON < 1e-10 { 1e290 } else { 1e30 }
}

/// What conducts in one stage, in units of cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Conductances {
    /// beta/h² between cells.
    pub kappa: f64,
    /// dt/h.
    pub per_h: f64,
    /// The largest of all.
    pub largest: f64,
    /// What none exceeds.
    most: f64,
}

impl Conductances {
    pub fn new<T: Real, const D: usize>(walls: &Walls<T, D>, kappa: f64, per_h: f64) -> Self {
        let held = walls.sides.walls().any(|(_, _, w)| matches!(w, Wall::Value(_) | Wall::Absorbing { .. }));
        let most = if held { stiffest::<T>() } else { f64::INFINITY };
        let mut faces = Self { kappa: kappa.min(most), per_h, largest: 0.0, most };
        let on_walls = walls.sides.walls().map(|(_, _, w)| 0.5 * faces.of(w));
        faces.largest = on_walls.fold(faces.kappa, f64::max);
        faces
    }

    /// About the level of phi at the end: its mean, moved by given fluxes and drawn towards what the walls hold. What is
    /// solved for is the deviation from it, which a stiff step leaves small where all walls hold the same.
    pub fn level<T: Real, const D: usize>(&self, walls: &Walls<T, D>, mean: f64) -> f64 {
        let mut weight = walls.layout.count() as f64;
        let given = walls.moving.iter().map(|&(wall, count)| match wall {
            Wall::Flux(g) => self.per_h * g * count as f64,
            _ => 0.0,
        });
        let mut level = mean - given.sum::<f64>() / weight;
        for &(wall, count) in &walls.moving {
            let (Wall::Value(held) | Wall::Absorbing { far: held, .. }) = wall else { continue };
            let more = self.of(wall) * count as f64;
            weight += more;
            level += (held - level) * (more / weight);
        }
        level
    }

    /// Of the homogeneous operator on a wall: 2 kappa for values, dt c/h for absorbing walls, 0 for the others.
    pub fn of(&self, wall: Wall) -> f64 {
        match wall {
            Wall::Value(_) => 2.0 * self.kappa,
            Wall::Absorbing { speed, .. } => (self.per_h * speed).min(self.most),
            Wall::Flux(_) | Wall::Open { .. } => 0.0,
        }
    }
}
