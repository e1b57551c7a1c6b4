//! What a grid shows of a scene before anything moves: `Target` halves grids, and on coarse ones obstacles close or vanish
//! and waves of the initial state alias.

use super::{BuildError, coverage, diffusion};
use crate::coarse;
use crate::scene::{Diffusion, Model, Scene};
use crate::solid::Solid;
use cf_diffusion::Law;
use cf_grid::Mask;

/// On a grid, x fastest.
pub(crate) struct Shown {
    cells: Vec<usize>,
    /// phi at the start.
    initial: Vec<f64>,
    /// 1 where sources hold phi, and where obstacles are.
    flags: [Vec<f64>; 2],
    /// Connected parts of the fluid.
    parts: usize,
}

impl Shown {
    /// What the grid of a scene shows; nothing for a model that needs no grid to be exact.
    pub fn of(scene: &Scene) -> Result<Option<Shown>, BuildError> {
        let Model::Diffusion(model) = &scene.model else { return Ok(None) };
        match scene.grid.dimension() {
            2 => on::<2>(scene, model),
            3 => on::<3>(scene, model),
            axes => Err(BuildError::Dimension { axes, what: "diffusion model" }),
        }
        .map(Some)
    }

    /// Whether a grid of 2^n times as large cells shows the same: means of phi within a quarter, obstacles and sources that hold
    /// phi within a half, both in the mean square, and as many connected parts.
    pub fn is_shown_by(&self, grid: &Shown) -> bool {
        const OFF: f64 = 0.25;
        const LOST: f64 = 0.5;
        let means = coarse::means(&self.initial, &self.cells, &grid.cells);
        let initial = grid.initial.iter().copied().zip(means);
        let flags = self.flags.iter().zip(&grid.flags);
        self.parts == grid.parts
            && coarse::difference(initial) <= OFF
            && flags.into_iter().all(|(fine, spread)| {
                let spread = |(i, flag): (usize, &f64)| (spread[coarse::above(i, &self.cells, &grid.cells)], *flag);
                coarse::difference(fine.iter().enumerate().map(spread)) <= LOST
            })
    }
}

fn on<const D: usize>(scene: &Scene, model: &Diffusion) -> Result<Shown, BuildError> {
    let grid = diffusion::grid::<D>(&scene.grid)?;
    let layout = grid.layout();
    let solids = Solid::of(scene);
    let mask = Mask::new(layout, |cell| !solids.holds(grid.centre(cell).as_slice()));
    let mut phi = vec![0.0; layout.slots()];
    for deposit in &model.initial {
        coverage::deposit(&grid, &deposit.shape, deposit.value, &mut phi);
    }
    let (origin, extent) = (grid.origin(), grid.extent());
    let held = |centre: &[f64]| {
        let shapes = model.sources.iter().filter(|source| source.value.is_some()).map(|source| &source.shape);
        shapes.into_iter().any(|shape| shape.weight(centre, origin.as_slice(), extent.as_slice()) > 0.0)
    };
    let (mut initial, mut flags) = (Vec::new(), [Vec::new(), Vec::new()]);
    layout.each_cell(layout.cells_region(), |at| {
        let fluid = mask.fluid()[at.slot()];
        initial.push(if fluid { phi[at.slot()] } else { 0.0 });
        flags[0].push(f64::from(u8::from(fluid && held(grid.centre(at.cell).as_slice()))));
        flags[1].push(f64::from(u8::from(!fluid)));
    });
    let sides = diffusion::sides(scene, &Law::new(model.law.k, model.law.tau, model.law.fourier)?);
    Ok(Shown { cells: grid.cells().to_vec(), initial, flags, parts: mask.components(&sides).cells.len() })
}
