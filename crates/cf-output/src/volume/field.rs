//! The voxels that rays go through.

use rayon::prelude::*;

use super::camera::V3;
use crate::OutputError;
use crate::array::Array;

/// Voxels along an edge of a block that is skipped where it is empty.
pub(super) const BLOCK: usize = 8;

/// A scalar field made ready for rays: v between 0 and 1 per voxel, and which voxels are solid.
#[derive(Debug, Clone)]
pub struct Volume {
    /// Cells of the array and of this, and how many cells of the array are averaged along each axis.
    shape: [usize; 3],
    cells: [usize; 3],
    by: usize,
    origin: V3,
    /// Edges of a voxel.
    spacing: V3,
    values: Vec<f32>,
    /// Share of each voxel that is solid; empty where none is.
    solid: Vec<f32>,
    /// Per block with the voxels around it: whether there is anything.
    occupied: Vec<bool>,
    blocks: [usize; 3],
}

impl Volume {
    /// The most voxels along an axis; longer fields are averaged over blocks of cells.
    pub const MOST: usize = 256;

    /// The first component of an array on a grid with `origin` and cells of size `spacing`; values between `low` and
    /// `high` become 0 to 1, and values beyond them count as these. What is not a number counts as empty.
    ///
    /// # Errors
    /// [`OutputError::Array`] for an array without values, [`OutputError::Request`] for a range or a grid without size.
    pub fn new(array: &Array, origin: V3, spacing: V3, [low, high]: [f64; 2]) -> Result<Self, OutputError> {
        let (shape, components) = (array.source.shape(), array.source.components());
        if components == 0 || shape.contains(&0) {
            return Err(OutputError::array(&array.name, format!("has no values; its shape is {shape:?}")));
        }
        let refuse = |reason: String| Err(OutputError::request("volume", reason));
        if !(low.is_finite() && high.is_finite() && high > low) {
            return refuse(format!("the range {low} to {high} is empty"));
        }
        if !(origin.iter().all(|o| o.is_finite()) && spacing.iter().all(|h| h.is_finite() && *h > 0.0)) {
            return refuse(format!("origin {origin:?} and spacing {spacing:?} are no grid"));
        }
        let by = shape.into_iter().max().unwrap_or(1).div_ceil(Self::MOST);
        let cells = shape.map(|n| n.div_ceil(by));
        let mut values = vec![0.0f32; cells.iter().product()];
        let mut bytes = Vec::new();
        for z in 0..shape[2] {
            for y in 0..shape[1] {
                bytes.clear();
                array.source.row(0..shape[0], y, z, &mut bytes);
                let row = cells[0] * (y / by + cells[1] * (z / by));
                let (mut component, mut x) = (0, 0);
                array.source.precision().decode(&bytes, |value| {
                    if component == 0 {
                        let scaled = ((value - low) / (high - low)).clamp(0.0, 1.0);
                        values[row + x / by] += if scaled.is_nan() { 0.0 } else { scaled as f32 };
                        x += 1;
                    }
                    component = (component + 1) % components;
                });
            }
        }
        let mut volume = Self {
            shape,
            cells,
            by,
            origin,
            spacing: spacing.map(|h| h * by as f64),
            values,
            solid: Vec::new(),
            occupied: Vec::new(),
            blocks: cells.map(|n| n.div_ceil(BLOCK)),
        };
        volume.average();
        volume.survey();
        Ok(volume)
    }

    /// Marks cells of the array as solid.
    pub fn set_solid(&mut self, solid: impl Fn([usize; 3]) -> bool) {
        let mut share = vec![0.0f32; self.values.len()];
        let inverse = (self.by as f32).powi(-3);
        for z in 0..self.shape[2] {
            for y in 0..self.shape[1] {
                for x in 0..self.shape[0] {
                    if solid([x, y, z]) {
                        share[self.index([x, y, z].map(|i| i / self.by))] += inverse;
                    }
                }
            }
        }
        self.solid = share;
        self.survey();
    }

