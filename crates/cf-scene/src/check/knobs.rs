//! `accuracy`: which of the knobs that a scene sets have an effect on a run.
//!
//! One value may serve several runs, so whether a knob is idle is known only when all runs are: [`idle`] decides.

use super::Checker;
use crate::error::{Detail, SceneError};
use crate::pace::Pace;
use crate::scene::{Model, Scene};
use crate::spec::{AccuracySpec, Integrator, Medium, Precision};
use std::collections::HashMap;

/// A knob that a scene sets, as one run sees it.
#[derive(Clone, Debug)]
pub(crate) struct Use {
    /// What to say where no run has a use for it.
    error: SceneError,
    /// Whether this run has none.
    idle: bool,
    /// Whether that is so because of what was chosen for the run rather than by the scene.
    chosen: bool,
}

/// The knobs that one run is given.
pub(super) fn uses(check: &Checker<'_>, spec: &AccuracySpec, scene: &Scene, pace: &Pace) -> Vec<Use> {
    let given = [
        ("level", spec.level.is_some()),
        ("integrator", spec.integrator.is_some()),
        ("advection", spec.advection.is_some()),
        ("splitting", spec.splitting.is_some()),
        ("dt", spec.dt.is_some()),
        ("cfl", spec.cfl.is_some()),
        ("step", spec.step.is_some()),
        ("tolerance", spec.tolerance.is_some()),
        ("precision", spec.precision.is_some()),
        ("solver", spec.solver.is_some()),
        ("flow", spec.flow.is_some()),
        ("eta_div", spec.eta_div.is_some()),
    ];
    let one = |(key, _): (&str, bool)| {
        let why = why_idle(key, spec, scene, pace);
        let problem = format!("{}, so this has no effect", why.as_deref().unwrap_or_default());
        let detail = Detail::new(problem).advice("remove it, or set it to None");
        Use {
            error: check.error(&format!("accuracy.{key}"), detail),
            idle: why.is_some(),
            chosen: scene.numerics.integrator.is_none() && pace.integrator.is_some() && key != "advection",
        }
    };
    given.into_iter().filter(|(_, set)| *set).map(one).collect()
}

fn why_idle(key: &str, spec: &AccuracySpec, scene: &Scene, pace: &Pace) -> Option<String> {
    let still = match &scene.model {
        // Whatever is written, the pulse is solved mode by mode in double precision.
        Model::SingleField(_) if key == "precision" && spec.precision == Some(Precision::F64) => return None,
        Model::SingleField(_) => return Some("a SingleField pulse is solved exactly, in double precision".to_owned()),
        Model::Diffusion(model) => model.medium == Medium::Still,
    };
    if matches!(key, "flow" | "eta_div") {
        return scene.fluid().is_none().then(|| "no fluid is solved for".to_owned());
    }
    if still && key == "advection" {
        return Some("the medium is still".to_owned());
    }
    let integrator = pace.integrator.filter(|i| matches!(i, Integrator::Kdk | Integrator::Characteristic))?;
    match key {
        "tolerance" | "solver" => Some(format!("{integrator:?} steps explicitly and never solves a system")),
        "precision" if spec.precision == Some(Precision::Mixed) => {
            Some(format!("{integrator:?} never solves a system, for which mixed differs from f64"))
        }
        "advection" | "splitting" if integrator == Integrator::Characteristic => {
            Some("Characteristic carries phi with its waves".to_owned())
        }
        _ => None,
    }
}

/// The knobs that no run has a use for: refusals where the scene itself left none, warnings with the number of the run
/// where that was chosen for it.
pub(crate) fn idle(runs: &[Vec<Use>]) -> (Vec<SceneError>, Vec<(usize, SceneError)>) {
    let mut places: HashMap<String, bool> = HashMap::new();
    let every = || runs.iter().enumerate().flat_map(|(run, uses)| uses.iter().map(move |one| (run, one)));
    let place = |one: &Use| format!("{} {:?}", one.error.place, one.error.place.span());
    for (_, one) in every() {
        *places.entry(place(one)).or_insert(true) &= one.idle;
    }
    let (mut refused, mut warned) = (Vec::new(), Vec::new());
    for (run, one) in every() {
        // The first run that has the knob speaks for all.
        if places.remove(&place(one)) == Some(true) {
            if one.chosen {
                warned.push((run, one.error.clone()));
            } else {
                refused.push(one.error.clone());
            }
        }
    }
    (refused, warned)
}
