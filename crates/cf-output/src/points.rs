//! `.vtp`: particles as points with one vertex each, streamed.

use std::path::Path;

use crate::OutputError;
use crate::appended::{Appended, check_arrays};
use crate::array::Array;
use crate::atomic::write_atomic;
use crate::image::{active, check_time, file_name};
use crate::manifest::{FileRecord, Shape};

/// One instant of a cloud of particles.
pub struct Points<'a> {
    /// Positions, three components per point in the unit of length (z = 0 in 2D); see [`Array::per_point`].
    pub positions: Array<'a>,
    /// Simulated time.
    pub time: f64,
    /// Point data, each with one value of any number of components per point.
    pub arrays: Vec<Array<'a>>,
}

impl Points<'_> {
    /// Number of points.
    pub fn count(&self) -> usize {
        self.positions.source.shape()[0]
    }

    pub(crate) fn check(&self) -> Result<(), OutputError> {
        let (shape, components) = (self.positions.source.shape(), self.positions.source.components());
        if shape[1..] != [1, 1] || components != 3 {
            let reason = format!("shape {shape:?} with {components} components; positions are [n, 1, 1] with 3");
            return Err(OutputError::array(&self.positions.name, reason));
        }
        check_time(self.time)?;
        check_arrays(&self.arrays, shape)
    }
}

/// Writes a `.vtp`: points, one vertex per point, point data; XML with raw little-endian appended data and the
/// time as `TimeValue`. No points at all is a valid file.
///
/// # Errors
/// [`OutputError::Request`] or [`OutputError::Array`] before the file is touched, [`OutputError::Io`] while writing.
pub fn write_points(path: &Path, points: &Points) -> Result<FileRecord, OutputError> {
    points.check()?;
    let count = points.count();
    let mut appended = Appended::default();
    let mut header = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<PolyData>\n",
    );
    header += &appended.time(points.time)?;
    header += &format!(
        "<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<Points>\n"
    );
    header += &appended.values(&points.positions)?;
    header += "</Points>\n<Verts>\n";
    header += &appended.counting("connectivity", 0, count)?;
    header += &appended.counting("offsets", 1, count)?;
    header += &format!("</Verts>\n<PointData{}>\n", active(&points.arrays));
    for array in &points.arrays {
        header += &appended.values(array)?;
    }
    header += "</PointData>\n</Piece>\n</PolyData>\n";
    let mut stats = write_atomic(path, |sink| appended.write(&header, sink))?;
    let positions = stats.remove(0);
    Ok(FileRecord {
        file: file_name(path),
        time: points.time,
        shape: Shape::Points { count, positions },
        arrays: points.arrays.iter().map(|a| a.name.clone()).zip(stats).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reader::read_points;

    fn cloud(count: usize) -> Points<'static> {
        Points {
            positions: Array::per_point("position", count, |p| [p as f64, 0.1, -1.0]),
            time: 2.5,
            arrays: vec![
                Array::per_point("saturation", count, |p| [p as f32 / 7.0]),
                Array::per_point("F", count, |p| [p as f64; 9]),
            ],
        }
    }

    #[test]
    fn particles_come_back_bit_for_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.vtp");
        let record = write_points(&path, &cloud(5)).unwrap();
        let read = read_points(&path).unwrap();
        assert_eq!(read.time, Some(2.5));
        assert_eq!(read.positions[4], [4.0, 0.1, -1.0]);
        assert_eq!(read.arrays[0].values[3], f64::from(3.0_f32 / 7.0));
        assert_eq!((read.arrays[1].components, read.arrays[1].values.len()), (9, 45));
        assert!(matches!(record.shape, Shape::Points { count: 5, .. }));
    }

    #[test]
    fn no_points_is_a_valid_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.vtp");
        write_points(&path, &cloud(0)).unwrap();
        assert!(read_points(&path).unwrap().positions.is_empty());
    }

    #[test]
    fn wrong_shapes_are_refused() {
        let path = Path::new("never-written.vtp");
        let mut points = cloud(5);
        points.arrays.push(Array::per_point("short", 4, |_| [0.0_f32]));
        assert!(write_points(path, &points).unwrap_err().to_string().contains("short"));
        let flat = Points { positions: Array::per_point("position", 2, |_| [0.0_f32; 2]), time: 0.0, arrays: vec![] };
        assert!(write_points(path, &flat).unwrap_err().to_string().contains("3"));
    }
}
