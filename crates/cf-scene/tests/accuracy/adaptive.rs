//! Adaptive steps in scenes, and the estimates of the error in summaries.

use super::{Ran, WAKE, unfold};
use cf_scene::progress::{Silent, StopAfter};
use cf_scene::summary::Summary;
use cf_scene::{Options, RunError, perform};

const STILL: &[&str] = &[
    "model.medium=Still",
    "model.sources=[]",
    "model.initial=[(shape: Gaussian(center: (1.0, 2.0), width: 0.15), value: 1.0)]",
    "sides=(x: Periodic, y: Periodic)",
];

fn with<'a>(base: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    base.iter().chain(more).copied().collect()
}

#[test]
fn frames_are_met_exactly_and_the_tolerance_is() {
    // A wave, Jeffreys' law, and Fourier's.
    for law in ["model.law.fourier=0.0", "model.law.fourier=0.1", "model.law=(k: 0.02, tau: 0.0)"] {
        let base = with(STILL, &[law, "run.frames=7"]);
        let reference = Ran::of(WAKE, &with(&base, &["accuracy.integrator=Sdirk2", "accuracy.dt=0.002"]));
        let mut steps = Vec::new();
        for (tolerance, sets) in [
            (1e-2, "accuracy.step=Adaptive(tolerance: 1e-2)"),
            (1e-3, "accuracy.step=Adaptive(tolerance: 1e-3)"),
            (1e-4, "accuracy.step=Adaptive(tolerance: 1e-4)"),
        ] {
            let ran = Ran::of(WAKE, &with(&base, &[sets]));
            let run = ran.run();
            assert_eq!((run.time, run.integrator.as_str()), (2.0, "Sdirk2"));
            assert_eq!(run.files.iter().filter(|file| file.ends_with(".vti")).count(), 8, "{:?}", run.files);
            let error = ran.error(&reference);
            // The tolerance is relative to the largest norm so far, the error to what is left at the end: at most twice.
            assert!(error <= 2.0 * tolerance, "{law} {tolerance:e}: {error:e}");
            let estimate = run.error.embedded.expect("an estimate of every step");
            assert!(estimate <= tolerance, "{estimate:e}");
            assert!(run.dt[0] > 0.0 && run.dt[1] >= run.dt[0] && run.dt_reason.starts_with("adaptive"), "{run:?}");
            steps.push(run.steps);
        }
        assert!(steps[0] <= steps[1] && steps[1] < steps[2], "{law}: {steps:?}");
    }
}

#[test]
fn a_source_that_begins_late_makes_steps_again() {
    let sets = with(
        STILL,
        &[
            "accuracy.step=Adaptive(tolerance: 1e-3)",
            "model.sources=[(shape: Gaussian(center: (1.0, 1.0), width: 0.1), rate: 1e3, from: 1.0)]",
            "run.frames=1",
            "model.law=(k: 0.05, tau: 0.1, fourier: 0.5)",
        ],
    );
    let ran = Ran::of(WAKE, &sets);
    assert!(ran.run().rejections > 0 && ran.run().dt[1] > 4.0 * ran.run().dt[0], "{:?}", ran.run().dt);
    let counted = 2 * (ran.run().steps + ran.run().rejections) as usize;
    assert_eq!(ran.run().iterations.solves, counted);
}

fn numbers(summary: &Summary) -> String {
    let run = &summary.runs[0];
    format!("{} {:?} {:?} {:?} {:?} {}", run.steps, run.dt, run.mass, run.ranges, run.error, run.rejections)
}

#[test]
fn stopping_going_on_and_threads_leave_no_trace() {
    let scenes = [
        unfold(WAKE, &["accuracy.step=Adaptive(tolerance: 1e-3)"]),
        unfold(WAKE, &[]),
        unfold(WAKE, &["accuracy.integrator=PaperBe", "accuracy.advection=Linear"]),
        unfold(WAKE, &["model.law.fourier=0.0"]),
    ];
    for experiment in &scenes {
        let dry = Options { write: false, ..Options::new("wake", "nowhere") };
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            numbers(&pool.install(|| perform(experiment, &dry, &mut Silent)).expect("a run"))
        };
        let expected = on(1);
        assert_eq!(on(2), expected);
        assert_eq!(on(5), expected);
        let folder = tempfile::tempdir().expect("a folder");
        let mut options = Options::new("wake", folder.path());
        let summary = loop {
            match perform(experiment, &options, &mut StopAfter(5)) {
                Ok(summary) => break summary,
                Err(RunError::Stopped { .. }) => options.resume = true,
                Err(other) => panic!("{other}"),
            }
        };
        assert!(options.resume, "it stopped at least once");
        assert_eq!(numbers(&summary), expected);
    }
}

#[test]
fn samples_of_the_error_change_no_bit() {
    for sets in [&[][..], &["accuracy.integrator=PaperBe"], &["model.law.fourier=0.0"]] {
        let experiment = unfold(WAKE, sets);
        let of = |estimate| {
            let options = Options { write: false, estimate, ..Options::new("wake", "nowhere") };
            perform(&experiment, &options, &mut Silent).expect("a run").runs.remove(0)
        };
        let (with, without) = (of(true), of(false));
        assert_eq!(format!("{:?}{:?}", with.ranges, with.mass), format!("{:?}{:?}", without.ranges, without.mass));
        assert_eq!((with.error.samples, without.error.samples), (4, 0));
        assert!(with.error.per_step.is_some() && without.error.per_step.is_none());
    }
}

#[test]
fn sampled_errors_are_those_of_the_run() {
    // Against a run of a sixteenth of the step: the sum of the errors of all steps bounds the error, and not by much.
    for (sets, most) in [
        (&["accuracy.integrator=PaperBe"][..], 6.0),
        (&["accuracy.integrator=Sdirk2"], 6.0),
        (&["accuracy.integrator=Kdk", "model.law.fourier=0.0"], 8.0),
        (&["accuracy.integrator=Characteristic", "model.law.fourier=0.0"], 40.0),
    ] {
        let base = with(STILL, sets);
        let (coarse, fine) = (with(&base, &["accuracy.dt=0.0625"]), with(&base, &["accuracy.dt=0.00390625"]));
        let (coarse, fine) = (Ran::of(WAKE, &coarse), Ran::of(WAKE, &fine));
        let (error, told) = (coarse.error(&fine), coarse.run().error.whole_run.expect("samples"));
        assert!(error <= 1.5 * told && told <= most * error, "{sets:?}: error {error:e}, told {told:e}");
        assert_eq!(coarse.run().error.embedded.is_some(), sets[0].ends_with("Sdirk2"));
    }
}
