//! Pareto plots, profiles and pictures.

use super::setting::{Measured, Scheme, best};
use super::sweep::Shown;
use crate::bench::Numbers;
use crate::failure::Failure;
use cf_output::{
    AxisScale, ColorRange, Curve, Join, Marker, Plane, Plot, PlotAxis, Style, Theme, color_bar, contact_sheet, draw,
};
use std::path::{Path, PathBuf};

const SCHEMES: [(Scheme, [u8; 3]); 5] = [
    (Scheme::PaperBe, [213, 94, 0]),
    (Scheme::Sdirk2, [0, 114, 178]),
    (Scheme::Kdk, [0, 158, 115]),
    (Scheme::Front, [204, 121, 167]),
    (Scheme::Spectral, [100, 100, 100]),
];
const NUMBERS: [(Numbers, Marker); 3] =
    [(Numbers::F64, Marker::Circle), (Numbers::F32, Marker::Triangle), (Numbers::Mixed, Marker::Square)];

/// Error against time, one colour per integrator, one symbol per precision, a line through what nothing beats.
pub fn pareto(problem: &str, rows: &[&Measured]) -> Plot {
    let mut curves = vec![Curve { label: "not beaten".into(), color: Some([40; 3]), ..Curve::new("", best(rows)) }];
    for (scheme, color) in SCHEMES {
        for (numbers, marker) in NUMBERS {
            let chosen = rows.iter().filter(|m| m.setting.scheme == scheme && m.setting.numbers == numbers);
            let points: Vec<[f64; 2]> = chosen.map(|m| [m.seconds, m.error]).collect();
            if !points.is_empty() {
                let label = format!("{scheme} {numbers}");
                curves.push(Curve { join: Join::Points, marker, color: Some(color), ..Curve::new(label, points) });
            }
        }
    }
    let log = |name: &str| PlotAxis { name: name.into(), scale: AxisScale::Log, range: None };
    Plot {
        title: problem.into(),
        x: log("wall time [s]"),
        y: log("relative error, 2-norm [1]"),
        curves,
        size: [900, 620],
        ..Plot::default()
    }
}

/// Profiles of the line in one plot, the disc side by side. Returns what was written.
pub fn fronts(shown: &[Shown], out: &Path) -> Result<Vec<PathBuf>, Failure> {
    let of = |problem: &'static str| shown.iter().filter(move |s| s.problem == problem);
    let mut written = Vec::new();
    let curves: Vec<Curve> = of("P2 line")
        .map(|s| {
            let place = |i: usize| 3.0 * (i as f64 + 0.5) / s.cells[0] as f64 - 1.5;
            let points = s.phi.iter().enumerate().map(|(i, &phi)| [place(i), phi]).collect();
            let join = if s.words == "exact" { Join::Dashed } else { Join::Solid };
            Curve { join, ..Curve::new(s.words.clone(), points) }
        })
        .collect();
    if !curves.is_empty() {
        let axis = |name: &str| PlotAxis { name: name.into(), ..PlotAxis::default() };
        let plot = Plot {
            title: "P2 line at t = 0.8 τ".into(),
            x: axis("x [cτ]"),
            y: axis("φ"),
            curves,
            size: [900, 620],
            ..Plot::default()
        };
        written.push(out.join("p2_line.png"));
        plot.write_png(&out.join("p2_line.png"))?;
    }
    let planes: Vec<(Plane, &Shown)> = of("P2 disc")
        .map(|s| Ok((Plane::new(s.cells, [0.0; 2], 2.4 / s.cells[0] as f64, s.phi.clone())?, s)))
        .collect::<Result<_, cf_output::OutputError>>()?;
    if !planes.is_empty() {
        let reach = planes[0].1.phi.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let style = Style {
            bar: false,
            axes: false,
            range: ColorRange::Fixed(-reach, reach),
            quantity: "φ".into(),
            side: 384,
            ..Style::default()
        };
        let pictures: Vec<_> = planes.iter().map(|(plane, s)| (draw(plane, &style), s.words.clone())).collect();
        let bar = color_bar(&style, [-reach, reach], pictures[0].0.height());
        written.push(out.join("p2_disc.png"));
        contact_sheet(&pictures, 4, Some(&bar), Theme::default()).write_png(&out.join("p2_disc.png"))?;
    }
    Ok(written)
}
