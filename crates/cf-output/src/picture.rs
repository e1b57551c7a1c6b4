//! Pictures of a scalar on a plane: colours, axes, colour bar, title, overlaid lines.

use crate::axes::{Axis, AxisScale};
use crate::bar::{BAR_MARGIN, SHORTEST_BAR, color_bar, frame};
use crate::canvas::Canvas;
use crate::color::{ColorMap, ColorRange, Display, Palette, Theme, clipped};
use crate::font;
use crate::overlay::{LEGEND_ROW, Overlay, legend, legend_rows, two_tone};
use crate::plane::Plane;
use crate::surface::{Anchor, Pen, Surface};

/// How a picture looks; start from `Style::default()` and change what matters.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// Top left.
    pub title: String,
    /// Top right, for example `t = 12.5 s`.
    pub time: String,
    /// Beside the colour bar: quantity and unit.
    pub quantity: String,
    /// Below and left of the axes: name and unit.
    pub axis_names: [String; 2],
    /// Draw axes with ticks.
    pub axes: bool,
    /// Draw the colour bar.
    pub bar: bool,
    /// Colour map.
    pub map: ColorMap,
    /// Values at the ends of the map.
    pub range: ColorRange,
    /// Spreading of values over the map; display only.
    pub display: Display,
    /// There are values beyond the low, the high end of the range: the colour bar ends in arrows. [`draw`] adds to it
    /// what it sees.
    pub clipped: [bool; 2],
    /// Light or dark surroundings.
    pub theme: Theme,
    /// Lines over the field.
    pub overlays: Vec<Overlay>,
    /// Wanted length of the longer side of the field in pixels; cells are enlarged or averaged by whole numbers.
    pub side: usize,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            title: String::new(),
            time: String::new(),
            quantity: String::new(),
            axis_names: [const { String::new() }; 2],
            axes: true,
            bar: true,
            map: ColorMap::default(),
            range: ColorRange::default(),
            display: Display::default(),
            clipped: [false; 2],
            theme: Theme::default(),
            overlays: vec![],
            side: 720,
        }
    }
}

const TITLE: f64 = 12.0;
pub(crate) const LABEL: f64 = 10.0;
pub(crate) const TICK: f64 = 9.0;
const PAD: f64 = 14.0;

/// Draws a plane. Any style and any values give a picture; cells without a number are magenta, solid ones grey.
pub fn draw(plane: &Plane, style: &Style) -> Canvas {
    let (pixels, size) = raster(plane, style);
    let area = Layout::new(plane, style, size);
    let mut canvas = Canvas::new(area.width, area.height, style.theme.background());
    canvas.paste(&pixels, area.left as usize, area.top as usize);
    let field = [area.left, area.top, area.left + size[0], area.top + size[1]];
    overlays(&mut canvas, style, plane, field);
    if style.axes {
        draw_axes(&mut canvas, style, &area, field);
    }
    let ink = style.theme.ink();
    if area.headed {
        let base = area.top - 11.0;
        canvas.text([area.left, base], &style.title, TITLE, ink, Anchor::Start, false);
        canvas.text([field[2], base], &style.time, TITLE, ink, Anchor::End, false);
    }
    legend(&mut canvas, style, [field[0], area.legend], size[0]);
    if style.bar {
        let range = style.range.resolve(plane.range());
        let beyond = clipped(plane.range(), style.display.range(range));
        let clipped = [0, 1].map(|end| style.clipped[end] || beyond[end]);
        let bar = color_bar(&Style { clipped, ..style.clone() }, range, size[1].max(SHORTEST_BAR) as usize);
        canvas.paste(&bar, (field[2] + PAD) as usize, (area.top - BAR_MARGIN) as usize);
    }
    canvas
}

/// Where the parts of a picture go, in pixels.
struct Layout {
    width: usize,
    height: usize,
    left: f64,
    top: f64,
    headed: bool,
    axes: [Axis; 2],
    /// Baselines below the field: tick labels, axis name.
    below: [f64; 2],
    /// Baseline of the first row of the legend.
    legend: f64,
}

