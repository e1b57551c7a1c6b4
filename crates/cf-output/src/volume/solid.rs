//! Solids in a volume: where their surface is, as a distance.

use std::fmt;
use std::sync::Arc;

use super::camera::V3;
use super::field::trilinear;

/// A distance to a surface, negative inside.
#[derive(Clone)]
pub(super) struct Solid(Arc<dyn Fn(V3) -> f64 + Send + Sync>);

impl Solid {
    pub fn new(distance: impl Fn(V3) -> f64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(distance))
    }

    pub fn distance(&self, p: V3) -> f64 {
        (self.0)(p)
    }

    /// The direction away from the solid, from differences over `reach` on either side.
    pub fn outward(&self, p: V3, reach: f64) -> V3 {
        std::array::from_fn(|a| {
            let mut beside = [p, p];
            beside[0][a] -= reach;
            beside[1][a] += reach;
            self.distance(beside[1]) - self.distance(beside[0])
        })
    }
}

impl fmt::Debug for Solid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Solid")
    }
}

/// About the distance to the surface of the solid cells of a mask, negative inside, for
/// [`Volume::set_solid`](super::Volume::set_solid): the share of solid cells around a point, smoothed so that stairs of
/// cells become slopes. Right near the surface, and never too far from it by much.
pub fn smooth_mask(
    cells: [usize; 3],
    origin: [f64; 3],
    spacing: [f64; 3],
    solid: &dyn Fn([usize; 3]) -> bool,
) -> impl Fn([f64; 3]) -> f64 + Send + Sync + use<> {
    let cells = cells.map(|n| n.max(1));
    let at = |i: usize| [i % cells[0], i / cells[0] % cells[1], i / (cells[0] * cells[1])];
    let mut share: Vec<f32> = (0..cells.iter().product()).map(|i| if solid(at(i)) { 1.0 } else { 0.0 }).collect();
    for _ in 0..2 {
        for axis in 0..3 {
            let stride: usize = cells[..axis].iter().product();
            let old = share.clone();
            for (i, share) in share.iter_mut().enumerate() {
                let place = at(i)[axis];
                let low = old[if place > 0 { i - stride } else { i }];
                let high = old[if place + 1 < cells[axis] { i + stride } else { i }];
                *share = 0.25 * (low + high) + 0.5 * old[i];
            }
        }
    }
    // Across a flat wall the share falls by 3/8 from the cell on one side to that on the other.
    let slope = spacing.into_iter().fold(f64::INFINITY, f64::min) / 0.375;
    move |p| {
        let place = std::array::from_fn(|a| (p[a] - origin[a]) / spacing[a]);
        slope * (0.5 - f64::from(trilinear(&share, cells, place)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::camera::{dot, unit};

    #[test]
    fn a_ball_of_cells_has_a_smooth_surface() {
        let n = 24;
        let within = |c: [usize; 3]| c.iter().map(|i| (*i as f64 + 0.5 - 12.0).powi(2)).sum::<f64>() <= 64.0;
        let distance = smooth_mask([n; 3], [0.0; 3], [1.0; 3], &within);
        assert!(distance([12.0; 3]) < 0.0 && distance([1.0; 3]) > 0.0);
        let solid = Solid::new(distance);
        for i in 0..40 {
            let (sin, cos) = (0.4 * f64::from(i)).sin_cos();
            let level = (1.0 - (0.048 * f64::from(i) - 0.95).powi(2)).sqrt();
            let towards = [level * cos, 0.048 * f64::from(i) - 0.95, level * sin];
            let (mut low, mut high) = (4.0, 11.0);
            for _ in 0..30 {
                let middle = 0.5 * (low + high);
                let p = towards.map(|t| 12.0 + middle * t);
                if solid.distance(p) < 0.0 { low = middle } else { high = middle }
            }
            assert!((low - 8.0).abs() < 0.5, "{low} at {towards:?}");
            let normal = unit(solid.outward(towards.map(|t| 12.0 + low * t), 0.75));
            assert!(dot(normal, towards) > 0.95, "{normal:?} at {towards:?}");
        }
    }
}
