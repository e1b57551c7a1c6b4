//! The energy that this law never lets grow, on one mode.
//!
//! ```text
//!     E′ = ½ ∫ φ² + (τ/2k) ∫ |q_C|²          dE′/dt = −k_F |∇φ|² + F_T ∇φ·q − |q|²/k ≤ 0,   q = q_C
//! ```
//!
//! for every F_T in \[0, 1\] and closed, periodic or zero-valued walls. On a mode ∫|q_C|² is D²/Λ. It sets the
//! relative units of φ and D, and so the norm in which a step, or an error, is measured.

use super::modes::{ModeMatrix, ModeState};
use crate::law::Law;

/// The energy E′ = φ²/2 + τD²/(2kΛ) of a mode, per volume \[P²\]. It never grows under this law, for any F_T.
pub fn energy(law: &Law, lambda: f64, state: ModeState) -> f64 {
    let flux = if state[1] == 0.0 { 0.0 } else { weight(law, lambda) * state[1] };
    0.5 * (state[0] * state[0] + flux * flux)
}

/// The largest factor by which a step `a` of a mode can enlarge √E′: its 2-norm in the energy's units.
///
/// At most 1 for every A-stable step. Needs kΛ > 0; at τ = 0 the energy does not see D.
pub fn energy_norm(law: &Law, lambda: f64, a: &ModeMatrix) -> f64 {
    let s = weight(law, lambda);
    let upper = if a[0][1] == 0.0 { 0.0 } else { a[0][1] / s };
    let lower = if s == 0.0 { [0.0; 2] } else { [a[1][0] * s, a[1][1]] };
    let sum = (a[0][0] + lower[1]).hypot(lower[0] - upper);
    let difference = (a[0][0] - lower[1]).hypot(lower[0] + upper);
    0.5 * (sum + difference)
}

/// √(τ/kΛ) \[s\], which turns D into the units of φ.
fn weight(law: &Law, lambda: f64) -> f64 {
    law.tau().sqrt() / (law.k() * lambda).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::modes::{evolve, propagator};
    use proptest::prelude::*;

    fn any_law() -> impl Strategy<Value = (Law, f64)> {
        let share = prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64, (-12.0..0.0f64).prop_map(|e| 1.0 - 10f64.powf(e))];
        let tau = prop_oneof![1 => Just(0.0), 8 => (-15.0..30.0f64).prop_map(|e| 10f64.powf(e))];
        (-12.0..12.0f64, tau, share, -10.0..14.0f64)
            .prop_map(|(k, tau, f, l)| (Law::new(10f64.powf(k), tau, f).unwrap(), 10f64.powf(l)))
    }

    #[test]
    fn the_norm_is_the_largest_growth() {
        let (law, lambda) = (Law::new(0.3, 0.7, 0.2).unwrap(), 5.0);
        let p = propagator(&law, lambda, 0.4);
        let scale = (law.tau() / (law.k() * lambda)).sqrt();
        let growth = |angle: f64| {
            let state = [angle.cos(), angle.sin() / scale];
            (energy(&law, lambda, evolve(&law, lambda, 0.4, state)) / energy(&law, lambda, state)).sqrt()
        };
        let most = (0..2000).map(|i| growth(f64::from(i) * 0.002)).fold(0.0, f64::max);
        assert!((energy_norm(&law, lambda, &p) / most - 1.0).abs() < 1e-5);
        assert_eq!(energy(&law, 0.0, [2.0, 0.0]), 2.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn energy_never_grows((law, lambda) in any_law(), t in -15.0..15.0f64) {
            let p = propagator(&law, lambda, 10f64.powf(t));
            prop_assert!(p.iter().flatten().all(|x| x.is_finite()));
            prop_assert!(energy_norm(&law, lambda, &p) <= 1.0 + 1e-12);
        }
    }
}
