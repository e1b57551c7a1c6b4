//! One mode of the law, solved exactly: φ and D = ∇·q_C on an eigenfunction of −∇² with eigenvalue Λ.
//!
//! ```text
//!     d/dt (φ, D) = M (φ, D)          M = [[−k_F Λ, −1], [k_C Λ/τ, −1/τ]]
//! ```
//!
//! Its exponential is written with dimensionless numbers only, y = kτΛ and θ = t/τ:
//!
//! ```text
//!     m = (1 + F_T y)/2,   d = (1 − F_T y)/2,   n² = d² − (1 − F_T) y          roots  −(m ∓ n)/τ
//!     overdamped (n² ≥ 0)      e₁ = e^{−kΛt/(m+n)},  e₂ = e^{−(m+n)θ},  σ = (e₁ − e₂)/2n
//!     oscillating (n² < 0)     σ = e^{−mθ} sin(|n|θ)/|n|
//!     e^{Mt} = [[C + dσ, −τσ], [k_C Λ σ, C − dσ]]                              C the mean of e₁ and e₂
//! ```
//!
//! The slow root is a quotient, not a difference, and σ comes from `exp_m1`, so neither small steps nor stiff modes
//! lose digits, and τ = 0 (θ = ∞, y = 0) is an ordinary value. Against 60-digit arithmetic the entries agree to
//! 1e-15, measured in the energy norm ([`energy`](super::energy)), plus one rounding of the phase |n|θ.

use nalgebra::Complex;

use crate::law::Law;

/// The state of a mode, (φ, D = ∇·q_C), in units (P, P/s) for a quantity φ of unit P.
pub type ModeState = [f64; 2];

/// A 2×2 matrix acting on a [`ModeState`], by rows.
pub type ModeMatrix = [[f64; 2]; 2];

/// The exact propagator e^{Mt} of a mode with eigenvalue `lambda` = Λ ≥ 0 \[1/m²\] over `t` ≥ 0 \[s\].
///
/// `t` = 0 is the identity, for τ = 0 too; for t > 0 a law with τ = 0 sets D = k_C Λ φ whatever D was.
/// A negative `t` or `lambda` gives NaN, and so may kτΛ > 1e150.
/// The divergence-free part of q_C is not a mode: it decays by e^{−t/τ} and φ never sees it.
pub fn propagator(law: &Law, lambda: f64, t: f64) -> ModeMatrix {
    if t == 0.0 {
        return [[1.0, 0.0], [0.0, 1.0]];
    }
    if !(t > 0.0 && lambda >= 0.0) {
        return [[f64::NAN; 2]; 2];
    }
    let shape = Shape::of(law, lambda);
    let Shape { m, d, slow, .. } = shape;
    let theta = t / law.tau();
    let (phi, flux, sigma) = if shape.square >= 0.0 {
        let n = shape.square.sqrt();
        let e1 = (-law.k() * lambda * t / (m + n)).exp();
        let e2 = (-(m + n) * theta).exp();
        let sigma = if e1 == 0.0 { 0.0 } else { e1 * relative_decay(n, theta) };
        // dσ with C: the mean of e₁ and e₂ and half their difference, the cancelling part taken out.
        let rest = if slow == 0.0 { 0.0 } else { slow / (n + d.abs()) * sigma };
        if d >= 0.0 { (e1 + rest, e2 - rest, sigma) } else { (e2 - rest, e1 + rest, sigma) }
    } else {
        let n = (-shape.square).sqrt();
        let e = (-m * theta).exp();
        if e == 0.0 {
            (0.0, 0.0, 0.0)
        } else {
            let (sin, cos) = (n * theta).sin_cos();
            let sigma = e * sin / n;
            (e * cos + d * sigma, e * cos - d * sigma, sigma)
        }
    };
    [[phi, -law.tau() * sigma], [law.k_cattaneo() * lambda * sigma, flux]]
}

/// The state `t` seconds after `state`, in a medium at rest and without a source.
pub fn evolve(law: &Law, lambda: f64, t: f64, state: ModeState) -> ModeState {
    apply(&propagator(law, lambda, t), state)
}

/// φ(t)/φ(0) of a mode that starts without slow flux: the top left entry of the [`propagator`].
pub fn response(law: &Law, lambda: f64, t: f64) -> f64 {
    propagator(law, lambda, t)[0][0]
}

/// The factor e^{−iωt} by which uniform motion turns the mode e^{iK·x}; `rate` is ω = K·u \[1/s\].
pub fn drift(rate: f64, t: f64) -> Complex<f64> {
    let (sin, cos) = (rate * t).sin_cos();
    Complex::new(cos, -sin)
}

/// Matrix times state.
pub fn apply(a: &ModeMatrix, s: ModeState) -> ModeState {
    a.map(|row| row[0] * s[0] + row[1] * s[1])
}

