//! Claims against results: what each statement says, measured. What cannot be measured does not hold.

mod cone;
mod order;
mod reach;
mod sample;

pub(crate) use reach::Upstream;

use crate::kept::Kept;
use crate::run::{Evidence, Front, Needs};
use crate::scene::Scene;
use crate::spec::{Claim, ClaimSource, Direction, Kind, Quantity, Statement};
use crate::summary::{ClaimResult, FLOW_FIELDS, FlowSummary, RunSummary};
use sample::Sample;

/// A run with what it left.
pub(crate) type Run<'a> = (&'a Scene, &'a RunSummary, &'a Evidence);

/// What the claims need of a run.
pub(crate) fn needs(run: &str, claims: &[Claim]) -> Needs {
    let mut needs = Needs::default();
    for claim in claims {
        match &claim.statement {
            Statement::ConeAngle { run: name, .. }
            | Statement::NoUpstreamTail { run: name, .. }
            | Statement::Within { run: name, .. } => needs.phi |= name == run,
            Statement::Ratio { runs: (a, b), .. } => needs.phi |= a == run || b == run,
            Statement::Monotone { runs, .. } => needs.phi |= runs.iter().any(|name| name == run),
            Statement::EqualBits { runs: (a, b) } => {
                let named = a == run || b == run;
                (needs.phi, needs.flux) = (needs.phi | named, needs.flux | named);
            }
            Statement::Order { runs, reference, .. } => {
                needs.phi |= reference == run || runs.iter().any(|name| name == run);
            }
            Statement::MassBudget { .. }
            | Statement::Divergence { .. }
            | Statement::Iterations { .. }
            | Statement::FlowIterations { .. }
            | Statement::NoPressure => {}
            Statement::Front { run: name, fraction, .. } if name == run => {
                // The smallest share reaches furthest: what holds for it holds for all.
                needs.front = Some(needs.front.map_or(*fraction, |other: f64| other.min(*fraction)));
            }
            Statement::Front { .. } => {}
            Statement::Speed { run: name, .. } => {
                let named = name == run;
                (needs.phi, needs.half) = (needs.phi | named, needs.half | named);
            }
        }
    }
    needs
}

/// What a statement came to.
#[derive(Debug, Default)]
struct Finding {
    expected: String,
    measured: String,
    value: Option<f64>,
    tolerance: Option<f64>,
    pass: bool,
}

