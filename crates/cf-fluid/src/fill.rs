//! Velocities within solids, for interpolation next to them: the mean of the nearest fluid's, layer by layer, so that the
//! fluid slips along solids.

use cf_grid::{Mask, Real};

use crate::lattice::Lattice;

/// Layers of faces that get a value: the reach of a cubic and a cell of motion.
const LAYERS: usize = 4;

/// Faces between solid cells and the faces whose mean they get, in the order of the layers.
#[derive(Debug, Clone)]
pub(crate) struct Fill {
    /// Slot, end of its sources in `sources`.
    faces: Vec<(usize, usize)>,
    sources: Vec<usize>,
}

impl Fill {
    pub fn new<const D: usize>(lattice: &Lattice<D>, mask: &Mask<D>) -> Self {
        let (layout, fluid) = (&lattice.layout, mask.fluid());
        let mut fill = Self { faces: Vec::new(), sources: Vec::new() };
        let Some(axis) = lattice.normal else { return fill };
        let mut known = vec![false; layout.slots()];
        layout.each_cell(lattice.region, |at| {
            let mut below = at.cell;
            below[axis] = lattice.place(axis, at.cell[axis] as i64 - 1).0;
            // Wall faces belong to the cell inside; the rim is solid.
            let low = at.cell[axis] > 0 || !lattice.walled(axis);
            known[at.slot()] = fluid[at.slot()] || (low && fluid[layout.slot(below)]);
        });
        for _ in 0..LAYERS {
            let mut layer = Vec::new();
            layout.each_cell(lattice.region, |at| {
                if known[at.slot()] {
                    return;
                }
                let before = fill.sources.len();
                for a in 0..D {
                    for by in [-1, 1] {
                        let mut near = at.cell;
                        near[a] = lattice.place(a, at.cell[a] as i64 + by).0;
                        let slot = layout.slot(near);
                        if known[slot] {
                            fill.sources.push(slot);
                        }
                    }
                }
                if fill.sources.len() > before {
                    fill.faces.push((at.slot(), fill.sources.len()));
                    layer.push(at.slot());
                }
            });
            layer.iter().for_each(|&slot| known[slot] = true);
        }
        fill
    }

    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&self.faces[..]) + std::mem::size_of_val(&self.sources[..])
    }

    pub fn apply<T: Real>(&self, u: &mut [T]) {
        let mut begin = 0;
        for &(slot, end) in &self.faces {
            let sum: f64 = self.sources[begin..end].iter().map(|&s| u[s].f64()).sum();
            u[slot] = T::of(sum / (end - begin) as f64);
            begin = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wall::FlowWall;
    use cf_grid::{FaceField, Grid, Sides};

    #[test]
    fn a_uniform_stream_goes_on_inside_solids() {
        let grid = Grid::new([12, 12], 1.0).unwrap();
        let layout = grid.layout();
        let mask = Mask::new(layout, |c| !(4..8).contains(&c[0]) || !(4..8).contains(&c[1]));
        let lattice = Lattice::faces(layout, &Sides::all(FlowWall::OPEN), 0);
        let mut u = FaceField::<f64, 2>::new(layout);
        layout.each_cell(lattice.region, |at| {
            let solid = |i: usize| i < 12 && !mask.fluid()[layout.slot([i, at.cell[1]])];
            let inside = at.cell[0] > 0 && solid(at.cell[0] - 1) && solid(at.cell[0]);
            u.axis_mut(0)[at.slot()] = if inside { -9.0 } else { 3.0 };
        });
        Fill::new(&lattice, &mask).apply(u.axis_mut(0));
        layout.each_cell(lattice.region, |at| assert_eq!(u.axis(0)[at.slot()], 3.0));
    }
}
