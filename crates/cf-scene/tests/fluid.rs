//! Scenes whose fluid is solved for: runs, checkpoints, masks, knobs, and what is refused.

use cf_scene::progress::{Silent, StopAfter};
use cf_scene::summary::{RunSummary, Summary};
use cf_scene::{Experiment, Limits, Options, RunError, SceneFile, Set, perform};
use std::path::Path;

/// A jet with buoyant ink between an obstacle, a held value and walls of every kind.
const INK: &str = r#"(
    grid: (cells: (40, 64), extent: (1.0, 1.6)),
    sides: (x: Walls(low: Closed, high: Absorbing(speed: 0.2)), y: Walls(low: Open, high: Value(0.0))),
    model: Diffusion(
        law: (k: 0.01, tau: 0.25),
        medium: Solved(
            velocity: (0.0, 0.1),
            walls: (x: (high: Open)),
            buoyancy: (strength: 0.5),
            jets: [(shape: Box(low: (0.4, 0.0), high: (0.6, 0.1)), velocity: (0.0, 1.0), from: 0.11, until: 0.43)],
        ),
        sources: [
            (shape: Box(low: (0.4, 0.0), high: (0.6, 0.1)), rate: 10.0, until: 0.5),
            (shape: Ball(center: (0.8, 0.4), radius: 0.1), value: 0.5, from: 0.2),
        ],
        obstacles: [Ball(center: (0.55, 0.8), radius: 0.15)],
    ),
    accuracy: (precision: f64, cfl: 0.8),
    run: (until: 2.4, frames: 3, variants: [
        (name: "cnp"),
        (name: "reflection", set: {"accuracy.flow": ReflectionExtrapolated, "accuracy.cfl": 2.0}),
        (name: "draft", set: {"accuracy.flow": Draft, "accuracy.splitting": Lie, "accuracy.integrator": PaperBe}),
        (name: "central", set: {"accuracy.flow": CentralRk4, "accuracy.precision": f32, "accuracy.cfl": 0.4, "run.until": 0.4}),
    ]),
    output: (fields: [phi, u, p]),
    claims: [(name: "mass", source: Ours, kind: Must, statement: MassBudget(tolerance: 1e-6))],
)"#;

fn unfold(name: &str, text: &str, flags: &[&str]) -> Result<Experiment, String> {
    let sets: Vec<Set> = flags.iter().map(|flag| Set::parse(flag).unwrap()).collect();
    let file = SceneFile::parse(name, text).map_err(|problems| problems.to_string())?;
    file.experiment(None, &sets, &Limits { memory: 1 << 30 }).map_err(|problems| problems.to_string())
}

fn experiment(text: &str, flags: &[&str]) -> Experiment {
    unfold("ink.ron", text, flags).unwrap_or_else(|problems| panic!("{problems}"))
}

fn dry(experiment: &Experiment) -> Summary {
    perform(experiment, &Options { write: false, ..Options::new("ink", "nowhere") }, &mut Silent).unwrap()
}

