//! A small reader of the files this crate writes, for round-trip tests and regression checks.
//!
//! Any bytes give a value or a typed error; nothing larger than the file itself is allocated on its word.

use std::fs;
use std::path::Path;

use crate::OutputError;
use crate::array::Precision;
use crate::header::{Header, Tag, tags};
use crate::series::SeriesEntry;

/// An array of a file, widened to f64 (exact for both precisions).
#[derive(Debug, Clone, PartialEq)]
pub struct ReadArray {
    /// Name in the file.
    pub name: String,
    /// Values per cell or point.
    pub components: usize,
    /// Scalar type in the file.
    pub precision: Precision,
    /// Interleaved components, x fastest.
    pub values: Vec<f64>,
}

/// The content of a `.vti`.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageFile {
    /// Point ranges, low and high per axis.
    pub extent: [usize; 6],
    /// Low corner of the box.
    pub origin: [f64; 3],
    /// Cell size.
    pub spacing: [f64; 3],
    /// `TimeValue`, if there is one.
    pub time: Option<f64>,
    /// Cell data in file order.
    pub arrays: Vec<ReadArray>,
}

/// The content of a `.vtp` of points.
#[derive(Debug, Clone, PartialEq)]
pub struct PointsFile {
    /// `TimeValue`, if there is one.
    pub time: Option<f64>,
    /// Positions.
    pub positions: Vec<[f64; 3]>,
    /// Point data in file order.
    pub arrays: Vec<ReadArray>,
}

/// Reads a `.vti` written by [`write_image`](crate::write_image).
///
/// # Errors
/// [`OutputError::Io`] if the file cannot be read, [`OutputError::Damaged`] if it is not one of ours.
pub fn read_image(path: &Path) -> Result<ImageFile, OutputError> {
    parse_image(&load(path)?).map_err(|reason| OutputError::damaged(path, reason))
}

/// Reads a `.vtp` written by [`write_points`](crate::write_points).
///
/// # Errors
/// As [`read_image`].
pub fn read_points(path: &Path) -> Result<PointsFile, OutputError> {
    parse_points(&load(path)?).map_err(|reason| OutputError::damaged(path, reason))
}

/// Reads a `.pvd` written by [`Series`](crate::Series).
///
/// # Errors
/// As [`read_image`].
pub fn read_series(path: &Path) -> Result<Vec<SeriesEntry>, OutputError> {
    parse_series(&load(path)?).map_err(|reason| OutputError::damaged(path, reason))
}

fn load(path: &Path) -> Result<Vec<u8>, OutputError> {
    fs::read(path).map_err(|e| OutputError::io(path, "read", e))
}

fn parse_image(bytes: &[u8]) -> Result<ImageFile, String> {
    let mut header = Header::parse(bytes, "ImageData")?;
    let image = header.find("ImageData")?;
    let extent: [usize; 6] = image.numbers("WholeExtent")?;
    let (origin, spacing) = (image.numbers("Origin")?, image.numbers("Spacing")?);
    if header.find("Piece")?.numbers::<usize, 6>("Extent")? != extent {
        return Err("the piece does not cover the image".into());
    }
    let cells = (0..3)
        .try_fold(1_usize, |n, a| n.checked_mul(extent[2 * a + 1].checked_sub(extent[2 * a])?))
        .ok_or("the extent is not a box")?;
    let time = read_time(&mut header)?;
    Ok(ImageFile { extent, origin, spacing, time, arrays: read_arrays(&mut header, "CellData", cells)? })
}

fn parse_points(bytes: &[u8]) -> Result<PointsFile, String> {
    let mut header = Header::parse(bytes, "PolyData")?;
    let [count] = header.find("Piece")?.numbers::<usize, 1>("NumberOfPoints")?;
    let time = read_time(&mut header)?;
    let positions = read_arrays(&mut header, "Points", count)?;
    let [ReadArray { components: 3, values, .. }] = positions.as_slice() else {
        return Err("there is no single array of positions with three components".into());
    };
    let positions = values.as_chunks::<3>().0.to_vec();
    for tag in header.arrays("Verts") {
        header.block(&tag, 8, count)?;
    }
    Ok(PointsFile { time, positions, arrays: read_arrays(&mut header, "PointData", count)? })
}

fn parse_series(bytes: &[u8]) -> Result<Vec<SeriesEntry>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "is not text")?;
    let tags = tags(text)?;
    if !tags.iter().any(|t| t.name == "VTKFile" && t.attribute("type").is_ok_and(|k| k == "Collection")) {
        return Err("is not a VTK collection".into());
    }
    let entry = |tag: &Tag| {
        let ([time], [part]) = (tag.numbers("timestep")?, tag.numbers("part")?);
        Ok(SeriesEntry { time, part, file: tag.attribute("file")?.to_string() })
    };
    tags.iter().filter(|t| t.name == "DataSet").map(entry).collect()
}

