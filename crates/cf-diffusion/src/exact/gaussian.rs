//! A Gaussian that spreads: φ₀ = A e^{−r²/2s²}, no slow flux at the start.
//!
//! Every mode of it evolves by its own factor g(K, t) = [`response`], for every law. In a box
//! on a line the modes are a sum; in free space, in 1, 2 or 3 dimensions, an integral over the wave number K,
//!
//! ```text
//!     φ(r, t) = A s  √(2/π) ∫ e^{−K²s²/2} g(K,t) cos(Kr)          dK         1D
//!               A s²        ∫ e^{−K²s²/2} g(K,t) J₀(Kr)        K  dK         2D
//!               A s³ √(2/π) ∫ e^{−K²s²/2} g(K,t) sin(Kr)/(Kr)  K² dK         3D
//! ```
//!
//! The modes of this law do not factor over the axes: a Gaussian in 2D is no product of two in 1D, as it is under
//! Fourier's law. In 2D and 3D φ becomes negative behind the front; that is the solution. In a uniform flow u
//! everything holds at the point x − ut.

use super::bessel::j0;
use super::modes::response;
use super::quadrature::integrate;
use crate::law::Law;

/// The Gaussian's height A \[P\] and its standard deviation s \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    /// Height A \[P\].
    pub height: f64,
    /// Standard deviation s \[m\], above 0.
    pub sigma: f64,
}

/// Largest Ks: beyond it e^{−K²s²/2} < 1e-17.
const CUT: f64 = 8.9;

/// Most modes or panels that are summed; a request for more gives NaN.
const MOST: f64 = 1e6;

impl Gaussian {
    /// φ at distance `r` \[m\] and time `t` \[s\] in free space of `dim` dimensions under Fourier's law of diffusivity
    /// `k` \[m²/s\]: the Gaussian with s² + 2kt for s², and the same mass.
    pub fn fourier(&self, k: f64, dim: u32, r: f64, t: f64) -> f64 {
        let spread = self.sigma.hypot((2.0 * k * t).sqrt());
        let (shrink, distance) = (self.sigma / spread, r / spread);
        self.height * shrink.powf(f64::from(dim)) * (-0.5 * distance * distance).exp()
    }

    /// φ at distance `r` \[m\] and time `t` \[s\] in free space of `dim` = 1, 2 or 3 dimensions (NaN for others).
    ///
    /// Absolute error below 1e-15 A, measured for (r + ct)/s up to 100. The work grows with that number; beyond 6e5 the
    /// result is NaN.
    pub fn free(&self, law: &Law, dim: u32, r: f64, t: f64) -> f64 {
        let (s, top) = (self.sigma, CUT / self.sigma);
        let wave = |x: f64| match dim {
            1 => x.cos(),
            2 => j0(x),
            3 if x == 0.0 => 1.0,
            3 => x.sin() / x,
            _ => f64::NAN,
        };
        let power = dim.clamp(1, 3) as i32 - 1;
        let f = |k: f64| {
            let z = k * s;
            (-0.5 * z * z).exp() * response(law, k * k, t) * wave(k * r) * z.powi(power) * s
        };
        // φ varies on the scale of its width at time t or shorter: panels over octaves from there to the cut,
        // each short enough for the phases K r and K c t.
        let phase = r.abs() + law.speed().unwrap_or(0.0) * t;
        let mut low = 0.0;
        let mut high = (1.0 / s.hypot((law.k() * t).sqrt())).min(top);
        if !(top > 0.0 && high > 0.0 && phase * top < 6.0 * MOST) {
            return f64::NAN;
        }
        let mut sum = 0.0;
        while low < top {
            sum += integrate(f, low, high, 4 + (phase * (high - low) / 6.0) as u32);
            (low, high) = (high, (2.0 * high).min(top));
        }
        self.height
            * if dim == 2 { 1.0 } else { std::f64::consts::FRAC_2_SQRT_PI * std::f64::consts::FRAC_1_SQRT_2 }
            * sum
    }

    /// φ at `x` \[m\] from the centre and time `t` \[s\] on a periodic line of the given length \[m\], 1D.
    ///
    /// The initial data is the Gaussian and its periodic images. Absolute error about 1e-15 A (1 + x/s). There are
    /// 1.4 `length`/s modes; NaN for more than a million.
    pub fn periodic(&self, law: &Law, length: f64, x: f64, t: f64) -> f64 {
        let step = 2.0 * std::f64::consts::PI / length;
        self.modes(step, |k| response(law, k * k, t) * (k * x).cos())
    }

    /// φ at `x` \[m\] from the low wall and time `t` \[s\] between closed walls at 0 and `length` \[m\], 1D, with the
    /// Gaussian centred at `centre`.
    ///
    /// The initial data is the Gaussian and its mirror images; a wall is not noticed at first from 8 s away.
    pub fn closed(&self, law: &Law, length: f64, centre: f64, x: f64, t: f64) -> f64 {
        let step = std::f64::consts::PI / length;
        2.0 * self.modes(step, |k| response(law, k * k, t) * (k * x).cos() * (k * centre).cos())
    }

