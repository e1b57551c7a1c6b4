//! No knob without an effect: what is written and does nothing is refused or warned of, with its place.

use cf_scene::{Experiment, Limits, Pace, Problems, SceneFile, Set};

const TEXT: &str = r#"(
    grid: (cells: (16, 32), extent: (1.0, 2.0)),
    sides: (x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open)),
    model: Diffusion(
        law: (k: 1.0, tau: 4.0),
        medium: Uniform((0.0, 0.8)),
        sources: [(shape: Ball(center: (0.5, 0.8), radius: 0.1), rate: 50.0)],
    ),
    accuracy: (level: Standard),
    run: (until: 1.0, frames: 4, variants: [
        (name: "one", set: {"accuracy.integrator": Kdk}),
        (name: "two", set: {"accuracy.integrator": Sdirk2}),
    ]),
)"#;

fn unfold(text: &str, flags: &[&str]) -> Result<Experiment, Problems> {
    let sets: Result<Vec<Set>, _> = flags.iter().map(|flag| Set::parse(flag)).collect();
    SceneFile::parse("s.ron", text)?.experiment(None, &sets?, &Limits { memory: 1 << 30 })
}

fn refusal(text: &str, flags: &[&str]) -> String {
    unfold(text, flags).map(drop).unwrap_err().to_string()
}

fn warnings(text: &str, flags: &[&str]) -> String {
    let runs = unfold(text, flags).unwrap_or_else(|problems| panic!("{problems}")).runs;
    let lines = runs.iter().flat_map(|run| run.warnings.iter().map(move |words| format!("{}: {words}\n", run.run)));
    lines.collect()
}

#[test]
fn a_knob_that_serves_one_run_may_be_idle_in_another() {
    for knob in ["accuracy.solver=Multigrid", "accuracy.tolerance=1e-6", "accuracy.precision=mixed"] {
        assert_eq!(warnings(TEXT, &[knob]), "", "{knob}");
        let words = refusal(TEXT, &[&format!("one:{knob}")]);
        assert!(words.starts_with(&format!("--set one:{knob}: ")) && words.contains("has no effect"), "{words}");
        assert_eq!(warnings(TEXT, &[&format!("two:{knob}")]), "", "{knob}");
    }
    assert!(refusal(TEXT, &["two:accuracy.integrator=Kdk", "accuracy.solver=Multigrid"]).contains("never solves"));
}

#[test]
fn a_knob_made_idle_by_a_choice_of_ours_is_warned_of() {
    let words = warnings(&TEXT.replace("\"accuracy.integrator\": Sdirk2", ""), &["two:accuracy.tolerance=1e-6"]);
    assert!(words.starts_with("two: --set two:accuracy.tolerance=1e-6: accuracy.tolerance: Kdk"), "{words}");
}

#[test]
fn transport_of_a_still_medium_and_numerics_of_an_exact_pulse_are_refused() {
    let still = TEXT.replace("Uniform((0.0, 0.8))", "Still");
    for run in ["one", "two"] {
        let words = refusal(&still, &[&format!("{run}:accuracy.advection=Cubic")]);
        assert!(words.contains("the medium is still, so this has no effect"), "{words}");
    }
    let pulse = "(grid: (cells: (64), extent: (8.0)), sides: (x: Periodic), model: SingleField(form: TwoField, k: 1.0, \
                 tau: 1.0, velocity: 0.5, pulse: (center: 3.0, width: 0.5)), run: (until: 1.0))";
    for knob in ["level=Draft", "integrator=Kdk", "dt=0.1", "cfl=0.1", "tolerance=0.1", "precision=f32", "solver=Auto"]
    {
        let words = refusal(pulse, &[&format!("accuracy.{knob}")]);
        assert!(words.contains("a SingleField pulse is solved exactly"), "{words}");
    }
    assert_eq!(unfold(pulse, &["accuracy.precision=f64"]).unwrap().runs, unfold(pulse, &[]).unwrap().runs);
    let thin = refusal(pulse, &["model.pulse.width=1e-3"]);
    assert!(thin.contains("model.pulse.width: out of range: expected at least a quarter of a cell"), "{thin}");
}

