//! One step of each scheme on one mode: the 2×2 matrix that takes (φ, D = ∇·q_C) to its next value.
//!
//! A solver's step on a box of cells, compared with these matrices through the modes of [`axis`](super::axis), is
//! right to rounding or wrong. The matrices of [`paper_be`] and [`sdirk2`] are A-stable: in the energy norm
//! ([`energy_norm`](super::energy::energy_norm)) they never exceed 1, for any step and any law. `lambda` = Λ ≥ 0
//! \[1/m²\] is an eigenvalue of −∇²_h; a step that is negative or not a number gives NaN.

use super::modes::ModeMatrix;
use crate::coefficients::{Coefficients, Kicks};
use crate::law::Law;

/// SDIRK2's γ = 1 − 1/√2: each of its two stages is an implicit Euler step over γΔt.
pub const SDIRK2_GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// The paper's step, implicit Euler with the flux eliminated (paper eqs 14-18): (I − Δt M)⁻¹. First order.
///
/// ```text
///     g [[1, −wΔt], [v k_C Λ, w (1 + k_F Λ Δt)]]          g = 1/(1 + βΛ)
/// ```
///
/// The last entry is w − v w k_C Λ Δt g with the difference taken out. Divergence-free q_C is multiplied by w.
pub fn paper_be(law: &Law, dt: f64, lambda: f64) -> ModeMatrix {
    let c = Coefficients::new(law, dt);
    let inverse = 1.0 + c.beta * lambda;
    [[1.0 / inverse, -c.pull / inverse], [c.gain * lambda / inverse, c.keep * ((1.0 + c.fast * lambda * dt) / inverse)]]
}

/// Two implicit stages over γΔt, A = J [I + ((1−γ)/γ)(J − I)] with J = [`paper_be`] over γΔt. Second order, L-stable.
pub fn sdirk2(law: &Law, dt: f64, lambda: f64) -> ModeMatrix {
    let j = paper_be(law, SDIRK2_GAMMA * dt, lambda);
    let ratio = (1.0 - SDIRK2_GAMMA) / SDIRK2_GAMMA;
    let mut second = j.map(|row| row.map(|x| ratio * x));
    second[0][0] = 1.0 + ratio * (j[0][0] - 1.0);
    second[1][1] = 1.0 + ratio * (j[1][1] - 1.0);
    multiply(&j, &second)
}

/// The explicit leapfrog with exact relaxation, kick, drift, kick, for F_T = 0. Second order, stable for
/// Δt ≤ [`kdk_limit`](crate::coefficients::kdk_limit).
pub fn kdk(law: &Law, dt: f64, lambda: f64) -> ModeMatrix {
    let Kicks { keep, gain, dt } = Kicks::new(law, dt);
    let kick = [[1.0, 0.0], [gain * lambda, keep]];
    let drift = [[1.0, -dt], [0.0, 1.0]];
    multiply(&kick, &multiply(&drift, &kick))
}

