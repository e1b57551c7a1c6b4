//! A picture of a cloud from a `.vti`: `cargo run -p cf-output --example volume -- FILE.vti OUT.png [ink|smoke|fire]`.

use std::path::Path;

use cf_output::{Array, Look, Material, OutputError, Volume, read_image, render};

fn main() -> Result<(), OutputError> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [file, out, rest @ ..] = &words[..] else {
        eprintln!("usage: volume FILE.vti OUT.png [ink|smoke|fire]");
        std::process::exit(2);
    };
    let image = read_image(Path::new(file))?;
    let Some(read) = image.arrays.first() else { return Ok(()) };
    let e = image.extent;
    let cells = [e[1] - e[0], e[3] - e[2], e[5] - e[4]];
    let values = |c: [usize; 3]| [read.values[read.components * (c[0] + cells[0] * (c[1] + cells[1] * c[2]))]];
    let mut sorted: Vec<f64> = read.values.iter().copied().filter(|v| *v > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let high = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(1.0);
    let array = Array::per_cell(read.name.clone(), cells, values);
    let volume = Volume::new(&array, image.origin, image.spacing)?;
    let look = match rest.first().map(String::as_str) {
        Some("ink") => Look::ink(),
        Some("fire") => Look { material: Material::FIRE, ..Look::default() },
        _ => Look::default(),
    };
    let time = image.time.map(|t| format!("t = {t:.2} s")).unwrap_or_default();
    render(&volume, &Look { title: read.name.clone(), time, range: [0.0, high], ..look })?.write_png(Path::new(out))
}
