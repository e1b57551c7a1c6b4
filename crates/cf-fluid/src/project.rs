//! The projection onto velocities without divergence.
//!
//! Lap_h s = div u*, u = u* - grad s, with faces open between fluid cells only. The residual of this solve is the
//! divergence that remains, so that the solve stops on it directly, and it is measured again on the velocity itself.

use cf_grid::{CellField, FaceField, Grid, Mask, Pool, Real, Sides};
use cf_linear::{Choice, Deviation, Helmholtz, Options, Plan, Precision, Solver, Stop};

use crate::calculus::{NegativeDivergence, max_speed, subtract_gradient};
use crate::error::FlowError;
use crate::gates::{Gates, Held};
use crate::wall::{self, FlowWall};

/// What a projection did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Projected {
    /// Solver iterations.
    pub iterations: usize,
    /// max|div u| dt afterwards, measured on the velocity, without [`imbalance`](Self::imbalance).
    pub divergence: f64,
    /// Largest mean of div u \[1/s\] over a part of the fluid that no open wall touches: what is held at its inflow does
    /// not balance, and no pressure can help. 0 where it balances to round-off.
    pub imbalance: f64,
    /// The divergence is above the tolerance, but at the rounding floor of the precision.
    pub at_floor: bool,
}

/// Projects velocities of one domain. The velocity is exact on closed faces for any tolerance.
pub struct Projection<T, const D: usize> {
    grid: Grid<D>,
    gates: Gates<D>,
    mask: Option<Mask<D>>,
    solver: Solver<T, D>,
    solved: Deviation,
    precision: Precision,
    step: CellField<T>,
    pool: Pool<T>,
}

/// Solves with the residual of the last one as right-hand side, before rounding is taken for the floor.
const PASSES: usize = 4;
/// Share of the tolerance asked of the solver; the rest is for the rounding of the velocity.
const SHARE: f64 = 0.9;

impl<T: Real, const D: usize> Projection<T, D> {
    /// A projection on `grid` between `sides`, around the solids of `mask`.
    pub fn new(
        grid: &Grid<D>,
        sides: &Sides<FlowWall<D>, D>,
        mask: Option<&Mask<D>>,
        precision: Precision,
    ) -> Result<Self, FlowError> {
        wall::check(sides)?;
        let layout = grid.layout();
        if let Some(mask) = mask.filter(|m| m.layout() != layout) {
            let (expected, found) = (layout.slots(), mask.layout().slots());
            return Err(FlowError::Layout { what: "the mask", expected, found });
        }
        let gates = Gates::new(layout, sides, mask, Vec::new());
        Ok(Self {
            grid: *grid,
            solver: solver(grid, &gates, mask, precision)?,
            solved: Deviation::default(),
            gates,
            mask: mask.cloned(),
            precision,
            step: CellField::default(),
            pool: Pool::default(),
        })
    }

    /// Replaces the faces that hold a velocity of their own.
    pub(crate) fn hold(&mut self, held: Vec<Held>) -> Result<(), FlowError> {
        if held == self.gates.held() {
            return Ok(());
        }
        let gates = Gates::new(self.grid.layout(), self.gates.sides(), self.mask.as_ref(), held);
        self.solver = solver(&self.grid, &gates, self.mask.as_ref(), self.precision)?;
        self.solver.share(&self.pool);
        self.gates = gates;
        Ok(())
    }

    /// The walls.
    pub fn sides(&self) -> &Sides<FlowWall<D>, D> {
        self.gates.sides()
    }

    /// The obstacles.
    pub fn mask(&self) -> Option<&Mask<D>> {
        self.mask.as_ref()
    }

    /// From now on scratch comes from `pool`; [`release`](Self::release) gives it back.
    pub(crate) fn share(&mut self, pool: &Pool<T>) {
        self.pool = pool.clone();
        self.solver.share(pool);
        self.step = CellField::default();
    }

    /// Where scratch comes from.
    pub(crate) fn pool(&self) -> &Pool<T> {
        &self.pool
    }

    /// Gives scratch back to the pool.
    pub(crate) fn release(&mut self) {
        self.pool.release([&mut self.step]);
    }

    /// The solver's plan, and its levels.
    pub fn choice(&self) -> (&Choice, usize) {
        (self.solver.choice(), self.solver.levels())
    }

    /// Bytes held, without what is in a shared pool.
    pub fn bytes(&self) -> usize {
        let mask = self.mask.as_ref().map_or(0, |m| m.fluid().len());
        self.step.bytes() + self.solver.bytes() + self.gates.bytes() + mask
    }

    /// Sets every closed face of `u` to the velocity it holds.
    pub fn impose(&self, u: &mut FaceField<T, D>) {
        self.gates.impose(u);
    }

    /// u -= factor · grad s, on open faces only. `s` \[m/s h\] with the rim as [`project`](Self::project) leaves it.
    pub fn subtract_gradient(&self, factor: f64, s: &CellField<T>, u: &mut FaceField<T, D>) {
        subtract_gradient(self.grid.layout(), &self.gates, factor, s, u);
    }

    /// max|div u| \[1/s\] over fluid cells; NaN if any velocity is not a number.
    pub fn divergence(&self, u: &mut FaceField<T, D>) -> f64 {
        let (layout, fluid) = (self.grid.layout(), self.mask.as_ref().map(Mask::fluid));
        NegativeDivergence::new(layout, &self.gates, fluid, u).largest(layout) / self.grid.h()
    }

