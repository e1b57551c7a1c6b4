//! Which solver, and why: a pure function of the operator's numbers and the tolerance.

use std::fmt;

use crate::chebyshev;

/// A solver choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plan {
    /// kappa = 0 and no conducting wall: x = b/alpha.
    Diagonal,
    /// Chebyshev iteration on the diagonally scaled operator; the iteration count is known beforehand.
    Chebyshev,
    /// PCG with one V(1,1) cycle.
    Multigrid,
}

/// A plan with the reason for it, for reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The plan.
    pub plan: Plan,
    /// One sentence.
    pub reason: String,
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.plan, self.reason)
    }
}

/// Passes over the data of one Chebyshev iteration, start and end of the solve included, as `cargo xtask bench solver` measures
/// where two threads stream 45 GB/s; of both only the ratio counts.
const CHEBYSHEV_PASSES: f64 = 6.0;
/// The same of one PCG + V(1,1) iteration.
const MULTIGRID_PASSES: f64 = 23.0;

impl Plan {
    /// Passes over the data of one iteration, as [`choose`](Self::choose) counts them.
    pub fn passes(self) -> f64 {
        match self {
            Plan::Diagonal => 2.0,
            Plan::Chebyshev => CHEBYSHEV_PASSES,
            Plan::Multigrid => MULTIGRID_PASSES,
        }
    }

    /// Chooses by predicted passes over the data for a residual reduction of `tolerance` (docs/solver.md).
    /// `alpha` and `kappa` as in [`Helmholtz`](crate::Helmholtz); `wall` is the largest wall conductance.
    pub fn choose(dimension: usize, alpha: f64, kappa: f64, wall: f64, tolerance: f64) -> Choice {
        if kappa == 0.0 && wall == 0.0 {
            return Choice { plan: Plan::Diagonal, reason: "kappa = 0: the operator is alpha".into() };
        }
        let digits = -tolerance.clamp(1e-16, 0.5).log10();
        let multigrid = MULTIGRID_PASSES * (1.0 + digits * multigrid_rate(kappa / alpha));
        if alpha > 0.0 {
            // The largest diagonal counts, and a wall may conduct more than an inner face.
            let strength = 0.5 * (kappa + kappa.max(wall));
            let count = chebyshev_count(dimension, alpha, strength, tolerance);
            let passes = CHEBYSHEV_PASSES * count as f64;
            if strength <= 4.0 * alpha && passes <= multigrid {
                return Choice {
                    plan: Plan::Chebyshev,
                    reason: format!(
                        "kappa = {:.2e} is small: {count} iterations known beforehand, {passes:.0} passes against {multigrid:.0}",
                        kappa / alpha
                    ),
                };
            }
        }
        let reason = if alpha == 0.0 {
            "a Poisson problem needs the coarse levels".into()
        } else {
            format!("kappa = {:.2e}: about {multigrid:.0} passes whatever the size", kappa / alpha)
        };
        Choice { plan: Plan::Multigrid, reason }
    }
}

/// Iterations per digit of PCG + V(1,1) (4 to 8 for six digits).
fn multigrid_rate(kappa: f64) -> f64 {
    match kappa {
        k if k < 0.05 => 0.4,
        k if k < 0.5 => 0.75,
        _ => 1.2,
    }
}

/// N = acosh(1/tol)/acosh(1 + alpha/(2 d kappa)): iterations of Chebyshev on [alpha, alpha + 4 d kappa] (Golub and
/// Varga 1961).
pub fn chebyshev_count(dimension: usize, alpha: f64, kappa: f64, tolerance: f64) -> usize {
    chebyshev::count(chebyshev::radius(alpha, 2.0 * dimension as f64 * kappa), tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_follow_kappa() {
        assert_eq!(Plan::choose(3, 1.0, 0.0, 0.0, 1e-6).plan, Plan::Diagonal);
        assert_eq!(Plan::choose(3, 1.0, 0.01, 0.0, 1e-6).plan, Plan::Chebyshev);
        assert_eq!(Plan::choose(3, 1.0, 100.0, 0.0, 1e-6).plan, Plan::Multigrid);
        assert_eq!(Plan::choose(2, 0.0, 1.0, 0.0, 1e-6).plan, Plan::Multigrid);
    }

    #[test]
    fn chebyshev_counts_are_those_measured() {
        // In two dimensions to 1e-6: 4 at kappa .01, 8 at .1, 21 at 1.
        for (kappa, expected) in [(0.01, 4), (0.1, 8), (1.0, 21)] {
            let n = chebyshev_count(2, 1.0, kappa, 1e-6);
            assert!(n.abs_diff(expected) <= 1, "kappa {kappa}: {n}");
        }
    }
}
