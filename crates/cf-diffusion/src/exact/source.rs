//! A mode under a steady source, at rest or carried by a uniform flow.
//!
//! With ω = K·u the mode e^{iK·x} obeys d/dt (φ, D) = A (φ, D) + (W, 0), A = M − iωI, M as in [`modes`]. A source that
//! starts at t = 0 adds ∫₀ᵗ e^{As} (W, 0) ds = A⁻¹(e^{At} − I)(W, 0). The quotient loses all digits where A is small
//! in one direction (a nearly uniform mode, or a wake in resonance, K·u ≈ cK), so it is used only where it is safe;
//! elsewhere the integral is taken root by root, or as a series.

use nalgebra::Complex;

use super::modes::{self, ModeState, Shape};
use crate::law::Law;

/// What a source of unit rate, W = 1 P/s on this mode from time 0, has added to (φ, D) after `t` ≥ 0 \[s\].
///
/// `lambda` = |K|² \[1/m²\], `rate` = K·u \[1/s\]. The result is linear in the source: multiply by its amplitude.
/// A negative `t` or `lambda` gives NaN. The error is 1e-14 of the result, both in the energy norm, times 1 + the
/// phases K·u t and cKt; a φ that is small beside its flux, √(τ/kΛ) D, is good to that much of the flux.
pub fn moving(law: &Law, lambda: f64, rate: f64, t: f64) -> [Complex<f64>; 2] {
    let shape = Shape::of(law, lambda);
    let theta = t / law.tau();
    let coupling = law.k_cattaneo() * lambda * t;
    let fast = law.k_fourier() * lambda * t;
    let size = fast.max(theta).max((coupling * theta).sqrt()).max((rate * t).abs());
    if t == 0.0 {
        [Complex::ZERO; 2]
    } else if !(t > 0.0 && lambda >= 0.0) {
        [Complex::from(f64::NAN); 2]
    } else if size <= 1.0 {
        series([[-fast, -t], [coupling / law.tau(), -theta]], rate * t).map(|x| x * t)
    } else if shape.square.abs() > 0.01 * shape.m * shape.m {
        root_by_root(law, lambda, rate, t, &shape)
    } else {
        by_quotient(law, lambda, rate, t)
    }
}

/// The same in a medium at rest.
pub fn still(law: &Law, lambda: f64, t: f64) -> ModeState {
    moving(law, lambda, 0.0, t).map(|x| x.re)
}

/// Σ (At)ʲ/(j+1)! (1, 0), for ‖At‖ of order 1; `m` is Mt and `turn` is ωt.
fn series(m: [[f64; 2]; 2], turn: f64) -> [Complex<f64>; 2] {
    let mut term = [Complex::ONE, Complex::ZERO];
    let mut sum = term;
    for j in 1..40 {
        let [phi, flux] = term;
        term = m.map(|row| phi * row[0] + flux * row[1]);
        term[0] -= Complex::i() * turn * phi;
        term[1] -= Complex::i() * turn * flux;
        for (total, part) in sum.iter_mut().zip(&mut term) {
            *part /= f64::from(j + 1);
            *total += *part;
        }
    }
    sum
}

/// Two well separated roots −(m ∓ n)/τ, real or a pair: each contributes J = ∫₀ᵗ e^{(s−iω)t'} dt' on its own.
fn root_by_root(law: &Law, lambda: f64, rate: f64, t: f64, shape: &Shape) -> [Complex<f64>; 2] {
    let n = Complex::new(shape.square, 0.0).sqrt();
    let larger = n + shape.m;
    let turn = Complex::new(0.0, -rate * t);
    let slow = integral(turn - law.k() * lambda * t / larger, t);
    let fast = integral(turn - larger * (t / law.tau()), t);
    let share = if shape.slow == 0.0 { Complex::ZERO } else { shape.slow / ((n + shape.d.abs()) * n * 2.0) };
    let (own, other) = if shape.d >= 0.0 { (slow, fast) } else { (fast, slow) };
    [own + (own - other) * share, (slow - fast) / (n * 2.0) * (law.k_cattaneo() * lambda)]
}

/// ∫₀ᵗ e^{zs/t} ds = t (e^z − 1)/z.
fn integral(z: Complex<f64>, t: f64) -> Complex<f64> {
    if z.re == f64::NEG_INFINITY {
        return Complex::ZERO;
    }
    // e^z − 1 = (e^x − 1) cos y − 2 sin²(y/2) + i e^x sin y
    let half = (0.5 * z.im).sin();
    let real = z.re.exp_m1() * z.im.cos() - 2.0 * half * half;
    let ratio = Complex::new(real, z.re.exp() * z.im.sin()) / z;
    if z == Complex::ZERO { Complex::new(t, 0.0) } else { ratio * t }
}

