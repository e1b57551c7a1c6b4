//! `claims`: statements that can be checked on the runs they name.

use super::names::source_of;
use super::{Checker, out_of_range};
use crate::error::{Detail, SceneError, number};
use crate::measure::Upstream;
use crate::scene::{Diffusion, Law, Model, Scene, TimeStep};
use crate::spec::{Claim, Kind, Knob, Medium, Quantity, SceneSpec, Statement};
use crate::text::merged::Merged;

/// Checks all claims against the validated runs.
pub(crate) fn claims(spec: &SceneSpec, merged: &Merged, runs: &[Scene], preset: Option<&str>) -> Vec<SceneError> {
    let mut check = Checker::new(merged);
    for (i, claim) in spec.claims.iter().enumerate() {
        let path = format!("claims[{i}].statement");
        let before = check.problems.len();
        one(&mut check, &path, claim, runs);
        // What cells there are depends on the size.
        if check.problems.len() == before && claim.applies(preset) {
            regions(&mut check, &path, &claim.statement, runs);
        }
    }
    check.problems
}

fn one(check: &mut Checker<'_>, path: &str, claim: &Claim, runs: &[Scene]) {
    let key = |name: &str| format!("{path}.{name}");
    check.require(claim.kind != Kind::Must || !claim.statement.of_the_machine(), path, || {
        Detail::new("what depends on the machine cannot be demanded").expected("kind: Report")
    });
    match &claim.statement {
        Statement::ConeAngle { run, expected, tolerance, source, rows } => {
            check.positive(&key("tolerance"), *tolerance);
            check.require((0.0..90.0).contains(expected), &key("expected"), || {
                out_of_range("an angle from 0 to below 90 degrees", *expected)
            });
            check.require(0.0 <= rows.0 && rows.0 < rows.1, &key("rows"), || {
                Detail::new("out of range")
                    .expected("(near, far) with 0 <= near < far")
                    .found(format!("({}, {})", rows.0, rows.1))
            });
            let Some((scene, model)) = moving(check, path, run, runs) else { return };
            check.require(source.len() == scene.grid.dimension(), &key("source"), || {
                Detail::new("wrong number of values").expected(format!("{} numbers", scene.grid.dimension()))
            });
            let speeds = (model.law.speed().unwrap_or(f64::INFINITY), speed(&model.medium));
            check.require(speeds.0 < speeds.1, path, || {
                Detail::new("only a flow faster than the waves has a cone")
                    .expected(format!("a wave speed below {}", number(speeds.1)))
                    .found(number(speeds.0))
            });
        }
        Statement::NoUpstreamTail { run, source, fraction, .. } => {
            check.require(*fraction > 0.0 && *fraction <= 1.0, &key("fraction"), || {
                out_of_range("above 0 up to 1", *fraction)
            });
            upstream(check, path, run, *source, runs);
        }
        Statement::Within { quantity, run, low, high } => {
            ends(check, path, claim, *low, *high);
            measurable(check, path, quantity, run, runs);
            if let Some(source) = source_of(quantity) {
                upstream(check, path, run, source, runs);
            }
        }
        Statement::Ratio { quantity, runs: (a, b), low, high } => {
            ends(check, path, claim, *low, *high);
            check.require(a != b, &key("runs"), || Detail::new("these are the same run"));
            for run in [a, b] {
                measurable(check, path, quantity, run, runs);
                if let Some(source) = source_of(quantity) {
                    upstream(check, path, run, source, runs);
                }
            }
        }
        Statement::Monotone { quantity, runs: names, .. } => {
            several(check, &key("runs"), names);
            for run in names {
                measurable(check, path, quantity, run, runs);
                if let Some(source) = source_of(quantity) {
                    upstream(check, path, run, source, runs);
                }
            }
        }
        Statement::EqualBits { runs: (a, b) } => {
            check.require(a != b, &key("runs"), || Detail::new("these are the same run"));
            if let (Some(a), Some(b)) = (find(runs, a), find(runs, b)) {
                let same = a.grid == b.grid && a.numerics.precision == b.numerics.precision;
                check.require(same, &key("runs"), || {
                    Detail::new("runs of different grids or precisions cannot end with equal bits")
                });
            }
        }
        Statement::Order { parameter, runs: names, reference, tolerance, .. } => {
            check.positive(&key("tolerance"), *tolerance);
            several(check, &key("runs"), names);
            check.require(!names.contains(reference), &key("reference"), || {
                Detail::new("the reference is itself one of the runs")
            });
            let values: Vec<Option<f64>> =
                names.iter().filter_map(|name| find(runs, name)).map(|scene| read(*parameter, scene)).collect();
            let distinct = values.iter().enumerate().all(|(i, value)| !values[..i].contains(value));
            check.require(
                distinct && values.iter().all(|value| value.is_some_and(|v| v > 0.0)),
                &key("parameter"),
                || {
                    Detail::new(format!("{parameter:?} must be above 0 and differ from run to run")).found(format!(
                        "{:?}",
                        values.iter().map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<_>>()
                    ))
                },
            );
        }
        Statement::MassBudget { tolerance } => {
            check.positive(&key("tolerance"), *tolerance);
        }
        Statement::Divergence { most } => {
            check.positive(&key("most"), *most);
            solved(check, path, runs.iter().any(|scene| scene.fluid().is_some()));
        }
        Statement::Iterations { .. } | Statement::NoPressure => {}
        Statement::FlowIterations { .. } => {
            solved(check, path, runs.iter().any(|scene| scene.fluid().is_some()));
        }
        Statement::Front { run, fraction, .. } => {
            check.require(*fraction > 0.0 && *fraction < 1.0, &key("fraction"), || {
                out_of_range("above 0 and below 1", *fraction)
            });
            let Some(scene) = find(runs, run) else { return };
            check.require(front_speed(scene).is_some(), path, || {
                Detail::new(format!("the signals of run `{run}` reach every cell at once"))
                    .expected("a law with fourier: 0 and tau above 0, or with k: 0")
            });
        }
        Statement::Speed { run, tolerance, .. } => {
            check.positive(&key("tolerance"), *tolerance);
            let line = find(runs, run).is_none_or(|scene| scene.grid.is_line());
            check.require(line, &key("run"), || {
                Detail::new("a pulse's speed needs one dimension").expected("a run on a grid of n or n x 1 cells")
            });
        }
    }
}

