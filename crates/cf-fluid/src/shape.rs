//! Voxel shapes: what boxes, spheres and mask files cover.

use cf_grid::{Grid, Mask};

use crate::error::FlowError;

/// A region of space \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape<const D: usize> {
    /// All x with low <= x <= high.
    Box {
        /// Low corner \[m\].
        low: [f64; D],
        /// High corner \[m\].
        high: [f64; D],
    },
    /// All x with |x - center| <= radius.
    Sphere {
        /// Centre \[m\].
        center: [f64; D],
        /// Radius \[m\].
        radius: f64,
    },
}

impl<const D: usize> Shape<D> {
    /// Whether a point \[m\] lies inside or on the surface.
    pub fn contains(&self, x: &[f64; D]) -> bool {
        match self {
            Shape::Box { low, high } => (0..D).all(|a| low[a] <= x[a] && x[a] <= high[a]),
            Shape::Sphere { center, radius } => {
                let square: f64 = (0..D).map(|a| (x[a] - center[a]).powi(2)).sum();
                square <= radius * radius
            }
        }
    }

    /// Refuses numbers that are not finite, boxes turned inside out and negative radii.
    pub fn check(&self) -> Result<(), FlowError> {
        let refuse = |what, found, expected| Err(FlowError::Shape { what, found, expected });
        match *self {
            Shape::Box { low, high } => {
                for a in 0..D {
                    if !low[a].is_finite() {
                        return refuse("a box's low corner", low[a], "a finite number");
                    }
                    if !(high[a].is_finite() && high[a] >= low[a]) {
                        return refuse("a box's high corner", high[a], "a finite number not below its low corner");
                    }
                }
            }
            Shape::Sphere { center, radius } => {
                if let Some(&found) = center.iter().find(|c| !c.is_finite()) {
                    return refuse("a sphere's centre", found, "finite numbers");
                }
                if !(radius.is_finite() && radius >= 0.0) {
                    return refuse("a sphere's radius", radius, "a finite number of 0 or more");
                }
            }
        }
        Ok(())
    }
}

/// The mask of a box with obstacles: a cell is solid where its centre lies in one of the shapes.
pub fn obstacles<const D: usize>(grid: &Grid<D>, shapes: &[Shape<D>]) -> Result<Mask<D>, FlowError> {
    shapes.iter().try_for_each(Shape::check)?;
    Ok(Mask::new(grid.layout(), |cell| {
        let x: [f64; D] = grid.centre(cell).into();
        !shapes.iter().any(|shape| shape.contains(&x))
    }))
}

/// The mask in the bytes of a mask file: one byte per cell, x fastest, 0 fluid, anything else solid.
pub fn obstacles_from_bytes<const D: usize>(grid: &Grid<D>, bytes: &[u8]) -> Result<Mask<D>, FlowError> {
    let layout = grid.layout();
    if bytes.len() != layout.count() {
        return Err(FlowError::Layout { what: "the mask file", expected: layout.count(), found: bytes.len() });
    }
    let cells = layout.cells();
    Ok(Mask::new(layout, |cell| {
        let place = (0..D).rev().fold(0, |place, a| place * cells[a] + cell[a]);
        bytes[place] == 0
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_and_files_make_the_same_mask() {
        let grid = Grid::new([4, 3, 2], 1.0).unwrap();
        let solid = Shape::Box { low: [1.0, 0.0, 0.0], high: [2.0, 1.0, 2.0] };
        let mask = obstacles(&grid, &[solid, Shape::Sphere { center: [3.5, 2.5, 1.5], radius: 0.1 }]).unwrap();
        assert_eq!(mask.fluid_cells(), 24 - 3);
        let mut bytes = [0; 24];
        for place in [1, 13, 23] {
            bytes[place] = 1;
        }
        assert_eq!(obstacles_from_bytes(&grid, &bytes).unwrap(), mask);
        let error = obstacles_from_bytes(&grid, &bytes[1..]).unwrap_err();
        assert!(error.to_string().contains("23") && error.to_string().contains("24"));
    }

    #[test]
    fn shapes_without_sense_are_refused() {
        let grid = Grid::new([2, 2], 1.0).unwrap();
        for shape in [
            Shape::Sphere { center: [0.0, f64::NAN], radius: 1.0 },
            Shape::Sphere { center: [0.0; 2], radius: -1.0 },
            Shape::Box { low: [1.0, 0.0], high: [0.0, 1.0] },
            Shape::Box { low: [f64::NEG_INFINITY, 0.0], high: [0.0, 1.0] },
        ] {
            assert!(matches!(obstacles(&grid, &[shape]), Err(FlowError::Shape { .. })), "{shape:?}");
        }
    }
}