/// What must not depend on interruptions and threads.
fn numbers(summary: &Summary) -> String {
    let one = |run: &RunSummary| {
        let flow = run.flow.as_ref().unwrap();
        format!(
            "{} {} {:?} {:?} {:?} {:?} {} {:?} {} {}",
            run.name,
            run.steps,
            run.dt,
            run.mass,
            run.ranges,
            run.iterations,
            flow.scheme,
            flow.projections,
            flow.divergence,
            flow.energy
        )
    };
    summary.runs.iter().map(one).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_fluid_is_solved_for_and_says_what_it_did() {
    let folder = tempfile::tempdir().unwrap();
    let summary = perform(&experiment(INK, &[]), &Options::new("ink", folder.path()), &mut Silent).unwrap();
    assert_eq!(summary.failures().count(), 0, "{:?}", summary.claims);
    let projections = |run: &RunSummary| run.flow.as_ref().unwrap().projections.solves as f64 / run.steps as f64;
    for (run, expected) in summary.runs.iter().zip([1.1, 2.0, 1.0, 4.0]) {
        let flow = run.flow.as_ref().unwrap();
        assert!(flow.divergence > 0.0 && flow.divergence <= flow.eta_div && flow.imbalance == 0.0, "{flow:?}");
        assert!((projections(run) - expected).abs() < 0.2, "{}: {}", run.name, projections(run));
        assert!(flow.speed > 1.0 && flow.speed < 3.0 && flow.courant <= 2.0, "{flow:?}");
        assert!(flow.hc.unwrap().max > 3.0 && flow.hc.unwrap().mean < flow.hc.unwrap().max);
        assert!(["advection", "projection", "transport", "diffusion"].iter().all(|p| run.seconds.phases[*p] > 0.0));
    }
    // The step follows the flow: short while the jet blows, long before.
    assert!(summary.runs[0].dt[1] > 2.0 * summary.runs[0].dt[0], "{:?}", summary.runs[0].dt);
    let arrays = |file: &str| {
        let image = cf_output::read_image(&folder.path().join(file)).unwrap();
        image.arrays.iter().map(|array| (array.name.clone(), array.components)).collect::<Vec<_>>()
    };
    let expected = [("phi".to_owned(), 1), ("u".to_owned(), 3), ("p".to_owned(), 1)];
    assert_eq!(arrays("cnp_0003.vti"), expected);
    // The draft scheme keeps no pressure.
    assert_eq!(arrays("draft_0003.vti"), expected[..2]);
}

#[test]
fn a_fluid_goes_on_with_the_same_bits() {
    let whole = experiment(INK, &[]);
    let expected = numbers(&dry(&whole));
    let folder = tempfile::tempdir().unwrap();
    let mut options = Options::new("ink", folder.path());
    let mut stops = 0;
    let summary = loop {
        match perform(&whole, &options, &mut StopAfter(23)) {
            Ok(summary) => break summary,
            Err(RunError::Stopped { checkpoint: Some(_), .. }) => (options.resume, stops) = (true, stops + 1),
            Err(other) => panic!("{other}"),
        }
        assert!(stops < 100);
    };
    assert!(stops > 8, "{stops}");
    assert_eq!(numbers(&summary), expected);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(numbers(&one.install(|| dry(&whole))), expected);
}

#[test]
fn space_works_too_and_what_is_given_has_no_pressure() {
    let text = r#"(
        grid: (cells: (12, 20, 10), extent: (1.2, 2.0, 1.0)),
        sides: (x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open), z: Periodic),
        model: Diffusion(
            law: (k: 0.01, tau: 0.5),
            medium: Solved,
            initial: [(shape: Ball(center: (0.6, 0.6, 0.5), radius: 0.3), value: 1.0)],
        ),
        run: (until: 1.0, frames: 1, variants: [
            (name: "rises", set: {"model.medium": Solved(buoyancy: (strength: 1.0))}),
            (name: "sinks", set: {"model.medium": Solved(buoyancy: (strength: -1.0))}),
            (name: "rests"),
            (name: "given", set: {"model.medium": Uniform((0.0, 0.1, 0.0))}),
        ]),
        output: (fields: [phi, u]),
    )"#;
    let folder = tempfile::tempdir().unwrap();
    let summary = perform(&experiment(text, &[]), &Options::new("box", folder.path()), &mut Silent).unwrap();
    let run = |name: &str| summary.runs.iter().find(|run| run.name == name).unwrap();
    let height = |name: &str| {
        let image = cf_output::read_image(&folder.path().join(format!("{name}_0001.vti"))).unwrap();
        let phi = &image.arrays[0].values;
        let total: f64 = phi.iter().sum();
        phi.iter().enumerate().map(|(i, v)| v * ((i / 12 % 20) as f64 + 0.5) * 0.1).sum::<f64>() / total
    };
    assert!(height("rises") > 0.65 && height("sinks") < 0.55 && (height("rests") - 0.6).abs() < 1e-4);
    let rests = run("rests").flow.as_ref().unwrap();
    assert!(rests.speed == 0.0 && rests.energy == 0.0 && rests.projections.iterations() == 0, "{rests:?}");
    assert!(run("given").flow.is_none());
    assert!(run("given").fields.iter().all(|field| !field.name.contains("flow")));
    assert!(run("rises").fields.iter().any(|field| field.name.contains("flow")));
}

