//! What the measurements must show.

use super::tables::{Listed, WITHIN};
use super::write::words;
use cf_fluid::Scheme as Flow;
use cf_tradeoff::{Level, Measured, Scheme, best, cheapest};

/// A statement and what was found.
pub struct Claim {
    /// The statement.
    pub name: String,
    /// What was measured.
    pub measured: String,
    /// Whether it holds.
    pub pass: bool,
}

/// A table of the specification; numbers that differ for a known reason are listed and do not fail it.
pub fn table(table: &Listed) -> Claim {
    let differ = table.rows.iter().filter(|row| !row.pass());
    let (known, unknown): (Vec<_>, Vec<_>) = differ.partition(|row| row.reason.is_some());
    let agree = table.rows.len() - known.len() - unknown.len();
    let mut measured = format!("{agree} of {} numbers", table.rows.len());
    if let Some(reason) = known.first().and_then(|row| row.reason) {
        measured += &format!("; {} differ: {reason}", known.len());
    }
    for r in &unknown {
        measured += &format!("; {}, {}, {}: {:.2e} for {:.1e}", r.case, r.scheme, r.quantity, r.measured, r.expected);
    }
    Claim {
        name: format!("{} as specified, within {:.0} % or with the reason why not", table.name, 100.0 * WITHIN),
        measured,
        pass: unknown.is_empty(),
    }
}

/// The problem on which both are compared, and the error.
const WAVES: &str = "P1 2D, F_T = 0, tau = 1 s";
const ERROR: f64 = 1e-2;
/// How many times cheaper the standard level must be.
const CHEAPER: f64 = 20.0;

/// The wall time at which the best of some measurements pass an error, by logarithms between two of them.
pub fn time_at(rows: &[&Measured], error: f64) -> Option<f64> {
    let points = best(rows);
    let after = points.iter().position(|p| p[1] <= error)?;
    let [time, reached] = points[after];
    let Some([earlier, larger]) = after.checked_sub(1).map(|i| points[i]) else { return Some(time) };
    let share = (larger / error).ln() / (larger / reached).ln();
    Some(earlier * (time / earlier).powf(share))
}

/// P1, 2D, F_T = 0: the standard level against the paper's scheme at one error, each on its own front.
pub fn cheaper(rows: &[Measured]) -> Claim {
    let of = |chosen: fn(&Measured) -> bool| -> Vec<&Measured> {
        rows.iter().filter(|m| m.problem == WAVES && chosen(m)).collect()
    };
    let standard = of(|m| m.setting.level == Some(Level::Standard));
    let paper = of(|m| m.setting.scheme == Scheme::PaperBe);
    let name = format!("{WAVES}: at an error of {ERROR:e} standard is at least {CHEAPER} times cheaper than PaperBe");
    let (Some(ours), Some(theirs)) = (time_at(&standard, ERROR), time_at(&paper, ERROR)) else {
        let least = |rows: &[&Measured]| rows.iter().map(|m| m.error).fold(f64::INFINITY, f64::min);
        let measured =
            format!("not both reached it: standard {:.1e}, PaperBe {:.1e} at best", least(&standard), least(&paper));
        return Claim { name, measured, pass: false };
    };
    let ratio = theirs / ours;
    let first = |rows: &[&Measured]| cheapest(rows.iter().copied(), ERROR).map(words).unwrap_or_default();
    let measured = format!(
        "{ratio:.0} times at equal error: {} against {} between neighbours on each front; the first to reach it: {}; {}",
        crate::show::seconds(ours),
        crate::show::seconds(theirs),
        first(&standard),
        first(&paper)
    );
    Claim { name, measured, pass: ratio >= CHEAPER }
}

