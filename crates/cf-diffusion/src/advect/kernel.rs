//! MUSCL for rows of cells: limited slopes, upwind fluxes, no branches (model section 6.6).

use cf_grid::Real;

/// Twice the slope of a cell from its one-sided differences `a` and `b`, limited by MC: their sum, at most four times
/// the smaller, 0 at an extremum.
#[inline(always)]
fn slope2<T: Real>(a: T, b: T) -> T {
    let four = T::of(4.0);
    let most = (four * a.min(b)).max(T::ZERO);
    let least = (four * a.max(b)).min(T::ZERO);
    (a + b).min(most).max(least)
}

/// ν⁺ (l + (1−ν) s_l/2) + ν⁻ (r − (1+ν) s_r/2): what crosses a face in a step, in units of a cell's content.
#[inline(always)]
fn flux<T: Real>(nu: T, l: T, l_slope2: T, r: T, r_slope2: T) -> T {
    let quarter = T::of(0.25);
    let (right, left) = (nu.max(T::ZERO), nu.min(T::ZERO));
    right * (l + (quarter - quarter * right) * l_slope2) + left * (r - (quarter + quarter * left) * r_slope2)
}

/// out = φ − (F_R − F_L) + add with the five rows `v` around φ = `v[2]` and ν on either end.
#[inline(always)]
pub(super) fn flux_form<T: Real>(v: [&[T]; 5], low: &[T], high: &[T], add: &[T], out: &mut [T]) {
    let n = out.len();
    let v = v.map(|row| &row[..n]);
    let (low, high, add) = (&low[..n], &high[..n], &add[..n]);
    for i in 0..n {
        let d: [T; 4] = std::array::from_fn(|k| v[k + 1][i] - v[k][i]);
        let s: [T; 3] = std::array::from_fn(|k| slope2(d[k], d[k + 1]));
        let in_low = flux(low[i], v[1][i], s[0], v[2][i], s[1]);
        let in_high = flux(high[i], v[2][i], s[1], v[3][i], s[2]);
        out[i] = v[2][i] - (in_high - in_low) + add[i];
    }
}

/// The same where ν is one number: out = φ − |ν| (φ − φ_1 + (1−|ν|)(s − s_1)/2), with the first and second upwind
/// rows and the downwind row. A constant stays what it is to the bit.
#[inline(always)]
pub(super) fn uniform<T: Real>(nu: T, second: &[T], first: &[T], own: &[T], down: &[T], out: &mut [T]) {
    let n = out.len();
    let (second, first, own, down) = (&second[..n], &first[..n], &own[..n], &down[..n]);
    let nu = nu.abs();
    let weight = T::of(0.25) * (T::ONE - nu);
    for i in 0..n {
        let (a, b, c) = (first[i] - second[i], own[i] - first[i], down[i] - own[i]);
        out[i] = own[i] - nu * (b + weight * (slope2(b, c) - slope2(a, b)));
    }
}

/// [`uniform`] with the five rows around φ.
#[inline(always)]
pub(super) fn uniform_five<T: Real>(nu: T, v: [&[T]; 5], out: &mut [T]) {
    if nu > T::ZERO {
        uniform(nu, v[0], v[1], v[2], v[3], out);
    } else {
        uniform(nu, v[4], v[3], v[2], v[1], out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_limited() {
        assert_eq!(slope2(1.0, 2.0), 3.0);
        assert_eq!(slope2(-2.0, -1.0), -3.0);
        assert_eq!(slope2(1.0, 9.0), 4.0);
        assert_eq!(slope2(-9.0, -1.0), -4.0);
        assert_eq!(slope2(1.0, -2.0), 0.0);
        assert_eq!(slope2(0.0f32, 5.0), 0.0);
    }

    #[test]
    fn both_kernels_agree_where_both_apply() {
        let v: Vec<f64> = (0..40).map(|i| (i as f64 * 1.7).sin() + f64::from(i % 3)).collect();
        let rows: [&[f64]; 5] = std::array::from_fn(|k| &v[k..k + 36]);
        for nu in [0.0, 0.3, -0.8, 1.0] {
            let (mut a, mut b) = ([0.0; 36], [0.0; 36]);
            uniform_five(nu, rows, &mut a);
            flux_form(rows, &[nu; 36], &[nu; 36], &[0.0; 36], &mut b);
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-14, "{a} {b}");
            }
        }
    }

    #[test]
    fn a_unit_courant_number_is_an_exact_shift() {
        let v = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0];
        let rows: [&[f64]; 5] = std::array::from_fn(|k| &v[k..k + 2]);
        let mut out = [0.0; 2];
        uniform_five(1.0, rows, &mut out);
        assert_eq!(out, [-1.0, 4.0]);
        uniform_five(-1.0, rows, &mut out);
        assert_eq!(out, [1.0, -5.0]);
    }
}
