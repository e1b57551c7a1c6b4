//! Small point sets through vtkio: `.vtp`, `.vtu` and legacy `.vtk`, for tools that want data inline.
//!
//! vtkio copies everything and drops field data, so these files carry no time; runs use
//! [`write_points`](crate::write_points). Its image writers are not used: origin and spacing are f32 there,
//! and legacy cell data on grids is broken.

use std::io;
use std::path::Path;

use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataArray, DataSet, PolyDataPiece, UnstructuredGridPiece,
    Version, VertexNumbers, Vtk,
};

use crate::OutputError;
use crate::array::{Array, Precision};
use crate::atomic::write_atomic;
use crate::points::Points;

/// More points than this belong in [`write_points`](crate::write_points), which does not copy them.
pub const INLINE_LIMIT: usize = 1_000_000;

/// Writes points inline; the extension chooses `.vtp` (base64), `.vtu` (base64) or `.vtk` (legacy binary).
///
/// # Errors
/// [`OutputError::Request`] for another extension, no points or more than [`INLINE_LIMIT`], [`OutputError::Array`] for
/// names the format cannot hold, [`OutputError::Io`] while writing.
pub fn inline_points(path: &Path, points: &Points) -> Result<(), OutputError> {
    points.check()?;
    let count = points.count();
    if count == 0 {
        // vtkio then leaves out NumberOfPoints, and VTK refuses the file.
        let reason = "there are no points; use write_points, whose files may be empty";
        return Err(OutputError::request("inline points", reason));
    }
    if count > INLINE_LIMIT {
        let reason = format!("{count} points are over {INLINE_LIMIT}; use write_points for a .vtp");
        return Err(OutputError::request("inline points", reason));
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    let legacy = extension == "vtk";
    let mut data = Attributes::new();
    for array in &points.arrays {
        array.check_name()?;
        if legacy && array.name.contains(|c: char| c.is_whitespace() || c == '%' || c == '"') {
            return Err(OutputError::array(&array.name, "legacy .vtk names have no spaces, quotes or percent signs"));
        }
        let components = array.source.components() as u32;
        let values = DataArray { name: array.name.clone(), data: collect(array), ..DataArray::default() };
        data.point
            .push(Attribute::DataArray(DataArray { elem: vtkio::model::ElementType::Generic(components), ..values }));
    }
    let numbers = 0..count as u64;
    let verts = if legacy {
        VertexNumbers::Legacy { num_cells: count as u32, vertices: (0..count as u32).flat_map(|p| [1, p]).collect() }
    } else {
        VertexNumbers::XML { connectivity: numbers.clone().collect(), offsets: numbers.map(|p| p + 1).collect() }
    };
    if legacy {
        data = fields(data);
    }
    let positions = collect(&points.positions);
    let set = match extension {
        "vtp" | "vtk" => {
            DataSet::inline(PolyDataPiece { points: positions, verts: Some(verts), data, ..PolyDataPiece::default() })
        }
        "vtu" => DataSet::inline(UnstructuredGridPiece {
            points: positions,
            cells: Cells { cell_verts: verts, types: vec![CellType::Vertex; count] },
            data,
        }),
        other => {
            let reason = format!("extension '{other}' is not one of vtp, vtu, vtk");
            return Err(OutputError::request("inline points", reason));
        }
    };
    let vtk = Vtk {
        version: if legacy { Version::new_legacy(4, 2) } else { Version::new_xml(1, 0) },
        title: "points".into(),
        // Legacy files are big endian by definition; XML says its order in the header.
        byte_order: if legacy { ByteOrder::BigEndian } else { ByteOrder::LittleEndian },
        data: set,
        file_path: None,
    };
    write_atomic(path, |sink| {
        let written = if legacy { vtk.write_legacy(sink) } else { vtk.write_xml(sink) };
        written.map_err(io::Error::from)
    })
}

/// Legacy files hold arrays of any component count only inside a field.
fn fields(data: Attributes) -> Attributes {
    let arrays = data
        .point
        .into_iter()
        .filter_map(|attribute| match attribute {
            Attribute::DataArray(a) => Some(vtkio::model::FieldArray {
                name: a.name,
                elem: match a.elem {
                    vtkio::model::ElementType::Generic(n) => n,
                    _ => 1,
                },
                data: a.data,
            }),
            Attribute::Field { .. } => None,
        })
        .collect();
    Attributes { point: vec![Attribute::Field { name: "FieldData".into(), data_array: arrays }], cell: vec![] }
}

fn collect(array: &Array) -> IOBuffer {
    let (mut bytes, mut values) = (vec![], vec![]);
    array.source.row(0..array.source.shape()[0], 0, 0, &mut bytes);
    array.source.precision().decode(&bytes, |v| values.push(v));
    match array.source.precision() {
        Precision::F32 => IOBuffer::F32(values.into_iter().map(|v| v as f32).collect()),
        Precision::F64 => IOBuffer::F64(values),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud() -> Points<'static> {
        Points {
            positions: Array::per_point("position", 3, |p| [p as f64, 0.5, -2.0]),
            time: 0.0,
            arrays: vec![
                Array::per_point("saturation", 3, |p| [p as f32 / 3.0]),
                Array::per_point("velocity", 3, |p| [p as f64, 1.0, 2.0]),
                Array::per_point("F", 3, |p| [p as f32; 9]),
            ],
        }
    }

    #[test]
    fn every_kind_is_read_back_by_vtkio() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["p.vtp", "p.vtu", "p.vtk"] {
            let path = dir.path().join(name);
            inline_points(&path, &cloud()).unwrap();
            let (points, data) = match Vtk::import(&path).unwrap().data {
                DataSet::PolyData { pieces, .. } => {
                    let piece = pieces[0].load_piece_data(None).unwrap();
                    (piece.points, piece.data)
                }
                DataSet::UnstructuredGrid { pieces, .. } => {
                    let piece = pieces[0].load_piece_data(None).unwrap();
                    (piece.points, piece.data)
                }
                other => panic!("{name}: {other:?}"),
            };
            assert_eq!(points.cast_into::<f64>().unwrap()[3..6], [1.0, 0.5, -2.0], "{name}");
            let mut found = vec![];
            for attribute in data.point {
                match attribute {
                    Attribute::DataArray(a) => found.push((a.name, a.data)),
                    Attribute::Field { data_array, .. } => {
                        found.extend(data_array.into_iter().map(|a| (a.name, a.data)));
                    }
                }
            }
            let names: Vec<&str> = found.iter().map(|(n, _)| n.as_str()).collect();
            assert_eq!(names, ["saturation", "velocity", "F"], "{name}");
            assert_eq!(found[0].1, IOBuffer::F32(vec![0.0, 1.0 / 3.0, 2.0 / 3.0]), "{name}");
            assert_eq!(found[2].1.len(), 27, "{name}");
        }
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        assert!(inline_points(&dir.path().join("p.vti"), &cloud()).unwrap_err().to_string().contains("vti"));
        let mut spaced = cloud();
        spaced.arrays[0].name = "two words".into();
        assert!(inline_points(&dir.path().join("p.vtk"), &spaced).is_err());
        for count in [0, INLINE_LIMIT + 1] {
            let positions = Array::per_point("x", count, |_| [0.0_f32; 3]);
            let points = Points { positions, time: 0.0, arrays: vec![] };
            let error = inline_points(&dir.path().join("p.vtp"), &points).unwrap_err().to_string();
            assert!(error.contains("write_points"), "{error}");
        }
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
