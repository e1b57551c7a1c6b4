//! The modes of a whole box: the transforms of its axes, one after the other.
//!
//! Each axis is transformed while its numbers are contiguous; then the array is turned so that the next axis is. After
//! all of them it lies as at first, x contiguous.

use rayon::prelude::*;

use cf_diffusion::exact::Walls;
use cf_grid::{Axis, Grid, Sides, Wall};

use crate::error::SpectralError;
use crate::transform::{AxisTransform, Direction, Of};

/// Columns that are turned together: a cache line of doubles, twice.
const BAND: usize = 16;

/// The transforms of a box.
pub(crate) struct Modes<const D: usize> {
    pub axes: [AxisTransform; D],
}

impl<const D: usize> Modes<D> {
    /// The transforms that belong to the walls of a box.
    pub fn new(grid: &Grid<D>, sides: &Sides<Wall, D>, of: Of) -> Result<Self, SpectralError> {
        for (axis, end, wall) in sides.walls() {
            if !matches!(wall, Wall::Value(v) if v.is_finite()) && wall != Wall::CLOSED {
                return Err(SpectralError::Wall { axis, end, wall });
            }
        }
        let mut axes = Vec::with_capacity(D);
        for (axis, &cells) in grid.cells().iter().enumerate() {
            let modes = AxisTransform::new(walls(sides.0[axis]), cells, grid.h(), of);
            axes.push(modes.ok_or(SpectralError::Cells { axis, cells })?);
        }
        let Ok(axes) = axes.try_into() else { unreachable!("one entry was pushed per axis") };
        Ok(Self { axes })
    }

    /// Cells and modes.
    pub fn count(&self) -> usize {
        self.axes.iter().map(AxisTransform::cells).product()
    }

    /// Transforms `data`, with `work` of the same length; what `work` holds afterwards is of no use.
    pub fn transform(&self, direction: Direction, data: &mut Vec<f64>, work: &mut Vec<f64>) {
        for axis in &self.axes {
            axis.rows(direction, data);
            turn(axis.cells(), data, work);
            std::mem::swap(data, work);
        }
    }

    /// Calls `f` with the eigenvalue Λ \[1/m²\] of every mode and its numbers in two arrays, in parallel.
    pub fn each(&self, one: &mut [f64], two: &mut [f64], f: impl Fn(usize, f64, &mut f64, &mut f64) + Sync) {
        let n = self.axes[0].cells();
        one.par_chunks_mut(n).zip(two.par_chunks_mut(n)).enumerate().for_each(|(row, (one, two))| {
            let mut rest = row;
            let mut others = 0.0;
            for axis in &self.axes[1..] {
                others += axis.eigenvalues()[rest % axis.cells()];
                rest /= axis.cells();
            }
            let numbers = one.iter_mut().zip(two).zip(self.axes[0].eigenvalues());
            numbers.enumerate().for_each(|(i, ((one, two), own))| f(row * n + i, own + others, one, two));
        });
    }
}

fn walls(axis: Axis<Wall>) -> Walls {
    let valued = |wall| matches!(wall, Wall::Value(_));
    match axis {
        Axis::Periodic => Walls::Periodic,
        Axis::Walls([low, high]) => match (valued(low), valued(high)) {
            (false, false) => Walls::Closed,
            (true, true) => Walls::Valued,
            (false, true) => Walls::ClosedValued,
            (true, false) => Walls::ValuedClosed,
        },
    }
}

/// Rows of `columns` numbers become columns.
pub(crate) fn turn<T: Copy + Send + Sync>(columns: usize, data: &[T], out: &mut [T]) {
    let rows = data.len() / columns;
    out.par_chunks_mut(rows * BAND).enumerate().for_each(|(band, out)| {
        let first = band * BAND;
        let width = out.len() / rows;
        for row in 0..rows {
            for (j, &x) in data[row * columns + first..][..width].iter().enumerate() {
                out[j * rows + row] = x;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_all_axes_changes_nothing() {
        let cells = [5, 17, 3];
        let data: Vec<f64> = (0..5 * 17 * 3).map(f64::from).collect();
        let (mut now, mut work) = (data.clone(), data.clone());
        for n in cells {
            turn(n, &now, &mut work);
            std::mem::swap(&mut now, &mut work);
        }
        assert_eq!(now, data);
    }

    #[test]
    fn there_and_back_is_the_identity() {
        let walls = [Walls::Closed, Walls::Periodic, Walls::ValuedClosed];
        let axes = [6, 5, 4];
        let modes = Modes { axes: [0, 1, 2].map(|a| AxisTransform::new(walls[a], axes[a], 0.1, Of::Cells).unwrap()) };
        let data: Vec<f64> = (0..modes.count()).map(|i| (i as f64 * 0.7).sin()).collect();
        let (mut now, mut work) = (data.clone(), data.clone());
        modes.transform(Direction::There, &mut now, &mut work);
        modes.transform(Direction::Back, &mut now, &mut work);
        assert!(now.iter().zip(&data).all(|(a, b)| (a - b).abs() < 1e-14));
    }
}