/// A⁻¹(e^{At} − I)(1, 0), the second row of A multiplied by τ.
fn by_quotient(law: &Law, lambda: f64, rate: f64, t: f64) -> [Complex<f64>; 2] {
    let p = modes::propagator(law, lambda, t);
    let turn = modes::drift(rate, t);
    let right = [turn * p[0][0] - 1.0, turn * (p[1][0] * law.tau())];
    let a = Complex::new(-law.k_fourier() * lambda, -rate);
    let c = law.k_cattaneo() * lambda;
    let d = Complex::new(-1.0, -rate * law.tau());
    let det = a * d + c;
    [(right[0] * d + right[1]) / det, (a * right[1] - right[0] * c) / det]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::energy::energy;
    use crate::exact::modes::evolve;
    use proptest::prelude::*;

    /// ([k, τ, F_T, Λ, ω, t], [Re φ, Im φ, Re D, Im D]) from 80-digit arithmetic.
    #[rustfmt::skip]
    const REFERENCE: [([f64; 6], [f64; 4]); 14] = [
        ([1.0, 1.0, 0.0, 1.0, 0.0, 0.7], [0.652690335303194, 0.0, 0.18907183430274763, 0.0]),
        ([1.0, 1.0, 0.0, 0.25, 0.0, 2.0], [1.792723352971346, 0.0, 0.26424111765711533, 0.0]),
        ([1.0, 1.0, 0.0, 1e-09, 0.0, 0.5], [0.49999999998153066, 0.0, 1.0653065971049074e-10, 0.0]),
        ([1.0, 1.0, 0.0, 1e-09, 1e-09, 200.0], [199.99998019899996, -1.9999997353332462e-05, 1.9899998039699995e-07, -1.9998997373329462e-14]),
        ([1.0, 0.001, 0.0, 1e-06, 0.0, 5.0], [4.999987505019808, 0.0, 4.998987510017796e-06, 0.0]),
        ([0.001, 1000.0, 0.0, 1000000.0, 1.0, 1.7], [0.7861765361808122, -0.49196692589964824, 0.4915101332968695, -0.9133470377190506]),
        ([0.001, 1000.0, 0.0, 1000000.0, 1.000001, 900.0], [362.39296398532474, -0.7589325240875391, 0.2382808745807262, -362.3507870522069]),
        ([2.0, 0.5, 0.05, 30.0, 3.0, 0.4], [0.018190583415568964, 0.05335071924678061, 1.1573742737510198, -0.34810280025938756]),
        ([2.0, 0.5, 0.9, 10000.0, 20.0, 1.3], [5.546565303177704e-05, 5.233562427337258e-07, 0.0016291570139236977, -0.010530249339891867]),
        ([1.0, 1.0, 0.0, 0.2500001, 0.3, 30.0], [2.1626387183195406, -2.179931175791322, 0.34602510665713254, -0.648789598441885]),
        ([1.0, 1e-15, 0.3, 10.0, 2.0, 0.1], [0.06289143533760742, -0.005269650828442293, 0.44024004736324934, -0.03688755579909642]),
        ([1.0, 1.0, 0.25, 1.0, 0.0, 0.9], [0.742015761517182, 0.0, 0.20277631183062417, 0.0]),
        ([1.0, 2.0, 0.3, 0.0, 0.0, 1.5], [1.5, 0.0, 0.0, 0.0]),
        ([1.0, 2.0, 0.3, 0.0, 2.0, 1.5], [0.0705600040299336, -0.9949962483002227, 0.0, 0.0]),
    ];

    /// √E′ of a complex state.
    fn size(law: &Law, lambda: f64, s: [Complex<f64>; 2]) -> f64 {
        if lambda == 0.0 {
            return s[0].norm() + s[1].norm();
        }
        (energy(law, lambda, s.map(|x| x.re)) + energy(law, lambda, s.map(|x| x.im))).sqrt()
    }

    #[test]
    fn agrees_with_many_digits() {
        for ([k, tau, share, lambda, rate, t], [a, b, c, d]) in REFERENCE {
            let law = Law::new(k, tau, share).unwrap();
            let expected = [Complex::new(a, b), Complex::new(c, d)];
            let found = moving(&law, lambda, rate, t);
            let error = size(&law, lambda, [found[0] - expected[0], found[1] - expected[1]]);
            assert!(error < 1e-13 * size(&law, lambda, expected), "{law:?} {lambda} {rate} {t}: {error:e}");
        }
    }

    #[test]
    fn corners() {
        let law = Law::new(1.0, 2.0, 0.3).unwrap();
        assert_eq!(still(&law, 0.0, 1.5), [1.5, 0.0]);
        assert_eq!(still(&law, 3.0, 0.0), [0.0, 0.0]);
        assert_eq!(still(&Law::fourier(1.0).unwrap(), 0.0, 2.0), [2.0, 0.0]);
        assert!(still(&law, f64::NAN, 1.0)[0].is_nan());
        // Long after: k Λ φ = W.
        assert!((still(&law, 3.0, 1e4)[0] - 1.0 / 3.0).abs() < 1e-15);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// The branches join: the source's work over t is that over t/2, propagated, plus that over t/2 again.
        #[test]
        fn two_halves_are_one(
            k in -6.0..6.0f64, tau in -9.0..9.0f64, share in 0.0..=1.0f64, l in -6.0..6.0f64, t in -6.0..6.0f64,
        ) {
            let (law, lambda) = (Law::new(10f64.powf(k), 10f64.powf(tau), share).unwrap(), 10f64.powf(l));
            let t = 10f64.powf(t);
            let phase = (law.k_cattaneo() * lambda / law.tau()).sqrt() * t;
            prop_assume!(phase < 1e4 || law.tau() < 1e-3 * t);
            let (half, whole) = (still(&law, lambda, 0.5 * t), still(&law, lambda, t));
            let later = evolve(&law, lambda, 0.5 * t, half);
            let error = [later[0] + half[0] - whole[0], later[1] + half[1] - whole[1]];
            let scale = energy(&law, lambda, half).sqrt();
            prop_assert!(energy(&law, lambda, error).sqrt() <= (1e-12 + 1e-15 * phase) * scale);
        }
    }
}
