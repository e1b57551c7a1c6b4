//! The pitfall of the paper's Appendix A: a moving medium and one equation for φ alone.
//!
//! At rest q_C can be eliminated: τφ_tt + φ_t = k φ_xx + τ k_F φ_xxt. In a uniform flow V every ∂_t of it has to
//! become D = ∂_t + V∂_x. Appendix A replaces one of the two in φ_tt,
//!
//! ```text
//!     printed      τ φ_tt + τV φ_xt + φ_t + V φ_x = k φ_xx + τ k_F φ_xxt + V τ k_F φ_xxx
//!     material     τ D²φ + Dφ                     = k φ_xx + τ k_F Dφ_xx
//!     two fields   Dφ + q_C,x = k_F φ_xx,    τ Dq_C + q_C = −k_C φ_x                        (this crate's model)
//! ```
//!
//! and its fronts (F_T = 0) run at [V ± √(V² + 4k/τ)]/2: a pulse knows how fast its medium moves. The other two are
//! the same model, with fronts at V ± c. The speed printed in the appendix itself is not that of its equation.
//!
//! The printed equation is exactly what follows if the medium carries φ but leaves the flux behind, φ_t + Vφ_x + q_x = 0
//! with τ q_t + q = −k φ_x − τ k_F (φ_xt + V φ_xx). One of its fronts then runs upstream at every V: there is no
//! super-critical flow, and no cone.
//!
//! On a mode e^{iKx} each is τ φ̈ + a₁ φ̇ + a₀ φ = 0 with complex numbers, solved exactly here. All start without slow
//! flux, q_C = 0, which means φ_t = −V φ_x + k_F φ_xx.

use std::f64::consts::PI;

use nalgebra::Complex;

use super::modes;
use crate::law::Law;

/// Which of the three models of a 1D periodic line in a uniform flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SingleField {
    /// One field, as printed in Appendix A: one of two time derivatives follows the medium.
    Printed,
    /// One field, with D² throughout.
    Material,
    /// φ and q_C, eq. 9.
    TwoField,
}

impl SingleField {
    /// All three, in the order above.
    pub const ALL: [SingleField; 3] = [SingleField::Printed, SingleField::Material, SingleField::TwoField];

    /// φ at time `t` ≥ 0 \[s\] from its `samples` at time 0, equally spaced over a periodic line of `length` \[m\] in a
    /// flow of `velocity` V \[m/s\]. The result has the length of `samples`.
    ///
    /// Exact for band-limited data, to rounding; of a pattern that changes sign from sample to sample only the part
    /// in phase with the samples is kept. The transform is direct: the work is the square of the sample count.
    pub fn evolve(self, samples: &[f64], length: f64, law: &Law, velocity: f64, t: f64) -> Vec<f64> {
        let n = samples.len();
        let turns: Vec<Complex<f64>> = (0..n).map(|j| modes::drift(2.0 * PI * j as f64 / n as f64, 1.0)).collect();
        let amplitudes: Vec<Complex<f64>> = (0..=n / 2)
            .map(|m| {
                let sum: Complex<f64> = samples.iter().enumerate().map(|(i, &s)| turns[m * i % n.max(1)] * s).sum();
                // Modes m and n − m are conjugate and are counted together.
                let count = if m == 0 || 2 * m == n { 1.0 } else { 2.0 };
                let wave = 2.0 * PI * m as f64 / length;
                sum * self.factor(wave, law, velocity, t) * (count / n as f64)
            })
            .collect();
        let at = |i: usize| amplitudes.iter().enumerate().map(|(m, a)| (a * turns[m * i % n].conj()).re).sum();
        (0..n).map(at).collect()
    }

    /// φ(t)/φ(0) of the mode e^{iKx}, K = `wave` \[rad/m\].
    fn factor(self, wave: f64, law: &Law, velocity: f64, t: f64) -> Complex<f64> {
        let turn = Complex::new(0.0, wave * velocity);
        let (tau, square) = (law.tau(), wave * wave);
        let fast = law.k_fourier() * square;
        match self {
            SingleField::Printed => {
                let damping = turn * tau + 1.0 + tau * fast;
                let force = turn * (1.0 + tau * fast) + law.k() * square;
                oscillate([force, damping], tau, -(turn + fast), t)
            }
            SingleField::Material => {
                let at_rest = [law.k() * square, 1.0 + tau * fast].map(Complex::from);
                oscillate(at_rest, tau, Complex::from(-fast), t) * modes::drift(turn.im, t)
            }
            SingleField::TwoField => modes::drift(turn.im, t) * modes::response(law, square, t),
        }
    }

