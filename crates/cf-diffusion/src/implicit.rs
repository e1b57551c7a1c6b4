//! The implicit step of the paper (eqs. 17, 18), rescaled so that no parameter breaks it, in conservative form.
//!
//! One stage over dt from (phi*, q*), with the coefficients of [`Coefficients`]:
//!
//! ```text
//! (I - beta Lap) phi^ = phi* - w dt Div q* + dt W (+ walls)
//! q_C   = w q* - v k_C Grad phi^
//! phi   = phi* - dt Div(q_C - k_F Grad phi^)  ( = phi^ if the solve is exact)
//! ```
//!
//! The solve sees the deviation from a reference, about the level at the end, and phi is updated from face fluxes of that deviation: mass is exact to
//! rounding at any tolerance. Where the rounding of kappa times the deviation would exceed what the precision promises,
//! phi^ itself is kept and its mass is restored per fluid component.

mod conductances;
mod rhs;
mod update;

use cf_grid::{CellField, End, Pool, Real, Wall};
use cf_linear::{Choice, Deviation, Helmholtz, Options, Plan, Precision, RightHandSide};
use cf_linear::{SolveError, Solver, Statistics, Stop};

use crate::coefficients::Coefficients;
use crate::law::Law;
use crate::source::Source;
use crate::state::State;
use crate::step_error::StepError;
use crate::sweeps::update_flux;
use crate::walls::{WallCell, Walls};
use conductances::Conductances;
use rhs::{Formed, Formula};

/// Largest share of rounding noise, D eps kappa, up to which phi is rebuilt from fluxes.
fn noise_limit<T: Real>() -> f64 {
    if T::EPSILON < 1e-10 { 1e-12 } else { 1e-5 }
}

/// What a stage moved.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moved {
    /// Through the walls, outwards \[sum of phi\].
    pub outflow: f64,
    /// The solve.
    pub statistics: Statistics,
}

/// The numbers of one stage.
#[derive(Debug, Clone, Copy)]
struct Stage<T> {
    c: Coefficients,
    faces: Conductances,
    /// What phi deviates from.
    reference: T,
    /// How far the state moves, in units of the stage's result.
    stretch: f64,
}

/// Implicit stages on one domain: scratch, and the solver of the current step size.
pub(crate) struct Implicit<T, const D: usize> {
    h: f64,
    y: CellField<T>,
    solver: Option<(f64, Solver<T, D>)>,
    found: Deviation,
    precision: Precision,
    plan: Option<Plan>,
    tolerance: f64,
    pool: Pool<T>,
}

impl<T: Real, const D: usize> Implicit<T, D> {
    pub fn new(h: f64, tolerance: f64, precision: Precision, plan: Option<Plan>) -> Self {
        let (y, found, pool) = Default::default();
        Self { h, y, solver: None, found, precision, plan, tolerance, pool }
    }

    /// From now on scratch comes from `pool`; [`release`](Self::release) gives it back.
    pub fn share(&mut self, pool: &Pool<T>) {
        self.pool = pool.clone();
        self.y = CellField::default();
        if let Some((_, solver)) = &mut self.solver {
            solver.share(pool);
        }
    }

    /// Gives scratch back to the pool.
    pub fn release(&mut self) {
        self.pool.release([&mut self.y]);
    }

    pub fn bytes(&self) -> usize {
        self.y.bytes() + self.solver.as_ref().map_or(0, |(_, s)| s.bytes())
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
        self.pool.fetch(&walls.layout, [&mut self.y]);
        let (mut c, h) = (Coefficients::new(law, dt), self.h);
        let kappa = c.beta / (h * h);
        let faces = Conductances::new(walls, kappa, dt / h);
        if faces.kappa < kappa {
            // The flux belongs to the operator: both or neither.
            c.gain *= faces.kappa / kappa;
        }
        let reference = T::of(faces.level(walls, walls.fluid_mean(&state.phi)));
        let stage = Stage { c, faces, reference, stretch };
        if let Some(q) = &mut state.slow_flux {
            walls.fill_seams(q);
        }
        let State { phi, slow_flux } = &mut *state;
        let slow = slow_flux.as_ref().map(|q| q.axes());
        let formula = Formula::new(walls, slow, source, &stage, h);
        let size = formula.size(walls, &faces, phi);
        if !size.is_finite() {
            return Err(culprit(walls, state, source));
        }
        self.ready(walls, &faces, dt)?;
        let Some((_, solver)) = &mut self.solver else { return Ok(Moved::default()) };
        // Never below the rounding floor of evaluating the right-hand side itself.
        let wanted = (self.tolerance.max(8.0 * T::EPSILON)) * size;
        let found = &mut self.found;
        solve(solver, &Formed { formula: &formula, phi }, &mut self.y, wanted, found)?;
        let (factor, statistics) = (found.factor, found.statistics);
        walls.fill_rim(&mut self.y);

        let noise = D as f64 * T::EPSILON * faces.largest;
        let outflow = if noise <= noise_limit::<T>() {
            self.rebuild(walls, phi, slow, &formula, &stage, factor)
        } else {
            self.keep(walls, phi, source, &formula, &stage, factor)
        };
        self.update_slow_flux(walls, state, &stage, factor);
        Ok(Moved { outflow, statistics })
    }