/// Iterations in all.
trait Total {
    fn iterations(&self) -> usize;
}

impl Total for cf_scene::summary::Iterations {
    fn iterations(&self) -> usize {
        (self.mean * self.solves as f64).round() as usize
    }
}

#[test]
fn without_diffusion_only_the_flow_carries() {
    let flags =
        ["model.law=(k: 0.0, tau: 0.0)", "model.sources=[(shape: Box(low: (0.4, 0.0), high: (0.6, 0.1)), rate: 10.0)]"];
    let summary = dry(&experiment(INK, &[&flags[..], &["sides.x.high=Open"]].concat()));
    let run = &summary.runs[0];
    // What flows in at a metre a second through a tenth of a metre of source carries at most 10/10.
    let phi = run.ranges.iter().find(|range| range.field == "phi").unwrap();
    assert!(phi.min > -1e-12 && run.iterations.solves == 0 && run.mass.drift.abs() < 1e-12, "{run:?}");
    assert!(run.flow.as_ref().unwrap().hc.is_none());
}

#[test]
fn every_knob_of_the_fluid_turns_something() {
    let end = |flags: &[&str]| {
        let mut experiment = experiment(INK, flags);
        experiment.runs.truncate(1);
        numbers(&dry(&experiment))
    };
    let medium = |what: &str| format!("model.medium={what}");
    let base = end(&[]);
    for flag in [
        "accuracy.eta_div=1e-7".to_owned(),
        "accuracy.cfl=0.4".into(),
        "cnp:accuracy=(precision: f64, dt: 0.01)".into(),
        "accuracy.flow=Draft".into(),
        "model.medium.velocity=(0.0, 0.2)".into(),
        "model.medium.buoyancy.strength=1.0".into(),
        "model.medium.buoyancy.reference=0.1".into(),
        "model.medium.buoyancy.up=(1.0, 0.0)".into(),
        "model.medium.jets[0].how=Set".into(),
        "model.medium.jets[0].velocity=(0.1, 1.0)".into(),
        "model.medium.jets[0].until=0.3".into(),
        "model.medium.walls.x.high=Closed".into(),
        "model.sources[1].value=0.25".into(),
        medium("Solved(force: (0.0, 0.3))"),
        medium("Solved(walls: (x: (high: Inflow((-0.2, 0.0)))))"),
    ] {
        assert_ne!(end(&[&flag]), base, "{flag}");
    }
}

