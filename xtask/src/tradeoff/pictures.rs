//! Pareto plots, profiles and pictures.

use super::sweep::Shown;
use crate::failure::Failure;
use cf_fluid::Scheme as Flow;
use cf_output::{
    AxisScale, ColorRange, Curve, Join, Marker, Plane, Plot, PlotAxis, Style, Theme, color_bar, contact_sheet, draw,
};
use cf_tradeoff::{Measured, Numbers, Scheme, Setting, best};
use std::path::{Path, PathBuf};

/// By integrator; by scheme where a fluid is solved for.
fn color(setting: &Setting) -> [u8; 3] {
    match setting.flow {
        Some(Flow::Draft) => return [213, 94, 0],
        Some(Flow::Cnp) => return [0, 114, 178],
        Some(Flow::ReflectionExtrapolated) => return [0, 158, 115],
        Some(Flow::CentralRk4) => return [204, 121, 167],
        Some(Flow::Auto) | None => {}
    }
    match setting.scheme {
        Scheme::PaperBe => [213, 94, 0],
        Scheme::Sdirk2 => [0, 114, 178],
        Scheme::Kdk => [0, 158, 115],
        Scheme::Front => [204, 121, 167],
        Scheme::Spectral => [110, 110, 110],
        Scheme::Transport => [230, 159, 0],
    }
}

const NUMBERS: [(Numbers, Marker); 3] =
    [(Numbers::F64, Marker::Circle), (Numbers::F32, Marker::Triangle), (Numbers::Mixed, Marker::Square)];

/// Error against time: one colour per integrator or scheme of a fluid, one symbol per precision, a line through what nothing beats, and black
/// diamonds under the levels of scenes.
pub fn pareto(problem: &str, rows: &[&Measured]) -> Plot {
    let points = |chosen: &dyn Fn(&Measured) -> bool| -> Vec<[f64; 2]> {
        rows.iter().filter(|m| chosen(m)).map(|m| [m.seconds, m.error]).collect()
    };
    let mut curves = vec![Curve { label: "not beaten".into(), color: Some([40; 3]), ..Curve::new("", best(rows)) }];
    for level in cf_tradeoff::Level::ALL {
        let mut points = points(&|m| m.setting.level == Some(level));
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if !points.is_empty() {
            let color = Some(match level {
                cf_tradeoff::Level::Draft => [190, 160, 60],
                cf_tradeoff::Level::Standard => [20, 20, 20],
                cf_tradeoff::Level::Accurate => [120, 60, 160],
            });
            curves.push(Curve {
                join: Join::Dashed,
                marker: Marker::Diamond,
                color,
                ..Curve::new(format!("level {level}"), points)
            });
        }
    }
    let mut methods: Vec<&Setting> = rows.iter().map(|m| &m.setting).collect();
    methods.sort_by_key(|s| (Scheme::ALL.iter().position(|scheme| *scheme == s.scheme), s.flow.map(|flow| flow as u8)));
    methods.dedup_by_key(|s| (s.scheme, s.flow));
    for method in methods {
        for (numbers, marker) in NUMBERS {
            let chosen = points(&|m| {
                let s = &m.setting;
                (s.scheme, s.flow) == (method.scheme, method.flow) && s.numbers == numbers && s.level.is_none()
            });
            if !chosen.is_empty() {
                let label = format!("{} {numbers}", method.method());
                let color = Some(color(method));
                curves.push(Curve { join: Join::Points, marker, color, ..Curve::new(label, chosen) });
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

/// Profiles of the line in one plot, the disc side by side and cut through. Returns what was written.
pub fn fronts(shown: &[Shown], out: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut written = Vec::new();
    let line: Vec<&Shown> = shown.iter().filter(|s| s.problem == "P2 line").collect();
    if !line.is_empty() {
        let profiles = line.iter().map(|s| profile(s, s.phi.clone(), 3.0, 1.5));
        let path = out.join("p2_line.png");
        plot("P2 line at t = 0.8 τ", profiles.collect(), None).write_png(&path)?;
        written.push(path);
    }
    let disc: Vec<&Shown> = shown.iter().filter(|s| s.problem == "P2 disc").collect();
    let Some(first) = disc.first() else { return Ok(written) };
    // The singularity of the inner front would take all colours.
    let reach = first.phi.iter().fold(0.0f64, |m, v| m.max(*v));
    let style = Style {
        bar: false,
        axes: false,
        range: ColorRange::Fixed(-reach, reach),
        quantity: "φ".into(),
        side: 384,
        ..Style::default()
    };
    let mut pictures = Vec::new();
    for s in &disc {
        let plane = Plane::new(s.cells, [0.0; 2], 2.4 / s.cells[0] as f64, s.phi.clone())?;
        pictures.push((draw(&plane, &style), s.words.clone()));
    }
    let bar = color_bar(&style, [-reach, reach], pictures[0].0.height());
    let path = out.join("p2_disc.png");
    contact_sheet(&pictures, 4, Some(&bar), Theme::default()).write_png(&path)?;
    written.push(path);
    let cuts = disc.iter().map(|s| {
        let row = s.cells[1] / 2 * s.cells[0];
        profile(s, s.phi[row..][..s.cells[0]].to_vec(), 2.4, 1.2)
    });
    let path = out.join("p2_disc_cut.png");
    plot("P2 disc at t = 0.6 τ, beside its middle", cuts.collect(), Some([-0.45, 0.35])).write_png(&path)?;
    written.push(path);
    Ok(written)
}

fn profile(s: &Shown, phi: Vec<f64>, length: f64, middle: f64) -> Curve {
    let count = phi.len() as f64;
    let place = |i: usize| length * (i as f64 + 0.5) / count - middle;
    let points = phi.into_iter().enumerate().map(|(i, phi)| [place(i), phi]).collect();
    let join = if s.words == "exact" { Join::Dashed } else { Join::Solid };
    Curve { join, ..Curve::new(s.words.clone(), points) }
}

fn plot(title: &str, curves: Vec<Curve>, range: Option<[f64; 2]>) -> Plot {
    let axis = |name: &str| PlotAxis { name: name.into(), ..PlotAxis::default() };
    let y = PlotAxis { range, ..axis("φ") };
    Plot { title: title.into(), x: axis("x [cτ]"), y, curves, size: [900, 620], ..Plot::default() }
}