    /// The speeds \[m/s\] of the left and the right front in a flow V, F_T = 0.
    ///
    /// [V ∓ √(V² + 4k/τ)]/2 for the printed model, V ∓ c for the others. For 0 < F_T < 1 there is no front: the
    /// printed model then has no speed (`None`), for the others c is the largest phase velocity in the medium's
    /// frame. `None` without memory too.
    pub fn front_speeds(self, law: &Law, velocity: f64) -> Option<[f64; 2]> {
        let c = law.speed()?;
        match self {
            SingleField::Printed if law.fourier_share() > 0.0 => None,
            SingleField::Printed => {
                let root = velocity.hypot(2.0 * c);
                // Their product is −c²: the smaller one is a quotient, so that it keeps its sign in a fast flow.
                let large = 0.5 * (velocity.abs() + root);
                let small = if c == 0.0 { 0.0 } else { c / large * c };
                Some(if velocity < 0.0 { [-large, small] } else { [-small, large] })
            }
            SingleField::Material | SingleField::TwoField => Some([velocity - c, velocity + c]),
        }
    }
}

/// z(t) for τ z̈ + a₁ ż + a₀ z = 0, z(0) = 1, ż(0) = `rate`; at τ = 0 the equation is of first order.
fn oscillate([a0, a1]: [Complex<f64>; 2], tau: f64, rate: Complex<f64>, t: f64) -> Complex<f64> {
    if tau == 0.0 {
        return (-a0 / a1 * t).exp();
    }
    // The larger root by the sum that does not cancel, the smaller from their product a₀/τ.
    let root = (a1 * a1 - a0 * tau * 4.0).sqrt();
    let sum = if (a1.conj() * root).re >= 0.0 { a1 + root } else { a1 - root };
    let (large, small) = (-sum / (2.0 * tau), -a0 * 2.0 / sum);
    let half = (small - large) * 0.5;
    let mean = (small + large) * 0.5;
    let z = half * t;
    let (e_small, e_large) = ((small * t).exp(), (large * t).exp());
    let sinh_over_half = if z.norm() < 1e-2 {
        let square = z * z;
        (mean * t).exp() * (square * (square / 120.0 + 1.0 / 6.0) + 1.0) * t
    } else {
        (e_small - e_large) / (half * 2.0)
    };
    (e_small + e_large) * 0.5 + sinh_over_half * (rate - mean)
}