impl Layout {
    fn new(plane: &Plane, style: &Style, size: [f64; 2]) -> Self {
        let (low, high) = (plane.origin(), plane.end());
        let axes = [0, 1].map(|a| {
            let count = (size[a] / if a == 0 { 110.0 } else { 75.0 }).clamp(1.0, 8.0) as usize;
            Axis::new(AxisScale::Linear, [low[a], high[a]], count)
        });
        let labels = axes[1].ticks.iter().map(|t| font::width(&t.label, TICK)).fold(0.0, f64::max);
        let name = |a: usize| !axes[a].title(&style.axis_names[a]).is_empty();
        let mut left = PAD;
        if style.axes {
            left += labels + 9.0 + if name(1) { LABEL + 12.0 } else { 0.0 };
        }
        let headed = !(style.title.is_empty() && style.time.is_empty());
        let top = PAD + if headed { TITLE + 11.0 } else { 0.0 };
        let ticks = top + size[1] + 10.0 + TICK;
        let named = ticks + if name(0) { 10.0 + LABEL } else { 0.0 };
        let end = if style.axes { named } else { top + size[1] };
        let legend = end + 14.0 + LABEL;
        let bottom = if legend_rows(style, size[0]).is_empty() {
            end
        } else {
            legend + LEGEND_ROW * (legend_rows(style, size[0]).len() - 1) as f64
        };
        // Titles longer than the field widen the picture instead of running into each other.
        let heads = font::width(&style.title, TITLE) + font::width(&style.time, TITLE) + 24.0;
        let mut right = left + size[0].max(if headed { heads.min(1200.0) } else { 0.0 });
        let mut bottom = bottom + PAD;
        if style.bar {
            let height = size[1].max(SHORTEST_BAR);
            let bar = color_bar(style, style.range.resolve(plane.range()), height as usize);
            right = right.max(left + size[0] + PAD + bar.width() as f64);
            bottom = bottom.max(top + height + BAR_MARGIN);
        } else {
            // Room for half of the last tick label.
            right += 0.5 * font::width("0000", TICK);
        }
        Self {
            width: (right + PAD) as usize,
            height: bottom as usize,
            left: left.round(),
            top: top.round(),
            headed,
            axes,
            below: [ticks, named],
            legend,
        }
    }
}

/// The field itself in pixels, and its size.
fn raster(plane: &Plane, style: &Style) -> (Canvas, [f64; 2]) {
    let longest = plane.cells().into_iter().max().unwrap_or(1).max(1);
    let side = style.side.clamp(32, 8192);
    let by = ((longest as f64 / side as f64).round() as usize).max(1);
    let (cells, values) = plane.reduced(by);
    let zoom = if by > 1 { 1 } else { ((side as f64 / longest as f64).round() as usize).max(1) };
    // A field of few rows still gets a visible strip.
    let stretch = cells.map(|n| if n * zoom < 8 { 8_usize.div_ceil(n * zoom) } else { 1 });
    let (w, h) = (cells[0] * zoom * stretch[0], cells[1] * zoom * stretch[1]);
    let range = style.display.range(style.range.resolve(plane.range()));
    let palette = Palette::new(style.map, style.display, range);
    let mut canvas = Canvas::new(w, h, style.theme.background());
    for y in 0..h {
        let row = cells[1] - 1 - y / (zoom * stretch[1]);
        for x in 0..w {
            let color = match values[row * cells[0] + x / (zoom * stretch[0])] {
                None => style.theme.solid(),
                Some(value) if value.is_nan() => style.theme.missing(),
                Some(value) => palette.of(value),
            };
            canvas.set(x, y, color);
        }
    }
    let size = [canvas.width() as f64, canvas.height() as f64];
    (canvas, size)
}

fn overlays(canvas: &mut Canvas, style: &Style, plane: &Plane, field: [f64; 4]) {
    let (low, high) = (plane.origin(), plane.end());
    let place = |p: &[f64; 2]| {
        [
            field[0] + (p[0] - low[0]) / (high[0] - low[0]) * (field[2] - field[0]),
            field[3] - (p[1] - low[1]) / (high[1] - low[1]) * (field[3] - field[1]),
        ]
    };
    for overlay in &style.overlays {
        let points: Vec<[f64; 2]> = overlay.points.iter().map(place).collect();
        two_tone(canvas, &points, overlay, field);
    }
}

