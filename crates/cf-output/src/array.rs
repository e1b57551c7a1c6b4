//! What a writer takes: named arrays whose values are produced a row at a time into a reused buffer.
//!
//! A field lives in a padded box (one-cell rim on every side, x contiguous); nothing here copies it.

use std::ops::Range;

use crate::OutputError;
use crate::padded::{Faces, Padded, PaddedCells};

/// The scalar type of an array, kept in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// IEEE single precision, 4 bytes.
    F32,
    /// IEEE double precision, 8 bytes.
    F64,
}

impl Precision {
    /// Size of one value in bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The name VTK gives this type.
    pub fn vtk_name(self) -> &'static str {
        match self {
            Self::F32 => "Float32",
            Self::F64 => "Float64",
        }
    }

    /// Turns little-endian bytes of this type into numbers, exactly; a trailing partial value is ignored.
    pub fn decode(self, bytes: &[u8], mut take: impl FnMut(f64)) {
        match self {
            Self::F32 => bytes.as_chunks::<4>().0.iter().for_each(|b| take(f32::from_le_bytes(*b).into())),
            Self::F64 => bytes.as_chunks::<8>().0.iter().for_each(|b| take(f64::from_le_bytes(*b))),
        }
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`.
pub trait Scalar: Copy + Sync + sealed::Sealed + 'static {
    /// The type's name for files.
    const PRECISION: Precision;
    /// Appends the values as little-endian bytes.
    fn put(values: &[Self], out: &mut Vec<u8>);
    /// The mean of two values, without overflow for any two finite ones.
    fn mean(self, other: Self) -> Self;
    /// Zero.
    fn zero() -> Self;
}

macro_rules! scalar {
    ($t:ty, $precision:expr) => {
        impl Scalar for $t {
            const PRECISION: Precision = $precision;

            fn put(values: &[Self], out: &mut Vec<u8>) {
                const N: usize = size_of::<$t>();
                let start = out.len();
                out.resize(start + values.len() * N, 0);
                for (bytes, value) in out[start..].as_chunks_mut::<N>().0.iter_mut().zip(values) {
                    *bytes = value.to_le_bytes();
                }
            }

            fn mean(self, other: Self) -> Self {
                0.5 * self + 0.5 * other
            }

            fn zero() -> Self {
                0.0
            }
        }
    };
}
scalar!(f32, Precision::F32);
scalar!(f64, Precision::F64);

/// Values on a box of `shape` cells (points are a box of `[n, 1, 1]`), produced a stretch of a row at a time.
pub trait Source {
    /// Scalar type of the values.
    fn precision(&self) -> Precision;
    /// Values per cell, interleaved in the output.
    fn components(&self) -> usize;
    /// Number of cells along x, y, z.
    fn shape(&self) -> [usize; 3];
    /// Appends cells `x` of row `y` in plane `z`, little endian: `x.len() · components · bytes` bytes.
    /// Callers stay inside `shape`.
    fn row(&self, x: Range<usize>, y: usize, z: usize, out: &mut Vec<u8>);
}

/// A named array to be written, borrowing its data.
pub struct Array<'a> {
    /// Name shown by ParaView, for example `phi`.
    pub name: String,
    /// Where the values come from.
    pub source: Box<dyn Source + 'a>,
}

impl<'a> Array<'a> {
    /// Any source under a name.
    pub fn new(name: impl Into<String>, source: impl Source + 'a) -> Self {
        Self { name: name.into(), source: Box::new(source) }
    }

    /// A scalar cell field in padded storage; `cells` counts the cells without the rim.
    ///
    /// # Errors
    /// [`OutputError::Array`] where `data` does not have one value per slot.
    pub fn padded<T: Scalar, const D: usize>(
        name: impl Into<String>,
        data: &'a [T],
        cells: [usize; D],
    ) -> Result<Self, OutputError> {
        let name = name.into();
        let source = PaddedCells::new(data, Padded::new(cells)).map_err(|r| OutputError::array(&name, r))?;
        Ok(Self::new(name, source))
    }

    /// A face field in padded storage, averaged to cell centres: three components, the third zero in 2D.
    /// `periodic[a]` says that the seam face of axis `a` is stored once, at the low slot.
    ///
    /// # Errors
    /// [`OutputError::Array`] where a component does not have one value per slot.
    pub fn faces<T: Scalar, const D: usize>(
        name: impl Into<String>,
        components: [&'a [T]; D],
        cells: [usize; D],
        periodic: [bool; D],
    ) -> Result<Self, OutputError> {
        let name = name.into();
        let source = Faces::new(components, Padded::new(cells), periodic).map_err(|r| OutputError::array(&name, r))?;
        Ok(Self::new(name, source))
    }

    /// One value of `C` components per cell from a function of the cell's index.
    pub fn per_cell<T: Scalar, const C: usize>(
        name: impl Into<String>,
        cells: [usize; 3],
        value: impl Fn([usize; 3]) -> [T; C] + 'a,
    ) -> Self {
        Self::new(name, PerCell { cells, value })
    }

    /// One value of `C` components per point from a function of the point's number.
    pub fn per_point<T: Scalar, const C: usize>(
        name: impl Into<String>,
        count: usize,
        value: impl Fn(usize) -> [T; C] + 'a,
    ) -> Self {
        Self::per_cell(name, [count, 1, 1], move |[p, _, _]| value(p))
    }

    pub(crate) fn check_name(&self) -> Result<(), OutputError> {
        if self.name.is_empty() || self.name.chars().any(char::is_control) {
            return Err(OutputError::array(&self.name, "give a name without control characters"));
        }
        match self.source.components() {
            0 => Err(OutputError::array(&self.name, "has no components")),
            _ => Ok(()),
        }
    }
}

/// Values from a function; see [`Array::per_cell`].
struct PerCell<F> {
    cells: [usize; 3],
    value: F,
}

impl<T: Scalar, const C: usize, F: Fn([usize; 3]) -> [T; C]> Source for PerCell<F> {
    fn precision(&self) -> Precision {
        T::PRECISION
    }

    fn components(&self) -> usize {
        C
    }

    fn shape(&self) -> [usize; 3] {
        self.cells
    }

    fn row(&self, x: Range<usize>, y: usize, z: usize, out: &mut Vec<u8>) {
        for i in x {
            T::put(&(self.value)([i, y, z]), out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_decode_to_the_values_put() {
        let mut out = vec![];
        f64::put(&[0.1, f64::NAN, -0.0, f64::MIN_POSITIVE], &mut out);
        let mut back = vec![];
        Precision::F64.decode(&out, |v| back.push(v));
        assert_eq!(back[0], 0.1);
        assert!(back[1].is_nan());
        assert_eq!(back[2].to_bits(), (-0.0_f64).to_bits());
        assert_eq!(back[3], f64::MIN_POSITIVE);
        out.clear();
        f32::put(&[0.1], &mut out);
        Precision::F32.decode(&out, |v| assert_eq!(v, f64::from(0.1_f32)));
    }

    #[test]
    fn means_do_not_overflow() {
        assert_eq!(f64::MAX.mean(f64::MAX), f64::MAX);
        assert_eq!(1.0_f32.mean(2.0), 1.5);
    }

    #[test]
    fn functions_give_interleaved_components() {
        let array = Array::per_point("v", 4, |p| [p as f32, -1.0]);
        let (mut out, mut back) = (vec![], vec![]);
        array.source.row(1..3, 0, 0, &mut out);
        Precision::F32.decode(&out, |v| back.push(v));
        assert_eq!(back, [1.0, -1.0, 2.0, -1.0]);
    }

    #[test]
    fn names_are_checked() {
        let named = |name: &str| Array::per_point(name, 1, |_| [0.0_f32]).check_name();
        assert!(named("φ <q>").is_ok());
        assert!(named("").is_err() && named("a\nb").is_err());
        assert!(Array::per_point("none", 1, |_| [0.0_f32; 0]).check_name().is_err());
    }
}
