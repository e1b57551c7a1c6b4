//! `.vti`: cell data on a uniform box, exact in every digit and streamed.

use std::path::Path;

use crate::OutputError;
use crate::appended::{Appended, check_arrays};
use crate::array::Array;
use crate::atomic::write_atomic;
use crate::manifest::{FileRecord, Shape};
use crate::text::{escape, numbers};

/// One instant of a run on a uniform grid.
pub struct Image<'a> {
    /// Cells along x, y, z; a 2D field is one cell thick.
    pub cells: [usize; 3],
    /// Low corner of the box, in the unit of length.
    pub origin: [f64; 3],
    /// Cell size along each axis, in the unit of length.
    pub spacing: [f64; 3],
    /// Simulated time.
    pub time: f64,
    /// Cell data, each of shape `cells`.
    pub arrays: Vec<Array<'a>>,
}

impl Image<'_> {
    fn check(&self) -> Result<(), OutputError> {
        let refuse = |what: &str, reason: String| Err(OutputError::request(what, reason));
        if self.cells.contains(&0) || self.cells.iter().any(|&n| n > i32::MAX as usize) {
            // ParaView keeps extents in 32-bit integers.
            return refuse("image", format!("{:?} cells; give 1 to 2147483647 along each axis", self.cells));
        }
        if !self.origin.iter().all(|o| o.is_finite()) {
            return refuse("image origin", format!("{:?} is not finite", self.origin));
        }
        if !self.spacing.iter().all(|&h| h.is_finite() && h > 0.0) {
            return refuse("image spacing", format!("{:?} is not positive and finite", self.spacing));
        }
        check_time(self.time)?;
        check_arrays(&self.arrays, self.cells)
    }
}

pub(crate) fn check_time(time: f64) -> Result<(), OutputError> {
    if time.is_finite() {
        return Ok(());
    }
    Err(OutputError::request("time", format!("{time} is not finite")))
}

/// Writes a `.vti`: XML with raw little-endian appended data and the time as `TimeValue`.
///
/// One stretch of a row is held in memory; the field itself is not copied. Returns what was written, for a
/// [`Manifest`](crate::Manifest).
///
/// # Errors
/// [`OutputError::Request`] or [`OutputError::Array`] before the file is touched, [`OutputError::Io`] while writing.
pub fn write_image(path: &Path, image: &Image) -> Result<FileRecord, OutputError> {
    image.check()?;
    let [nx, ny, nz] = image.cells;
    let extent = [0, nx, 0, ny, 0, nz];
    let extent_text = extent.map(|n| n.to_string()).join(" ");
    let mut appended = Appended::default();
    let mut header = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<ImageData WholeExtent=\"{extent_text}\" Origin=\"{}\" Spacing=\"{}\">\n",
        numbers(&image.origin),
        numbers(&image.spacing)
    );
    header += &appended.time(image.time)?;
    header += &format!("<Piece Extent=\"{extent_text}\">\n<CellData{}>\n", active(&image.arrays));
    for array in &image.arrays {
        header += &appended.values(array)?;
    }
    header += "</CellData>\n</Piece>\n</ImageData>\n";
    let stats = write_atomic(path, |sink| appended.write(&header, sink))?;
    Ok(FileRecord {
        file: file_name(path),
        time: image.time,
        shape: Shape::Image { extent, origin: image.origin, spacing: image.spacing },
        arrays: image.arrays.iter().map(|a| a.name.clone()).zip(stats).collect(),
    })
}

/// The attributes that make a viewer colour by the first scalar and draw arrows of the first vector.
pub(crate) fn active(arrays: &[Array]) -> String {
    let first = |components: usize, word: &str| {
        let found = arrays.iter().find(|a| a.source.components() == components);
        found.map_or(String::new(), |a| format!(" {word}=\"{}\"", escape(&a.name)))
    };
    first(1, "Scalars") + &first(3, "Vectors")
}

pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reader::read_image;

    fn image<'a>(arrays: Vec<Array<'a>>) -> Image<'a> {
        Image {
            cells: [3, 2, 1],
            origin: [0.1, -1e-17, 1e300],
            spacing: [1.0 / 3.0, 0.1 + 0.2, 5e-324],
            time: 0.1 + 0.7,
            arrays,
        }
    }

    #[test]
    fn a_padded_field_comes_back_bit_for_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vti");
        let phi: Vec<f64> = (0..20).map(|s| (s as f64).sqrt()).collect();
        let u: Vec<f32> = (0..20).map(|s| s as f32 / 3.0).collect();
        let written = image(vec![
            Array::padded("phi <&\">", &phi, [3, 2]).unwrap(),
            Array::faces("u", [&u[..], &u], [3, 2], [false, true]).unwrap(),
        ]);
        let record = write_image(&path, &written).unwrap();
        let read = read_image(&path).unwrap();
        assert_eq!(read.extent, [0, 3, 0, 2, 0, 1]);
        assert_eq!((read.origin, read.spacing), (written.origin, written.spacing));
        assert_eq!(read.time, Some(0.1 + 0.7));
        assert_eq!(read.arrays[0].name, "phi <&\">");
        assert_eq!(read.arrays[0].values, [6, 7, 8, 11, 12, 13].map(|s| phi[s]));
        assert_eq!(read.arrays[1].components, 3);
        assert_eq!(read.arrays[1].values[0], f64::from(0.5 * u[6] + 0.5 * u[7]));
        assert_eq!(record.arrays[0].1.max, phi[13]);
        assert_eq!(record.file, "a.vti");
    }

    #[test]
    fn meaningless_requests_touch_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vti");
        let refused = |change: &dyn Fn(&mut Image)| {
            let mut bad = image(vec![Array::per_cell("a", [3, 2, 1], |_| [0.0_f32])]);
            change(&mut bad);
            write_image(&path, &bad).unwrap_err().to_string()
        };
        assert!(refused(&|i| i.time = f64::NAN).contains("time"));
        assert!(refused(&|i| i.spacing[1] = 0.0).contains("spacing"));
        assert!(refused(&|i| i.origin[2] = f64::INFINITY).contains("origin"));
        assert!(refused(&|i| i.cells[0] = 0).contains("cells"));
        assert!(refused(&|i| i.cells[0] = 4).contains("shape"));
        assert!(refused(&|i| i.arrays.push(Array::per_cell("a", [3, 2, 1], |_| [0.0_f32]))).contains("twice"));
        assert!(!path.exists());
    }

    #[test]
    fn the_first_scalar_and_vector_are_active() {
        let arrays = [
            Array::per_point("u", 1, |_| [0.0_f32; 3]),
            Array::per_point("phi", 1, |_| [0.0_f32]),
            Array::per_point("p", 1, |_| [0.0_f32]),
        ];
        assert_eq!(active(&arrays), " Scalars=\"phi\" Vectors=\"u\"");
    }
}
