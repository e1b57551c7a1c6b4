//! The preconditioner: one V(1,1) cycle with red-black Gauss-Seidel, colours reversed on the way up, from a zero guess.
//! It is a symmetric positive definite operator (model/diffusion.md 5.2).

use cf_grid::{Layout, Real};

use crate::axis::in_series;
use crate::coarse::{self, CoarseSolver};
use crate::helmholtz::Helmholtz;
use crate::level::{Coefficients, LevelOperator};
use crate::stencil::{BoxStencil, StoredStencil};
use crate::transfer::Transfer;

/// Levels, transfers and scratch of one operator, built once and reused for every solve.
pub struct Multigrid<T, const D: usize> {
    finest: LevelOperator<T, D>,
    /// `transfers[l]` joins level l and l + 1.
    transfers: Vec<Transfer<T, D>>,
    coarser: Vec<Level<T, D>>,
    coarsest: Option<CoarseSolver<D>>,
}

struct Level<T, const D: usize> {
    operator: LevelOperator<T, D>,
    x: Vec<T>,
    b: Vec<T>,
    scratch: Vec<T>,
}

/// Coarsening goes on to about this many cells, where the exact solve is free.
const SMALL: usize = 64;

/// Below this local kappa two symmetric sweeps solve a level as well as anything (model/diffusion.md 5.4).
const WEAK: f64 = 0.5;

impl<T: Real, const D: usize> Multigrid<T, D> {
    /// The hierarchy of an operator: levels halve until kappa is weak, or few cells are left.
    pub fn new(helmholtz: &Helmholtz<'_, D>) -> Self {
        let finest = helmholtz.level::<T>();
        let (mut transfers, mut coarser): (Vec<_>, Vec<Level<T, D>>) = (Vec::new(), Vec::new());
        let kappa = helmholtz.kappa() * helmholtz.largest_share();
        let mut strength = if helmholtz.alpha() > 0.0 { kappa / helmholtz.alpha() } else { f64::INFINITY };
        let coarsest = loop {
            let current = coarser.last().map_or(&finest, |l| &l.operator);
            let cells = current.layout.count();
            if strength < WEAK && cells > SMALL {
                break None;
            }
            if cells <= SMALL || current.layout.cells().iter().all(|&n| n == 1) {
                break CoarseSolver::new(current).filter(|_| cells <= coarse::LARGEST);
            }
            let (operator, transfer) = coarsen(current);
            let slots = operator.layout.slots();
            let field = || vec![T::ZERO; slots];
            coarser.push(Level { x: field(), b: field(), scratch: field(), operator });
            transfers.push(transfer);
            strength /= 4.0;
        };
        Self { finest, transfers, coarser, coarsest }
    }

    /// The operator of the finest level, divided by its [`scale`](Helmholtz::scale).
    pub(crate) fn finest(&self) -> &LevelOperator<T, D> {
        &self.finest
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        1 + self.coarser.len()
    }

    /// Whether the coarsest level is solved exactly.
    pub fn is_exact_below(&self) -> bool {
        self.coarsest.is_some()
    }

    /// Bytes of coefficients, transfers and level vectors.
    pub fn bytes(&self) -> usize {
        let vectors: usize = self.coarser.iter().map(|l| 3 * l.x.len()).sum();
        let scales: usize = self.transfers.iter().filter_map(|t| t.renormalise.as_ref()).map(Vec::len).sum();
        let stored: usize = self.coarser.iter().map(|l| l.operator.bytes()).sum();
        (vectors + scales) * size_of::<T>() + stored + self.finest.bytes()
    }

    /// x = M b, one cycle from a zero guess. `scratch` is any vector of the same layout whose content is not needed;
    /// its rim and that of `x` are set to zero or wrapped.
    pub fn cycle(&mut self, b: &[T], x: &mut [T], scratch: &mut [T]) {
        self.split().1.cycle(b, x, scratch);
    }

    /// The finest operator and the cycle over it, borrowed apart.
    pub(crate) fn split(&mut self) -> (&LevelOperator<T, D>, Below<'_, T, D>) {
        let Self { finest, transfers, coarser, coarsest } = self;
        (finest, Below { finest, transfers, coarser, coarsest })
    }
}

/// A hierarchy borrowed for cycles.
pub(crate) struct Below<'a, T, const D: usize> {
    finest: &'a LevelOperator<T, D>,
    transfers: &'a [Transfer<T, D>],
    coarser: &'a mut [Level<T, D>],
    coarsest: &'a mut Option<CoarseSolver<D>>,
}

impl<T: Real, const D: usize> Below<'_, T, D> {
    pub fn cycle(&mut self, b: &[T], x: &mut [T], scratch: &mut [T]) {
        cycle(self.finest, self.transfers, self.coarser, self.coarsest, b, x, scratch);
    }
}

fn cycle<T: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    transfers: &[Transfer<T, D>],
    coarser: &mut [Level<T, D>],
    coarsest: &mut Option<CoarseSolver<D>>,
    b: &[T],
    x: &mut [T],
    scratch: &mut [T],
) {
    x.fill(T::ZERO);
    let Some((next, below)) = coarser.split_first_mut() else {
        if let Some(solver) = coarsest {
            solver.solve(b, x);
        } else {
            operator.smooth(b, x, false);
            operator.smooth(b, x, true);
            operator.smooth(b, x, false);
            operator.smooth(b, x, true);
        }
        return;
    };
    operator.smooth(b, x, false);
    scratch.fill(T::ZERO);
    operator.residual(b, x, scratch);
    transfers[0].weigh(scratch);
    operator.wrap(scratch);
    transfers[0].restrict(scratch, &mut next.b);
    cycle(&next.operator, &transfers[1..], below, coarsest, &next.b, &mut next.x, &mut next.scratch);
    next.operator.wrap(&mut next.x);
    transfers[0].prolong_add(&next.x, x);
    operator.smooth(b, x, true);
}

