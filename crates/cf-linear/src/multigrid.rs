//! The preconditioner: one V(1,1) cycle with red-black Gauss-Seidel, colours reversed on the way up, from a zero guess.
//! It is a symmetric positive definite operator, as conjugate gradients ask for (Tatebe 1993). One coarse level is
//! solved by two cycles in a row, which keeps that.
//!
//! Levels of uniform coefficients take the two sweeps of [`fused`](crate::fused); levels with stored coefficients, and
//! those where two cells of one colour meet at a seam, take one sweep per part of the cycle.

use cf_grid::{CellField, Layout, Real, row_dot, row_sum};

use crate::axis::in_series;
use crate::coarse::CoarseSolver;
use crate::deflate::Deflation;
use crate::fused::{Fused, Products, Scratch};
use crate::helmholtz::Helmholtz;
use crate::kernels::Clock;
use crate::level::{Coefficients, LevelOperator};
use crate::stencil::{BoxStencil, StoredStencil};
use crate::transfer::Transfer;

/// Levels, transfers and scratch of one operator, built once and reused for every solve.
pub(crate) struct Multigrid<T, const D: usize> {
    finest: LevelOperator<T, D>,
    /// `steps[l]` joins level l and l + 1.
    steps: Vec<Step<T, D>>,
    coarser: Vec<Level<T, D>>,
    coarsest: Option<CoarseSolver<D>>,
    /// Of the finest level where that is not fused: a copy of right-hand sides of another precision, and scratch. Empty where they are
    /// not needed.
    own: [CellField<T>; 2],
    copies: bool,
    work: Work<T>,
}

/// How two levels are joined.
struct Step<T, const D: usize> {
    transfer: Transfer<T, D>,
    fused: Option<Fused<T, D>>,
}

struct Level<T, const D: usize> {
    operator: LevelOperator<T, D>,
    x: CellField<T>,
    b: CellField<T>,
    /// Empty where the level is fused.
    scratch: CellField<T>,
    /// Right-hand side and solution of a second cycle.
    second: Option<[CellField<T>; 2]>,
}

/// What the fused sweeps of all levels share.
struct Work<T> {
    threads: Vec<Scratch<T>>,
    sums: Vec<Products>,
}

/// Coarsening goes on to about this many cells, where the exact solve is free.
const SMALL: usize = 64;

/// The level of a three-dimensional box that is solved by two cycles in a row, counted from the finest: what the levels
/// below leave, odd ones above all, would cost an iteration, and this costs a fifth of a pass (one more cycle over 1/64 of the cells). Over
/// obstacles a cycle may overshoot by more than a factor of two, where two in a row are not positive definite any more.
const TWICE: usize = 2;

/// Below this local kappa two symmetric sweeps solve a level well enough: all neighbours of a cell together weigh at most
/// 2 D WEAK / (1 + 2 D WEAK) of its diagonal.
const WEAK: f64 = 0.5;

impl<T: Real, const D: usize> Multigrid<T, D> {
    /// The hierarchy of an operator: levels halve until kappa is weak, or few cells are left.
    pub fn new(helmholtz: &Helmholtz<'_, D>) -> Self {
        // Open volume of each cell, as long as there are obstacles.
        let mut open = helmholtz.open();
        let finest = helmholtz.level::<T>().with_band(&open);
        let (mut steps, mut coarser): (Vec<Step<T, D>>, Vec<Level<T, D>>) = (Vec::new(), Vec::new());
        let kappa = helmholtz.kappa() * helmholtz.largest_share();
        let mut strength = if helmholtz.alpha() > 0.0 { kappa / helmholtz.alpha() } else { f64::INFINITY };
        let coarsest = loop {
            let current = coarser.last().map_or(&finest, |l| &l.operator);
            let cells = current.layout.count();
            if strength < WEAK && cells > SMALL {
                break None;
            }
            if cells <= SMALL {
                break CoarseSolver::new(current);
            }
            let (operator, step) = coarsen(current, &mut open);
            let twice = coarser.len() + 1 == TWICE && D == 3 && !helmholtz.is_stored();
            let [x, b, scratch] = Default::default();
            coarser.push(Level { x, b, scratch, second: twice.then(Default::default), operator });
            steps.push(step);
            strength /= 4.0;
        };
        let fused = || steps.iter().filter_map(|s| s.fused.as_ref());
        let length = fused().map(Fused::scratch).max().unwrap_or(0);
        let planes = fused().map(Fused::planes).max().unwrap_or(0);
        // A serial sweep needs one, threads two each (see `fused::tile::slabs`).
        let threads = if length == 0 { 0 } else { 2 * rayon::current_num_threads() };
        let work = Work {
            threads: (0..threads).map(|_| vec![T::ZERO; length]).collect(),
            sums: vec![Products::default(); planes],
        };
        let mut made = Self { finest, steps, coarser, coarsest, own: Default::default(), copies: false, work };
        made.each_vector(|layout, vector| *vector = CellField::new(layout));
        made
    }

