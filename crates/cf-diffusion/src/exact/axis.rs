//! The modes of −∇²_h along one axis of a box of cells.
//!
//! φ sits at cell centres and the difference quotient between neighbours on faces. At a closed wall the face carries
//! nothing; at a wall of value 0 the quotient reaches over half a cell. On a box the modes are products over the axes
//! and the eigenvalues add up. With s = 2/h:
//!
//! | walls | eigenvalue, m = 0..n−1 | vector at cell i |
//! |---|---|---|
//! | periodic | (s sin πm/n)² | cos 2πmi/n + sin 2πmi/n |
//! | closed, closed | (s sin πm/2n)² | cos πm(i+½)/n |
//! | valued, valued | (s sin π(m+1)/2n)² | sin π(m+1)(i+½)/n |
//! | closed, valued | (s sin π(m+½)/2n)² | cos π(m+½)(i+½)/n |
//! | valued, closed | (s sin π(m+½)/2n)² | sin π(m+½)(i+½)/n |

use std::f64::consts::{FRAC_PI_2, PI};

/// The two ends of an axis, low end first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walls {
    /// The last cell is the first one's neighbour.
    Periodic,
    /// No flux at either end.
    Closed,
    /// Value 0 at both ends.
    Valued,
    /// No flux at the low end, value 0 at the high end.
    ClosedValued,
    /// Value 0 at the low end, no flux at the high end.
    ValuedClosed,
}

/// Eigenvalues and eigenvectors of −∇²_h on an axis of `n` cells of width `h`.
///
/// ```text
///     −(f_{i+1} − 2 f_i + f_{i−1})/h² = Λ f_i                the vectors are orthonormal: Σ_i f_m(i) f_l(i) = δ_ml
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisModes {
    walls: Walls,
    cells: usize,
    h: f64,
}

impl AxisModes {
    /// The modes of `cells` cells (at most 2³²) of width `h` \[m\]. `None` without a cell, or if `h` is not a positive
    /// number.
    pub fn new(walls: Walls, cells: usize, h: f64) -> Option<AxisModes> {
        let countable = cells > 0 && cells as u64 <= 1 << 32;
        (countable && h > 0.0 && h.is_finite()).then_some(AxisModes { walls, cells, h })
    }

    /// How many modes there are, one per cell. They are numbered from 0.
    pub fn count(&self) -> usize {
        self.cells
    }

    /// Eigenvalue Λ_m \[1/m²\].
    pub fn eigenvalue(&self, m: usize) -> f64 {
        // A periodic axis of one cell has no difference to take: Λ = 0, as sin 0.
        let root = 2.0 * (FRAC_PI_2 * self.half_waves(m) / self.cells as f64).sin() / self.h;
        root * root
    }

    /// The largest eigenvalue \[1/m²\], which bounds an explicit step; below 4/h².
    pub fn largest(&self) -> f64 {
        self.eigenvalue(if self.walls == Walls::Periodic { self.cells / 2 } else { self.cells - 1 })
    }

    /// Vector m at the centre of cell `i`, x = (i + ½)h from the low end.
    pub fn vector(&self, m: usize, i: usize) -> f64 {
        let last = self.cells - 1;
        // The mean square of the shape is ½, except where every cell has the same modulus (periodic: the sum's is 1).
        let scale = match self.walls {
            Walls::Periodic => 1.0,
            Walls::Closed if m == 0 => 1.0,
            Walls::Valued if m == last => 1.0,
            _ => 2.0,
        };
        let phase = self.phase(m, i);
        let shape = match self.walls {
            Walls::Periodic => phase.cos() + phase.sin(),
            Walls::Closed | Walls::ClosedValued => phase.cos(),
            Walls::Valued | Walls::ValuedClosed => phase.sin(),
        };
        (scale / self.cells as f64).sqrt() * shape
    }

