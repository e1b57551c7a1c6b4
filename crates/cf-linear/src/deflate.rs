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

    /// Number of constants.
    pub fn count(&self) -> usize {
        match self {
            Self::None => 0,
            Self::Whole => 1,
            Self::Components(c) => 1 + c.others.len(),
        }
    }

    /// x = factor · x + value(i) in component i, the largest being the first (rounded once, but in small components).
    pub fn scale_and_shift<T: Real, const D: usize>(
        &self,
        layout: &Layout<D>,
        x: &mut [T],
        factor: f64,
        value: impl Fn(usize) -> f64,
    ) {
        match self {
            Self::None => scale_and_shift_box(layout, x, factor, 0.0),
            Self::Whole => scale_and_shift_box(layout, x, factor, value(0)),
            Self::Components(c) => {
                c.scale_and_shift_main(layout, x, factor, value(0));
                for (i, slots) in c.others.iter().enumerate() {
                    shift(x, slots, value(1 + i));
                }
            }
        }
    }

    /// Subtracts the mean of each component, the largest component first, and tells it to `each`.
    pub fn project<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &mut [T], mut each: impl FnMut(usize, f64)) {
        match self {
            Self::None => {}
            Self::Whole => {
                let mean = layout.sum(x) / layout.count() as f64;
                scale_and_shift_box(layout, x, 1.0, -mean);
                each(0, mean);
            }
            Self::Components(c) => {
                let mean = c.mean_main(layout, x);
                c.scale_and_shift_main(layout, x, 1.0, -mean);
                each(0, mean);
                for (i, slots) in c.others.iter().enumerate() {
                    let mean = slots.iter().map(|&s| x[s].f64()).sum::<f64>() / slots.len() as f64;
                    shift(x, slots, -mean);
                    each(1 + i, mean);
                }
            }
        }
    }
}

impl Floating {
    fn mean_main<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &[T]) -> f64 {
        let sum: f64 = layout.par_runs(
            layout.cells_region(),
            (),
            #[inline(always)]
            |run, ()| {
                let cells = run.row(x).iter().zip(run.row(&self.main));
                cells.map(|(v, &inside)| if inside { v.f64() } else { 0.0 }).sum::<f64>()
            },
        );
        sum / self.main_cells as f64
    }

    /// x = factor · x everywhere, + value in the largest component.
    fn scale_and_shift_main<T: Real, const D: usize>(&self, layout: &Layout<D>, x: &mut [T], factor: f64, value: f64) {
        layout.par_runs(
            layout.cells_region(),
            x,
            #[inline(always)]
            |run, row: &mut [T]| {
                for (v, &inside) in row.iter_mut().zip(run.row(&self.main)) {
                    *v = T::of(v.f64() * factor + if inside { value } else { 0.0 });
                }
            },
        );
    }
}

/// x = factor · x + value.
fn scale_and_shift_box<T: Real, const D: usize>(layout: &Layout<D>, x: &mut [T], factor: f64, value: f64) {
    layout.par_runs(
        layout.cells_region(),
        x,
        #[inline(always)]
        |_, row: &mut [T]| {
            row.iter_mut().for_each(|v| *v = T::of(v.f64() * factor + value));
        },
    );
}

fn shift<T: Real>(x: &mut [T], slots: &[usize], value: f64) {
    slots.iter().for_each(|&s| x[s] = T::of(x[s].f64() + value));
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