fn coarsen<T: Real, const D: usize>(fine: &LevelOperator<T, D>) -> (LevelOperator<T, D>, Transfer<T, D>) {
    let pairs: Vec<_> = fine.axes.iter().map(|a| a.coarsen()).collect();
    let axes = std::array::from_fn(|a| pairs[a].0.clone());
    let interpolation = std::array::from_fn(|a| pairs[a].1.clone());
    // Halving a valid layout gives a valid layout.
    let layout = Layout::new(std::array::from_fn(|a| pairs[a].0.len())).unwrap_or(fine.layout);
    let mut transfer = Transfer { fine: fine.layout, coarse: layout, axes: interpolation, renormalise: None };
    let coefficients = match &fine.coefficients {
        Coefficients::Uniform(s) => Coefficients::Uniform(BoxStencil { alpha: s.alpha, axes: axes.clone() }),
        Coefficients::Stored(s) => {
            let stencil = coarsen_stored(fine, s, &axes, &layout);
            transfer.renormalise = Some(renormalisation(fine, s, &stencil, &transfer));
            Coefficients::Stored(stencil)
        }
    };
    (LevelOperator::new(layout, axes, coefficients), transfer)
}

/// Coarse mass = sum of the children's; a coarse face's conductance = sum over the fine faces on it, each with the
/// resistance of the longer way (model/diffusion.md 5.8).
fn coarsen_stored<T: Real, const D: usize>(
    fine: &LevelOperator<T, D>,
    stencil: &StoredStencil<T, D>,
    axes: &[crate::axis::AxisTable; D],
    layout: &Layout<D>,
) -> StoredStencil<T, D> {
    let parent = |a: usize, i: usize| if fine.axes[a].len() > 1 { i / 2 } else { i };
    let mut mass = vec![0.0; layout.slots()];
    let mut face: [Vec<f64>; D] = std::array::from_fn(|_| vec![0.0; layout.slots()]);
    fine.layout.each_cell(fine.layout.cells_region(), |at| {
        mass[layout.slot(std::array::from_fn(|a| parent(a, at.cell[a])))] += stencil.mass[at.slot()].f64();
    });
    for a in 0..D {
        let (n, m) = (fine.axes[a].len(), axes[a].len());
        fine.layout.each_cell(fine.layout.faces_region(a, false), |at| {
            let i = at.cell[a];
            // Faces inside a coarse cell vanish.
            let to = match i {
                0 => 0,
                i if i == n => m,
                i if n > 1 && i % 2 == 0 => i / 2,
                _ => return,
            };
            let w = stencil.face[a][at.slot()].f64();
            let wall = !fine.axes[a].periodic && (i == 0 || i == n);
            let w = if n == 1 {
                w
            } else if wall {
                let area: f64 = (0..D).filter(|&o| o != a).map(|o| fine.axes[o].width[at.cell[o]]).product();
                let end = if i == 0 { 0 } else { n - 1 };
                let longer = 0.5 * (axes[a].width[if i == 0 { 0 } else { m - 1 }] - fine.axes[a].width[end]);
                in_series(w, longer, fine.axes[a].kappa * area)
            } else if fine.axes[a].face[i] > 0.0 {
                w * axes[a].face[to] / fine.axes[a].face[i]
            } else {
                0.0
            };
            let mut cell: [usize; D] = std::array::from_fn(|o| if o == a { to } else { parent(o, at.cell[o]) });
            cell[a] = to;
            face[a][layout.slot(cell)] += w;
        });
    }
    StoredStencil::new(layout, &mass, &face)
}

/// Per fine cell: (sum of its weights) / (sum of its weights from coarse cells that are not solid).
fn renormalisation<T: Real, const D: usize>(
    fine: &LevelOperator<T, D>,
    fine_stencil: &StoredStencil<T, D>,
    coarse: &StoredStencil<T, D>,
    transfer: &Transfer<T, D>,
) -> Vec<T> {
    let layout = transfer.coarse;
    let wrap = |x: &mut [T]| {
        for a in 0..D {
            if fine.axes[a].periodic {
                layout.wrap_rim(a, x);
            }
        }
    };
    let (mut all, mut open) = (vec![T::ZERO; layout.slots()], vec![T::ZERO; layout.slots()]);
    layout.par_cells(&mut all, |_| T::ONE);
    layout.par_cells(&mut open, |at| if coarse.inverse[at.slot()] > T::ZERO { T::ONE } else { T::ZERO });
    wrap(&mut all);
    wrap(&mut open);
    let slots = fine.layout.slots();
    let (mut sum, mut part) = (vec![T::ZERO; slots], vec![T::ZERO; slots]);
    transfer.prolong_add(&all, &mut sum);
    transfer.prolong_add(&open, &mut part);
    let mut scale = vec![T::ZERO; slots];
    fine.layout.par_cells(&mut scale, |at| {
        let s = at.slot();
        if fine_stencil.inverse[s] > T::ZERO && part[s] > T::ZERO { sum[s] / part[s] } else { T::ZERO }
    });
    scale
}