/// The product of two matrices, `b` first.
fn multiply(a: &ModeMatrix, b: &ModeMatrix) -> ModeMatrix {
    a.map(|row| [0, 1].map(|j| row[0] * b[0][j] + row[1] * b[1][j]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coefficients::kdk_limit;
    use crate::exact::energy::energy_norm;
    use crate::exact::modes::propagator;
    use proptest::prelude::*;

    type Scheme = fn(&Law, f64, f64) -> ModeMatrix;

    /// The error after `steps` steps to the time 1, in the energy norm.
    fn error(scheme: Scheme, law: &Law, lambda: f64, steps: u32) -> f64 {
        let a = scheme(law, 1.0 / f64::from(steps), lambda);
        let all = (1..steps).fold(a, |product, _| multiply(&a, &product));
        let exact = propagator(law, lambda, 1.0);
        energy_norm(law, lambda, &[0, 1].map(|i| [0, 1].map(|j| all[i][j] - exact[i][j])))
    }

    fn order(scheme: Scheme, law: &Law) -> f64 {
        (error(scheme, law, 3.0, 256) / error(scheme, law, 3.0, 512)).log2()
    }

    /// The larger modulus of the eigenvalues.
    fn spectral_radius(a: &ModeMatrix) -> f64 {
        let (half, det) = (0.5 * (a[0][0] + a[1][1]), a[0][0] * a[1][1] - a[0][1] * a[1][0]);
        let root = half * half - det;
        if root < 0.0 { det.sqrt() } else { half.abs() + root.sqrt() }
    }

    #[test]
    fn orders_in_time() {
        for share in [0.0, 0.2, 1.0] {
            let law = Law::new(1.0, 0.5, share).unwrap();
            assert!((order(paper_be, &law) - 1.0).abs() < 0.02);
            assert!((order(sdirk2, &law) - 2.0).abs() < 0.02);
        }
        assert!((order(kdk, &Law::cattaneo(1.0, 0.5).unwrap()) - 2.0).abs() < 0.02);
    }

    #[test]
    fn no_step_changes_nothing() {
        for tau in [0.0, 1.0] {
            let law = Law::new(1.0, tau, 0.0).unwrap();
            for scheme in [paper_be as Scheme, sdirk2, kdk] {
                assert_eq!(scheme(&law, 0.0, 7.0), [[1.0, 0.0], [0.0, 1.0]]);
                assert!(scheme(&law, -1.0, 7.0)[0][0].is_nan() && scheme(&law, 1.0, f64::NAN)[1][0].is_nan());
            }
        }
    }

    #[test]
    fn the_explicit_limit_is_sharp() {
        for tau in [1e-9, 0.1, 1.0, 10.0, 1e9] {
            let law = Law::cattaneo(1.0, tau).unwrap();
            let limit = kdk_limit(&law, 400.0);
            assert!(spectral_radius(&kdk(&law, 0.999 * limit, 400.0)) <= 1.0 + 1e-12);
            assert!(spectral_radius(&kdk(&law, 1.001 * limit, 400.0)) > 1.0);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        #[test]
        fn implicit_steps_never_enlarge_the_energy(
            k in -12.0..12.0f64, tau in prop_oneof![1 => Just(-400.0), 9 => -15.0..30.0f64], dt in -15.0..15.0f64,
            share in prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64, Just(1e-12), Just(1.0 - 1e-12)], l in -10.0..14.0f64,
        ) {
            // 10^-400 is the corner τ = 0.
            let law = Law::new(10f64.powf(k), 10f64.powf(tau), share).unwrap();
            let (dt, lambda) = (10f64.powf(dt), 10f64.powf(l));
            for scheme in [paper_be, sdirk2] {
                let a = scheme(&law, dt, lambda);
                prop_assert!(a.iter().flatten().all(|x| x.is_finite()));
                let norm = energy_norm(&law, lambda, &a);
                prop_assert!(norm <= 1.0 + 1e-12, "{norm}");
            }
        }

        #[test]
        fn euler_inverts_the_generator(
            k in -12.0..12.0f64, tau in -15.0..30.0f64, dt in -15.0..15.0f64, share in 0.0..=1.0f64, l in -10.0..14.0f64,
        ) {
            let law = Law::new(10f64.powf(k), 10f64.powf(tau), share).unwrap();
            let (dt, lambda) = (10f64.powf(dt), 10f64.powf(l));
            let a = paper_be(&law, dt, lambda);
            let fast = 1.0 + law.k_fourier() * lambda * dt;
            let (slow, decay) = (law.k_cattaneo() * lambda * dt / law.tau(), 1.0 + dt / law.tau());
            // (I − Δt M) A = I; each line relative to the terms it is the sum of.
            for j in 0..2 {
                let [one, two] = [[1.0, 0.0], [0.0, 1.0]].map(|unit| unit[j]);
                let first = [fast * a[0][j], dt * a[1][j], -one];
                let second = [decay * a[1][j], -slow * a[0][j], -two];
                for terms in [first, second] {
                    let size: f64 = terms.iter().map(|x| x.abs()).sum();
                    prop_assert!(terms.iter().sum::<f64>().abs() <= 1e-14 * size);
                }
            }
        }
    }
}
