//! Our solver and another one in turn on the same problems, so that what else the machine does meets both.

use super::hypre::{self, Hypre, Missing};
use super::problem::Problem;
use super::solver::{self, Measured};
use crate::cli::SolverArgs;
use crate::failure::Failure;
use std::path::{Path, PathBuf};

/// How far the norms of two solutions may be apart, in tolerances: far below what a wrong wall makes, 10 times what was
/// ever seen.
const APART: f64 = 100.0;

/// Both on one problem.
pub struct Comparison {
    pub ours: Measured,
    pub theirs: Measured,
}

/// Where peers are compiled.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/peers")
}

/// The peer, ready to run.
pub fn prepare(asked: &SolverArgs) -> Result<Result<Hypre, Missing>, Failure> {
    Hypre::build(asked.mpicc.as_deref().unwrap_or(Path::new("mpicc")), &folder())
}

/// Ours, theirs, ours, theirs: each `runs` times, each from the start. What they cannot do costs only their row.
pub fn compare(
    hypre: &Hypre,
    problem: &Problem,
    runs: usize,
) -> Result<(Measured, Result<Measured, Failure>), Failure> {
    let (mut ours, mut theirs) = (Vec::new(), Ok(Vec::new()));
    for _ in 0..runs {
        ours.push(solver::turn(problem, 0)?);
        if let Ok(turns) = &mut theirs {
            match hypre.turn(problem) {
                Ok(turn) => turns.push(turn),
                Err(failure) => theirs = Err(failure),
            }
        }
    }
    let method = solver::method(&ours);
    let measured = |method, turns| Measured { problem: problem.clone(), method, turns };
    Ok((measured(method, ours), theirs.map(|turns| measured(hypre::METHOD.into(), turns))))
}

impl Comparison {
    /// Times that theirs takes longer, for the solve.
    pub fn ratio(&self) -> f64 {
        self.theirs.median(|turn| turn.seconds) / self.ours.median(|turn| turn.seconds)
    }

    /// The same from nothing: with set-up and what new memory costs.
    pub fn ratio_with_setup(&self) -> f64 {
        let whole = |measured: &Measured| measured.median(|turn| turn.setup_seconds + turn.new_seconds + turn.seconds);
        whole(&self.theirs) / whole(&self.ours)
    }

    /// Difference of the norms of the solutions, relative.
    pub fn apart(&self) -> f64 {
        let [ours, theirs] = [&self.ours, &self.theirs].map(|measured| measured.median(|turn| turn.norm));
        (ours - theirs).abs() / theirs
    }

    /// Refuses to compare times where not the same was solved as well.
    pub fn check(&self) -> Result<(), Failure> {
        let problem = &self.ours.problem;
        let tolerance = problem.tolerance.0;
        for measured in [&self.ours, &self.theirs] {
            measured.check()?;
        }
        let apart = self.apart();
        if apart.is_nan() || apart > APART * tolerance {
            return Err(Failure::failed(format!("{problem}: the solutions differ by {apart:.1e}")));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::problem::{Cells, Numbers, Solids, Strength, Tolerance, Walls};
    use crate::bench::solver::{Status, Turn};

    fn measured(norm: f64, residual: f64, seconds: f64) -> Measured {
        let (strength, tolerance, numbers) = (Strength::Poisson, Tolerance(1e-6), Numbers::F64);
        let problem = Problem {
            cells: Cells(vec![8, 8]),
            walls: Walls::Closed,
            solids: Solids::Open,
            strength,
            tolerance,
            numbers,
            threads: 1,
        };
        let turn = Turn {
            iterations: 5,
            seconds,
            setup_seconds: 0.75,
            new_seconds: 0.25,
            bytes: 1.0,
            residual,
            rounding: 1e-15,
            norm,
            plan: None,
            kernels: Vec::new(),
        };
        Measured { problem, method: "a method".into(), turns: vec![turn] }
    }

    #[test]
    fn times_are_compared_only_for_the_same_solution() {
        let compared =
            |norm, residual| Comparison { ours: measured(1.0, 1e-7, 2.0), theirs: measured(norm, residual, 5.0) };
        let same = compared(1.0 + 1e-6, 9e-7);
        assert!(same.check().is_ok());
        assert_eq!((same.ratio(), same.ratio_with_setup()), (2.5, 2.0));
        assert!(compared(1.01, 9e-7).check().is_err());
        assert!(compared(1.0, 1e-5).check().is_err());
        assert_eq!(
            [1e-7, 1e-5, f64::NAN].map(|r| measured(1.0, r, 1.0).status()),
            [Status::Met, Status::Missed, Status::Missed]
        );
        let mut rounded = measured(1.0, 1e-5, 1.0);
        rounded.turns[0].rounding = 2e-5;
        assert_eq!(rounded.status(), Status::Rounding);
        assert!(compared(f64::NAN, f64::NAN).check().is_err());
    }
}
