//! phi after the solve: from the fluxes of the solution, or the solution itself where rounding forbids that.

use cf_grid::{Real, Wall};

use super::rhs::Formula;
use super::{Implicit, ROW, Stage, in_pieces};
use crate::source::Source;
use crate::sweeps::{part_sums, restore, spread};
use crate::walls::Walls;

impl<T: Real, const D: usize> Implicit<T, D> {
    /// phi from the face fluxes of the solved deviation. Returns what left through the walls.
    pub(super) fn rebuild(
        &self,
        walls: &Walls<T, D>,
        phi: &mut [T],
        slow: Option<[&[T]; D]>,
        formula: &Formula<'_, T, D>,
        stage: &Stage<T>,
        factor: f64,
    ) -> f64 {
        let &Stage { c, faces, reference, stretch } = stage;
        let y = &self.y[..];
        let (gain, weight) = (T::of(stretch), T::of(faces.kappa * factor));
        let fluid = walls.mask.as_ref().map(|m| m.fluid());
        let layout = walls.layout;
        layout.par_runs(
            layout.cells_region(),
            &mut *phi,
            #[inline(always)]
            |run, phi: &mut [T]| {
                let (mut moved, mut rhs) = ([T::ZERO; ROW], [T::ZERO; ROW]);
                in_pieces(
                    &run,
                    phi,
                    #[inline(always)]
                    |piece, phi| {
                        let (moved, rhs) = (&mut moved[..phi.len()], &mut rhs[..phi.len()]);
                        formula.form(&piece, phi, rhs);
                        spread(walls, &piece, y, moved);
                        if let Some(fluid) = fluid {
                            for (i, (phi, &rhs)) in phi.iter_mut().zip(rhs.iter()).enumerate() {
                                if fluid[piece.slot() + i] {
                                    *phi += gain * ((rhs - (*phi - reference)) + weight * moved[i]);
                                }
                            }
                            return;
                        }
                        for ((phi, &rhs), &moved) in phi.iter_mut().zip(rhs.iter()).zip(moved.iter()) {
                            let change = (rhs - (*phi - reference)) + weight * moved;
                            *phi += gain * change;
                        }
                    },
                );
            },
        );
        let far = reference.f64();
        let mut outflow = 0.0;
        walls.each(|w| {
            let (conductance, solved) = (faces.of(w.wall), factor * y[w.cell].f64());
            outflow += match w.wall {
                Wall::Flux(g) => faces.per_h * g,
                Wall::Value(v) => {
                    let old = slow.map_or(0.0, |q| w.end.sign() * q[w.axis][w.face].f64());
                    c.pull / self.h * old + conductance * (solved - (v - far))
                }
                Wall::Absorbing { far: rest, .. } => conductance * (solved - (rest - far)),
                Wall::Open { .. } => 0.0,
            };
            // rhs holds the walls' inhomogeneous part; their homogeneous part is still missing.
            if conductance > 0.0 {
                phi[w.cell] -= T::of(stretch * conductance * solved);
            }
        });
        outflow
    }

    /// phi^ itself, with the mass of each part restored. Through walls that pass phi by its value leaves what is missing.
    pub(super) fn keep(
        &self,
        walls: &Walls<T, D>,
        phi: &mut [T],
        source: Source<'_, T>,
        formula: &Formula<'_, T, D>,
        stage: &Stage<T>,
        factor: f64,
    ) -> f64 {
        let &Stage { c, faces, reference, stretch } = stage;
        let (parts, layout, far) = (walls.parts(), walls.layout, reference.f64());
        let (y, old) = (&self.y[..], &*phi);
        // All sums are of deviations from the reference.
        let before = part_sums(walls, parts, |slot| old[slot].f64() - far);
        // Between the cells of a part nothing is lost: what it gains is known without their fluxes.
        let mut gained = match source.rate {
            Some(rate) => part_sums(walls, parts, |slot| source.share * c.dt * rate.at(slot).f64()),
            None => vec![0.0; before.len()],
        };
        let mut outflow = 0.0;
        let mut conducts = vec![false; before.len()];
        walls.each(|w| {
            conducts[parts.of(w.cell)] |= faces.of(w.wall) > 0.0;
            if let Wall::Flux(g) = w.wall {
                gained[parts.of(w.cell)] -= faces.per_h * g;
                outflow += faces.per_h * g;
            }
        });
        // So is the constant that the solve leaves out, the mean of phi^. That of the right-hand side carries the rounding
        // of large fluxes and serves only where a wall that holds phi does not conduct.
        let right = if conducts == parts.held {
            Vec::new()
        } else {
            let mut rhs = formula.whole(walls, old, &self.pool);
            let sums = part_sums(walls, parts, |slot| rhs[slot].f64());
            self.pool.release([&mut rhs]);
            sums
        };
        let level = |part: usize| match (conducts[part], parts.held[part]) {
            (true, _) => 0.0,
            (false, true) => right.get(part).map_or(0.0, |sum| sum / parts.cells(part, &layout)),
            (false, false) => (before[part] + gained[part]) / parts.cells(part, &layout),
        };
        let levels: Vec<f64> = (0..before.len()).map(level).collect();

        let gain = T::of(stretch);
        let fluid = walls.mask.as_ref().map(|m| m.fluid());
        layout.par_runs(
            layout.cells_region(),
            &mut *phi,
            #[inline(always)]
            |run, phi: &mut [T]| {
                for (i, (phi, &y)) in phi.iter_mut().zip(run.row(y)).enumerate() {
                    let slot = run.slot() + i;
                    if fluid.is_none_or(|f| f[slot]) {
                        let solved = T::of(factor * y.f64() + levels[parts.of(slot)]);
                        *phi += gain * (solved - (*phi - reference));
                    }
                }
            },
        );
        let totals: Vec<f64> = before.iter().zip(&gained).map(|(sum, gained)| sum + stretch * gained).collect();
        restore(walls, parts, phi, far, &totals);

        if parts.held.contains(&true) {
            let new = &*phi;
            let after = part_sums(walls, parts, |slot| new[slot].f64() - far);
            let missing = (0..after.len()).filter(|&i| parts.held[i]).map(|i| (totals[i] - after[i]) / stretch);
            outflow += missing.sum::<f64>();
        }
        outflow
    }
}
