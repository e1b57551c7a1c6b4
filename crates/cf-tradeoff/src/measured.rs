//! What came of a setting, and the choice among many.

use crate::setting::Setting;

/// What a setting did on a problem. Errors are relative to the solution unless named otherwise; what has no meaning on a
/// problem is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The problem, without the grid.
    pub problem: String,
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// The knobs.
    pub setting: Setting,
    /// c dt/h; with transport alone, max|u_a| dt/h.
    pub courant: f64,
    /// |φ − exact|_2 / |exact|_2, in space and time.
    pub error: f64,
    /// The same against the solution that is discrete in space and exact in time.
    pub time_error: f64,
    /// The same as `error` in the 1-norm.
    pub one: f64,
    /// Largest |φ − exact| over the largest |exact|.
    pub worst: f64,
    /// How far φ exceeds the largest exact value, over the jump at the start where there is one, else over that value.
    pub overshoot: f64,
    /// Change of the mass over sum|φ|.
    pub drift: f64,
    /// On a front in one dimension: cells from 90 % to 10 % of the jump.
    pub width: f64,
    /// On a front in one dimension: the largest rise of φ, which should only fall, over the jump.
    pub ringing: f64,
    /// In a wake: the share of |φ| outside the cone by more than three standard deviations of the source.
    pub outside: f64,
    /// In a wake: the half angle that the ridges enclose with the flow \[degrees\].
    pub angle: f64,
    /// Solver iterations of all steps.
    pub iterations: usize,
    /// Median wall time \[s\], set-up included, initial values not.
    pub seconds: f64,
    /// Timed runs.
    pub runs: usize,
}

/// The measurements that no other beats in both error and time, cheapest first, as (seconds, error).
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

/// The middle one, or the mean of the two in the middle; not a number where there is none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let middle = |i: usize| sorted.get(i).copied().unwrap_or(f64::NAN);
    0.5 * (middle(sorted.len().saturating_sub(1) / 2) + middle(sorted.len() / 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scheme;

    fn measured(seconds: f64, error: f64) -> Measured {
        Measured {
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
            outside: f64::NAN,
            angle: f64::NAN,
            iterations: 0,
            seconds,
            runs: 3,
        }
    }

    #[test]
    fn only_what_nothing_beats_stays() {
        let all =
            [measured(3.0, 0.1), measured(1.0, 0.5), measured(2.0, 0.6), measured(4.0, 0.1), measured(0.5, f64::NAN)];
        assert_eq!(best(&all.iter().collect::<Vec<_>>()), [[1.0, 0.5], [3.0, 0.1]]);
        assert_eq!(cheapest(all.iter(), 0.2).map(|m| m.seconds), Some(3.0));
        assert_eq!(cheapest(all.iter(), 0.01), None);
    }

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 8.0].into_iter()), 3.0);
        assert_eq!(median([3.0, 1.0, 8.0, 4.0].into_iter()), 3.5);
        assert!(median(std::iter::empty()).is_nan());
    }
}
