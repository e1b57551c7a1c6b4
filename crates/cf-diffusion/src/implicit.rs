//! The implicit step of the paper (eqs. 17, 18), rescaled so that no parameter breaks it, in conservative form.
//!
//! One stage over dt from (phi*, q*), with the coefficients of [`Coefficients`] (model/diffusion.md section 3):
//!
//! ```text
//! (I - beta Lap) phi^ = phi* - w dt Div q* + dt W (+ walls)
//! q_C   = w q* - v k_C Grad phi^
//! phi   = phi* - dt Div(q_C - k_F Grad phi^)  ( = phi^ if the solve is exact)
//! ```
//!
//! The solve sees the deviation from the mean, and phi is updated from face fluxes of that deviation: mass is exact to
//! rounding at any tolerance. Where the rounding of kappa times the deviation would exceed what the precision promises,
//! phi^ itself is kept and its mass is restored per fluid component (section 0.1).

use cf_grid::{CellField, End, Max, Real, Wall, row_sum};
use cf_linear::{Choice, Helmholtz, Options, Plan, Precision, Solver, Statistics, Stop};

use crate::coefficients::Coefficients;
use crate::law::Law;
use crate::source::Source;
use crate::state::State;
use crate::step_error::StepError;
use crate::sweeps::{net_outflow, spread, update_flux};
use crate::walls::Walls;

/// Largest share of rounding noise, D eps kappa, up to which phi is rebuilt from fluxes.
fn noise_limit<T: Real>() -> f64 {
    if T::EPSILON < 1e-10 { 1e-12 } else { 1e-5 }
}

/// What a stage moved.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moved {
    /// Through the walls, outwards [sum of phi].
    pub outflow: f64,
    /// The solve.
    pub statistics: Statistics,
}

/// Implicit stages on one domain: scratch, and the solver of the current step size.
pub(crate) struct Implicit<T, const D: usize> {
    h: f64,
    rhs: CellField<T>,
    y: CellField<T>,
    solver: Option<(f64, Solver<T, D>)>,
    precision: Precision,
    plan: Option<Plan>,
    tolerance: f64,
}

impl<T: Real, const D: usize> Implicit<T, D> {
    pub fn new(walls: &Walls<T, D>, h: f64, tolerance: f64, precision: Precision, plan: Option<Plan>) -> Self {
        let field = || CellField::new(&walls.layout);
        Self { h, rhs: field(), y: field(), solver: None, precision, plan, tolerance }
    }

    pub fn bytes(&self) -> usize {
        self.rhs.bytes() + self.y.bytes() + self.solver.as_ref().map_or(0, |(_, s)| s.bytes())
    }

    pub fn choice(&self) -> Option<(&Choice, usize)> {
        self.solver.as_ref().map(|(_, s)| (s.choice(), s.levels()))
    }

