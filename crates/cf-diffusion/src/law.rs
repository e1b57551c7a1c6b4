//! The Cattaneo-Fourier law: three numbers that say how a quantity spreads.
//!
//! ```text
//!     φ_t + ∇·(uφ) + ∇·q_C − ∇·(k_F ∇φ) = W                      k_F = F_T k
//!     τ (q_C,t + ∇·(q_C ⊗ u)) + q_C     = −k_C ∇φ                k_C = (1 − F_T) k
//! ```
//!
//! (paper eqs 4 and 9, rewritten with the memory-free part of the flux eliminated). The slow flux q_C needs a time τ
//! to follow the gradient, so a disturbance travels at c = √(k_C/τ); the share F_T of the diffusivity answers at
//! once, as Fourier's law does. F_T = 0 is Cattaneo's law, F_T = 1 is Fourier's, the rest is Jeffreys'.

use crate::error::LawError;

/// Diffusivity k \[m²/s\], relaxation time τ \[s\] and Fourier share F_T \[1\], checked once.
///
/// k ≥ 0, τ ≥ 0 and 0 ≤ F_T ≤ 1, all finite. k = 0 is a law in which nothing spreads: its speed is 0, and a slow
/// flux present at the start only decays, e^{−t/τ}. Whether a law has memory does not depend on k.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Numbers", into = "Numbers"))]
pub struct Law {
    k: f64,
    tau: f64,
    fourier: f64,
}

impl Law {
    /// A law from diffusivity `k` \[m²/s\], relaxation time `tau` \[s\] and Fourier share `fourier` in \[0, 1\].
    pub fn new(k: f64, tau: f64, fourier: f64) -> Result<Law, LawError> {
        Ok(Law {
            k: finite_from_zero("k [m^2/s]", k)?,
            tau: finite_from_zero("tau [s]", tau)?,
            fourier: if (0.0..=1.0).contains(&fourier) {
                fourier + 0.0
            } else {
                return Err(LawError::OutOfRange {
                    parameter: "fourier (F_T)",
                    found: fourier,
                    expected: "a share in [0, 1]",
                });
            },
        })
    }

    /// Fourier's law, q = −k ∇φ: F_T = 1, τ = 0.
    pub fn fourier(k: f64) -> Result<Law, LawError> {
        Law::new(k, 0.0, 1.0)
    }

    /// Cattaneo's law, τ q_t + q = −k ∇φ: F_T = 0.
    pub fn cattaneo(k: f64, tau: f64) -> Result<Law, LawError> {
        Law::new(k, tau, 0.0)
    }

    /// Jeffreys' law, the sum of both: the same as [`Law::new`], spelt out at the call.
    pub fn jeffreys(k: f64, tau: f64, fourier: f64) -> Result<Law, LawError> {
        Law::new(k, tau, fourier)
    }

    /// The law with the given speed c \[m/s\]: k = c² τ / (1 − F_T). It needs memory: τ > 0 and F_T < 1.
    pub fn from_speed(speed: f64, tau: f64, fourier: f64) -> Result<Law, LawError> {
        let speed = finite_from_zero("speed c [m/s]", speed)?;
        if !Law::new(0.0, tau, fourier)?.has_memory() {
            return Err(LawError::NoMemory { tau, fourier });
        }
        // In this order neither c² nor 1/(1 − F_T) overflows on its own.
        Law::new(speed * tau * (speed / (1.0 - fourier)), tau, fourier)
    }

    /// The law for which a medium moving at `medium_speed` = |u| \[m/s\] has the number H_c = |u|/c (paper sec. 5).
    pub fn from_hc(hc: f64, medium_speed: f64, tau: f64, fourier: f64) -> Result<Law, LawError> {
        let medium_speed = finite_from_zero("medium speed |u| [m/s]", medium_speed)?;
        if hc > 0.0 && hc.is_finite() {
            Law::from_speed(medium_speed / hc, tau, fourier)
        } else {
            Err(LawError::OutOfRange { parameter: "H_c", found: hc, expected: "a finite number above 0" })
        }
    }

    /// Total diffusivity k \[m²/s\].
    pub fn k(&self) -> f64 {
        self.k
    }

    /// Relaxation time τ \[s\].
    pub fn tau(&self) -> f64 {
        self.tau
    }

    /// Fourier share F_T, from 0 (Cattaneo) to 1 (Fourier).
    pub fn fourier_share(&self) -> f64 {
        self.fourier
    }

    /// The part of the diffusivity that answers at once, k_F = F_T k \[m²/s\].
    pub fn k_fourier(&self) -> f64 {
        self.fourier * self.k
    }

    /// The part of the diffusivity with memory, k_C = (1 − F_T) k \[m²/s\].
    pub fn k_cattaneo(&self) -> f64 {
        (1.0 - self.fourier) * self.k
    }

    /// Whether q_C is an unknown of its own: τ > 0 and F_T < 1. Otherwise the law is Fourier's with diffusivity k.
    pub fn has_memory(&self) -> bool {
        self.tau > 0.0 && self.fourier < 1.0
    }