/// The wave numbers \[rad/m\] between which a mode oscillates while it decays: K₋ = 1/((1+r)√(kτ)) and
/// K₊ = (1+r)/(F_T √(kτ)), r = √(1−F_T). K₊ is infinite for F_T = 0; `None` where nothing oscillates.
pub fn oscillation_band(law: &Law) -> Option<[f64; 2]> {
    let r = 1.0 + (1.0 - law.fourier_share()).sqrt();
    let length = law.k().sqrt() * law.tau().sqrt();
    (law.has_memory() && length > 0.0).then(|| [1.0 / (r * length), r / (law.fourier_share() * length)])
}

/// The dimensionless numbers of a mode that do not depend on time.
pub(super) struct Shape {
    /// Mean damping times τ, (1 + F_T y)/2.
    pub m: f64,
    /// Half the difference of the two dampings times τ, (1 − F_T y)/2.
    pub d: f64,
    /// The coupling k_C τ Λ.
    pub slow: f64,
    /// n² = d² − k_C τ Λ; negative where the mode oscillates.
    pub square: f64,
}

impl Shape {
    pub(super) fn of(law: &Law, lambda: f64) -> Shape {
        let fast = law.k_fourier() * law.tau() * lambda;
        let slow = law.k_cattaneo() * law.tau() * lambda;
        let d = 0.5 - 0.5 * fast;
        Shape { m: 0.5 + 0.5 * fast, d, slow, square: d * d - slow }
    }
}

