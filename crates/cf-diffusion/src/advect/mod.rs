//! Transport of φ and q_C by the moving medium (paper eqs 11 and 12).
//!
//! ```text
//!     φ_t + div(u φ) = 0          cells; conservative
//!     q_t + u·grad q = 0          q_C, component by component on the faces; bounded
//! ```
//!
//! [`Advection::Muscl`] moves what crosses each face: mass is kept to round-off for any velocity. The semi-Lagrangian
//! methods fetch every value from the foot of its trajectory: bounded by the old values for any step, but they neither
//! keep the mass nor see div u.
//!
//! At walls the medium carries in what [`Wall::carried_in`] says, and q_C = 0; it carries out what arrives there. Through a
//! [`Wall::Flux`] it must not pass. A face on a `Value` wall stores q_C and is moved with the velocities of the one cell
//! beside it; faces on other walls and on solids store none and stay zero.

mod error;
mod flow;
mod kernel;
mod muscl;
mod sample;
mod semi_lagrangian;
mod sites;
mod sweep;
#[cfg(test)]
mod tests;
mod trace;

use cf_grid::{CellField, FaceField, Grid, Mask, Pool, Real, Sides, Wall};

pub use error::AdvectError;

use crate::medium::{Medium, Survey};
use flow::{Flow, Stream};
use muscl::Form;
use sites::Sites;
use sweep::{Dilatation, Sweep};

/// How φ and q_C are carried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Advection {
    /// Flux-form MUSCL with the MC limiter, split by dimension, order XY(Z) and (Z)YX in turn. Second order, conservative,
    /// no new extrema in one dimension; sub-steps by itself above |u_a| Δt/h = 0.9 (1 in a uniform medium, an exact
    /// shift there).
    #[default]
    Muscl,
    /// Cubic semi-Lagrangian, midpoint trajectories, clamped to the values around the foot. Any step; not conservative.
    Cubic,
    /// Linear semi-Lagrangian, first order: for drafts.
    Linear,
}

/// What a step of transport did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Transported {
    /// ∫ φ that left through the walls \[P m^D\], negative where more came in. With [`Advection::Muscl`] exactly the sum of
    /// the wall fluxes, so that ∫φ before = ∫φ after + outflow to round-off. The semi-Lagrangian methods have no fluxes; for
    /// them it is the upwind flux Δt u φ through the walls at the start of the step, an estimate.
    pub outflow: f64,
    /// Equal sub-steps taken; 0 where nothing moved.
    pub substeps: usize,
}

/// Carries φ \[P\] and q_C \[P m/s\] on one grid.
///
/// Owns all storage a step needs, or [shares](Self::share) it: one cell-sized array from the first step, a second one from the
/// first conservative step in 3D whose velocity varies, and two flags per cell from the first that diverges strongly.
#[derive(Debug, Clone)]
pub struct Advector<T, const D: usize> {
    grid: Grid<D>,
    sides: Sides<Wall, D>,
    method: Advection,
    mask: Option<Mask<D>>,
    cells: Sites<D>,
    faces: [Sites<D>; D],
    work: CellField<T>,
    /// Empty where it is not needed.
    second: CellField<T>,
    pool: Pool<T>,
    /// Flags of strongly divergent cells, and of these with their neighbours, by slot; empty until there are some.
    divergent: [Vec<bool>; 2],
    reversed: bool,
}

impl<T: Real, const D: usize> Advector<T, D> {
    /// Largest |u_a| Δt/h of a conservative sub-step in a medium whose velocity varies; 1 in a uniform one, where the
    /// transport is then an exact shift.
    pub const COURANT: f64 = 0.9;
    /// Largest change of u_a Δt/h across a cell in a conservative sub-step; only met by flow that converges or shears
    /// on the scale of a cell.
    pub const CHANGE: f64 = 0.5;
    /// Most conservative sub-steps per call.
    pub const SUBSTEPS: usize = 10_000;

    /// Storage for transport on `grid` between `sides`, around the solids of `mask`.
    pub fn new(grid: &Grid<D>, sides: &Sides<Wall, D>, mask: Option<&Mask<D>>, method: Advection) -> Self {
        let layout = grid.layout();
        Self {
            grid: *grid,
            sides: *sides,
            method,
            mask: mask.cloned(),
            cells: Sites::cells(layout, sides),
            faces: std::array::from_fn(|a| Sites::faces(layout, sides, a)),
            work: CellField::default(),
            second: CellField::default(),
            pool: Pool::default(),
            divergent: [Vec::new(), Vec::new()],
            reversed: false,
        }
    }

