//! The scalars of one time step, in a form that no corner of the parameters breaks (paper eqs 14-18, rescaled).
//!
//! The paper's implicit step is, with v = Δt/(τ+Δt) and w = τ/(τ+Δt),
//!
//! ```text
//!     (I − β ∇²) φ^ = φ* − w Δt ∇·q*                             β = Δt (k_F + v k_C)
//!     q_C           = w q* − v k_C ∇φ^
//!     φ             = φ* − Δt ∇·(q_C − k_F ∇φ^)
//! ```
//!
//! v and w come from the two divisions, never from 1 − v: every coefficient is then right to rounding for any
//! τ ∈ [0, 1e30] s, Δt ∈ [0, 1e15] s and k up to 1e30 m²/s, and τ = 0, F_T = 0 and F_T = 1 need no other formula.

use crate::law::Law;

/// Coefficients of the implicit step over `dt` \[s\].
///
/// β ≤ k Δt, with equality only without memory, and β ≤ (cΔt)² for F_T = 0: the step is badly conditioned only
/// where it steps over the wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// β = Δt (k_F + v k_C) \[m²\], the weight of the Laplacian.
    pub beta: f64,
    /// w Δt \[s\], the weight of ∇·q* on the right-hand side.
    pub pull: f64,
    /// w = τ/(τ+Δt) \[1\], what remains of the old slow flux.
    pub keep: f64,
    /// v k_C \[m²/s\], what the new gradient adds to the slow flux.
    pub gain: f64,
    /// k_F \[m²/s\], the flux without memory per gradient.
    pub fast: f64,
    /// Δt \[s\].
    pub dt: f64,
}

impl Coefficients {
    /// Coefficients of `law` for a step `dt` ≥ 0 \[s\]. `dt` = 0 leaves the state as it is, for τ = 0 too.
    ///
    /// A negative step, or one that is not a number, has no coefficients: all are NaN.
    pub fn new(law: &Law, dt: f64) -> Coefficients {
        let dt = if dt >= 0.0 { dt } else { f64::NAN };
        let (v, w) = if dt == 0.0 { (0.0, 1.0) } else { (dt / (law.tau() + dt), law.tau() / (law.tau() + dt)) };
        let (fast, slow) = (law.k_fourier(), law.k_cattaneo());
        // Without memory this is Fourier's step bit for bit, whichever of τ = 0 and F_T = 1 made it so.
        let fourier = dt * law.k();
        let beta = if law.has_memory() { (dt * (fast + v * slow)).min(fourier) } else { fourier };
        Coefficients { beta, pull: w * dt, keep: w, gain: v * slow, fast, dt }
    }
}

/// Coefficients of the explicit kick-drift-kick step over `dt` \[s\], for F_T = 0:
///
/// ```text
///     q ← e q − (1−e) k ∇φ;    φ ← φ − Δt ∇·q + Δt W;    q ← e q − (1−e) k ∇φ            e = exp(−Δt/2τ)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kicks {
    /// e = exp(−Δt/2τ) \[1\], what a half kick leaves of the slow flux; 0 at τ = 0.
    pub keep: f64,
    /// (1−e) k_C \[m²/s\], what the gradient adds in a half kick.
    pub gain: f64,
    /// Δt \[s\], the drift.
    pub dt: f64,
}

impl Kicks {
    /// Coefficients of `law` for a step `dt` ≥ 0 \[s\]; all NaN for a step that is negative or not a number.
    ///
    /// The fast flux of a law with F_T > 0 is not part of this step.
    pub fn new(law: &Law, dt: f64) -> Kicks {
        let dt = if dt >= 0.0 { dt } else { f64::NAN };
        let x = if dt == 0.0 { 0.0 } else { -0.5 * dt / law.tau() };
        Kicks { keep: x.exp(), gain: -x.exp_m1() * law.k_cattaneo(), dt }
    }
}