/// Checks a claim.
pub(crate) fn check(claim: &Claim, runs: &[Run<'_>]) -> ClaimResult {
    let finding = match statement(&claim.statement, runs) {
        Ok(finding) => finding,
        Err(reason) => Finding { measured: format!("not measurable: {reason}"), ..expectation(&claim.statement) },
    };
    let (kind, reason) = match &claim.kind {
        Kind::Must => ("Must", None),
        Kind::Report => ("Report", None),
        Kind::KnownFalse(reason) => ("KnownFalse", Some(reason.clone())),
    };
    ClaimResult {
        name: claim.name.clone(),
        source: match claim.source {
            ClaimSource::Paper => "Paper".into(),
            ClaimSource::Ours => "Ours".into(),
        },
        kind: kind.into(),
        reason,
        expected: finding.expected,
        measured: finding.measured,
        value: finding.value,
        of_the_machine: claim.statement.of_the_machine(),
        tolerance: finding.tolerance,
        pass: finding.pass,
    }
}

/// What a statement expects, in words.
fn expectation(statement: &Statement) -> Finding {
    let (expected, tolerance) = match statement {
        Statement::ConeAngle { expected, tolerance, .. } => {
            (format!("a half angle of {expected}° within {tolerance}°"), Some(*tolerance))
        }
        Statement::NoUpstreamTail { cells, fraction, .. } => (
            format!("|phi| at most {fraction:e} of its maximum further than {cells} cells upstream of the source"),
            Some(*fraction),
        ),
        Statement::Within { quantity, low, high, .. } => (format!("{}{}", words(quantity), range(*low, *high)), None),
        Statement::Ratio { quantity, runs: (a, b), low, high } => {
            (format!("{} of {a} divided by that of {b}{}", words(quantity), range(*low, *high)), None)
        }
        Statement::NoPressure => ("no bytes for a flow and no projection in any run".into(), Some(0.0)),
        Statement::Monotone { quantity, runs, direction } => {
            let way = match direction {
                Direction::Rising => "rising",
                Direction::Falling => "falling",
            };
            (format!("{} {way} over {}", words(quantity), runs.join(", ")), None)
        }
        Statement::EqualBits { runs: (a, b) } => (format!("{a} and {b} end with the same bits"), None),
        Statement::Order { parameter, expected, tolerance, .. } => {
            (format!("distance ~ {parameter:?}^{expected} within {tolerance}"), Some(*tolerance))
        }
        Statement::MassBudget { tolerance } => {
            let of = "of the largest of the sum of |phi|, what was emitted, and what was there at the start";
            (format!("nothing missing beyond {tolerance:e} {of}"), Some(*tolerance))
        }
        Statement::Divergence { most } => {
            (format!("max|div u| dt at most {most:e} after every projection of every run"), Some(*most))
        }
        Statement::Iterations { most } => {
            (format!("at most {most} iterations a solve in every step of every run"), Some(*most as f64))
        }
        Statement::FlowIterations { most } => {
            (format!("at most {most} iterations a projection in every step of every run"), Some(*most as f64))
        }
        Statement::Front { run, fraction, cells } => (
            format!(
                "in {run}, |phi| above {fraction:e} of its maximum never further from its sources than \
                 ∫ max|u| dt + c t and {cells} cells"
            ),
            None,
        ),
        Statement::Speed { expected, tolerance, front, .. } => {
            let front = if *front == crate::spec::Front::Fore { "fore" } else { "aft" };
            (format!("the {front} pulse at {expected} m/s within {tolerance}"), Some(*tolerance))
        }
    };
    Finding { expected, tolerance, ..Finding::default() }
}

fn range(low: Option<f64>, high: Option<f64>) -> String {
    match (low, high) {
        (Some(low), Some(high)) => format!(" from {low} to {high}"),
        (Some(low), None) => format!(" at least {low}"),
        (None, Some(high)) => format!(" at most {high}"),
        (None, None) => String::new(),
    }
}

fn words(quantity: &Quantity) -> String {
    match quantity {
        Quantity::Mass => "mass [P m^D]".into(),
        Quantity::Maximum => "largest phi [P]".into(),
        Quantity::Minimum => "smallest phi [P]".into(),
        Quantity::RadiusOfGyration => "radius of gyration [m]".into(),
        Quantity::RadiusAbout(axis) => format!("radius about {} [m]", ["x", "y", "z"][axis.index()]),
        Quantity::Centre(axis) => format!("mean {} of phi [m]", ["x", "y", "z"][axis.index()]),
        Quantity::EnergyPerWork => "kinetic energy per work of buoyancy and force".into(),
        Quantity::DiffusionSeconds => "diffusion of a step [s]".into(),
        Quantity::PeakMemory => "peak memory of the program [GB]".into(),
        Quantity::UpstreamLeak { cells, .. } => format!("share of |phi| further than {cells} cells upstream"),
        Quantity::OutsideCone { .. } => "share of |phi| out of reach of the source's signals".into(),
    }
}

fn statement(statement: &Statement, runs: &[Run<'_>]) -> Result<Finding, String> {
    let mut finding = expectation(statement);
    let near = |value: f64, expected: f64, tolerance: f64| (value - expected).abs() <= tolerance;
    match statement {
        Statement::ConeAngle { run, expected, tolerance, source, rows } => {
            let run = find(runs, run)?;
            let angle = cone::half_angle(&phi(run)?, &reach::flow(run.0)?, source, *rows)?;
            finding.pass = near(angle.degrees, *expected, *tolerance);
            finding.measured =
                format!("{:.2}° ({:.2}° to {:.2}° over {} sides)", angle.degrees, angle.least, angle.most, angle.sides);
            finding.value = Some(angle.degrees);
        }
        Statement::NoUpstreamTail { run, source, cells, fraction } => {
            let run = find(runs, run)?;
            let sample = phi(run)?;
            let all = sample.phi.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let behind = reach::upstream(&sample, run.0, *source, *cells)?;
            let tail = behind.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let share = if all > 0.0 { tail / all } else { return Err("phi is zero everywhere".into()) };
            finding.pass = share <= *fraction;
            finding.measured = format!("{share:.3e} of the maximum");
            finding.value = Some(share);
        }
        Statement::Within { quantity, run, low, high } => {
            let value = measure(*quantity, find(runs, run)?)?;
            finding.pass = between(value, *low, *high);
            finding.measured = number(value);
            finding.value = Some(value);
        }
        Statement::Ratio { quantity, runs: (a, b), low, high } => {
            let (a, b) = (measure(*quantity, find(runs, a)?)?, measure(*quantity, find(runs, b)?)?);
            let ratio = if b == 0.0 { return Err("the second of the two is zero".into()) } else { a / b };
            finding.pass = between(ratio, *low, *high);
            finding.measured = format!("{} ({} by {})", number(ratio), number(a), number(b));
            finding.value = Some(ratio);
        }
        Statement::NoPressure => {
            let of_flow = |run: &RunSummary| {
                let stored = run.fields.iter().filter(|field| field.name == FLOW_FIELDS).map(|field| field.bytes);
                (stored.sum::<u64>(), run.flow.as_ref().map_or(0, |flow| flow.projections.solves))
            };
            let (bytes, projections) =
                runs.iter().map(|run| of_flow(run.1)).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            finding.pass = bytes == 0 && projections == 0;
            finding.measured = format!("{bytes} bytes and {projections} projections in {} runs", runs.len());
            finding.value = Some(bytes as f64);
        }
        Statement::Monotone { quantity, runs: names, direction } => {
            let values =
                names.iter().map(|name| measure(*quantity, find(runs, name)?)).collect::<Result<Vec<_>, _>>()?;
            finding.pass = values.windows(2).all(|pair| match direction {
                Direction::Rising => pair[0] < pair[1],
                Direction::Falling => pair[0] > pair[1],
            });
            finding.measured = values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", ");
        }
        Statement::EqualBits { runs: (a, b) } => {
            let (a, b) = (find(runs, a)?, find(runs, b)?);
            let differing = differing(a, b)?;
            finding.pass = differing == 0;
            finding.measured = match differing {
                0 => "equal".into(),
                count => format!("{count} numbers differ"),
            };
            finding.value = Some(differing as f64);
        }
        Statement::Order { parameter, runs: names, reference, expected, tolerance } => {
            let reference = phi(find(runs, reference)?)?;
            let mut points = Vec::new();
            for name in names {
                let run = find(runs, name)?;
                let knob = crate::check::read(*parameter, run.0).ok_or("the parameter has no value")?;
                points.push((knob, order::distance(&phi(run)?, &reference)?));
            }
            let power = order::power(&points)?;
            finding.pass = near(power, *expected, *tolerance);
            let distances: Vec<String> = points.iter().map(|(_, distance)| format!("{distance:.3e}")).collect();
            finding.measured = format!("power {power:.3}; distances {}", distances.join(", "));
            finding.value = Some(power);
        }
        Statement::MassBudget { tolerance } => {
            let worst = runs.iter().map(|(_, summary, _)| (summary.mass.drift.abs(), &summary.name));
            let worst = worst.max_by(|a, b| a.0.total_cmp(&b.0)).ok_or("there is no run")?;
            finding.pass = worst.0 <= *tolerance;
            finding.measured = format!("{:.2e} at most, in {}", worst.0, worst.1);
            finding.value = Some(worst.0);
        }
        Statement::Divergence { most } => {
            let (divergence, run) = worst(runs, |flow| flow.divergence)?;
            finding.pass = divergence <= *most;
            finding.measured = format!("{divergence:.2e} at most, in {run}");
            finding.value = Some(divergence);
        }
        Statement::Iterations { most } => {
            let solving = runs.iter().filter(|(_, summary, _)| summary.iterations.solves > 0);
            let most_of = |run: &&Run<'_>| run.1.iterations.max;
            let worst = solving.max_by_key(most_of).ok_or("no run solves a system")?;
            let iterations = worst.1.iterations.max;
            finding.pass = iterations <= *most;
            finding.measured = format!("{iterations} at most, in {}", worst.1.name);
            finding.value = Some(iterations as f64);
        }
        Statement::FlowIterations { most } => {
            let (iterations, run) = worst(runs, |flow| flow.projections.max as f64)?;
            finding.pass = iterations <= *most as f64;
            finding.measured = format!("{iterations} at most, in {run}");
            finding.value = Some(iterations);
        }
        Statement::Front { run, fraction, cells } => {
            let run = find(runs, run)?;
            let c = crate::check::front_speed(run.0).ok_or("signals have no speed")?;
            let slack = *cells as f64 * run.0.grid.spacing;
            let fronts = run.2.fronts.iter().filter(|front| front.fraction <= *fraction && front.time > 0.0);
            let allowed = |front: &Front| front.carried + c * front.time;
            let nearest = fronts.max_by(|a, b| (a.reach - allowed(a)).total_cmp(&(b.reach - allowed(b))));
            let nearest = nearest.ok_or("no frame was measured")?;
            finding.pass = nearest.reach <= allowed(nearest) + slack;
            finding.measured = format!(
                "{:.4} m of {:.4} m at t = {:.3} s, the nearest it came: {:.4} m/s of {:.4} m/s",
                nearest.reach,
                allowed(nearest),
                nearest.time,
                nearest.reach / nearest.time,
                allowed(nearest) / nearest.time
            );
            finding.value = Some(nearest.reach / nearest.time);
        }
        Statement::Speed { run, front, expected, tolerance } => {
            let run = find(runs, run)?;
            let half = run.2.half.as_deref().ok_or("there is no phi at half time")?;
            let end = phi(run)?;
            let place = |phi: &[f64]| {
                let x: Vec<f64> = (0..phi.len()).map(|i| end.centre(0, i)).collect();
                let fronts = cf_diffusion::exact::single_field::measured_fronts(&x, phi);
                fronts
                    .map(|[aft, fore]| if *front == crate::spec::Front::Fore { fore } else { aft })
                    .ok_or("phi has no maximum")
            };
            let speed = (place(&end.phi)? - place(half)?) / (run.2.time - 0.5 * run.0.schedule.until);
            if !speed.is_finite() {
                return Err("no time passed".into());
            }
            finding.pass = near(speed, *expected, *tolerance);
            finding.measured = format!("{speed:.4} m/s");
            finding.value = Some(speed);
        }
    }
    Ok(finding)
}

fn between(value: f64, low: Option<f64>, high: Option<f64>) -> bool {
    low.is_none_or(|low| value >= low) && high.is_none_or(|high| value <= high)
}

fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) { format!("{value:.3e}") } else { format!("{value:.5}") }
}

