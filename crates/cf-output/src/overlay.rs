//! Lines over a picture, such as a predicted cone, and their legend below it.

use crate::canvas::Canvas;
use crate::color::Rgb;
use crate::font;
use crate::picture::{LABEL, Style};
use crate::surface::{Anchor, Pen, Surface};

/// The place on the map of the colour behind a line of the legend.
const PATCH: f64 = 0.62;

/// Distance of legend rows in pixels.
pub(crate) const LEGEND_ROW: f64 = 18.0;

/// A line drawn over a picture, in the coordinates of the plane.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// Corners; two for a straight line. Parts outside the plane are cut away.
    pub points: Vec<[f64; 2]>,
    /// Legend text; empty for none. Lines that share a label share the legend entry.
    pub label: String,
    /// Line colour.
    pub color: Rgb,
    /// Dashed instead of solid.
    pub dashed: bool,
}

impl Overlay {
    /// A dashed white line with a dark rim, visible on every colour map.
    pub fn straight(from: [f64; 2], to: [f64; 2], label: impl Into<String>) -> Self {
        Self { points: vec![from, to], label: label.into(), color: [255; 3], dashed: true }
    }
}

/// A line over a darker, wider one, so that it shows on bright and dark colours alike.
pub(crate) fn two_tone(canvas: &mut Canvas, points: &[[f64; 2]], overlay: &Overlay, clip: [f64; 4]) {
    let line = Pen { dashed: overlay.dashed, ..Pen::new(1.8, overlay.color) };
    canvas.line(points, Pen { width: 3.8, color: [0; 3], alpha: 0.55, ..line }, clip);
    canvas.line(points, line, clip);
}

/// Overlays with a label of their own, in rows that fit the width.
pub(crate) fn legend_rows(style: &Style, width: f64) -> Vec<Vec<&Overlay>> {
    let mut rows: Vec<Vec<&Overlay>> = vec![];
    let (mut used, mut seen) = (f64::INFINITY, vec![]);
    for overlay in &style.overlays {
        if overlay.label.is_empty() || seen.contains(&&overlay.label) {
            continue;
        }
        seen.push(&overlay.label);
        let wide = legend_width(overlay);
        if used + wide > width {
            rows.push(vec![]);
            used = 0.0;
        }
        used += wide;
        if let Some(row) = rows.last_mut() {
            row.push(overlay);
        }
    }
    rows
}

fn legend_width(overlay: &Overlay) -> f64 {
    40.0 + font::width(&overlay.label, LABEL) + 22.0
}

/// Draws the legend in rows from `left`, the first on baseline `base`.
pub(crate) fn legend(canvas: &mut Canvas, style: &Style, [left, base]: [f64; 2], width: f64) {
    let everywhere = [0.0, 0.0, canvas.width() as f64, canvas.height() as f64];
    for (n, row) in legend_rows(style, width).into_iter().enumerate() {
        let base = base + LEGEND_ROW * n as f64;
        let mut x = left;
        for overlay in row {
            let y = base - 0.4 * LABEL;
            // On a patch of field colour, so that a white line shows on a white page too.
            canvas.rectangle([x, y - 7.0, x + 32.0, y + 7.0], style.map.at(PATCH), 1.0);
            two_tone(canvas, &[[x + 2.0, y], [x + 30.0, y]], overlay, everywhere);
            canvas.text([x + 40.0, base], &overlay.label, LABEL, style.theme.ink(), Anchor::Start, false);
            x += legend_width(overlay);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_names_each_label_once_and_wraps() {
        let line = |label: &str| Overlay::straight([0.0; 2], [1.0; 2], label);
        let overlays = ["cone", "cone", "", "front", "a much longer label than the others"].map(line).to_vec();
        let style = Style { overlays, ..Style::default() };
        let labels = |width: f64| {
            let rows = legend_rows(&style, width);
            rows.iter().map(|r| r.iter().map(|o| o.label.len()).collect()).collect::<Vec<Vec<_>>>()
        };
        assert_eq!(labels(2000.0), [vec![4, 5, 35]]);
        assert_eq!(labels(250.0), [vec![4, 5], vec![35]]);
    }
}