    /// Ready for right-hand sides of another precision.
    pub fn with_copies(mut self) -> Self {
        self.copies = true;
        let layout = self.finest.layout;
        if self.own[0].is_empty() && self.steps.first().is_none_or(|s| s.fused.is_none()) {
            self.own[0] = CellField::new(&layout);
        }
        self
    }

    /// Calls `f` with every vector that the cycle needs, and its layout.
    pub fn each_vector(&mut self, mut f: impl FnMut(&Layout<D>, &mut CellField<T>)) {
        let Self { finest, steps, coarser, own: [copy, scratch], copies, .. } = self;
        if *copies && steps.first().is_none_or(|s| s.fused.is_none()) {
            f(&finest.layout, copy);
        }
        if steps.first().is_some_and(|s| s.fused.is_none()) {
            f(&finest.layout, scratch);
        }
        for (l, Level { operator, x, b, scratch, second }) in coarser.iter_mut().enumerate() {
            let plain = steps.get(l + 1).is_some_and(|s| s.fused.is_none());
            let scratch = plain.then_some(scratch).into_iter();
            [x, b].into_iter().chain(scratch).chain(second.iter_mut().flatten()).for_each(|v| f(&operator.layout, v));
        }
    }

    /// The operator of the finest level, divided by its [`scale`](Helmholtz::scale).
    pub(crate) fn finest(&self) -> &LevelOperator<T, D> {
        &self.finest
    }

    /// Number of levels.
    pub fn levels(&self) -> usize {
        1 + self.coarser.len()
    }

    /// Bytes of coefficients, transfers and level vectors.
    pub fn bytes(&self) -> usize {
        let second = |l: &Level<T, D>| l.second.as_ref().map_or(0, |s| s[0].len() + s[1].len());
        let levels: usize = self.coarser.iter().map(|l| l.x.len() + l.b.len() + l.scratch.len() + second(l)).sum();
        let own: usize = self.own.iter().map(|vector| vector.len()).sum();
        let rings: usize = self.work.threads.iter().map(Vec::len).sum();
        let scales: usize = self.steps.iter().filter_map(|s| s.transfer.renormalise.as_ref()).map(Vec::len).sum();
        let tables: usize = self.steps.iter().filter_map(|s| s.fused.as_ref()).map(Fused::bytes).sum();
        let stored: usize = self.coarser.iter().map(|l| l.operator.bytes()).sum();
        let sums = self.work.sums.len() * size_of::<Products>();
        (levels + own + rings + scales) * size_of::<T>() + tables + sums + stored + self.finest.bytes()
    }

    /// The finest operator and the cycle over it, borrowed apart.
    pub(crate) fn split(&mut self) -> (&LevelOperator<T, D>, Cycle<'_, T, D>) {
        let Self { finest, steps, coarser, coarsest, own, work, .. } = self;
        (finest, Cycle { finest, steps, coarser, coarsest, own, work })
    }
}

/// A hierarchy borrowed for cycles.
pub(crate) struct Cycle<'a, T, const D: usize> {
    finest: &'a LevelOperator<T, D>,
    steps: &'a [Step<T, D>],
    coarser: &'a mut [Level<T, D>],
    coarsest: &'a mut Option<CoarseSolver<D>>,
    own: &'a mut [CellField<T>; 2],
    work: &'a mut Work<T>,
}