    /// Sets closed faces, then makes max|div u| dt <= eta. `potential` holds a guess of s \[m/s h\] and gets s; zeros are a
    /// valid guess.
    ///
    /// # Errors
    /// A step that is not finite and >= 0, fields of another layout, velocities that are not finite, and a solve that
    /// does not converge.
    pub fn project(
        &mut self,
        u: &mut FaceField<T, D>,
        potential: &mut CellField<T>,
        dt: f64,
        eta: f64,
    ) -> Result<Projected, FlowError> {
        self.check(u, potential, dt, eta)?;
        self.gates.impose(u);
        subtract_gradient(self.grid.layout(), &self.gates, 1.0, potential, u);
        self.remove(u, potential, 1.0, dt, eta)
    }

    /// [`project`](Self::project) from no guess; `sum` gets factor · s on top of what it holds.
    pub(crate) fn project_onto(
        &mut self,
        u: &mut FaceField<T, D>,
        sum: &mut CellField<T>,
        factor: f64,
        dt: f64,
        eta: f64,
    ) -> Result<Projected, FlowError> {
        self.check(u, sum, dt, eta)?;
        self.gates.impose(u);
        self.remove(u, sum, factor, dt, eta)
    }

    fn check(&self, u: &FaceField<T, D>, potential: &CellField<T>, dt: f64, eta: f64) -> Result<(), FlowError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(FlowError::TimeStep(dt));
        }
        if !(eta > 0.0 && eta.is_finite()) {
            return Err(FlowError::Setting { name: "eta_div", found: eta, expected: "a finite number above 0" });
        }
        let (lengths, expected) = (u.axes().map(<[T]>::len), self.grid.layout().slots());
        match lengths.into_iter().chain([potential.len()]).find(|&n| n != expected) {
            Some(found) => Err(FlowError::Layout { what: "a projected field", expected, found }),
            None => Ok(()),
        }
    }

    /// Removes the divergence that is left in u; sum += factor · s.
    fn remove(
        &mut self,
        u: &mut FaceField<T, D>,
        sum: &mut CellField<T>,
        factor: f64,
        dt: f64,
        eta: f64,
    ) -> Result<Projected, FlowError> {
        let layout = *self.grid.layout();
        let scale = T::of(factor);
        self.pool.fetch(&layout, [&mut self.step]);
        let fluid = self.mask.as_ref().map(Mask::fluid);
        let (h, mut done) = (self.grid.h(), Projected::default());
        // In the units of Σ (u_R - u_L). Without a step nothing is moved by what remains: the rounding floor decides.
        let wanted = (eta * h / dt).min(f64::MAX.sqrt());
        // The means that are left out, and with them what the solve has left beside them: the largest of all divergence cannot tell.
        let (mut removed, mut beside) = (0.0, 0.0);
        for pass in 0..=PASSES {
            let rhs = NegativeDivergence::new(&layout, &self.gates, fluid, u);
            let largest = rhs.largest(&layout);
            if !largest.is_finite() {
                return Err(self.not_finite(u));
            }
            let left = (largest - removed).max(beside);
            done.divergence = left * dt / h;
            if left <= wanted || pass == PASSES || done.at_floor {
                done.at_floor = left > wanted;
                break;
            }
            let solved = &mut self.solved;
            self.solver.solve_deviation(&rhs, &mut self.step, Stop::Largest(SHARE * wanted), solved)?;
            self.solver.finish(&mut self.step, solved);
            done.iterations += solved.statistics.iterations;
            done.at_floor = solved.statistics.at_floor && pass > 0;
            let mean = solved.removed.iter().fold(0f64, |m, r| m.max(r.abs()));
            // Rounding makes means of the size of eps |u|; more is an imbalance.
            if pass == 0
                && mean > 64.0 * T::EPSILON * largest
                && mean > 64.0 * T::EPSILON * max_speed(&layout, self.gates.sides(), u)
            {
                removed = mean;
                done.imbalance = mean / h;
            }
            beside = if removed > 0.0 { solved.statistics.largest } else { 0.0 };
            subtract_gradient(&layout, &self.gates, 1.0, &self.step, u);
            let step = &self.step;
            layout.par_runs(layout.cells_region(), &mut sum[..], |run, s: &mut [T]| {
                for (s, &step) in s.iter_mut().zip(run.row(step)) {
                    *s += scale * step;
                }
            });
            for a in (0..D).filter(|&a| self.gates.sides().is_periodic(a)) {
                layout.wrap_rim(a, sum);
            }
        }
        Ok(done)
    }

    fn not_finite(&self, u: &FaceField<T, D>) -> FlowError {
        let layout = self.grid.layout();
        let mut found = FlowError::NotFinite { axis: 0, cell: Vec::new() };
        for a in (0..D).rev() {
            layout.each_cell(layout.faces_region(a, self.sides().is_periodic(a)), |at| {
                if !u.axis(a)[at.slot()].is_finite() {
                    found = FlowError::NotFinite { axis: a, cell: at.cell.to_vec() };
                }
            });
        }
        found
    }
}

fn solver<T: Real, const D: usize>(
    grid: &Grid<D>,
    gates: &Gates<D>,
    mask: Option<&Mask<D>>,
    precision: Precision,
) -> Result<Solver<T, D>, FlowError> {
    let walls = gates.sides().map(|_, _, wall| wall.conductance());
    let mut operator = Helmholtz::new(grid.layout(), 0.0, 1.0, walls);
    if let Some(mask) = mask {
        operator = operator.with_mask(mask);
    }
    let shares = gates.shares();
    if let Some(shares) = &shares {
        operator = operator.with_shares(shares);
    }
    Ok(Solver::new(&operator, Options { plan: Some(Plan::Multigrid), precision, ..Options::default() })?)
}