    /// q_C = w q* - v k_C Grad phi^, `stretch` times as far.
    fn update_slow_flux(&self, walls: &Walls<T, D>, state: &mut State<T, D>, stage: &Stage<T>, factor: f64) {
        let &Stage { c, reference, stretch, .. } = stage;
        let Some(q) = &mut state.slow_flux else { return };
        let (y, far) = (&self.y[..], reference.f64());
        let keep = 1.0 - stretch + stretch * c.keep;
        let gain = stretch * c.gain / self.h;
        update_flux(walls, q, y, keep, gain * factor);
        walls.each(|w| {
            if let Wall::Value(v) = w.wall {
                set_wall_flux(q.axis_mut(w.axis), w, factor * y[w.cell].f64() - (v - far), keep, gain);
            }
        });
        walls.fill_seams(q);
    }

    /// The solver for this step size, rebuilt when the size changes.
    fn ready(&mut self, walls: &Walls<T, D>, faces: &Conductances, dt: f64) -> Result<(), StepError> {
        if self.solver.as_ref().is_some_and(|&(of, _)| of == dt) {
            return Ok(());
        }
        self.solver = None;
        let conductances = walls.sides.map(|_, _, wall| faces.of(wall));
        let mut operator = Helmholtz::new(&walls.layout, 1.0, faces.kappa, conductances);
        if let Some(mask) = &walls.mask {
            operator = operator.with_mask(mask);
        }
        let options = Options {
            plan: self.plan,
            precision: self.precision,
            reduction: self.tolerance.clamp(1e-14, 0.1),
            ..Options::default()
        };
        let mut solver = Solver::new(&operator, options)?;
        solver.share(&self.pool);
        self.solver = Some((dt, solver));
        Ok(())
    }
}

/// A solve to max|r| <= `wanted`. The residual that the iteration carries along and the true one differ by rounding: a
/// solve that stopped a hair above its goal is asked for a little more.
fn solve<T: Real, const D: usize>(
    solver: &mut Solver<T, D>,
    rhs: &dyn RightHandSide<T, D>,
    y: &mut [T],
    wanted: f64,
    found: &mut Deviation,
) -> Result<(), SolveError> {
    const HAIR: f64 = 0.02;
    match solver.solve_deviation(rhs, y, Stop::Largest(wanted), found) {
        Err(SolveError::NotConverged { residual, .. }) if residual <= (1.0 + HAIR) * wanted => {
            solver.solve_deviation(rhs, y, Stop::Largest((1.0 - 2.0 * HAIR) * wanted), found)
        }
        done => done,
    }
}

/// Longest piece of a row that passes through a buffer on the stack.
pub(crate) const ROW: usize = 512;

/// A row in pieces of at most [`ROW`] cells.
#[inline(always)]
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

/// The gradient over the half cell at a wall with a value, `above` = phi - value, into the face's flux; `gain` in units of
/// q per phi. Low faces have already decayed with the cells' sweep.
pub(crate) fn set_wall_flux<T: Real>(q: &mut [T], w: WallCell, above: f64, keep: f64, gain: f64) {
    let gradient = -2.0 * above * w.end.sign();
    let old = if w.end == End::Low { q[w.face].f64() } else { keep * q[w.face].f64() };
    q[w.face] = T::of(old - gain * gradient);
}

/// Which input made the right-hand side something else than a number.
fn culprit<T: Real, const D: usize>(walls: &Walls<T, D>, state: &State<T, D>, source: Source<'_, T>) -> StepError {
    let slow = state.slow_flux.iter().flat_map(|q| q.axes()).map(|q| ("the slow flux", q));
    let first = |field, bad: &dyn Fn(usize) -> bool| walls.first(bad).map(|cell| (field, cell.to_vec()));
    let found = first("phi", &|slot| !state.phi[slot].is_finite())
        .or_else(|| source.rate.and_then(|rate| first("the source", &|slot| !rate.at(slot).is_finite())))
        .or_else(|| slow.filter_map(|(field, q)| first(field, &|slot| !q[slot].is_finite())).next());
    let (field, cell) = found.unwrap_or(("the right-hand side of the diffusion step", Vec::new()));
    StepError::NotFinite { field, cell }
}