/// The largest of a number over the runs that solve for a fluid, with the run.
fn worst<'r>(runs: &'r [Run<'_>], number: impl Fn(&FlowSummary) -> f64) -> Result<(f64, &'r str), String> {
    let all = runs.iter().filter_map(|(_, summary, _)| Some((number(summary.flow.as_ref()?), summary.name.as_str())));
    // NaN is the largest of all.
    all.max_by(|a, b| a.0.total_cmp(&b.0)).ok_or_else(|| "no run solves for a fluid".to_owned())
}

fn find<'r, 'a>(runs: &'r [Run<'a>], name: &str) -> Result<&'r Run<'a>, String> {
    runs.iter().find(|run| run.1.name == name).ok_or_else(|| format!("there is no run `{name}`"))
}

fn phi(run: &Run<'_>) -> Result<Sample, String> {
    let phi = run.2.phi.as_ref().ok_or_else(|| format!("the end of run `{}` was not kept", run.1.name))?;
    Ok(Sample::new(&run.0.grid, had(phi, run)?))
}

fn had(kept: &Kept, run: &Run<'_>) -> Result<Vec<f64>, String> {
    kept.get().map_err(|error| format!("the end of run `{}` cannot be read again: {error}", run.1.name))
}

fn measure(quantity: Quantity, run: &Run<'_>) -> Result<f64, String> {
    let sample = phi(run)?;
    let whole: f64 = sample.phi.iter().map(|value| value.abs()).sum();
    let share = |part: f64| if whole > 0.0 { Ok(part / whole) } else { Err("phi is zero everywhere".to_owned()) };
    match quantity {
        Quantity::Mass => Ok(run.1.mass.end),
        Quantity::DiffusionSeconds => {
            let seconds = run.1.seconds.phases.get("diffusion").copied().unwrap_or(0.0);
            Ok(seconds / run.1.steps.max(1) as f64)
        }
        Quantity::PeakMemory if run.1.peak_memory == 0 => Err("the system does not tell".into()),
        Quantity::PeakMemory => Ok(run.1.peak_memory as f64 / 1e9),
        Quantity::Maximum => Ok(sample.phi.iter().copied().fold(f64::NEG_INFINITY, f64::max)),
        Quantity::Minimum => Ok(sample.phi.iter().copied().fold(f64::INFINITY, f64::min)),
        Quantity::Centre(axis) => {
            let centre = sample.centre_of_mass().ok_or_else(|| "phi is zero everywhere".to_owned())?;
            Ok(centre[axis.index()])
        }
        Quantity::EnergyPerWork => {
            let flow = run.1.flow.as_ref().ok_or("no fluid is solved for")?;
            if flow.work == 0.0 { Err("no work was done".into()) } else { Ok(flow.energy / flow.work) }
        }
        Quantity::RadiusAbout(axis) => {
            sample.radius_about(Some(axis.index())).ok_or_else(|| "phi is zero everywhere".to_owned())
        }
        Quantity::RadiusOfGyration => sample.radius_of_gyration().ok_or_else(|| "phi is zero everywhere".to_owned()),
        Quantity::UpstreamLeak { source, cells } => {
            share(reach::upstream(&sample, run.0, source, cells)?.iter().map(|value| value.abs()).sum())
        }
        Quantity::OutsideCone { source } => share(reach::outside(&sample, run.0, source, run.2.time)?),
    }
}

/// How many numbers of two runs differ in their bits.
fn differing(a: &Run<'_>, b: &Run<'_>) -> Result<usize, String> {
    let count = |a: &[f64], b: &[f64]| {
        let pairs = a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        pairs + a.len().abs_diff(b.len())
    };
    let fluxes = (a.2.flux.as_ref(), b.2.flux.as_ref());
    let (Some(one), Some(other)) = fluxes else { return Err("the fluxes were not kept".into()) };
    if one.len() != other.len() {
        return Err("only one of the runs has a flux with memory".into());
    }
    let mut differ = count(&phi(a)?.phi, &phi(b)?.phi);
    for (one, other) in one.iter().zip(other) {
        differ += count(&had(one, a)?, &had(other, b)?);
    }
    Ok(differ)
}
