//! Line and scatter plots, as PNG and as SVG from the same drawing.

use std::path::Path;

use crate::OutputError;
use crate::atomic::write_text;
use crate::axes::{Axis, AxisScale};
use crate::canvas::Canvas;
use crate::color::{Rgb, Theme, line_color};
use crate::curve::{Curve, Join, join, mark};
use crate::font;
use crate::surface::{Anchor, Pen, Surface, Svg};

/// One axis of a plot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlotAxis {
    /// Name and unit.
    pub name: String,
    /// Linear or logarithmic.
    pub scale: AxisScale,
    /// Fixed ends; from the data, with a small margin, if `None`.
    pub range: Option<[f64; 2]>,
}

/// A plot of curves over two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Above the axes.
    pub title: String,
    /// Horizontal axis.
    pub x: PlotAxis,
    /// Vertical axis.
    pub y: PlotAxis,
    /// Curves, the last on top.
    pub curves: Vec<Curve>,
    /// Width and height in pixels, 160 to 4096.
    pub size: [usize; 2],
    /// Light or dark surroundings.
    pub theme: Theme,
}

impl Default for Plot {
    fn default() -> Self {
        Self {
            title: String::new(),
            x: PlotAxis::default(),
            y: PlotAxis::default(),
            curves: vec![],
            size: [760, 520],
            theme: Theme::default(),
        }
    }
}

const TITLE: f64 = 12.0;
const LABEL: f64 = 10.5;
const TICK: f64 = 9.5;
const ROW: f64 = 20.0;

impl Plot {
    /// The plot as pixels.
    pub fn draw(&self) -> Canvas {
        let [w, h] = self.bounded();
        let mut canvas = Canvas::new(w as usize, h as usize, self.theme.background());
        self.draw_on(&mut canvas);
        canvas
    }