    /// From now on scratch comes from `pool` and goes back to it within each call.
    pub fn share(&mut self, pool: &Pool<T>) {
        self.pool = pool.clone();
        (self.work, self.second) = Default::default();
    }

    /// Bytes of storage held now, without what is in a shared pool.
    pub fn bytes(&self) -> usize {
        let mask = self.mask.as_ref().map_or(0, |m| m.fluid().len());
        self.work.bytes() + self.second.bytes() + mask + 2 * self.divergent[0].len()
    }

    /// Whether the next conservative sub-step sweeps the last axis first. Part of the state: a resumed run sets it with
    /// [`set_reversed`](Self::set_reversed).
    pub fn reversed(&self) -> bool {
        self.reversed
    }

    /// Sets the order of the next conservative sub-step.
    pub fn set_reversed(&mut self, reversed: bool) {
        self.reversed = reversed;
    }

    /// Longest step \[s\] without sub-steps: |u_a| Δt/h ≤ 0.9 (1 if uniform) on every axis, and a change of u_a Δt/h across a cell of at
    /// most 0.5. `None` where any step is stable: semi-Lagrangian methods, a medium at rest, a refused medium.
    pub fn stable_dt(&self, medium: &Medium<T, D>) -> Option<f64> {
        let survey = medium.survey(&self.grid, &self.sides).ok()?;
        let per_second = self.rate(&survey);
        (self.method == Advection::Muscl && per_second > 0.0).then(|| 1.0 / per_second)
    }

    /// Sub-steps per second \[1/s\] the limits ask for.
    fn rate(&self, survey: &Survey<D>) -> f64 {
        let largest = |v: [f64; D]| v.into_iter().fold(0.0, f64::max);
        let (speed, change) = (largest(survey.speed), largest(survey.change));
        let courant = if survey.uniform { 1.0 } else { Self::COURANT };
        (speed / courant).max(change / Self::CHANGE) / self.grid.h()
    }

    /// Carries `phi` and, if given, the slow flux over `dt` ≥ 0 \[s\]. Values in the rim and on faces without flux are left
    /// alone. A medium at rest, or `dt` = 0, changes nothing at all.
    ///
    /// # Errors
    /// Refuses steps and velocities that are not finite, a medium that crosses a [`Wall::Flux`], fields of another layout,
    /// and more than [`SUBSTEPS`](Self::SUBSTEPS) conservative sub-steps; the fields are unchanged then.
    pub fn advect(
        &mut self,
        phi: &mut CellField<T>,
        mut slow_flux: Option<&mut FaceField<T, D>>,
        medium: &Medium<T, D>,
        dt: f64,
    ) -> Result<Transported, AdvectError> {
        let slots = self.grid.layout().slots();
        let flux_slots = slow_flux.iter().flat_map(|q| q.axes()).map(|q| q.len());
        if let Some(found) = flux_slots.chain([phi.len()]).find(|&n| n != slots) {
            return Err(AdvectError::Layout { expected: slots, found });
        }
        if !(dt >= 0.0 && dt.is_finite()) {
            return Err(AdvectError::Step { dt });
        }
        let survey = medium.survey(&self.grid, &self.sides)?;
        let moving: [bool; D] = std::array::from_fn(|a| survey.speed[a] * dt > 0.0 && !self.rounded_to_rest(a, medium));
        if !moving.contains(&true) {
            return Ok(Transported::default());
        }
        let substeps = self.substeps(&survey, dt)?;
        let step = dt / substeps as f64;
        let ratio = step / self.grid.h();
        let flow = match medium {
            Medium::Still => return Ok(Transported::default()),
            Medium::Uniform(u) => {
                Flow::Uniform(std::array::from_fn(|a| T::of(if moving[a] { u[a] * ratio } else { 0.0 })))
            }
            Medium::Field(u) => Flow::Field { u, ratio: T::of(ratio) },
        };
        if matches!(flow, Flow::Field { ratio, .. } if !ratio.is_finite()) {
            return Err(AdvectError::Step { dt });
        }
        let stream = Stream { flow, fluid: self.mask.as_ref().map(Mask::fluid) };
        let mut flags = std::mem::take(&mut self.divergent);
        let divergent = match self.method {
            Advection::Muscl => muscl::divergent_cells(&self.cells, &stream, moving, &mut flags),
            Advection::Cubic | Advection::Linear => None,
        };
        let mut outflow = 0.0;
        self.pool.fetch(self.grid.layout(), [&mut self.work]);
        for _ in 0..substeps {
            outflow += match self.method {
                Advection::Muscl => self.muscl(phi, slow_flux.as_deref_mut(), flow, moving, divergent),
                Advection::Cubic => self.fetch::<4>(phi, slow_flux.as_deref_mut(), medium, flow, ratio),
                Advection::Linear => self.fetch::<2>(phi, slow_flux.as_deref_mut(), medium, flow, ratio),
            };
        }
        self.pool.release([&mut self.work, &mut self.second]);
        self.divergent = flags;
        Ok(Transported { outflow: outflow * self.grid.cell_volume(), substeps })
    }

