//! The surface of the box as the steps see it (model/diffusion.md section 4).
//!
//! | wall | operator | right-hand side | q_C on the face |
//! |---|---|---|---|
//! | flux g | 0 | - dt g/h | none |
//! | value v | 2 kappa | 2 kappa v | stored, gradient over h/2 |
//! | absorbing c | dt c/h | dt c far/h | none, q·n = c (phi - far) |
//! | open | 0 | 0 | none |

use cf_grid::{End, FaceField, Layout, Mask, Real, Sides, Wall};

/// One fluid cell on a wall.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WallCell {
    pub axis: usize,
    pub end: End,
    pub wall: Wall,
    /// Slot of the cell.
    pub cell: usize,
    /// Slot of its wall face.
    pub face: usize,
}

/// The walls of a domain: sides, obstacles, and which faces are open.
#[derive(Debug, Clone)]
pub(crate) struct Walls<T, const D: usize> {
    pub layout: Layout<D>,
    pub sides: Sides<Wall, D>,
    pub mask: Option<Mask<D>>,
    /// 1 on faces between fluid cells, 0 elsewhere; only with a mask.
    pub open: Option<FaceField<T, D>>,
}

impl<T: Real, const D: usize> Walls<T, D> {
    pub fn new(layout: &Layout<D>, sides: &Sides<Wall, D>, mask: Option<Mask<D>>) -> Self {
        let open = mask.as_ref().map(|mask| {
            let mut open = FaceField::new(layout);
            for a in 0..D {
                let last = layout.cells()[a] - 1;
                layout.par_region(layout.faces_region(a, false), open.axis_mut(a), |at| {
                    let i = at.cell[a];
                    let mut pair = [at.cell; 2];
                    if i > 0 {
                        pair[0][a] = i - 1;
                    } else {
                        pair[0][a] = last;
                    }
                    if i > last {
                        pair[1][a] = 0;
                    }
                    let inner = (i > 0 && i <= last) || sides.is_periodic(a);
                    let wet = pair.map(|c| mask.fluid()[layout.slot(c)]);
                    if inner && wet[0] && wet[1] { T::ONE } else { T::ZERO }
                });
            }
            open
        });
        Self { layout: *layout, sides: *sides, mask, open }
    }

    /// Every fluid cell on every wall.
    pub fn each(&self, mut f: impl FnMut(WallCell)) {
        for (axis, end, wall) in self.sides.walls() {
            let mut region = self.layout.cells_region();
            match end {
                End::Low => region.high[axis] = 1,
                End::High => region.low[axis] = self.layout.cells()[axis] - 1,
            }
            self.layout.each_cell(region, |at| {
                if self.mask.as_ref().is_none_or(|m| m.fluid()[at.slot()]) {
                    let face = if end == End::Low { at.slot() } else { at.high(axis) };
                    f(WallCell { axis, end, wall, cell: at.slot(), face });
                }
            });
        }
    }

    /// Fills the rim of a cell field: copies across periodic seams, mirrors at walls.
    pub fn fill_rim(&self, x: &mut [T]) {
        for a in 0..D {
            if self.sides.is_periodic(a) {
                self.layout.wrap_rim(a, x);
            } else {
                self.layout.mirror_rim(a, x);
            }
        }
    }

    /// Copies seam faces to the high rim, where divergences read them.
    pub fn fill_seams(&self, q: &mut FaceField<T, D>) {
        for a in (0..D).filter(|&a| self.sides.is_periodic(a)) {
            self.layout.wrap_rim(a, q.axis_mut(a));
        }
    }

    /// Conductances of the homogeneous operator: 2 kappa for values, dt c/h for absorbing walls, 0 for the others.
    pub fn conductances(&self, kappa: f64, dt_per_h: f64) -> Sides<f64, D> {
        self.sides.map(|_, _, wall| match wall {
            Wall::Value(_) => 2.0 * kappa,
            Wall::Absorbing { speed, .. } => dt_per_h * speed,
            Wall::Flux(_) | Wall::Open { .. } => 0.0,
        })
    }

    /// Fluid cells per connected component, with labels; one component without a mask.
    pub fn components(&self) -> Option<cf_grid::Components> {
        self.mask.as_ref().map(|m| m.components(&self.sides))
    }
}
