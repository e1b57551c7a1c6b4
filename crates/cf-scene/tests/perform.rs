//! Small scenes from text to results: files, claims, stopping and going on, threads.

use cf_scene::progress::{Silent, StopAfter};
use cf_scene::summary::Summary;
use cf_scene::{Experiment, Failure, Limits, Options, RunError, SceneFile, Set, TimeStep, perform};
use std::path::Path;

const WAKE: &str = r#"(
    about: (title: "Wake"),
    grid: (cells: (32, 48), extent: (2.0, 3.0)),
    sides: (x: Walls(low: Absorbing(speed: 0.25), high: Absorbing(speed: 0.25)),
            y: Walls(low: Absorbing(speed: 0.25), high: Absorbing(speed: 0.25))),
    model: Diffusion(
        law: (k: 0.25, tau: 4.0),
        medium: Uniform((0.0, 0.5)),
        initial: [(shape: Ball(center: (1.0, 1.5), radius: 0.3), value: 1.0)],
        sources: [(shape: Box(low: (0.9, 0.9), high: (1.1, 1.1)), rate: 50.0, from: 0.13, until: Some(1.71))],
    ),
    accuracy: (precision: f64, level: Standard),
    run: (until: 3.0, frames: 4, variants: [
        (name: "kdk"),
        (name: "sdirk", set: {"model.law.fourier": 0.5, "accuracy.precision": mixed}),
        (name: "be", set: {"accuracy.integrator": PaperBe, "accuracy.precision": f32}),
        (name: "front", set: {"accuracy.integrator": Characteristic}),
    ]),
    output: (fields: [phi, q_C, u]),
    claims: [
        (name: "half", source: Ours, kind: Report, statement: EqualBits(runs: ("kdk", "front"))),
        (name: "leak", source: Ours, kind: Must,
            statement: Monotone(quantity: UpstreamLeak(cells: 3), runs: ["sdirk", "kdk", "front"], direction: Falling)),
        (name: "mass", source: Ours, kind: Must, statement: MassBudget(tolerance: 1e-6)),
        (name: "speed", source: Ours, kind: Report, statement: Within(quantity: OutsideCone(), run: "front", high: Some(0.05))),
    ],
)"#;

fn experiment(text: &str, flags: &[&str]) -> Experiment {
    let sets: Vec<Set> = flags.iter().map(|flag| Set::parse(flag).unwrap()).collect();
    let file = SceneFile::parse("wake.ron", text).unwrap_or_else(|problems| panic!("{problems}"));
    file.experiment(None, &sets, &Limits { memory: 1 << 30 }).unwrap_or_else(|problems| panic!("{problems}"))
}

fn dry(experiment: &Experiment) -> Result<Summary, RunError> {
    perform(experiment, &Options { write: false, ..Options::new("wake", "nowhere") }, &mut Silent)
}

/// Everything in a summary that must not depend on machine, threads or interruptions.
fn numbers(summary: &Summary) -> String {
    let run = |run: &cf_scene::summary::RunSummary| {
        format!(
            "{} {} {:?} {:?} {:?} {:?} {:?}",
            run.name, run.steps, run.dt, run.mass, run.ranges, run.iterations, run.time
        )
    };
    let claim = |claim: &cf_scene::summary::ClaimResult| format!("{} {} {:?}", claim.name, claim.measured, claim.value);
    summary.runs.iter().map(run).chain(summary.claims.iter().map(claim)).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_scene_leaves_its_files_and_claims() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let experiment = experiment(WAKE, &[]);
    let summary = perform(&experiment, &Options::new("wake", &out), &mut Silent).unwrap();
    assert_eq!(summary.failures().count(), 0, "{:?}", summary.claims);
    for run in &summary.runs {
        let steps: f64 = 3.0 / run.dt[0];
        assert!(run.mass.drift.abs() < 1e-6 && run.time == 3.0 && run.steps as f64 <= steps + 1.0, "{run:?}");
        // The source acts for 1.58 s on 0.04 m²; its edges lie within cells.
        let emitted = run.mass.emitted / (50.0 * 0.04 * 1.58);
        assert!((emitted - 1.0).abs() < 1e-5, "{}: {emitted}", run.name);
        for file in &run.files {
            assert!(out.join(file).is_file(), "{file}");
        }
        assert_eq!(cf_output::read_series(&out.join(format!("{}.pvd", run.name))).unwrap().len(), 5);
        let image = cf_output::read_image(&out.join(format!("{}_0004.vti", run.name))).unwrap();
        assert_eq!(image.arrays.iter().map(|a| &a.name[..]).collect::<Vec<_>>(), ["phi", "q_C", "u"]);
        let mass = image.arrays[0].values.iter().sum::<f64>() / 256.0;
        assert!((mass / run.mass.end - 1.0).abs() < 1e-6, "{}: {mass}", run.name);
    }
    assert!(summary.files.iter().all(|file| out.join(file).is_file()));
    let left = std::fs::read_dir(&out).unwrap().filter_map(|entry| entry.unwrap().file_name().into_string().ok());
    let extra: Vec<String> = left.filter(|name| name.starts_with('.') || name.starts_with("checkpoint")).collect();
    assert!(extra.is_empty(), "{extra:?}");
}