/// (1 − e^{−2nθ})/2n, and its limit θ as n → 0.
fn relative_decay(n: f64, theta: f64) -> f64 {
    if n * theta < 1e-300 { theta } else { -(-2.0 * n * theta).exp_m1() / (2.0 * n) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::energy::energy_norm;
    use proptest::prelude::*;

    /// ([k, τ, F_T, Λ, t], e^{Mt} by rows) from 60-digit arithmetic.
    #[rustfmt::skip]
    const REFERENCE: [([f64; 5], [f64; 4]); 14] = [
        ([1.0, 1.0, 0.0, 1.0, 0.7], [0.8109281656972523, -0.4636185010004463, 0.4636185010004463, 0.3473096646968061]),
        ([1.0, 1.0, 0.0, 0.25, 2.0], [0.7357588823428847, -0.7357588823428847, 0.18393972058572117, 4.7964828250684315e-81]),
        ([1.0, 1.0, 0.0, 0.2500001, 3.0], [0.5578252497582262, -0.6693903800367219, 0.16734766194821848, -0.11156513027849568]),
        ([1.0, 1.0, 0.0, 0.01, 50.0], [0.6096653991212487, -0.6158871225162131, 0.006158871225162132, -0.006221723394964446]),
        ([1.0, 1e-06, 0.0, 4.0, 0.3], [0.3011939709574109, -3.01195175742933e-07, 1.2047807029717321, -1.2047855221330973e-06]),
        ([0.001, 1000.0, 0.0, 1000000.0, 1.7], [-0.12823940125516212, -0.9908224047099974, 0.9908224047099974, -0.12923022365987213]),
        ([2.0, 0.5, 0.05, 30.0, 0.4], [-0.14321168959756733, 0.031115184571484482, -3.547131041149231, -0.17432687416905182]),
        ([2.0, 0.5, 0.9, 10000.0, 1.3], [-6.870424803905147e-07, -3.091309466777568e-06, 0.012365237867110268, 0.05563670074058227]),
        ([1.0, 1e-15, 0.3, 10.0, 0.1], [0.3678794411714423, -3.67879441171446e-16, 2.575156088200122, -2.5751560882001477e-15]),
        ([1000000000000.0, 1e-15, 0.5, 1e-10, 0.01], [0.3678794411714423, -3.6787944117147913e-16, 18.393972058573954, -1.8393972058575796e-14]),
        ([1.0, 1.0, 0.25, 1.0, 0.9], [0.6117197477900803, -0.47164734574301637, 0.3537355093072623, 0.25798423848281804]),
        ([1.0, 1e+30, 0.0, 100000000000000.0, 100000000.0], [0.5403023058681398, -84147098.48078965, 8.414709848078965e-09, 0.5403023058681398]),
        ([1e-12, 1000.0, 0.999999, 100000000000000.0, 20.0], [-9.802202184863594e-12, -0.009802094360259672, 9.802094360541537e-10, 0.9801986537123686]),
        ([3.0, 2.0, 1.0, 0.5, 1.1], [0.19204990862075408, -0.3848999017597326, 0.0, 0.5769498103804866]),
    ];

    /// The largest difference of two matrices in the energy's units.
    fn distance(law: &Law, lambda: f64, a: &ModeMatrix, b: &ModeMatrix) -> f64 {
        let difference = [0, 1].map(|i| [0, 1].map(|j| a[i][j] - b[i][j]));
        energy_norm(law, lambda, &difference)
    }

    fn multiply(a: &ModeMatrix, b: &ModeMatrix) -> ModeMatrix {
        a.map(|row| [0, 1].map(|j| row[0] * b[0][j] + row[1] * b[1][j]))
    }

    fn any_law() -> impl Strategy<Value = (Law, f64)> {
        let share = prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64, (-12.0..0.0f64).prop_map(|e| 1.0 - 10f64.powf(e))];
        let tau = prop_oneof![1 => Just(0.0), 8 => (-15.0..30.0f64).prop_map(|e| 10f64.powf(e))];
        (-12.0..12.0f64, tau, share, -10.0..14.0f64)
            .prop_map(|(k, tau, f, l)| (Law::new(10f64.powf(k), tau, f).unwrap(), 10f64.powf(l)))
    }

    #[test]
    fn agrees_with_many_digits() {
        for ([k, tau, share, lambda, t], p) in REFERENCE {
            let law = Law::new(k, tau, share).unwrap();
            let error = distance(&law, lambda, &propagator(&law, lambda, t), &[[p[0], p[1]], [p[2], p[3]]]);
            assert!(error < 2e-15, "{law:?} {lambda} {t}: {error:e}");
        }
    }

    #[test]
    fn small_entries_keep_their_digits() {
        // Stiff, overdamped: e^{Mt} has entries from 1e-6 to 1, each good to 1e-12 on its own.
        for ([k, tau, share, lambda, t], p) in [REFERENCE[4], REFERENCE[8], REFERENCE[12]] {
            let found = propagator(&Law::new(k, tau, share).unwrap(), lambda, t);
            for (found, expected) in found.iter().flatten().zip(p) {
                assert!((found / expected - 1.0).abs() < 1e-9, "{found:e} {expected:e}");
            }
        }
    }

    #[test]
    fn limits_of_the_law() {
        let fourier = (-2.0f64 * 3.0 * 0.1).exp();
        let still = Law::new(2.0, 0.0, 0.25).unwrap();
        assert_eq!(propagator(&still, 3.0, 0.1), [[fourier, -0.0], [1.5 * 3.0 * fourier, 0.0]]);
        let one = propagator(&Law::new(2.0, 5.0, 1.0).unwrap(), 3.0, 0.1);
        assert!(
            (one[0][0] - fourier).abs() < 1e-15 && one[1][0] == 0.0 && (one[1][1] - (-0.02f64).exp()).abs() < 1e-15
        );
        // A uniform field does not change, and nothing happens in no time.
        assert_eq!(evolve(&Law::cattaneo(2.0, 1.0).unwrap(), 0.0, 7.0, [3.0, 0.0]), [3.0, 0.0]);
        assert_eq!(evolve(&still, 3.0, 0.0, [3.0, 4.0]), [3.0, 4.0]);
        assert!(response(&still, f64::NAN, 1.0).is_nan() && response(&still, 1.0, f64::NAN).is_nan());
    }

    #[test]
    fn the_band_ends_where_damping_is_critical() {
        let law = Law::new(0.7, 0.3, 0.4).unwrap();
        for wave_number in oscillation_band(&law).unwrap() {
            assert!(Shape::of(&law, wave_number * wave_number).square.abs() < 1e-14);
        }
        assert_eq!(oscillation_band(&Law::cattaneo(1.0, 1.0).unwrap()), Some([0.5, f64::INFINITY]));
        assert_eq!(oscillation_band(&Law::fourier(1.0).unwrap()), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn two_steps_are_one((law, lambda) in any_law(), t in -15.0..15.0f64, part in 0.0..1.0f64) {
            let t = 10f64.powf(t);
            let (first, second) = (part * t, t - part * t);
            let phase = (law.k_cattaneo() * lambda / law.tau().max(1e-300)).sqrt() * t;
            prop_assume!(phase < 1e6 || law.tau() < 1e-3 * t);
            let twice = multiply(&propagator(&law, lambda, second), &propagator(&law, lambda, first));
            let error = distance(&law, lambda, &twice, &propagator(&law, lambda, t));
            prop_assert!(error <= 1e-13 + 1e-15 * phase.min(1e9), "{error:e} at phase {phase:e}");
        }

        #[test]
        fn it_solves_the_equation(k in -2.0..2.0f64, tau in -2.0..2.0f64, share in 0.0..=1.0f64, l in -2.0..2.0f64, t in 0.1..3.0f64) {
            let law = Law::new(10f64.powf(k), 10f64.powf(tau), share).unwrap();
            let lambda = 10f64.powf(l);
            let rate = law.k() * lambda + 1.0 / law.tau();
            let (t, e) = (t / rate, 3e-3 / rate);
            let p = |shift: f64| propagator(&law, lambda, t + shift * e);
            let m = [[-law.k_fourier() * lambda, -1.0], [law.k_cattaneo() * lambda / law.tau(), -1.0 / law.tau()]];
            let change = [0, 1].map(|i| [0, 1].map(|j| {
                (8.0 * (p(1.0)[i][j] - p(-1.0)[i][j]) - p(2.0)[i][j] + p(-2.0)[i][j]) / (12.0 * e)
            }));
            let error = distance(&law, lambda, &change, &multiply(&m, &p(0.0))) / rate;
            prop_assert!(error < 1e-10, "{error:e}");
        }
    }
}