    /// The plot as SVG text.
    pub fn svg(&self) -> String {
        let [w, h] = self.bounded();
        let mut svg = Svg::new(w, h, self.theme.background());
        self.draw_on(&mut svg);
        svg.finish()
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// As [`write_atomic`](crate::write_atomic).
    pub fn write_png(&self, path: &Path) -> Result<(), OutputError> {
        self.draw().write_png(path)
    }

    /// Writes an SVG.
    ///
    /// # Errors
    /// As [`write_atomic`](crate::write_atomic).
    pub fn write_svg(&self, path: &Path) -> Result<(), OutputError> {
        write_text(path, &self.svg())
    }

    fn bounded(&self) -> [f64; 2] {
        self.size.map(|n| n.clamp(160, 4096) as f64)
    }

    fn axis(&self, which: usize, length: f64) -> Axis {
        let (asked, other) = if which == 0 { (&self.x, &self.y) } else { (&self.y, &self.x) };
        let count = (length / if which == 0 { 90.0 } else { 60.0 }).max(2.0) as usize;
        if let Some(range) = asked.range {
            return Axis::new(asked.scale, [range[0].min(range[1]), range[0].max(range[1])], count);
        }
        let log = |axis: &PlotAxis| axis.scale == AxisScale::Log;
        // A point that cannot be drawn does not stretch either axis.
        let shown = |v: f64, axis: &PlotAxis| v.is_finite() && (!log(axis) || v > 0.0);
        let values = || {
            let points = self.curves.iter().flat_map(|c| &c.points);
            points.filter(|p| shown(p[which], asked) && shown(p[1 - which], other)).map(|p| p[which])
        };
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let range = if low > high {
            [if log(asked) { 0.1 } else { 0.0 }, 1.0]
        } else if log(asked) {
            let margin = (high / low).powf(0.04).max(1.1);
            [low / margin, high * margin]
        } else {
            let margin = 0.04 * (high - low);
            // Data that start at zero keep their zero on the axis.
            [if low == 0.0 { 0.0 } else { low - margin }, if high == 0.0 { 0.0 } else { high + margin }]
        };
        Axis::new(asked.scale, range, count)
    }

    fn draw_on(&self, surface: &mut impl Surface) {
        let [width, height] = self.bounded();
        let ink = self.theme.ink();
        let top = if self.title.is_empty() { 18.0 } else { 18.0 + TITLE + 12.0 };
        let vertical = self.axis(1, height - top - 60.0);
        let labels = vertical.ticks.iter().map(|t| font::width(&t.label, TICK)).fold(0.0, f64::max);
        let names = [self.axis(0, width).title(&self.x.name), vertical.title(&self.y.name)];
        let left = 14.0 + labels + 10.0 + if names[1].is_empty() { 0.0 } else { LABEL + 14.0 };
        let bottom = height - 16.0 - TICK - 10.0 - if names[0].is_empty() { 0.0 } else { LABEL + 12.0 };
        let field = [left.round(), top.round(), (width - 24.0).round(), bottom.round()];
        let axes = [self.axis(0, field[2] - field[0]), vertical];
        let names = [axes[0].title(&self.x.name), names[1].clone()];
        self.grid(surface, &axes, field);
        for (n, curve) in self.curves.iter().enumerate() {
            self.curve(surface, curve, n, &axes, field);
        }
        outline(surface, field, ink);
        surface.text([field[0], field[1] - 12.0], &self.title, TITLE, ink, Anchor::Start, false);
        let middle = [0.5 * (field[0] + field[2]), 0.5 * (field[1] + field[3])];
        surface.text([middle[0], height - 14.0], &names[0], LABEL, ink, Anchor::Middle, false);
        surface.text([14.0 + LABEL, middle[1]], &names[1], LABEL, ink, Anchor::Middle, true);
        self.legend(surface, &axes, field);
    }

    fn grid(&self, surface: &mut impl Surface, axes: &[Axis; 2], [x0, y0, x1, y1]: [f64; 4]) {
        let (ink, faint) = (self.theme.ink(), Pen::new(1.0, self.theme.faint()));
        for tick in &axes[0].ticks {
            let Some(t) = axes[0].position(tick.value) else { continue };
            let x = (x0 + t * (x1 - x0)).floor() + 0.5;
            surface.line(&[[x, y0], [x, y1]], faint, [x0, y0, x1, y1]);
            surface.text([x, y1 + 8.0 + TICK], &tick.label, TICK, ink, Anchor::Middle, false);
        }
        for tick in &axes[1].ticks {
            let Some(t) = axes[1].position(tick.value) else { continue };
            let y = (y1 - t * (y1 - y0)).floor() + 0.5;
            surface.line(&[[x0, y], [x1, y]], faint, [x0, y0, x1, y1]);
            surface.text([x0 - 8.0, y + 0.5 * TICK], &tick.label, TICK, ink, Anchor::End, false);
        }
    }

    fn curve(&self, surface: &mut impl Surface, curve: &Curve, n: usize, axes: &[Axis; 2], field: [f64; 4]) {
        let color = curve.color.unwrap_or_else(|| line_color(n, self.theme));
        let mut run: Vec<[f64; 2]> = vec![];
        let pen = Pen { dashed: curve.join == Join::Dashed, ..Pen::new(2.0, color) };
        for point in &curve.points {
            match place(*point, axes, field) {
                Some(at) => run.push(at),
                None => join(surface, &mut run, curve.join, pen, field),
            }
        }
        join(surface, &mut run, curve.join, pen, field);
        for at in curve.points.iter().filter_map(|p| place(*p, axes, field)) {
            let inside = at[0] >= field[0] - 1.0
                && at[0] <= field[2] + 1.0
                && at[1] >= field[1] - 1.0
                && at[1] <= field[3] + 1.0;
            if inside {
                mark(surface, curve.marker, at, color);
            }
        }
    }

    /// In the corner with the fewest points below it.
    fn legend(&self, surface: &mut impl Surface, axes: &[Axis; 2], field: [f64; 4]) {
        let named: Vec<(usize, &Curve)> = self.curves.iter().enumerate().filter(|(_, c)| !c.label.is_empty()).collect();
        if named.is_empty() {
            return;
        }
        let widest = named.iter().map(|(_, c)| font::width(&c.label, LABEL)).fold(0.0, f64::max);
        let (w, h) = (46.0 + widest * 1.05 + 10.0, ROW * named.len() as f64 + 10.0);
        let corners = [
            [field[2] - w - 10.0, field[1] + 10.0],
            [field[0] + 10.0, field[1] + 10.0],
            [field[2] - w - 10.0, field[3] - h - 10.0],
            [field[0] + 10.0, field[3] - h - 10.0],
        ];
        let covered = |[x, y]: [f64; 2]| {
            let hit = |p: &[f64; 2]| p[0] >= x - 6.0 && p[0] <= x + w + 6.0 && p[1] >= y - 6.0 && p[1] <= y + h + 6.0;
            let along = |c: &Curve| {
                let placed: Vec<[f64; 2]> = c.points.iter().filter_map(|p| place(*p, axes, field)).collect();
                let between = placed.windows(2).flat_map(|s| {
                    // Long segments hide under a box without a point in it.
                    (1..8).map(|n| [0, 1].map(|a| s[0][a] + (s[1][a] - s[0][a]) * f64::from(n) / 8.0))
                });
                between.filter(hit).count() + placed.iter().filter(|p| hit(p)).count()
            };
            self.curves.iter().map(along).sum::<usize>()
        };
        let [x, y] = corners.into_iter().min_by_key(|c| covered(*c)).unwrap_or(corners[0]);
        surface.rectangle([x, y, x + w, y + h], self.theme.background(), 0.86);
        outline(surface, [x, y, x + w, y + h], self.theme.faint());
        for (row, (n, curve)) in named.into_iter().enumerate() {
            let base = y + 5.0 + ROW * (row as f64 + 0.5);
            let color = curve.color.unwrap_or_else(|| line_color(n, self.theme));
            let pen = Pen { dashed: curve.join == Join::Dashed, ..Pen::new(2.0, color) };
            let mut sample = vec![[x + 8.0, base], [x + 38.0, base]];
            join(surface, &mut sample, curve.join, pen, [x, y, x + w, y + h]);
            mark(surface, curve.marker, [x + 23.0, base], color);
            let at = [x + 46.0, base + 0.5 * LABEL];
            surface.text(at, &curve.label, LABEL, self.theme.ink(), Anchor::Start, false);
        }
    }
}

fn place(point: [f64; 2], axes: &[Axis; 2], [x0, y0, x1, y1]: [f64; 4]) -> Option<[f64; 2]> {
    let (u, v) = (axes[0].position(point[0])?, axes[1].position(point[1])?);
    Some([x0 + u * (x1 - x0), y1 - v * (y1 - y0)])
}

fn outline(surface: &mut impl Surface, [x0, y0, x1, y1]: [f64; 4], color: Rgb) {
    for edge in [[x0, y0, x1, y0 + 1.0], [x0, y1 - 1.0, x1, y1], [x0, y0, x0 + 1.0, y1], [x1 - 1.0, y0, x1, y1]] {
        surface.rectangle(edge, color, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Marker;
    use proptest::prelude::*;

    fn convergence() -> Plot {
        let curve = |order: i32, marker| {
            let points = (3..8).map(|n| [f64::from(1 << n), f64::from(1 << n).powi(-order)]).collect();
            Curve { marker, ..Curve::new(format!("order {order}"), points) }
        };
        let log = |name: &str| PlotAxis { name: name.into(), scale: AxisScale::Log, range: None };
        Plot {
            title: "Convergence".into(),
            x: log("cells"),
            y: log("error"),
            curves: vec![curve(1, Marker::Circle), curve(2, Marker::Square)],
            ..Plot::default()
        }
    }

    #[test]
    fn curves_and_words_are_in_the_svg() {
        let svg = convergence().svg();
        for part in ["Convergence", "cells", "error", "order 2", "10⁻⁴", "<polyline", "<polygon"] {
            assert!(svg.contains(part), "{part}");
        }
        assert_eq!(svg.matches("<polygon").count(), 2 * (5 + 1));
    }

    #[test]
    fn a_curve_is_drawn_in_its_colour_where_it_runs() {
        let mut plot = Plot { curves: vec![Curve::new("", vec![[0.0, 0.0], [1.0, 1.0]])], ..Plot::default() };
        plot.curves[0].color = Some([255, 0, 0]);
        (plot.x.range, plot.y.range) = (Some([0.0, 1.0]), Some([0.0, 1.0]));
        let canvas = plot.draw();
        let red: Vec<[usize; 2]> = (0..canvas.height())
            .flat_map(|y| (0..canvas.width()).map(move |x| [x, y]))
            .filter(|&[x, y]| canvas.get(x, y) == Some([255, 0, 0]))
            .collect();
        let low = red.iter().max_by_key(|p| p[1]).unwrap();
        let high = red.iter().min_by_key(|p| p[1]).unwrap();
        assert!(low[0] < 90 && high[0] > 700, "{low:?} {high:?}");
    }

    #[test]
    fn points_that_cannot_be_shown_leave_a_gap() {
        let points = vec![[1.0, 1.0], [2.0, 2.0], [3.0, f64::NAN], [4.0, 4.0], [5.0, 5.0]];
        let lines = |points| {
            let plot = Plot { curves: vec![Curve::new("", points)], ..Plot::default() };
            plot.svg().matches("stroke-width=\"2\"").count()
        };
        assert_eq!(lines(points), 2);
        assert_eq!(lines(vec![[1.0, 1.0], [2.0, 2.0]]), 1);
        assert_eq!(lines(vec![]), 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 24, ..ProptestConfig::default() })]

        #[test]
        fn anything_can_be_plotted(points: Vec<[f64; 2]>, log: bool, fixed: bool, w in 0_usize..400) {
            let scale = if log { AxisScale::Log } else { AxisScale::Linear };
            let range = points.first().copied().filter(|_| fixed);
            let axis = PlotAxis { name: "τ".into(), scale, range };
            let curve = Curve { marker: Marker::Diamond, join: Join::Dashed, ..Curve::new("a", points) };
            let plot = Plot { x: axis.clone(), y: axis, curves: vec![curve], size: [w, w], ..Plot::default() };
            plot.draw();
            let svg = plot.svg();
            prop_assert!(!svg.contains("NaN") && !svg.contains("inf"));
        }
    }
}
