//! `model.law`: from any two of k, tau and a speed to (k, tau, F_T).
//!
//! With c² = (1 − F_T)·k/tau: k = c²·tau/(1 − F_T) and tau = (1 − F_T)·k/c². The speed c
//! may come as H_c = |u|/c or as the half angle of the wake, sin(angle) = 1/H_c.

use super::{Checker, out_of_range};
use crate::error::{Detail, number};
use crate::scene::Law;
use crate::spec::{LawSpec, Medium};

const PATH: &str = "model.law";
const LEGAL: &str = "k and tau, or one of c, hc and cone_angle with tau or k";

/// Resolves the law; zeros where there are problems.
pub(super) fn law(check: &mut Checker<'_>, spec: &LawSpec, medium: &Medium) -> Law {
    let key = |name: &str| format!("{PATH}.{name}");
    let nothing = Law { k: 0.0, tau: 0.0, fourier: 0.0 };
    let fourier = spec.fourier;
    let share = (0.0..=1.0).contains(&fourier);
    check.require(share, &key("fourier"), || out_of_range("a share from 0 to 1", fourier));
    for (name, value) in [("k", spec.k), ("tau", spec.tau)] {
        if let Some(value) = value {
            check.not_negative(&key(name), value);
        }
    }
    let Some(speed) = speed(check, spec, medium) else { return nothing };
    if !check.problems.is_empty() {
        return nothing;
    }
    let law = match (spec.k, spec.tau, speed) {
        (Some(k), Some(tau), None) => Law { k, tau, fourier },
        (None, Some(tau), Some((name, c))) => {
            let moves = waves(check, name, fourier) && check.positive(&key("tau"), tau);
            if moves { Law { k: c * c * tau / (1.0 - fourier), tau, fourier } } else { nothing }
        }
        (Some(k), None, Some((name, c))) => {
            let moves = waves(check, name, fourier) && check.positive(&key("k"), k);
            if moves { Law { k, tau: (1.0 - fourier) * k / (c * c), fourier } } else { nothing }
        }
        (Some(_), Some(_), Some((name, _))) => {
            let detail = Detail::new(format!("k, tau and {name} together say too much")).expected(LEGAL);
            check.fail(&key(name), detail.advice("remove one, or set one to None"));
            nothing
        }
        (k, None, None) => {
            let given = if k.is_some() { "k alone does not say" } else { "nothing here says" };
            let detail = Detail::new(format!("{given} how fast phi spreads")).expected(LEGAL);
            check.fail(PATH, detail.advice("tau: 0 is Fourier's law"));
            nothing
        }
        (None, _, _) => {
            check.fail(PATH, Detail::new("one number is not enough to say how phi spreads").expected(LEGAL));
            nothing
        }
    };
    let finite = law.k.is_finite() && law.tau.is_finite() && law.speed().is_none_or(f64::is_finite);
    check.require(finite, PATH, || {
        let [k, tau, speed] = [law.k, law.tau, law.speed().unwrap_or(0.0)].map(number);
        Detail::new(format!("these numbers give k = {k}, tau = {tau} and c = {speed}")).expected("finite numbers")
    });
    law
}

/// The wave speed and the key it came from: `Some(None)` if none is given, `None` after a problem.
fn speed(check: &mut Checker<'_>, spec: &LawSpec, medium: &Medium) -> Option<Option<(&'static str, f64)>> {
    let given = [("c", spec.c), ("hc", spec.hc), ("cone_angle", spec.cone_angle)];
    let mut given = given.into_iter().filter_map(|(name, value)| Some((name, value?)));
    let Some((name, value)) = given.next() else { return Some(None) };
    let path = format!("{PATH}.{name}");
    if let Some((other, _)) = given.next() {
        let detail = Detail::new(format!("{name} and {other} both say how fast waves are")).expected(LEGAL);
        check.fail(&format!("{PATH}.{other}"), detail.advice("keep one of them"));
        return None;
    }
    if !check.positive(&path, value) {
        return None;
    }
    if name == "c" {
        return Some(Some((name, value)));
    }
    let flow = match medium {
        Medium::Uniform(u) => u.iter().map(|component| component * component).sum::<f64>().sqrt(),
        _ => 0.0,
    };
    let uniform = check.require(flow > 0.0, &path, || {
        Detail::new(format!("{name} is relative to a uniform flow, and the medium is not one"))
            .expected("medium: Uniform((u, v)) with a speed")
            .advice("give c instead")
    });
    let right = name != "cone_angle"
        || check.require(value <= 90.0, &path, || out_of_range("an angle above 0 up to 90 degrees", value));
    let c = if name == "hc" { flow / value } else { flow * value.to_radians().sin() };
    (uniform && right).then_some(Some((name, c)))
}

fn waves(check: &mut Checker<'_>, name: &str, fourier: f64) -> bool {
    check.require(fourier < 1.0, &format!("{PATH}.{name}"), || {
        Detail::new(format!("with fourier: 1 there are no waves, so {name} means nothing")).expected("k and tau")
    })
}