    /// Sums over blocks of cells become means; the last block may be short.
    fn average(&mut self) {
        let (by, cells, shape) = (self.by, self.cells, self.shape);
        if by == 1 {
            return;
        }
        for (i, value) in self.values.iter_mut().enumerate() {
            let at = [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])];
            let count: usize = (0..3).map(|a| (shape[a] - at[a] * by).min(by)).product();
            *value /= count as f32;
        }
    }

    fn survey(&mut self) {
        let blocks = self.blocks;
        let cells = self.cells;
        let occupied = (0..blocks.iter().product()).map(|b: usize| {
            let at = [b % blocks[0], b / blocks[0] % blocks[1], b / (blocks[0] * blocks[1])];
            let range = |a: usize| (at[a] * BLOCK).saturating_sub(1)..((at[a] + 1) * BLOCK + 1).min(cells[a]);
            range(2).any(|z| {
                range(1).any(|y| {
                    let row = cells[0] * (y + cells[1] * z);
                    let x = row + range(0).start..row + range(0).end;
                    self.values[x.clone()].iter().any(|v| *v > 0.0)
                        || (!self.solid.is_empty() && self.solid[x].iter().any(|s| *s > 0.0))
                })
            })
        });
        self.occupied = occupied.collect();
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.cells[0] * (y + self.cells[1] * z)
    }

    /// The low and the high corner of the array's box.
    pub(super) fn corners(&self) -> [V3; 2] {
        let end = std::array::from_fn(|a| self.origin[a] + self.spacing[a] / self.by as f64 * self.shape[a] as f64);
        [self.origin, end]
    }

    /// The longest edge of the box.
    pub(super) fn longest(&self) -> f64 {
        let [low, high] = self.corners();
        (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max)
    }

    pub(super) fn smallest_voxel(&self) -> f64 {
        self.spacing.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// A point in units of voxels from the low corner, and a direction likewise.
    pub(super) fn in_voxels(&self, p: V3) -> V3 {
        std::array::from_fn(|a| (p[a] - self.origin[a]) / self.spacing[a])
    }

    pub(super) fn per_voxel(&self, d: V3) -> V3 {
        std::array::from_fn(|a| d[a] / self.spacing[a])
    }

    /// Whether there may be anything at a point (in voxels); otherwise the box of voxels that is empty.
    pub(super) fn empty_block(&self, p: V3) -> Option<[V3; 2]> {
        let at: [usize; 3] = std::array::from_fn(|a| ((p[a].max(0.0) as usize) / BLOCK).min(self.blocks[a] - 1));
        if self.occupied[at[0] + self.blocks[0] * (at[1] + self.blocks[1] * at[2])] {
            return None;
        }
        Some([at.map(|i| (i * BLOCK) as f64), at.map(|i| ((i + 1) * BLOCK) as f64)])
    }

    /// v at a point in voxels.
    pub(super) fn value(&self, p: V3) -> f32 {
        trilinear(&self.values, self.cells, p)
    }

    /// The solid share at a point in voxels.
    pub(super) fn solidity(&self, p: V3) -> f32 {
        if self.solid.is_empty() { 0.0 } else { trilinear(&self.solid, self.cells, p) }
    }

    /// The outward direction of the solid's surface at a point in voxels.
    pub(super) fn outward(&self, p: V3) -> V3 {
        std::array::from_fn(|a| {
            let mut beside = [p, p];
            beside[0][a] -= 0.75;
            beside[1][a] += 0.75;
            f64::from(self.solidity(beside[0]) - self.solidity(beside[1])) / self.spacing[a]
        })
    }

    /// ∫ v ds from every voxel of a coarser grid to the light, solids counting as very dense.
    pub(super) fn depth_towards(&self, light: V3) -> Depth {
        let by = self.cells.into_iter().max().unwrap_or(1).div_ceil(Depth::MOST);
        let cells = self.cells.map(|n| n.div_ceil(by));
        let mut coarse = vec![0.0f32; cells.iter().product()];
        let inverse = (by as f32).powi(-3);
        for z in 0..self.cells[2] {
            for y in 0..self.cells[1] {
                for x in 0..self.cells[0] {
                    let i = self.index([x, y, z]);
                    let solid = self.solid.get(i).map_or(0.0, |s| SOLID * s);
                    coarse[x / by + cells[0] * (y / by + cells[1] * (z / by))] += inverse * (self.values[i] + solid);
                }
            }
        }
        let step: V3 = std::array::from_fn(|a| light[a] / (self.spacing[a] * by as f64));
        // One voxel per step along the axis the light comes from most.
        let largest = step.iter().fold(0.0f64, |m, s| m.max(s.abs())).max(f64::MIN_POSITIVE);
        let (step, length) = (step.map(|s| s / largest), 1.0 / largest);
        let mut depth = vec![0.0f32; coarse.len()];
        depth.par_chunks_mut(cells[0]).enumerate().for_each(|(row, depth)| {
            for (x, depth) in depth.iter_mut().enumerate() {
                let mut p: V3 = [x, row % cells[1], row / cells[1]].map(|i| i as f64 + 0.5);
                let mut sum = 0.0f32;
                loop {
                    p = std::array::from_fn(|a| p[a] + step[a]);
                    if (0..3).any(|a| !(0.0..=cells[a] as f64).contains(&p[a])) {
                        break;
                    }
                    sum += trilinear(&coarse, cells, p);
                }
                *depth = sum * length as f32;
            }
        });
        Depth { cells, by: by as f64, values: depth }
    }
}

