//! What the measurements must show.

use super::orders::{Row, WITHIN};
use super::setting::{Measured, Scheme, cheapest};

/// A statement and what was found.
pub struct Claim {
    /// The statement.
    pub name: String,
    /// What was measured.
    pub measured: String,
    /// Whether it holds.
    pub pass: bool,
}

/// The table of 6.1.
pub fn table(rows: &[Row]) -> Claim {
    let off: Vec<String> = rows
        .iter()
        .filter(|row| !row.pass())
        .map(|r| format!("{} {} steps, {}: {:.2e} for {:.1e}", r.scheme, r.steps, r.law, r.measured, r.expected))
        .collect();
    let measured = match off.as_slice() {
        [] => format!("all {} numbers", rows.len()),
        off => format!("{} of {} numbers; not {}", rows.len() - off.len(), rows.len(), off.join("; ")),
    };
    Claim {
        name: format!("errors in time as in model 6.1, within {:.0} %", 100.0 * WITHIN),
        measured,
        pass: off.is_empty(),
    }
}

/// The error at which both are compared.
const ERROR: f64 = 1e-2;
/// How many times cheaper the standard setting must be.
const CHEAPER: f64 = 20.0;

/// P1, 2D, F_T = 0: the cheapest standard setting against the cheapest of the paper's scheme.
pub fn cheaper(rows: &[Measured]) -> Claim {
    let of = |standard: bool| {
        let counts = move |m: &&Measured| {
            let chosen = if standard { m.setting.is_standard() } else { m.setting.scheme == Scheme::PaperBe };
            m.problem == "P1 2D, F_T = 0" && chosen
        };
        cheapest(rows.iter().filter(counts), ERROR)
    };
    let name =
        format!("P1 2D, F_T = 0: at an error of {ERROR:e} standard is at least {CHEAPER} times cheaper than PaperBe");
    match (of(true), of(false)) {
        (Some(ours), Some(paper)) => {
            let ratio = paper.seconds / ours.seconds;
            let measured = format!("{ratio:.0} times: {} against {}", ours.words(), paper.words());
            Claim { name, measured, pass: ratio >= CHEAPER }
        }
        (Some(ours), None) => {
            let tried = rows.iter().filter(|m| m.problem == "P1 2D, F_T = 0" && m.setting.scheme == Scheme::PaperBe);
            let closest = tried.min_by(|a, b| a.error.total_cmp(&b.error));
            let ratio = closest.map_or(f64::NAN, |paper| paper.seconds / ours.seconds);
            let error = closest.map_or(f64::NAN, |paper| paper.error);
            let measured = format!(
                "more than {ratio:.0} times: {} reached it, PaperBe did not: {error:.1e} at best",
                ours.words()
            );
            Claim { name, measured, pass: ratio >= CHEAPER }
        }
        _ => Claim { name, measured: "no standard setting reached it".into(), pass: false },
    }
}

/// P2: no overshoot of the front scheme, a smeared PaperBe, ringing central schemes.
pub fn fronts(rows: &[Measured]) -> Vec<Claim> {
    let of = |problem: &'static str, scheme: Scheme| {
        rows.iter().filter(move |m| m.problem == problem && m.setting.scheme == scheme)
    };
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
    // At c dt/h = 0.5, the limit of the scheme in more than one dimension.
    let slow = |m: &&Measured| m.courant <= 0.51;
    let front = most(&mut of("P2 line", Scheme::Front).map(|m| m.ringing));
    let disc = most(&mut of("P2 disc", Scheme::Front).filter(slow).map(|m| m.overshoot));
    let smeared = most(&mut of("P2 line", Scheme::PaperBe).map(|m| m.width));
    let sharp = most(&mut of("P2 line", Scheme::Front).map(|m| m.width));
    let central = of("P2 line", Scheme::Kdk).chain(of("P2 line", Scheme::Sdirk2));
    let ringing = central.map(|m| m.ringing).fold(f64::INFINITY, f64::min);
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    vec![
        Claim {
            name: "P2 line: the front scheme overshoots by at most 0.1 % of the jump".into(),
            measured: percent(front),
            pass: front <= 1e-3,
        },
        Claim {
            name: "P2 disc: the front scheme at c dt/h = 0.5 exceeds the maximum by at most 0.1 %".into(),
            measured: percent(disc),
            pass: disc <= 1e-3,
        },
        Claim {
            name: "P2 line: PaperBe smears the front over 20 cells".into(),
            measured: format!("{smeared:.1} cells; the front scheme {sharp:.1}"),
            pass: smeared >= 20.0,
        },
        Claim {
            name: "P2 line: central schemes (Kdk, Sdirk2) ring by more than 10 % of the jump".into(),
            measured: format!("at least {}", percent(ringing)),
            pass: ringing > 0.1,
        },
    ]
}
