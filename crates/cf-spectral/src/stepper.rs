//! The step: to the modes, one exact propagator each, and back.

use cf_diffusion::exact::{modes, source};
use cf_diffusion::{Law, Medium, Source, State, StepReport};
use cf_grid::{End, Grid, Real, Sides, Wall};

use crate::cells;
use crate::error::SpectralError;
use crate::modes::Modes;
use crate::shift::Shift;
use crate::transform::{Direction, Of};

/// A stepper on one box without error in time; see the [crate](crate).
pub struct Spectral<const D: usize> {
    grid: Grid<D>,
    sides: Sides<Wall, D>,
    law: Law,
    modes: Modes<D>,
    /// Modes of the steady state that walls with values ask for; `None` if they are all 0.
    rest: Option<Vec<f64>>,
    phi: Vec<f64>,
    flux: Vec<f64>,
    work: Vec<f64>,
    shifts: [Option<Shift>; D],
}

impl<const D: usize> Spectral<D> {
    /// A stepper for `law` on `grid` between `sides`, with its transforms planned and its three arrays of f64 made.
    ///
    /// # Errors
    /// Walls other than closed ones and finite values.
    pub fn new(grid: &Grid<D>, sides: &Sides<Wall, D>, law: Law) -> Result<Self, SpectralError> {
        let modes = Modes::new(grid, sides, Of::Cells)?;
        let zeros = vec![0.0; modes.count()];
        let mut made = Self {
            grid: *grid,
            sides: *sides,
            law,
            modes,
            rest: None,
            phi: zeros.clone(),
            flux: zeros.clone(),
            work: zeros,
            shifts: std::array::from_fn(|_| None),
        };
        made.rest = made.steady_state();
        Ok(made)
    }

    /// The law.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The walls.
    pub fn sides(&self) -> &Sides<Wall, D> {
        &self.sides
    }

    /// Bytes of scratch.
    pub fn bytes(&self) -> usize {
        (3 + usize::from(self.rest.is_some())) * self.phi.len() * size_of::<f64>()
    }

    /// −∇²_h φ_s = 2 Σ v/h² at the walls, by modes.
    fn steady_state(&mut self) -> Option<Vec<f64>> {
        let valued = |wall| if let Some(Wall::Value(v)) = wall { v } else { 0.0 };
        let values = [0, 1].map(|e| std::array::from_fn(|a| valued(self.sides.wall(a, End::BOTH[e]))));
        let [low, high]: [[f64; D]; 2] = values;
        if low.iter().chain(&high).all(|&v| v == 0.0) {
            return None;
        }
        let (layout, n, h) = (self.grid.layout(), self.grid.cells(), self.grid.h());
        let mut pull = cf_grid::CellField::<f64>::new(layout);
        layout.par_cells(&mut pull, |at| {
            let beside = |a: usize| {
                let low = if at.cell[a] == 0 { low[a] } else { 0.0 };
                low + if at.cell[a] + 1 == n[a] { high[a] } else { 0.0 }
            };
            (0..D).map(beside).sum::<f64>() * 2.0 / h / h
        });
        let mut rest = vec![0.0; self.modes.count()];
        cells::take(&self.grid, |slot| pull[slot], &mut rest);
        self.modes.transform(Direction::There, &mut rest, &mut self.work);
        self.modes.each(&mut rest, &mut self.work, |_, lambda, rest, _| *rest /= lambda);
        Some(rest)
    }

