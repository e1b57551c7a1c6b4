//! Rays, front to back, one row of the picture per task.

use rayon::prelude::*;

use super::camera::{Camera, V3, along, dot, unit};
use super::field::Volume;
use super::{Material, decode, encode};
use crate::canvas::Canvas;

/// Length of a step in voxels.
const STEP: f64 = 0.75;
/// What is left of the background when a ray ends.
const DARK: f64 = 1.0 / 512.0;
/// The colour of solids.
const STONE: [f64; 3] = [0.42, 0.4, 0.38];

/// Draws the volume over what the canvas shows.
pub(super) fn through(canvas: &mut Canvas, volume: &Volume, camera: &Camera, light: V3, material: &Material) {
    let depth = (material.shadow > 0.0).then(|| volume.depth_towards(light));
    let shadow = |p: V3| depth.as_ref().map_or(0.0, |d| material.shadow * f64::from(d.at(p)) / volume.longest());
    let scene = Scene { volume, light: unit(light), material, shadow: &shadow };
    let (width, height) = (canvas.width(), canvas.height());
    let below: &Canvas = canvas;
    let rows: Vec<Vec<Option<[u8; 3]>>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let pixel = |x: usize| {
                let ray = camera.ray([x as f64 + 0.5, y as f64 + 0.5]);
                let (mut color, left) = scene.along(camera.eye, ray, offset(x, y))?;
                let behind = below.get(x, y)?;
                (0..3).for_each(|c| color[c] += left[c] * decode(behind[c]));
                Some(color.map(encode))
            };
            (0..width).map(pixel).collect()
        })
        .collect();
    for (y, row) in rows.into_iter().enumerate() {
        row.into_iter().enumerate().for_each(|(x, color)| {
            if let Some(color) = color {
                canvas.set(x, y, color);
            }
        });
    }
}

/// Where in its first step a ray begins, 0 to 1: rays that begin alike would show the steps as bands.
fn offset(x: usize, y: usize) -> f64 {
    // Interleaved gradient noise (Jimenez 2014).
    (52.982_918_9 * (0.067_110_56 * x as f64 + 0.005_837_15 * y as f64).fract()).fract()
}

struct Scene<'a, S> {
    volume: &'a Volume,
    light: V3,
    material: &'a Material,
    /// Shadow of a point in voxels, in units of the extinction.
    shadow: &'a S,
}

impl<S: Fn(V3) -> f64> Scene<'_, S> {
    /// Light that a ray collects and the share of the background it lets through; `None` where it meets nothing.
    fn along(&self, eye: V3, ray: V3, offset: f64) -> Option<(V3, V3)> {
        let [enter, leave] = span(self.volume.corners(), eye, ray)?;
        let step = STEP * self.volume.smallest_voxel();
        let (start, slope) = (self.volume.in_voxels(eye), self.volume.per_voxel(ray));
        let (mut color, mut left, mut met) = ([0.0; 3], [1.0; 3], false);
        let mut number = 0u64;
        loop {
            let t = enter + (number as f64 + offset) * step;
            if t >= leave {
                break;
            }
            let p = along(start, t, slope);
            if let Some([low, high]) = self.volume.empty_block(p) {
                let exit = (0..3).map(|a| {
                    let side = if slope[a] > 0.0 { high[a] } else { low[a] };
                    if slope[a] == 0.0 { f64::INFINITY } else { (side - start[a]) / slope[a] }
                });
                let exit = exit.fold(f64::INFINITY, f64::min);
                number = number.max(((exit - enter) / step - offset) as u64) + 1;
                continue;
            }
            number += 1;
            if self.volume.solidity(p) > 0.5 {
                self.stone(p, &mut color, &mut left);
                return Some((color, left));
            }
            let v = f64::from(self.volume.value(p));
            if v <= 0.0 {
                continue;
            }
            met = true;
            // The last step may be a short one.
            let length = step.min(leave - t + (1.0 - offset) * step) / self.volume.longest();
            self.cloud(p, v * length, &mut color, &mut left);
            if left.iter().all(|l| *l < DARK) {
                break;
            }
        }
        met.then_some((color, left))
    }

    fn cloud(&self, p: V3, amount: f64, color: &mut V3, left: &mut V3) {
        let m = self.material;
        let shadow = (self.shadow)(p);
        for c in 0..3 {
            let through = (-m.extinction[c] * amount).exp();
            let lit = m.ambient + (1.0 - m.ambient) * (-m.extinction[c] * shadow).exp();
            color[c] += left[c] * (1.0 - through) * (m.albedo[c] * lit + m.glow[c]);
            left[c] *= through;
        }
    }

    fn stone(&self, p: V3, color: &mut V3, left: &mut V3) {
        let facing = dot(unit(self.volume.outward(p)), self.light).max(0.0);
        let shadow = (self.shadow)(along(p, 1.5, self.volume.outward(p)));
        for c in 0..3 {
            let lit = 0.35 + 0.65 * facing * (-self.material.extinction[c] * shadow).exp();
            color[c] += left[c] * STONE[c] * lit;
            left[c] = 0.0;
        }
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