/// Density of solids in shadows, in units of v.
const SOLID: f32 = 20.0;

/// Optical depth towards the light.
pub(super) struct Depth {
    cells: [usize; 3],
    by: f64,
    values: Vec<f32>,
}

impl Depth {
    const MOST: usize = 96;

    /// At a point in voxels of the volume.
    pub fn at(&self, p: V3) -> f32 {
        trilinear(&self.values, self.cells, p.map(|v| v / self.by))
    }
}

/// Between the centres of voxels; constant beyond the last ones.
fn trilinear(values: &[f32], cells: [usize; 3], p: V3) -> f32 {
    let (mut low, mut high, mut share) = ([0usize; 3], [0usize; 3], [0.0f32; 3]);
    for a in 0..3 {
        let x = (p[a] - 0.5).clamp(0.0, (cells[a] - 1) as f64);
        low[a] = x as usize;
        high[a] = (low[a] + 1).min(cells[a] - 1);
        share[a] = (x - low[a] as f64) as f32;
    }
    let row = |y: usize, z: usize| {
        let row = cells[0] * (y + cells[1] * z);
        let (l, h) = (values[row + low[0]], values[row + high[0]]);
        l + share[0] * (h - l)
    };
    let plane = |z: usize| {
        let (l, h) = (row(low[1], z), row(high[1], z));
        l + share[1] * (h - l)
    };
    let (l, h) = (plane(low[2]), plane(high[2]));
    l + share[2] * (h - l)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_fields_are_averaged_and_keep_their_box() {
        let array = Array::per_cell("phi", [600, 3, 2], |c| [if c[0] < 300 { 1.0f64 } else { f64::NAN }]);
        let volume = Volume::new(&array, [1.0, 2.0, 3.0], [0.01; 3], [0.0, 2.0]).unwrap();
        assert_eq!((volume.cells, volume.by), ([200, 1, 1], 3));
        assert!((volume.values[0] - 0.5).abs() < 1e-6 && volume.values[199] == 0.0);
        let [low, high] = volume.corners();
        assert_eq!(low, [1.0, 2.0, 3.0]);
        assert!((high[0] - 7.0).abs() < 1e-12 && (high[1] - 2.03).abs() < 1e-12);
        assert!(Volume::new(&array, [0.0; 3], [1.0; 3], [1.0, 1.0]).is_err());
    }

    #[test]
    fn a_linear_field_is_interpolated_exactly_and_empty_blocks_are_known() {
        let array = Array::per_cell("phi", [32, 16, 8], |c| [if c[0] < 4 { 1.0f32 } else { 0.0 }]);
        let volume = Volume::new(&array, [0.0; 3], [1.0; 3], [0.0, 1.0]).unwrap();
        assert!(volume.empty_block([20.0, 3.0, 3.0]).is_some() && volume.empty_block([2.0, 3.0, 3.0]).is_none());
        let slope: Vec<f32> = (0..60).map(|i| (i % 5) as f32 + 10.0 * (i / 5 % 4) as f32 - (i / 20) as f32).collect();
        let at = trilinear(&slope, [5, 4, 3], [2.25, 1.75, 2.0]);
        assert!((at - (1.75 + 12.5 - 1.5)).abs() < 1e-5, "{at}");
    }

    #[test]
    fn the_depth_towards_the_light_is_the_length_of_the_way() {
        let array = Array::per_cell("phi", [20, 20, 20], |_| [1.0f32]);
        let volume = Volume::new(&array, [0.0; 3], [0.1; 3], [0.0, 1.0]).unwrap();
        let depth = volume.depth_towards([0.0, 1.0, 0.0]);
        assert!((depth.at([10.0, 0.5, 10.0]) - 1.9).abs() < 0.11);
        assert!(depth.at([10.0, 19.5, 10.0]) < 0.11);
    }
}