fn draw_axes(canvas: &mut Canvas, style: &Style, area: &Layout, field: [f64; 4]) {
    let ink = style.theme.ink();
    let [x0, y0, x1, y1] = field;
    frame(canvas, field, ink);
    let everywhere = [0.0, 0.0, area.width as f64, area.height as f64];
    for tick in &area.axes[0].ticks {
        let Some(t) = area.axes[0].position(tick.value) else { continue };
        let x = x0 + t * (x1 - x0);
        canvas.line(&[[x, y1 + 1.0], [x, y1 + 5.0]], Pen::new(1.2, ink), everywhere);
        canvas.text([x, area.below[0]], &tick.label, TICK, ink, Anchor::Middle, false);
    }
    for tick in &area.axes[1].ticks {
        let Some(t) = area.axes[1].position(tick.value) else { continue };
        let y = y1 - t * (y1 - y0);
        canvas.line(&[[x0 - 5.0, y], [x0 - 1.0, y]], Pen::new(1.2, ink), everywhere);
        canvas.text([x0 - 9.0, y + 0.5 * TICK], &tick.label, TICK, ink, Anchor::End, false);
    }
    let names = [0, 1].map(|a| area.axes[a].title(&style.axis_names[a]));
    canvas.text([0.5 * (x0 + x1), area.below[1]], &names[0], LABEL, ink, Anchor::Middle, false);
    canvas.text([PAD + LABEL, 0.5 * (y0 + y1)], &names[1], LABEL, ink, Anchor::Middle, true);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ramp(cells: [usize; 2]) -> Plane {
        let values = (0..cells[0] * cells[1]).map(|n| (n / cells[0]) as f64).collect();
        Plane::new(cells, [0.0; 2], 0.1, values).unwrap()
    }

    fn bare() -> Style {
        Style { axes: false, bar: false, map: ColorMap::Grey, ..Style::default() }
    }

    #[test]
    fn the_vertical_axis_points_up() {
        let (pixels, _) = raster(&ramp([4, 4]), &bare());
        let bright = |y: usize| pixels.get(5, y).unwrap()[0];
        assert!(bright(2) > 240 && bright(pixels.height() - 3) < 15);
    }

    #[test]
    fn fields_are_scaled_by_whole_numbers_to_the_wanted_size() {
        let size = |n| raster(&ramp([n, 1]), &bare()).1[0];
        assert_eq!([size(1), size(7), size(64), size(200)], [720.0, 721.0, 704.0, 800.0]);
        assert_eq!([size(512), size(901), size(1200), size(4096)], [512.0, 901.0, 600.0, 683.0]);
    }

    #[test]
    fn cells_without_a_number_are_marked() {
        let plane = Plane::new([2, 1], [0.0; 2], 1.0, vec![f64::NAN, 1.0]).unwrap();
        let (pixels, _) = raster(&plane, &bare());
        assert_eq!(pixels.get(10, 10), Some(Theme::Light.missing()));
        assert_ne!(pixels.get(700, 10), Some(Theme::Light.missing()));
    }

    #[test]
    fn cells_below_zero_are_teal_in_the_field_and_on_its_bar() {
        let plane = Plane::new([2, 1], [0.0; 2], 1.0, vec![-1.0, 4.0]).unwrap();
        let style = Style { map: ColorMap::FireIce, display: Display::Power(0.5), ..bare() };
        let (pixels, _) = raster(&plane, &style);
        let [red, green, blue] = pixels.get(10, 1).unwrap();
        assert!(blue > red + 8 && green > red + 8);
        let bar = color_bar(&style, [-1.0, 4.0], 300);
        assert_eq!(bar.get(8, (BAR_MARGIN + 299.0) as usize).map(|c| c[2].abs_diff(blue) < 6), Some(true));
        // A third of the way up, where zero is: -1 and 4 have the roots 1 and 2.
        let zero = bar.get(8, (BAR_MARGIN + 200.0) as usize).unwrap();
        assert!(zero.iter().all(|c| *c < 12), "{zero:?}");
    }

    #[test]
    fn solid_cells_are_grey_at_every_size_and_have_no_range() {
        let solid = |n: usize| {
            let values = (0..n * n).map(|i| if i % n < n / 2 { 1e9 } else { (i / n) as f64 });
            let plane = Plane::new([n, n], [0.0; 2], 1.0, values.collect()).unwrap();
            plane.with_solid((0..n * n).map(|i| i % n < n / 2).collect()).unwrap()
        };
        for n in [4, 4000] {
            assert_eq!(solid(n).range(), [0.0, n as f64 - 1.0]);
            let (pixels, size) = raster(&solid(n), &bare());
            let at = |x: f64| pixels.get((x * size[0]) as usize, 9);
            assert!(at(0.4) == Some(Theme::Light.solid()) && at(0.6) != Some(Theme::Light.solid()), "{n}");
        }
    }

    #[test]
    fn a_picture_marks_what_its_range_leaves_out() {
        let style = |high| Style { range: ColorRange::Fixed(0.0, high), axes: false, ..Style::default() };
        let wide = draw(&ramp([4, 4]), &Style { clipped: [false, true], ..style(2.0) });
        assert_eq!(draw(&ramp([4, 4]), &style(2.0)), wide);
        assert_ne!(
            draw(&ramp([4, 4]), &style(3.0)),
            draw(&ramp([4, 4]), &Style { clipped: [false, true], ..style(3.0) })
        );
    }

    #[test]
    fn an_overlay_runs_where_it_says() {
        let plane = Plane::new([10, 10], [0.0; 2], 0.1, vec![0.0; 100]).unwrap();
        let line = Overlay { dashed: false, ..Overlay::straight([0.0, 0.0], [1.0, 1.0], "edge") };
        let with = draw(&plane, &Style { overlays: vec![line.clone()], ..bare() });
        let area = Layout::new(&plane, &Style { overlays: vec![line], ..bare() }, [720.0; 2]);
        let at = |x: f64, y: f64| with.get((area.left + x) as usize, (area.top + y) as usize).unwrap();
        assert_eq!(at(360.0, 359.0), [255; 3]);
        assert_ne!(at(360.0, 340.0), [255; 3]);
    }

    #[test]
    fn every_option_changes_the_picture() {
        let plane = ramp([30, 20]);
        let base = draw(&plane, &Style::default());
        let words = |change: &dyn Fn(&mut Style)| {
            let mut style = Style::default();
            change(&mut style);
            draw(&plane, &style)
        };
        let changed = [
            words(&|s| s.title = "a".into()),
            words(&|s| s.time = "b".into()),
            words(&|s| s.quantity = "c".into()),
            words(&|s| s.axis_names[0] = "x".into()),
            words(&|s| s.axis_names[1] = "y".into()),
            words(&|s| s.axes = false),
            words(&|s| s.bar = false),
            words(&|s| s.map = ColorMap::Inferno),
            words(&|s| s.range = ColorRange::Fixed(0.0, 3.0)),
            words(&|s| s.range = ColorRange::Symmetric),
            words(&|s| s.display = Display::Log(3)),
            words(&|s| s.display = Display::Gamma(0.5)),
            words(&|s| (s.display, s.map) = (Display::Power(0.5), ColorMap::FireIce)),
            words(&|s| s.theme = Theme::Dark),
            words(&|s| s.side = 300),
            words(&|s| s.clipped = [true, false]),
            words(&|s| s.overlays.push(Overlay::straight([0.0; 2], [1.0; 2], ""))),
        ];
        for (n, picture) in changed.iter().enumerate() {
            assert_ne!(picture, &base, "option {n}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 24, ..ProptestConfig::default() })]

        #[test]
        fn any_values_and_sizes_give_a_picture(
            nx in 1_usize..40, ny in 1_usize..40, seed: Vec<f64>, origin: f64, log: bool, side in 0_usize..200,
        ) {
            prop_assume!(origin.is_finite());
            let values = (0..nx * ny).map(|n| seed.get(n % seed.len().max(1)).copied().unwrap_or(0.0)).collect();
            let plane = Plane::new([nx, ny], [origin, 0.0], 0.1, values).unwrap();
            let display = if log { Display::Log(4) } else { Display::Gamma(0.5) };
            let overlays = vec![Overlay::straight([f64::NAN, 1.0], [origin, 1e300], "edge")];
            draw(&plane, &Style { display, side, overlays, title: "τ".into(), ..Style::default() });
        }
    }
}
