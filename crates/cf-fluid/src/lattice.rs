//! Where a transported quantity has its values, and how they continue behind walls.
//!
//! The flow next to a closed wall and its mirror image together solve Euler's equations in all of space. So values
//! continue evenly behind a closed wall, but the normal velocity, which is odd. Behind other walls the outermost value
//! continues; what is carried in through them is the business of `carry`.

use cf_grid::{End, Layout, Real, Region, Sides};

use crate::wall::FlowWall;

/// What lies behind an end of a line of values.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Beyond {
    /// The mirror image, the wall half a cell behind the outermost value.
    Even,
    /// The negative mirror image, the wall on the outermost value.
    Odd,
    /// The outermost value.
    Same,
}

/// The values along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Line {
    Ring { count: i64 },
    Walls { last: i64, ends: [Beyond; 2] },
}

/// Cells, or the faces normal to one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lattice<const D: usize> {
    pub layout: Layout<D>,
    /// The axis of faces; `None` for cells.
    pub normal: Option<usize>,
    /// Indices that hold a value.
    pub region: Region<D>,
    lines: [Line; D],
    /// What enters through each wall, and the distance from the outermost value to it \[cells\].
    pub inflow: Sides<Option<(f64, f64)>, D>,
}

impl<const D: usize> Lattice<D> {
    fn new(
        layout: &Layout<D>,
        sides: &Sides<FlowWall<D>, D>,
        normal: Option<usize>,
        carried: impl Fn(usize, End, FlowWall<D>) -> Option<f64>,
    ) -> Self {
        let lines = std::array::from_fn(|a| {
            let (n, along) = (layout.cells()[a] as i64, normal == Some(a));
            let beyond = |end| match sides.wall(a, end) {
                Some(FlowWall::Closed) if along => Beyond::Odd,
                Some(FlowWall::Closed) => Beyond::Even,
                _ => Beyond::Same,
            };
            if sides.is_periodic(a) {
                Line::Ring { count: n }
            } else {
                Line::Walls { last: if along { n } else { n - 1 }, ends: End::BOTH.map(beyond) }
            }
        });
        let region = match normal {
            Some(a) => layout.faces_region(a, sides.is_periodic(a)),
            None => layout.cells_region(),
        };
        let inflow =
            sides.map(|a, end, wall| carried(a, end, wall).map(|v| (v, if normal == Some(a) { 0.0 } else { 0.5 })));
        Self { layout: *layout, normal, region, lines, inflow }
    }

    /// The faces normal to `axis`, with the velocity component that walls let in.
    pub fn faces(layout: &Layout<D>, sides: &Sides<FlowWall<D>, D>, axis: usize) -> Self {
        Self::new(layout, sides, Some(axis), |_, _, wall| wall.carried_in().map(|u| u[axis]))
    }

    /// The cells, with the value that walls let in.
    pub fn cells(layout: &Layout<D>, sides: &Sides<FlowWall<D>, D>, inflow: impl Fn(usize, End) -> f64) -> Self {
        Self::new(layout, sides, None, |a, end, wall| wall.carried_in().map(|_| inflow(a, end)))
    }

    /// Distance of the values from the low faces of their cells along an axis \[cells\].
    #[inline(always)]
    pub fn half(&self, axis: usize) -> f64 {
        if self.normal == Some(axis) { 0.0 } else { 0.5 }
    }

    /// Whether an axis ends in walls.
    #[inline(always)]
    pub fn walled(&self, axis: usize) -> bool {
        matches!(self.lines[axis], Line::Walls { .. })
    }

    /// The last index along an axis.
    #[inline(always)]
    pub fn last(&self, axis: usize) -> i64 {
        match self.lines[axis] {
            Line::Ring { count } => count - 1,
            Line::Walls { last, .. } => last,
        }
    }

    /// The last index along x that has a slot.
    #[inline(always)]
    pub fn stored(&self) -> i64 {
        self.layout.cells()[0] as i64
    }

    /// Continues rows by one value beyond either end, into the rim, as far as there are slots, so that most stretches need
    /// not ask what lies there.
    pub fn continue_rows<T: Real>(&self, field: &mut [T]) {
        let (n, high) = (self.layout.cells()[0], self.last(0) + 1);
        let low = self.place(0, -1);
        let beyond = (high == n as i64).then(|| self.place(0, high));
        let signed = |(index, flip): (usize, bool), row: &[T]| if flip { -row[1 + index] } else { row[1 + index] };
        for row in field.chunks_exact_mut(n + 2) {
            row[0] = signed(low, row);
            if let Some(beyond) = beyond {
                row[1 + n] = signed(beyond, row);
            }
        }
    }

    /// The stored index that stands for `index`, and whether its value changes sign.
    #[inline(always)]
    pub fn place(&self, axis: usize, index: i64) -> (usize, bool) {
        match self.lines[axis] {
            Line::Ring { count } => {
                (if (0..count).contains(&index) { index } else { index.rem_euclid(count) } as usize, false)
            }
            Line::Walls { last, ends } => {
                if (0..=last).contains(&index) {
                    return (index as usize, false);
                }
                let (beyond, outside) = if index < 0 { (ends[0], -index) } else { (ends[1], index - last) };
                let inwards = match beyond {
                    Beyond::Even => outside - 1,
                    Beyond::Odd => outside,
                    Beyond::Same => 0,
                };
                let inwards = inwards.clamp(0, last);
                ((if index < 0 { inwards } else { last - inwards }) as usize, beyond == Beyond::Odd)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_grid::Axis;

    #[test]
    fn values_continue_as_walls_say() {
        let layout = Layout::new([4, 3]).unwrap();
        let sides = Sides([Axis::Walls([FlowWall::Closed, FlowWall::Open([1.0, 2.0])]), Axis::Periodic]);
        let (cells, faces) = (Lattice::cells(&layout, &sides, |_, _| 7.0), Lattice::faces(&layout, &sides, 0));
        assert_eq!((cells.place(0, -1), cells.place(0, -2), cells.place(0, 9)), ((0, false), (1, false), (3, false)));
        assert_eq!((faces.place(0, -1), faces.place(0, 6)), ((1, true), (4, false)));
        assert_eq!((faces.place(1, -1), faces.place(1, 3)), ((2, false), (0, false)));
        assert_eq!(cells.inflow.wall(0, End::High).flatten(), Some((7.0, 0.5)));
        assert_eq!(faces.inflow.wall(0, End::High).flatten(), Some((1.0, 0.0)));
        assert_eq!(faces.inflow.wall(0, End::Low).flatten(), None);
    }
}