impl<T: Real, const D: usize> Cycle<'_, T, D> {
    /// x = M (scale · b), one cycle from a zero guess; the rim of `x` is not meaningful. Returns inner products of
    /// scale · b and x; small components of a `deflation` are taken out of x before that.
    pub fn run<B: Real>(&mut self, b: &[B], scale: f64, x: &mut [T], deflation: &Deflation) -> Products {
        let Self { finest, steps, coarser, coarsest, own, work } = self;
        if let (Some(step), Some((next, below))) = (steps.first(), coarser.split_first_mut())
            && let Some(fused) = &step.fused
        {
            fused.descend(b, scale, &mut next.b, &mut work.threads);
            visit(next, &steps[1..], below, coarsest, work);
            let products = fused.ascend(b, scale, &next.x, x, &mut work.sums, &mut work.threads);
            if !products.bx.is_finite() {
                // What stands between rows is multiplied by zero, which NaN would survive.
                work.threads.iter_mut().for_each(|scratch| scratch.fill(T::ZERO));
            }
            return products;
        }
        let layout = finest.layout;
        let cells = layout.cells_region();
        let [copy, scratch] = &mut **own;
        let b = match T::same(b) {
            Some(b) if scale == 1.0 => b,
            _ => {
                if copy.is_empty() {
                    *copy = CellField::new(&layout);
                }
                layout.par_runs(
                    cells,
                    &mut copy[..],
                    #[inline(always)]
                    |run, copy: &mut [T]| {
                        for (copy, &b) in copy.iter_mut().zip(run.row(b)) {
                            *copy = T::of(b.f64() * scale);
                        }
                    },
                );
                copy
            }
        };
        cycle(finest, steps, coarser, coarsest, b, x, scratch, work);
        if let Deflation::Components(_) = deflation {
            deflation.project(&layout, x, |_, _| ());
        }
        let (bx, sum): (f64, f64) = layout.par_runs(
            cells,
            (),
            #[inline(always)]
            |run, ()| {
                let x = run.row(x);
                (row_dot(run.row(b), x), row_sum(x))
            },
        );
        Products { bx, xax: finest.energy(x), x: sum }
    }

    /// The parts of [`run`](Self::run) against the clock: the two fused sweeps and what is below them, or the cycle as a whole. `size` is
    /// that of a number here, relative to those of b.
    pub fn time<B: Real>(&mut self, b: &[B], x: &mut [T], deflation: &Deflation, size: f64, clock: &mut Clock) {
        let part = size / f64::from(1 << D);
        if let (Some(step), Some((next, below))) = (self.steps.first(), self.coarser.split_first_mut())
            && let Some(fused) = &step.fused
        {
            let (steps, Work { threads, sums }) = (&self.steps[1..], &mut *self.work);
            clock.time("descend", 1.0, 1.0 + part, || fused.descend(b, 1.0, &mut next.b, threads));
            clock.time("ascend", 1.0, 1.0 + size + part, || {
                fused.ascend(b, 1.0, &next.x, x, sums, threads);
            });
            let (coarsest, work) = (&mut *self.coarsest, &mut *self.work);
            // Each level is 2^-D of the one above.
            let below_all = (3.0 * size + 2.0 * part) / f64::from((1 << D) - 1);
            clock.time("coarse levels", 1.0, below_all, || visit(next, steps, below, coarsest, work));
            return;
        }
        clock.time("cycle, not fused", 1.0, f64::NAN, || {
            self.run(b, 1.0, x, deflation);
        });
    }
}

/// Solves a level below the finest, by one cycle or two.
fn visit<T: Real, const D: usize>(
    level: &mut Level<T, D>,
    steps: &[Step<T, D>],
    coarser: &mut [Level<T, D>],
    coarsest: &mut Option<CoarseSolver<D>>,
    work: &mut Work<T>,
) {
    let Level { operator, x, b, scratch, second } = level;
    cycle(operator, steps, coarser, coarsest, b, x, scratch, work);
    let Some([rhs, dx]) = second.as_mut().filter(|_| !coarser.is_empty()) else { return };
    operator.residual(b, x, rhs);
    cycle(operator, steps, coarser, coarsest, rhs, dx, scratch, work);
    operator.layout.par_runs(
        operator.layout.cells_region(),
        &mut x[..],
        #[inline(always)]
        |run, x: &mut [T]| {
            for (x, &dx) in x.iter_mut().zip(run.row(dx)) {
                *x += dx;
            }
        },
    );
    operator.wrap(x);
}

#[allow(clippy::too_many_arguments)]
fn cycle<T: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    steps: &[Step<T, D>],
    coarser: &mut [Level<T, D>],
    coarsest: &mut Option<CoarseSolver<D>>,
    b: &[T],
    x: &mut [T],
    scratch: &mut [T],
    work: &mut Work<T>,
) {
    let (Some((next, below)), Some((step, rest))) = (coarser.split_first_mut(), steps.split_first()) else {
        x.fill(T::ZERO);
        if let Some(solver) = coarsest {
            solver.solve(b, x);
        } else {
            operator.smooth(b, x, false);
            operator.smooth(b, x, true);
            operator.smooth(b, x, false);
            operator.smooth(b, x, true);
        }
        operator.wrap(x);
        return;
    };
    if let Some(fused) = &step.fused {
        fused.descend(b, 1.0, &mut next.b, &mut work.threads);
        visit(next, rest, below, coarsest, work);
        fused.ascend(b, 1.0, &next.x, x, &mut work.sums, &mut work.threads);
        return;
    }
    x.fill(T::ZERO);
    operator.smooth(b, x, false);
    scratch.fill(T::ZERO);
    operator.residual(b, x, scratch);
    step.transfer.weigh(scratch);
    operator.wrap(scratch);
    step.transfer.restrict(scratch, &mut next.b);
    visit(next, rest, below, coarsest, work);
    next.operator.wrap(&mut next.x);
    step.transfer.prolong_add(&next.x, x);
    operator.smooth(b, x, true);
    operator.wrap(x);
}

