//! Which layer of a scene its pictures show, and the lines that belong over it.

use crate::scene::{Model, Scene};
use crate::solid::Solid;
use crate::spec::Medium;
use cf_diffusion::{half_angle, hc};
use cf_output::{Overlay, Slice};

/// The share of a cone's edge that is left out, so that the wake itself can be seen beside the line that continues it.
const HIDDEN: f64 = 0.55;

/// A layer of cells seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    pub slice: Slice,
    /// The axes to the right and upwards.
    pub axes: [usize; 2],
    pub cells: [usize; 2],
    pub origin: [f64; 2],
    pub spacing: f64,
}

impl View {
    /// The plane itself, or in 3D the layer through the first source along the flow. `None` on a line.
    pub fn of(scene: &Scene) -> Option<View> {
        let grid = &scene.grid;
        if grid.is_line() {
            return None;
        }
        let slice = match grid.dimension() {
            2 => Slice { axis: 2, index: 0 },
            3 => {
                // Across the axis along which the medium moves least, the last of equals.
                let u = velocity(scene).or_else(|| driven(scene)).unwrap_or_default();
                let speed = |axis: usize| u.get(axis).copied().unwrap_or(0.0).abs();
                let axis = (0..3).fold(2, |best, axis| if speed(axis) < speed(best) { axis } else { best });
                let middle = source_centre(scene).map_or(grid.origin[axis] + 0.5 * grid.extent[axis], |c| c[axis]);
                let index = ((middle - grid.origin[axis]) / grid.spacing).max(0.0) as usize;
                Slice { axis, index: index.min(grid.cells[axis] - 1) }
            }
            _ => return None,
        };
        let axes = [[1, 2], [0, 2], [0, 1]][slice.axis];
        let [cells, origin] = [axes.map(|a| grid.cells[a] as f64), axes.map(|a| grid.origin[a])];
        Some(View { slice, axes, cells: cells.map(|n| n as usize), origin, spacing: grid.spacing })
    }

    /// Which cells of the layer are solid; `None` where the scene has no obstacles.
    pub fn solid(&self, scene: &Scene) -> Option<Vec<bool>> {
        let solid = Solid::of(scene);
        if solid.is_empty() {
            return None;
        }
        let [right, up] = self.axes;
        let across = if scene.grid.dimension() == 3 { solid.centre(self.slice.axis, self.slice.index) } else { 0.0 };
        let mut centre = [across; 3];
        let mut cells = Vec::with_capacity(self.cells[0] * self.cells[1]);
        for j in 0..self.cells[1] {
            centre[up] = solid.centre(up, j);
            for i in 0..self.cells[0] {
                centre[right] = solid.centre(right, i);
                cells.push(solid.holds(&centre[..scene.grid.dimension()]));
            }
        }
        Some(cells)
    }

    /// The edges of the cone behind the first source, where F_T = 0 and the flow is faster than the waves and in the layer.
    pub fn cone(&self, scene: &Scene) -> Vec<Overlay> {
        let lines = || {
            // Where a part of the flux has no memory nothing is strictly confined.
            let Model::Diffusion(model) = &scene.model else { return None };
            if model.law.fourier > 0.0 {
                return None;
            }
            let (u, tip) = (velocity(scene)?, source_centre(scene)?);
            let speed = u.iter().map(|v| v * v).sum::<f64>().sqrt();
            let law = cf_diffusion::Law::new(model.law.k, model.law.tau, model.law.fourier).ok()?;
            let ratio = hc(&law, speed).filter(|ratio| *ratio > 1.0 + 1e-6 && ratio.is_finite())?;
            let flow = self.axes.map(|axis| u[axis] / speed);
            if flow[0].hypot(flow[1]) < 1.0 - 1e-9 {
                return None;
            }
            let tip = self.axes.map(|axis| tip[axis]);
            let angle = half_angle(ratio);
            let label = format!("asin(1/H_c) = {:.1}°", angle.to_degrees());
            let edge = |angle: f64| {
                let (sin, cos) = angle.sin_cos();
                let towards = [cos * flow[0] - sin * flow[1], sin * flow[0] + cos * flow[1]];
                let out = self.way_out(tip, towards);
                let at = |share: f64| [0, 1].map(|a| tip[a] + share * out * towards[a]);
                Overlay::straight(at(HIDDEN), at(1.0), label.clone())
            };
            Some(vec![edge(angle), edge(-angle)])
        };
        lines().unwrap_or_default()
    }

    /// How far it is from a point to the edge.
    fn way_out(&self, from: [f64; 2], towards: [f64; 2]) -> f64 {
        let along = |a: usize| {
            let end = self.origin[a] + if towards[a] > 0.0 { self.spacing * self.cells[a] as f64 } else { 0.0 };
            if towards[a] == 0.0 { f64::INFINITY } else { (end - from[a]) / towards[a] }
        };
        along(0).min(along(1)).max(0.0)
    }
}

fn velocity(scene: &Scene) -> Option<Vec<f64>> {
    match &scene.model {
        Model::Diffusion(model) => match &model.medium {
            Medium::Uniform(u) => Some(u.to_vec()),
            _ => None,
        },
        Model::SingleField(_) => None,
    }
}

/// Where a solved fluid is driven to: along its first jet, its inflow or start, or upwards.
fn driven(scene: &Scene) -> Option<Vec<f64>> {
    let fluid = scene.fluid()?;
    let jet = fluid.jets.first().map(|jet| jet.velocity.to_vec());
    let start = || fluid.velocity.iter().any(|v| *v != 0.0).then(|| fluid.velocity.to_vec());
    jet.or_else(start).or_else(|| Some(fluid.buoyancy.as_ref()?.up.to_vec()))
}

fn source_centre(scene: &Scene) -> Option<Vec<f64>> {
    let Model::Diffusion(model) = &scene.model else { return None };
    let shape = &model.sources.first()?.shape;
    let middle = |axis: usize| {
        let (low, high) = shape.bounds(axis);
        (low.is_finite() && high.is_finite()).then_some(0.5 * (low + high))
    };
    (0..scene.grid.dimension()).map(middle).collect()
}
