//! Rays, front to back, one row of the picture per task.

use rayon::prelude::*;

use super::camera::{Camera, V3, along, dot, unit};
use super::field::Voxels;
use super::solid::Solid;
use super::{Look, decode, encode};
use crate::canvas::Canvas;

/// Length of a step in voxels.
const STEP: f64 = 0.75;
/// What is left of the background when a ray ends.
const DARK: f64 = 1.0 / 512.0;
/// Steps in which the place where a ray meets a solid is found.
const HALVINGS: usize = 12;
/// Light on solids: from everywhere, and from the lamp, plain and as a highlight.
const SKY: f64 = 0.34;
const LAMP: f64 = 0.78;
const GLOSS: f64 = 0.10;

/// Draws the volume over what the canvas shows.
pub(super) fn through(canvas: &mut Canvas, voxels: &Voxels<'_>, camera: &Camera, look: &Look) {
    let (light, material) = (camera.direction(look.light), &look.material);
    let depths = (material.shadow > 0.0).then(|| {
        let whole = voxels.depth_towards(light, false);
        (voxels.volume.solid.is_some().then(|| voxels.depth_towards(light, true)), whole)
    });
    let weight = material.shadow / voxels.volume.longest();
    let shadow = |p: V3| depths.as_ref().map_or(0.0, |(_, whole)| weight * f64::from(whole.at(p)));
    let bare =
        |p: V3| depths.as_ref().map_or(0.0, |(bare, whole)| weight * f64::from(bare.as_ref().unwrap_or(whole).at(p)));
    let mut up = [0.0; 3];
    up[look.up] = 1.0;
    let scene = Scene { voxels, light: unit(light), up, look, shadow: &shadow, bare: &bare };
    let (width, height) = (canvas.width(), canvas.height());
    let below: &Canvas = canvas;
    let shade = |x: usize, y: usize, [dx, dy]: [f64; 2]| {
        let met = scene.along(camera.eye, camera.ray([x as f64 + dx, y as f64 + dy]), offset(x, y));
        let behind = below.get(x, y).unwrap_or_default();
        met.map(|met| (std::array::from_fn(|c| met.color[c] + met.left[c] * decode(behind[c])), met.stone))
    };
    let rows: Vec<Vec<Option<(V3, bool)>>> =
        (0..height).into_par_iter().map(|y| (0..width).map(|x| shade(x, y, [0.5; 2])).collect()).collect();
    let stone = |x: usize, y: usize| rows.get(y).and_then(|row| row.get(x)).is_some_and(|p| p.is_some_and(|p| p.1));
    let edge = |x: usize, y: usize| {
        let sides = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        sides.into_iter().any(|(i, j)| i < width && j < height && stone(i, j) != stone(x, y))
    };
    let smooth = |x: usize, y: usize| {
        let behind = below.get(x, y).unwrap_or_default().map(decode);
        let rays = SPREAD.map(|spread| shade(x, y, spread).map_or(behind, |shaded| shaded.0));
        std::array::from_fn(|c| rays.iter().map(|ray| ray[c]).sum::<f64>() / rays.len() as f64)
    };
    let rows: Vec<Vec<Option<V3>>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let pixel = |x: usize| if edge(x, y) { Some(smooth(x, y)) } else { rows[y][x].map(|shaded| shaded.0) };
            (0..width).map(pixel).collect()
        })
        .collect();
    for (y, row) in rows.into_iter().enumerate() {
        row.into_iter().enumerate().for_each(|(x, color)| {
            if let Some(color) = color {
                canvas.set(x, y, color.map(encode));
            }
        });
    }
}