/// The largest stable step \[s\] of the kick-drift-kick scheme, the root of k Δt tanh(Δt/2τ) Λ_max = 2.
///
/// `lambda_max` \[1/m²\] is the largest eigenvalue of −∇²_h, 4d/h² on a grid of spacing h in d dimensions. For
/// Δt ≪ τ this is cΔt ≤ h/√d, for Δt ≫ τ it is the explicit heat limit k Δt ≤ h²/2d; the bound is sharp. It is
/// infinite if nothing diffuses, NaN for a negative `lambda_max`, and meant for F_T = 0.
pub fn kdk_limit(law: &Law, lambda_max: f64) -> f64 {
    let tau = law.tau();
    let heat = 2.0 / law.k_cattaneo() / lambda_max;
    if !(0.0..f64::INFINITY).contains(&heat) {
        return if heat == f64::INFINITY { heat } else { f64::NAN };
    }
    let wave = (2.0 * heat).sqrt() * tau.sqrt();
    let stable = |dt: f64| dt * (0.5 * dt / tau).tanh() <= heat;
    // x²/(1+x) ≤ x tanh x ≤ min(x, x²) encloses the root within 31 %; what is left is one bit per halving.
    let (mut low, mut high) = (heat.max(wave), 0.5 * heat + (0.5 * heat).hypot(wave));
    for _ in 0..60 {
        let middle = low + 0.5 * (high - low);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn law(k: f64, tau: f64, fourier: f64) -> Law {
        Law::new(k, tau, fourier).unwrap()
    }

    /// 0, or ten to a power between `low` and `high`.
    fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
        prop_oneof![1 => Just(0.0), 9 => (low..high).prop_map(|e| 10f64.powf(e))]
    }

    #[test]
    fn no_step_is_the_identity() {
        for tau in [0.0, 1.0, 1e30] {
            let c = Coefficients::new(&law(2.0, tau, 0.5), 0.0);
            assert_eq!((c.beta, c.pull, c.keep, c.gain), (0.0, 0.0, 1.0, 0.0));
            let kicks = Kicks::new(&law(2.0, tau, 0.0), 0.0);
            assert_eq!((kicks.keep, kicks.gain), (1.0, 0.0));
        }
    }

    #[test]
    fn the_limits_of_the_law() {
        let c = Coefficients::new(&law(2.0, 0.0, 0.3), 0.1);
        assert_eq!((c.beta, c.keep, c.pull), (0.2, 0.0, 0.0));
        assert_eq!(c.beta, Coefficients::new(&law(2.0, 5.0, 1.0), 0.1).beta);
        // τ → ∞ at a fixed speed: β → (cΔt)².
        let wave = Coefficients::new(&Law::from_speed(0.5, 1e30, 0.0).unwrap(), 0.1);
        assert_relative_eq!(wave.beta, 0.0025, max_relative = 1e-14);
        assert_eq!(Kicks::new(&law(2.0, 0.0, 0.0), 0.1), Kicks { keep: 0.0, gain: 2.0, dt: 0.1 });
        assert!(Coefficients::new(&law(1.0, 1.0, 0.0), -1.0).beta.is_nan());
        assert!(Kicks::new(&law(1.0, 1.0, 0.0), f64::NAN).gain.is_nan());
    }

    #[test]
    fn the_explicit_limit_has_both_ends() {
        // c = 1, h = 1/4, d = 2: h/(c√d); heat: h²/(2 d k).
        assert_relative_eq!(kdk_limit(&law(1e12, 1e12, 0.0), 128.0), 0.125 * 2f64.sqrt(), max_relative = 1e-12);
        assert_relative_eq!(kdk_limit(&law(3.0, 1e-12, 0.0), 128.0), 1.0 / 192.0, max_relative = 1e-12);
        assert_eq!(kdk_limit(&law(3.0, 0.0, 0.0), 128.0), 1.0 / 192.0);
        assert_eq!(kdk_limit(&law(0.0, 1.0, 0.0), 128.0), f64::INFINITY);
        assert!(kdk_limit(&law(1.0, 1.0, 0.0), f64::NAN).is_nan());
        assert!(kdk_limit(&law(1.0, 1.0, 0.0), -1.0).is_nan());
    }

    proptest! {
        #[test]
        fn beta_never_exceeds_fouriers(
            k in decades(-30.0, 30.0), tau in decades(-15.0, 30.0), dt in decades(-15.0, 15.0), share in 0.0..=1.0f64,
        ) {
            let law = law(k, tau, share);
            let c = Coefficients::new(&law, dt);
            for value in [c.beta, c.pull, c.keep, c.gain, c.fast] {
                prop_assert!(value.is_finite() && value >= 0.0);
            }
            prop_assert!(c.beta <= k * dt);
            prop_assert!(c.pull <= dt.min(tau) * (1.0 + 1e-15));
            let visible = c.keep * (1.0 - share) > 1e-14 && k * dt > 0.0;
            prop_assert!(!visible || c.beta < k * dt, "equality needs F_T = 1 or tau = 0");
            prop_assert!((c.beta - dt * (c.fast + c.gain)).abs() <= 1e-15 * k * dt);
        }

        #[test]
        fn a_cattaneo_step_is_conditioned_by_its_wave(
            k in -30.0..30.0f64, tau in -15.0..30.0f64, dt in -15.0..15.0f64,
        ) {
            let law = law(10f64.powf(k), 10f64.powf(tau), 0.0);
            let dt = 10f64.powf(dt);
            let cfl = law.speed().unwrap() * dt;
            prop_assert!(Coefficients::new(&law, dt).beta <= cfl * cfl * (1.0 + 1e-14));
        }

        #[test]
        fn the_explicit_limit_is_the_root(
            k in -30.0..30.0f64, tau in decades(-30.0, 30.0), lambda in -10.0..14.0f64,
        ) {
            let (k, lambda) = (10f64.powf(k), 10f64.powf(lambda));
            let dt = kdk_limit(&law(k, tau, 0.0), lambda);
            let residual = k * lambda * dt * (0.5 * dt / tau).tanh() / 2.0;
            prop_assert!((residual - 1.0).abs() < 1e-14, "{residual}");
        }
    }
}
