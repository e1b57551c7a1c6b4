//! Pictures of `phi` in space, as a cloud of ink, smoke or fire. Volumes are kept on disk until all runs are done, so that all
//! pictures have one camera, on the part of the box where there ever is something to see.

use crate::error::number;
use crate::model::Model;
use crate::pictures::{Last, alike, clock, round_up};
use crate::scene::Scene;
use crate::solid::Solid;
use crate::spec::{Axis, Cloud, Field, VolumeSpec};
use crate::spool::Spool;
use cf_output::{Canvas, Look, Material, OutputError, Theme, Volume, contact_sheet, render, write_animation};
use std::path::Path;
use std::sync::Arc;

/// Height of a picture.
const HEIGHT: usize = 720;
/// Pictures per second of an animation.
const RATE: f64 = 8.0;
/// Of the top of the range, what still can be seen.
const SEEN: f64 = 0.05;
/// Optical depth at which half of an automatic cloud is seen.
const DEPTH: f64 = 2.0;
/// Around what is seen, and the least size of what is shown, as parts of the box's longest edge.
const MARGIN: f64 = 0.03;
const LEAST: f64 = 0.25;

/// What was drawn.
#[derive(Default)]
pub(crate) struct Drawn {
    /// Files of each run.
    pub runs: Vec<Vec<String>>,
    /// Files that show all runs.
    pub all: Vec<String>,
}

/// Where a run keeps its volumes, of which the first `keep` stay.
pub(crate) fn spool(scene: &Scene, folder: &Path, keep: usize) -> Result<Spool, OutputError> {
    let voxels = Volume::voxels(cells(scene)).iter().product();
    Spool::open(folder.join(format!(".{}.clouds", scene.run)), voxels, keep)
}

/// The voxels of `phi` as it is.
pub(crate) fn voxels(scene: &Scene, model: &dyn Model) -> Result<Vec<f64>, OutputError> {
    let Some(array) = model.arrays(&[Field::Phi])?.pop() else { return Ok(Vec::new()) };
    let volume = Volume::new(&array, origin(scene), [scene.grid.spacing; 3])?;
    Ok(volume.values().iter().copied().map(f64::from).collect())
}

fn cells(scene: &Scene) -> [usize; 3] {
    std::array::from_fn(|axis| scene.grid.cells.get(axis).copied().unwrap_or(1))
}

fn origin(scene: &Scene) -> [f64; 3] {
    std::array::from_fn(|axis| scene.grid.origin.get(axis).copied().unwrap_or(0.0))
}

type Distance = Arc<dyn Fn([f64; 3]) -> f64 + Send + Sync>;

/// The volumes of one run, and how they are to be shown.
struct Reel<'a> {
    scene: &'a Scene,
    spec: &'a VolumeSpec,
    frames: &'a [(u32, f64)],
    spool: Spool,
    solid: Option<Distance>,
    range: [f64; 2],
    /// Whether something is below zero that would show above it.
    below: bool,
    /// The part of the box where something is seen at some time.
    seen: Option<[[f64; 3]; 2]>,
}

impl<'a> Reel<'a> {
    /// `None` where the scene asks for no cloud, or not all volumes are there.
    fn open(folder: &Path, last: &'a Last<'_>) -> Result<Option<Self>, OutputError> {
        let (scene, frames) = (last.scene, &last.frames[..]);
        let Some(spec) = &scene.output.volume else { return Ok(None) };
        let spool = spool(scene, folder, frames.len())?;
        let complete = spool.records() == frames.len() && !frames.is_empty();
        let solid = Solid::of(scene);
        let solid = (!solid.is_empty()).then(|| Arc::new(solid.distance(Volume::voxels(cells(scene)))) as Distance);
        let mut reel =
            Reel { scene, spec, frames, spool, solid, range: [spec.low, spec.low + 1.0], below: false, seen: None };
        if !complete {
            reel.spool.remove()?;
            return Ok(None);
        }
        reel.range[1] = spec.high.map_or_else(|| reel.automatic(), Ok)?;
        let least = reel.range[0] + SEEN * (reel.range[1] - reel.range[0]);
        for n in 0..frames.len() {
            let volume = reel.volume(n)?;
            reel.below |= volume.values().iter().any(|value| f64::from(*value) < -least);
            reel.seen = union(reel.seen, volume.extent_above(least));
        }
        Ok(Some(reel))
    }