    /// A uniform velocity into a closed wall that [`Medium::check`] lets pass is a rounding error.
    fn rounded_to_rest(&self, axis: usize, medium: &Medium<T, D>) -> bool {
        matches!(medium, Medium::Uniform(_))
            && self.sides.walls().any(|(a, _, wall)| a == axis && wall.carried_in().is_none())
    }

    fn substeps(&self, survey: &Survey<D>, dt: f64) -> Result<usize, AdvectError> {
        if self.method != Advection::Muscl {
            return Ok(1);
        }
        let substeps = (self.rate(survey) * dt * (1.0 - 1e-12)).ceil().max(1.0);
        if substeps <= Self::SUBSTEPS as f64 {
            return Ok(substeps as usize);
        }
        let courant = survey.speed.into_iter().fold(0.0, f64::max) * dt / self.grid.h();
        Err(AdvectError::TooManySubsteps { dt, courant, substeps, limit: Self::SUBSTEPS })
    }

    fn muscl(
        &mut self,
        phi: &mut [T],
        slow_flux: Option<&mut FaceField<T, D>>,
        flow: Flow<'_, T, D>,
        moving: [bool; D],
        divergent: Option<&[bool]>,
    ) -> f64 {
        let mut order = [0; D];
        let mut axes = 0;
        for i in 0..D {
            let axis = if self.reversed { D - 1 - i } else { i };
            if moving[axis] {
                order[axes] = axis;
                axes += 1;
            }
        }
        let order = &order[..axes];
        self.reversed = !self.reversed;
        let fluid = self.mask.as_ref().map(Mask::fluid);
        let stream = Stream { flow, fluid };
        if axes == 3 && (fluid.is_some() || matches!(flow, Flow::Field { .. })) {
            self.pool.fetch(self.grid.layout(), [&mut self.second]);
        }
        let form = (Form::Conservative, divergent);
        let outflow = muscl::step(&self.cells, stream, form, order, phi, (&mut self.work, &mut self.second));
        if let Some(q) = slow_flux {
            for a in 0..D {
                let form = (Form::Advective, None);
                muscl::step(&self.faces[a], stream, form, order, q.axis_mut(a), (&mut self.work, &mut []));
            }
        }
        outflow
    }

    fn fetch<const K: usize>(
        &mut self,
        phi: &mut [T],
        slow_flux: Option<&mut FaceField<T, D>>,
        medium: &Medium<T, D>,
        flow: Flow<'_, T, D>,
        ratio: f64,
    ) -> f64 {
        let fluid = self.mask.as_ref().map(Mask::fluid);
        let stream = Stream { flow, fluid };
        let through = |axis| {
            Sweep { sites: &self.cells, stream, axis, dilatation: Dilatation::Absent, divergent: None }.outflow(phi)
        };
        let outflow = (0..D).map(through).sum();
        semi_lagrangian::step::<T, D, K>(&self.cells, medium, fluid, ratio, phi, &mut self.work);
        if let Some(q) = slow_flux {
            for a in 0..D {
                semi_lagrangian::step::<T, D, K>(&self.faces[a], medium, fluid, ratio, q.axis_mut(a), &mut self.work);
            }
        }
        outflow
    }
}
