//! Writes one file of each kind into a folder, for a look and for the VTK check:
//! `cargo run -p cf-output --example gallery -- FOLDER`, then `python tests/vtk/check.py FOLDER`.

use std::path::{Path, PathBuf};

use cf_output::{
    Array, AxisScale, ColorMap, ColorRange, Curve, Display, Image, Join, Manifest, Marker, OutputError, Overlay,
    Padded, Part, Plane, Plot, PlotAxis, Points, Series, Slice, Style, Table, Theme, color_bar, contact_sheet, draw,
    inline_points, write_animation, write_image, write_points,
};

const CELLS: [usize; 2] = [160, 96];
const H: f64 = 1.0 / 96.0;

/// A plume that spreads downstream of a source, with memory of its edge.
fn plume(x: f64, y: f64, time: f64) -> f64 {
    let (along, across) = (x - 0.25, (y - 0.5).abs());
    if along <= 0.0 {
        return 0.0;
    }
    let edge = 0.45 * along;
    let head = 1.0 / (1.0 + ((along - 0.4 * time) / 0.02).exp());
    let inside = 1.0 / (1.0 + ((across - edge) / 0.01).exp());
    head * inside * (0.35 + 0.65 * (-(across / (0.3 * edge + 0.02)).powi(2)).exp()) / (1.0 + along)
}

fn field(time: f64) -> Vec<f64> {
    let box_of = Padded::new(CELLS);
    let mut phi = vec![f64::NAN; box_of.slots().unwrap_or(0)];
    for j in 0..CELLS[1] {
        for i in 0..CELLS[0] {
            phi[box_of.slot(i, j, 0)] = plume((i as f64 + 0.5) * H, (j as f64 + 0.5) * H, time);
        }
    }
    phi
}

fn style(time: f64) -> Style {
    let tip = [0.25, 0.5];
    Style {
        title: "Cattaneo plume in a uniform wind".into(),
        time: format!("t = {time:.2} s"),
        quantity: "concentration φ [kg/m²]".into(),
        axis_names: ["x [m]".into(), "y [m]".into()],
        map: ColorMap::Inferno,
        range: ColorRange::Fixed(0.0, 1.0),
        overlays: [0.45, -0.45]
            .map(|slope| Overlay::straight(tip, [2.0, 0.5 + slope * 1.75], "cone edge, asin(1/H₁)"))
            .to_vec(),
        ..Style::default()
    }
}

fn cut(array: &Array, part: Part) -> Result<Plane, OutputError> {
    Plane::cut(array, Slice { axis: 2, index: 0 }, part, [0.0; 3], H)
}

fn runs(folder: &Path) -> Result<(), OutputError> {
    let mut series = Series::new(folder.join("plume.pvd"));
    let mut manifest = Manifest::default();
    let mut frames = vec![];
    for n in 0..6_u32 {
        let time = 0.75 * f64::from(n + 1);
        let phi = field(time);
        let wind: Vec<f32> = phi.iter().map(|v| 1.0 + *v as f32).collect();
        let calm = vec![0.25_f32; phi.len()];
        let image = Image {
            cells: [CELLS[0], CELLS[1], 1],
            origin: [0.0, -0.1, 1.0 / 3.0],
            spacing: [H; 3],
            time,
            arrays: vec![
                Array::padded("phi", &phi, CELLS)?,
                Array::faces("u", [&wind[..], &calm], CELLS, [true, true])?,
                Array::per_cell("odd <name> & \"more\"", [CELLS[0], CELLS[1], 1], |[i, j, _]| [(i * j) as f32]),
            ],
        };
        let count = 50 * n as usize;
        let points = Points {
            positions: Array::per_point("position", count, |p| [p as f64 / 7.0, time, 0.0]),
            time,
            arrays: vec![
                Array::per_point("saturation", count, |p| [p as f32 / 3.0]),
                Array::per_point("velocity", count, |p| [p as f64, -1.0, 0.1]),
            ],
        };
        let (vti, vtp) = (folder.join(format!("plume_{n:04}.vti")), folder.join(format!("plume_{n:04}.vtp")));
        manifest.files.push(write_image(&vti, &image)?);
        manifest.files.push(write_points(&vtp, &points)?);
        series.push(time, 0, &vti)?;
        series.push(time, 1, &vtp)?;
        frames.push((time, cut(&image.arrays[0], Part::Magnitude)?));
        for extension in ["vtp", "vtu", "vtk"].into_iter().filter(|_| count > 0) {
            inline_points(&folder.join(format!("inline/small_{n}.{extension}")), &points)?;
        }
    }
    manifest.write(&folder.join("plume.manifest.json"))?;
    pictures(folder, &frames)
}