/// The positions \[m\] of the outermost peaks of a pulse that has split, left and right, to a fraction of a cell.
///
/// A peak is a sample above its neighbours and above 5 % of the largest, refined by a parabola; `x` \[m\] are the
/// equally spaced positions of the samples `phi`. `None` if there is no peak, or if the lengths differ. A speed is
/// the difference of two such positions over the time between; near t = 0 the peaks are not yet apart.
pub fn measured_fronts(x: &[f64], phi: &[f64]) -> Option<[f64; 2]> {
    if x.len() != phi.len() {
        return None;
    }
    let threshold = 0.05 * phi.iter().copied().fold(0.0, f64::max);
    let mut peaks = phi.windows(3).zip(x.windows(3)).filter_map(|(p, x)| {
        let bend = p[0] - 2.0 * p[1] + p[2];
        let peak = p[1] > threshold && p[1] > p[0] && p[1] >= p[2];
        peak.then(|| x[1] + 0.25 * (x[2] - x[0]) * (p[0] - p[2]) / bend)
    });
    let left = peaks.next()?;
    Some([left, peaks.next_back().unwrap_or(left)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Gaussian;

    const LENGTH: f64 = 4.0;

    fn line(n: usize, sigma: f64) -> (Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..n).map(|i| LENGTH * (i as f64 + 0.5) / n as f64 - 0.5 * LENGTH).collect();
        let phi = x.iter().map(|x| (-0.5 * (x / sigma).powi(2)).exp()).collect();
        (x, phi)
    }

    fn furthest(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn material_and_two_fields_are_one_model() {
        let (_, phi) = line(256, 0.08);
        for (k, tau, share) in
            [(1.0, 1e3, 0.0), (1.0, 1.0, 0.0), (0.1, 0.3, 0.4), (0.1, 1e-6, 0.2), (0.1, 0.0, 0.2), (0.1, 2.0, 1.0)]
        {
            let law = Law::new(k, tau, share).unwrap();
            let [one, two] =
                [SingleField::Material, SingleField::TwoField].map(|m| m.evolve(&phi, LENGTH, &law, 0.7, 0.3));
            assert!(furthest(&one, &two) < 1e-12, "{law:?}: {:e}", furthest(&one, &two));
        }
    }

    #[test]
    fn all_agree_in_a_medium_at_rest() {
        let (_, phi) = line(128, 0.1);
        for share in [0.0, 0.3, 1.0] {
            let law = Law::new(0.2, 0.5, share).unwrap();
            let [a, b, c] = SingleField::ALL.map(|m| m.evolve(&phi, LENGTH, &law, 0.0, 0.4));
            assert!(furthest(&a, &b) < 1e-13 && furthest(&b, &c) < 1e-13);
        }
    }

    #[test]
    fn two_fields_are_the_gaussian_solution_carried_along() {
        let (x, phi) = line(257, 0.1);
        let law = Law::new(0.02, 1.0, 0.1).unwrap();
        let found = SingleField::TwoField.evolve(&phi, LENGTH, &law, 0.5, 0.8);
        let pulse = Gaussian { height: 1.0, sigma: 0.1 };
        let expected: Vec<f64> = x.iter().map(|x| pulse.periodic(&law, LENGTH, x - 0.4, 0.8)).collect();
        assert!(furthest(&found, &expected) < 1e-13);
    }

    #[test]
    fn printed_solves_its_equation() {
        // Residual of the printed mode equation by differences, F_T > 0 included.
        let (law, v, wave) = (Law::new(0.3, 0.7, 0.2).unwrap(), 0.9, 4.0);
        let f = |t: f64| SingleField::Printed.factor(wave, &law, v, t);
        let (t, e, i) = (0.6, 1e-3, Complex::i());
        let rate = (f(t + e) - f(t - e)) / (2.0 * e);
        let bend = (f(t + e) - f(t) * 2.0 + f(t - e)) / (e * e);
        let (ik, kf) = (i * wave, law.tau() * law.k_fourier());
        let left = bend * law.tau() + ik * v * law.tau() * rate + rate + ik * v * f(t);
        let right = ik * ik * (f(t) * law.k() + rate * kf) + ik * ik * ik * v * kf * f(t);
        assert!((left - right).norm() < 1e-4 * bend.norm());
        assert!((f(0.0) - 1.0).norm() < 1e-15);
    }

    #[test]
    fn measured_speeds_are_the_predicted_ones() {
        let law = Law::from_speed(1.0, 100.0, 0.0).unwrap();
        let (x, phi) = line(1024, 0.03);
        for v in [-0.5, 0.0, 0.5, 1.0] {
            for model in SingleField::ALL {
                let seen = |t: f64| measured_fronts(&x, &model.evolve(&phi, LENGTH, &law, v, t)).unwrap();
                let (early, late) = (seen(0.3), seen(0.8));
                for (side, speed) in model.front_speeds(&law, v).unwrap().into_iter().enumerate() {
                    let measured = (late[side] - early[side]) / 0.5;
                    assert!((measured - speed).abs() < 2e-3, "{model:?} {v}: {measured} {speed}");
                }
            }
        }
        // The printed model has an upstream front in any flow.
        assert!(SingleField::Printed.front_speeds(&law, 50.0).unwrap()[0] < 0.0);
        // And the pitfall: at V = c the printed model is off by 0.38 c on either side.
        let printed = SingleField::Printed.front_speeds(&law, 1.0).unwrap();
        assert!((printed[1] - 1.618).abs() < 1e-3 && (printed[0] + 0.618).abs() < 1e-3);
    }

    #[test]
    fn corners() {
        let law = Law::cattaneo(1.0, 1.0).unwrap();
        assert!(SingleField::Printed.evolve(&[], 1.0, &law, 1.0, 1.0).is_empty());
        assert_eq!(SingleField::Material.evolve(&[2.0], 1.0, &law, 1.0, 1.0), [2.0]);
        assert!(SingleField::Printed.evolve(&[1.0, 2.0, 4.0], 0.0, &law, 1.0, 1.0)[0].is_nan());
        assert_eq!(SingleField::Printed.front_speeds(&Law::new(1.0, 1.0, 0.1).unwrap(), 1.0), None);
        assert_eq!(SingleField::TwoField.front_speeds(&Law::fourier(1.0).unwrap(), 1.0), None);
        assert_eq!(measured_fronts(&[0.0, 1.0], &[0.0]), None);
        assert_eq!(measured_fronts(&[0.0, 1.0, 2.0, 3.0], &[0.0, 1.0, 2.0, 3.0]), None);
        assert_eq!(measured_fronts(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.0]), Some([1.0, 1.0]));
        assert_eq!(measured_fronts(&[0.0; 3], &[f64::NAN; 3]), None);
    }
}