    /// A s (ΔK/√(2π)) [f(0) + 2 Σ e^{−K²s²/2} f(K)] over the multiples K of `step` = ΔK.
    fn modes(&self, step: f64, f: impl Fn(f64) -> f64) -> f64 {
        let z = step * self.sigma;
        if !(z * MOST > CUT && z < f64::INFINITY) {
            return f64::NAN;
        }
        let term = |m: u32| {
            let m = f64::from(m);
            (-0.5 * (m * z) * (m * z)).exp() * f(m * step)
        };
        let tail: f64 = (1..=(CUT / z) as u32).rev().map(term).sum();
        self.height * z / (2.0 * std::f64::consts::PI).sqrt() * (f(0.0) + 2.0 * tail)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// (dimension, [F_T, r, t], φ) for s = 0.1, k = τ = 1, height 1, from 20-digit quadrature.
    const REFERENCE: [(u32, [f64; 3], f64); 7] = [
        (3, [0.0, 0.0, 0.5], -3.5845746539388947e-06),
        (3, [0.0, 0.4, 0.5], -0.05567373245805422),
        (3, [0.05, 0.2, 0.3], -0.04349718595505281),
        (2, [0.0, 0.1, 0.5], -0.030031231248297),
        (2, [0.05, 0.5, 0.5], 0.04324152040545734),
        (1, [0.0, 0.45, 0.5], 0.38180189765189937),
        (1, [0.2, 0.0, 2.0], 0.04291285317408019),
    ];

    const PULSE: Gaussian = Gaussian { height: 1.0, sigma: 0.1 };

    #[test]
    fn free_space_agrees_with_many_digits() {
        for (dim, [share, r, t], expected) in REFERENCE {
            let found = PULSE.free(&Law::new(1.0, 1.0, share).unwrap(), dim, r, t);
            assert!((found - expected).abs() < 1e-15, "{dim} {share} {r} {t}: {:e}", found - expected);
        }
    }

    #[test]
    fn fouriers_law_has_its_closed_form() {
        let law = Law::fourier(0.3).unwrap();
        for (dim, r, t) in [(1, 0.3, 0.1), (2, 0.0, 2.0), (3, 0.5, 0.01), (2, 5.0, 1e4), (3, 0.2, 0.0)] {
            let (found, expected) = (PULSE.free(&law, dim, r, t), PULSE.fourier(0.3, dim, r, t));
            assert!((found - expected).abs() < 1e-14, "{dim} {r} {t}: {:e}", found - expected);
        }
    }

    #[test]
    fn memory_is_forgotten() {
        // Relative difference to Fourier's law O(τ/t); the model's measured value is 2.0e-3 at t = 500 τ.
        let (late, heat) =
            (PULSE.free(&Law::cattaneo(1.0, 1.0).unwrap(), 1, 0.0, 500.0), PULSE.fourier(1.0, 1, 0.0, 500.0));
        assert!((late / heat - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_box_is_free_space_until_the_walls_are_felt() {
        for share in [0.0, 0.3, 1.0] {
            let law = Law::new(0.02, 1.0, share).unwrap();
            for x in [0.0, 0.2, 0.35] {
                let free = PULSE.free(&law, 1, x, 1.0);
                assert!((PULSE.periodic(&law, 4.0, x, 1.0) - free).abs() < 1e-14);
                assert!((PULSE.closed(&law, 4.0, 2.0, 2.0 + x, 1.0) - free).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_wall_mirrors() {
        // Centred on the wall, the closed half is the free line twice.
        let law = Law::new(0.02, 1.0, 0.0).unwrap();
        assert!((PULSE.closed(&law, 4.0, 0.0, 0.3, 1.0) - 2.0 * PULSE.free(&law, 1, 0.3, 1.0)).abs() < 1e-13);
    }

    #[test]
    fn the_troughs_of_the_model() {
        // Least φ at t = τ/2 behind the front, F_T = 0: −0.069 in 2D, −0.057 in 3D.
        let law = Law::cattaneo(1.0, 1.0).unwrap();
        for (dim, expected) in [(2, -0.069), (3, -0.057)] {
            let least = (0..200).map(|i| PULSE.free(&law, dim, 0.004 * f64::from(i), 0.5)).fold(0.0, f64::min);
            assert!((least - expected).abs() < 1e-3, "{dim}: {least}");
        }
    }

    #[test]
    fn corners() {
        let law = Law::cattaneo(1.0, 1.0).unwrap();
        assert!(PULSE.free(&law, 4, 0.0, 1.0).is_nan() && PULSE.free(&law, 3, f64::NAN, 1.0).is_nan());
        assert!(PULSE.free(&law, 3, 1.0, f64::INFINITY).is_nan() && PULSE.free(&law, 3, f64::INFINITY, 1.0).is_nan());
        for sigma in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
            let pulse = Gaussian { height: 1.0, sigma };
            assert!(pulse.free(&law, 2, 0.3, 1.0).is_nan() && pulse.periodic(&law, 1.0, 0.3, 1.0).is_nan(), "{sigma}");
        }
        assert!(PULSE.periodic(&law, 0.0, 0.1, 1.0).is_nan() && PULSE.closed(&law, 1.0, f64::NAN, 0.0, 0.0).is_nan());
    }
}