    /// Speed of second sound c = √(k_C/τ) \[m/s\]; `None` without memory.
    ///
    /// For F_T = 0 no signal is faster. For 0 < F_T < 1 signals have no finite speed and c is the largest phase
    /// velocity of a travelling wave, reached at the wave number 1/√(k_F τ).
    pub fn speed(&self) -> Option<f64> {
        let (k_c, tau) = (self.k_cattaneo(), self.tau);
        let square = k_c / tau;
        // The quotient alone may leave the range of f64 where c itself does not.
        let speed = if square.is_normal() { square.sqrt() } else { k_c.sqrt() / tau.sqrt() };
        self.has_memory().then_some(speed)
    }
}

/// `value` if it is finite and not negative; −0 becomes 0, so that no later quotient changes sign.
fn finite_from_zero(parameter: &'static str, value: f64) -> Result<f64, LawError> {
    if value >= 0.0 && value.is_finite() {
        Ok(value + 0.0)
    } else {
        Err(LawError::OutOfRange { parameter, found: value, expected: "a finite number, 0 or more" })
    }
}

/// What is stored of a law: the arguments of [`Law::new`], checked again when read.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Numbers {
    k: f64,
    tau: f64,
    fourier: f64,
}

#[cfg(feature = "serde")]
impl TryFrom<Numbers> for Law {
    type Error = LawError;
    fn try_from(n: Numbers) -> Result<Law, LawError> {
        Law::new(n.k, n.tau, n.fourier)
    }
}

#[cfg(feature = "serde")]
impl From<Law> for Numbers {
    fn from(law: Law) -> Numbers {
        Numbers { k: law.k, tau: law.tau, fourier: law.fourier }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    #[test]
    fn what_is_refused_is_named() {
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(Law::new(bad, 1.0, 0.5).unwrap_err().to_string().starts_with("k [m^2/s] is"));
            assert!(Law::new(1.0, bad, 0.5).unwrap_err().to_string().starts_with("tau [s] is"));
            assert!(Law::from_speed(bad, 1.0, 0.5).unwrap_err().to_string().starts_with("speed c"));
            assert!(Law::from_hc(bad, 1.0, 1.0, 0.5).unwrap_err().to_string().starts_with("H_c"));
            assert!(Law::from_hc(1.0, bad, 1.0, 0.5).unwrap_err().to_string().starts_with("medium speed"));
        }
        for bad in [-1e-9, 1.0 + 1e-9, f64::NAN] {
            assert!(Law::new(1.0, 1.0, bad).unwrap_err().to_string().contains("a share in [0, 1]"));
        }
        assert!(matches!(Law::from_speed(1.0, 0.0, 0.5), Err(LawError::NoMemory { .. })));
        assert!(matches!(Law::from_speed(1.0, 1.0, 1.0), Err(LawError::NoMemory { .. })));
        assert!(Law::from_hc(0.0, 1.0, 1.0, 0.0).is_err());
        let text = Law::cattaneo(-2.0, 1.0).unwrap_err().to_string();
        assert_eq!(text, "k [m^2/s] is -2e0, expected a finite number, 0 or more");
    }

    #[test]
    fn only_memory_gives_a_speed() -> Result<(), LawError> {
        assert_eq!(Law::fourier(1.0)?.speed(), None);
        assert_eq!(Law::cattaneo(1.0, 0.0)?.speed(), None);
        assert_eq!(Law::jeffreys(1.0, 1.0, 1.0)?.speed(), None);
        assert_eq!(Law::cattaneo(0.0, 1.0)?.speed(), Some(0.0));
        assert_eq!(Law::jeffreys(4.0, 3.0, 0.25)?.speed(), Some(1.0));
        assert!(Law::cattaneo(-0.0, 1.0)?.k().is_sign_positive());
        Ok(())
    }

    #[test]
    fn the_speed_exists_where_its_square_does_not() -> Result<(), LawError> {
        assert_relative_eq!(Law::cattaneo(1e300, 1e-300)?.speed().unwrap(), 1e300, max_relative = 1e-15);
        assert_relative_eq!(Law::cattaneo(1e-300, 1e300)?.speed().unwrap(), 1e-300, max_relative = 1e-15);
        Ok(())
    }

    proptest! {
        #[test]
        fn a_speed_makes_a_law_with_that_speed(c in -30.0..30.0f64, tau in -30.0..30.0f64, share in 0.0..0.999_999f64) {
            let c = 10f64.powf(c);
            let found = Law::from_speed(c, 10f64.powf(tau), share).unwrap().speed().unwrap();
            prop_assert!((found / c - 1.0).abs() < 1e-14);
        }

        #[test]
        fn both_parts_add_up(k in -30.0..30.0f64, share in 0.0..=1.0f64) {
            let law = Law::new(10f64.powf(k), 1.0, share).unwrap();
            prop_assert!(((law.k_fourier() + law.k_cattaneo()) / law.k() - 1.0).abs() < 1e-15);
        }
    }
}
