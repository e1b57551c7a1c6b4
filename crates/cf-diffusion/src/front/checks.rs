//! What a front stepper looks at before it works, and after.

use cf_grid::{Real, Sides, Wall};

use super::{Front, FrontError, FrontState};
use crate::source::Source;

/// Refuses wall numbers that are not finite, and negative absorbing speeds.
pub(super) fn walls<const D: usize>(sides: &Sides<Wall, D>) -> Result<(), FrontError> {
    for (axis, end, wall) in sides.walls() {
        let (what, value) = match wall {
            Wall::Flux(g) => ("flux", g),
            Wall::Value(v) => ("value", v),
            Wall::Absorbing { speed, far } if far.is_finite() => ("speed", speed),
            Wall::Absorbing { far, .. } => ("far", far),
            Wall::Open { inflow } => ("inflow", inflow),
        };
        let least = if what == "speed" { 0.0 } else { f64::NEG_INFINITY };
        if !(value.is_finite() && value >= least) {
            let expected = if what == "speed" { "a finite number >= 0" } else { "a finite number" };
            return Err(FrontError::Wall { axis, end, what, value, expected });
        }
    }
    Ok(())
}

impl<T: Real, const D: usize> Front<T, D> {
    /// How many sub-steps `dt` takes; 0 for 0.
    pub(super) fn substeps(&self, dt: f64) -> Result<usize, FrontError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(FrontError::TimeStep(dt));
        }
        let stable = self.stable_dt();
        // One part in 1e12: a step computed from the limit itself is meant to pass.
        let substeps = if dt == 0.0 { 0.0 } else { (dt / stable * (1.0 - 1e-12)).ceil().max(1.0) };
        if substeps <= Self::SUBSTEPS as f64 {
            return Ok(substeps as usize);
        }
        Err(FrontError::TooManySubsteps { dt, stable, substeps, limit: Self::SUBSTEPS })
    }

    /// Refuses fields of another layout, which the sweeps could not index.
    pub(super) fn check_layout(&self, state: &FrontState<T, D>, source: Source<'_, T>) -> Result<(), FrontError> {
        let expected = self.grid.layout().slots();
        let flux = state.flux.iter().map(|q| ("the flux", q.len()));
        let rate = source.rate.iter().map(|rate| ("the source", rate.reach(expected)));
        match flux.chain(rate).chain([("phi", state.phi.len())]).find(|&(_, found)| found != expected) {
            Some((what, found)) => Err(FrontError::Layout { what, expected, found }),
            None => Ok(()),
        }
    }

    /// The first cell in which x is not finite.
    pub(super) fn first_bad(&self, x: impl Fn(usize) -> T) -> Option<Vec<usize>> {
        let (layout, mut found) = (self.grid.layout(), None);
        layout.each_cell(layout.cells_region(), |at| {
            if found.is_none() && !x(at.slot()).is_finite() {
                found = Some(at.cell.to_vec());
            }
        });
        found
    }
}