    /// One backward Euler stage; the state moves `stretch` times as far as the stage's result: 1 for backward Euler,
    /// 1 + sqrt 2 for the first stage of SDIRK2, whose outcome is the start of the second.
    pub fn stage(
        &mut self,
        walls: &Walls<T, D>,
        law: &Law,
        state: &mut State<T, D>,
        source: Source<'_, T>,
        dt: f64,
        stretch: f64,
    ) -> Result<Moved, StepError> {
        let (layout, h) = (walls.layout, self.h);
        let cells = layout.cells_region();
        let c = Coefficients::new(law, dt);
        let kappa = c.beta / (h * h);
        let per_h = dt / h;
        let reference = T::of(layout.sum(&state.phi) / layout.count() as f64);
        let size = self.form_rhs(walls, state, source, &c, reference, kappa, per_h);
        if !size.is_finite() {
            return Err(StepError::NotFinite { field: "right-hand side", cell: Vec::new() });
        }
        self.ready(walls, kappa, per_h, dt)?;
        let Some((_, solver)) = &mut self.solver else { return Ok(Moved::default()) };
        // Never below the rounding floor of evaluating the right-hand side itself.
        let wanted = (self.tolerance.max(8.0 * T::EPSILON)) * size;
        let found = solver.solve_deviation(&self.rhs, &mut self.y, Stop::Largest(wanted))?;
        let factor = found.factor;

        // Totals before phi changes: what the stage must arrive at, per component.
        walls.fill_rim(&mut self.y);
        let y = &self.y[..];
        let keeps_flux_form = D as f64 * T::EPSILON * kappa <= noise_limit::<T>();
        let (slow, rhs) = (state.slow_flux.as_ref(), &self.rhs[..]);
        let mut outflow = 0.0;
        let far = reference.f64();
        walls.each(|w| {
            let phi = factor * y[w.cell].f64();
            outflow += match w.wall {
                Wall::Flux(g) => per_h * g,
                Wall::Value(v) => {
                    let old = slow.map_or(0.0, |q| w.end.sign() * q.axis(w.axis)[w.face].f64());
                    c.pull / h * old + 2.0 * kappa * (phi - (v - far))
                }
                Wall::Absorbing { speed, far: rest } => per_h * speed * (phi - (rest - far)),
                Wall::Open { .. } => 0.0,
            };
        });
        let (gain, weight) = (T::of(stretch), T::of(kappa * factor));
        // Solid cells keep their value.
        let fluid = walls.mask.as_ref().map(|m| m.fluid());
        if keeps_flux_form {
            layout.par_runs(cells, &mut state.phi[..], |run, phi: &mut [T]| {
                let mut moved = [T::ZERO; ROW];
                in_pieces(&run, phi, |piece, phi| {
                    let moved = &mut moved[..phi.len()];
                    spread(walls, &piece, y, moved);
                    if let Some(fluid) = fluid {
                        for (i, (phi, &rhs)) in phi.iter_mut().zip(piece.row(rhs)).enumerate() {
                            if fluid[piece.slot() + i] {
                                *phi += gain * ((rhs - (*phi - reference)) + weight * moved[i]);
                            }
                        }
                        return;
                    }
                    for ((phi, &rhs), &moved) in phi.iter_mut().zip(piece.row(rhs)).zip(moved.iter()) {
                        let change = (rhs - (*phi - reference)) + weight * moved;
                        *phi += gain * change;
                    }
                });
            });
            // rhs holds the walls' inhomogeneous part; their homogeneous part is still missing.
            walls.each(|w| {
                let conductance = match w.wall {
                    Wall::Value(_) => 2.0 * kappa,
                    Wall::Absorbing { speed, .. } => per_h * speed,
                    Wall::Flux(_) | Wall::Open { .. } => return,
                };
                state.phi[w.cell] -= T::of(stretch * conductance * factor * y[w.cell].f64());
            });
        } else {
            let labels = walls.components();
            let totals = component_sums(walls, labels.as_ref(), |slot| {
                let phi = state.phi[slot].f64();
                phi + stretch * (rhs[slot].f64() - (phi - far))
            });
            let mut totals = totals;
            walls.each(|w| {
                let conductance = match w.wall {
                    Wall::Value(_) => 2.0 * kappa,
                    Wall::Absorbing { speed, .. } => per_h * speed,
                    Wall::Flux(_) | Wall::Open { .. } => return,
                };
                let component = labels.as_ref().map_or(0, |l| l.label[w.cell] as usize - 1);
                totals[component] -= stretch * conductance * factor * y[w.cell].f64();
            });
            // phi^ - reference, in the precision of the state.
            self.rhs.copy_from_slice(&self.y);
            solver.finish(&mut self.rhs, &found);
            let solved = &self.rhs[..];
            layout.par_runs(cells, &mut state.phi[..], |run, phi: &mut [T]| {
                for (i, (phi, &solved)) in phi.iter_mut().zip(run.row(solved)).enumerate() {
                    if fluid.is_none_or(|f| f[run.slot() + i]) {
                        *phi += gain * (solved - (*phi - reference));
                    }
                }
            });
            restore(walls, labels.as_ref(), &mut state.phi, &totals);
        }

        if let Some(q) = &mut state.slow_flux {
            // Stretched: q + stretch (w q - v k_C Grad - q).
            let keep = 1.0 - stretch + stretch * c.keep;
            let gain = stretch * c.gain / h;
            update_flux(walls, q, y, keep, gain * factor);
            walls.each(|w| {
                if let Wall::Value(v) = w.wall {
                    // Gradient over half a cell, oriented along the axis. Low faces have decayed with the cells' sweep.
                    let gradient = -2.0 * (factor * y[w.cell].f64() - (v - far)) * w.end.sign();
                    let q = &mut q.axis_mut(w.axis)[w.face];
                    let old = if w.end == End::Low { q.f64() } else { keep * q.f64() };
                    *q = T::of(old - gain * gradient);
                }
            });
            walls.fill_seams(q);
        }
        Ok(Moved { outflow, statistics: found.statistics })
    }

