//! The constants of a conserving operator: removed from residuals and corrections, added back exactly.
//!
//! Where no wall conducts, each connected component has the eigenvector 1 with eigenvalue alpha. Its part of the
//! solution is mean(b)/alpha; the solver only sees what is left, so pure Poisson problems are solvable and huge kappa
//! loses nothing in `f32` (model/diffusion.md 5.6, 5.7).

use cf_grid::{Components, Layout, Real, row_sum};

use crate::helmholtz::Helmholtz;

/// Which constants there are.
#[derive(Debug, Clone)]
pub(crate) enum Deflation {
    /// Some wall conducts.
    None,
    /// The whole box.
    Whole,
    /// One per connected component of a mask that touches no conducting wall.
    Components(Components),
}

impl Deflation {
    pub fn new<const D: usize>(helmholtz: &Helmholtz<'_, D>) -> Self {
        match helmholtz.mask() {
            _ if !helmholtz.conserves() => match helmholtz.mask() {
                None => Self::None,
                Some(mask) => floating(helmholtz, mask.components(helmholtz.walls())),
            },
            None => Self::Whole,
            Some(mask) => Self::Components(mask.components(helmholtz.walls())),
        }
    }

    /// Mean of each component.
    pub fn means<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &[T]) -> Vec<f64> {
        match self {
            Self::None => Vec::new(),
            Self::Whole => {
                let sum: f64 = layout.par_runs(layout.cells_region(), (), |run, ()| row_sum(run.row(x)));
                vec![sum / layout.count() as f64]
            }
            Self::Components(c) => {
                let mut sums = vec![0.0; c.cells.len()];
                for (v, &label) in x.iter().zip(&c.label) {
                    if label > 0 {
                        sums[label as usize - 1] += v.f64();
                    }
                }
                sums.iter().zip(&c.cells).map(|(s, &n)| if n > 0 { s / n as f64 } else { 0.0 }).collect()
            }
        }
    }

    /// x += value of each component.
    pub fn shift<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &mut [T], values: &[f64]) {
        match self {
            Self::None => {}
            Self::Whole => {
                let value = T::of(values[0]);
                layout.par_runs(layout.cells_region(), x, |_, row: &mut [T]| row.iter_mut().for_each(|v| *v += value));
            }
            Self::Components(c) => {
                for (v, &label) in x.iter_mut().zip(&c.label) {
                    if label > 0 {
                        *v += T::of(values[label as usize - 1]);
                    }
                }
            }
        }
    }

    /// Subtracts the means and returns them.
    pub fn project<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &mut [T]) -> Vec<f64> {
        let mut means = self.means(layout, x);
        means.iter_mut().for_each(|m| *m = -*m);
        self.shift(layout, x, &means);
        means.iter_mut().for_each(|m| *m = -*m);
        means
    }
}

/// Keeps only the components that no conducting wall touches.
fn floating<const D: usize>(helmholtz: &Helmholtz<'_, D>, mut components: Components) -> Deflation {
    let layout = helmholtz.layout();
    let mut held = vec![false; components.cells.len()];
    for (axis, end, w) in helmholtz.walls().walls() {
        if w == 0.0 {
            continue;
        }
        let mut region = layout.cells_region();
        match end {
            cf_grid::End::Low => region.high[axis] = 1,
            cf_grid::End::High => region.low[axis] = layout.cells()[axis] - 1,
        }
        layout.each_cell(region, |at| {
            if let Some(i) = components.label[at.slot()].checked_sub(1) {
                held[i as usize] = true;
            }
        });
    }
    if held.iter().all(|&h| h) {
        return Deflation::None;
    }
    for label in &mut components.label {
        if *label > 0 && held[*label as usize - 1] {
            *label = 0;
        }
    }
    for (cells, &held) in components.cells.iter_mut().zip(&held) {
        if held {
            *cells = 0;
        }
    }
    Deflation::Components(components)
}
