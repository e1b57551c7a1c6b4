//! One case: a box between walls, a law, a step, and states on it.

use cf_grid::{Axis, End, Grid, Mask, Real, Sides, Wall};

use super::Measured;
use super::random::Random;
use crate::{Diffusion, Integrator, Law, Medium, Settings, Source, State, StepReport, energy};

/// A box, its walls and obstacles, a law, the settings of a stepper and a step size.
#[derive(Debug, Clone, PartialEq)]
pub struct Case<const D: usize> {
    /// The box.
    pub grid: Grid<D>,
    /// Its walls.
    pub sides: Sides<Wall, D>,
    /// Its obstacles.
    pub mask: Option<Mask<D>>,
    /// The law.
    pub law: Law,
    /// The settings.
    pub settings: Settings,
    /// The step \[s\].
    pub dt: f64,
}

/// Which walls a random box may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kinds {
    /// Closed or periodic: mass stays.
    Closed,
    /// Closed, periodic or of value zero: energy never grows.
    Dissipative,
    /// All of them, inhomogeneous.
    Any,
}

impl<const D: usize> Case<D> {
    /// Closed walls, no obstacles, tight solves.
    pub fn new(cells: [usize; D], h: f64, law: Law, integrator: Integrator, dt: f64) -> Measured<Self> {
        let settings = Settings { integrator, tolerance: 1e-15, ..Settings::default() };
        Ok(Self { grid: Grid::new(cells, h)?, sides: Sides::all(Wall::CLOSED), mask: None, law, settings, dt })
    }

    /// A stepper for it.
    pub fn stepper<T: Real>(&self) -> Measured<Diffusion<T, D>> {
        Ok(Diffusion::new(&self.grid, &self.sides, self.mask.clone(), self.law, self.settings)?)
    }

    /// `steps` steps from `state` in a medium at rest; the last report with outflow and emission of all steps.
    pub fn run<T: Real>(&self, state: &mut State<T, D>, steps: usize) -> Measured<StepReport> {
        let mut stepper = self.stepper()?;
        let mut all = StepReport::default();
        for _ in 0..steps {
            let report = stepper.step(state, &Medium::Still, Source::NONE, self.dt)?;
            let (outflow, emitted) = (all.outflow + report.outflow, all.emitted + report.emitted);
            all = StepReport { outflow, emitted, iterations: all.iterations.max(report.iterations), ..report };
        }
        Ok(all)
    }

    /// Lyapunov energy E'.
    pub fn energy<T: Real>(&self, state: &State<T, D>) -> f64 {
        energy::lyapunov(&self.grid, &self.sides, &self.law, state)
    }

    /// Whether a cell is fluid.
    pub fn is_fluid(&self, slot: usize) -> bool {
        self.mask.as_ref().is_none_or(|m| m.fluid()[slot])
    }

    /// phi by cell.
    pub fn set_phi<T: Real>(&self, state: &mut State<T, D>, mut phi: impl FnMut([usize; D]) -> f64) {
        let layout = self.grid.layout();
        layout.each_cell(layout.cells_region(), |at| state.phi[at.slot()] = T::of(phi(at.cell)));
    }

    /// q_C on every face that holds one, by axis, cell above the face and the fluid cells beside it (low, high; `None` on a
    /// wall); periodic seams included.
    pub fn set_flux<T: Real>(
        &self,
        state: &mut State<T, D>,
        mut flux: impl FnMut(usize, [usize; D], [Option<usize>; 2]) -> f64,
    ) {
        let layout = *self.grid.layout();
        let Some(q) = &mut state.slow_flux else { return };
        for a in 0..D {
            let n = layout.cells()[a];
            let periodic = self.sides.is_periodic(a);
            let value = |end| matches!(self.sides.wall(a, end), Some(Wall::Value(_)));
            layout.each_cell(layout.faces_region(a, periodic), |at| {
                let [mut low, mut high] = [at.cell; 2];
                low[a] = if at.cell[a] == 0 { n - 1 } else { at.cell[a] - 1 };
                high[a] %= n;
                let wet = |cell| Some(layout.slot(cell)).filter(|&slot| self.is_fluid(slot));
                let (below, above) = (wet(low), wet(high));
                let beside = match at.cell[a] {
                    0 if !periodic => [None, above.filter(|_| value(End::Low))],
                    i if i == n => [below.filter(|_| value(End::High)), None],
                    _ => [below, above],
                };
                let on_wall = !periodic && (at.cell[a] == 0 || at.cell[a] == n);
                let count = beside.iter().flatten().count();
                if count == 2 || on_wall && count == 1 {
                    q.axis_mut(a)[at.slot()] = T::of(flux(a, at.cell, beside));
                }
            });
        }
    }

