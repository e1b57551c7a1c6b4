//! Which cells are solid: those whose centre lies in an obstacle, or that a mask file says are.

use crate::scene::{Grid, Model, Scene};
use crate::spec::{Axes, Shape};
use std::fmt;
use std::sync::Arc;

/// The content of a mask file.
#[derive(Clone, PartialEq)]
pub struct MaskFile {
    /// The file, as the scene names it.
    pub file: String,
    /// Its cells along each axis.
    pub cells: Axes<usize>,
    /// One byte a cell, x fastest; 0 is fluid.
    pub bytes: Arc<[u8]>,
}

impl fmt::Debug for MaskFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // In the place of the bytes, what tells masks apart.
        write!(f, "MaskFile({:?}, {:?}, {:08x})", self.file, self.cells, crc32fast::hash(&self.bytes))
    }
}

impl MaskFile {
    /// Whether the cell of the mask that holds a point of the box is solid.
    fn holds(&self, point: &[f64], grid: &Grid) -> bool {
        let place = (0..self.cells.len()).rev().fold(0, |place, axis| {
            let share = (point[axis] - grid.origin[axis]) / grid.extent[axis];
            let index = (share * self.cells[axis] as f64).max(0.0) as usize;
            place * self.cells[axis] + index.min(self.cells[axis] - 1)
        });
        self.bytes.get(place).is_some_and(|byte| *byte != 0)
    }
}

/// The obstacles of a box.
pub(crate) struct Solid<'a> {
    grid: &'a Grid,
    obstacles: &'a [Shape],
    mask: Option<&'a MaskFile>,
}

impl<'a> Solid<'a> {
    /// The obstacles of a scene; none for a model without walls.
    pub fn of(scene: &'a Scene) -> Self {
        let (obstacles, mask) = match &scene.model {
            Model::Diffusion(model) => (model.obstacles.as_slice(), model.mask.as_ref()),
            Model::SingleField(_) => (&[][..], None),
        };
        Solid { grid: &scene.grid, obstacles, mask }
    }

    /// Whether there are no obstacles.
    pub fn is_empty(&self) -> bool {
        self.obstacles.is_empty() && self.mask.is_none()
    }

    /// Whether the point, a cell's centre, is in a solid cell.
    pub fn holds(&self, centre: &[f64]) -> bool {
        self.obstacles.iter().any(|shape| shape.weight(centre, &self.grid.origin, &self.grid.extent) > 0.0)
            || self.mask.is_some_and(|mask| mask.holds(centre, self.grid))
    }

    /// The centre of the cells with index `i` along an axis \[m\].
    pub fn centre(&self, axis: usize, i: usize) -> f64 {
        self.grid.origin[axis] + (i as f64 + 0.5) * self.grid.spacing
    }

    /// Whether a fluid cell whose centre lies between `low` and `high` passes a test of its centre.
    pub fn any_fluid(&self, bounds: impl Fn(usize) -> (f64, f64), test: impl Fn(&[f64]) -> bool) -> bool {
        let (grid, mut ranges) = (self.grid, [(0, 1); 3]);
        for (axis, range) in ranges.iter_mut().enumerate().take(grid.dimension()) {
            let cells = grid.cells[axis] as f64;
            let place = |x: f64| (x - grid.origin[axis]) / grid.spacing - 0.5;
            let (low, high) = bounds(axis);
            // A cell more on either side: what is exactly at the edge is for the test.
            *range = ((place(low) - 1.0).clamp(0.0, cells) as usize, (place(high) + 2.0).clamp(0.0, cells) as usize);
        }
        let mut centre = [0.0; 3];
        for k in ranges[2].0..ranges[2].1 {
            for j in ranges[1].0..ranges[1].1 {
                for i in ranges[0].0..ranges[0].1 {
                    for (axis, index) in [i, j, k].into_iter().enumerate().take(grid.dimension()) {
                        centre[axis] = self.centre(axis, index);
                    }
                    let point = &centre[..grid.dimension()];
                    if test(point) && !self.holds(point) {
                        return true;
                    }
                }
            }
        }
        false
    }
}