#[test]
fn a_step_that_is_asked_for_is_taken_or_said_not_to_be() {
    let scene = &unfold(TEXT, &["accuracy.cfl=3.0", "run.frames=1"]).unwrap().runs[0];
    let pace = Pace::of(scene);
    assert!((pace.dt - 3.0 * 0.0625 / 1.3).abs() < 1e-12 && pace.dt > 1.0 / 64.0, "{pace:?}");
    assert!(scene.warnings.is_empty());
    for knob in ["accuracy.cfl=1e300", "accuracy.dt=1e300"] {
        let words = warnings(TEXT, &[knob]);
        assert!(
            words.contains(&format!("one: --set {knob}: ")) && words.contains("frames every 0.25 s cut"),
            "{words}"
        );
    }
    let still = TEXT.replace("Uniform((0.0, 0.8))", "Still").replace("\"accuracy.integrator\": Kdk", "");
    let words = refusal(&still, &["model.law.tau=0.0", "accuracy.cfl=0.5"]);
    assert!(words.contains("accuracy.cfl: neither medium nor waves move here"), "{words}");
}

#[test]
fn what_never_acts_is_warned_of() {
    let late = warnings(TEXT, &["model.sources[0].from=1.0"]);
    assert!(late.contains("model.sources[0].from: this source begins after the run has ended"), "{late}");
    let empty = warnings(TEXT, &["model.sources[0].rate=0.0"]);
    assert!(empty.contains("model: no initial value, source or wall puts anything into the box"), "{empty}");
    assert_eq!(warnings(TEXT, &["model.sources[0].rate=0.0", "sides.x.low.inflow=1.0"]), "");
}

#[test]
fn obstacles_leave_something_to_simulate() {
    let with = |obstacles: &str| TEXT.replace("rate: 50.0)],", &format!("rate: 50.0)], obstacles: [{obstacles}],"));
    assert_eq!(warnings(&with("Box(low: (0.0, 0.0), high: (0.4, 2.0))"), &[]), "");
    let deposit = "initial: [(shape: Box(low: (0.1, 0.1), high: (0.3, 0.4)), value: 1.0)], sources";
    let words = refusal(&with("Box(low: (0.0, 0.0), high: (0.4, 2.0))").replace("sources", deposit), &[]);
    assert!(words.contains("model.initial[0].shape: every cell of this shape is solid"), "{words}");
}

#[test]
fn numerics_refuse_at_a_place() {
    let slow = ["model.law.k=1e-90", "model.law.tau=1e95"];
    let words = refusal(TEXT, &["accuracy.precision=f32", "one:accuracy.integrator=Characteristic", slow[0], slow[1]]);
    assert!(
        words.starts_with("--set one:accuracy.integrator=Characteristic: accuracy.integrator: the speed c"),
        "{words}"
    );
}

#[test]
fn a_region_without_cells_proves_nothing() {
    let claim = |statement: &str| {
        let claims = format!("claims: [(name: \"c\", source: Ours, kind: Must, statement: {statement})],\n)");
        TEXT.replace("]),\n)", &format!("]),\n    {claims}"))
    };
    let tail = claim("NoUpstreamTail(run: \"one\", cells: 3, fraction: 1e-3)");
    assert_eq!(warnings(&tail, &[]), "");
    let words = refusal(&tail, &["model.obstacles=[Below(axis: Y, at: 0.6)]"]);
    assert!(words.contains("run `one` has no cells further than 3 cells upstream"), "{words}");
    let cone = claim("Within(quantity: OutsideCone(), run: \"two\", high: 0.5)");
    let words = refusal(&cone, &["two:model.law.fourier=1.0"]);
    assert!(words.contains("the law of run `two` has no memory"), "{words}");
}