#[test]
fn going_on_gives_the_same_bits_as_never_stopping() {
    let whole = experiment(WAKE, &[]);
    let expected = numbers(&dry(&whole).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let mut options = Options::new("wake", folder.path());
    let mut stops = 0;
    let summary = loop {
        match perform(&whole, &options, &mut StopAfter(29)) {
            Ok(summary) => break summary,
            Err(RunError::Stopped { checkpoint: Some(path), .. }) => assert!(path.is_file()),
            Err(other) => panic!("{other}"),
        }
        (options.resume, stops) = (true, stops + 1);
        assert!(stops < 50);
    };
    assert!(stops >= 4, "{stops}");
    assert_eq!(numbers(&summary), expected);
    let table = std::fs::read_to_string(folder.path().join("kdk.csv")).unwrap();
    assert_eq!(table.lines().count(), 6);
    assert!(folder.path().join("kdk_0004.png").is_file());
    let manifest = std::fs::read_to_string(folder.path().join("sdirk.manifest.json")).unwrap();
    assert_eq!(manifest.matches("\"time\"").count(), 5);
}

#[test]
fn threads_leave_no_trace() {
    let experiment = experiment(WAKE, &["run.until=1.0"]);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        numbers(&pool.install(|| dry(&experiment)).unwrap())
    };
    let one = with(1);
    assert_eq!(with(2), one);
    assert_eq!(with(5), one);
}

fn stopped_at(folder: &Path) -> (Experiment, Options) {
    let experiment = experiment(WAKE, &["run.until=1.0"]);
    let mut options = Options::new("wake", folder);
    let stopped = perform(&experiment, &options, &mut StopAfter(3)).unwrap_err();
    assert_eq!(stopped.failure(), Failure::Interrupted);
    options.resume = true;
    (experiment, options)
}

#[test]
fn damaged_checkpoints_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (experiment, options) = stopped_at(folder.path());
    let path = folder.path().join("checkpoint.kdk");
    let good = std::fs::read(&path).unwrap();
    let refusal = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let error = perform(&experiment, &options, &mut StopAfter(1)).unwrap_err();
        assert_eq!(error.failure(), Failure::Io, "{error}");
        error.to_string()
    };
    for length in (0..good.len()).step_by(good.len() / 97).chain([good.len() - 1]) {
        assert!(refusal(&good[..length]).contains("damaged"));
    }
    for at in (0..good.len()).step_by(good.len() / 211) {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (at % 8);
        let words = refusal(&bytes);
        assert!(words.contains("damaged") || words.contains("format has version"), "{at}: {words}");
    }
    assert!(refusal(&[&good[..], b"x"].concat()).contains("follows its end"));
    std::fs::write(&path, &good).unwrap();
    perform(&experiment, &options, &mut Silent).unwrap();
}

