//! Errors of sampled steps: a step in one beside the same step in two.
//!
//! A scheme of order p makes an error of C dt^(p+1) in a step and of C dt^(p+1)/2^p in two halves of it, so the difference of
//! both is 1 - 2^-p of the error. This sees everything that a step does, transport and splitting included, and costs two
//! steps a sample, which is why only few steps are sampled. Sdirk2 has an estimate from its own stages besides.

use crate::backup::{Backup, PhiCopy};
use crate::model::{Model, StepFailure};
use crate::pace::Pace;
use crate::scene::{self, Scene, TimeStep};
use crate::spec::{Advection, Integrator, Splitting};
use crate::stopwatch::Stopwatch;
use crate::summary::ErrorSummary;
use cf_diffusion::StepReport;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Samples of a run.
const SAMPLES: u64 = 4;

/// What samples told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Samples {
    /// How many.
    count: u64,
    /// The sum of the relative differences of one step and two halves.
    sum: f64,
    /// The largest relative estimate from the stages.
    embedded: Option<f64>,
    /// The largest norm so far.
    scale: f64,
}

/// Whether a step of a run of about `steps` is sampled: the middles of equal parts of the run.
pub(crate) fn is_due(step: u64, steps: f64) -> bool {
    let at = |part: u64| ((2 * part + 1) as f64 / (2 * SAMPLES) as f64 * steps).floor() as u64;
    (0..SAMPLES).any(|part| at(part) == step)
}

impl Samples {
    /// Notes an estimate from the stages of a step.
    pub fn embedded(&mut self, error: Option<f64>, norm: f64) {
        let Some(error) = error else { return };
        self.scale = self.scale.max(norm);
        let relative = if error == 0.0 { 0.0 } else { error / self.scale };
        self.embedded = Some(self.embedded.map_or(relative, |most| most.max(relative)));
    }

    /// Makes the step, before it the same in two halves, from which it goes back.
    pub fn step(
        &mut self,
        model: &mut dyn Model,
        from: f64,
        dt: f64,
        watch: &mut Stopwatch,
    ) -> Result<StepReport, StepFailure> {
        let (begun, mut before, mut aside) = (Instant::now(), Backup::default(), Stopwatch::default());
        before.keep(model);
        let half = 0.5 * dt;
        let halves = model.advance(from, half, &mut aside).and_then(|_| model.advance(from + half, half, &mut aside));
        // A half that fails leaves no sample; the step itself is about to tell why.
        let fine = halves.ok().and_then(|_| PhiCopy::of(model));
        before.restore(model);
        model.estimate(true);
        watch.add("error samples", begun.elapsed().as_secs_f64());
        let report = model.advance(from, dt, watch)?;
        let begun = Instant::now();
        self.embedded(report.error, model.norm());
        model.estimate(false);
        if let Some(fine) = fine {
            let [difference, size] = model.distance(fine.values());
            self.sum += if difference == 0.0 { 0.0 } else { (difference / size).sqrt() };
            self.count += 1;
        }
        watch.add("error samples", begun.elapsed().as_secs_f64());
        Ok(report)
    }

    /// What they say of a run of `steps`.
    pub fn summary(&self, scene: &Scene, pace: &Pace, steps: u64) -> ErrorSummary {
        let Self { count, sum, embedded, .. } = *self;
        let how = match &scene.model {
            scene::Model::SingleField(_) => "none is made: the solution is exact in time",
            _ if scene.fluid().is_some() => {
                "none is made where a fluid is solved for: it would take all its fields again"
            }
            _ if matches!(scene.numerics.step, TimeStep::Adaptive(_)) => "from the two stages of every step taken",
            _ if count == 0 => "no step was sampled",
            _ if embedded.is_some() => "sampled steps: in one and in two halves, and from their two stages",
            _ => "sampled steps, in one and in two halves; this integrator has no estimate of its own",
        };
        // The error of the step from the difference.
        let factor = if order(scene, pace) == 1 { 2.0 } else { 4.0 / 3.0 };
        let per_step = (count > 0).then(|| factor * sum / count as f64);
        let whole_run = per_step.map(|error| error * steps as f64);
        ErrorSummary { embedded, per_step, whole_run, samples: count, how: how.into() }
    }
}

/// The order of the steps as a whole.
fn order(scene: &Scene, pace: &Pace) -> u32 {
    let moves = scene.moves() && pace.integrator != Some(Integrator::Characteristic);
    let lie = moves && (scene.numerics.splitting == Splitting::Lie || scene.numerics.advection == Advection::Linear);
    if lie || pace.integrator == Some(Integrator::PaperBe) { 1 } else { 2 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_spread_over_the_run() {
        let due = |steps: u64| (0..steps).filter(|step| is_due(*step, steps as f64)).collect::<Vec<_>>();
        assert_eq!(due(800), [100, 300, 500, 700]);
        assert_eq!(due(4), [0, 1, 2, 3]);
        assert_eq!(due(1), [0]);
        assert!(due(0).is_empty());
    }
}
