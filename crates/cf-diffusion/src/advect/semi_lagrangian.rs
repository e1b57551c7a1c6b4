//! Semi-Lagrangian transport: every value is fetched from the foot of its trajectory.

use cf_grid::Real;

use crate::medium::Medium;

use super::muscl::copy;
use super::sample::at_foot;
use super::sites::Sites;
use super::trace::displacement;

/// Carries `field` over a step with `ratio` = Δt/h \[s/m\] (uniform: the displacement is one vector).
pub(super) fn step<T: Real, const D: usize, const K: usize>(
    sites: &Sites<D>,
    medium: &Medium<T, D>,
    fluid: Option<&[bool]>,
    ratio: f64,
    field: &mut [T],
    work: &mut [T],
) {
    let from: &[T] = field;
    // Faces store zeros inside solids: only cells have to look away from them.
    let avoid = fluid.filter(|_| sites.normal.is_none());
    sites.layout.par_region(sites.region, work, |at| match fluid {
        Some(fluid) if !sites.open(fluid, at.cell) => {
            if sites.normal.is_none() {
                from[at.slot()]
            } else {
                T::ZERO
            }
        }
        _ => at_foot::<T, D, K>(sites, avoid, from, at.cell, displacement(sites, medium, ratio, at.cell)),
    });
    copy(&sites.layout, sites.region, work, field);
}
