//! Fields in padded boxes: scalars at cells, vectors from faces.
//!
//! The rim is one slot wide on every side. Slot of cell (i, j, k): `(i+1) + (nx+2)·((j+1) + (ny+2)·(k+1))`;
//! in 2D without the last factor. Face `a` of a cell is its low face along axis `a` and shares the cell's slot.

use std::ops::Range;

use crate::array::{Precision, Scalar, Source};

/// The shape of a padded box in two or three dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Padded {
    cells: [usize; 3],
    planar: bool,
}

impl Padded {
    /// A box of `cells`, D = 2 or 3; the rim is not counted.
    pub fn new<const D: usize>(cells: [usize; D]) -> Self {
        const { assert!(D == 2 || D == 3, "fields are two- or three-dimensional") };
        let z = if D == 3 { cells[D - 1] } else { 1 };
        Self { cells: [cells[0], cells[1], z], planar: D == 2 }
    }

    /// Cells along x, y, z; 2D is one cell thick.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Number of slots, rim included; `None` where it overflows.
    pub fn slots(&self) -> Option<usize> {
        let [x, y, z] = self.cells.map(|n| n.checked_add(2));
        let plane = x?.checked_mul(y?)?;
        if self.planar { Some(plane) } else { plane.checked_mul(z?) }
    }

    /// Slot of cell (i, j, k); k is ignored in 2D.
    pub fn slot(&self, i: usize, j: usize, k: usize) -> usize {
        let [nx, ny, _] = self.cells;
        let plane = if self.planar { 0 } else { (ny + 2) * (k + 1) };
        (i + 1) + (nx + 2) * ((j + 1) + plane)
    }

    fn check<T>(&self, data: &[T]) -> Result<(), String> {
        match self.slots() {
            Some(slots) if slots == data.len() => Ok(()),
            slots => Err(format!(
                "{} values given, but {:?} cells with their rim have {} slots",
                data.len(),
                self.cells,
                slots.map_or("too many".into(), |n| n.to_string())
            )),
        }
    }
}

/// A scalar at the cells of a padded box.
pub struct PaddedCells<'a, T> {
    data: &'a [T],
    padded: Padded,
}

impl<'a, T: Scalar> PaddedCells<'a, T> {
    /// Borrows `data`, which must have one value per slot; the error says both numbers.
    pub fn new(data: &'a [T], padded: Padded) -> Result<Self, String> {
        padded.check(data)?;
        Ok(Self { data, padded })
    }
}

impl<T: Scalar> Source for PaddedCells<'_, T> {
    fn precision(&self) -> Precision {
        T::PRECISION
    }

    fn components(&self) -> usize {
        1
    }

    fn shape(&self) -> [usize; 3] {
        self.padded.cells
    }

    fn row(&self, x: Range<usize>, y: usize, z: usize, out: &mut Vec<u8>) {
        let start = self.padded.slot(x.start, y, z);
        T::put(&self.data[start..start + x.len()], out);
    }
}

/// A vector at cell centres, each component the mean of the cell's two faces along its axis.
pub struct Faces<'a, T> {
    components: [Option<&'a [T]>; 3],
    periodic: [bool; 3],
    padded: Padded,
}

impl<'a, T: Scalar> Faces<'a, T> {
    /// Borrows one array per axis, each with one value per slot; `periodic` per axis.
    pub fn new<const D: usize>(components: [&'a [T]; D], padded: Padded, periodic: [bool; D]) -> Result<Self, String> {
        if padded.planar != (D == 2) {
            return Err("the faces and the box differ in dimension".into());
        }
        let mut faces = Self { components: [None; 3], periodic: [false; 3], padded };
        for a in 0..D {
            padded.check(components[a])?;
            faces.components[a] = Some(components[a]);
            faces.periodic[a] = periodic[a];
        }
        Ok(faces)
    }

    /// Slot of the high face of a cell along `axis`: its upper neighbour's, or the seam's where the axis closes.
    fn high(&self, axis: usize, mut cell: [usize; 3]) -> usize {
        let wraps = self.periodic[axis] && cell[axis] + 1 == self.padded.cells[axis];
        cell[axis] = if wraps { 0 } else { cell[axis] + 1 };
        self.padded.slot(cell[0], cell[1], cell[2])
    }
}

impl<T: Scalar> Source for Faces<'_, T> {
    fn precision(&self) -> Precision {
        T::PRECISION
    }

