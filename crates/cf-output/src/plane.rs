//! A scalar on a rectangle of cells: a 2D field, or a cut through a 3D one.

use crate::OutputError;
use crate::array::Array;

/// What of an array is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Part {
    /// The value itself of a scalar; the Euclidean norm of several components.
    #[default]
    Magnitude,
    /// One component, from 0.
    Component(usize),
}

/// A layer of cells perpendicular to an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slice {
    /// 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Number of the layer from the low side.
    pub index: usize,
}

/// Cell values on a rectangle, the horizontal axis contiguous, the vertical axis upwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    cells: [usize; 2],
    origin: [f64; 2],
    spacing: f64,
    values: Vec<f64>,
    /// One word per cell; empty where no cell is solid.
    solid: Vec<bool>,
}

impl Plane {
    /// Takes one layer of an array on a grid with `origin` and cubic cells of size `spacing`. A 2D field is the
    /// layer `Slice { axis: 2, index: 0 }`. Cuts across x show y to the right and z upwards; across y, x and z.
    ///
    /// # Errors
    /// [`OutputError::Array`] for a layer or component the array does not have, [`OutputError::Request`] for a grid
    /// without size.
    pub fn cut(array: &Array, slice: Slice, part: Part, origin: [f64; 3], spacing: f64) -> Result<Self, OutputError> {
        let (shape, components) = (array.source.shape(), array.source.components());
        let refuse = |reason: String| Err(OutputError::array(&array.name, reason));
        if slice.axis > 2 || slice.index >= shape[slice.axis] {
            return refuse(format!("has no layer {} along axis {}; its shape is {shape:?}", slice.index, slice.axis));
        }
        if matches!(part, Part::Component(c) if c >= components) || components == 0 {
            return refuse(format!("has no {part:?}; it has {components} components"));
        }
        let [right, up] = [[1, 2], [0, 2], [0, 1]][slice.axis];
        let mut values = Vec::with_capacity(shape[right].saturating_mul(shape[up]).min(1 << 28));
        let mut bytes = vec![];
        for row in 0..shape[up] {
            bytes.clear();
            // Across x, a row of the picture visits one cell of each row of the field.
            match slice.axis {
                0 => (0..shape[1]).for_each(|y| array.source.row(slice.index..slice.index + 1, y, row, &mut bytes)),
                1 => array.source.row(0..shape[0], slice.index, row, &mut bytes),
                _ => array.source.row(0..shape[0], row, slice.index, &mut bytes),
            }
            let (mut component, mut value) = (0, 0.0_f64);
            array.source.precision().decode(&bytes, |v| {
                match part {
                    Part::Component(c) if c == component => value = v,
                    Part::Component(_) => {}
                    Part::Magnitude if components == 1 => value = v,
                    // hypot of NaN and infinity is infinity; a cell without a number must stay one.
                    Part::Magnitude => value = if v.is_nan() { v } else { value.hypot(v) },
                }
                component += 1;
                if component == components {
                    values.push(value);
                    (component, value) = (0, 0.0);
                }
            });
        }
        Self::new([shape[right], shape[up]], [origin[right], origin[up]], spacing, values)
    }

    /// From values at hand, row by row from the bottom.
    ///
    /// # Errors
    /// [`OutputError::Request`] unless there is one value per cell, at least one cell, and a finite grid of
    /// positive spacing.
    pub fn new(cells: [usize; 2], origin: [f64; 2], spacing: f64, values: Vec<f64>) -> Result<Self, OutputError> {
        let refuse = |reason: String| Err(OutputError::request("picture", reason));
        if values.is_empty() || cells[0].checked_mul(cells[1]) != Some(values.len()) {
            return refuse(format!("{} values for {cells:?} cells", values.len()));
        }
        if !(spacing.is_finite() && spacing > 0.0 && origin.iter().all(|o| o.is_finite())) {
            return refuse(format!("origin {origin:?} and spacing {spacing} are no grid"));
        }
        Ok(Self { cells, origin, spacing, values, solid: Vec::new() })
    }

    /// The same with cells that are solid: they have no value, whatever is stored for them.
    ///
    /// # Errors
    /// [`OutputError::Request`] unless there is one word per cell.
    pub fn with_solid(mut self, solid: Vec<bool>) -> Result<Self, OutputError> {
        if solid.len() != self.values.len() {
            let reason = format!("{} words for the solid ones of {} cells", solid.len(), self.values.len());
            return Err(OutputError::request("picture", reason));
        }
        self.solid = solid;
        Ok(self)
    }

    fn is_solid(&self, cell: usize) -> bool {
        self.solid.get(cell).copied().unwrap_or(false)
    }

    /// Cells to the right and upwards.
    pub fn cells(&self) -> [usize; 2] {
        self.cells
    }

    /// Low corner.
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// High corner.
    pub fn end(&self) -> [f64; 2] {
        [0, 1].map(|a| self.origin[a] + self.spacing * self.cells[a] as f64)
    }

