//! The voxels that rays go through.

use rayon::prelude::*;

use super::camera::{V3, dot};
use super::solid::Solid;
use crate::OutputError;
use crate::array::Array;

/// Voxels along an edge of a block that is skipped where it is empty.
pub(super) const BLOCK: usize = 8;

/// A scalar field in a box, and what is solid there.
#[derive(Debug, Clone)]
pub struct Volume {
    /// Cells of the array and of this, and how many cells of the array are averaged along each axis.
    shape: [usize; 3],
    cells: [usize; 3],
    by: usize,
    origin: V3,
    /// Edges of a voxel.
    spacing: V3,
    /// The field itself; what is not a number counts as zero.
    values: Vec<f32>,
    pub(super) solid: Option<Solid>,
}

impl Volume {
    /// The most voxels along an axis; longer fields are averaged over blocks of cells.
    pub const MOST: usize = 256;

    /// The voxels of a field with these cells.
    pub fn voxels(shape: [usize; 3]) -> [usize; 3] {
        let by = Self::coarsening(shape);
        shape.map(|n| n.div_ceil(by))
    }

    fn coarsening(shape: [usize; 3]) -> usize {
        shape.into_iter().max().unwrap_or(1).div_ceil(Self::MOST).max(1)
    }

    /// From the values of all voxels, x fastest, of a field with `shape` cells of size `spacing` from `origin` on.
    ///
    /// # Errors
    /// [`OutputError::Request`] for a grid without size or another number of values than [`voxels`](Self::voxels) says.
    pub fn from_voxels(
        shape: [usize; 3],
        origin: [f64; 3],
        spacing: [f64; 3],
        values: Vec<f32>,
    ) -> Result<Self, OutputError> {
        let refuse = |reason: String| Err(OutputError::request("volume", reason));
        if !(origin.iter().all(|o| o.is_finite()) && spacing.iter().all(|h| h.is_finite() && *h > 0.0)) {
            return refuse(format!("origin {origin:?} and spacing {spacing:?} are no grid"));
        }
        let (by, cells) = (Self::coarsening(shape), Self::voxels(shape));
        if values.is_empty() || cells.iter().try_fold(1usize, |n, m| n.checked_mul(*m)) != Some(values.len()) {
            return refuse(format!("{} values for {cells:?} voxels", values.len()));
        }
        Ok(Self { shape, cells, by, origin, spacing: spacing.map(|h| h * by as f64), values, solid: None })
    }

