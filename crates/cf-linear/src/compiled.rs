//! The door: a solver for one operator, compiled once.
//!
//! There are two precisions and two dimensions, so that all solvers there are can be compiled here, behind one virtual
//! call per solve. A crate that is generic over both would otherwise compile the whole of multigrid again, for every
//! set of vector registers.

use std::any::Any;

use cf_grid::Real;

use crate::error::SolveError;
use crate::helmholtz::Helmholtz;
use crate::plan::Choice;
use crate::solver::{Core, Options};
use crate::stop::{Deviation, Statistics, Stop};

/// Solver of A x = b for one [`Helmholtz`] operator. Vectors are fields of its layout. Everything is allocated here; a
/// solve allocates nothing that grows with the grid, but a few numbers per pocket of a mask; the first
/// [`improve`](Self::improve) adds two vectors.
pub struct Solver<T, const D: usize>(Box<dyn Solve<T, D>>);

impl<T: Real, const D: usize> Solver<T, D> {
    /// Builds plan, hierarchy and scratch. Fails with [`SolveError::Coefficient`] where a number is negative, not finite
    /// or too large to add up, and with [`SolveError::Length`] where a mask or shares have another layout.
    pub fn new(helmholtz: &Helmholtz<'_, D>, options: Options) -> Result<Self, SolveError> {
        let single = T::NAME == f32::NAME;
        // A layout of another dimension does not exist, nor does a third precision.
        let none = || SolveError::Length { what: "a layout", expected: 2, found: D };
        let made: Box<dyn Any> = match D {
            2 => {
                let helmholtz = helmholtz.as_dimension::<2>().ok_or_else(none)?;
                if single {
                    Box::new(plane_single(&helmholtz, options)?)
                } else {
                    Box::new(plane(&helmholtz, options)?)
                }
            }
            _ => {
                let helmholtz = helmholtz.as_dimension::<3>().ok_or_else(none)?;
                if single {
                    Box::new(space_single(&helmholtz, options)?)
                } else {
                    Box::new(space(&helmholtz, options)?)
                }
            }
        };
        Ok(Self(*made.downcast::<Box<dyn Solve<T, D>>>().map_err(|_| none())?))
    }

    /// The plan and why.
    pub fn choice(&self) -> &Choice {
        self.0.choice()
    }

    /// Levels of the hierarchy; 1 where there is none.
    pub fn levels(&self) -> usize {
        self.0.levels()
    }

    /// Bytes held: vectors, hierarchy, stored coefficients.
    pub fn bytes(&self) -> usize {
        self.0.bytes()
    }

    /// y = A x in the units of the caller; the rim of `x` is overwritten along periodic axes. For checks and reports.
    pub fn apply(&self, x: &mut [T], y: &mut [T]) {
        self.0.apply(x, y);
    }

    /// z = M r, the preconditioner as an operator, for tests of its symmetry; the identity for plans without one.
    pub fn precondition(&mut self, r: &[T], z: &mut [T]) {
        self.0.precondition(r, z);
    }

    /// Solves A x = b from a zero guess: x is overwritten, its rim zero behind walls and wrapped along
    /// periodic axes.
    ///
    /// Fails with [`SolveError::NotFinite`] for a right-hand side that is not finite or a solution too large for `T`,
    /// with [`SolveError::NotConverged`] if the criterion is met neither within the limit nor by the rounding floor.
    pub fn solve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        self.0.solve(b, x, stop)
    }

    /// Solves A x = b for the parts of x = constants + factor · y; `y` is overwritten, its rim is zero or wrapped. The
    /// vectors inside are of unit size, so neither tiny nor huge b and kappa under- or overflow in `f32`. Fails as
    /// [`solve`](Self::solve) does.
    pub fn solve_deviation(&mut self, b: &[T], y: &mut [T], stop: Stop) -> Result<Deviation, SolveError> {
        self.0.solve_deviation(b, y, stop)
    }

    /// Solves A x = b starting from the content of `x`; the criterion stays relative to b, and what is solved is
    /// A dx = b - A x. The rim of `x` and its solid cells are not read; solid cells are left alone. The statistics are
    /// those of the correction, but for `rhs`.
    pub fn improve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        self.0.improve(b, x, stop)
    }

    /// x = constants + factor · y, in place, with the rim wrapped along periodic axes.
    pub fn finish(&self, y: &mut [T], deviation: &Deviation) {
        self.0.finish(y, deviation);
    }

    /// x += constants, per component.
    pub fn add_constants(&self, x: &mut [T], deviation: &Deviation) {
        self.0.add_constants(x, deviation);
    }

    /// The rounding floor of max|r| for a solution of this size, 8 eps (alpha + 4 D kappa) max|x|, with 2 D kappa
    /// replaced by the largest sum of conductances.
    pub fn floor(&self, largest: f64) -> f64 {
        self.0.floor(largest)
    }
}

fn plane_single(helmholtz: &Helmholtz<'_, 2>, options: Options) -> Result<Box<dyn Solve<f32, 2>>, SolveError> {
    Ok(Box::new(Core::new(helmholtz, options)?))
}

fn plane(helmholtz: &Helmholtz<'_, 2>, options: Options) -> Result<Box<dyn Solve<f64, 2>>, SolveError> {
    Ok(Box::new(Core::new(helmholtz, options)?))
}

fn space_single(helmholtz: &Helmholtz<'_, 3>, options: Options) -> Result<Box<dyn Solve<f32, 3>>, SolveError> {
    Ok(Box::new(Core::new(helmholtz, options)?))
}

fn space(helmholtz: &Helmholtz<'_, 3>, options: Options) -> Result<Box<dyn Solve<f64, 3>>, SolveError> {
    Ok(Box::new(Core::new(helmholtz, options)?))
}

/// A [`Solver`] without its types.
trait Solve<T, const D: usize>: Send + Sync {
    fn choice(&self) -> &Choice;
    fn levels(&self) -> usize;
    fn bytes(&self) -> usize;
    fn apply(&self, x: &mut [T], y: &mut [T]);
    fn precondition(&mut self, r: &[T], z: &mut [T]);
    fn solve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError>;
    fn solve_deviation(&mut self, b: &[T], y: &mut [T], stop: Stop) -> Result<Deviation, SolveError>;
    fn improve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError>;
    fn finish(&self, y: &mut [T], deviation: &Deviation);
    fn add_constants(&self, x: &mut [T], deviation: &Deviation);
    fn floor(&self, largest: f64) -> f64;
}

impl<T: Real, const D: usize> Solve<T, D> for Core<T, D> {
    fn choice(&self) -> &Choice {
        self.choice()
    }

    fn levels(&self) -> usize {
        self.levels()
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn apply(&self, x: &mut [T], y: &mut [T]) {
        self.apply(x, y);
    }

    fn precondition(&mut self, r: &[T], z: &mut [T]) {
        self.precondition(r, z);
    }

    fn solve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        self.solve(b, x, stop)
    }

    fn solve_deviation(&mut self, b: &[T], y: &mut [T], stop: Stop) -> Result<Deviation, SolveError> {
        self.solve_deviation(b, y, stop)
    }

    fn improve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        self.improve(b, x, stop)
    }

    fn finish(&self, y: &mut [T], deviation: &Deviation) {
        self.finish(y, deviation);
    }

    fn add_constants(&self, x: &mut [T], deviation: &Deviation) {
        self.add_constants(x, deviation);
    }

    fn floor(&self, largest: f64) -> f64 {
        self.floor(largest)
    }
}
