//! Where a moving medium stands against the speed of second sound: H_c = |u|/c (paper sec. 5, eq. 26).
//!
//! Below 1 a disturbance also travels upstream. Above 1 it is carried off faster than it spreads and stays inside a
//! cone behind its source, of half-angle asin(1/H_c), as sound stays inside a Mach cone. The cone is strict only for
//! F_T = 0. For 0 < F_T < 1 the law is parabolic: c is then the largest phase velocity of a travelling wave, the cone
//! is where most of the wave goes, and a diffuse halo of k_F surrounds it.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use crate::law::Law;

/// |H_c − 1| up to which a medium counts as critical. At 1e-6 the cone's half-angle is within 0.1° of 90°, and an
/// H_c of 1 that was computed from k, τ and u in decimal notation is recognised with certainty.
pub const CRITICAL_TOLERANCE: f64 = 1e-6;

/// How a law and the speed of its medium relate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Regime {
    /// No memory (τ = 0 or F_T = 1): no finite speed, H_c is not defined.
    Fourier,
    /// H_c < 1: the disturbance reaches every point, upstream too.
    Subcritical,
    /// H_c = 1 within [`CRITICAL_TOLERANCE`]: the front stands still upstream; half-angle 90°.
    Critical,
    /// H_c > 1: a wake.
    Supercritical {
        /// Half-angle of the wake asin(1/H_c) \[rad\].
        half_angle: f64,
    },
}

impl Regime {
    /// The regime of `law` in a medium of speed `medium_speed` = |u| \[m/s\]; the sign does not matter.
    ///
    /// A speed that is not a number gives a half-angle that is not a number.
    pub fn of(law: &Law, medium_speed: f64) -> Regime {
        match hc(law, medium_speed) {
            None => Regime::Fourier,
            Some(h) if (h - 1.0).abs() <= CRITICAL_TOLERANCE => Regime::Critical,
            Some(h) if h < 1.0 => Regime::Subcritical,
            Some(h) => Regime::Supercritical { half_angle: half_angle(h) },
        }
    }

    /// One word for tables.
    pub fn name(&self) -> &'static str {
        match self {
            Regime::Fourier => "fourier",
            Regime::Subcritical => "sub-critical",
            Regime::Critical => "critical",
            Regime::Supercritical { .. } => "super-critical",
        }
    }
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())?;
        if let Regime::Supercritical { half_angle } = self {
            write!(f, " (half-angle {:.1}°)", half_angle.to_degrees())?;
        }
        Ok(())
    }
}

/// H_c = |u|/c \[1\] for a medium of speed |u| \[m/s\]; `None` for a law without memory.
///
/// It is 0 in a medium at rest, and infinite if k = 0 and the medium moves.
pub fn hc(law: &Law, medium_speed: f64) -> Option<f64> {
    let u = medium_speed.abs();
    law.speed().map(|c| if u == 0.0 { 0.0 } else { u / c })
}

/// Half-angle of the wake asin(1/H_c) \[rad\]: H_c = 2/√3, √2, 2 give 60°, 45°, 30°. Not a number where there is no
/// wake (H_c < 1); π/2 within [`CRITICAL_TOLERANCE`] of 1.
pub fn half_angle(hc: f64) -> f64 {
    if (hc - 1.0).abs() <= CRITICAL_TOLERANCE { FRAC_PI_2 } else { (1.0 / hc.max(0.0)).asin() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::LawError;
    use approx::assert_relative_eq;

    #[test]
    fn the_papers_three_cones() {
        for (hc, degrees) in [(2.0 / 3f64.sqrt(), 60.0), (2f64.sqrt(), 45.0), (2.0, 30.0)] {
            assert_relative_eq!(half_angle(hc).to_degrees(), degrees, max_relative = 1e-14);
        }
        assert_eq!(half_angle(1.0), FRAC_PI_2);
        assert_eq!(half_angle(f64::INFINITY), 0.0);
        assert!(half_angle(0.9).is_nan() && half_angle(-2.0).is_nan() && half_angle(0.0).is_nan());
    }

    #[test]
    fn regimes_in_order() -> Result<(), LawError> {
        let law = Law::cattaneo(0.16, 1.0)?;
        assert_eq!(Regime::of(&law, 0.0), Regime::Subcritical);
        assert_eq!(Regime::of(&law, 0.39), Regime::Subcritical);
        assert_eq!(Regime::of(&law, -0.4), Regime::Critical);
        assert_eq!(Regime::of(&law, 0.8).to_string(), "super-critical (half-angle 30.0°)");
        assert_eq!(Regime::of(&Law::fourier(0.16)?, 0.8), Regime::Fourier);
        assert!(matches!(Regime::of(&law, f64::NAN), Regime::Supercritical { half_angle } if half_angle.is_nan()));
        Ok(())
    }

    #[test]
    fn nothing_spreads_at_zero_diffusivity() -> Result<(), LawError> {
        let law = Law::cattaneo(0.0, 1.0)?;
        assert_eq!(hc(&law, 0.0), Some(0.0));
        assert_eq!(Regime::of(&law, 1.0), Regime::Supercritical { half_angle: 0.0 });
        Ok(())
    }

    #[test]
    fn a_law_made_from_hc_has_it() -> Result<(), LawError> {
        for share in [0.0, 0.3, 0.9] {
            let law = Law::from_hc(1.0, 0.7, 0.3, share)?;
            assert_eq!(Regime::of(&law, 0.7), Regime::Critical);
        }
        Ok(())
    }
}
