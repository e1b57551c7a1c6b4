//! Sharp data of Cattaneo's law (F_T = 0) on a line: the telegraph equation.
//!
//! With a = 1/2τ, c = √(k/τ) and ρ = (a/c)√(c²t² − x²), the field at |x| < ct that grows from a point is
//!
//! ```text
//!     φ₀ = δ:   φ = (a/2c) e^{−at} [I₀(ρ) + at I₁(ρ)/ρ],          q = (a²x/2c) e^{−at} I₁(ρ)/ρ
//!     q₀ = δ:   φ = (a²x/2c³) e^{−at} I₁(ρ)/ρ,                    q = (a/2c) e^{−at} [at I₁(ρ)/ρ − I₀(ρ)]
//! ```
//!
//! plus the two fronts at x = ±ct, which carry the delta functions that [`Telegraph::front`] describes. Every
//! function here returns the part between the fronts, and 0 outside. The exponent ρ − at is formed as one number and
//! never overflows. Relative error 1e-15, times 1 + |ρ − at|.

use super::bessel::{i0e, i1e, i1e_over_x};
use super::quadrature::integrate;
use crate::law::Law;

/// The telegraph equation of one law: its speed c \[m/s\] and its damping a = 1/2τ \[1/s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telegraph {
    c: f64,
    a: f64,
}

/// A point between the fronts.
struct Inside {
    /// ρ = at √(1 − ξ²), ξ = x/ct.
    rho: f64,
    /// e^{ρ − at}.
    decay: f64,
}

impl Telegraph {
    /// The telegraph equation of `law`; `None` unless F_T = 0, τ > 0 and k > 0.
    pub fn new(law: &Law) -> Option<Telegraph> {
        let c = law.speed().filter(|&c| c > 0.0 && law.fourier_share() == 0.0)?;
        Some(Telegraph { c, a: 0.5 / law.tau() })
    }

    /// e^{−at}/2, the strength at `t` \[s\] of each front.
    ///
    /// φ₀ = δ: φ carries e^{−at}/2 [δ(x−ct) + δ(x+ct)] and q carries c e^{−at}/2 [δ(x−ct) − δ(x+ct)].
    /// q₀ = δ: φ carries e^{−at}/2c [δ(x−ct) − δ(x+ct)] and q carries e^{−at}/2 [δ(x−ct) + δ(x+ct)].
    pub fn front(&self, t: f64) -> f64 {
        0.5 * (-self.a * t).exp()
    }

    /// φ at `x` \[m\] and `t` \[s\] from φ₀ = δ(x), q₀ = 0, between the fronts \[1/m\].
    pub fn phi_of_phi(&self, x: f64, t: f64) -> f64 {
        let at = self.a * t;
        self.between(x, t, |p| 0.5 * self.a / self.c * p.decay * (i0e(p.rho) + at * i1e_over_x(p.rho)))
    }

    /// q from φ₀ = δ(x), q₀ = 0, between the fronts \[1/s\].
    pub fn q_of_phi(&self, x: f64, t: f64) -> f64 {
        self.between(x, t, |p| 0.5 * self.a * (self.a * (x / self.c)) * p.decay * i1e_over_x(p.rho))
    }

    /// φ from φ₀ = 0, q₀ = δ(x), between the fronts \[s/m²\].
    pub fn phi_of_q(&self, x: f64, t: f64) -> f64 {
        self.q_of_phi(x, t) / self.c / self.c
    }

    /// q from φ₀ = 0, q₀ = δ(x), between the fronts \[1/m\].
    pub fn q_of_q(&self, x: f64, t: f64) -> f64 {
        let at = self.a * t;
        self.between(x, t, |p| 0.5 * self.a / self.c * p.decay * (at * i1e_over_x(p.rho) - i0e(p.rho)))
    }

