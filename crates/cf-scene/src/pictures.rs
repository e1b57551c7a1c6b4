//! Pictures of `phi`: one look for all frames of a run, and sheets that put runs side by side on one scale.

use crate::scene::{Grid, Scene};
use crate::spec::Pictures;
use crate::view::View;
use cf_output::{
    Canvas, ColorMap, ColorRange, Curve, Display, Join, Marker, OutputError, Plane, Plot, PlotAxis, Style, Theme,
    clipped, color_bar, common_range, contact_sheet, draw,
};
use std::fmt::Write;

/// The brightest share of the cells that have anything is cut off by an automatic range, so that a source does not
/// swamp its wake.
const CUT: f64 = 0.003;
/// What is below this share of the largest value counts as nothing.
const NOTHING: f64 = 1e-4;
/// Exponents of automatic ranges: they lift what is faint, of several pictures on one scale as far as the faintest needs.
const LIFT: [f64; 2] = [0.2, 0.5];
/// Where the largest value of the faintest picture should be on a scale of several.
const FAINTEST: f64 = 0.4;
/// What goes below zero by this share of the largest value is given its place on the scale.
const NEGATIVE: f64 = 1.0 / 256.0;

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    range: [f64; 2],
    display: Display,
    map: ColorMap,
}

impl Scale {
    /// The scale that shows these fields best, or as the scene says.
    pub fn of<'a>(pictures: Pictures, fields: impl Iterator<Item = &'a [f64]>) -> Scale {
        match pictures {
            Pictures::Linear { low, high } => {
                Scale { range: [low, high], display: Display::Linear, map: ColorMap::FireIce }
            }
            Pictures::Log { low, high } => {
                let decades = (high / low).log10().ceil().clamp(1.0, 300.0) as u32;
                Scale { range: [low, high], display: Display::Log(decades), map: ColorMap::Inferno }
            }
            Pictures::Off | Pictures::Auto => Scale::automatic(fields),
        }
    }

    fn automatic<'a>(fields: impl Iterator<Item = &'a [f64]>) -> Scale {
        let fields: Vec<Vec<f64>> =
            fields.map(|field| field.iter().copied().filter(|value| value.is_finite()).collect()).collect();
        let values = || fields.iter().flatten().copied();
        let [above, below] = [values().collect(), values().map(|value| -value).collect()].map(most);
        let low = if below > NEGATIVE * above { -round_up(below) } else { 0.0 };
        let high = match above {
            above if above > 0.0 => round_up(above),
            _ if low < 0.0 => 0.0,
            _ => 1.0,
        };
        let faintest = fields
            .iter()
            .map(|field| most(field.iter().map(|value| value.abs()).collect()))
            .filter(|top| *top > 0.0)
            .fold(f64::INFINITY, f64::min);
        // The exponent that shows the faintest at its place, in steps that can be read.
        let lift = FAINTEST.ln() / (faintest / high.max(-low)).min(0.999).ln();
        let lift = if lift.is_finite() { (20.0 * lift).round() / 20.0 } else { LIFT[1] };
        let display = Display::Power(lift.clamp(LIFT[0], LIFT[1]));
        Scale { range: [low, high], display, map: ColorMap::FireIce }
    }

    fn style(self) -> Style {
        let [low, high] = self.range;
        let range = ColorRange::Fixed(low, high);
        let mut quantity = String::from("φ [P]");
        if let Display::Power(power) = self.display {
            let _ = write!(quantity, ", colours by |φ|^{power}");
        }
        if low < 0.0 && self.map == ColorMap::FireIce {
            quantity.push_str(", teal below 0");
        }
        Style { range, display: self.display, map: self.map, quantity, ..Style::default() }
    }
}

/// The largest value above zero, but for the few that an automatic range leaves out; 0 if there is none.
fn most(mut values: Vec<f64>) -> f64 {
    let largest = values.iter().copied().fold(0.0, f64::max);
    values.retain(|value| *value > NOTHING * largest);
    let at = ((1.0 - CUT) * values.len() as f64) as usize;
    if at < values.len() { *values.select_nth_unstable_by(at, f64::total_cmp).1 } else { largest }
}

