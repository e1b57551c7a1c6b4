//! Where signals of a source can be: upstream of it, and inside the region that flow and waves cover together.

use super::sample::Sample;
use crate::scene::{Diffusion, Model, Scene};
use crate::solid::Solid;
use crate::spec::{Medium, SourceSpec};
use rayon::prelude::*;

fn model(scene: &Scene) -> Result<&Diffusion, String> {
    match &scene.model {
        Model::Diffusion(model) => Ok(model),
        Model::SingleField(_) => Err("the run has no source".into()),
    }
}

fn velocity(scene: &Scene) -> Result<Vec<f64>, String> {
    match &model(scene)?.medium {
        Medium::Uniform(u) if u.iter().any(|component| *component != 0.0) => Ok(u.to_vec()),
        _ => Err("the flow is not uniform".into()),
    }
}

/// The direction of a uniform flow.
pub(super) fn flow(scene: &Scene) -> Result<Vec<f64>, String> {
    let u = velocity(scene)?;
    let speed = u.iter().map(|v| v * v).sum::<f64>().sqrt();
    Ok(u.iter().map(|component| component / speed).collect())
}

fn source(scene: &Scene, index: usize) -> Result<&SourceSpec, String> {
    model(scene)?.sources.get(index).ok_or_else(|| format!("the run has no source [{index}]"))
}

/// The half space further upstream than some cells from the edge of a source.
pub(crate) struct Upstream {
    flow: Vec<f64>,
    limit: f64,
}

impl Upstream {
    /// Further upstream than `cells` cells from the edge of the source `index`.
    pub fn of(scene: &Scene, index: usize, cells: usize) -> Result<Self, String> {
        let (flow, shape) = (flow(scene)?, &source(scene, index)?.shape);
        // The corner of the source's box furthest upstream.
        let corner = |axis: usize| if flow[axis] >= 0.0 { shape.bounds(axis).0 } else { shape.bounds(axis).1 };
        let edge: f64 = (0..flow.len()).filter(|axis| flow[*axis] != 0.0).map(|axis| flow[axis] * corner(axis)).sum();
        if !edge.is_finite() {
            return Err("the source has no edge".into());
        }
        let limit = edge - cells as f64 * scene.grid.spacing * (1.0 - 1e-9);
        Ok(Upstream { flow, limit })
    }

    fn holds(&self, x: &[f64]) -> bool {
        self.flow.iter().zip(x).map(|(u, x)| u * x).sum::<f64>() < self.limit
    }

    /// Whether cells of a scene that are not solid lie here.
    pub fn has_fluid(&self, scene: &Scene) -> bool {
        let solid = Solid::of(scene);
        // The cell furthest upstream decides where nothing is solid.
        let first = |(axis, u): (usize, &f64)| if *u >= 0.0 { 0 } else { scene.grid.cells[axis] - 1 };
        let corner: Vec<f64> = self.flow.iter().enumerate().map(|at| solid.centre(at.0, first(at))).collect();
        self.holds(&corner)
            && (solid.is_empty()
                || solid.any_fluid(|_| (f64::NEG_INFINITY, f64::INFINITY), |centre| self.holds(centre)))
    }
}

/// The values of `phi` further upstream than `cells` cells from the edge of a source; there are some.
pub(super) fn upstream(sample: &Sample, scene: &Scene, index: usize, cells: usize) -> Result<Vec<f64>, String> {
    let region = Upstream::of(scene, index, cells)?;
    let values = sample.phi.iter().enumerate();
    let there: Vec<f64> =
        values.filter(|(number, _)| region.holds(&sample.centre_of(*number))).map(|(_, value)| *value).collect();
    if there.is_empty() { Err(format!("no cell lies further than {cells} cells upstream")) } else { Ok(there) }
}

