//! What can be asked of a flow between steps.

use cf_diffusion::Medium;
use cf_grid::{CellField, FaceField, Grid, Mask, Max, Real, Sides};

use crate::calculus::{kinetic_energy, max_speed, net_outflow};
use crate::fluid::Fluid;
use crate::project::Projection;
use crate::settings::FlowSettings;
use crate::wall::FlowWall;

impl<T: Real, const D: usize> Fluid<T, D> {
    /// p/rho \[m²/s²\] at a cell slot; `None` for schemes that do not keep it.
    pub fn pressure(&self, slot: usize) -> Option<f64> {
        self.pressure.as_ref().map(|p| p[slot].f64() * self.grid.h())
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The walls.
    pub fn sides(&self) -> &Sides<FlowWall<D>, D> {
        self.projection.sides()
    }

    /// The obstacles.
    pub fn mask(&self) -> Option<&Mask<D>> {
        self.projection.mask()
    }

    /// The settings.
    pub fn settings(&self) -> &FlowSettings<D> {
        &self.settings
    }

    /// The projection, for its plan.
    pub fn projection(&self) -> &Projection<T, D> {
        &self.projection
    }

    /// Time of u \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Sets the time \[s\], which only emitters read.
    pub fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// max|u_a| \[m/s\].
    pub fn max_speed(&self) -> f64 {
        max_speed(self.grid.layout(), self.sides(), self.velocity())
    }

    /// max|div u| \[1/s\].
    pub fn divergence(&mut self) -> f64 {
        self.give_back();
        self.projection.divergence(&mut self.u)
    }

    /// ∫ u²/2 \[m^(D+2)/s²\].
    pub fn kinetic_energy(&self) -> f64 {
        kinetic_energy(&self.grid, self.sides(), self.velocity())
    }

    /// Volume that leaves through the walls per second \[m^D/s\].
    pub fn net_outflow(&self) -> f64 {
        net_outflow(&self.grid, self.sides(), self.velocity())
    }

    /// The step \[s\] of CFL_u = `cfl`, also for the speeds of jets and inflows that act now; infinite at rest.
    pub fn dt_for(&self, cfl: f64) -> f64 {
        let walls = self.sides().walls().filter_map(|(_, _, w)| w.carried_in()).flatten();
        let jets = self.emitters.iter().filter(|(e, _)| e.share(self.time, 0.0) > 0.0);
        let jets = jets.flat_map(|(_, faces)| faces.iter().map(|f| f.velocity));
        let speed = walls.chain(jets).fold(self.max_speed(), |m, v| m.max(v.abs()));
        if speed > 0.0 { cfl * self.grid.h() / speed } else { f64::INFINITY }
    }

    /// The longest step that resolves buoyancy \[s\]: 1/sqrt(g beta_b max|grad phi|).
    pub fn buoyancy_dt(&self, phi: &CellField<T>) -> f64 {
        let Some(buoyancy) = self.settings.buoyancy else { return f64::INFINITY };
        let (layout, mask) = (self.grid.layout(), self.mask());
        let largest: Max = layout.par_runs(layout.cells_region(), (), |run, ()| {
            let mut largest = 0f64;
            for at in run.ats() {
                for a in (0..D).filter(|&a| at.cell[a] > 0) {
                    if mask.is_none_or(|m| m.fluid()[at.slot()] && m.fluid()[at.low(a)]) {
                        largest = largest.max((phi[at.slot()].f64() - phi[at.low(a)].f64()).abs());
                    }
                }
            }
            Max(largest)
        });
        1.0 / (buoyancy.strength.abs() * largest.0 / self.grid.h()).sqrt()
    }

    /// Bytes of all storage.
    pub fn bytes(&self) -> usize {
        let lent = if let Medium::Field(u) = &self.medium { u.bytes() } else { 0 };
        let velocities = [&self.u, &self.before, &self.next].into_iter().chain(self.stages.iter().flatten());
        let held: usize = self.emitters.iter().map(|(_, faces)| std::mem::size_of_val(&faces[..])).sum();
        lent + velocities.map(FaceField::bytes).sum::<usize>()
            + self.pressure.as_ref().map_or(0, CellField::bytes)
            + self.potential.iter().map(CellField::bytes).sum::<usize>()
            + self.carry.bytes()
            + self.projection.bytes()
            + self.own.bytes()
            + held
    }
}
