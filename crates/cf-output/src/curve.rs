//! Curves of a plot: points, how they are joined, and their symbols.

use crate::color::Rgb;
use crate::surface::{Pen, Surface};

/// The symbol at each point of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Marker {
    /// None.
    #[default]
    None,
    /// A disc.
    Circle,
    /// A square.
    Square,
    /// A triangle, tip up.
    Triangle,
    /// A square on its corner.
    Diamond,
}

/// How the points of a curve are joined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Join {
    /// By a line.
    #[default]
    Solid,
    /// By a dashed line, for references and theory.
    Dashed,
    /// Not at all.
    Points,
}

/// One curve. Points that are not finite, or not positive on a log axis, leave a gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    /// Legend text; empty for none.
    pub label: String,
    /// (x, y) in drawing order.
    pub points: Vec<[f64; 2]>,
    /// Line style.
    pub join: Join,
    /// Symbols.
    pub marker: Marker,
    /// Colour; the next one of a colour-blind safe list if `None`.
    pub color: Option<Rgb>,
}

impl Curve {
    /// A solid line without symbols.
    pub fn new(label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { label: label.into(), points, ..Self::default() }
    }
}

/// Draws what has been collected since the last gap.
pub(crate) fn join(surface: &mut impl Surface, run: &mut Vec<[f64; 2]>, join: Join, pen: Pen, clip: [f64; 4]) {
    if run.len() > 1 && join != Join::Points {
        surface.line(run, pen, clip);
    }
    run.clear();
}

/// Draws a symbol.
pub(crate) fn mark(surface: &mut impl Surface, marker: Marker, [x, y]: [f64; 2], color: Rgb) {
    let polygon = |corners: usize, radius: f64, turn: f64| -> Vec<[f64; 2]> {
        let angle = |n: usize| std::f64::consts::TAU * (n as f64 / corners as f64 + turn);
        (0..corners).map(|n| [x + radius * angle(n).cos(), y + radius * angle(n).sin()]).collect()
    };
    let corners = match marker {
        Marker::None => return,
        Marker::Circle => polygon(24, 4.2, 0.0),
        Marker::Square => polygon(4, 5.2, 0.125),
        Marker::Triangle => polygon(3, 5.6, -0.25),
        Marker::Diamond => polygon(4, 5.6, 0.0),
    };
    surface.convex(&corners, color);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::canvas::Canvas;

    #[test]
    fn every_symbol_covers_its_point() {
        for marker in [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond] {
            let mut canvas = Canvas::new(21, 21, [255; 3]);
            mark(&mut canvas, marker, [10.5, 10.5], [0; 3]);
            assert_eq!(canvas.get(10, 10), Some([0; 3]), "{marker:?}");
            assert_eq!(canvas.get(1, 1), Some([255; 3]), "{marker:?}");
        }
    }

    #[test]
    fn a_single_point_or_no_line_draws_nothing_and_empties_the_run() {
        let mut canvas = Canvas::new(9, 9, [255; 3]);
        let (pen, clip) = (Pen::new(2.0, [0; 3]), [0.0, 0.0, 9.0, 9.0]);
        for (points, style) in [(vec![[4.0; 2]], Join::Solid), (vec![[0.0; 2], [9.0; 2]], Join::Points)] {
            let mut run = points;
            join(&mut canvas, &mut run, style, pen, clip);
            assert!(run.is_empty() && canvas == Canvas::new(9, 9, [255; 3]));
        }
    }
}