/// The next number with two digits.
pub(crate) fn round_up(value: f64) -> f64 {
    let unit = 10f64.powf(value.log10().floor() - 1.0);
    if unit > 0.0 && unit.is_finite() { (value / unit).ceil() * unit } else { value }
}

fn plane(scene: &Scene, view: &View, values: &[f64]) -> Result<Plane, OutputError> {
    let plane = Plane::new(view.cells, view.origin, view.spacing, values.to_vec())?;
    match view.solid(scene) {
        Some(solid) => plane.with_solid(solid),
        None => Ok(plane),
    }
}

fn axis_names(view: &View) -> [String; 2] {
    view.axes.map(|axis| format!("{} [m]", ["x", "y", "z"][axis]))
}

/// One frame of a run.
pub(crate) fn frame(
    scene: &Scene,
    view: &View,
    scale: Scale,
    time: f64,
    values: &[f64],
) -> Result<Canvas, OutputError> {
    let style = Style {
        title: scene.label.clone(),
        time: clock(scene, time),
        axis_names: axis_names(view),
        overlays: view.cone(scene),
        ..scale.style()
    };
    Ok(draw(&plane(scene, view, values)?, &style))
}

/// One frame of a run on a line.
pub(crate) fn line(scene: &Scene, span: [f64; 2], time: f64, values: &[f64]) -> Canvas {
    let title = format!("{}, {}", scene.label, clock(scene, time));
    plot(title, scene, span, vec![Curve { marker: Marker::None, ..Curve::new("", points(scene, values)) }]).draw()
}

/// The smallest and largest values with some air, for the plots of a run on a line.
pub(crate) fn span(low: f64, high: f64) -> [f64; 2] {
    let air = 0.05 * (high - low).max(f64::MIN_POSITIVE);
    [low - air, high + air]
}

/// A time with as many digits as frames need.
pub(crate) fn clock(scene: &Scene, time: f64) -> String {
    let interval = scene.schedule.interval;
    let digits = if interval > 0.0 { (1.0 - interval.log10().floor()).clamp(0.0, 9.0) as usize } else { 1 };
    format!("t = {time:.digits$} s")
}

fn points(scene: &Scene, values: &[f64]) -> Vec<[f64; 2]> {
    let origin = scene.grid.origin.first().copied().unwrap_or(0.0);
    values.iter().enumerate().map(|(i, value)| [origin + (i as f64 + 0.5) * scene.grid.spacing, *value]).collect()
}

fn plot(title: String, scene: &Scene, span: [f64; 2], curves: Vec<Curve>) -> Plot {
    let origin = scene.grid.origin.first().copied().unwrap_or(0.0);
    let end = origin + scene.grid.extent.first().copied().unwrap_or(1.0);
    Plot {
        title,
        x: PlotAxis { name: "x [m]".into(), range: Some([origin, end]), ..PlotAxis::default() },
        y: PlotAxis { name: "φ [P]".into(), range: Some(span), ..PlotAxis::default() },
        curves,
        ..Plot::default()
    }
}

/// The end of a run.
pub(crate) struct Last<'a> {
    pub scene: &'a Scene,
    pub time: f64,
    pub values: Vec<f64>,
    /// Numbers and times of its frames.
    pub frames: Vec<(u32, f64)>,
}

/// Whether two boxes have one size; of lines only the length counts.
pub(crate) fn alike(a: &Grid, b: &Grid) -> bool {
    if a.is_line() && b.is_line() { a.extent.first() == b.extent.first() } else { a.extent == b.extent }
}