/// The sum of |phi| over cells that no signal of a source can have reached at `time`: with every emission a ball of
/// radius c·age that drifts with the flow. Where F_T > 0, c is that of the part with memory, and what lies outside is
/// Fourier's doing. A law without memory reaches everywhere, which leaves nothing to measure, as does a box that the
/// signals cover: the region is convex, so it covers the box where it holds the cells in the corners.
pub(super) fn outside(sample: &Sample, scene: &Scene, index: usize, time: f64) -> Result<f64, String> {
    let (u, source) = (velocity(scene)?, source(scene, index)?);
    let c = model(scene)?.law.speed().ok_or("without memory signals reach every cell at once")?;
    let ages = (time - source.until.unwrap_or(time).min(time), time - source.from);
    if ages.1 <= 0.0 {
        return Err("the source has not begun".into());
    }
    // Cells that the source touches count as its own.
    let bounds: Vec<(f64, f64)> = (0..u.len())
        .map(|axis| source.shape.bounds(axis))
        .map(|(low, high)| (low - 0.5 * sample.h, high + 0.5 * sample.h))
        .collect();
    let reached = |x: [f64; 3]| {
        // How far a ball of this age is from the cell: a convex function of the age.
        let gap = |age: f64| {
            let square: f64 = (0..u.len())
                .map(|axis| {
                    let place = x[axis] - u[axis] * age;
                    (bounds[axis].0 - place).max(place - bounds[axis].1).max(0.0).powi(2)
                })
                .sum();
            square.sqrt() - c * age
        };
        let (mut low, mut high) = ages;
        for _ in 0..60 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            let (gap_a, gap_b) = (gap(a), gap(b));
            if gap_a <= 0.0 || gap_b <= 0.0 {
                return true;
            }
            if gap_a < gap_b { high = b } else { low = a }
        }
        gap(ages.0) <= 0.0 || gap(ages.1) <= 0.0 || gap(low) <= 1e-9 * sample.h
    };
    let corner = |number: usize| {
        let end = |axis: usize| if number >> axis & 1 == 1 { sample.cells[axis] - 1 } else { 0 };
        std::array::from_fn(|axis| if axis < u.len() { sample.centre(axis, end(axis)) } else { 0.0 })
    };
    if (0..1usize << u.len()).all(|number| reached(corner(number))) {
        return Err("signals of the source can have reached every cell".into());
    }
    // Summed in order, so that threads leave no trace.
    let parts: Vec<f64> = sample
        .phi
        .par_chunks(1 << 12)
        .enumerate()
        .map(|(chunk, values)| {
            let first = chunk << 12;
            let far = values.iter().enumerate().filter(|(i, v)| **v != 0.0 && !reached(sample.centre_of(first + i)));
            far.map(|(_, value)| value.abs()).sum()
        })
        .collect();
    Ok(parts.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, SceneFile};

    fn scene(u: &str, k: f64) -> Scene {
        let text = format!(
            "(grid: (cells: (40, 80), extent: (4.0, 8.0)), \
             sides: (x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open)), \
             model: Diffusion(law: (k: {k}, tau: 4.0), medium: Uniform({u}), \
             sources: [(shape: Box(low: (1.9, 3.9), high: (2.1, 4.1)), rate: 1.0, until: Some(4.0))]), run: (until: 6.0))"
        );
        SceneFile::parse("s.ron", &text)
            .unwrap()
            .experiment(None, &[], &Limits { memory: 1 << 30 })
            .unwrap()
            .runs
            .remove(0)
    }

    #[test]
    fn upstream_is_against_the_flow() {
        for (u, count) in [("(0.0, 0.5)", 36 * 40), ("(0.0, -0.5)", 36 * 40), ("(0.5, 0.0)", 16 * 80)] {
            let scene = scene(u, 0.25);
            let sample = Sample::new(&scene.grid, vec![1.0; 3200]);
            assert_eq!(upstream(&sample, &scene, 0, 3).unwrap().len(), count, "{u}");
            assert!(
                upstream(&sample, &scene, 0, 39).is_err() && !Upstream::of(&scene, 0, 39).unwrap().has_fluid(&scene)
            );
        }
        let mut still = scene("(0.5, 0.0)", 0.25);
        let Model::Diffusion(model) = &mut still.model else { unreachable!() };
        model.medium = Medium::Still;
        let sample = Sample::new(&still.grid, vec![1.0; 3200]);
        assert!(upstream(&sample, &still, 0, 3).is_err());
    }

    #[test]
    fn what_is_solid_does_not_count_as_upstream() {
        let mut scene = scene("(0.5, 0.0)", 0.25);
        let region = Upstream::of(&scene, 0, 3).unwrap();
        assert!(region.has_fluid(&scene));
        let Model::Diffusion(model) = &mut scene.model else { unreachable!() };
        model.obstacles = vec![crate::spec::Shape::Below { axis: crate::spec::Axis::X, at: 1.7 }];
        assert!(!region.has_fluid(&scene));
    }

    #[test]
    fn a_cone_that_covers_the_box_leaves_nothing_to_measure() {
        let scene = scene("(0.5, 0.0)", 400.0); // c = 10
        let sample = Sample::new(&scene.grid, vec![1.0; 3200]);
        assert!(outside(&sample, &scene, 0, 6.0).unwrap_err().contains("every cell"));
    }

    #[test]
    fn the_cone_holds_what_flow_and_waves_carry() {
        let scene = scene("(0.0, 0.5)", 0.25); // c = 0.25
        let one = |x: f64, y: f64| {
            let mut sample = Sample::new(&scene.grid, vec![0.0; 3200]);
            sample.phi[(x * 10.0) as usize + 40 * (y * 10.0) as usize] = 2.0;
            outside(&sample, &scene, 0, 6.0).unwrap()
        };
        // Ages from 2 to 6 s: drift 1 to 3 m, radius 0.5 to 1.5 m.
        assert_eq!((one(2.0, 5.0), one(2.0, 4.55), one(2.0, 7.0), one(3.0, 7.0)), (0.0, 0.0, 0.0, 0.0));
        assert_eq!((one(2.0, 4.0), one(3.9, 7.0), one(0.5, 4.5), one(2.8, 5.0)), (2.0, 2.0, 2.0, 2.0));
    }
}