/// The operator of the next level and the way there; `open` becomes that level's.
fn coarsen<T: Real, const D: usize>(
    fine: &LevelOperator<T, D>,
    open: &mut Vec<f64>,
) -> (LevelOperator<T, D>, Step<T, D>) {
    let pairs: Vec<_> = fine.axes.iter().map(|a| a.coarsen()).collect();
    let axes = std::array::from_fn(|a| pairs[a].0.clone());
    let interpolation = std::array::from_fn(|a| pairs[a].1.clone());
    // Halving a valid layout gives a valid layout.
    let layout = Layout::new(std::array::from_fn(|a| pairs[a].0.len())).unwrap_or(fine.layout);
    let mut transfer = Transfer { fine: fine.layout, coarse: layout, axes: interpolation, renormalise: None };
    let mut fused = None;
    let coefficients = match &fine.coefficients {
        Coefficients::Uniform(s) => {
            fused = Fused::new(s, &fine.layout, &layout, &transfer.axes);
            Coefficients::Uniform(BoxStencil { alpha: s.alpha, axes: axes.clone() })
        }
        Coefficients::Stored(s) => {
            let stencil = coarsen_stored(fine, s, &axes, &transfer);
            transfer.renormalise = Some(renormalisation(fine, s, &stencil, &transfer));
            *open = sum_children(&transfer, |slot| open[slot]);
            Coefficients::Stored(stencil)
        }
    };
    (LevelOperator::new(layout, axes, coefficients).with_band(open), Step { transfer, fused })
}

/// The coarse cells that stand for a fine cell, and for how much of it, beside axis `skip`.
fn heirs<T, const D: usize>(
    transfer: &Transfer<T, D>,
    cell: [usize; D],
    skip: Option<usize>,
) -> impl Iterator<Item = ([usize; D], f64)> + '_ {
    (0..1usize << D).filter_map(move |bits| {
        let (mut to, mut part) = (cell, 1.0);
        for a in 0..D {
            let (p, beside) = (&transfer.axes[a], bits >> a & 1 == 1);
            if skip == Some(a) || !p.coarsened {
                part *= f64::from(u8::from(!beside));
                continue;
            }
            let lent = p.lent[cell[a]];
            // Only the last cell of an axis is alone.
            (to[a], part) =
                if beside { (transfer.coarse.cells()[a] - 1, part * lent) } else { (cell[a] / 2, part * (1.0 - lent)) };
        }
        (part > 0.0).then_some((to, part))
    })
}

fn sum_children<T: Real, const D: usize>(transfer: &Transfer<T, D>, value: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut sum = vec![0.0; transfer.coarse.slots()];
    transfer.fine.each_cell(transfer.fine.cells_region(), |at| {
        for (to, part) in heirs(transfer, at.cell, None) {
            sum[transfer.coarse.slot(to)] += part * value(at.slot());
        }
    });
    sum
}

/// Coarse mass = sum of the children's; a coarse face's conductance = sum over the fine faces on it, each with the
/// resistance of the longer way.
fn coarsen_stored<T: Real, const D: usize>(
    fine: &LevelOperator<T, D>,
    stencil: &StoredStencil<T, D>,
    axes: &[crate::axis::AxisTable; D],
    transfer: &Transfer<T, D>,
) -> StoredStencil<T, D> {
    let layout = &transfer.coarse;
    let mass = sum_children(transfer, |slot| stencil.mass[slot].f64());
    let mut face: [Vec<f64>; D] = std::array::from_fn(|_| vec![0.0; layout.slots()]);
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
                let longer = 0.5 * (axes[a].extent[if i == 0 { 0 } else { m - 1 }] - fine.axes[a].extent[end]);
                in_series(w, longer, fine.axes[a].kappa * area)
            } else if fine.axes[a].face[i] > 0.0 {
                w * axes[a].face[to] / fine.axes[a].face[i]
            } else {
                0.0
            };
            for (mut cell, part) in heirs(transfer, at.cell, Some(a)) {
                cell[a] = to;
                face[a][layout.slot(cell)] += part * w;
            }
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