    /// Smallest and largest finite value; +∞ and −∞ if there is none.
    pub fn range(&self) -> [f64; 2] {
        let finite = self.values.iter().enumerate().filter(|(cell, v)| v.is_finite() && !self.is_solid(*cell));
        finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], (_, &v)| [a.min(v), b.max(v)])
    }

    /// Means over the cells that are not solid in blocks of `by` × `by` (fewer at the high sides), `None` where all are.
    /// A block with a NaN is NaN: a broken cell must not vanish in a small picture.
    pub(crate) fn reduced(&self, by: usize) -> ([usize; 2], Vec<Option<f64>>) {
        let by = by.max(1);
        let [nx, ny] = self.cells;
        let small = [nx.div_ceil(by), ny.div_ceil(by)];
        if by == 1 {
            let one = |(cell, value): (usize, &f64)| (!self.is_solid(cell)).then_some(*value);
            return (small, self.values.iter().enumerate().map(one).collect());
        }
        let mut values = Vec::with_capacity(small[0] * small[1]);
        for j in 0..small[1] {
            for i in 0..small[0] {
                let rows = j * by..ny.min((j + 1) * by);
                let columns = i * by..nx.min((i + 1) * by);
                let block = || rows.clone().flat_map(|y| y * nx + columns.start..y * nx + columns.end);
                let fluid = || block().filter(|cell| !self.is_solid(*cell));
                let count = fluid().count() as f64;
                values.push((count > 0.0).then(|| fluid().map(|cell| self.values[cell] / count).sum()));
            }
        }
        (small, values)
    }
}

/// The range that holds several pictures, for one colour scale in all of them.
pub fn common_range(planes: &[Plane]) -> [f64; 2] {
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    planes.iter().map(Plane::range).fold(start, |[a, b], [low, high]| [a.min(low), b.max(high)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field() -> Array<'static> {
        Array::per_cell("f", [2, 3, 4], |[i, j, k]| [(i + 10 * j + 100 * k) as f64])
    }

    #[test]
    fn cuts_show_the_layer_they_name() {
        let cut =
            |axis, index| Plane::cut(&field(), Slice { axis, index }, Part::Magnitude, [1.0, 2.0, 3.0], 0.5).unwrap();
        let z = cut(2, 3);
        assert_eq!((z.cells, z.origin, z.end()), ([2, 3], [1.0, 2.0], [2.0, 3.5]));
        assert_eq!(z.values, [300.0, 301.0, 310.0, 311.0, 320.0, 321.0]);
        let x = cut(0, 1);
        assert_eq!((x.cells, x.origin), ([3, 4], [2.0, 3.0]));
        assert_eq!(x.values[..4], [1.0, 11.0, 21.0, 101.0]);
        assert_eq!(cut(1, 2).values[..3], [20.0, 21.0, 120.0]);
    }

    #[test]
    fn vectors_show_a_component_or_their_length() {
        let array = Array::per_cell("u", [2, 1, 1], |[i, ..]| [3.0_f32, 4.0, if i == 1 { f32::NAN } else { 0.0 }]);
        let cut = |part| Plane::cut(&array, Slice { axis: 2, index: 0 }, part, [0.0; 3], 1.0);
        let length = cut(Part::Magnitude).unwrap();
        assert!(length.values[0] == 5.0 && length.values[1].is_nan());
        assert_eq!(cut(Part::Component(1)).unwrap().values, [4.0, 4.0]);
        assert!(cut(Part::Component(3)).is_err());
        assert!(Plane::cut(&array, Slice { axis: 2, index: 1 }, Part::Magnitude, [0.0; 3], 1.0).is_err());
        assert!(Plane::cut(&array, Slice { axis: 3, index: 0 }, Part::Magnitude, [0.0; 3], 1.0).is_err());
    }

    #[test]
    fn reducing_averages_blocks_and_keeps_broken_cells() {
        let values = vec![1.0, 3.0, 10.0, 5.0, 7.0, 20.0, 0.0, 2.0, f64::NAN];
        let plane = Plane::new([3, 3], [0.0; 2], 1.0, values).unwrap();
        let (cells, small) = plane.reduced(2);
        assert_eq!((cells, &small[..3]), ([2, 2], &[4.0, 15.0, 1.0].map(Some)[..]));
        assert!(small[3].is_some_and(f64::is_nan));
        let mut solid = vec![false; 9];
        (solid[0], solid[8]) = (true, true);
        let (_, small) = plane.clone().with_solid(solid).unwrap().reduced(2);
        assert_eq!(small, [Some(5.0), Some(15.0), Some(1.0), None]);
        assert!(plane.clone().with_solid(vec![true; 8]).is_err());
        assert_eq!(plane.range(), [0.0, 20.0]);
    }

    #[test]
    fn planes_without_meaning_are_refused() {
        assert!(Plane::new([2, 2], [0.0; 2], 1.0, vec![0.0; 3]).is_err());
        assert!(Plane::new([0, 2], [0.0; 2], 1.0, vec![]).is_err());
        assert!(Plane::new([1, 1], [0.0; 2], 0.0, vec![0.0]).is_err());
    }
}
