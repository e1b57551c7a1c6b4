//! Pictures of `phi`: one look for all frames of a run, and sheets that put runs side by side on one scale.

use crate::scene::{Grid, Scene};
use crate::spec::Pictures;
use crate::view::View;
use cf_output::{
    Canvas, ColorMap, ColorRange, Curve, Display, Join, Marker, OutputError, Plane, Plot, PlotAxis, Style, Theme,
    clipped, color_bar, common_range, contact_sheet, draw,
};

/// The brightest share of the cells that have anything is cut off by an automatic range, so that a source does not
/// swamp its wake.
const CUT: f64 = 0.003;
/// What is below this share of the largest value counts as nothing.
const NOTHING: f64 = 1e-4;
/// Exponent of automatic ranges: lifts what is faint.
const LIFT: f64 = 0.5;
/// A share of negative values in the sum of |phi| beyond this makes the map a symmetric one.
const NEGATIVE: f64 = 0.1;

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
                Scale { range: [low, high], display: Display::Linear, map: ColorMap::Inferno }
            }
            Pictures::Log { low, high } => {
                let decades = (high / low).log10().ceil().clamp(1.0, 300.0) as u32;
                Scale { range: [low, high], display: Display::Log(decades), map: ColorMap::Inferno }
            }
            Pictures::Off | Pictures::Auto => Scale::automatic(fields.flatten().copied()),
        }
    }

    fn automatic(values: impl Iterator<Item = f64>) -> Scale {
        let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let whole: f64 = values.iter().map(|value| value.abs()).sum();
        let negative: f64 = values.iter().map(|value| -value.min(0.0)).sum();
        values.retain(|value| value.abs() > NOTHING * largest);
        let at = ((1.0 - CUT) * values.len() as f64) as usize;
        let high = if at < values.len() {
            values.select_nth_unstable_by(at, |a, b| a.abs().total_cmp(&b.abs())).1.abs()
        } else {
            largest
        };
        let high = if high > 0.0 { round_up(high) } else { 1.0 };
        if negative > NEGATIVE * whole {
            return Scale { range: [-high, high], display: Display::Linear, map: ColorMap::BlueRed };
        }
        Scale { range: [0.0, high], display: Display::Gamma(LIFT), map: ColorMap::Inferno }
    }

    fn style(self) -> Style {
        let [low, high] = self.range;
        let range = ColorRange::Fixed(low, high);
        Style { range, display: self.display, map: self.map, quantity: "φ [P]".into(), ..Style::default() }
    }
}

/// The next number with two digits.
fn round_up(value: f64) -> f64 {
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
    /// The cloud, where the scene asks for it.
    pub cloud: Option<Canvas>,
}

/// The clouds of all runs at their ends, side by side; `None` where there are fewer than two.
pub(crate) fn clouds(lasts: &[Last<'_>]) -> Option<Canvas> {
    let pictures: Vec<(Canvas, String)> =
        // Each has its run's label in it.
        lasts.iter().filter_map(|last| Some((last.cloud.clone()?, String::new()))).collect();
    let columns = if pictures.len() <= 6 { pictures.len() } else { pictures.len().div_ceil(2) };
    (pictures.len() > 1).then(|| contact_sheet(&pictures, columns, None, Theme::Light))
}

/// Whether two boxes have one size; of lines only the length counts.
fn alike(a: &Grid, b: &Grid) -> bool {
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
    let bar = color_bar(&Style { clipped, ..scale.style() }, scale.range, tall.min(400));
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
        assert_eq!((scale.range, scale.map), ([0.0, 1.0], ColorMap::Inferno));
        values[5000..9000].fill(-0.5);
        assert_eq!(Scale::of(Pictures::Auto, [&values[..]].into_iter()).range, [-1.0, 1.0]);
        assert_eq!(Scale::of(Pictures::Auto, [&[0.0; 9][..]].into_iter()).range, [0.0, 1.0]);
        assert_eq!(Scale::of(Pictures::Auto, [&[f64::NAN; 9][..]].into_iter()).range, [0.0, 1.0]);
    }

    #[test]
    fn a_scene_may_fix_the_range() {
        let log = Scale::of(Pictures::Log { low: 1e-3, high: 1.0 }, std::iter::empty());
        assert_eq!((log.range, log.display), ([1e-3, 1.0], Display::Log(3)));
    }
}