#[test]
fn a_mask_file_is_as_good_as_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("ink.ron").display().to_string();
    // 10 x 16 cells, each of four by four of the grid.
    let solid = |i: usize| (4..6).contains(&(i % 10)) && (8..10).contains(&(i / 10));
    let bytes: Vec<u8> = (0..160).map(|i| u8::from(solid(i)) * 255).collect();
    std::fs::write(folder.path().join("rock.raw"), &bytes).unwrap();
    let run = |flags: &[&str]| {
        let mut experiment = unfold(&name, INK, flags).unwrap_or_else(|problems| panic!("{problems}"));
        experiment.runs.truncate(1);
        numbers(&dry(&experiment))
    };
    let file = run(&["model.obstacles=[]", r#"model.mask=(file: "rock.raw", cells: (10, 16))"#]);
    assert_eq!(file, run(&["model.obstacles=[Box(low: (0.4, 0.8), high: (0.6, 1.0))]"]));
    assert_ne!(file, run(&["model.obstacles=[]"]));
    let told = |flag: &str| unfold(&name, INK, &[flag]).map(|_| ()).unwrap_err();
    assert!(
        told(r#"model.mask=(file: "rock.raw")"#)
            .contains("expected 2560 bytes, one for each cell of (40, 64), found 160 bytes")
    );
    assert!(
        told(r#"model.mask=(file: "none.raw")"#).contains("model.mask.file: the mask file `none.raw` cannot be read")
    );
    assert!(told(r#"model.mask=(file: ".")"#).contains("is not a file"));
    assert!(told(r#"model.mask=(file: "rock.raw", cells: (160))"#).contains("model.mask.cells: the grid has 2 axes"));
    assert!(told(r#"model.mask=(file: "rock.raw", cells: (0, 16))"#).contains("model.mask.cells"));
    std::fs::write(folder.path().join("full.raw"), [1; 2560]).unwrap();
    assert!(told(r#"model.mask=(file: "full.raw")"#).contains("the obstacles fill every cell"));
    assert!(Path::new(&name).parent().is_some());
}

#[test]
fn a_jet_within_an_obstacle_is_refused() {
    let text = INK.replace("obstacles: [Ball", "obstacles: [Box(low: (0.3, 0.0), high: (0.7, 0.3)), Ball");
    let text = text.replace("(shape: Box(low: (0.4, 0.0), high: (0.6, 0.1)), rate: 10.0, until: 0.5),", "");
    let problem = unfold("ink.ron", &text, &[]).unwrap_err();
    assert!(problem.contains("model.medium.jets[0].shape: every cell of this shape is solid"), "{problem}");
}

#[test]
fn what_makes_no_flow_is_refused_where_it_stands() {
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "velocity: (0.0, 0.1)",
            "velocity: (0.0, 0.1, 0.0)",
            &["ink.ron:7:23: model.medium.velocity: the grid has 2 axes"],
        ),
        (
            "velocity: (0.0, 0.1)",
            "velcity: (0.0, 0.1)",
            &["ink.ron:7:13: model.medium: unknown key `velcity`", "did you mean `velocity`"],
        ),
        (
            "x: (high: Open)",
            "x: (low: Open)",
            &["ink.ron:8:30: model.medium.walls.x.low: the fluid passes this wall along x, which is Closed to phi"],
        ),
        ("x: (high: Open)", "x: (low: Inflow((0.5, 0.0)))", &["model.medium.walls.x.low: the fluid passes"]),
        ("x: (high: Open)", "x: (high: Inflow((0.5)))", &["model.medium.walls.x.high: the grid has 2 axes"]),
        (
            "x: (high: Open)",
            "z: (high: Open)",
            &["model.medium.walls.z: the grid has 2 axes, so there is no wall along z"],
        ),
        (
            "x: (high: Open)",
            "x: (high: Opne)",
            &[
                "`Opne` is not one of the choices",
                "did you mean `Open`",
                "write high: Inflow((1.0, 0.0)), high: Open or",
            ],
        ),
        (
            "(x: (high: Open))",
            "Open",
            &["model.medium.walls: `Open` is", "expected walls: (x: (low: Inflow((1.0, 0.0)),"],
        ),
        (
            "x: (high: Open)",
            "x: Open",
            &["model.medium.walls.x: `Open` is", "expected x: (low: Inflow((1.0, 0.0)), high"],
        ),
        (
            "x: (high: Open)",
            "x: (Open, Open)",
            &["unknown key `Open`", "write x: (low: Inflow((1.0, 0.0)), high: Open)"],
        ),
        ("x: (high: Open)", "x: (high: Inflow(1.0))", &["expected high: Inflow((1.0, 0.0)), high: Open or"]),
        ("x: (high: Open)", "high: Open", &["unknown key `high`", "write walls: (x: (low: Inflow((1.0, 0.0)),"]),
        ("strength: 0.5", "reference: 0.5", &["model.medium.buoyancy: the key `strength` is missing"]),
        ("strength: 0.5", "strength: 0.5, up: (0.0, 0.0)", &["model.medium.buoyancy.up: this points nowhere"]),
        ("strength: 0.5", "strength: inf", &["model.medium.buoyancy.strength: not a finite number"]),
        (
            "shape: Box(low: (0.4, 0.0), high: (0.6, 0.1)), velocity",
            "shape: Everywhere, velocity",
            &["model.medium.jets[0].shape: a jet of this shape", "`Box` or `Ball`"],
        ),
        (
            "shape: Box(low: (0.4, 0.0), high: (0.6, 0.1)), velocity",
            "shape: Ball(center: (9.0, 0.0), radius: 0.1), velocity",
            &["model.medium.jets[0].shape: the shape lies wholly outside"],
        ),
        (
            "velocity: (0.0, 1.0), from: 0.11",
            "velocity: (1.0), from: 0.11",
            &["model.medium.jets[0].velocity: the grid has 2 axes"],
        ),
        ("until: 0.43", "until: 0.1", &["model.medium.jets[0].until: out of range: expected later than from"]),
        (
            "y: Walls(low: Open,",
            "y: Walls(low: Closed,",
            &["model.medium.jets[0]: this jet blows through a wall along y, which is Closed to phi"],
        ),
        ("value: 0.5, from", "from", &["model.sources[1]: the key `rate` is missing", "or value"]),
        (
            "value: 0.5, from",
            "value: 0.5, rate: 1.0, from",
            &["model.sources[1].value: a source either adds at a rate or holds a value"],
        ),
        (
            "shape: Ball(center: (0.8, 0.4), radius: 0.1)",
            "shape: Gaussian(center: (0.8, 0.4), width: 0.1)",
            &["model.sources[1].shape: this shape has no inside"],
        ),
        ("cfl: 0.8", "eta_div: 0.0", &["accuracy.eta_div: out of range"]),
        ("cfl: 0.8", "step: Adaptive(tolerance: 1e-3)", &["accuracy.step: where a fluid is solved for"]),
        ("cfl: 0.8", "level: Target(1e-2)", &["accuracy.level: where a fluid is solved for"]),
        (
            "cfl: 0.8",
            "integrator: Characteristic",
            &["accuracy.integrator: Characteristic follows the waves of a uniform medium"],
        ),
        ("cfl: 0.8", "cfl: -1.0", &["accuracy.cfl: out of range"]),
    ];
    let mut wrong = Vec::new();
    for (from, to, parts) in cases {
        assert!(INK.contains(from), "{from}");
        let told =
            unfold("ink.ron", &INK.replacen(from, to, 1), &[]).map(|_| String::new()).unwrap_or_else(|told| told);
        wrong.extend(
            parts.iter().filter(|part| !told.contains(*part)).map(|part| format!("{to}: {part} not in\n{told}")),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let idle = unfold("ink.ron", INK, &["model.medium=Still", "accuracy.eta_div=1e-3"]).map(|_| ()).unwrap_err();
    assert!(idle.contains("no fluid is solved for, so this has no effect"), "{idle}");
}

#[test]
fn an_unstable_flow_ends_the_run_as_a_numerical_failure() {
    let central = experiment(INK, &["central:run.until=2.4"]);
    let options = Options { write: false, ..Options::new("ink", "nowhere") };
    let error =
        perform(&Experiment { runs: central.runs[3..].to_vec(), ..central }, &options, &mut Silent).unwrap_err();
    assert_eq!(error.failure(), cf_scene::Failure::Numerical, "{error}");
    assert!(error.to_string().contains("accuracy.cfl"), "{error}");
}

/// What a claim about the ink came to.
fn claimed(claim: &str, flags: &[&str]) -> (bool, String) {
    let claim = format!("(name: \"it\", source: Ours, kind: Must, statement: {claim})");
    let text = INK.replace("(name: \"mass\", source", &format!("{claim}, (name: \"mass\", source"));
    let mut experiment = experiment(&text, flags);
    experiment.runs.truncate(1);
    let found = dry(&experiment).claims.swap_remove(0);
    (found.pass, found.measured)
}

/// What goes into a closed part of the fluid stays in it as divergence: no projection takes it out, and no claim may hide it.
#[test]
fn what_does_not_balance_fails_the_claim_of_divergence() {
    let scene = |solved: &str, obstacles: &str| {
        format!(
            "(grid: (cells: (32, 32), extent: (1.0, 1.0)), \
             sides: (x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open)), \
             model: Diffusion(law: (k: 0.0, tau: 0.0), medium: Solved({solved}), obstacles: [{obstacles}]), \
             accuracy: (precision: f64), run: (until: 0.1, frames: 1), \
             claims: [(name: \"it\", source: Ours, kind: Must, statement: Divergence(most: 1e-4))])"
        )
    };
    let jet = "jets: [(shape: Box(low: (0.3, 0.0), high: (0.6, 0.2)), velocity: (0.0, 1.0))]";
    // Half of the jet blows into a solid.
    let half = "Box(low: (0.45, 0.1), high: (0.7, 0.4))";
    let inflow = "walls: (x: (low: Inflow((1.0, 0.0)), high: Closed), y: (low: Closed, high: Closed))";
    for (solved, obstacles, holds) in [(jet, "", true), (jet, half, false), (inflow, "", false)] {
        let summary = dry(&experiment(&scene(solved, obstacles), &[]));
        let (claim, flow) = (&summary.claims[0], summary.runs[0].flow.as_ref().unwrap());
        assert_eq!((claim.pass, flow.imbalance == 0.0), (holds, holds), "{solved}: {} {flow:?}", claim.measured);
        assert!(holds || flow.divergence > 1e-3, "{solved}: {flow:?}");
    }
}

#[test]
fn claims_about_a_fluid_hold_and_can_fail() {
    let no_reference = &["model.medium.buoyancy.reference=0.0", "run.frames=30"][..];
    let undriven = &["model.medium=Solved(buoyancy: (strength: 2.0))", "model.sources[1].from=0.0"][..];
    let blunt = &["cnp:accuracy.integrator=PaperBe", "cnp:accuracy.tolerance=1e-12", "run.frames=30"][..];
    for (claim, flags, expected) in [
        ("Divergence(most: 1e-4)", no_reference, true),
        ("Divergence(most: 1e-6)", no_reference, false),
        ("FlowIterations(most: 12)", no_reference, true),
        ("FlowIterations(most: 1)", no_reference, false),
        ("Iterations(most: 20)", blunt, true),
        ("Iterations(most: 1)", blunt, false),
        ("Front(run: \"cnp\", fraction: 1e-3, cells: 2)", no_reference, true),
        // The flow carries phi this far, not a wave.
        ("Front(run: \"cnp\", fraction: 1e-3, cells: 2)", &["model.law=(k: 0.0, tau: 0.0)", "sides.x.high=Open"], true),
        // Every implicit step reaches the whole box.
        ("Front(run: \"cnp\", fraction: 1e-9, cells: 2)", blunt, false),
        ("Within(quantity: EnergyPerWork, run: \"cnp\", low: 0.05, high: 1.0)", undriven, true),
        // The jet's work is not counted.
        ("Within(quantity: EnergyPerWork, run: \"cnp\", high: 1.0)", no_reference, false),
        ("Within(quantity: Centre(X), run: \"cnp\", low: 0.5, high: 0.9)", no_reference, true),
        ("Within(quantity: Centre(Y), run: \"cnp\", low: 1.5)", no_reference, false),
        ("NoPressure", no_reference, false),
    ] {
        let (holds, measured) = claimed(claim, flags);
        assert_eq!(holds, expected, "{claim}: {measured}");
        assert!(!measured.contains("not measurable"), "{claim}: {measured}");
    }
    let told = |claim: &str, flags: &[&str]| {
        let claim = format!("(name: \"it\", source: Ours, kind: Must, statement: {claim})");
        let text = INK.replace("(name: \"mass\", source", &format!("{claim}, (name: \"mass\", source"));
        unfold("ink.ron", &text, flags).map(|_| ()).unwrap_err()
    };
    let still = &["model.medium=Still"];
    assert!(told("Divergence(most: 1e-4)", still).contains("there is none"));
    assert!(told("FlowIterations(most: 8)", still).contains("there is none"));
    assert!(told("Within(quantity: PeakMemory, run: \"cnp\", high: 9.0)", &[]).contains("cannot be demanded"));
    assert!(told("Ratio(quantity: Mass, runs: (\"cnp\", \"cnp\"), high: 9.0)", &[]).contains("the same run"));
    assert!(told("Ratio(quantity: Mass, runs: (\"cnp\", \"dratf\"), high: 9.0)", &[]).contains("runs[1]"));
    assert!(told("Divergence(most: 0.0)", &[]).contains("claims[0].statement.most: out of range"));
    assert!(told("Front(run: \"cnp\", fraction: 0.0, cells: 1)", &[]).contains("statement.fraction: out of range"));
    let fourier = &["model.law=(k: 0.1, tau: 0.0)", "sides.x.high=Open"];
    assert!(told("Front(run: \"cnp\", fraction: 0.1, cells: 1)", fourier).contains("reach every cell at once"));
    assert!(told("Within(quantity: Centre(Z), run: \"cnp\", low: 0.0)", &[]).contains("no such axis"));
}

#[test]
fn given_media_have_no_pressure_and_runs_have_ratios() {
    let measured = |claim: &str, kind: &str| {
        let text = format!(
            "(grid: (cells: (24, 24), extent: (1.0, 1.0)), sides: (x: Periodic), \
             model: Diffusion(law: (k: 0.01, tau: 0.1, fourier: 0.5), medium: Uniform((0.5, 0.0)), \
                 initial: [(shape: Ball(center: (0.5, 0.5), radius: 0.2), value: 1.0)]), \
             run: (until: 0.2, frames: 1, variants: [(name: \"a\"), (name: \"b\", set: {{\"model.initial[0].value\": 2.0}})]), \
             claims: [(name: \"it\", source: Ours, kind: {kind}, statement: {claim})])"
        );
        dry(&experiment(&text, &[])).claims.swap_remove(0)
    };
    for (claim, kind, expected) in [
        ("NoPressure", "Must", true),
        ("Ratio(quantity: Mass, runs: (\"b\", \"a\"), low: 1.9, high: 2.1)", "Must", true),
        ("Ratio(quantity: Mass, runs: (\"a\", \"b\"), low: 1.9)", "Must", false),
        ("Ratio(quantity: DiffusionSeconds, runs: (\"a\", \"b\"), low: 0.0)", "Report", true),
        ("Within(quantity: PeakMemory, run: \"a\", high: 1e-6)", "Report", false),
    ] {
        let found = measured(claim, kind);
        assert_eq!(found.pass, expected, "{claim}: {}", found.measured);
        assert!(!found.measured.contains("not measurable"), "{claim}: {}", found.measured);
        assert_eq!(found.of_the_machine, kind == "Report", "{claim}");
    }
    // What the budget is relative to is what it says.
    let budget = measured("MassBudget(tolerance: 1e-6)", "Must");
    assert!(
        budget.expected.contains("sum of |phi|, what was emitted, and what was there at the start"),
        "{}",
        budget.expected
    );
}

#[test]
fn clouds_are_drawn_in_space_and_refused_in_the_plane() {
    let text = r#"(
        grid: (cells: (12, 20, 10), extent: (1.2, 2.0, 1.0)),
        sides: (x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open), z: Periodic),
        model: Diffusion(
            law: (k: 0.01, tau: 0.5),
            medium: Solved(buoyancy: (strength: 1.0)),
            initial: [(shape: Ball(center: (0.6, 0.6, 0.5), radius: 0.3), value: 1.0)],
            obstacles: [Ball(center: (0.6, 1.2, 0.5), radius: 0.2)],
        ),
        run: (until: 1.0, frames: 4, variants: [(name: "a"), (name: "b")]),
        output: (pictures: Off, vtk: false, volume: (look: Smoke, high: 0.5)),
    )"#;
    let folder = tempfile::tempdir().unwrap();
    let experiment = experiment(text, &[]);
    let mut options = Options::new("box", folder.path());
    let summary = loop {
        // Stopped and taken up again, the animation is whole all the same.
        match perform(&experiment, &options, &mut StopAfter(29)) {
            Ok(summary) => break summary,
            Err(RunError::Stopped { .. }) => options.resume = true,
            Err(other) => panic!("{other}"),
        }
    };
    assert!(options.resume);
    let frames = |path: &str| {
        let bytes = std::fs::read(folder.path().join(path)).unwrap();
        bytes.windows(4).filter(|chunk| *chunk == b"fcTL").count()
    };
    assert_eq!(frames("a_cloud_animation.png"), 5);
    assert_eq!(frames("box_clouds_animation.png"), 5);
    assert!(summary.files.contains(&"box_clouds.png".to_owned()));
    assert!(summary.runs[0].files.contains(&"a_cloud_0004.png".to_owned()));
    let pixels = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_ne!(pixels("a_cloud_0000.png"), pixels("a_cloud_0004.png"));
    assert!(summary.runs[0].files.contains(&"a_cloud_animation.png".to_owned()));
    assert!(std::fs::read_dir(folder.path()).unwrap().all(|file| !file.unwrap().path().ends_with(".a.clouds")));
    // Without stops, the same pictures.
    let again = tempfile::tempdir().unwrap();
    perform(&experiment, &Options::new("box", again.path()), &mut Silent).unwrap();
    for name in ["box_clouds.png", "b_cloud_0003.png"] {
        assert_eq!(pixels(name), std::fs::read(again.path().join(name)).unwrap(), "{name}");
    }
    let told = |flag: &str| unfold("box.ron", text, &[flag]).map(|_| ()).unwrap_err();
    assert!(told("output.volume.high=0.0").contains("output.volume.high: out of range"));
    assert!(told("output.volume.eye=(0.0, 100.0)").contains("output.volume.eye: out of range"));
    let flat = unfold("ink.ron", INK, &["output=(volume: (look: Ink, high: 1.0))"]).map(|_| ()).unwrap_err();
    assert!(flat.contains("a cloud needs three dimensions"), "{flat}");
}

#[test]
fn clouds_fill_their_pictures_and_choose_their_own_range() {
    // A puff in a corner of a large box of still air.
    let text = r#"(
        grid: (cells: (32, 32, 32), extent: (3.2, 3.2, 3.2)),
        model: Diffusion(
            law: (k: 0.001, tau: 0.0),
            initial: [(shape: Ball(center: (0.5, 0.6, 0.5), radius: 0.3), value: 0.004)],
        ),
        run: (until: 0.5, frames: 1),
        output: (pictures: Off, vtk: false, volume: (look: Smoke)),
    )"#;
    let covered = |flags: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        perform(&experiment(text, flags), &Options::new("puff", folder.path()), &mut Silent).unwrap();
        let picture = cf_output::Canvas::read_png(&folder.path().join("main_cloud_0001.png")).unwrap();
        let bright = picture.pixels().chunks_exact(3).filter(|pixel| pixel[1] > 150).count();
        bright as f64 / (picture.width() * picture.height()) as f64
    };
    assert!(covered(&[]) > 0.15, "{}", covered(&[]));
    assert!(covered(&["output.volume.whole=true"]) < 0.06);
    assert!(covered(&["output.volume.high=1.0"]) < 0.01);
}