/// The ends of all runs of one size side by side on one scale; `None` where there are fewer than two.
pub(crate) fn sheet(title: &str, lasts: &[Last<'_>]) -> Result<Option<Canvas>, OutputError> {
    let Some(first) = lasts.first() else { return Ok(None) };
    let alike: Vec<&Last<'_>> = lasts
        .iter()
        .filter(|last| {
            alike(&last.scene.grid, &first.scene.grid) && (last.time - first.time).abs() <= 1e-9 * first.time
        })
        .collect();
    if alike.len() < 2 {
        return Ok(None);
    }
    let Some(_) = View::of(first.scene) else {
        // Equal curves show where one is dashed and drawn last.
        let curves = alike.iter().enumerate().map(|(i, last)| Curve {
            marker: Marker::None,
            join: if i + 1 < alike.len() { Join::Solid } else { Join::Dashed },
            ..Curve::new(last.scene.label.clone(), points(last.scene, &last.values))
        });
        let values = || alike.iter().flat_map(|last| last.values.iter().copied());
        let span = span(values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        return Ok(Some(
            plot(format!("{title}, {}", clock(first.scene, first.time)), first.scene, span, curves.collect()).draw(),
        ));
    };
    let scale = Scale::of(first.scene.output.pictures, alike.iter().map(|last| &last.values[..]));
    let small = Style { axes: false, bar: false, side: 480, ..scale.style() };
    let (mut pictures, mut planes) = (Vec::new(), Vec::new());
    for last in &alike {
        let Some(view) = View::of(last.scene) else { continue };
        let overlays =
            view.cone(last.scene).into_iter().map(|line| cf_output::Overlay { label: String::new(), ..line });
        let plane = plane(last.scene, &view, &last.values)?;
        planes.push(plane.clone());
        let picture = draw(&plane, &Style { overlays: overlays.collect(), ..small.clone() });
        pictures.push((picture, last.scene.label.clone()));
    }
    let tall = pictures.iter().map(|(picture, _)| picture.height()).max().unwrap_or(240);
    let clipped = clipped(common_range(&planes), scale.range);
    let style = scale.style();
    let quantity = format!("{}; {}", style.quantity, clock(first.scene, first.time));
    let bar = color_bar(&Style { clipped, quantity, ..style }, scale.range, tall.min(400));
    let columns = if pictures.len() <= 6 { pictures.len() } else { pictures.len().div_ceil(2) };
    Ok(Some(contact_sheet(&pictures, columns, Some(&bar), Theme::Light)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_does_not_swamp_its_wake() {
        let mut values = vec![0.0; 10_000];
        values[..4000].fill(1.0);
        values[..8].fill(500.0);
        let scale = Scale::of(Pictures::Auto, [&values[..]].into_iter());
        assert_eq!((scale.range, scale.display), ([0.0, 1.0], Display::Power(0.5)));
        values[5000..9000].fill(-0.25);
        let signed = Scale::of(Pictures::Auto, [&values[..]].into_iter());
        assert_eq!((signed.range, signed.map), ([-0.25, 1.0], ColorMap::FireIce));
        assert!(signed.style().quantity.contains("teal below 0") && !scale.style().quantity.contains("teal"));
        assert_eq!(Scale::of(Pictures::Auto, [&[0.0; 9][..]].into_iter()).range, [0.0, 1.0]);
        assert_eq!(Scale::of(Pictures::Auto, [&[f64::NAN; 9][..]].into_iter()).range, [0.0, 1.0]);
    }

    #[test]
    fn a_faint_run_shows_beside_a_strong_one() {
        let fields = [[0.5; 100], [8.0; 100]];
        let scale = Scale::of(Pictures::Auto, fields.iter().map(|field| &field[..]));
        let Display::Power(power) = scale.display else { panic!("{:?}", scale.display) };
        assert!((0.2..0.4).contains(&power) && (0.5f64 / 8.0).powf(power) > 0.35, "{power}");
        assert!(scale.style().quantity.contains(&format!("^{power}")));
        let drop = [-2.0; 9];
        assert_eq!(Scale::of(Pictures::Auto, [&drop[..]].into_iter()).range, [-2.0, 0.0]);
    }

    #[test]
    fn a_scene_may_fix_the_range() {
        let log = Scale::of(Pictures::Log { low: 1e-3, high: 1.0 }, std::iter::empty());
        assert_eq!((log.range, log.display), ([1e-3, 1.0], Display::Log(3)));
    }
}
