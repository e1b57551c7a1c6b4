//! A pinhole camera that looks at the middle of what it is to show, as near as that fits the picture.

use super::Look;

pub(super) type V3 = [f64; 3];

pub(super) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn along(p: V3, t: f64, d: V3) -> V3 {
    std::array::from_fn(|a| p[a] + t * d[a])
}

pub(super) fn unit(v: V3) -> V3 {
    let size = dot(v, v).sqrt().max(f64::MIN_POSITIVE);
    v.map(|x| x / size)
}

fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Half diagonals of the box between its middle and the eye: far enough for little distortion.
const DISTANCE: f64 = 4.5;
/// Share of the picture that the box leaves free on every side.
const MARGIN: f64 = 0.05;

pub(super) struct Camera {
    corners: [V3; 2],
    up: usize,
    pub eye: V3,
    right: V3,
    upward: V3,
    forward: V3,
    /// Pixels per unit of slope, and the pixel in the direction of view.
    scale: f64,
    middle: [f64; 2],
    /// Width over height of what is shown.
    pub aspect: f64,
}

impl Camera {
    /// `area` is the part of the picture that the box, or the part of it that the look names, may fill.
    pub fn new(corners: [V3; 2], look: &Look, area: [f64; 4]) -> Self {
        let shown = look.frame.unwrap_or(corners);
        let centre: V3 = std::array::from_fn(|a| 0.5 * (shown[0][a] + shown[1][a]));
        let half: V3 = std::array::from_fn(|a| 0.5 * (corners[1][a] - corners[0][a]));
        let mut camera = Self {
            corners,
            up: look.up,
            eye: centre,
            right: [0.0; 3],
            upward: [0.0; 3],
            forward: [0.0; 3],
            scale: 1.0,
            middle: [0.0; 2],
            aspect: 1.0,
        };
        let towards = camera.direction(look.eye);
        camera.eye = along(centre, DISTANCE * dot(half, half).sqrt(), towards);
        camera.forward = towards.map(|v| -v);
        // Straight from above the picture keeps the axis that comes first to the right.
        let mut pole = [0.0; 3];
        pole[look.up] = 1.0;
        let mut right = cross(camera.forward, pole);
        if dot(right, right) < 1e-12 {
            right = [0.0; 3];
            right[(look.up + 2) % 3] = 1.0;
        }
        camera.right = unit(right);
        camera.upward = cross(camera.right, camera.forward);
        let seen = corners_of(shown).map(|corner| camera.slope(corner));
        let low: [f64; 2] = std::array::from_fn(|a| seen.iter().map(|s| s[a]).fold(f64::INFINITY, f64::min));
        let high: [f64; 2] = std::array::from_fn(|a| seen.iter().map(|s| s[a]).fold(f64::NEG_INFINITY, f64::max));
        camera.aspect = (high[0] - low[0]).max(1e-9) / (high[1] - low[1]).max(1e-9);
        let size = [area[2] - area[0], area[3] - area[1]];
        camera.scale = [0, 1]
            .map(|a| (1.0 - 2.0 * MARGIN) * size[a] / (high[a] - low[a]).max(1e-9))
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let place = [0.5 * (area[0] + area[2]), 0.5 * (area[1] + area[3])];
        camera.middle =
            [place[0] - camera.scale * 0.5 * (low[0] + high[0]), place[1] + camera.scale * 0.5 * (low[1] + high[1])];
        camera
    }

    /// The direction from the box to a place around and above it, in degrees: 0 and 0 is along the axis after `up`.
    pub fn direction(&self, [around, above]: [f64; 2]) -> V3 {
        let ((sin, cos), (rise, level)) =
            (around.to_radians().sin_cos(), above.clamp(-90.0, 90.0).to_radians().sin_cos());
        let mut v = [0.0; 3];
        v[self.up] = rise;
        v[(self.up + 1) % 3] = level * cos;
        v[(self.up + 2) % 3] = level * sin;
        v
    }

