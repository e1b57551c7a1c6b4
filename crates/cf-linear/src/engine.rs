//! What a [`Solver`](crate::Solver) holds: the operator alone, or with a V-cycle in the same or in single precision.

use cf_grid::{CellField, Layout, Real};

use crate::helmholtz::Helmholtz;
use crate::level::LevelOperator;
use crate::multigrid::Multigrid;
use crate::plan::Plan;
use crate::solver::Precision;

/// Operator and preconditioner, with the vector z = M r in the precision of M.
pub(crate) enum Engine<T, const D: usize> {
    /// Diagonal and Chebyshev: only the operator.
    Plain(Box<LevelOperator<T, D>>),
    Same {
        multigrid: Box<Multigrid<T, D>>,
        z: CellField<T>,
    },
    Single {
        multigrid: Box<Multigrid<f32, D>>,
        operator: Box<LevelOperator<T, D>>,
        z: CellField<f32>,
    },
}

impl<T: Real, const D: usize> Engine<T, D> {
    pub fn new(helmholtz: &Helmholtz<'_, D>, plan: Plan, precision: Precision) -> Self {
        let operator = || Box::new(helmholtz.level());
        match (plan, precision) {
            (Plan::Diagonal | Plan::Chebyshev, _) => Self::Plain(operator()),
            (Plan::Multigrid, Precision::Full) => {
                Self::Same { multigrid: Box::new(Multigrid::new(helmholtz)), z: CellField::new(helmholtz.layout()) }
            }
            (Plan::Multigrid, Precision::Single) => Self::Single {
                multigrid: Box::new(if T::NAME == f32::NAME {
                    Multigrid::new(helmholtz)
                } else {
                    Multigrid::new(helmholtz).with_copies()
                }),
                operator: operator(),
                z: CellField::new(helmholtz.layout()),
            },
        }
    }

    pub fn operator(&self) -> &LevelOperator<T, D> {
        match self {
            Self::Plain(operator) | Self::Single { operator, .. } => operator,
            Self::Same { multigrid, .. } => multigrid.finest(),
        }
    }

    /// Calls `f` with z and the vectors of the cycle, where they have the precision of the solver's vectors.
    pub fn each_vector(&mut self, mut f: impl FnMut(&Layout<D>, &mut CellField<T>)) {
        if let Self::Same { multigrid, z } = self {
            let layout = multigrid.finest().layout;
            f(&layout, z);
            multigrid.each_vector(f);
        }
    }

    pub fn levels(&self) -> usize {
        match self {
            Self::Plain(_) => 1,
            Self::Same { multigrid, .. } => multigrid.levels(),
            Self::Single { multigrid, .. } => multigrid.levels(),
        }
    }

    pub fn bytes(&self) -> usize {
        match self {
            Self::Plain(operator) => operator.bytes(),
            Self::Same { multigrid, z } => multigrid.bytes() + z.bytes(),
            Self::Single { multigrid, operator, z } => multigrid.bytes() + operator.bytes() + z.bytes(),
        }
    }
}
