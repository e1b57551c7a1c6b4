//! Fields on coarser grids of the same box, whose cells are 2^n times as large: which cell has which in it, means, differences.

/// The index of the cell that has the cell `index` in it; both count x fastest.
pub(crate) fn above(index: usize, fine: &[usize], coarse: &[usize]) -> usize {
    let (mut rest, mut stride, mut above) = (index, 1, 0);
    for (n, m) in fine.iter().zip(coarse) {
        above += stride * (rest % n / (n / m));
        (rest, stride) = (rest / n, stride * m);
    }
    above
}

/// Means of `values` over the coarse cells.
pub(crate) fn means(values: &[f64], fine: &[usize], coarse: &[usize]) -> Vec<f64> {
    let count: usize = coarse.iter().product();
    let mut means = vec![0.0; count];
    let share = count as f64 / values.len() as f64;
    for (index, value) in values.iter().enumerate() {
        means[above(index, fine, coarse)] += share * value;
    }
    means
}

/// In the mean square, relative to the second of each pair; 0 where both are 0.
pub(crate) fn difference(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (off, size) = pairs.fold((0.0, 0.0), |(off, size), (a, b)| (off + (a - b) * (a - b), size + b * b));
    if off == 0.0 { 0.0 } else { (off / size).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_the_cells_inside() {
        let phi: Vec<f64> = (0..16).map(f64::from).collect();
        assert_eq!(means(&phi, &[4, 4], &[2, 2]), [2.5, 4.5, 10.5, 12.5]);
        assert_eq!(means(&phi, &[4, 4], &[1, 1]), [7.5]);
        assert_eq!(means(&phi[..8], &[2, 2, 2], &[1, 1, 1]), [3.5]);
        assert_eq!(means(&phi[..8], &[8, 1], &[2, 1]), [1.5, 5.5]);
    }

    #[test]
    fn differences_are_relative() {
        assert_eq!(difference([(1.0, 1.0), (0.0, 1.0)].into_iter()), 0.5f64.sqrt());
        assert_eq!(difference([(0.0, 0.0)].into_iter()), 0.0);
        assert_eq!(difference([(1.0, 0.0)].into_iter()), f64::INFINITY);
    }
}
