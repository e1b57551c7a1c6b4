//! MUSCL for rows of cells: limited slopes, upwind fluxes, no branches.

use cf_grid::Real;

use crate::limiter::slope2;

use super::sites::CHUNK;

/// ν⁺ (l + (1−ν) s_l/2) + ν⁻ (r − (1+ν) s_r/2): what crosses a face in a step, in units of a cell's content.
#[inline(always)]
fn flux<T: Real>(nu: T, l: T, l_slope2: T, r: T, r_slope2: T) -> T {
    let quarter = T::of(0.25);
    let (right, left) = (nu.max(T::ZERO), nu.min(T::ZERO));
    right * (l + (quarter - quarter * right) * l_slope2) + left * (r - (quarter + quarter * left) * r_slope2)
}

/// A stretch of values along x with two more at either end, as [`flux_form`] and [`uniform`] want it when slopes and
/// fluxes of neighbours can be shared.
pub(super) type Window<T> = [T; CHUNK + 4];

/// Slopes of the window's values 1 ..= m + 2.
#[inline(always)]
fn window_slopes<T: Real>(v: &Window<T>, m: usize) -> [T; CHUNK + 2] {
    let mut slopes = [T::ZERO; CHUNK + 2];
    let (a, b, c) = (&v[..m + 2], &v[1..m + 3], &v[2..m + 4]);
    for (((s, &a), &b), &c) in slopes.iter_mut().zip(a).zip(b).zip(c) {
        *s = slope2(b - a, c - b);
    }
    slopes
}

/// [`flux_form`] of the window's values 2 .. m + 2, ν on their low ends and on the high end of the last.
#[inline(always)]
pub(super) fn flux_form_window<T: Real>(v: &Window<T>, low: &[T], last: T, add: &[T], out: &mut [T]) {
    let m = out.len();
    let slopes = window_slopes(v, m);
    let mut fluxes = [T::ZERO; CHUNK + 1];
    for i in 0..low.len().min(CHUNK) {
        fluxes[i] = flux(low[i], v[i + 1], slopes[i], v[i + 2], slopes[i + 1]);
    }
    fluxes[m] = flux(last, v[m + 1], slopes[m], v[m + 2], slopes[m + 1]);
    let (own, in_low, in_high) = (&v[2..m + 2], &fluxes[..m], &fluxes[1..=m]);
    for ((((out, &own), &l), &h), &add) in out.iter_mut().zip(own).zip(in_low).zip(in_high).zip(add) {
        *out = own - (h - l) + add;
    }
}

/// [`uniform`] of the window's values 2 .. m + 2.
#[inline(always)]
pub(super) fn uniform_window<T: Real>(nu: T, v: &Window<T>, out: &mut [T]) {
    let m = out.len();
    let slopes = window_slopes(v, m);
    let weight = T::of(0.25) * (T::ONE - nu.abs());
    let own = &v[2..m + 2];
    // Against the flow differences and slopes change sign.
    let (sign, upwind, first) =
        if nu > T::ZERO { (weight, &v[1..m + 1], &slopes[..m]) } else { (-weight, &v[3..m + 3], &slopes[2..m + 2]) };
    for ((((out, &own), &up), &s), &s_up) in out.iter_mut().zip(own).zip(upwind).zip(&slopes[1..=m]).zip(first) {
        *out = own - nu.abs() * ((own - up) + sign * (s - s_up));
    }
}

/// out = φ − (F_R − F_L) + add with the five rows `v` around φ = `v[2]` and ν on either end.
#[inline(always)]
pub(super) fn flux_form<T: Real>(v: [&[T]; 5], low: &[T], high: &[T], add: &[T], out: &mut [T]) {
    let n = out.len();
    let [v0, v1, v2, v3, v4] = v.map(|row| &row[..n]);
    let (low, high, add) = (&low[..n], &high[..n], &add[..n]);
    for i in 0..n {
        let (a, b, c, d) = (v1[i] - v0[i], v2[i] - v1[i], v3[i] - v2[i], v4[i] - v3[i]);
        let s = slope2(b, c);
        let in_low = flux(low[i], v1[i], slope2(a, b), v2[i], s);
        let in_high = flux(high[i], v2[i], s, v3[i], slope2(c, d));
        out[i] = v2[i] - (in_high - in_low) + add[i];
    }
}

/// [`flux_form`] with the slopes of the rows before, at and behind φ times `steep`.
#[inline(always)]
pub(super) fn flux_form_with<T: Real>(v: [&[T]; 5], steep: [&[T]; 3], low: &[T], high: &[T], add: &[T], out: &mut [T]) {
    let n = out.len();
    let [v0, v1, v2, v3, v4] = v.map(|row| &row[..n]);
    let [steep1, steep2, steep3] = steep.map(|row| &row[..n]);
    let (low, high, add) = (&low[..n], &high[..n], &add[..n]);
    for i in 0..n {
        let (a, b, c, d) = (v1[i] - v0[i], v2[i] - v1[i], v3[i] - v2[i], v4[i] - v3[i]);
        let s = steep2[i] * slope2(b, c);
        let in_low = flux(low[i], v1[i], steep1[i] * slope2(a, b), v2[i], s);
        let in_high = flux(high[i], v2[i], s, v3[i], steep3[i] * slope2(c, d));
        out[i] = v2[i] - (in_high - in_low) + add[i];
    }
}

/// [`flux_form`] where ν is one number: out = φ − |ν| (φ − φ_1 + (1−|ν|)(s − s_1)/2), with the first and second upwind
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
    fn kernels_agree_where_several_apply() {
        let v: Vec<f64> = (0..40).map(|i| (i as f64 * 1.7).sin() + f64::from(i % 3)).collect();
        let rows: [&[f64]; 5] = std::array::from_fn(|k| &v[k..k + 36]);
        for nu in [0.0, 0.3, -0.8, 1.0] {
            let (mut a, mut b) = ([0.0; 36], [0.0; 36]);
            uniform_five(nu, rows, &mut a);
            flux_form(rows, &[nu; 36], &[nu; 36], &[0.0; 36], &mut b);
            let (mut c, mut d) = ([0.0; 36], [0.0; 36]);
            let mut window = [0.0; CHUNK + 4];
            window[..40].copy_from_slice(&v);
            flux_form_window(&window, &[nu; 36], nu, &[0.0; 36], &mut c);
            uniform_window(nu, &window, &mut d);
            for i in 0..36 {
                assert!((a[i] - b[i]).abs() < 1e-14 && (a[i] - d[i]).abs() < 1e-14);
                assert_eq!(b[i], c[i]);
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
