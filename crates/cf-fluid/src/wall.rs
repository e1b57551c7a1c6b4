//! Walls of the box as the flow meets them.

use cf_grid::Sides;

use crate::error::FlowError;

/// Wall of an incompressible inviscid flow. Velocities are components along the axes, not outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlowWall<const D: usize> {
    /// Nothing passes; the fluid slips along it.
    Closed,
    /// The fluid enters (or leaves) with this velocity \[m/s\]: its normal component is held on the wall, all of it is
    /// carried in.
    Inflow([f64; D]),
    /// Pressure 0. What flows out leaves freely; what flows in carries this velocity \[m/s\] of the fluid outside.
    Open([f64; D]),
}

impl<const D: usize> FlowWall<D> {
    /// Open towards fluid at rest.
    pub const OPEN: Self = FlowWall::Open([0.0; D]);

    /// The velocity a trajectory from outside brings along; `None` where none can.
    pub fn carried_in(self) -> Option<[f64; D]> {
        match self {
            FlowWall::Closed => None,
            FlowWall::Inflow(u) | FlowWall::Open(u) => Some(u),
        }
    }

    /// Conductance of the wall face for the pressure, in units of an inner face.
    pub(crate) fn conductance(self) -> f64 {
        if matches!(self, FlowWall::Open(_)) { 2.0 } else { 0.0 }
    }

    /// The velocity held on a wall face normal to `axis`; `None` where the pressure decides.
    pub(crate) fn held(self, axis: usize) -> Option<f64> {
        match self {
            FlowWall::Closed => Some(0.0),
            FlowWall::Inflow(u) => Some(u[axis]),
            FlowWall::Open(_) => None,
        }
    }
}

/// Refuses wall velocities that are not finite.
pub(crate) fn check<const D: usize>(sides: &Sides<FlowWall<D>, D>) -> Result<(), FlowError> {
    for (axis, end, wall) in sides.walls() {
        let velocity = wall.carried_in().unwrap_or([0.0; D]);
        if let Some(component) = velocity.iter().position(|v| !v.is_finite()) {
            return Err(FlowError::Wall { axis, end, component, value: velocity[component] });
        }
    }
    Ok(())
}
