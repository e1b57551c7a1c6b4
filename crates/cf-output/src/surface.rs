//! What plots are drawn on: a canvas of pixels or an SVG.

use std::fmt::Write;

use crate::color::Rgb;
use crate::text::escape;

/// Width in pixels, colour, dashes and opacity of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pen {
    pub width: f64,
    pub color: Rgb,
    pub dashed: bool,
    pub alpha: f64,
}

impl Pen {
    pub fn new(width: f64, color: Rgb) -> Self {
        Self { width, color, dashed: false, alpha: 1.0 }
    }
}

/// Which point of a text lies at the given position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    pub fn fraction(self) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => 0.5,
            Self::End => 1.0,
        }
    }
}

/// Drawing in pixels, y down; boxes are `[x0, y0, x1, y1]`.
pub(crate) trait Surface {
    fn rectangle(&mut self, area: [f64; 4], color: Rgb, alpha: f64);
    fn line(&mut self, points: &[[f64; 2]], pen: Pen, clip: [f64; 4]);
    /// A filled convex polygon, corners clockwise on the screen.
    fn convex(&mut self, corners: &[[f64; 2]], color: Rgb);
    /// `at` is on the baseline; `upward` text reads from bottom to top. `cap` is the height of capitals.
    fn text(&mut self, at: [f64; 2], text: &str, cap: f64, color: Rgb, anchor: Anchor, upward: bool);
}

/// An SVG under construction.
pub(crate) struct Svg {
    size: [f64; 2],
    body: String,
    clips: usize,
}

impl Svg {
    pub fn new(width: f64, height: f64, background: Rgb) -> Self {
        let mut svg = Self { size: [width, height], body: String::new(), clips: 0 };
        svg.rectangle([0.0, 0.0, width, height], background, 1.0);
        svg
    }

    pub fn finish(self) -> String {
        let [w, h] = self.size;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" \
             font-family=\"Helvetica, Arial, sans-serif\">\n{}</svg>\n",
            self.body
        )
    }
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Hundredths of a pixel are enough, and infinities are no SVG.
fn coordinate(v: f64) -> f64 {
    if v.is_nan() {
        return 0.0;
    }
    (v.clamp(-1e6, 1e6) * 100.0).round() / 100.0
}

fn pairs(points: &[[f64; 2]]) -> String {
    let text: Vec<String> = points.iter().map(|p| format!("{},{}", coordinate(p[0]), coordinate(p[1]))).collect();
    text.join(" ")
}

impl Surface for Svg {
    fn rectangle(&mut self, area: [f64; 4], color: Rgb, alpha: f64) {
        let [x0, y0, x1, y1] = area.map(coordinate);
        let _ = writeln!(
            self.body,
            "<rect x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\" fill=\"{}\" fill-opacity=\"{alpha}\"/>",
            (x1 - x0).max(0.0),
            (y1 - y0).max(0.0),
            hex(color)
        );
    }

    fn line(&mut self, points: &[[f64; 2]], pen: Pen, clip: [f64; 4]) {
        let [x0, y0, x1, y1] = clip.map(coordinate);
        self.clips += 1;
        let id = self.clips;
        let dash = if pen.dashed { " stroke-dasharray=\"7 5\"" } else { "" };
        let _ = writeln!(
            self.body,
            "<clipPath id=\"c{id}\"><rect x=\"{x0}\" y=\"{y0}\" width=\"{}\" height=\"{}\"/></clipPath>\n\
             <polyline points=\"{}\" clip-path=\"url(#c{id})\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" \
             stroke-opacity=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"{dash}/>",
            (x1 - x0).max(0.0),
            (y1 - y0).max(0.0),
            pairs(points),
            hex(pen.color),
            pen.width,
            pen.alpha
        );
    }

    fn convex(&mut self, corners: &[[f64; 2]], color: Rgb) {
        let _ = writeln!(self.body, "<polygon points=\"{}\" fill=\"{}\"/>", pairs(corners), hex(color));
    }

    fn text(&mut self, at: [f64; 2], text: &str, cap: f64, color: Rgb, anchor: Anchor, upward: bool) {
        let [x, y] = at.map(coordinate);
        let word = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn = if upward { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{}\" text-anchor=\"{word}\"{turn}>{}</text>",
            coordinate(cap / 0.72), // capitals of common sans-serif fonts
            hex(color),
            escape(text)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn svg_is_escaped_and_finite() {
        let mut svg = Svg::new(100.0, 50.0, [255; 3]);
        svg.text([1.0, f64::INFINITY], "a<b & φ²", 10.0, [1, 2, 3], Anchor::End, true);
        svg.line(&[[0.0, 1.0], [f64::NEG_INFINITY, 1e300]], Pen::new(1.0, [0; 3]), [0.0, 0.0, 9.0, 9.0]);
        let text = svg.finish();
        assert!(text.contains("a&lt;b &amp; φ²") && text.contains("#010203"), "{text}");
        assert!(!text.contains("inf") && !text.contains("NaN"), "{text}");
        assert_eq!(text.matches("<text").count(), text.matches("</text>").count());
    }
}
