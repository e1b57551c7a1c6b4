//! The cells near obstacles, which a level with stored coefficients relaxes more often than the others.
//!
//! Coarse cells cut by an obstacle stand for fine cells that may not even be joined, so the coarse correction is poor
//! there and leaves errors that only smoothing removes. Extra sweeps over a band of cells before and after each smoother
//! cost little where obstacles are few, and halve the iterations (docs/solver.md). A sweep passes over the band alone, not over the level.

use cf_grid::{Layout, Real};

use crate::axis::AxisTable;
use crate::stencil::StoredStencil;

/// Runs of cells, row by row.
#[derive(Debug, Clone)]
pub(crate) struct Band {
    /// Runs of row r: `runs[starts[r]..starts[r + 1]]`.
    starts: Vec<u32>,
    /// First cell and the cell after the last.
    runs: Vec<[u32; 2]>,
}

/// A cell is irregular where its two faces along an axis differ by more than this factor.
const JUMP: f64 = 0.5;

impl Band {
    /// The cells that are irregular or have an irregular one among their 3^D - 1 neighbours: cells that are not all
    /// open, and cells at a jump of the coefficient. `open` is the open volume of each cell, solid cells have none.
    /// `None` where there are no such cells.
    pub fn new<T: Real, const D: usize>(
        layout: &Layout<D>,
        axes: &[AxisTable; D],
        stencil: &StoredStencil<T, D>,
        open: &[f64],
    ) -> Option<Self> {
        let mut near = vec![0u8; layout.slots()];
        layout.par_cells(&mut near, |at| {
            let volume: f64 = (0..D).map(|a| axes[a].width[at.cell[a]]).product();
            let cut = open[at.slot()] < (1.0 - 1e-9) * volume;
            let jump = (0..D).any(|a| {
                let i = at.cell[a];
                let ends = [(i, at.slot()), (i + 1, at.high(a))];
                // A closed wall has no coefficient.
                if ends.iter().any(|&(face, _)| axes[a].face[face] == 0.0) {
                    return false;
                }
                let [low, high] = ends.map(|(face, slot)| stencil.face[a][slot].f64() / axes[a].face[face]);
                low.min(high) < JUMP * low.max(high)
            });
            u8::from(cut || jump)
        });
        let mut next = near.clone();
        for a in 0..D {
            if axes[a].periodic {
                layout.wrap_rim(a, &mut near);
            }
            layout.par_cells(&mut next, |at| near[at.low(a)] | near[at.slot()] | near[at.high(a)]);
            near.copy_from_slice(&next);
        }
        let (mut starts, mut runs) = (Vec::new(), Vec::<[u32; 2]>::new());
        let mut fresh = true;
        layout.each_cell(layout.cells_region(), |at| {
            let i = at.cell[0] as u32;
            if i == 0 {
                starts.push(runs.len() as u32);
                fresh = true;
            }
            if near[at.slot()] == 0 || stencil.inverse[at.slot()] == T::ZERO {
                return;
            }
            match runs.last_mut() {
                Some(run) if !fresh && run[1] == i => run[1] = i + 1,
                _ => runs.push([i, i + 1]),
            }
            fresh = false;
        });
        starts.push(runs.len() as u32);
        (!runs.is_empty()).then_some(Self { starts, runs })
    }

    /// Runs of the row that a cell is in.
    #[inline]
    pub fn row<const D: usize>(&self, layout: &Layout<D>, cell: [usize; D]) -> &[[u32; 2]] {
        let row = (1..D).rev().fold(0, |row, a| row * layout.cells()[a] + cell[a]);
        &self.runs[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.runs[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn band(walls: Option<[f64; 2]>, solid: &[[usize; 2]]) -> Option<Vec<Vec<[u32; 2]>>> {
        let layout = Layout::new([9, 6]).unwrap();
        let axes: [_; 2] = std::array::from_fn(|a| AxisTable::new(layout.cells()[a], 1.0, walls));
        let open_at = |c: [usize; 2]| !solid.contains(&c);
        let (mut mass, mut open) = (vec![0.0; layout.slots()], vec![0.0; layout.slots()]);
        layout.par_cells(&mut mass, |at| f64::from(u8::from(open_at(at.cell))));
        open.copy_from_slice(&mass);
        let face = std::array::from_fn(|a| {
            let mut w = vec![0.0; layout.slots()];
            let low = |mut c: [usize; 2]| {
                c[a] = (c[a] + axes[a].len() - 1) % axes[a].len();
                c
            };
            layout.par_cells(&mut w, |at| if open_at(at.cell) && open_at(low(at.cell)) { 1.0 } else { 0.0 });
            if walls.is_none() {
                layout.wrap_rim(a, &mut w);
            }
            w
        });
        let stencil = StoredStencil::<f64, 2>::new(&layout, &mass, &face);
        let band = Band::new(&layout, &axes, &stencil, &open)?;
        Some((0..6).map(|j| band.row(&layout, [0, j]).to_vec()).collect())
    }

    #[test]
    fn a_box_has_none() {
        assert_eq!(band(Some([0.0; 2]), &[]), None);
        assert_eq!(band(None, &[]), None);
    }

    #[test]
    fn an_obstacle_has_two_rings() {
        // (4, 2) is solid, so its neighbours have a closed face, and theirs are near it.
        let rows = band(Some([0.0; 2]), &[[4, 2]]).unwrap();
        assert_eq!(rows[2], [[2, 4], [5, 7]]);
        assert!(rows[0].iter().all(|r| r[0] >= 2 && r[1] <= 7) && !rows[0].is_empty());
        assert!(rows[5].is_empty());
    }

    #[test]
    fn it_wraps() {
        let rows = band(None, &[[0, 2]]).unwrap();
        // (1, 2) and (8, 2) have a closed face.
        assert_eq!(rows[2], [[1, 3], [7, 9]]);
    }
}