#[test]
fn foreign_checkpoints_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (_, options) = stopped_at(folder.path());
    for flags in [["run.until=1.0", "model.law.k=0.2"], ["run.until=2.0", "model.law.k=0.25"]] {
        let error = perform(&experiment(WAKE, &flags), &options, &mut Silent).unwrap_err();
        assert!(error.to_string().contains("of another run"), "{error}");
    }
    std::fs::rename(folder.path().join("checkpoint.kdk"), folder.path().join("checkpoint.sdirk")).unwrap();
    let error = perform(&experiment(WAKE, &["run.until=1.0"]), &options, &mut Silent).unwrap_err();
    assert!(error.to_string().contains("it is of run `kdk`"), "{error}");
}

#[test]
fn an_unwritable_folder_and_a_stop_without_files_are_said() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("out"), "a file").unwrap();
    let experiment = experiment(WAKE, &["run.until=0.5"]);
    let error = perform(&experiment, &Options::new("wake", folder.path().join("out")), &mut Silent).unwrap_err();
    assert!(error.failure() == Failure::Io && error.to_string().contains("out"), "{error}");
    let dry = Options { write: false, ..Options::new("wake", folder.path().join("none")) };
    let stopped = perform(&experiment, &dry, &mut StopAfter(2)).unwrap_err();
    assert!(matches!(stopped, RunError::Stopped { step: 2, checkpoint: None, .. }));
    assert!(!folder.path().join("none").exists());
}

#[test]
fn numbers_that_overflow_are_found_with_their_place() {
    let flags =
        ["be:model.initial[0].value=3e38", "be:model.initial[0].shape=Everywhere", "be:model.sources[0].rate=3e38"];
    let experiment = experiment(WAKE, &flags);
    let error = dry(&experiment).unwrap_err();
    assert_eq!(error.failure(), Failure::Numerical);
    assert!(error.to_string().contains("run `be`, step"), "{error}");
}

#[test]
fn steps_may_be_capped_and_runs_may_be_empty() {
    let capped = dry(&experiment(WAKE, &["run.steps=5"])).unwrap();
    assert!(capped.runs.iter().all(|run| run.steps == 5 && run.warnings.iter().any(|line| line.contains("run.steps"))));
    let empty = dry(&experiment(WAKE, &["run.until=0.0"])).unwrap();
    assert!(empty.runs.iter().all(|run| run.steps == 0 && run.mass.drift == 0.0));
    assert!(empty.claims.iter().any(|claim| claim.measured.starts_with("not measurable")));
    // The checks refuse such a step; a program may ask for it all the same.
    let mut endless = experiment(WAKE, &[]);
    endless.runs[0].numerics.step = TimeStep::Fixed(1e-300);
    let endless = dry(&endless).unwrap_err();
    assert_eq!(endless.failure(), Failure::Input, "{endless}");
}

#[test]
fn space_obstacles_and_flows_by_formula_run() {
    let text = r#"(
        grid: (cells: (12, 10, 8), extent: (1.2, 1.0, 0.8)),
        model: Diffusion(
            law: (c: 0.3, tau: 1.0, fourier: 0.25),
            medium: Analytic(Deformation(period: 1.0)),
            initial: [(shape: Gaussian(center: (0.4, 0.5, 0.4), width: 0.15), value: 2.0)],
        ),
        accuracy: (precision: f64),
        run: (until: 0.5, frames: 2, variants: [
            (name: "flow"),
            (name: "solid", set: {
                "model.medium": Still,
                "model.obstacles": [Box(low: (0.7, 0.0, 0.0), high: (0.8, 0.7, 0.8))],
            }),
        ]),
        claims: [(name: "mass", source: Ours, kind: Must, statement: MassBudget(tolerance: 1e-12))],
    )"#;
    let folder = tempfile::tempdir().unwrap();
    let summary = perform(&experiment(text, &[]), &Options::new("box", folder.path()), &mut Silent).unwrap();
    assert_eq!(summary.failures().count(), 0, "{:?}", summary.claims);
    assert!(folder.path().join("flow_0002.png").is_file() && folder.path().join("box.png").is_file());
}