    /// φ from the step φ₀ = 1 for x < 0, 0 for x > 0, q₀ = 0: jumps of e^{−at}/2 at x = ±ct, a smooth ramp between.
    ///
    /// φ(x) + φ(−x) = 1. With x = ct sin ψ the ramp is ∫ (at/2) e^{−2at sin²(ψ/2)} [cos ψ i0e(ρ) + i1e(ρ)] dψ,
    /// ρ = at cos ψ, an integrand without singularity. Absolute error 1e-15.
    pub fn riemann_phi(&self, x: f64, t: f64) -> f64 {
        let reach = if t < 0.0 { f64::NAN } else { self.c * t };
        if x < 0.0 {
            return 1.0 - self.riemann_phi(-x, t);
        }
        if x >= reach {
            // At the start the step itself, and its mean where it jumps.
            return if x == 0.0 { 0.5 } else { 0.0 };
        }
        let at = self.a * t;
        let ramp = |psi: f64| {
            let (half, cos) = ((0.5 * psi).sin(), psi.cos());
            let rho = at * cos;
            0.5 * at * (-2.0 * at * half * half).exp() * (cos * i0e(rho) + i1e(rho))
        };
        let start = (x / reach).asin();
        // Beyond this angle the exponential is below e^{−40} of its value at 0.
        let end = 2.0 * (20.0 / at).sqrt().min(std::f64::consts::FRAC_1_SQRT_2).asin();
        self.front(t) + if end > start { integrate(ramp, start, end, 8) } else { 0.0 * start }
    }

    /// q from the same step \[P m/s\]: (c/2) e^{−at} I₀(ρ) between the fronts.
    pub fn riemann_q(&self, x: f64, t: f64) -> f64 {
        self.between(x, t, |p| 0.5 * self.c * p.decay * i0e(p.rho))
    }

    /// What has crossed x = 0 from the same step \[P m\]: ∫₀ᵗ q(0) dt = (ct/2) e^{−at} [I₀(at) + I₁(at)].
    pub fn riemann_mass(&self, t: f64) -> f64 {
        let at = self.a * t;
        0.5 * self.c * t * (i0e(at) + i1e(at))
    }