    /// rhs = phi* - reference - (w dt/h) Σ(q_high - q_low) + dt W + walls; returns the size of what went in.
    #[allow(clippy::too_many_arguments)]
    fn form_rhs(
        &mut self,
        walls: &Walls<T, D>,
        state: &mut State<T, D>,
        source: Source<'_, T>,
        c: &Coefficients,
        reference: T,
        kappa: f64,
        per_h: f64,
    ) -> f64 {
        let layout = walls.layout;
        if let Some(q) = &mut state.slow_flux {
            walls.fill_seams(q);
        }
        let (phi, slow) = (&state.phi[..], state.slow_flux.as_ref().map(|q| q.axes()));
        let pull = T::of(c.pull / self.h);
        let emitted = source.share * c.dt;
        let fluid = walls.mask.as_ref().map(|m| m.fluid());
        let size: Max = layout.par_runs(layout.cells_region(), &mut self.rhs[..], |run, rhs: &mut [T]| {
            let mut net = [T::ZERO; ROW];
            let mut size = Max(0.0);
            in_pieces(&run, rhs, |piece, rhs| {
                for (rhs, &phi) in rhs.iter_mut().zip(piece.row(phi)) {
                    *rhs = phi - reference;
                }
                if let Some(q) = slow {
                    let net = &mut net[..rhs.len()];
                    net_outflow(&piece, q, net);
                    for (rhs, &net) in rhs.iter_mut().zip(net.iter()) {
                        *rhs -= pull * net;
                    }
                }
                if let Some(rate) = source.rate {
                    let emitted = T::of(emitted);
                    for (rhs, &w) in rhs.iter_mut().zip(piece.row(rate)) {
                        *rhs += emitted * w;
                    }
                }
                if let Some(fluid) = fluid {
                    for (rhs, &fluid) in rhs.iter_mut().zip(piece.row(fluid)) {
                        *rhs = if fluid { *rhs } else { T::ZERO };
                    }
                }
                let largest = rhs.iter().fold(T::ZERO, |m, r| m.max(r.abs()));
                // A NaN loses every comparison; the sum keeps it.
                let poison = row_sum(rhs) * 0.0;
                size = Max(size.0.max(largest.f64()) + poison);
            });
            size
        });
        let mut size = size.0;
        let far = reference.f64();
        walls.each(|w| {
            let (part, level) = match w.wall {
                Wall::Flux(g) => (-per_h * g, per_h * g),
                Wall::Value(v) => (2.0 * kappa * (v - far), v - far),
                Wall::Absorbing { speed, far: rest } => (per_h * speed * (rest - far), rest - far),
                Wall::Open { .. } => return,
            };
            self.rhs[w.cell] += T::of(part);
            size = size.max(level.abs());
        });
        size
    }

    /// The solver for this step size, rebuilt when the size changes.
    fn ready(&mut self, walls: &Walls<T, D>, kappa: f64, per_h: f64, dt: f64) -> Result<(), StepError> {
        if self.solver.as_ref().is_some_and(|&(of, _)| of == dt) {
            return Ok(());
        }
        self.solver = None;
        let mut operator = Helmholtz::new(&walls.layout, 1.0, kappa, walls.conductances(kappa, per_h));
        if let Some(mask) = &walls.mask {
            operator = operator.with_mask(mask);
        }
        let options = Options {
            plan: self.plan,
            precision: self.precision,
            reduction: self.tolerance.clamp(1e-14, 0.1),
            ..Options::default()
        };
        self.solver = Some((dt, Solver::new(&operator, options)?));
        Ok(())
    }
}

/// Longest piece of a row that passes through a buffer on the stack.
pub(crate) const ROW: usize = 512;

/// A row in pieces of at most [`ROW`] cells.
pub(crate) fn in_pieces<'l, T, const D: usize>(
    run: &cf_grid::Run<'l, D>,
    row: &mut [T],
    mut f: impl FnMut(cf_grid::Run<'l, D>, &mut [T]),
) {
    let mut start = 0;
    for piece in row.chunks_mut(ROW) {
        f(run.part(start, piece.len()), piece);
        start += piece.len();
    }
}

fn component_sums<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    labels: Option<&cf_grid::Components>,
    value: impl Fn(usize) -> f64 + Sync,
) -> Vec<f64> {
    let layout = walls.layout;
    match labels {
        None => vec![layout.par_runs(layout.cells_region(), (), |run, ()| {
            (run.slot()..run.slot() + run.len()).map(&value).sum::<f64>()
        })],
        Some(labels) => {
            let mut sums = vec![0.0; labels.cells.len()];
            layout.each_cell(layout.cells_region(), |at| {
                if let Some(component) = labels.label[at.slot()].checked_sub(1) {
                    sums[component as usize] += value(at.slot());
                }
            });
            sums
        }
    }
}

/// Shifts each component to its total.
fn restore<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    labels: Option<&cf_grid::Components>,
    phi: &mut [T],
    totals: &[f64],
) {
    let layout = walls.layout;
    // Twice: in f32 the first shift is itself rounded.
    for _ in 0..2 {
        let found = component_sums(walls, labels, |slot| phi[slot].f64());
        let cells = |i: usize| labels.map_or(layout.count(), |l| l.cells[i]) as f64;
        let shift: Vec<f64> = (0..totals.len()).map(|i| (totals[i] - found[i]) / cells(i)).collect();
        layout.par_runs(layout.cells_region(), &mut *phi, |run, row: &mut [T]| match labels {
            None => row.iter_mut().for_each(|v| *v += T::of(shift[0])),
            Some(l) => {
                for (v, &label) in row.iter_mut().zip(run.row(&l.label)) {
                    if label > 0 {
                        *v += T::of(shift[label as usize - 1]);
                    }
                }
            }
        });
    }
}