    /// The first component of an array on a grid with `origin` and cells of size `spacing`. What is not a number counts
    /// as zero.
    ///
    /// # Errors
    /// [`OutputError::Array`] for an array without values, [`OutputError::Request`] for a grid without size.
    pub fn new(array: &Array, origin: [f64; 3], spacing: [f64; 3]) -> Result<Self, OutputError> {
        let (shape, components) = (array.source.shape(), array.source.components());
        if components == 0 || shape.contains(&0) {
            return Err(OutputError::array(&array.name, format!("has no values; its shape is {shape:?}")));
        }
        let (by, cells) = (Self::coarsening(shape), Self::voxels(shape));
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
                        values[row + x / by] += if value.is_finite() { value as f32 } else { 0.0 };
                        x += 1;
                    }
                    component = (component + 1) % components;
                });
            }
        }
        let mut volume = Self::from_voxels(shape, origin, spacing, values)?;
        volume.average();
        Ok(volume)
    }

    /// The values of the voxels, x fastest.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Puts solids into the box: `distance` is how far a point is from their surface, negative inside. It may be less than
    /// the distance far away, and should be right near the surface, where it gives the shading. What the field has inside of
    /// solids is replaced by what is beside them.
    pub fn set_solid(&mut self, distance: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static) {
        let solid = Solid::new(distance);
        let mut known: Vec<bool> =
            (0..self.values.len()).map(|i| solid.distance(self.centre(self.place(i))) > 0.0).collect();
        // Two layers are more than interpolation reaches.
        for _ in 0..2 {
            let old = known.clone();
            let found: Vec<(usize, f32)> = (0..old.len())
                .into_par_iter()
                .filter(|i| !old[*i])
                .filter_map(|i| {
                    let (mut sum, mut count) = (0.0f32, 0u8);
                    self.around(self.place(i), |j| {
                        if old[j] {
                            (sum, count) = (sum + self.values[j], count + 1);
                        }
                    });
                    (count > 0).then(|| (i, sum / f32::from(count)))
                })
                .collect();
            for (i, value) in found {
                (self.values[i], known[i]) = (value, true);
            }
        }
        for (value, known) in self.values.iter_mut().zip(known) {
            if !known {
                *value = 0.0;
            }
        }
        self.solid = Some(solid);
    }

    /// The box around all voxels above `least` and all that have a part of a solid's surface or inside; `None` where there
    /// are none.
    pub fn extent_above(&self, least: f64) -> Option<[[f64; 3]; 2]> {
        let (mut low, mut high, mut any) = ([usize::MAX; 3], [0usize; 3], false);
        for (i, value) in self.values.iter().enumerate() {
            let seen = || f64::from(*value) > least;
            let stony = || self.solid.as_ref().is_some_and(|s| s.distance(self.centre(self.place(i))) <= 0.0);
            if seen() || stony() {
                let at = self.place(i);
                any = true;
                low = std::array::from_fn(|a| low[a].min(at[a]));
                high = std::array::from_fn(|a| high[a].max(at[a] + 1));
            }
        }
        let [_, end] = self.corners();
        let point =
            |at: [usize; 3]| std::array::from_fn(|a| (self.origin[a] + self.spacing[a] * at[a] as f64).min(end[a]));
        any.then(|| [point(low), point(high)])
    }

    /// How much of the field a look through the box along an axis meets, as (∫ max(φ - low, 0) ds) over the longest edge:
    /// that through which half of the field is seen. 0 where there is nothing.
    pub fn column(&self, axis: usize, low: f64) -> f64 {
        let axis = axis.min(2);
        let stride: usize = self.cells[..axis].iter().product();
        let mut columns: Vec<f64> = (0..self.values.len())
            .filter(|i| self.place(*i)[axis] == 0)
            .map(|first| {
                let along = (0..self.cells[axis]).map(|n| f64::from(self.values[first + n * stride]) - low);
                along.map(|v| v.max(0.0)).sum::<f64>() * self.spacing[axis] / self.longest()
            })
            .collect();
        columns.sort_unstable_by(f64::total_cmp);
        let (half, mut sum) = (0.5 * columns.iter().sum::<f64>(), 0.0);
        let found = columns.into_iter().find(|column| {
            sum += column;
            sum >= half
        });
        found.unwrap_or(0.0)
    }

    /// Sums over blocks of cells become means; the last block may be short.
    fn average(&mut self) {
        let (by, shape) = (self.by, self.shape);
        if by == 1 {
            return;
        }
        for i in 0..self.values.len() {
            let at = self.place(i);
            let count: usize = (0..3).map(|a| (shape[a] - at[a] * by).min(by)).product();
            self.values[i] /= count as f32;
        }
    }

    fn place(&self, i: usize) -> [usize; 3] {
        [i % self.cells[0], i / self.cells[0] % self.cells[1], i / (self.cells[0] * self.cells[1])]
    }

    fn centre(&self, at: [usize; 3]) -> V3 {
        std::array::from_fn(|a| self.origin[a] + (at[a] as f64 + 0.5) * self.spacing[a])
    }

    /// Calls with each voxel around one.
    fn around(&self, at: [usize; 3], mut call: impl FnMut(usize)) {
        let range = |a: usize| at[a].saturating_sub(1)..(at[a] + 2).min(self.cells[a]);
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    call(x + self.cells[0] * (y + self.cells[1] * z));
                }
            }
        }
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

    /// Made ready for rays: values between `low` and `high` become 0 to 1, and values beyond them count as these.
    pub(super) fn prepared(&self, [low, high]: [f64; 2]) -> Voxels<'_> {
        let scaled = |value: &f32| ((f64::from(*value) - low) / (high - low)).clamp(0.0, 1.0) as f32;
        let mut voxels = Voxels {
            volume: self,
            cells: self.cells,
            spacing: self.spacing,
            values: self.values.iter().map(scaled).collect(),
            share: Vec::new(),
            occupied: Vec::new(),
            stony: Vec::new(),
            blocks: [0; 3],
            step: 0.0,
        };
        voxels.step = voxels.smallest_voxel();
        if self.by == 1 && self.cells.into_iter().max() <= Some(FEW) {
            (0..3).for_each(|axis| voxels.halve(axis));
            voxels.step *= 0.8;
        }
        voxels.survey();
        voxels
    }
}