    /// Slopes to the right and upwards under which a point is seen.
    fn slope(&self, p: V3) -> [f64; 2] {
        let from = along(p, -1.0, self.eye);
        let depth = dot(from, self.forward).max(f64::MIN_POSITIVE);
        [dot(from, self.right) / depth, dot(from, self.upward) / depth]
    }

    fn pixel(&self, p: V3) -> [f64; 2] {
        let [right, up] = self.slope(p);
        [self.middle[0] + self.scale * right, self.middle[1] - self.scale * up]
    }

    /// The direction of the ray through a point of the picture.
    pub fn ray(&self, [x, y]: [f64; 2]) -> V3 {
        let (right, up) = ((x - self.middle[0]) / self.scale, (self.middle[1] - y) / self.scale);
        unit(std::array::from_fn(|a| self.forward[a] + right * self.right[a] + up * self.upward[a]))
    }

    /// The edges of the box behind and before what is in it, in pixels.
    #[allow(clippy::type_complexity)]
    pub fn edges(&self) -> (Vec<[[f64; 2]; 2]>, Vec<[[f64; 2]; 2]>) {
        let (mut behind, mut before) = (Vec::new(), Vec::new());
        let corners = corners_of(self.corners);
        // A side is seen from inside where the eye is not beyond it.
        let hidden = |axis: usize, high: usize| {
            let side = self.corners[high][axis];
            if high == 1 { self.eye[axis] <= side } else { self.eye[axis] >= side }
        };
        for axis in 0..3 {
            for start in (0..8).filter(|c| c >> axis & 1 == 0) {
                let edge = [self.pixel(corners[start]), self.pixel(corners[start | 1 << axis])];
                let sides = (0..3).filter(|&other| other != axis);
                if sides.clone().all(|other| hidden(other, start >> other & 1)) {
                    behind.push(edge)
                } else {
                    before.push(edge)
                }
            }
        }
        (behind, before)
    }
}

fn corners_of([low, high]: [V3; 2]) -> [V3; 8] {
    std::array::from_fn(|c| std::array::from_fn(|a| if c >> a & 1 == 1 { high[a] } else { low[a] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_the_points_whose_pixels_they_leave_and_the_box_fits() {
        let corners = [[0.0, 1.0, -2.0], [4.0, 9.0, 2.0]];
        for up in 0..3 {
            for eye in [[0.0, 0.0], [30.0, 20.0], [-100.0, -40.0], [10.0, 90.0]] {
                let look = Look { eye, up, ..Look::default() };
                let camera = Camera::new(corners, &look, [0.0, 30.0, 400.0, 300.0]);
                for corner in corners_of(corners) {
                    let at = camera.pixel(corner);
                    assert!((0.0..=400.0).contains(&at[0]) && (30.0..=300.0).contains(&at[1]), "{at:?}");
                    let away = unit(along(corner, -1.0, camera.eye));
                    assert!(dot(camera.ray(at), away) > 1.0 - 1e-12);
                }
                let (behind, before) = camera.edges();
                assert_eq!(behind.len() + before.len(), 12);
                assert!(behind.len() >= 3);
                // A part of the box fills what the box filled.
                let part = [[1.0, 2.0, -1.0], [2.0, 3.0, 0.0]];
                let near = Camera::new(corners, &Look { frame: Some(part), ..look }, [0.0, 30.0, 400.0, 300.0]);
                assert!(near.scale > 1.5 * camera.scale);
                let at = corners_of(part).map(|corner| near.pixel(corner));
                let size = |a: usize| {
                    let of = |f: fn(f64, f64) -> f64, start| at.iter().map(|p| p[a]).fold(start, f);
                    of(f64::max, 0.0) - of(f64::min, f64::INFINITY)
                };
                assert!(at.iter().all(|p| (0.0..=400.0).contains(&p[0]) && (30.0..=300.0).contains(&p[1])));
                assert!(size(0) > 0.85 * 400.0 || size(1) > 0.85 * 270.0);
            }
        }
    }
}