/// The ends of a range.
fn ends(check: &mut Checker<'_>, path: &str, claim: &Claim, low: Option<f64>, high: Option<f64>) {
    if let (Some(low), Some(high)) = (low, high) {
        check.require(low <= high, &format!("{path}.high"), || {
            out_of_range(&format!("at least low, which is {}", number(low)), high)
        });
    }
    check.require(low.or(high).is_some() || claim.kind != Kind::Must, path, || {
        Detail::new("a claim that must hold needs `low` or `high`").advice("or make it kind: Report")
    });
}

/// A statement about a region needs cells there: about nothing everything holds.
fn regions(check: &mut Checker<'_>, path: &str, statement: &Statement, runs: &[Scene]) {
    let names: &[String] = match statement {
        Statement::NoUpstreamTail { run, .. } | Statement::Within { run, .. } => std::slice::from_ref(run),
        Statement::Monotone { runs, .. } => runs,
        Statement::Ratio { runs: (a, b), .. } => &[a.clone(), b.clone()],
        _ => return,
    };
    let (source, cells) = match statement {
        Statement::NoUpstreamTail { source, cells, .. } => (*source, Some(*cells)),
        Statement::Within { quantity, .. }
        | Statement::Monotone { quantity, .. }
        | Statement::Ratio { quantity, .. } => match quantity {
            Quantity::UpstreamLeak { source, cells } => (*source, Some(*cells)),
            Quantity::OutsideCone { source } => (*source, None),
            _ => return,
        },
        _ => return,
    };
    for scene in names.iter().filter_map(|name| find(runs, name)) {
        let run = &scene.run;
        match cells.map(|cells| (cells, Upstream::of(scene, source, cells))) {
            Some((cells, Ok(region))) => check.require(region.has_fluid(scene), path, || {
                Detail::new(format!(
                    "run `{run}` has no cells further than {cells} cells upstream of source [{source}]"
                ))
                .advice("take fewer cells, or a box that begins further upstream")
            }),
            Some((_, Err(_))) => true,
            None => check.require(law(scene).has_memory(), path, || {
                Detail::new(format!("the law of run `{run}` has no memory, so its signals reach every cell at once"))
                    .expected("tau above 0 and fourier below 1")
            }),
        };
    }
}