/// P2: no overshoot of the front scheme, a smeared PaperBe, ringing central schemes.
pub fn fronts(rows: &[Measured]) -> Vec<Claim> {
    let of = |problem: &'static str, scheme: Scheme| {
        rows.iter().filter(move |m| m.problem == problem && m.setting.scheme == scheme)
    };
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
    // At c dt/h = 0.5, what the scheme allows itself in more than one dimension.
    let slow = |m: &&Measured| m.courant <= 0.51;
    let front = most(&mut of("P2 line", Scheme::Front).map(|m| m.ringing));
    let disc = most(&mut of("P2 disc", Scheme::Front).filter(slow).map(|m| m.overshoot));
    let fast = most(&mut of("P2 disc", Scheme::Front).filter(|m| !slow(m)).map(|m| m.overshoot));
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
            name: "P2 disc: the front scheme at c dt/h = 0.5, its limit, exceeds the largest exact value by at most 0.1 % of \
                   the jump"
                .into(),
            measured: format!("{}; at 0.9, which it does not allow itself, {}", percent(disc), percent(fast)),
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

/// P3: the angle of the cone in the solution and in the front scheme, on the finest grid.
pub fn cones(rows: &[Measured], angles: &[(String, usize, f64)]) -> Vec<Claim> {
    let mut claims = Vec::new();
    let finest = |problem: &str| angles.iter().filter(|(p, ..)| p == problem).map(|(_, n, _)| *n).max();
    for (problem, n, exact) in angles.iter().filter(|(problem, n, a)| !a.is_nan() && finest(problem) == Some(*n)) {
        let of = |scheme: Scheme| {
            rows.iter().filter(move |m| &m.problem == problem && m.cells[0] == *n && m.setting.scheme == scheme)
        };
        let front = of(Scheme::Front).map(|m| m.angle).fold(f64::NAN, f64::max);
        let paper = of(Scheme::PaperBe).map(|m| m.angle).fold(f64::NAN, f64::max);
        claims.push(Claim {
            // Half of what figure 3 asks for.
            name: format!(
                "{problem}: the front scheme has the cone of the solution to 0.5 degrees, nearer than PaperBe"
            ),
            measured: format!("{front:.2} for {exact:.2} degrees; PaperBe up to {paper:.2}"),
            pass: (front - exact).abs() <= 0.5 && (front - exact).abs() < (paper - exact).abs(),
        });
    }
    claims
}

/// The problem on which the schemes of the fluid are compared, and how many times cheaper the default must be.
const VORTICES: &str = "P5 vortices";
const CHEAPER_FLOW: f64 = 5.0;

/// P5: the default scheme of a fluid against the one that scenes take for drafts, at one error.
pub fn fluids(rows: &[Measured]) -> Claim {
    let at = |flow: Flow| {
        let own: Vec<&Measured> =
            rows.iter().filter(|m| m.problem == VORTICES && m.setting.flow == Some(flow)).collect();
        time_at(&own, ERROR)
    };
    let name = format!("{VORTICES}: at an error of {ERROR:e} Cnp is at least {CHEAPER_FLOW} times cheaper than Draft");
    let time = |flow| at(flow).map_or_else(|| "not reached".into(), crate::show::seconds);
    let measured = [Flow::Draft, Flow::Cnp, Flow::ReflectionExtrapolated, Flow::CentralRk4]
        .map(|flow| format!("{flow:?} {}", time(flow)))
        .join(", ");
    let ratio = at(Flow::Draft).zip(at(Flow::Cnp)).map(|(draft, own)| draft / own);
    Claim { name, measured, pass: ratio.is_some_and(|ratio| ratio >= CHEAPER_FLOW) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_tradeoff::{Problem, Setting};

    #[test]
    fn times_are_read_between_two_measurements() {
        let problem = Problem::line(8).unwrap();
        let (measured, _) = problem.measure(&Setting::new(Scheme::Kdk, 8, 1), 1).unwrap();
        let at = |seconds, error| Measured { seconds, error, ..measured.clone() };
        let all = [at(1.0, 1e-1), at(100.0, 1e-3), at(50.0, 0.5)];
        let rows: Vec<&Measured> = all.iter().collect();
        assert!((time_at(&rows, 1e-2).unwrap() - 10.0).abs() < 1e-12);
        assert_eq!(time_at(&rows, 0.2), Some(1.0));
        assert_eq!(time_at(&rows, 1e-4), None);
    }
}