    fn components(&self) -> usize {
        3
    }

    fn shape(&self) -> [usize; 3] {
        self.padded.cells
    }

    fn row(&self, x: Range<usize>, y: usize, z: usize, out: &mut Vec<u8>) {
        for i in x {
            let low = self.padded.slot(i, y, z);
            let mut vector = [T::zero(); 3];
            for (axis, component) in self.components.iter().enumerate() {
                if let Some(face) = component {
                    vector[axis] = face[low].mean(face[self.high(axis, [i, y, z])]);
                }
            }
            T::put(&vector, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(source: &dyn Source, y: usize, z: usize) -> Vec<f64> {
        let (mut bytes, mut out) = (vec![], vec![]);
        source.row(0..source.shape()[0], y, z, &mut bytes);
        source.precision().decode(&bytes, |v| out.push(v));
        out
    }

    #[test]
    fn slots_follow_the_formula_and_skip_the_rim() {
        let flat = Padded::new([3, 2]);
        assert_eq!((flat.slots(), flat.slot(0, 0, 0), flat.slot(2, 1, 0)), (Some(20), 6, 13));
        let solid = Padded::new([3, 2, 2]);
        assert_eq!((solid.slots(), solid.slot(0, 0, 0), solid.slot(2, 1, 1)), (Some(80), 26, 53));
        let data: Vec<f32> = (0..80).map(|s| s as f32).collect();
        let cells = PaddedCells::new(&data, solid).unwrap();
        assert_eq!(values(&cells, 1, 1), [51.0, 52.0, 53.0]);
    }

    #[test]
    fn wrong_lengths_are_refused_with_both_numbers() {
        let error = PaddedCells::new(&[0.0_f64; 7], Padded::new([3, 2])).err().unwrap();
        assert!(error.contains('7') && error.contains("20"), "{error}");
        assert!(PaddedCells::new(&[0.0_f64], Padded::new([usize::MAX, 2])).is_err());
        let (short, full) = ([0.0_f64; 3], [0.0_f64; 20]);
        assert!(Faces::new([&full[..], &short], Padded::new([3, 2]), [false; 2]).is_err());
    }

    #[test]
    fn walls_use_the_rim_face_and_periodic_axes_the_seam() {
        let padded = Padded::new([3, 2]);
        let mut u = [f64::NAN; 20];
        let mut v = [f64::NAN; 20];
        for j in 0..2 {
            for i in 0..4 {
                u[padded.slot(i, j, 0)] = (10 * j + i) as f64; // i = 3 is the high wall, in the rim
            }
        }
        for j in 0..3 {
            for i in 0..3 {
                v[padded.slot(i, j, 0)] = j as f64;
            }
        }
        let walls = Faces::new([&u[..], &v], padded, [false; 2]).unwrap();
        assert_eq!(values(&walls, 1, 0), [10.5, 1.5, 0.0, 11.5, 1.5, 0.0, 12.5, 1.5, 0.0]);
        for j in 0..2 {
            u[padded.slot(3, j, 0)] = f64::NAN; // never read on a periodic axis
        }
        let seam = Faces::new([&u[..], &v], padded, [true, true]).unwrap();
        assert_eq!(values(&seam, 1, 0), [10.5, 0.5, 0.0, 11.5, 0.5, 0.0, 11.0, 0.5, 0.0]);
    }

    #[test]
    fn three_dimensional_faces_average_along_every_axis() {
        let padded = Padded::new([1, 1, 2]);
        let mut w = [0.0_f32; 36];
        for k in 0..3 {
            w[padded.slot(0, 0, k)] = (k * k) as f32;
        }
        let zero = [0.0_f32; 36];
        let faces = Faces::new([&zero[..], &zero, &w], padded, [false; 3]).unwrap();
        assert_eq!(values(&faces, 0, 1), [0.0, 0.0, 2.5]);
    }
}