/// Fields of so few voxels along each axis are made smoother before they are drawn.
const FEW: usize = 128;

/// The voxels that rays go through: v between 0 and 1 each.
pub(super) struct Voxels<'a> {
    pub volume: &'a Volume,
    cells: [usize; 3],
    spacing: V3,
    values: Vec<f32>,
    /// Share of each voxel that is solid; empty where nothing is.
    share: Vec<f32>,
    /// Per block with the voxels around it: whether there is any cloud, and any solid.
    occupied: Vec<bool>,
    stony: Vec<bool>,
    blocks: [usize; 3],
    /// How fine the field is: rays need not see more than it had before it was refined.
    pub step: f64,
}

impl Voxels<'_> {
    /// Makes two of each voxel along an axis, by cubics through the centres that were.
    fn halve(&mut self, axis: usize) {
        // Catmull and Rom at 1/4 of the way from the second to the third.
        const NEAR: [f32; 4] = [-9.0 / 128.0, 111.0 / 128.0, 29.0 / 128.0, -3.0 / 128.0];
        let (old, n) = (self.cells, self.cells[axis]);
        if n < 2 {
            return;
        }
        let stride: usize = old[..axis].iter().product();
        self.cells[axis] *= 2;
        self.spacing[axis] *= 0.5;
        let cells = self.cells;
        let mut fine = vec![0.0f32; cells.iter().product()];
        fine.par_chunks_mut(cells[0]).enumerate().for_each(|(row, fine)| {
            for (x, fine) in fine.iter_mut().enumerate() {
                let mut at = [x, row % cells[1], row / cells[1]];
                let (half, place) = (at[axis] % 2, at[axis] / 2);
                at[axis] = 0;
                let first = at[0] + old[0] * (at[1] + old[1] * at[2]);
                let value = |offset: isize| {
                    let offset = if half == 1 { offset } else { -offset };
                    self.values[first + stride * place.saturating_add_signed(offset).min(n - 1)]
                };
                let sum: f32 = NEAR.iter().zip(-1..3).map(|(weight, offset)| weight * value(offset)).sum();
                *fine = sum.clamp(0.0, 1.0);
            }
        });
        self.values = fine;
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.cells[0] * (y + self.cells[1] * z)
    }

    fn survey(&mut self) {
        let cells = self.cells;
        self.blocks = cells.map(|n| n.div_ceil(BLOCK));
        let blocks = self.blocks;
        if let Some(solid) = &self.volume.solid {
            let reach = dot(self.spacing, self.spacing).sqrt();
            let distances: Vec<f64> = (0..self.values.len())
                .into_par_iter()
                .map(|i| {
                    let at = [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])];
                    solid.distance(self.point(at.map(|n| n as f64 + 0.5)))
                })
                .collect();
            self.share = distances.iter().map(|d| (0.5 - d / self.smallest_voxel()).clamp(0.0, 1.0) as f32).collect();
            self.stony = vec![false; blocks.iter().product()];
            for (i, distance) in distances.iter().enumerate() {
                if *distance < reach {
                    let at = [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])].map(|n| n / BLOCK);
                    self.stony[at[0] + blocks[0] * (at[1] + blocks[1] * at[2])] = true;
                }
            }
        }
        let occupied = (0..blocks.iter().product()).map(|b: usize| {
            let at = [b % blocks[0], b / blocks[0] % blocks[1], b / (blocks[0] * blocks[1])];
            let range = |a: usize| (at[a] * BLOCK).saturating_sub(1)..((at[a] + 1) * BLOCK + 1).min(cells[a]);
            range(2).any(|z| {
                range(1).any(|y| {
                    let row = cells[0] * (y + cells[1] * z);
                    let x = row + range(0).start..row + range(0).end;
                    self.values[x].iter().any(|v| *v > 0.0)
                })
            })
        });
        self.occupied = occupied.collect();
    }

    pub(super) fn smallest_voxel(&self) -> f64 {
        self.spacing.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// A point in units of voxels from the low corner, and a direction likewise.
    pub(super) fn in_voxels(&self, p: V3) -> V3 {
        std::array::from_fn(|a| (p[a] - self.volume.origin[a]) / self.spacing[a])
    }

    /// A point in voxels as a point of space.
    pub(super) fn point(&self, p: V3) -> V3 {
        std::array::from_fn(|a| self.volume.origin[a] + p[a] * self.spacing[a])
    }

    pub(super) fn per_voxel(&self, d: V3) -> V3 {
        std::array::from_fn(|a| d[a] / self.spacing[a])
    }

    fn block(&self, p: V3) -> ([usize; 3], usize) {
        let at: [usize; 3] = std::array::from_fn(|a| ((p[a].max(0.0) as usize) / BLOCK).min(self.blocks[a] - 1));
        (at, at[0] + self.blocks[0] * (at[1] + self.blocks[1] * at[2]))
    }

    /// Whether there may be anything at a point (in voxels); otherwise the box of voxels that is empty.
    pub(super) fn empty_block(&self, p: V3) -> Option<[V3; 2]> {
        let (at, block) = self.block(p);
        if self.occupied[block] || self.stony.get(block) == Some(&true) {
            return None;
        }
        Some([at.map(|i| (i * BLOCK) as f64), at.map(|i| ((i + 1) * BLOCK) as f64)])
    }

    /// The solid, where its surface or inside may be at a point in voxels.
    pub(super) fn solid_near(&self, p: V3) -> Option<&Solid> {
        let near = !self.stony.is_empty() && self.stony[self.block(p).1];
        self.volume.solid.as_ref().filter(|_| near)
    }

    /// v at a point in voxels.
    pub(super) fn value(&self, p: V3) -> f32 {
        trilinear(&self.values, self.cells, p)
    }

    /// ∫ v ds from every voxel of a coarser grid to the light, solids counting as very dense or, by `bare`, not at all.
    pub(super) fn depth_towards(&self, light: V3, bare: bool) -> Depth {
        let by = self.cells.into_iter().max().unwrap_or(1).div_ceil(Depth::MOST);
        let cells = self.cells.map(|n| n.div_ceil(by));
        let mut coarse = vec![0.0f32; cells.iter().product()];
        let inverse = (by as f32).powi(-3);
        for z in 0..self.cells[2] {
            for y in 0..self.cells[1] {
                for x in 0..self.cells[0] {
                    let i = self.index([x, y, z]);
                    let solid = if bare { 0.0 } else { self.share.get(i).map_or(0.0, |s| SOLID * s) };
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
pub(super) fn trilinear(values: &[f32], cells: [usize; 3], p: V3) -> f32 {
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
        let volume = Volume::new(&array, [1.0, 2.0, 3.0], [0.01; 3]).unwrap();
        assert_eq!((volume.cells, volume.by), ([200, 1, 1], 3));
        assert!((volume.values[0] - 1.0).abs() < 1e-6 && volume.values[199] == 0.0);
        let [low, high] = volume.corners();
        assert_eq!(low, [1.0, 2.0, 3.0]);
        assert!((high[0] - 7.0).abs() < 1e-12 && (high[1] - 2.03).abs() < 1e-12);
        assert!(Volume::new(&array, [0.0; 3], [1.0, 0.0, 1.0]).is_err());
        let again = Volume::from_voxels([600, 3, 2], [1.0, 2.0, 3.0], [0.01; 3], volume.values().to_vec()).unwrap();
        assert_eq!((again.cells, again.spacing, &again.values), (volume.cells, volume.spacing, &volume.values));
        assert!(Volume::from_voxels([600, 3, 2], [0.0; 3], [1.0; 3], vec![0.0; 199]).is_err());
    }

    #[test]
    fn a_linear_field_is_interpolated_exactly_and_empty_blocks_are_known() {
        let array = Array::per_cell("phi", [32, 16, 8], |c| [if c[0] < 4 { 1.0f32 } else { 0.0 }]);
        let volume = Volume::new(&array, [0.0; 3], [1.0; 3]).unwrap();
        let voxels = volume.prepared([0.0, 1.0]);
        // Of two voxels a cell.
        assert!(voxels.empty_block([40.0, 6.0, 6.0]).is_some() && voxels.empty_block([4.0, 6.0, 6.0]).is_none());
        let slope: Vec<f32> = (0..60).map(|i| (i % 5) as f32 + 10.0 * (i / 5 % 4) as f32 - (i / 20) as f32).collect();
        let at = trilinear(&slope, [5, 4, 3], [2.25, 1.75, 2.0]);
        assert!((at - (1.75 + 12.5 - 1.5)).abs() < 1e-5, "{at}");
    }

    #[test]
    fn the_depth_towards_the_light_is_the_length_of_the_way() {
        let array = Array::per_cell("phi", [20, 20, 20], |_| [1.0f32]);
        let mut volume = Volume::new(&array, [0.0; 3], [0.1; 3]).unwrap();
        let depth = volume.prepared([0.0, 1.0]).depth_towards([0.0, 1.0, 0.0], false);
        assert!((depth.at([20.0, 1.0, 20.0]) - 1.9).abs() < 0.11);
        assert!(depth.at([20.0, 39.0, 20.0]) < 0.11);
        volume.set_solid(|p| 1.5 - p[1]);
        let voxels = volume.prepared([0.0, 1.0]);
        let [bare, whole] = [true, false].map(|bare| voxels.depth_towards([0.0, 1.0, 0.0], bare).at([20.0, 1.0, 20.0]));
        assert!(bare < 2.0 && whole > 8.0, "{bare} {whole}");
    }

    #[test]
    fn halves_of_voxels_keep_linear_fields_and_sharp_ones_within_their_range() {
        let array = Array::per_cell("phi", [16, 3, 2], |c| [c[0] as f32 / 16.0]);
        let volume = Volume::new(&array, [0.0; 3], [1.0; 3]).unwrap();
        let voxels = volume.prepared([0.0, 1.0]);
        assert_eq!(voxels.cells, [32, 6, 4]);
        let at = |x: usize| voxels.values[voxels.index([x, 2, 1])];
        assert!((4..28).all(|x| (at(x) - (0.5 * x as f32 - 0.25) / 16.0).abs() < 1e-6));
        let step = Array::per_cell("phi", [16, 3, 2], |c| [if c[0] < 8 { 1.0f32 } else { 0.0 }]);
        let volume = Volume::new(&step, [0.0; 3], [1.0; 3]).unwrap();
        assert!(volume.prepared([0.0, 1.0]).values.iter().all(|v| (0.0..=1.0).contains(v)));
    }

    #[test]
    fn the_field_beside_a_solid_goes_on_into_it() {
        let array = Array::per_cell("phi", [12, 4, 4], |c| [if c[0] < 6 { 3.0f32 } else { 0.0 }]);
        let mut volume = Volume::new(&array, [0.0; 3], [1.0; 3]).unwrap();
        volume.set_solid(|p| 6.0 - p[0]);
        let row: Vec<f32> = volume.values()[..12].to_vec();
        assert_eq!(row, [3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn the_extent_is_that_of_what_can_be_seen_and_of_solids() {
        let array = Array::per_cell("phi", [10, 10, 10], |c| [if c == [2, 3, 4] { 1.0f32 } else { 0.01 }]);
        let mut volume = Volume::new(&array, [1.0; 3], [0.5; 3]).unwrap();
        let near = |a: V3, b: V3| (0..3).all(|n| (a[n] - b[n]).abs() < 1e-12);
        let [low, high] = volume.extent_above(0.1).unwrap();
        assert!(near(low, [2.0, 2.5, 3.0]) && near(high, [2.5, 3.0, 3.5]), "{low:?} {high:?}");
        assert!(volume.extent_above(2.0).is_none());
        volume.set_solid(|p| p[0].max(p[1]).max(p[2]) - 1.5);
        assert!(near(volume.extent_above(2.0).unwrap()[1], [1.5; 3]));
        assert!(near(volume.extent_above(0.1).unwrap()[0], [1.0; 3]));
    }

    #[test]
    fn a_column_is_what_half_of_the_field_is_seen_through() {
        let array = Array::per_cell("phi", [10, 4, 5], |c| [if c[0] < 5 && c[1] == 2 { 2.0f32 } else { 0.0 }]);
        let volume = Volume::new(&array, [0.0; 3], [0.1; 3]).unwrap();
        assert!((volume.column(2, 0.0) - 1.0).abs() < 1e-6 && (volume.column(0, 1.0) - 0.5).abs() < 1e-6);
        assert_eq!(volume.column(1, 3.0), 0.0);
    }
}
