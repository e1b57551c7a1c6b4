//! Shapes: where something is, as a weight between 0 and 1.

use super::Axes;
use serde::Deserialize;

/// An axis of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// Where something is. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shape {
    /// The whole domain.
    Everywhere,
    /// A box, its faces included.
    Box {
        /// The low corner.
        low: Axes<f64>,
        /// The high corner.
        high: Axes<f64>,
    },
    /// A disc or ball, its surface included.
    Ball {
        /// The centre.
        center: Axes<f64>,
        /// The radius.
        radius: f64,
    },
    /// exp(−r²/(2·width²)).
    Gaussian {
        /// The centre.
        center: Axes<f64>,
        /// The standard deviation.
        width: f64,
    },
    /// The half space of coordinates up to `at`.
    Below {
        /// The axis that is compared.
        axis: Axis,
        /// The boundary.
        at: f64,
    },
    /// The half space of coordinates from `at` on.
    Above {
        /// The axis that is compared.
        axis: Axis,
        /// The boundary.
        at: f64,
    },
    /// The product over the axes of cos(π·mode·x/extent), x from the low corner; between −1 and 1.
    Cosine {
        /// Half waves along each axis.
        modes: Axes<u32>,
    },
}

impl Axis {
    /// 0 for x, 1 for y, 2 for z.
    pub fn index(self) -> usize {
        match self {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        }
    }
}

impl Shape {
    /// The weight at a point of a domain with this low corner and extent \[m\]. All slices are as long as the dimension.
    pub fn weight(&self, point: &[f64], origin: &[f64], extent: &[f64]) -> f64 {
        let indicator = |inside: bool| if inside { 1.0 } else { 0.0 };
        let distance_squared = |center: &[f64]| -> f64 { point.iter().zip(center).map(|(x, c)| (x - c).powi(2)).sum() };
        let coordinate = |axis: Axis| point.get(axis.index()).copied().unwrap_or(0.0);
        match self {
            Shape::Everywhere => 1.0,
            Shape::Box { low, high } => {
                indicator(point.iter().zip(low.iter().zip(high.iter())).all(|(x, (low, high))| low <= x && x <= high))
            }
            Shape::Ball { center, radius } => indicator(distance_squared(center) <= radius * radius),
            Shape::Gaussian { center, width } => (-0.5 * distance_squared(center) / (width * width)).exp(),
            Shape::Below { axis, at } => indicator(coordinate(*axis) <= *at),
            Shape::Above { axis, at } => indicator(coordinate(*axis) >= *at),
            Shape::Cosine { modes } => (0..point.len().min(modes.len()))
                .map(|a| (std::f64::consts::PI * f64::from(modes[a]) * (point[a] - origin[a]) / extent[a]).cos())
                .product(),
        }
    }

    /// How far a point is from the surface \[m\], negative inside; `None` for a shape without one.
    pub fn distance(&self, point: &[f64]) -> Option<f64> {
        let coordinate = |axis: Axis| point.get(axis.index()).copied().unwrap_or(0.0);
        match self {
            Shape::Box { low, high } => {
                let beyond = |(x, (low, high)): (&f64, (&f64, &f64))| (low - x).max(x - high);
                let sides = || point.iter().zip(low.iter().zip(high.iter())).map(beyond);
                let outside = sides().map(|side| side.max(0.0).powi(2)).sum::<f64>().sqrt();
                Some(outside + sides().fold(f64::NEG_INFINITY, f64::max).min(0.0))
            }
            Shape::Ball { center, radius } => {
                let squared: f64 = point.iter().zip(center.iter()).map(|(x, c)| (x - c).powi(2)).sum();
                Some(squared.sqrt() - radius)
            }
            Shape::Below { axis, at } => Some(coordinate(*axis) - at),
            Shape::Above { axis, at } => Some(at - coordinate(*axis)),
            Shape::Everywhere | Shape::Gaussian { .. } | Shape::Cosine { .. } => None,
        }
    }

    /// The smallest box around the shape, or around three widths of a Gaussian, as (low, high) along an axis \[m\];
    /// unbounded ends are infinite.
    pub fn bounds(&self, axis: usize) -> (f64, f64) {
        let around = |center: &Axes<f64>, reach: f64| {
            let middle = center.get(axis).copied().unwrap_or(0.0);
            (middle - reach, middle + reach)
        };
        let everything = (f64::NEG_INFINITY, f64::INFINITY);
        match self {
            Shape::Everywhere | Shape::Cosine { .. } => everything,
            Shape::Box { low, high } => {
                (low.get(axis).copied().unwrap_or(everything.0), high.get(axis).copied().unwrap_or(everything.1))
            }
            Shape::Ball { center, radius } => around(center, *radius),
            Shape::Gaussian { center, width } => around(center, 3.0 * width),
            Shape::Below { axis: own, at } if own.index() == axis => (everything.0, *at),
            Shape::Above { axis: own, at } if own.index() == axis => (*at, everything.1),
            Shape::Below { .. } | Shape::Above { .. } => everything,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_negative_where_the_shape_is() {
        let axes = |v: [f64; 3]| v.into_iter().collect::<Axes<f64>>();
        let block = Shape::Box { low: axes([1.0, 1.0, 1.0]), high: axes([2.0, 3.0, 2.0]) };
        assert_eq!(block.distance(&[1.5, 2.0, 1.25]), Some(-0.25));
        assert_eq!(block.distance(&[5.0, 7.0, 1.5]), Some(5.0));
        let ball = Shape::Ball { center: axes([0.0; 3]), radius: 2.0 };
        assert_eq!([ball.distance(&[0.0, 1.0, 0.0]), ball.distance(&[3.0, 0.0, 4.0])], [Some(-1.0), Some(3.0)]);
        let ground = Shape::Below { axis: Axis::Y, at: 0.5 };
        let roof = Shape::Above { axis: Axis::Y, at: 0.5 };
        assert_eq!([ground.distance(&[0.0, 1.0, 0.0]), roof.distance(&[0.0, 1.0, 0.0])], [Some(0.5), Some(-0.5)]);
        assert_eq!(Shape::Everywhere.distance(&[0.0; 3]), None);
    }
}
