//! A field between its values, at one point.

use cf_grid::{Real, array};

use crate::lattice::Lattice;

/// The integer below. Numbers without one give 0; huge ones the largest that leaves room for neighbours.
#[inline(always)]
pub(crate) fn floor(x: f64) -> i64 {
    let i = x.clamp(-1e15, 1e15) as i64;
    i - i64::from((i as f64) > x)
}

/// Lagrange weights of the points -1, 0, 1, 2 at `t` in [0, 1].
#[inline(always)]
pub(crate) fn cubic<T: Real>(t: T) -> [T; 4] {
    let (half, sixth) = (T::of(0.5), T::of(1.0 / 6.0));
    let (a, b, c) = (t + T::ONE, t - T::ONE, t - T::of(2.0));
    [-sixth * t * b * c, half * a * b * c, -half * a * t * c, sixth * a * t * b]
}

/// The value at `shift` \[cells\] from the value at `own`, with `K` = 2 (linear) or 4 (cubic) points per axis, and the
/// smallest and largest of the values that enclose the point.
#[inline(never)]
pub(crate) fn sample<T: Real, const D: usize, const K: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    own: [i64; D],
    shift: [T; D],
) -> (T, T, T) {
    let around = (K / 2 - 1) as i64;
    let (mut index, mut flip, mut weight) = ([[0; K]; D], [[false; K]; D], [[T::ZERO; K]; D]);
    for a in 0..D {
        let below = floor(shift[a].f64());
        let t = shift[a] - T::of(below as f64);
        for k in 0..K {
            (index[a][k], flip[a][k]) = lattice.place(a, own[a].saturating_add(below - around + k as i64));
        }
        if K == 2 {
            (weight[a][0], weight[a][1]) = (T::ONE - t, t);
        } else {
            weight[a].copy_from_slice(&cubic(t)[..K]);
        }
    }
    let mut total = T::ZERO;
    let mut bounds: Option<(T, T)> = None;
    for z in 0..if D == 3 { K } else { 1 } {
        for y in 0..K {
            let mut cell = [0; D];
            cell[1] = index[1][y];
            let (mut w, mut turn) = (weight[1][y], flip[1][y]);
            let mut near = y + 1 == K / 2 || y == K / 2;
            if D == 3 {
                cell[2] = index[2][z];
                w *= weight[2][z];
                turn ^= flip[2][z];
                near &= z + 1 == K / 2 || z == K / 2;
            }
            let base = lattice.layout.slot(cell);
            let v: [T; K] = array(
                #[inline(always)]
                |k| {
                    let v = field[base + index[0][k]];
                    if turn != flip[0][k] { -v } else { v }
                },
            );
            let mut line = T::ZERO;
            for k in 0..K {
                line += weight[0][k] * v[k];
            }
            total += w * line;
            if near {
                for v in [v[K / 2 - 1], v[K / 2]] {
                    let (low, high) = bounds.unwrap_or((v, v));
                    bounds = Some((low.min(v), high.max(v)));
                }
            }
        }
    }
    let (low, high) = bounds.unwrap_or((total, total));
    (total, low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_of_any_number() {
        assert_eq!((floor(2.25), floor(-2.25), floor(-2.0)), (2, -3, -2));
        assert_eq!(floor(f64::NAN), 0);
        assert!(floor(f64::INFINITY) > 1 << 40 && floor(f64::NEG_INFINITY) < -(1 << 40));
    }

    #[test]
    fn cubic_weights_keep_cubics() {
        for t in [0.0, 0.3, 1.0] {
            let w = cubic::<f64>(t);
            for power in 0..4 {
                let sum: f64 = (0..4).map(|k| w[k] * (k as f64 - 1.0).powi(power)).sum();
                assert!((sum - t.powi(power)).abs() < 1e-14);
            }
        }
    }
}