fn pictures(folder: &Path, frames: &[(f64, Plane)]) -> Result<(), OutputError> {
    let Some((time, last)) = frames.last() else { return Ok(()) };
    draw(last, &style(*time)).write_png(&folder.join("picture.png"))?;
    let dark = Style { theme: Theme::Dark, map: ColorMap::Viridis, display: Display::Log(4), ..style(*time) };
    draw(last, &dark).write_png(&folder.join("dark_log.png"))?;
    let small = Style {
        axes: false,
        bar: false,
        side: 240,
        title: String::new(),
        time: String::new(),
        overlays: vec![],
        ..style(0.0)
    };
    let sheet: Vec<_> = frames.iter().map(|(t, p)| (draw(p, &small), format!("t = {t:.2} s"))).collect();
    let bar = color_bar(&small, [0.0, 1.0], 300);
    contact_sheet(&sheet, 3, Some(&bar), Theme::Light).write_png(&folder.join("sheet.png"))?;
    write_animation(&folder.join("animation.png"), frames.len() as u32, 4.0, Theme::Light, |n| {
        let (t, plane) = &frames[n as usize];
        Ok(draw(plane, &style(*t)))
    })?;
    let n = 48;
    let swirl = Array::per_cell("w", [n, n, n], |[i, j, k]| {
        let [x, y, z] = [i, j, k].map(|a| (a as f64 + 0.5) / 24.0 - 1.0);
        [if x.hypot(y + 0.55) < 0.2 { f64::NAN } else { 2e-4 * (3.0 * x).sin() * (2.0 * y + z).cos() }]
    });
    let plane = Plane::cut(&swirl, Slice { axis: 2, index: 24 }, Part::Magnitude, [-1.0; 3], 1.0 / 24.0)?;
    let signed = Style {
        title: "Vorticity, middle layer".into(),
        time: "step 1200".into(),
        quantity: "ω [1/s]".into(),
        axis_names: ["x / L".into(), "y / L".into()],
        map: ColorMap::BlueRed,
        range: ColorRange::Symmetric,
        side: 480,
        ..Style::default()
    };
    draw(&plane, &signed).write_png(&folder.join("signed.png"))
}

fn plots(folder: &Path) -> Result<(), OutputError> {
    let sizes = [16.0_f64, 32.0, 64.0, 128.0, 256.0];
    let curve = |label: &str, order: f64, scale: f64, marker| Curve {
        marker,
        ..Curve::new(label, sizes.iter().map(|n| [*n, scale * n.powf(-order)]).collect())
    };
    let axis = |name: &str, scale| PlotAxis { name: name.into(), scale, range: None };
    let convergence = Plot {
        title: "Modal decay: error against grid size".into(),
        x: axis("cells per side", AxisScale::Log),
        y: axis("relative L₂ error", AxisScale::Log),
        curves: vec![
            curve("backward Euler", 1.0, 0.9, Marker::Circle),
            curve("SDIRK2", 2.0, 3.0, Marker::Square),
            curve("Störmer–Verlet", 2.0, 1.0, Marker::Triangle),
            Curve { join: Join::Dashed, marker: Marker::None, ..curve("order 2", 2.0, 6.0, Marker::None) },
        ],
        ..Plot::default()
    };
    convergence.write_png(&folder.join("convergence.png"))?;
    convergence.write_svg(&folder.join("convergence.svg"))?;
    let wave = |phase: f64| {
        (0..200).map(|n| f64::from(n) / 20.0).map(|t| [t, (-0.2 * t).exp() * (2.0 * t + phase).cos()]).collect()
    };
    let budget = Plot {
        title: "Mass in the box".into(),
        x: axis("time [s]", AxisScale::Linear),
        y: axis("deviation [kg]", AxisScale::Linear),
        curves: vec![Curve::new("left half", wave(0.0)), Curve::new("right half", wave(1.5))],
        theme: Theme::Dark,
        ..Plot::default()
    };
    budget.write_png(&folder.join("budget.png"))?;
    let letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ|abcdefghijklmnopqrstuvwxyz|0123456789 .,:;!?'\"`^_-+=*/\\|()[]{}<>@#$%&~|αβγδεηθκλμπρστφχω Δ∇∂ x²³ 10⁻⁴ H₀₁₂ ° · × − ± √ ∞ ≤ ≥ ≈ →";
    let lines =
        letters.split('|').map(|l| (cf_output::Canvas::new(760, 1, [255; 3]), l.to_string())).collect::<Vec<_>>();
    contact_sheet(&lines, 1, None, Theme::Light).write_png(&folder.join("letters.png"))?;
    let mut table = Table::new(&["cells", "error"]);
    for n in sizes {
        table.push([n.into(), n.powi(-2).into()])?;
    }
    table.write(&folder.join("convergence.csv"))
}

fn main() -> Result<(), OutputError> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/gallery".into()));
    runs(&folder)?;
    plots(&folder)?;
    println!("look into {}", folder.display());
    Ok(())
}
