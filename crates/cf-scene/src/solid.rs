//! Which cells are solid: those whose centre lies in an obstacle, or that a mask file says are.

use crate::scene::{Grid, Model, Scene};
use crate::spec::{Axes, Shape};
use cf_output::smooth_mask;
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

    /// A distance to the surface for pictures: of shapes as they are, of masks and of shapes without one about that of their
    /// cells, looked at on this many voxels of the box.
    pub fn distance(&self, voxels: [usize; 3]) -> impl Fn([f64; 3]) -> f64 + Send + Sync + use<> {
        let (exact, rough): (Vec<Shape>, Vec<Shape>) =
            self.obstacles.iter().cloned().partition(|shape| shape.distance(&[0.0; 3]).is_some());
        let (origin, extent) = (&self.grid.origin, &self.grid.extent);
        let along = |values: &[f64]| std::array::from_fn(|axis| values.get(axis).copied().unwrap_or(1.0));
        let edges: [f64; 3] = along(extent);
        let cells: [usize; 3] = std::array::from_fn(|axis| self.grid.cells.get(axis).copied().unwrap_or(1));
        let by = (0..3).map(|axis| cells[axis].div_ceil(voxels[axis].max(1))).max().unwrap_or(1).max(1);
        let spacing: [f64; 3] = std::array::from_fn(|axis| edges[axis] / cells[axis] as f64 * by as f64);
        let low: [f64; 3] = along(origin);
        let mask = (!rough.is_empty() || self.mask.is_some()).then(|| {
            smooth_mask(voxels, low, spacing, &|voxel| {
                let centre: [f64; 3] =
                    std::array::from_fn(|axis| low[axis] + (voxel[axis] as f64 + 0.5) * spacing[axis]);
                rough.iter().any(|shape| shape.weight(&centre, origin, extent) > 0.0)
                    || self.mask.is_some_and(|mask| mask.holds(&centre, self.grid))
            })
        });
        move |point| {
            let shapes = exact.iter().filter_map(|shape| shape.distance(&point)).fold(f64::INFINITY, f64::min);
            mask.as_ref().map_or(shapes, |mask| shapes.min(mask(point)))
        }
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