    /// `f` at a point between the fronts, 0 outside, NaN before the start.
    fn between(&self, x: f64, t: f64, f: impl Fn(&Inside) -> f64) -> f64 {
        let (xi, at) = (x / (self.c * t), self.a * t);
        if t < 0.0 {
            return f64::NAN;
        }
        if xi.abs() >= 1.0 || t == 0.0 {
            return 0.0;
        }
        let root = ((1.0 - xi) * (1.0 + xi)).sqrt();
        f(&Inside { rho: at * root, decay: (-at * xi * xi / (1.0 + root)).exp() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::modes::propagator;
    use std::f64::consts::PI;

    /// (x, t, φ) of the step for c = 1, τ = 1, from 30-digit quadrature of the Green's function.
    const RIEMANN: [[f64; 3]; 8] = [
        [0.3, 0.8, 0.4375432237999326],
        [-0.3, 0.8, 0.5624567762000674],
        [0.79, 0.8, 0.3371719011531936],
        [0.0, 0.8, 0.5],
        [1.0, 5.0, 0.3821306295549175],
        [4.9, 5.0, 0.04576423190487406],
        [10.0, 200.0, 0.30870322025104097],
        [-20.0, 200.0, 0.8413439784007088],
    ];

    fn unit() -> Telegraph {
        Telegraph::new(&Law::cattaneo(1.0, 1.0).unwrap()).unwrap()
    }

    #[test]
    fn the_step_agrees_with_many_digits() {
        for [x, t, expected] in RIEMANN {
            let found = unit().riemann_phi(x, t);
            assert!((found - expected).abs() < 1e-15, "{x} {t}: {:e}", found - expected);
        }
    }

    #[test]
    fn a_point_source_keeps_its_mass() {
        let law = Law::cattaneo(0.3, 0.7).unwrap();
        let telegraph = Telegraph::new(&law).unwrap();
        for t in [0.01, 0.5, 3.0, 20.0] {
            let reach = law.speed().unwrap() * t;
            let total = |f: fn(&Telegraph, f64, f64) -> f64| integrate(|x| f(&telegraph, x, t), -reach, reach, 40);
            let fronts = 2.0 * telegraph.front(t);
            assert!((fronts + total(Telegraph::phi_of_phi) - 1.0).abs() < 1e-13);
            // ∫q decays like e^{−t/τ}, and an odd φ has no mass.
            assert!((fronts + total(Telegraph::q_of_q) - (-t / 0.7f64).exp()).abs() < 1e-13);
            assert!(total(Telegraph::phi_of_q).abs() < 1e-13 && total(Telegraph::q_of_phi).abs() < 1e-13);
        }
    }

    #[test]
    fn every_wave_number_agrees_with_its_mode() {
        // ∫ φ cos Kx dx over the Green's functions is the propagator's first row; D = K times the sine part of q.
        let law = Law::cattaneo(0.3, 0.7).unwrap();
        let telegraph = Telegraph::new(&law).unwrap();
        for (wave, t) in [(0.4, 0.3), (1.0, 2.0), (5.0, 2.0), (40.0, 1.0)] {
            let reach = law.speed().unwrap() * t;
            let p = propagator(&law, wave * wave, t);
            let (sin, cos) = (wave * reach).sin_cos();
            let over = |f: &dyn Fn(f64) -> f64| integrate(f, -reach, reach, 60);
            let phi = over(&|x| telegraph.phi_of_phi(x, t) * (wave * x).cos()) + 2.0 * telegraph.front(t) * cos;
            assert!((phi - p[0][0]).abs() < 1e-13);
            let front_q = 2.0 * law.speed().unwrap() * telegraph.front(t) * sin;
            let q = over(&|x| telegraph.q_of_phi(x, t) * (wave * x).sin()) + front_q;
            assert!((wave * q - p[1][0]).abs() < 1e-12 * wave);
            let front_phi = 2.0 * telegraph.front(t) * sin / law.speed().unwrap();
            let phi = over(&|x| telegraph.phi_of_q(x, t) * (wave * x).sin()) + front_phi;
            assert!((phi + wave * p[0][1]).abs() < 1e-12 * wave);
            let q = over(&|x| telegraph.q_of_q(x, t) * (wave * x).cos()) + 2.0 * telegraph.front(t) * cos;
            assert!((q - p[1][1]).abs() < 1e-13);
        }
    }

    #[test]
    fn the_step_is_consistent() {
        let t = 3.0;
        let front = unit().riemann_phi(t * (1.0 - 1e-12), t);
        assert!((front - unit().front(t)).abs() < 1e-11);
        assert_eq!((unit().riemann_phi(3.1, t), unit().riemann_phi(-3.1, t)), (0.0, 1.0));
        assert!((unit().riemann_phi(0.0, t) - 0.5).abs() < 1e-14);
        let crossed = integrate(|s| unit().riemann_q(0.0, s), 0.0, t, 4);
        assert!((unit().riemann_mass(t) - crossed).abs() < 1e-14);
        let arrived = integrate(|x| unit().riemann_phi(x, t), 0.0, t, 4);
        assert!((arrived - crossed).abs() < 1e-13);
        // Long after, Fourier's error function; here its flux, √(k/4πt).
        let late = unit().riemann_q(0.0, 1e6);
        assert!((late * (4.0 * PI * 1e6).sqrt() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn corners() {
        assert_eq!(Telegraph::new(&Law::fourier(1.0).unwrap()), None);
        assert_eq!(Telegraph::new(&Law::jeffreys(1.0, 1.0, 0.1).unwrap()), None);
        assert_eq!(Telegraph::new(&Law::cattaneo(0.0, 1.0).unwrap()), None);
        assert_eq!(
            (unit().riemann_phi(0.0, 0.0), unit().riemann_phi(1.0, 0.0), unit().riemann_phi(-1.0, 0.0)),
            (0.5, 0.0, 1.0)
        );
        for f in
            [Telegraph::phi_of_phi, Telegraph::q_of_phi, Telegraph::phi_of_q, Telegraph::q_of_q, Telegraph::riemann_phi]
        {
            assert!(f(&unit(), f64::NAN, 1.0).is_nan() && f(&unit(), 0.1, f64::NAN).is_nan());
            assert!(f(&unit(), 1.0, 1e30).is_finite() && f(&unit(), 0.1, -1.0).is_nan());
        }
        assert!((unit().riemann_phi(1.0, 1e30) - 0.5).abs() < 1e-14);
    }
}
