//! `phi` on a box of cells of any dimension, for measuring.

use crate::scene::Grid;

/// Values at cell centres, x fastest.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub cells: Vec<usize>,
    pub origin: Vec<f64>,
    pub h: f64,
    pub phi: Vec<f64>,
}

impl Sample {
    pub fn new(grid: &Grid, phi: Vec<f64>) -> Self {
        Sample { cells: grid.cells.to_vec(), origin: grid.origin.to_vec(), h: grid.spacing, phi }
    }

    pub fn dimension(&self) -> usize {
        self.cells.len()
    }

    /// The centre of the cells with index `i` along an axis.
    pub fn centre(&self, axis: usize, i: usize) -> f64 {
        self.origin[axis] + (i as f64 + 0.5) * self.h
    }

    /// The centre of a cell by its number.
    pub fn centre_of(&self, mut number: usize) -> [f64; 3] {
        let mut centre = [0.0; 3];
        for (axis, n) in self.cells.iter().enumerate() {
            centre[axis] = self.centre(axis, number % n);
            number /= n;
        }
        centre
    }

    /// The value at a point, linear between centres; `None` beyond the outermost centres.
    pub fn at(&self, point: &[f64]) -> Option<f64> {
        let (mut low, mut part) = ([0usize; 3], [0.0; 3]);
        for (axis, n) in self.cells.iter().enumerate() {
            let place = (point[axis] - self.origin[axis]) / self.h - 0.5;
            // A point meant to be a centre may miss it by rounding.
            let place = if (place - place.round()).abs() < 1e-6 { place.round() } else { place };
            if !(0.0..=(n - 1) as f64).contains(&place) {
                return None;
            }
            low[axis] = place as usize;
            part[axis] = place - place.floor();
        }
        let mut sum = 0.0;
        for corner in 0..1usize << self.dimension() {
            let (mut number, mut stride, mut weight) = (0, 1, 1.0);
            for (axis, n) in self.cells.iter().enumerate() {
                let up = corner >> axis & 1;
                weight *= if up == 1 { part[axis] } else { 1.0 - part[axis] };
                number += stride * (low[axis] + up).min(n - 1);
                stride *= n;
            }
            if weight > 0.0 {
                sum += weight * self.phi.get(number)?;
            }
        }
        Some(sum)
    }

    /// The mean of a function of the place, weighted by |phi|; `None` where there is nothing.
    fn mean(&self, f: impl Fn([f64; 3]) -> f64) -> Option<f64> {
        let total: f64 = self.phi.iter().map(|value| value.abs()).sum();
        let sum: f64 = self.phi.iter().enumerate().map(|(i, value)| value.abs() * f(self.centre_of(i))).sum();
        (total > 0.0).then(|| sum / total)
    }

    /// The centre of |phi|; `None` where there is nothing.
    pub fn centre_of_mass(&self) -> Option<[f64; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| self.mean(|x| x[axis]));
        Some([x?, y?, z?])
    }

    /// Root mean square distance of |phi| from its centre; `None` where there is nothing.
    pub fn radius_of_gyration(&self) -> Option<f64> {
        self.radius_about(None)
    }

    /// The same, without the distance along an axis.
    pub fn radius_about(&self, axis: Option<usize>) -> Option<f64> {
        let centre = self.centre_of_mass()?;
        let across = |x: [f64; 3]| (0..3).filter(|a| Some(*a) != axis).map(|a| (x[a] - centre[a]).powi(2)).sum();
        self.mean(across).map(f64::sqrt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_between_centres_are_linear() {
        let phi = (0..12).map(|i| (i % 4) as f64 + 10.0 * (i / 4) as f64).collect();
        let sample = Sample { cells: vec![4, 3], origin: vec![1.0, 0.0], h: 0.5, phi };
        assert_eq!(sample.at(&[1.25, 0.25]), Some(0.0));
        assert_eq!(sample.at(&[2.75, 1.25]), Some(23.0));
        assert!((sample.at(&[1.6, 0.5]).unwrap() - (0.7 + 5.0)).abs() < 1e-12);
        assert_eq!((sample.at(&[1.2, 0.5]), sample.at(&[1.5, 1.3])), (None, None));
    }

    #[test]
    fn a_square_has_its_radius() {
        let sample = Sample { cells: vec![64, 64], origin: vec![0.0, 0.0], h: 1.0 / 64.0, phi: vec![-2.0; 4096] };
        assert!((sample.radius_of_gyration().unwrap() - (1.0f64 / 6.0).sqrt()).abs() < 1e-3);
        assert!((sample.radius_about(Some(0)).unwrap() - (1.0f64 / 12.0).sqrt()).abs() < 1e-3);
        let empty = Sample { phi: vec![0.0; 4096], ..sample };
        assert_eq!(empty.radius_of_gyration(), None);
    }
}
