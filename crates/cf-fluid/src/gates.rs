//! Which faces the pressure moves, and what the others hold.
//!
//! Faces between fluid cells are open. Faces of solids hold 0, wall faces what their wall says, and emitters may hold
//! faces of their own. Closed faces have the pressure coefficient 0, so that no solve changes them: no-penetration is
//! exact for any tolerance.

use cf_grid::{End, FaceField, Layout, Mask, Real, Region, Sides};

use crate::wall::FlowWall;

/// A face with a velocity of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Held {
    pub axis: usize,
    /// Slot of the face, the low one of a periodic seam.
    pub slot: usize,
    /// Velocity \[m/s\].
    pub velocity: f64,
}

/// The faces of a box with solids.
#[derive(Debug, Clone)]
pub(crate) struct Gates<const D: usize> {
    layout: Layout<D>,
    sides: Sides<FlowWall<D>, D>,
    /// Per axis and slot; `None` where all inner faces are open.
    open: Option<[Vec<bool>; D]>,
    fluid: Option<Vec<bool>>,
    held: Vec<Held>,
}

impl<const D: usize> Gates<D> {
    pub fn new(layout: &Layout<D>, sides: &Sides<FlowWall<D>, D>, mask: Option<&Mask<D>>, held: Vec<Held>) -> Self {
        let fluid = mask.map(Mask::fluid);
        let open = (mask.is_some() || !held.is_empty()).then(|| {
            let mut open: [Vec<bool>; D] = std::array::from_fn(|a| {
                let mut open = vec![false; layout.slots()];
                let n = layout.cells()[a];
                layout.par_region(layout.faces_region(a, sides.is_periodic(a)), &mut open, |at| {
                    let wet = |cell: [usize; D]| fluid.is_none_or(|f| f[layout.slot(cell)]);
                    let mut below = at.cell;
                    below[a] = (at.cell[a] + n - 1) % n;
                    match at.cell[a] {
                        _ if sides.is_periodic(a) => wet(below) && wet(at.cell),
                        0 => wet(at.cell) && sides.wall(a, End::Low).is_some_and(|w| w.conductance() > 0.0),
                        i if i == n => wet(below) && sides.wall(a, End::High).is_some_and(|w| w.conductance() > 0.0),
                        _ => wet(below) && wet(at.cell),
                    }
                });
                open
            });
            held.iter().for_each(|h| open[h.axis][h.slot] = false);
            open
        });
        Self { layout: *layout, sides: *sides, open, fluid: fluid.map(<[bool]>::to_vec), held }
    }

    /// Flags of open faces along an axis; `None` where all inner faces are.
    pub fn open(&self, axis: usize) -> Option<&[bool]> {
        self.open.as_ref().map(|open| &open[axis][..])
    }

    pub fn sides(&self) -> &Sides<FlowWall<D>, D> {
        &self.sides
    }

    pub fn held(&self) -> &[Held] {
        &self.held
    }

    pub fn bytes(&self) -> usize {
        let open = self.open.iter().flatten().map(Vec::len).sum::<usize>();
        open + self.fluid.as_ref().map_or(0, Vec::len) + std::mem::size_of_val(&self.held[..])
    }

    /// Share of the conductance of each face for the solver; `None` where a mask says it all.
    pub fn shares(&self) -> Option<FaceField<f64, D>> {
        (!self.held.is_empty()).then(|| {
            let mut shares = FaceField::new(&self.layout);
            for a in 0..D {
                shares.axis_mut(a).fill(1.0);
            }
            self.held.iter().for_each(|h| shares.axis_mut(h.axis)[h.slot] = 0.0);
            shares
        })
    }

    /// Sets every closed face to its velocity.
    pub fn impose<T: Real>(&self, u: &mut FaceField<T, D>) {
        for a in 0..D {
            if let Some(open) = &self.open {
                self.layout.par_runs(
                    self.layout.faces_region(a, self.sides.is_periodic(a)),
                    u.axis_mut(a),
                    #[inline(always)]
                    |run, u: &mut [T]| {
                        for (u, &open) in u.iter_mut().zip(run.row(&open[a])) {
                            *u = if open { *u } else { T::ZERO };
                        }
                    },
                );
            }
            for end in End::BOTH {
                let Some(velocity) = self.sides.wall(a, end).and_then(|w| w.held(a)) else { continue };
                let fluid = self.fluid.as_deref();
                self.layout.par_region(wall_faces(&self.layout, a, end), u.axis_mut(a), |at| {
                    let inside = if end == End::Low { at.slot() } else { at.low(a) };
                    T::of(if fluid.is_none_or(|f| f[inside]) { velocity } else { 0.0 })
                });
            }
        }
        for held in &self.held {
            u.axis_mut(held.axis)[held.slot] = T::of(held.velocity);
        }
    }
}

/// The faces of one wall.
pub(crate) fn wall_faces<const D: usize>(layout: &Layout<D>, axis: usize, end: End) -> Region<D> {
    let mut region = layout.faces_region(axis, false);
    match end {
        End::Low => region.high[axis] = 1,
        End::High => region.low[axis] = layout.cells()[axis],
    }
    region
}
