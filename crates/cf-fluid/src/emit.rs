//! Emitters: where fluid and the transported quantity enter.

use cf_grid::{CellField, End, Grid, Mask, Real, Sides};

use crate::error::FlowError;
use crate::gates::Held;
use crate::shape::Shape;
use crate::wall::FlowWall;

/// How an emitter moves the fluid inside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Jet<const D: usize> {
    /// The velocity \[m/s\] is set before each projection, which then may change it.
    Set([f64; D]),
    /// The faces inside hold the velocity \[m/s\], as walls that blow: faces on closed walls too, so that a box on a wall
    /// is an inlet.
    Hold([f64; D]),
}

/// What an emitter does to the transported quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Emission {
    /// W \[P/s\], for the share of the step during which the emitter acts.
    Rate(f64),
    /// phi is set to this value \[P\] before each step.
    Value(f64),
}

/// A shape that emits from time `from` to `until` \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Emitter<const D: usize> {
    /// Cells whose centres, and faces whose centres, lie in it.
    pub shape: Shape<D>,
    /// What it does to the velocity.
    pub jet: Option<Jet<D>>,
    /// What it does to phi.
    pub emission: Option<Emission>,
    /// Start \[s\].
    pub from: f64,
    /// End \[s\]; may be infinite.
    pub until: f64,
}

impl<const D: usize> Emitter<D> {
    /// Acting from the start for ever.
    pub fn new(shape: Shape<D>, jet: Option<Jet<D>>, emission: Option<Emission>) -> Self {
        Self { shape, jet, emission, from: 0.0, until: f64::INFINITY }
    }

    /// Refuses shapes without sense and numbers that are not finite.
    pub fn check(&self) -> Result<(), FlowError> {
        self.shape.check()?;
        let refuse = |name, found| Err(FlowError::Setting { name, found, expected: "a finite number" });
        if let Some(Jet::Set(u) | Jet::Hold(u)) = self.jet
            && let Some(&found) = u.iter().find(|u| !u.is_finite())
        {
            return refuse("an emitter's velocity", found);
        }
        if let Some(Emission::Rate(v) | Emission::Value(v)) = self.emission
            && !v.is_finite()
        {
            return refuse("an emitter's rate or value", v);
        }
        if self.from.is_nan() || self.until.is_nan() {
            return refuse("an emitter's time", f64::NAN);
        }
        Ok(())
    }

    /// Share of a step from `time` over `dt` \[s\] during which it acts, in \[0, 1\].
    pub fn share(&self, time: f64, dt: f64) -> f64 {
        if dt == 0.0 {
            return f64::from(self.from <= time && time < self.until);
        }
        ((self.until.min(time + dt) - self.from.max(time)) / dt).clamp(0.0, 1.0)
    }

    /// Whether it acts in the middle of a step.
    pub(crate) fn acts(&self, time: f64, dt: f64) -> bool {
        let middle = time + 0.5 * dt;
        self.from <= middle && middle < self.until
    }

    /// The faces in the shape with the velocity of a jet. Faces on high walls count, a periodic seam once.
    pub(crate) fn faces(&self, grid: &Grid<D>, sides: &Sides<FlowWall<D>, D>, mask: Option<&Mask<D>>) -> Vec<Held> {
        let Some(Jet::Set(velocity) | Jet::Hold(velocity)) = self.jet else { return Vec::new() };
        let (layout, mut faces) = (grid.layout(), Vec::new());
        for axis in 0..D {
            layout.each_cell(layout.faces_region(axis, sides.is_periodic(axis)), |at| {
                if !self.shape.contains(&grid.face(axis, at.cell).into()) {
                    return;
                }
                let wall = |end| sides.wall(axis, end).is_some();
                let mut pair = [at.cell; 2];
                pair[0][axis] = match at.cell[axis] {
                    0 if wall(End::Low) => 0,
                    0 => layout.cells()[axis] - 1,
                    i => i - 1,
                };
                if at.cell[axis] == layout.cells()[axis] {
                    pair[1] = pair[0];
                }
                // A face of a solid belongs to the solid.
                if mask.is_none_or(|m| pair.iter().all(|&cell| m.fluid()[layout.slot(cell)])) {
                    faces.push(Held { axis, slot: at.slot(), velocity: velocity[axis] });
                }
            });
        }
        faces
    }

    /// Calls `f` with the slot of every fluid cell in the shape.
    pub(crate) fn each_cell(&self, grid: &Grid<D>, mask: Option<&Mask<D>>, mut f: impl FnMut(usize)) {
        let layout = grid.layout();
        layout.each_cell(layout.cells_region(), |at| {
            let fluid = mask.is_none_or(|m| m.fluid()[at.slot()]);
            if fluid && self.shape.contains(&grid.centre(at.cell).into()) {
                f(at.slot());
            }
        });
    }

    /// Sets phi where the emitter holds a value; returns the mass that this added \[P m^D\].
    pub fn set_value<T: Real>(&self, grid: &Grid<D>, mask: Option<&Mask<D>>, phi: &mut CellField<T>) -> f64 {
        let Some(Emission::Value(value)) = self.emission else { return 0.0 };
        let mut added = 0.0;
        self.each_cell(grid, mask, |slot| {
            let old = phi[slot].f64();
            phi[slot] = T::of(value);
            added += phi[slot].f64() - old;
        });
        added * grid.cell_volume()
    }
}