    /// Half waves of mode m along the axis.
    fn half_waves(&self, m: usize) -> f64 {
        match self.walls {
            Walls::Periodic => 2.0 * m as f64,
            Walls::Closed => m as f64,
            Walls::Valued => m as f64 + 1.0,
            Walls::ClosedValued | Walls::ValuedClosed => m as f64 + 0.5,
        }
    }

    /// The argument of sine and cosine, with whole turns taken out in integers so that no digits are lost.
    fn phase(&self, m: usize, i: usize) -> f64 {
        let n = self.cells as u128;
        // Indices beyond the axis continue it periodically; 4n is a whole number of periods for every wall.
        let (m, i) = (m as u128 % (4 * n), i as u128 % (4 * n));
        let (product, turn) = match self.walls {
            Walls::Periodic => (m * i, n),
            Walls::Closed => (m * (2 * i + 1), 4 * n),
            Walls::Valued => ((m + 1) * (2 * i + 1), 4 * n),
            Walls::ClosedValued | Walls::ValuedClosed => ((2 * m + 1) * (2 * i + 1), 8 * n),
        };
        2.0 * PI * ((product % turn) as f64 / turn as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Walls; 5] = [Walls::Periodic, Walls::Closed, Walls::Valued, Walls::ClosedValued, Walls::ValuedClosed];

    /// −∇²_h applied to `f`, written from the definition with ghost cells.
    fn minus_laplacian(walls: Walls, f: &[f64], h: f64) -> Vec<f64> {
        let n = f.len();
        let low = match walls {
            Walls::Periodic => f[n - 1],
            Walls::Closed | Walls::ClosedValued => f[0],
            Walls::Valued | Walls::ValuedClosed => -f[0],
        };
        let high = match walls {
            Walls::Periodic => f[0],
            Walls::Closed | Walls::ValuedClosed => f[n - 1],
            Walls::Valued | Walls::ClosedValued => -f[n - 1],
        };
        let at = |i: isize| {
            if i < 0 { low } else { *f.get(i as usize).unwrap_or(&high) }
        };
        (0..n as isize).map(|i| (2.0 * at(i) - at(i - 1) - at(i + 1)) / (h * h)).collect()
    }

    #[test]
    fn they_are_the_eigenvectors() {
        for walls in ALL {
            for n in [1, 2, 3, 7, 16, 33] {
                let axis = AxisModes::new(walls, n, 0.3).unwrap();
                for m in 0..n {
                    let f: Vec<f64> = (0..n).map(|i| axis.vector(m, i)).collect();
                    for (a, b) in minus_laplacian(walls, &f, 0.3).iter().zip(&f) {
                        assert!((a - axis.eigenvalue(m) * b).abs() < 1e-13 * 4.0 / 0.09, "{walls:?} {n} {m}");
                    }
                    assert!(axis.eigenvalue(m) <= axis.largest() * (1.0 + 1e-15));
                }
            }
        }
    }

    #[test]
    fn they_are_orthonormal() {
        for walls in ALL {
            for n in [1, 2, 9, 32] {
                let axis = AxisModes::new(walls, n, 1.0).unwrap();
                for (m, l) in (0..n).flat_map(|m| (0..n).map(move |l| (m, l))) {
                    let dot: f64 = (0..n).map(|i| axis.vector(m, i) * axis.vector(l, i)).sum();
                    assert!((dot - f64::from(u8::from(m == l))).abs() < 1e-13, "{walls:?} {n} {m} {l}");
                }
            }
        }
    }

    #[test]
    fn corners() {
        assert_eq!(AxisModes::new(Walls::Closed, 0, 1.0), None);
        assert_eq!(AxisModes::new(Walls::Closed, 4, f64::NAN), None);
        assert_eq!(AxisModes::new(Walls::Periodic, 1, 1.0).unwrap().eigenvalue(0), 0.0);
        // Any index has a value.
        assert!(AxisModes::new(Walls::Periodic, 4, 1.0).unwrap().vector(usize::MAX, usize::MAX).is_finite());
    }
}