    /// Advances `state` by `dt` \[s\], of any size, in `medium`, with W of `source` constant over the step. `dt` = 0
    /// changes nothing.
    ///
    /// The report gives what left through walls with values and what the source emitted.
    ///
    /// # Errors
    /// Media with a velocity on every face, or that cross a wall; sources in moving media; fields of another layout or
    /// law; steps that are not finite and >= 0; values that are not finite.
    pub fn step<T: Real>(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        source: Source<'_, T>,
        dt: f64,
    ) -> Result<StepReport, SpectralError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(SpectralError::TimeStep(dt));
        }
        self.check(state, source)?;
        let velocity = self.velocity(medium)?;
        let moving = velocity.iter().any(|&u| u != 0.0);
        if moving && source.rate.is_some() {
            return Err(SpectralError::MovingSource);
        }
        if dt == 0.0 {
            return Ok(StepReport::default());
        }
        let layout = *self.grid.layout();
        let before = layout.sum(&state.phi);
        self.diffuse(state, source, dt);
        if moving {
            self.carry(state, velocity.map(|u| u * dt / self.grid.h()));
        }
        let gained = layout.sum(&state.phi) - before;
        if !gained.is_finite() {
            return Err(SpectralError::NotFinite);
        }
        let volume = self.grid.cell_volume();
        let emitted = source.rate.map_or(0.0, |rate| source.share * dt * rate.sum(&layout, |_| true)) * volume;
        let holds = self.sides.walls().all(|(.., wall)| wall == Wall::CLOSED);
        let outflow = if holds { 0.0 } else { emitted - gained * volume };
        Ok(StepReport { outflow, emitted, ..StepReport::default() })
    }

    fn check<T: Real>(&self, state: &State<T, D>, source: Source<'_, T>) -> Result<(), SpectralError> {
        if state.slow_flux.is_some() != self.law.has_memory() {
            return Err(SpectralError::SlowFlux { found: state.slow_flux.is_some() });
        }
        let expected = self.grid.layout().slots();
        let flux = state.slow_flux.iter().flat_map(|q| q.axes()).map(|q| ("the slow flux", q.len()));
        let rate = source.rate.iter().map(|rate| ("the source", rate.reach(expected)));
        match flux.chain(rate).chain([("phi", state.phi.len())]).find(|&(_, found)| found != expected) {
            Some((what, found)) => Err(SpectralError::Layout { what, expected, found }),
            None => Ok(()),
        }
    }

    fn velocity<T>(&self, medium: &Medium<T, D>) -> Result<[f64; D], SpectralError> {
        let velocity: [f64; D] = match medium {
            Medium::Still => [0.0; D],
            Medium::Uniform(u) => std::array::from_fn(|a| u[a]),
            Medium::Field(_) => return Err(SpectralError::Field),
        };
        let wrong = |&(axis, &u): &(usize, &f64)| !u.is_finite() || u != 0.0 && !self.sides.is_periodic(axis);
        match velocity.iter().enumerate().find(wrong) {
            Some((axis, &velocity)) => Err(SpectralError::Velocity { axis, velocity }),
            None => Ok(velocity),
        }
    }

    /// The step in a medium at rest. With ψ the potential of the part of q_C that is a gradient, ∇²ψ = D,
    /// q_C ← e^{−dt/τ} q_C + ∇(ψ' − e^{−dt/τ} ψ), and D alone needs the modes.
    fn diffuse<T: Real>(&mut self, state: &mut State<T, D>, source: Source<'_, T>, dt: f64) {
        let Self { grid, sides, law, modes: box_modes, rest, phi, flux, work, .. } = self;
        let memory = law.has_memory();
        let (keep, lost) = if memory { ((-dt / law.tau()).exp(), -(-dt / law.tau()).exp_m1()) } else { (0.0, 1.0) };
        cells::take(grid, |slot| state.phi[slot], phi);
        box_modes.transform(Direction::There, phi, work);
        match &state.slow_flux {
            Some(q) => {
                cells::divergence(grid, sides, q, flux);
                box_modes.transform(Direction::There, flux, work);
            }
            None => flux.fill(0.0),
        }
        let emitted = source.rate.map(|rate| {
            let mut emitted = vec![0.0; phi.len()];
            cells::take(grid, |slot| rate.at(slot), &mut emitted);
            box_modes.transform(Direction::There, &mut emitted, work);
            emitted
        });
        box_modes.each(phi, flux, |i, lambda, phi, flux| {
            let rest = rest.as_ref().map_or(0.0, |rest| rest[i]);
            // A uniform field has no divergence; rounding must not make it gain mass.
            let before = if lambda == 0.0 { 0.0 } else { *flux };
            let mut after = modes::evolve(law, lambda, dt, [*phi - rest, before]);
            if let Some(emitted) = &emitted {
                let [value, divergence] = source::still(law, lambda, dt);
                after[0] += source.share * emitted[i] * value;
                after[1] += source.share * emitted[i] * divergence;
            }
            *phi = after[0] + rest;
            *flux = if lambda == 0.0 { 0.0 } else { -(after[1] - keep * before) / lambda };
            *flux -= lost * law.k_cattaneo() * rest;
        });
        box_modes.transform(Direction::Back, phi, work);
        cells::put(grid, phi, &mut state.phi);
        if let Some(q) = &mut state.slow_flux {
            box_modes.transform(Direction::Back, flux, work);
            cells::add_gradient(grid, sides, keep, flux, |v| -lost * law.k_cattaneo() * v, q);
        }
    }

    /// Moves phi and q_C by `distance` \[cells\] per axis.
    fn carry<T: Real>(&mut self, state: &mut State<T, D>, distance: [f64; D]) {
        let layout = *self.grid.layout();
        for axis in (0..D).filter(|&a| distance[a] != 0.0) {
            let shift = self.shifts[axis].get_or_insert_with(|| Shift::new(axis, layout.cells()[axis]));
            shift.apply(&layout, layout.cells_region(), distance[axis], &mut state.phi);
            for (a, q) in state.slow_flux.iter_mut().flat_map(|q| q.axes_mut()).enumerate() {
                let region = layout.faces_region(a, self.sides.is_periodic(a));
                shift.apply(&layout, region, distance[axis], q);
            }
        }
    }
}