/// The speed of signals relative to the medium \[m/s\]; `None` where there is no bound.
pub(crate) fn front_speed(scene: &Scene) -> Option<f64> {
    let Model::Diffusion(model) = &scene.model else { return None };
    match model.law {
        Law { k: 0.0, .. } => Some(0.0),
        Law { fourier: 0.0, .. } => model.law.speed(),
        _ => None,
    }
}

fn solved(check: &mut Checker<'_>, path: &str, is: bool) {
    check.require(is, path, || {
        Detail::new("this is about a fluid that is solved for, and there is none").expected("medium: Solved(…)")
    });
}

/// Whether a run has what a quantity is about.
fn measurable(check: &mut Checker<'_>, path: &str, quantity: &Quantity, run: &str, runs: &[Scene]) {
    let Some(scene) = find(runs, run) else { return };
    match quantity {
        Quantity::Centre(axis) | Quantity::RadiusAbout(axis) => {
            check.require(axis.index() < scene.grid.dimension(), path, || {
                Detail::new("the grid has no such axis").expected(format!("one of {}", scene.grid.dimension()))
            });
        }
        Quantity::EnergyPerWork => solved(check, path, scene.fluid().is_some()),
        _ => {}
    }
}

fn find<'a>(runs: &'a [Scene], name: &str) -> Option<&'a Scene> {
    runs.iter().find(|scene| scene.run == name)
}

/// A diffusion run in a uniform flow.
fn moving<'a>(check: &mut Checker<'_>, path: &str, run: &str, runs: &'a [Scene]) -> Option<(&'a Scene, &'a Diffusion)> {
    let scene = find(runs, run)?;
    match &scene.model {
        Model::Diffusion(model) if speed(&model.medium) > 0.0 => Some((scene, model)),
        _ => {
            let detail = Detail::new(format!("upstream and downstream need a uniform flow, which run `{run}` has not"));
            check.fail(path, detail.expected("medium: Uniform((u, v))"));
            None
        }
    }
}

fn upstream(check: &mut Checker<'_>, path: &str, run: &str, source: usize, runs: &[Scene]) {
    let Some((scene, model)) = moving(check, path, run, runs) else { return };
    let bounded = |shape: &crate::spec::Shape| {
        (0..scene.grid.dimension()).all(|axis| shape.bounds(axis).0.is_finite() && shape.bounds(axis).1.is_finite())
    };
    let good = model.sources.get(source).is_some_and(|source| bounded(&source.shape));
    check.require(good, path, || {
        Detail::new(format!("run `{run}` has no bounded source [{source}]"))
            .found(format!("a list of {}, counted from [0]", model.sources.len()))
    });
}

fn speed(medium: &Medium) -> f64 {
    match medium {
        Medium::Uniform(u) => u.iter().map(|component| component * component).sum::<f64>().sqrt(),
        _ => 0.0,
    }
}

fn several(check: &mut Checker<'_>, path: &str, names: &[String]) {
    let unique = names.iter().enumerate().all(|(i, name)| !names[..i].contains(name));
    check.require(names.len() >= 2 && unique, path, || {
        Detail::new("a comparison needs two or more different runs").found(names.len().to_string())
    });
}

fn law(scene: &Scene) -> Law {
    match &scene.model {
        Model::Diffusion(model) => model.law,
        Model::SingleField(model) => model.law,
    }
}

pub(crate) fn read(parameter: Knob, scene: &Scene) -> Option<f64> {
    let law = law(scene);
    match parameter {
        Knob::Tau => Some(law.tau),
        Knob::Fourier => Some(law.fourier),
        Knob::CellSize => Some(scene.grid.spacing),
        Knob::TimeStep => match scene.numerics.step {
            TimeStep::Fixed(dt) => Some(dt),
            TimeStep::Cfl(_)
            | TimeStep::Bounded(_)
            | TimeStep::Adaptive(_)
            | TimeStep::Courant(_)
            | TimeStep::Shift(_) => None,
        },
    }
}
