//! A disc with a sharp edge under Cattaneo's law (F_T = 0) in the plane, from the Green's function.
//!
//! φ₀ = 1 within the radius R, q₀ = 0. With a = 1/2τ and c = √(k/τ),
//!
//! ```text
//!     φ = U_t + U/τ,    U(r,t) = (e^{−at}/c) ∫₀^{ct} cosh((a/c) √(c²t² − s²)) / √(c²t² − s²) A(s; r) s ds
//! ```
//!
//! where A(s; r) is the share of the circle of radius s around a point at distance r that lies in the disc: 1 or 0 by a
//! wide margin, arccos((s² + r² − R²)/2sr)/π between. Where the whole circle lies inside, the integral is elementary.
//!
//! Once the inner front has passed the centre, ct > R, φ has a logarithmic singularity on the circle r = ct − R that
//! points down: a focus turns a jump into one. Means over cells exist and are what a scheme on cells should find. The
//! maximum is finite; it is the front that leaves, r = ct + R, or the plateau that no wave has reached.

use cf_diffusion::Law;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// The disc of one law: radius R \[m\], speed c \[m/s\], damping a = 1/2τ \[1/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    radius: f64,
    c: f64,
    a: f64,
}

impl Disc {
    /// A disc of `radius` \[m\] under `law`; `None` unless F_T = 0, τ > 0, k > 0 and the radius is above 0.
    pub fn new(law: &Law, radius: f64) -> Option<Self> {
        let c = law.speed().filter(|&c| c > 0.0 && law.fourier_share() == 0.0)?;
        (radius > 0.0).then(|| Self { radius, c, a: 0.5 / law.tau() })
    }

    /// U at `r` \[m\] and `t` \[s\], the response to a rate of change of 1 in the disc \[s\]. Absolute error 1e-12 t.
    pub fn response(&self, r: f64, t: f64) -> f64 {
        let (reach, at) = (self.c * t, self.a * t);
        // In the angle θ, s = ct sin θ, the root disappears.
        let angle = |s: f64| (s / reach).clamp(0.0, 1.0).asin();
        let (near, far) = (angle((self.radius - r).abs()), angle(self.radius + r));
        // ∫ cosh(at cos θ) sin θ dθ = −sinh(at cos θ)/at, while the whole circle is inside.
        let whole = if r < self.radius { (at.sinh() - (at * near.cos()).sinh()) / at } else { 0.0 };
        let share = |s: f64| ((s * s + r * r - self.radius * self.radius) / (2.0 * s * r)).clamp(-1.0, 1.0).acos() / PI;
        let part = between(near, far, |theta| (at * theta.cos()).cosh() * theta.sin() * share(reach * theta.sin()));
        (-at).exp() * t * (whole + part)
    }

    /// φ at `r` and `t`, averaged over the times t ± `window` \[s\]: that takes the singularity off.
    pub fn phi(&self, r: f64, t: f64, window: f64) -> f64 {
        let [before, now, after] = [t - window, t, t + window].map(|t| self.response(r, t));
        0.5 * (after - before) / window + 2.0 * self.a * now
    }

    /// Means of φ at `t` over the squares of edge `h` \[m\] of the quarter plane x, y > 0, `n` by `n` of them from the
    /// centre on, x contiguous: φ on [`FINER`]² points of each, from a table of r.
    pub fn means(&self, n: usize, h: f64, t: f64) -> Vec<f64> {
        let fine = h / FINER as f64;
        let count = (std::f64::consts::SQRT_2 * (n * FINER) as f64) as usize + 3;
        let table: Vec<f64> =
            (0..count).into_par_iter().map(|i| self.phi(i as f64 * fine, t, 0.5 * fine / self.c)).collect();
        let at = |x: f64, y: f64| {
            let r = x.hypot(y) / fine;
            let (i, rest) = (r as usize, r.fract());
            table[i] + rest * (table[i + 1] - table[i])
        };
        let mean = |place: usize| {
            let [i, j] = [place % n, place / n].map(|i| i * FINER);
            let point = |s: usize| at(((i + s % FINER) as f64 + 0.5) * fine, ((j + s / FINER) as f64 + 0.5) * fine);
            (0..FINER * FINER).map(point).sum::<f64>() / (FINER * FINER) as f64
        };
        (0..n * n).into_par_iter().map(mean).collect()
    }
}

/// Points per cell and axis behind a mean.
pub const FINER: usize = 16;

/// ∫ of a function with square roots at its ends, by the tanh-sinh rule.
fn between(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 1.0 / 16.0;
    if high <= low {
        return 0.0;
    }
    let half = 0.5 * (high - low);
    let term = |i: i32| {
        let x = f64::from(i) * STEP;
        let inner = FRAC_PI_2 * x.sinh();
        let weight = FRAC_PI_2 * x.cosh() / inner.cosh().powi(2);
        weight * f(low + half * (1.0 + inner.tanh()))
    };
    half * STEP * (-50..=50).map(term).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc() -> Disc {
        Disc::new(&Law::cattaneo(1.0, 1.0).unwrap(), 0.4).unwrap()
    }

    #[test]
    fn the_quadrature_knows_roots_and_smooth_functions() {
        assert!((between(0.0, 1.0, f64::sqrt) - 2.0 / 3.0).abs() < 1e-12);
        assert!((between(0.0, 2.0, |x| (x * (2.0 - x)).sqrt()) - FRAC_PI_2).abs() < 1e-12);
        assert!((between(-1.0, 1.0, f64::exp) - 2.0 * 1f64.sinh()).abs() < 1e-12);
    }

    #[test]
    fn before_the_front_comes_nothing_happens_and_beyond_it_nothing_is() {
        assert!((disc().phi(0.1, 0.25, 1e-4) - 1.0).abs() < 1e-7);
        assert_eq!(disc().phi(1.01, 0.6, 1e-4), 0.0);
    }

    /// At the centre the integral is elementary: U = e^{−at} [sinh(at) − sinh(a √(t² − R²))]/a for c = 1, t > R.
    #[test]
    fn the_centre_has_a_closed_form() {
        let u = |t: f64| (-0.5 * t).exp() * 2.0 * ((0.5 * t).sinh() - (0.5 * (t * t - 0.16).sqrt()).sinh());
        let exact = (u(0.6001) - u(0.5999)) / 2e-4 + u(0.6);
        assert!((disc().phi(1e-9, 0.6, 1e-4) - exact).abs() < 1e-6, "{}", disc().phi(1e-9, 0.6, 1e-4));
    }

    #[test]
    fn mass_stays_and_the_maximum_is_that_of_the_hankel_transform() {
        let (n, h) = (128, 2.4 / 256.0);
        let means = disc().means(n, h, 0.6);
        let mass = 4.0 * means.iter().sum::<f64>() * h * h;
        assert!((mass / (PI * 0.16) - 1.0).abs() < 1e-4, "{mass}");
        // R ∫ J₁(KR) J₀(Kr) g(K,t) dK in bins of h/16, summed over cells by another program: 0.23428.
        let most = means.iter().fold(0.0f64, |m, v| m.max(*v));
        assert!((most - 0.23428).abs() < 2e-4, "{most}");
    }
}
