//! Steps and frames together: a run must end, and a step that is asked for should be taken.

use super::Checker;
use crate::error::{Detail, number};
use crate::pace::{MOST_STEPS, Pace};
use crate::scene::{Model, Scene, TimeStep};
use crate::spec::{Flow, Level, Medium};

/// Checks the time step against the run.
pub(super) fn time(check: &mut Checker<'_>, scene: &Scene, pace: &Pace) {
    let Model::Diffusion(model) = &scene.model else { return };
    let (aims, capped) = (matches!(scene.numerics.level, Level::Target(_)), scene.schedule.steps.is_some());
    check.require(!(aims && capped), "run.steps", || {
        Detail::new("Target compares runs of different steps at their end, which a number of steps would cut off")
            .advice("remove one of the two, or set steps to None")
    });
    let path = match scene.numerics.step {
        TimeStep::Fixed(_) => "accuracy.dt",
        TimeStep::Cfl(_) => "accuracy.cfl",
        TimeStep::Courant(_) => "model.medium",
        TimeStep::Bounded(_) | TimeStep::Shift(_) | TimeStep::Adaptive(_) => "run.until",
    };
    let moves = scene.medium_speed() > 0.0 || model.law.speed().is_some_and(|c| c > 0.0);
    if !check.require(moves || !matches!(scene.numerics.step, TimeStep::Cfl(_)), path, || {
        Detail::new("neither medium nor waves move here, so there is no speed to count cells by")
            .expected("accuracy.dt, a step in seconds")
    }) {
        return;
    }
    if let Medium::Analytic(Flow::Deformation { period }) = model.medium {
        let turns = scene.schedule.until / period;
        check.require(turns <= MOST_STEPS, "model.medium", || {
            Detail::new(format!("the flow would return {} times before the end of the run", number(turns)))
                .expected(format!("at most {MOST_STEPS:e} times"))
        });
    }
    let steps = pace.steps(scene);
    if !check.require(steps <= MOST_STEPS, path, || {
        Detail::new(format!("steps of {} s would not come to the end of the run", number(pace.dt)))
            .expected(format!("at most {MOST_STEPS:e} steps"))
            .found(format!("{} or more", number(steps)))
            .advice("check run.until, the speeds in model.medium and model.law, and the cell count")
    }) {
        return;
    }
    let (interval, until) = (scene.schedule.interval, scene.schedule.until);
    if path.starts_with("accuracy") && until > 0.0 && pace.dt > interval * (1.0 + 1e-6) {
        let detail = Detail::new(format!("frames every {} s cut the steps of {} s", number(interval), number(pace.dt)));
        check.warn(path, detail.advice("ask for fewer frames or for a shorter step"));
    }
    for (i, source) in model.sources.iter().enumerate().filter(|(_, source)| until > 0.0 && source.from >= until) {
        let detail = Detail::new("this source begins after the run has ended, so it does nothing");
        check.warn(&format!("model.sources[{i}].from"), detail.found(number(source.from)));
    }
}
