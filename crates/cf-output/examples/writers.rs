//! Times the streamed raw writer against vtkio's inline base64 writer on the same field:
//! `cargo run --release -p cf-output --example writers -- [cells per side, 128]`.

use std::error::Error;
use std::time::Instant;

use cf_output::{Array, Image, Padded, write_image};
use vtkio::model::{
    Attribute, Attributes, ByteOrder, DataArray, DataSet, ElementType, Extent, ImageDataPiece, Piece, Version, Vtk,
};

/// Best of three, in seconds.
fn best(mut run: impl FnMut() -> Result<(), Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        run()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// Peak memory of this process so far in MiB, where the system tells.
fn peak() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kib| kib / 1024.0)
}

fn main() -> Result<(), Box<dyn Error>> {
    let n: usize = std::env::args().nth(1).map_or(Ok(128), |a| a.parse())?;
    let folder = tempfile::tempdir()?;
    let padded = Padded::new([n; 3]);
    let slots = padded.slots().ok_or("too many cells")?;
    let phi: Vec<f32> = (0..slots).map(|s| (s as f32 * 1e-3).sin()).collect();
    println!("{n}^3 cells, f32, one scalar and one vector from faces");
    let report = |name: &str, seconds: f64, file: &std::path::Path| -> Result<(), Box<dyn Error>> {
        let size = std::fs::metadata(file)?.len() as f64 / 1e6;
        let peak = peak().map_or("unknown".into(), |p| format!("{p:.0} MiB"));
        println!("{name:24} {seconds:8.3} s   {size:8.1} MB   peak memory so far {peak}");
        Ok(())
    };

    let ours = folder.path().join("ours.vti");
    let seconds = best(|| {
        let arrays = vec![
            Array::padded("phi", &phi, [n; 3])?,
            Array::faces("u", [&phi[..], &phi, &phi], [n; 3], [true, false, false])?,
        ];
        let image = Image { cells: [n; 3], origin: [0.0; 3], spacing: [0.1; 3], time: 0.0, arrays };
        write_image(&ours, &image)?;
        Ok(())
    })?;
    report("streamed raw, synced", seconds, &ours)?;

    let theirs = folder.path().join("theirs.vti");
    let seconds = best(|| {
        // vtkio owns its data: the copies out of padded storage are part of the price.
        let scalar: Vec<f32> = (0..n * n * n).map(|c| phi[padded.slot(c % n, c / n % n, c / (n * n))]).collect();
        let vector: Vec<f32> = scalar.iter().flat_map(|v| [*v; 3]).collect();
        let array = |name: &str, components: u32, data: Vec<f32>| {
            let elem = ElementType::Generic(components);
            Attribute::DataArray(DataArray { name: name.into(), elem, data: data.into() })
        };
        let side = 0..=n as i32;
        let extent = Extent::Ranges([side.clone(), side.clone(), side]);
        let data = Attributes { point: vec![], cell: vec![array("phi", 1, scalar), array("u", 3, vector)] };
        let pieces = vec![Piece::Inline(Box::new(ImageDataPiece { extent: extent.clone(), data }))];
        Vtk {
            version: Version::new_xml(1, 0),
            title: String::new(),
            byte_order: ByteOrder::LittleEndian,
            data: DataSet::ImageData { extent, origin: [0.0; 3], spacing: [0.1; 3], meta: None, pieces },
            file_path: None,
        }
        .export(&theirs)?;
        Ok(())
    })?;
    report("vtkio base64, not synced", seconds, &theirs)
}
