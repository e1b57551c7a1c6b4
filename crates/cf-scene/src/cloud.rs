//! Pictures of `phi` in space, as a cloud of ink, smoke or fire.

use crate::model::Model;
use crate::pictures::clock;
use crate::scene::Scene;
use crate::solid::Solid;
use crate::spec::{Axis, Cloud, Field, VolumeSpec};
use cf_output::{Canvas, Look, Material, OutputError, Volume, render};

/// Width and height of a picture.
pub(crate) const SIZE: [usize; 2] = [480, 720];

/// The cloud as it is; `None` where the scene asks for none.
pub(crate) fn cloud(scene: &Scene, model: &dyn Model, time: f64) -> Result<Option<Canvas>, OutputError> {
    let Some(spec) = &scene.output.volume else { return Ok(None) };
    let Some(array) = model.arrays(&[Field::Phi])?.pop() else { return Ok(None) };
    let grid = &scene.grid;
    let origin = std::array::from_fn(|axis| grid.origin.get(axis).copied().unwrap_or(0.0));
    let mut volume = Volume::new(&array, origin, [grid.spacing; 3], [spec.low, spec.high])?;
    let solid = Solid::of(scene);
    if !solid.is_empty() {
        volume.set_solid(|cell| {
            let centre: [f64; 3] = std::array::from_fn(|axis| solid.centre(axis, cell[axis]));
            solid.holds(&centre)
        });
    }
    let look = Look { title: scene.label.clone(), time: clock(scene, time), ..look(spec) };
    render(&volume, &look).map(Some)
}

fn look(spec: &VolumeSpec) -> Look {
    let base = match spec.look {
        Cloud::Ink => Look::ink(),
        Cloud::Smoke => Look::default(),
        Cloud::Fire => Look { material: Material::FIRE, ..Look::default() },
    };
    let eye = spec.eye.map_or(base.eye, |(around, above)| [around, above]);
    Look { size: SIZE, up: spec.up.map_or(1, Axis::index), eye, ..base }
}

/// The colours of a picture as numbers of a spool.
pub(crate) fn pack(canvas: &Canvas) -> Vec<f64> {
    let whole = |p: &[u8]| p.iter().fold(0.0, |sum, byte| 256.0 * sum + f64::from(*byte));
    canvas.pixels().chunks_exact(3).map(whole).collect()
}

/// The picture of such numbers.
pub(crate) fn unpack(numbers: &[f64]) -> Canvas {
    let mut canvas = Canvas::new(SIZE[0], SIZE[1], [0; 3]);
    for (i, number) in numbers.iter().enumerate() {
        let [_, red, green, blue] = (*number as u32).to_be_bytes();
        canvas.set(i % SIZE[0], i / SIZE[0], [red, green, blue]);
    }
    canvas
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_the_spool() {
        let mut canvas = Canvas::new(SIZE[0], SIZE[1], [255, 254, 1]);
        canvas.set(7, 11, [1, 0, 200]);
        let numbers: Vec<f64> = pack(&canvas).into_iter().map(|v| f64::from(v as f32)).collect();
        assert_eq!(unpack(&numbers), canvas);
    }
}
