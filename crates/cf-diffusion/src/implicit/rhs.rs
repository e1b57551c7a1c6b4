//! The right-hand side of a stage, formed where it is read: at the start of the solve, for its true residual, and when phi is rebuilt.

use cf_grid::{CellField, Max, Pool, Real, Run, Wall, row_sum, vectorised};
use cf_linear::RightHandSide;

use super::conductances::Conductances;
use super::{ROW, Stage, in_pieces};
use crate::source::{Rate, Source};
use crate::sweeps::net_outflow;
use crate::walls::Walls;

/// phi* - reference - (w dt/h) Σ(q_high - q_low) + dt W + walls, zero in solid cells, as a formula of phi*.
pub(super) struct Formula<'a, T, const D: usize> {
    reference: T,
    pull: T,
    slow: Option<[&'a [T]; D]>,
    rate: Option<(Rate<'a, T>, T)>,
    /// What walls add to the cells at their low and high ends.
    walls: [[T; 2]; D],
    fluid: Option<&'a [bool]>,
}

impl<'a, T: Real, const D: usize> Formula<'a, T, D> {
    /// Seams of `slow` are filled.
    pub fn new(
        walls: &'a Walls<T, D>,
        slow: Option<[&'a [T]; D]>,
        source: Source<'a, T>,
        stage: &Stage<T>,
        h: f64,
    ) -> Self {
        let &Stage { c, faces, reference, .. } = stage;
        let mut parts = [[T::ZERO; 2]; D];
        for (axis, end, wall) in walls.sides.walls() {
            parts[axis][end as usize] = T::of(match wall {
                Wall::Flux(g) => -faces.per_h * g,
                Wall::Value(level) | Wall::Absorbing { far: level, .. } => faces.of(wall) * (level - reference.f64()),
                Wall::Open { .. } => 0.0,
            });
        }
        Self {
            reference,
            pull: T::of(c.pull / h),
            slow,
            rate: source.rate.map(|rate| (rate, T::of(source.share * c.dt))),
            walls: parts,
            fluid: walls.mask.as_ref().map(|m| m.fluid()),
        }
    }

    /// The values of at most [`ROW`] cells, from phi* there.
    #[inline(always)]
    pub fn form(&self, piece: &Run<'_, D>, phi: &[T], rhs: &mut [T]) {
        self.inside(piece, phi, rhs);
        for a in 0..D {
            let [low, high] = self.walls[a];
            let cells = piece.layout().cells()[a];
            // Along x a piece ends at a wall; along the others it lies at one as a whole.
            let (last, at_low, at_high) = match a {
                0 => (piece.cell[0] + rhs.len(), 0..1, rhs.len() - 1..rhs.len()),
                _ => (piece.cell[a] + 1, 0..rhs.len(), 0..rhs.len()),
            };
            if low != T::ZERO && piece.cell[a] == 0 {
                rhs[at_low].iter_mut().for_each(|rhs| *rhs += low);
            }
            if high != T::ZERO && last == cells {
                rhs[at_high].iter_mut().for_each(|rhs| *rhs += high);
            }
        }
        if let Some(fluid) = self.fluid {
            for (rhs, &fluid) in rhs.iter_mut().zip(piece.row(fluid)) {
                *rhs = if fluid { *rhs } else { T::ZERO };
            }
        }
    }

    /// The same without what walls add; anything in solid cells.
    #[inline(always)]
    fn inside(&self, piece: &Run<'_, D>, phi: &[T], rhs: &mut [T]) {
        for (rhs, &phi) in rhs.iter_mut().zip(phi) {
            *rhs = phi - self.reference;
        }
        if let Some(q) = self.slow {
            let mut net = [T::ZERO; ROW];
            let net = &mut net[..rhs.len()];
            net_outflow(piece, q, net);
            for (rhs, &net) in rhs.iter_mut().zip(net.iter()) {
                *rhs -= self.pull * net;
            }
        }
        if let Some((rate, emitted)) = self.rate {
            let (skipped, rate) = rate.within(piece.slot(), rhs.len());
            for (rhs, &w) in rhs[skipped..].iter_mut().zip(rate) {
                *rhs += emitted * w;
            }
        }
    }

    /// All of it, in an array of the pool.
    pub fn whole(&self, walls: &Walls<T, D>, phi: &[T], pool: &Pool<T>) -> CellField<T> {
        let mut rhs = CellField::default();
        pool.fetch(&walls.layout, [&mut rhs]);
        walls.layout.par_runs(
            walls.layout.cells_region(),
            &mut rhs[..],
            #[inline(always)]
            |run, rhs: &mut [T]| in_pieces(&run, rhs, |piece, rhs| self.form(&piece, piece.row(phi), rhs)),
        );
        rhs
    }

    /// The size of what goes in through cells; not finite if any of it is not.
    fn size_inside(&self, walls: &Walls<T, D>, phi: &[T]) -> f64 {
        let layout = walls.layout;
        let size: Max = layout.par_runs(
            layout.cells_region(),
            (),
            #[inline(always)]
            |run, ()| {
                let mut buffer = [T::ZERO; ROW];
                let (mut largest, mut poison) = (T::ZERO, 0.0);
                for first in (0..run.len()).step_by(ROW) {
                    let piece = run.part(first, ROW.min(run.len() - first));
                    let rhs = &mut buffer[..piece.len()];
                    self.inside(&piece, piece.row(phi), rhs);
                    if let Some(fluid) = self.fluid {
                        for (rhs, &fluid) in rhs.iter_mut().zip(piece.row(fluid)) {
                            *rhs = if fluid { *rhs } else { T::ZERO };
                        }
                    }
                    largest = rhs.iter().fold(largest, |m, r| m.max(r.abs()));
                    // A NaN loses every comparison; the sum keeps it.
                    poison += row_sum(rhs) * 0.0;
                }
                Max(largest.f64() + poison)
            },
        );
        size.0
    }

    /// The size of what goes in; not finite if any of it is not.
    pub fn size(&self, walls: &Walls<T, D>, faces: &Conductances, phi: &[T]) -> f64 {
        let inside = self.size_inside(walls, phi);
        if !inside.is_finite() {
            return inside;
        }
        let levels = walls.moving.iter().map(|&(wall, _)| match wall {
            Wall::Flux(g) => faces.per_h * g,
            Wall::Value(level) | Wall::Absorbing { far: level, .. } => level - self.reference.f64(),
            Wall::Open { .. } => 0.0,
        });
        levels.fold(inside, |size, level| size.max(level.abs()))
    }
}

/// The formula with phi* itself.
pub(super) struct Formed<'a, T, const D: usize> {
    pub formula: &'a Formula<'a, T, D>,
    pub phi: &'a [T],
}

impl<T: Real, const D: usize> RightHandSide<T, D> for Formed<'_, T, D> {
    fn row<'r>(&'r self, run: &Run<'_, D>, buffer: &'r mut [T]) -> &'r [T] {
        vectorised(
            #[inline(always)]
            || self.formula.form(run, run.row(self.phi), buffer),
        );
        buffer
    }
}