/// Where the rays of a pixel at the edge of a solid go through it.
const SPREAD: [[f64; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// Where in its first step a ray begins, 0 to 1: rays that begin alike would show the steps as bands.
fn offset(x: usize, y: usize) -> f64 {
    // Interleaved gradient noise (Jimenez 2014).
    (52.982_918_9 * (0.067_110_56 * x as f64 + 0.005_837_15 * y as f64).fract()).fract()
}

/// What a ray came to.
struct Met {
    /// The light it collected, and the share of the background that it lets through.
    color: V3,
    left: V3,
    /// Whether it ends at a solid.
    stone: bool,
}

struct Scene<'a, S, B> {
    voxels: &'a Voxels<'a>,
    light: V3,
    up: V3,
    look: &'a Look,
    /// Shadow of a point in voxels, in units of the extinction: of everything, and of the cloud alone.
    shadow: &'a S,
    bare: &'a B,
}

impl<S: Fn(V3) -> f64, B: Fn(V3) -> f64> Scene<'_, S, B> {
    /// `None` where the ray meets nothing.
    fn along(&self, eye: V3, ray: V3, offset: f64) -> Option<Met> {
        let [enter, leave] = span(self.voxels.volume.corners(), eye, ray)?;
        let step = STEP * self.voxels.step;
        let (start, slope) = (self.voxels.in_voxels(eye), self.voxels.per_voxel(ray));
        let (mut color, mut left, mut met) = ([0.0; 3], [1.0; 3], false);
        let mut number = 0u64;
        loop {
            let t = enter + (number as f64 + offset) * step;
            if t >= leave {
                break;
            }
            let p = along(start, t, slope);
            if let Some([low, high]) = self.voxels.empty_block(p) {
                let exit = (0..3).map(|a| {
                    let side = if slope[a] > 0.0 { high[a] } else { low[a] };
                    if slope[a] == 0.0 { f64::INFINITY } else { (side - start[a]) / slope[a] }
                });
                let exit = exit.fold(f64::INFINITY, f64::min);
                number = number.max(((exit - enter) / step - offset) as u64) + 1;
                continue;
            }
            number += 1;
            if let Some(solid) = self.voxels.solid_near(p)
                && solid.distance(along(eye, t, ray)) <= 0.0
            {
                let (mut out, mut inside) = ((t - step).max(enter), t);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (out + inside);
                    if solid.distance(along(eye, middle, ray)) <= 0.0 { inside = middle } else { out = middle }
                }
                let stone = self.stone(solid, along(eye, inside, ray), ray);
                (0..3).for_each(|c| color[c] += left[c] * stone[c]);
                return Some(Met { color, left: [0.0; 3], stone: true });
            }
            let v = f64::from(self.voxels.value(p));
            if v <= 0.0 {
                continue;
            }
            met = true;
            // The last step may be a short one.
            let length = step.min(leave - t + (1.0 - offset) * step) / self.voxels.volume.longest();
            self.cloud(p, v * length, &mut color, &mut left);
            if left.iter().all(|l| *l < DARK) {
                break;
            }
        }
        met.then_some(Met { color, left, stone: false })
    }

    fn cloud(&self, p: V3, amount: f64, color: &mut V3, left: &mut V3) {
        let m = &self.look.material;
        let shadow = (self.shadow)(p);
        for c in 0..3 {
            let through = (-m.extinction[c] * amount).exp();
            let lit = m.ambient + (1.0 - m.ambient) * (-m.extinction[c] * shadow).exp();
            color[c] += left[c] * (1.0 - through) * (m.albedo[c] * lit + m.glow[c]);
            left[c] *= through;
        }
    }

    /// The light of a solid's surface: the lamp, where no cloud is before it, and the sky.
    fn stone(&self, solid: &Solid, p: V3, ray: V3) -> V3 {
        let reach = self.voxels.smallest_voxel();
        let normal = unit(solid.outward(p, 0.5 * reach));
        let lamp = dot(normal, self.light).max(0.0);
        let shadow = (self.bare)(self.voxels.in_voxels(along(p, 2.0 * reach, normal)));
        let half = unit(std::array::from_fn(|a| self.light[a] - ray[a]));
        let gloss = if lamp > 0.0 { dot(normal, half).max(0.0).powi(24) } else { 0.0 };
        let sky = SKY * (0.6 + 0.4 * dot(normal, self.up));
        std::array::from_fn(|c| {
            let clear = (-self.look.material.extinction[c] * shadow).exp();
            self.look.solid[c] * (sky + LAMP * lamp * clear) + GLOSS * gloss * clear
        })
    }
}

/// Where a ray enters and leaves a box.
fn span([low, high]: [V3; 2], eye: V3, ray: V3) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for a in 0..3 {
        if ray[a] == 0.0 {
            if !(low[a]..=high[a]).contains(&eye[a]) {
                return None;
            }
            continue;
        }
        let ends = [(low[a] - eye[a]) / ray[a], (high[a] - eye[a]) / ray[a]];
        (enter, leave) = (enter.max(ends[0].min(ends[1])), leave.min(ends[0].max(ends[1])));
    }
    (leave > enter).then_some([enter, leave])
}