    /// q_C = `scale` Grad phi, with zero outside walls that have a value.
    pub fn set_gradient<T: Real>(&self, state: &mut State<T, D>, scale: f64) {
        let (phi, h) = (state.phi.clone(), self.grid.h());
        let at = |slot: usize| phi[slot].f64();
        self.set_flux(state, |_, _, beside| match beside {
            [Some(low), Some(high)] => scale * (at(high) - at(low)) / h,
            [None, Some(high)] => scale * 2.0 * at(high) / h,
            [Some(low), None] => scale * -2.0 * at(low) / h,
            [None, None] => 0.0,
        });
    }

    /// A state of random phi in ±`phi` and q_C in ±`flux`.
    pub fn random_state<T: Real>(&self, random: &mut Random, phi: f64, flux: f64) -> State<T, D> {
        let mut state = State::new(&self.grid, &self.law);
        self.set_phi(&mut state, |_| phi * random.between(-1.0, 1.0));
        self.set_flux(&mut state, |_, _, _| flux * random.between(-1.0, 1.0));
        state
    }

    /// The q_C that weighs as much in the energy as a phi of 1: sqrt(k/tau).
    pub fn flux_unit(&self) -> f64 {
        if self.law.has_memory() { (self.law.k() / self.law.tau()).sqrt() } else { 0.0 }
    }

    /// The largest that conducts: `kappa` between cells, twice that on walls with a value, c dt/h on absorbing ones \[1\].
    pub fn conductance(&self, kappa: f64) -> f64 {
        let walls = self.sides.walls().map(|(_, _, wall)| match wall {
            Wall::Value(_) => 2.0 * kappa,
            Wall::Absorbing { speed, .. } => speed * self.dt / self.grid.h(),
            Wall::Flux(_) | Wall::Open { .. } => 0.0,
        });
        walls.fold(kappa, f64::max)
    }

    /// What walls of a given flux let pass in a step, in or out [P m^D]: it may leave by other walls at once.
    pub fn passing(&self) -> f64 {
        let faces = |axis: usize| (self.grid.layout().count() / self.grid.cells()[axis]) as f64;
        let given = self.sides.walls().map(|(axis, _, wall)| match wall {
            Wall::Flux(g) => g.abs() * faces(axis),
            _ => 0.0,
        });
        self.dt * self.grid.cell_volume() / self.grid.h() * given.sum::<f64>()
    }

    /// A random box of up to `most` cells per axis with random walls and, one time in three, obstacles.
    pub fn random_box(&mut self, random: &mut Random, kinds: Kinds, most: usize) -> Measured<()> {
        let cells = std::array::from_fn(|_| 1 + random.below(most));
        self.grid = Grid::new(cells, self.grid.h())?;
        self.sides = Sides(std::array::from_fn(|_| match random.below(3) {
            0 => Axis::Periodic,
            _ => Axis::Walls(std::array::from_fn(|_| random_wall(random, kinds, self.flux_unit()))),
        }));
        let solid = random.between(0.05, 0.6);
        self.mask = random.chance(1.0 / 3.0).then(|| {
            let flags: Vec<bool> = (0..self.grid.layout().slots()).map(|_| !random.chance(solid)).collect();
            Mask::new(self.grid.layout(), |cell| flags[self.grid.layout().slot(cell)])
        });
        Ok(())
    }
}

fn random_wall(random: &mut Random, kinds: Kinds, speed: f64) -> Wall {
    let any = [0, 1, 2, 3, 4, 5];
    match (kinds, random.pick(any)) {
        (Kinds::Closed, _) => Wall::CLOSED,
        (Kinds::Dissipative, i) => {
            if i < 3 {
                Wall::CLOSED
            } else {
                Wall::Value(0.0)
            }
        }
        (Kinds::Any, 0) => Wall::CLOSED,
        (Kinds::Any, 1) => Wall::Flux(0.1 * speed * random.between(-1.0, 1.0)),
        (Kinds::Any, 2) => Wall::Value(random.between(-1.0, 1.0)),
        (Kinds::Any, 3) => Wall::Open { inflow: random.between(-1.0, 1.0) },
        (Kinds::Any, 4) => Wall::Absorbing { speed: speed * random.between(0.0, 2.0), far: random.between(-1.0, 1.0) },
        (Kinds::Any, _) => Wall::Value(0.0),
    }
}
