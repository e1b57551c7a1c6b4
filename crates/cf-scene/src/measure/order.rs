//! Convergence: distances to a reference and the power with which they shrink.

use super::cone::slope;
use super::sample::Sample;

/// The L2 distance of two fields relative to the second. A finer field is averaged over the cells of a coarser one.
pub(super) fn distance(a: &Sample, b: &Sample) -> Result<f64, String> {
    let (a, b) = (coarsened(a, b)?, coarsened(b, a)?);
    let (difference, norm) = a.iter().zip(&b).fold((0.0, 0.0), |(d, n), (a, b)| (d + (a - b) * (a - b), n + b * b));
    if norm > 0.0 { Ok((difference / norm).sqrt()) } else { Err("the reference is zero".into()) }
}

/// `fine` on the cells of `coarse`; unchanged if it is no finer.
fn coarsened(fine: &Sample, coarse: &Sample) -> Result<Vec<f64>, String> {
    let by = (coarse.h / fine.h).round().max(1.0) as usize;
    let wide = |sample: &Sample, axis: usize| sample.cells[axis] as f64 * sample.h;
    let same = fine.dimension() == coarse.dimension()
        && (0..fine.dimension()).all(|axis| {
            let length = wide(coarse, axis);
            (wide(fine, axis) - length).abs() < 1e-9 * length
                && (by == 1 || fine.cells[axis] == by * coarse.cells[axis])
                && (fine.cells[axis].is_multiple_of(coarse.cells[axis])
                    || coarse.cells[axis].is_multiple_of(fine.cells[axis]))
        });
    if !same {
        return Err("the grids do not fit into each other".into());
    }
    if by == 1 {
        return Ok(fine.phi.clone());
    }
    let mut sums = vec![0.0; coarse.phi.len()];
    for (number, value) in fine.phi.iter().enumerate() {
        let (mut rest, mut target, mut stride) = (number, 0, 1);
        for (n, m) in fine.cells.iter().zip(&coarse.cells) {
            target += stride * (rest % n / by);
            rest /= n;
            stride *= m;
        }
        sums[target] += value / by.pow(fine.dimension() as u32) as f64;
    }
    Ok(sums)
}

/// The power p of distance ~ parameter^p, fitted over the points.
pub(super) fn power(points: &[(f64, f64)]) -> Result<f64, String> {
    let positive = points.iter().all(|(parameter, distance)| *parameter > 0.0 && *distance > 0.0);
    let logs: Vec<(f64, f64)> = points.iter().map(|(parameter, distance)| (parameter.ln(), distance.ln())).collect();
    let power = slope(&logs);
    if positive && power.is_finite() { Ok(power) } else { Err("distances or parameters are zero".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_found() {
        let points: Vec<(f64, f64)> = [0.1, 0.05, 0.02].iter().map(|x: &f64| (*x, 3.0 * x.powf(1.5))).collect();
        assert!((power(&points).unwrap() - 1.5).abs() < 1e-12);
        assert!(power(&[(0.1, 0.0), (0.2, 1.0)]).is_err());
    }

    #[test]
    fn a_finer_field_is_averaged() {
        let coarse = Sample { cells: vec![2, 1], origin: vec![0.0; 2], h: 1.0, phi: vec![1.0, 3.0] };
        let phi = vec![0.0, 2.0, 3.0, 3.0, 1.0, 1.0, 2.0, 4.0];
        let fine = Sample { cells: vec![4, 2], origin: vec![0.0; 2], h: 0.5, phi };
        assert_eq!((distance(&fine, &coarse), distance(&coarse, &fine)), (Ok(0.0), Ok(0.0)));
        let shifted = Sample { phi: vec![2.0, 3.0], ..coarse.clone() };
        assert!((distance(&shifted, &coarse).unwrap() - 0.1f64.sqrt()).abs() < 1e-12);
        let other = Sample { cells: vec![3, 1], origin: vec![0.0; 2], h: 1.0, phi: vec![0.0; 3] };
        assert!(distance(&other, &coarse).is_err());
    }
}
