//! The slope limiter of the MUSCL schemes.

use cf_grid::Real;

/// Twice the slope of a cell from its one-sided differences `a` and `b`, limited by MC: their sum, at most four times
/// the smaller, 0 at an extremum.
#[inline(always)]
pub(crate) fn slope2<T: Real>(a: T, b: T) -> T {
    let four = T::of(4.0);
    let most = (four * a.min(b)).max(T::ZERO);
    let least = (four * a.max(b)).min(T::ZERO);
    (a + b).min(most).max(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_limited() {
        for ((a, b), expected) in [((1.0, 2.0), 3.0), ((-2.0, -1.0), -3.0), ((1.0, 9.0), 4.0), ((-9.0, -1.0), -4.0)] {
            assert_eq!(slope2(a, b), expected);
        }
        assert_eq!(slope2(-1.0, 2.0), 0.0);
    }
}