    fn volume(&mut self, n: usize) -> Result<Volume, OutputError> {
        let values = self.spool.get(n)?.into_iter().map(|value| value as f32).collect();
        let mut volume =
            Volume::from_voxels(cells(self.scene), origin(self.scene), [self.scene.grid.spacing; 3], values)?;
        if let Some(solid) = self.solid.clone() {
            volume.set_solid(move |p| solid(p));
        }
        Ok(volume)
    }

    /// The top of the range at which the thickest frame has the depth that shows it well.
    fn automatic(&mut self) -> Result<f64, OutputError> {
        let look = self.look([0.0, 1.0]);
        let ([around, above], up) = (look.eye, look.up);
        let (sin, cos) = around.to_radians().sin_cos();
        let axis = match () {
            () if above.abs() > 60.0 => up,
            () if cos.abs() >= sin.abs() => (up + 1) % 3,
            () => (up + 2) % 3,
        };
        let mut most = 0.0f64;
        for n in 0..self.frames.len() {
            most = most.max(self.volume(n)?.column(axis, self.spec.low));
        }
        let extinction = look.material.extinction.iter().sum::<f64>() / 3.0;
        let size = extinction * most / DEPTH;
        Ok(self.spec.low + if size > 0.0 && size.is_finite() { round_up(size) } else { 1.0 })
    }

    fn look(&self, range: [f64; 2]) -> Look {
        let base = match self.spec.look {
            Cloud::Ink => Look::ink(),
            Cloud::Smoke => Look::default(),
            Cloud::Fire => Look { material: Material::FIRE, ..Look::default() },
        };
        let eye = self.spec.eye.map_or(base.eye, |(around, above)| [around, above]);
        Look { up: self.spec.up.map_or(1, Axis::index), eye, range, ..base }
    }

    fn draw(&mut self, n: usize, frame: Option<[[f64; 3]; 2]>) -> Result<Canvas, OutputError> {
        let volume = self.volume(n)?;
        let below = if self.below { "; what is below 0 is clear" } else { "" };
        let look = Look {
            frame,
            title: self.scene.label.clone(),
            time: clock(self.scene, self.frames[n].1),
            note: format!("densest at φ = {} P{below}", number(rounded(self.range[1]))),
            ..self.look(self.range)
        };
        render(&volume, &look.fitted(&volume, HEIGHT))
    }
}

