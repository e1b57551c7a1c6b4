//! Colour bars: the map, its ticks, quantity and unit.

use crate::axes::{Axis, AxisScale};
use crate::canvas::Canvas;
use crate::color::{ColorRange, Display, Palette, Rgb};
use crate::font;
use crate::picture::{LABEL, Style, TICK};
use crate::surface::{Anchor, Pen, Surface};

/// Width of the coloured strip in pixels.
const BAR: f64 = 18.0;
/// Room above and below the bar for half of a label.
pub(crate) const BAR_MARGIN: f64 = 8.0;
/// Length of the arrow at an end beyond which there are values, in pixels.
const ARROW: f64 = 7.0;
/// Bars beside thin pictures are at least this long, in pixels.
pub(crate) const SHORTEST_BAR: f64 = 120.0;

/// A colour bar of its own, `height` pixels between its ends, for several pictures with one scale.
pub fn color_bar(style: &Style, range: [f64; 2], height: usize) -> Canvas {
    let range = style.display.range(ColorRange::Auto.resolve(range));
    let height = height.clamp(20, 8000) as f64;
    let axis = bar_axis(style, range, height);
    let title = axis.title(&style.quantity);
    let labels = axis.ticks.iter().map(|t| font::width(&t.label, TICK)).fold(0.0, f64::max);
    let width = BAR + 9.0 + labels + if title.is_empty() { 4.0 } else { 12.0 + LABEL + 6.0 };
    let theme = style.theme;
    let mut canvas = Canvas::new(width as usize, (height + 2.0 * BAR_MARGIN) as usize, theme.background());
    let palette = Palette::new(style.map, style.display, range);
    let middle = 0.5 * (1.0 + BAR);
    for (end, y, tip) in [(0, BAR_MARGIN + height, ARROW), (1, BAR_MARGIN, -ARROW)] {
        if style.clipped[end] {
            // The rim, and in it the colour of what goes on; corners in one sense of rotation.
            let half = |width: f64| 0.5 * width * tip.signum();
            let arrow =
                |width: f64, tip: f64| [[middle - half(width), y], [middle + half(width), y], [middle, y + tip]];
            canvas.convex(&arrow(BAR + 1.0, tip), theme.ink());
            canvas.convex(&arrow(BAR - 3.0, 0.75 * tip), palette.at(end as f64));
        }
    }
    for y in 0..height as usize {
        let t = 1.0 - (y as f64 + 0.5) / height;
        let row = BAR_MARGIN + y as f64;
        canvas.rectangle([1.0, row, BAR, row + 1.0], palette.at(t), 1.0);
    }
    frame(&mut canvas, [1.0, BAR_MARGIN, BAR, BAR_MARGIN + height], theme.ink());
    for tick in &axis.ticks {
        let y = BAR_MARGIN + height * (1.0 - style.display.position(tick.value, range));
        let clip = [0.0, 0.0, width, height + 2.0 * BAR_MARGIN];
        canvas.line(&[[BAR, y], [BAR + 4.0, y]], Pen::new(1.2, theme.ink()), clip);
        canvas.text([BAR + 9.0, y + 0.5 * TICK], &tick.label, TICK, theme.ink(), Anchor::Start, false);
    }
    let at = [width - 6.0, BAR_MARGIN + 0.5 * height];
    canvas.text(at, &title, LABEL, theme.ink(), Anchor::Middle, true);
    canvas
}

fn bar_axis(style: &Style, range: [f64; 2], height: f64) -> Axis {
    let scale = if matches!(style.display, Display::Log(_)) { AxisScale::Log } else { AxisScale::Linear };
    // Zero lies somewhere between, so that both sides of it need ticks.
    let apart = if range[0] < 0.0 && matches!(style.display, Display::Power(_)) { 35.0 } else { 70.0 };
    let mut axis = Axis::new(scale, range, (height / apart).clamp(2.0, 12.0) as usize);
    // A power crowds the ticks of one end; keep those that have room.
    let mut last = f64::INFINITY;
    axis.ticks.retain(|tick| {
        let y = height * style.display.position(tick.value, range);
        let room = (y - last).abs() > 1.6 * TICK;
        if room {
            last = y;
        }
        room
    });
    axis
}

/// A line one pixel wide around an area.
pub(crate) fn frame(canvas: &mut Canvas, [x0, y0, x1, y1]: [f64; 4], ink: Rgb) {
    canvas.rectangle([x0 - 1.0, y0 - 1.0, x1 + 1.0, y0], ink, 1.0);
    canvas.rectangle([x0 - 1.0, y1, x1 + 1.0, y1 + 1.0], ink, 1.0);
    canvas.rectangle([x0 - 1.0, y0, x0, y1], ink, 1.0);
    canvas.rectangle([x1, y0, x1 + 1.0, y1], ink, 1.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{ColorMap, Theme};

    #[test]
    fn the_bar_runs_from_the_low_colour_up_to_the_high_one() {
        let style = Style { map: ColorMap::Inferno, ..Style::default() };
        let bar = color_bar(&style, [0.0, 1.0], 200);
        let at = |y: f64| bar.get(8, y as usize).map(|c| c.map(u32::from).iter().sum::<u32>());
        assert!(at(BAR_MARGIN + 2.0) > Some(600) && at(BAR_MARGIN + 197.0) < Some(40));
    }

    #[test]
    fn values_beyond_an_end_make_it_an_arrow() {
        let bar = |clipped| color_bar(&Style { map: ColorMap::Inferno, clipped, ..Style::default() }, [0.0, 1.0], 200);
        let (plain, white) = (bar([false; 2]), Some(Theme::Light.background()));
        let ends = [BAR_MARGIN + 202.0, BAR_MARGIN - 3.0].map(|y| y as usize);
        for (n, clipped) in [[true, false], [false, true]].into_iter().enumerate() {
            let bar = bar(clipped);
            assert!(bar.get(9, ends[n]) != white && bar.get(9, ends[1 - n]) == white, "{clipped:?}");
            assert_eq!((bar.width(), bar.height()), (plain.width(), plain.height()));
        }
    }

    #[test]
    fn ticks_crowded_by_a_gamma_keep_their_distance() {
        let style = Style { display: Display::Gamma(0.1), ..Style::default() };
        let axis = bar_axis(&style, [0.0, 1.0], 300.0);
        let at: Vec<f64> = axis.ticks.iter().map(|t| 300.0 * style.display.position(t.value, [0.0, 1.0])).collect();
        assert!(at.len() >= 2 && at.windows(2).all(|w| w[1] - w[0] > TICK), "{at:?}");
    }
}