fn read_time(header: &mut Header) -> Result<Option<f64>, String> {
    let found = read_arrays(header, "FieldData", 1)?;
    Ok(found.iter().find(|a| a.name == "TimeValue").and_then(|a| a.values.first().copied()))
}

fn read_arrays(header: &mut Header, section: &str, tuples: usize) -> Result<Vec<ReadArray>, String> {
    let mut arrays = vec![];
    for tag in header.arrays(section) {
        let precision = match tag.attribute("type")? {
            "Float32" => Precision::F32,
            "Float64" => Precision::F64,
            other => return Err(format!("array type {other} is not Float32 or Float64")),
        };
        let [components] = tag.numbers::<usize, 1>("NumberOfComponents")?;
        let bytes_each = components.checked_mul(precision.bytes()).ok_or("too many components")?;
        let block = header.block(&tag, bytes_each, tuples)?;
        let mut values = Vec::with_capacity(block.len() / precision.bytes());
        precision.decode(block, |v| values.push(v));
        arrays.push(ReadArray { name: tag.attribute("Name")?.to_string(), components, precision, values });
    }
    Ok(arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::Array;
    use crate::{Image, Points, write_image, write_points};
    use proptest::prelude::*;

    fn samples() -> [Vec<u8>; 3] {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        let image = Image {
            cells: [3, 2, 1],
            origin: [0.0; 3],
            spacing: [0.5; 3],
            time: 1.0,
            arrays: vec![Array::per_cell("phi", [3, 2, 1], |[i, j, _]| [(i + j) as f32])],
        };
        write_image(&path, &image).unwrap();
        let vti = fs::read(&path).unwrap();
        let positions = Array::per_point("position", 4, |p| [p as f64; 3]);
        write_points(&path, &Points { positions, time: 0.0, arrays: vec![] }).unwrap();
        let vtp = fs::read(&path).unwrap();
        let mut series = crate::Series::new(dir.path().join("s.pvd"));
        series.push(0.0, 0, &path).unwrap();
        [vti, vtp, fs::read(dir.path().join("s.pvd")).unwrap()]
    }

    fn read_all(bytes: &[u8]) -> usize {
        usize::from(parse_image(bytes).is_ok())
            + usize::from(parse_points(bytes).is_ok())
            + usize::from(parse_series(bytes).is_ok())
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn random_bytes_are_refused(bytes: Vec<u8>) {
            prop_assert_eq!(read_all(&bytes), 0);
        }

        #[test]
        fn damaged_files_never_panic(which in 0_usize..3, edits: Vec<(prop::sample::Index, u8)>, cut: prop::sample::Index) {
            let mut bytes = samples()[which].clone();
            for (at, to) in edits {
                let at = at.index(bytes.len());
                bytes[at] = to;
            }
            read_all(&bytes);
            bytes.truncate(cut.index(bytes.len()));
            read_all(&bytes);
        }
    }

    #[test]
    fn each_file_is_read_by_its_own_reader_only() {
        assert_eq!(samples().map(|bytes| read_all(&bytes)), [1, 1, 1]);
    }

    #[test]
    fn a_short_file_says_what_is_missing() {
        let [vti, ..] = samples();
        // The last array is cut; the closing tags and four values are gone.
        assert!(parse_image(&vti[..vti.len() - 45]).unwrap_err().contains("phi"));
    }

    #[test]
    fn sizes_in_the_header_are_not_believed() {
        let [vti, vtp, _] = samples();
        for (bytes, from, to) in [
            (&vti, "0 3 0 2 0 1", "0 9 0 9 0 9"),
            (&vti, "NumberOfComponents=\"1\"", "NumberOfComponents=\"99999999999999999\""),
            (&vti, "offset=\"16\"", "offset=\"18446744073709551615\""),
            (&vtp, "NumberOfPoints=\"4\"", "NumberOfPoints=\"4000000000000000000\""),
        ] {
            let split = bytes.windows(13).position(|w| w == b"<AppendedData").unwrap();
            let header = std::str::from_utf8(&bytes[..split]).unwrap().replace(from, to);
            let changed = [header.as_bytes(), &bytes[split..]].concat();
            assert_ne!(&changed, bytes, "{from}");
            assert_eq!(read_all(&changed), 0, "{from}");
        }
    }
}
