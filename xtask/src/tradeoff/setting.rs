//! What is turned, and what came of it.

use crate::bench::Numbers;
use std::fmt;

/// How time is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// The paper's backward Euler.
    PaperBe,
    /// Two implicit stages, second order.
    Sdirk2,
    /// Explicit leapfrog, F_T = 0.
    Kdk,
    /// Characteristic MUSCL, F_T = 0.
    Front,
    /// Transforms, exact in time.
    Spectral,
}

/// One choice of every knob but the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The integrator.
    pub scheme: Scheme,
    /// Equal steps to the end.
    pub steps: usize,
    /// Precision of state and solver.
    pub numbers: Numbers,
    /// eta of the solves.
    pub tolerance: f64,
    /// Worker threads.
    pub threads: usize,
}

impl Setting {
    /// Double precision and the tolerance of the standard preset.
    pub fn new(scheme: Scheme, steps: usize, threads: usize) -> Self {
        Self { scheme, steps, numbers: Numbers::F64, tolerance: 1e-5, threads }
    }

    /// Whether the standard preset could choose it (model/diffusion.md 7).
    pub fn is_standard(&self) -> bool {
        matches!(self.scheme, Scheme::Sdirk2 | Scheme::Kdk) && self.tolerance == 1e-5
    }
}

/// What a setting did on a problem. Errors are relative to the solution unless named otherwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The problem, without the grid.
    pub problem: String,
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// The knobs.
    pub setting: Setting,
    /// sqrt(k/tau) dt/h; not a number for tau = 0.
    pub courant: f64,
    /// |phi - exact|_2 / |exact|_2, in space and time.
    pub error: f64,
    /// The same against the solution that is discrete in space and exact in time.
    pub time_error: f64,
    /// The same as `error` in the 1-norm.
    pub one: f64,
    /// Largest |phi - exact| over the largest |exact|.
    pub worst: f64,
    /// How far phi exceeds the largest exact value, over that.
    pub overshoot: f64,
    /// Change of the mass over sum|phi|.
    pub drift: f64,
    /// On a front in one dimension: cells from 90 % to 10 % of the jump.
    pub width: f64,
    /// On a front in one dimension: the largest rise of phi, which should only fall, over the jump.
    pub ringing: f64,
    /// Solver iterations of all steps.
    pub iterations: usize,
    /// Median wall time \[s\], with everything but the initial values.
    pub seconds: f64,
    /// Timed runs.
    pub runs: usize,
}

impl Measured {
    /// The knobs in words.
    pub fn words(&self) -> String {
        let Setting { scheme, steps, numbers, tolerance, threads } = self.setting;
        let cells = crate::show::cells(&self.cells);
        let solve = match scheme {
            Scheme::PaperBe | Scheme::Sdirk2 => format!(", tolerance {tolerance:e}"),
            _ => String::new(),
        };
        let plural = |n| if n == 1 { "" } else { "s" };
        format!(
            "{scheme}, {cells}, {steps} step{}, {numbers}{solve}, {threads} thread{}",
            plural(steps),
            plural(threads)
        )
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Scheme::PaperBe => "PaperBe",
            Scheme::Sdirk2 => "Sdirk2",
            Scheme::Kdk => "Kdk",
            Scheme::Front => "Front",
            Scheme::Spectral => "Spectral",
        })
    }
}

/// The measurements that no other beats in both error and time, cheapest first.
pub fn best(all: &[&Measured]) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = all.iter().map(|m| [m.seconds, m.error]).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut least = f64::INFINITY;
    points.retain(|p| {
        let better = p[1] < least;
        least = least.min(p[1]);
        better
    });
    points
}

/// The cheapest measurement with at most this error.
pub fn cheapest<'a>(all: impl Iterator<Item = &'a Measured>, error: f64) -> Option<&'a Measured> {
    all.filter(|m| m.error <= error).min_by(|a, b| a.seconds.total_cmp(&b.seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_nothing_beats_stays() {
        let measured = |seconds, error| Measured {
            problem: String::new(),
            cells: vec![],
            setting: Setting::new(Scheme::Kdk, 1, 1),
            courant: 1.0,
            error,
            time_error: error,
            one: error,
            worst: error,
            overshoot: 0.0,
            drift: 0.0,
            width: f64::NAN,
            ringing: f64::NAN,
            iterations: 0,
            seconds,
            runs: 3,
        };
        let all =
            [measured(3.0, 0.1), measured(1.0, 0.5), measured(2.0, 0.6), measured(4.0, 0.1), measured(0.5, f64::NAN)];
        assert_eq!(best(&all.iter().collect::<Vec<_>>()), [[1.0, 0.5], [3.0, 0.1]]);
        assert_eq!(cheapest(all.iter(), 0.2).map(|m| m.seconds), Some(3.0));
        assert_eq!(cheapest(all.iter(), 0.01), None);
    }
}
