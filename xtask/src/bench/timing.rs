//! Times and what is made of several of them.

use crate::failure::Failure;
use std::time::Instant;

/// Runs `work` and gives its result with the seconds it took.
pub fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let begun = Instant::now();
    let done = work();
    (done, begun.elapsed().as_secs_f64())
}

/// The shortest of some runs \[s\].
pub fn best(runs: usize, mut work: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    let mut least = f64::INFINITY;
    for _ in 0..runs {
        let (done, seconds) = timed(&mut work);
        done?;
        least = least.min(seconds);
    }
    Ok(least)
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

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 8.0].into_iter()), 3.0);
        assert_eq!(median([3.0, 1.0, 8.0, 4.0].into_iter()), 3.5);
        assert!(median(std::iter::empty()).is_nan());
    }
}