/// Draws the clouds of all runs at every frame, an animation of each, one of all side by side, and a sheet of their ends.
pub(crate) fn draw(name: &str, folder: &Path, lasts: &[Last<'_>]) -> Result<Drawn, OutputError> {
    let mut drawn = Drawn { runs: vec![Vec::new(); lasts.len()], all: Vec::new() };
    let mut reels = Vec::new();
    for last in lasts {
        reels.push(Reel::open(folder, last)?);
    }
    let frames: Vec<_> = reels.iter().map(|reel| Some(frame(reel.as_ref()?, &reels))).collect();
    for ((reel, frame), files) in reels.iter_mut().zip(frames).zip(&mut drawn.runs) {
        let (Some(reel), Some(frame)) = (reel, frame) else { continue };
        let animation = format!("{}_cloud_animation.png", reel.scene.run);
        write_animation(&folder.join(&animation), reel.frames.len() as u32, RATE, Theme::Light, |n| {
            let picture = reel.draw(n as usize, frame)?;
            let name = picture_name(reel, n as usize);
            picture.write_png(&folder.join(&name))?;
            files.push(name);
            Ok(picture)
        })?;
        files.push(animation);
    }
    let reels: Vec<Reel<'_>> = reels.into_iter().flatten().collect();
    if reels.len() > 1 {
        let last = reels.iter().map(|reel| reel.frames.len()).max().unwrap_or(1) - 1;
        let sheet = format!("{name}_clouds.png");
        side_by_side(folder, &reels, last)?.write_png(&folder.join(&sheet))?;
        let animation = format!("{name}_clouds_animation.png");
        write_animation(&folder.join(&animation), last as u32 + 1, RATE, Theme::Light, |n| {
            Ok(side_by_side(folder, &reels, n as usize)?.halved())
        })?;
        drawn.all = vec![sheet, animation];
    }
    for reel in reels {
        reel.spool.remove()?;
    }
    Ok(drawn)
}

fn picture_name(reel: &Reel<'_>, n: usize) -> String {
    format!("{}_cloud_{:04}.png", reel.scene.run, reel.frames[n].0)
}

/// A frame of all runs, as their files have it; runs that ended stay as they are.
fn side_by_side(folder: &Path, reels: &[Reel<'_>], n: usize) -> Result<Canvas, OutputError> {
    let one = |reel: &Reel<'_>| {
        let name = picture_name(reel, n.min(reel.frames.len() - 1));
        // Each has its run's label in it.
        Ok((Canvas::read_png(&folder.join(name))?, String::new()))
    };
    let pictures: Vec<(Canvas, String)> = reels.iter().map(one).collect::<Result<_, OutputError>>()?;
    let columns = if pictures.len() <= 6 { pictures.len() } else { pictures.len().div_ceil(2) };
    Ok(contact_sheet(&pictures, columns, None, Theme::Light))
}

/// What the pictures of a run show of its box: what is seen in any run of the same box.
fn frame(reel: &Reel<'_>, reels: &[Option<Reel<'_>>]) -> Option<[[f64; 3]; 2]> {
    if reel.spec.whole {
        return None;
    }
    let alike = |other: &&Reel<'_>| {
        alike(&other.scene.grid, &reel.scene.grid) && other.scene.grid.origin == reel.scene.grid.origin
    };
    let seen = reels.iter().flatten().filter(alike).fold(None, |seen, other| union(seen, other.seen))?;
    let grid = &reel.scene.grid;
    let longest = grid.extent.iter().copied().fold(0.0, f64::max);
    let side = |axis: usize| {
        let (start, end) = (grid.origin[axis], grid.origin[axis] + grid.extent[axis]);
        let middle = 0.5 * (seen[0][axis] + seen[1][axis]);
        let half = (0.5 * (seen[1][axis] - seen[0][axis]) + MARGIN * longest).max(0.5 * LEAST * longest);
        [(middle - half).max(start), (middle + half).min(end)]
    };
    let sides = [side(0), side(1), side(2)];
    Some([sides.map(|side| side[0]), sides.map(|side| side[1])])
}

/// To three digits, for people.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// The box around both.
fn union(a: Option<[[f64; 3]; 2]>, b: Option<[[f64; 3]; 2]>) -> Option<[[f64; 3]; 2]> {
    let (Some(a), Some(b)) = (a, b) else { return a.or(b) };
    Some([
        std::array::from_fn(|axis| a[0][axis].min(b[0][axis])),
        std::array::from_fn(|axis| a[1][axis].max(b[1][axis])),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        assert_eq!([2.4000000000000004, 0.2, 1234.0].map(|v| number(rounded(v))), ["2.4", "0.2", "1230"]);
    }

    #[test]
    fn a_union_holds_both() {
        let (a, b) = ([[0.0; 3], [1.0; 3]], [[-1.0, 0.5, 0.5], [0.5, 0.5, 2.0]]);
        assert_eq!(union(Some(a), Some(b)), Some([[-1.0, 0.0, 0.0], [1.0, 1.0, 2.0]]));
        assert_eq!((union(None, Some(b)), union(Some(a), None), union(None, None)), (Some(b), Some(a), None));
    }
}
