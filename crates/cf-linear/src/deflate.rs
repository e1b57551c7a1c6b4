//! The constants of a conserving operator: removed from residuals and corrections, added back exactly.
//!
//! Where no wall conducts, each connected component has the eigenvector 1 with eigenvalue alpha. Its part of the
//! solution is mean(b)/alpha; the solver only sees what is left, so pure Poisson problems are solvable and huge kappa
//! loses nothing in `f32`. Passes: 1 for means, 2 to shift; on uniform boxes both ride along with other sweeps.

use cf_grid::{Layout, Real};

use crate::helmholtz::Helmholtz;

/// Which constants there are.
#[derive(Debug, Clone)]
pub(crate) enum Deflation {
    /// Every cell is joined to a conducting wall, or no cell to anything.
    None,
    /// The whole box.
    Whole,
    /// One per connected component that touches no conducting wall.
    Components(Floating),
}

/// Components that no conducting wall touches: the largest as flags, the others as lists.
#[derive(Debug, Clone)]
pub(crate) struct Floating {
    main: Vec<bool>,
    main_cells: usize,
    others: Vec<Vec<usize>>,
}

impl Deflation {
    pub fn new<const D: usize>(helmholtz: &Helmholtz<'_, D>) -> Self {
        if helmholtz.is_diagonal() {
            Self::None
        } else if helmholtz.is_stored() {
            floating(helmholtz)
        } else if helmholtz.conserves() {
            Self::Whole
        } else {
            Self::None
        }
    }

    /// Bytes of flags and lists.
    pub fn bytes(&self) -> usize {
        match self {
            Self::None | Self::Whole => 0,
            Self::Components(c) => c.main.len() + c.others.iter().map(|slots| size_of_val(&slots[..])).sum::<usize>(),
        }
    }

    /// Mean of each component, the largest component first.
    pub fn means<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &[T]) -> Vec<f64> {
        match self {
            Self::None => Vec::new(),
            Self::Whole => vec![layout.sum(x) / layout.count() as f64],
            Self::Components(c) => {
                let main: f64 = layout.par_runs(
                    layout.cells_region(),
                    (),
                    #[inline(always)]
                    |run, ()| {
                        let cells = run.row(x).iter().zip(run.row(&c.main));
                        cells.map(|(v, &inside)| if inside { v.f64() } else { 0.0 }).sum::<f64>()
                    },
                );
                let others = c.others.iter().map(|slots| {
                    let sum: f64 = slots.iter().map(|&s| x[s].f64()).sum();
                    sum / slots.len() as f64
                });
                std::iter::once(main / c.main_cells as f64).chain(others).collect()
            }
        }
    }

    /// x += value of each component, rounded once.
    pub fn shift<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &mut [T], values: &[f64]) {
        if !values.is_empty() {
            self.scale_and_shift(layout, x, 1.0, values);
        }
    }

    /// x = factor · x + value of each component (rounded once, but in small components). `values` may be empty.
    pub fn scale_and_shift<T: Real, const D: usize>(
        &self,
        layout: &Layout<D>,
        x: &mut [T],
        factor: f64,
        values: &[f64],
    ) {
        let (first, rest) = values.split_first().map_or((0.0, values), |(first, rest)| (*first, rest));
        match self {
            Self::None | Self::Whole => layout.par_runs(
                layout.cells_region(),
                x,
                #[inline(always)]
                |_, row: &mut [T]| {
                    row.iter_mut().for_each(|v| *v = T::of(v.f64() * factor + first));
                },
            ),
            Self::Components(c) => {
                layout.par_runs(
                    layout.cells_region(),
                    &mut *x,
                    #[inline(always)]
                    |run, row: &mut [T]| {
                        for (v, &inside) in row.iter_mut().zip(run.row(&c.main)) {
                            *v = T::of(v.f64() * factor + if inside { first } else { 0.0 });
                        }
                    },
                );
                for (slots, value) in c.others.iter().zip(rest) {
                    slots.iter().for_each(|&s| x[s] = T::of(x[s].f64() + value));
                }
            }
        }
    }

    /// Subtracts the means and returns them.
    pub fn project<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &mut [T]) -> Vec<f64> {
        let means = self.means(layout, x);
        let negative: Vec<f64> = means.iter().map(|m| -m).collect();
        self.shift(layout, x, &negative);
        means
    }
}

/// Flood fill over conducting faces; components joined to a conducting wall are dropped.
fn floating<const D: usize>(helmholtz: &Helmholtz<'_, D>) -> Deflation {
    let layout = helmholtz.layout();
    let mut seen = vec![false; layout.slots()];
    let (mut found, mut queue) = (Vec::new(), Vec::new());
    layout.each_cell(layout.cells_region(), |at| {
        if seen[at.slot()] || !helmholtz.is_fluid(at.cell) {
            return;
        }
        let (mut slots, mut held) = (Vec::new(), false);
        seen[at.slot()] = true;
        queue.push(at.cell);
        while let Some(cell) = queue.pop() {
            slots.push(layout.slot(cell));
            for (neighbour, conductance) in helmholtz.faces_of(cell) {
                match neighbour {
                    _ if conductance == 0.0 => {}
                    None => held = true,
                    Some(next) => {
                        let slot = layout.slot(next);
                        if !std::mem::replace(&mut seen[slot], true) {
                            queue.push(next);
                        }
                    }
                }
            }
        }
        if !held {
            found.push(slots);
        }
    });
    // Largest first; the sort is stable, so that the order is that of the first cells otherwise.
    found.sort_by_key(|slots| std::cmp::Reverse(slots.len()));
    let mut found = found.into_iter();
    let Some(largest) = found.next() else { return Deflation::None };
    let mut main = vec![false; layout.slots()];
    largest.iter().for_each(|&s| main[s] = true);
    Deflation::Components(Floating { main, main_cells: largest.len(), others: found.collect() })
}
