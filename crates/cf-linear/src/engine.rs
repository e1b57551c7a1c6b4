//! What a [`Solver`](crate::Solver) holds: the operator alone, or with a V-cycle in the same or in single precision.

use cf_grid::{Layout, Real};

use crate::helmholtz::Helmholtz;
use crate::level::LevelOperator;
use crate::multigrid::{Below, Multigrid};
use crate::pcg::Preconditioner;
use crate::plan::Plan;
use crate::solver::Precision;

/// Operator and preconditioner.
pub(crate) enum Engine<T, const D: usize> {
    /// Diagonal and Chebyshev: only the operator.
    Plain(Box<LevelOperator<T, D>>),
    Same(Box<Multigrid<T, D>>),
    Single {
        operator: Box<LevelOperator<T, D>>,
        cycle: Box<SingleCycle<D>>,
    },
}

impl<T: Real, const D: usize> Engine<T, D> {
    pub fn new(helmholtz: &Helmholtz<'_, D>, plan: Plan, precision: Precision) -> Self {
        match (plan, precision) {
            (Plan::Diagonal | Plan::Chebyshev, _) => Self::Plain(Box::new(helmholtz.level())),
            (Plan::Multigrid, Precision::Full) => Self::Same(Box::new(Multigrid::new(helmholtz))),
            (Plan::Multigrid, Precision::Single) => {
                Self::Single { operator: Box::new(helmholtz.level()), cycle: Box::new(SingleCycle::new(helmholtz)) }
            }
        }
    }

    pub fn operator(&self) -> &LevelOperator<T, D> {
        match self {
            Self::Plain(o) => o,
            Self::Same(m) => m.finest(),
            Self::Single { operator, .. } => operator,
        }
    }

    /// Operator and preconditioner apart; `None` where there is no preconditioner.
    pub fn preconditioned(&mut self) -> Option<(&LevelOperator<T, D>, Cycle<'_, T, D>)> {
        match self {
            Self::Plain(_) => None,
            Self::Same(m) => {
                let (operator, below) = m.split();
                Some((operator, Cycle::Same(below)))
            }
            Self::Single { operator, cycle } => Some((operator, Cycle::Single(cycle))),
        }
    }

    pub fn levels(&self) -> usize {
        match self {
            Self::Plain(_) => 1,
            Self::Same(m) => m.levels(),
            Self::Single { cycle, .. } => cycle.multigrid.levels(),
        }
    }

    pub fn bytes(&self) -> usize {
        match self {
            Self::Plain(o) => o.bytes(),
            Self::Same(m) => m.bytes(),
            Self::Single { operator, cycle } => {
                operator.bytes() + cycle.multigrid.bytes() + 3 * cycle.layout.slots() * size_of::<f32>()
            }
        }
    }
}

/// A borrowed preconditioner.
pub(crate) enum Cycle<'a, T, const D: usize> {
    Same(Below<'a, T, D>),
    Single(&'a mut SingleCycle<D>),
}

impl<T: Real, const D: usize> Preconditioner<T> for Cycle<'_, T, D> {
    fn precondition(&mut self, r: &[T], largest: f64, z: &mut [T], scratch: &mut [T]) {
        match self {
            Cycle::Same(m) => m.cycle(r, z, scratch),
            Cycle::Single(s) => s.precondition(r, largest, z),
        }
    }
}

/// An `f32` hierarchy with vectors of its own.
pub(crate) struct SingleCycle<const D: usize> {
    multigrid: Multigrid<f32, D>,
    b: Vec<f32>,
    x: Vec<f32>,
    scratch: Vec<f32>,
    layout: Layout<D>,
}

impl<const D: usize> SingleCycle<D> {
    fn new(helmholtz: &Helmholtz<'_, D>) -> Self {
        let layout = *helmholtz.layout();
        let field = || vec![0.0; layout.slots()];
        Self { multigrid: Multigrid::new(helmholtz), b: field(), x: field(), scratch: field(), layout }
    }

    /// z = M r, with r scaled to unit size on the way in.
    fn precondition<T: Real>(&mut self, r: &[T], largest: f64, z: &mut [T]) {
        let cells = self.layout.cells_region();
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let inverse = 1.0 / unit;
        self.layout.par_runs(cells, &mut self.b[..], |run, b: &mut [f32]| {
            for (b, &r) in b.iter_mut().zip(run.row(r)) {
                *b = (r.f64() * inverse) as f32;
            }
        });
        self.multigrid.cycle(&self.b, &mut self.x, &mut self.scratch);
        let x = &self.x[..];
        self.layout.par_runs(cells, z, |run, z: &mut [T]| {
            for (z, &x) in z.iter_mut().zip(run.row(x)) {
                *z = T::of(f64::from(x) * unit);
            }
        });
    }
}
