//! No knob without its effect: every key of a scene that a run depends on is turned, and what changes is what was said.
//! Costs are counted, never timed.

use super::{Ran, WAKE, unfold};
use cf_scene::spec::{AccuracySpec, Flow, LawSpec, Medium, Output, RunSpec, SourceSpec};
use cf_scene::summary::RunSummary;

/// What turning a knob does, from the first setting to the second.
#[derive(Clone, Copy)]
enum Effect {
    /// The number rises.
    Rises(fn(&RunSummary) -> f64),
    /// The number rises so many times.
    Times(f64, fn(&RunSummary) -> f64),
    /// The error against a run of far smaller steps on the same cells falls; the settings of that run.
    Sharper(&'static [&'static str]),
    /// phi at the end differs.
    Differs,
}
use Effect::{Differs, Rises, Sharper, Times};

type Knob = (&'static str, &'static [&'static str], [&'static str; 2], &'static [Effect]);

fn steps(run: &RunSummary) -> f64 {
    run.steps as f64
}
fn solves(run: &RunSummary) -> f64 {
    run.iterations.solves as f64
}
fn iterations(run: &RunSummary) -> f64 {
    run.iterations.mean * run.iterations.solves as f64
}
fn projections(run: &RunSummary) -> f64 {
    run.flow.as_ref().map_or(0.0, |flow| flow.projections.solves as f64)
}
fn pressure_iterations(run: &RunSummary) -> f64 {
    run.flow.as_ref().map_or(0.0, |flow| flow.projections.solves as f64 * flow.projections.mean)
}
fn phi_bytes(run: &RunSummary) -> f64 {
    run.fields[0].bytes as f64
}
fn time(run: &RunSummary) -> f64 {
    run.time
}
fn cells(run: &RunSummary) -> f64 {
    run.cells.iter().map(|n| *n as f64).product()
}
fn fewer_lost(run: &RunSummary) -> f64 {
    -run.mass.drift.abs()
}
fn emitted(run: &RunSummary) -> f64 {
    run.mass.emitted
}
fn highest(run: &RunSummary) -> f64 {
    run.ranges[0].max
}
fn smaller_residual(run: &RunSummary) -> f64 {
    -run.residual
}
fn smaller_estimate(run: &RunSummary) -> f64 {
    -run.error.whole_run.unwrap_or(f64::NAN)
}
fn files(run: &RunSummary) -> f64 {
    run.files.len() as f64
}

const FINE: &[&str] = &["accuracy.integrator=Sdirk2", "accuracy.dt=0.004", "accuracy.tolerance=1e-10"];
const STEADY: &[&str] = &["accuracy.dt=0.0625"];
const BUOYANT: &[&str] = &["model.medium=Solved(buoyancy: (strength: 0.05))"];
const WAVES: &[&str] = &["model.law.fourier=0.0", "accuracy.dt=0.0625"];

/// Key, what else is set, the two settings, and what changes from the first to the second.
const ACCURACY: &[Knob] = &[
    ("level", &[], ["accuracy.level=Draft", "accuracy.level=Standard"], &[Sharper(FINE), Rises(solves)]),
    ("level", &[], ["accuracy.level=Standard", "accuracy.level=Accurate"], &[Sharper(FINE), Rises(steps)]),
    (
        "level",
        &["grid.cells=(64, 128)"],
        ["accuracy.level=Target(0.2)", "accuracy.level=Target(0.02)"],
        &[Rises(steps), Rises(cells)],
    ),
    (
        "integrator",
        STEADY,
        ["accuracy.integrator=PaperBe", "accuracy.integrator=Sdirk2"],
        &[Times(2.0, solves), Sharper(FINE)],
    ),
    ("integrator", WAVES, ["accuracy.integrator=Kdk", "accuracy.integrator=Sdirk2"], &[Rises(solves), Differs]),
    (
        "integrator",
        WAVES,
        ["accuracy.integrator=Characteristic", "accuracy.integrator=PaperBe"],
        &[Rises(solves), Differs],
    ),
    ("advection", STEADY, ["accuracy.advection=Linear", "accuracy.advection=Cubic"], &[Differs, Sharper(FINE)]),
    ("advection", STEADY, ["accuracy.advection=Cubic", "accuracy.advection=Muscl"], &[Differs, Rises(fewer_lost)]),
    (
        "splitting",
        &["accuracy.dt=0.125"],
        ["accuracy.splitting=Lie", "accuracy.splitting=Strang"],
        &[Differs, Rises(smaller_estimate)],
    ),
    ("dt", &[], ["accuracy.dt=0.25", "accuracy.dt=0.125"], &[Times(2.0, steps), Sharper(FINE)]),
    ("cfl", &[], ["accuracy.cfl=2.0", "accuracy.cfl=1.0"], &[Rises(steps), Rises(smaller_estimate)]),
    (
        "step",
        &["model.medium=Still"],
        ["accuracy.step=Adaptive(tolerance: 1e-2)", "accuracy.step=Adaptive(tolerance: 1e-4)"],
        &[Rises(steps), Sharper(FINE)],
    ),
    (
        "tolerance",
        STEADY,
        ["accuracy.tolerance=1e-3", "accuracy.tolerance=1e-8"],
        &[Rises(iterations), Rises(smaller_residual)],
    ),
    (
        "precision",
        STEADY,
        ["accuracy.precision=f32", "accuracy.precision=f64"],
        &[Times(2.0, phi_bytes), Rises(fewer_lost)],
    ),
    (
        "precision",
        &["accuracy.dt=0.25", "accuracy.solver=Multigrid"],
        ["accuracy.precision=mixed", "accuracy.precision=f64"],
        &[Differs],
    ),
    (
        "solver",
        &["accuracy.dt=0.5", "model.law.k=4.0", "accuracy.tolerance=1e-6"],
        ["accuracy.solver=Multigrid", "accuracy.solver=Chebyshev"],
        &[Rises(iterations), Differs],
    ),
    ("cfl", BUOYANT, ["accuracy.cfl=0.8", "accuracy.cfl=0.2"], &[Rises(steps), Differs]),
    ("flow", BUOYANT, ["accuracy.flow=Cnp", "accuracy.flow=CentralRk4"], &[Rises(projections), Differs]),
    ("flow", BUOYANT, ["accuracy.flow=Draft", "accuracy.flow=ReflectionExtrapolated"], &[Rises(projections), Differs]),
    ("eta_div", BUOYANT, ["accuracy.eta_div=1e-2", "accuracy.eta_div=1e-7"], &[Rises(pressure_iterations), Differs]),
];

/// The same for what is no accuracy.
const OTHERS: &[Knob] = &[
    (
        "grid.cells",
        &["accuracy.cfl=1.0"],
        ["grid.cells=(32, 64)", "grid.cells=(64, 128)"],
        &[Times(4.0, cells), Rises(steps)],
    ),
    ("grid.extent", &[], ["grid.extent=(2.0, 4.0)", "grid.extent=(4.0, 8.0)"], &[Differs]),
    ("grid.origin", &[], ["grid.origin=(0.0, 0.0)", "grid.origin=(0.25, 0.0)"], &[Differs]),
    ("sides", &[], ["sides.y=Periodic", "sides.y=Walls(low: Open, high: Open)"], &[Differs]),
    ("sides.flux", &[], ["sides.x.low=Flux(-1.0)", "sides.x.low=Flux(-100.0)"], &[Rises(highest)]),
    ("sides.value", &[], ["sides.y.low=Value(1.0)", "sides.y.low=Value(100.0)"], &[Rises(highest)]),
    (
        "sides.inflow",
        &["sides.y.high=Open"],
        ["sides.y.low=Open(inflow: 1.0)", "sides.y.low=Open(inflow: 100.0)"],
        &[Rises(highest)],
    ),
    ("sides.speed", &["run.until=6"], ["sides.y.high.speed=Some(0.1)", "sides.y.high.speed=Some(0.5)"], &[Differs]),
    ("model.law.k", &[], ["model.law.k=0.5", "model.law.k=0.25"], &[Rises(highest)]),
    ("model.law.tau", &[], ["model.law.tau=4.0", "model.law.tau=1.0"], &[Differs]),
    ("model.law.fourier", &[], ["model.law.fourier=0.5", "model.law.fourier=0.1"], &[Differs]),
    ("model.law.c", &["model.law.k=None"], ["model.law.c=Some(0.2)", "model.law.c=Some(0.4)"], &[Differs]),
    ("model.law.hc", &["model.law.k=None"], ["model.law.hc=Some(2.0)", "model.law.hc=Some(1.5)"], &[Differs]),
    (
        "model.law.cone_angle",
        &["model.law.k=None"],
        ["model.law.cone_angle=Some(30.0)", "model.law.cone_angle=Some(50.0)"],
        &[Differs],
    ),
    (
        "model.medium.rate",
        &[],
        [
            "model.medium=Analytic(Rotation(center: (1.0, 2.0), rate: 0.2))",
            "model.medium=Analytic(Rotation(center: (1.0, 2.0), rate: 0.8))",
        ],
        &[Rises(steps), Differs],
    ),
    (
        "model.medium.center",
        &["accuracy.dt=0.05"],
        [
            "model.medium=Analytic(Rotation(center: (1.0, 2.0), rate: 0.2))",
            "model.medium=Analytic(Rotation(center: (1.0, 1.5), rate: 0.2))",
        ],
        &[Differs],
    ),
    (
        "model.medium.period",
        &["accuracy.dt=0.02"],
        ["model.medium=Analytic(Deformation(period: 1.0))", "model.medium=Analytic(Deformation(period: 2.0))"],
        &[Differs],
    ),
    (
        "model.medium.velocity",
        &[],
        ["model.medium=Solved(velocity: (0.0, 0.5))", "model.medium=Solved(velocity: (0.0, 5.0))"],
        &[Rises(steps), Differs],
    ),
    (
        "model.medium.force",
        &["sides.y=Periodic"],
        ["model.medium=Solved(force: (0.0, 0.5))", "model.medium=Solved(force: (0.0, 5.0))"],
        &[Rises(steps), Differs],
    ),
    (
        "model.medium.buoyancy",
        &[],
        ["model.medium=Solved(buoyancy: (strength: 0.05))", "model.medium=Solved(buoyancy: (strength: 5.0))"],
        &[Rises(steps), Differs],
    ),
    ("model.medium", &[], ["model.medium=Still", "model.medium=Uniform((0.0, 0.5))"], &[Differs]),
    (
        "model.initial",
        &[],
        ["model.initial=[]", "model.initial=[(shape: Everywhere, value: 100.0)]"],
        &[Rises(highest)],
    ),
    ("model.sources.rate", &[], ["model.sources[0].rate=50.0", "model.sources[0].rate=100.0"], &[Times(2.0, emitted)]),
    (
        "model.sources.value",
        &[],
        [
            "model.sources=[(shape: Ball(center: (1.0, 1.0), radius: 0.2), value: 1.0)]",
            "model.sources=[(shape: Ball(center: (1.0, 1.0), radius: 0.2), value: 2.0)]",
        ],
        &[Times(2.0, highest)],
    ),
    ("model.sources.from", &[], ["model.sources[0].from=1.0", "model.sources[0].from=0.0"], &[Times(2.0, emitted)]),
    (
        "model.sources.until",
        &[],
        ["model.sources[0].until=Some(0.5)", "model.sources[0].until=Some(1.0)"],
        &[Times(2.0, emitted)],
    ),
    (
        "model.obstacles",
        &["model.medium=Still"],
        ["model.obstacles=[]", "model.obstacles=[Box(low: (0.5, 1.5), high: (1.5, 1.75))]"],
        &[Differs],
    ),
    ("run.until", &["accuracy.cfl=1.0"], ["run.until=1.0", "run.until=2.0"], &[Times(2.0, time), Rises(steps)]),
    ("run.frames", &[], ["run.frames=1", "run.frames=5"], &[Rises(files)]),
    ("run.every", &["run.frames=None"], ["run.every=1.0", "run.every=0.25"], &[Rises(files)]),
    ("run.steps", &[], ["run.steps=5", "run.steps=10"], &[Times(2.0, steps)]),
    ("output.vtk", &[], ["output.vtk=false", "output.vtk=true"], &[Rises(files)]),
    ("output.table", &[], ["output.table=false", "output.table=true"], &[Rises(files)]),
    ("output.pictures", &[], ["output.pictures=Off", "output.pictures=Auto"], &[Rises(files)]),
];

fn turn(knobs: &[Knob]) {
    let mut wrong = Vec::new();
    for (key, base, settings, effects) in knobs {
        let ran = settings.map(|setting| Ran::of(WAKE, &base.iter().copied().chain([setting]).collect::<Vec<_>>()));
        for effect in *effects {
            let numbers = |number: fn(&RunSummary) -> f64| [number(ran[0].run()), number(ran[1].run())];
            let (holds, what) = match effect {
                Rises(number) => {
                    let [a, b] = numbers(*number);
                    (a < b, format!("{a} to {b}, expected a rise"))
                }
                Times(factor, number) => {
                    let [a, b] = numbers(*number);
                    ((b / a / factor - 1.0).abs() < 0.1, format!("{a} to {b}, expected {factor} times as much"))
                }
                Sharper(fine) => {
                    let still = base.iter().filter(|set| set.starts_with("model"));
                    let reference = Ran::of(WAKE, &fine.iter().chain(still).copied().collect::<Vec<_>>());
                    let [a, b] = [0, 1].map(|i| ran[i].error(&reference));
                    (b < a, format!("error {a:e} to {b:e}, expected it to fall"))
                }
                Differs => (ran[0].phi != ran[1].phi, "the same phi to the bit".to_owned()),
            };
            if !holds {
                wrong.push(format!("{key}, {} to {}: {what}", settings[0], settings[1]));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn accuracy_does_what_it_says() {
    turn(ACCURACY);
}

#[test]
fn everything_else_changes_something() {
    turn(OTHERS);
}

#[test]
fn no_knob_is_forgotten() {
    // A new key does not compile here until it is named.
    let AccuracySpec {
        level,
        integrator,
        advection,
        splitting,
        dt,
        cfl,
        step,
        tolerance,
        precision,
        solver,
        flow,
        eta_div,
    } = AccuracySpec::default();
    let keys = [
        ("level", level.is_none()),
        ("integrator", integrator.is_none()),
        ("advection", advection.is_none()),
        ("splitting", splitting.is_none()),
        ("dt", dt.is_none()),
        ("cfl", cfl.is_none()),
        ("step", step.is_none()),
        ("tolerance", tolerance.is_none()),
        ("precision", precision.is_none()),
        ("solver", solver.is_none()),
        ("flow", flow.is_none()),
        ("eta_div", eta_div.is_none()),
    ];
    for (key, open) in keys {
        assert!(open && ACCURACY.iter().any(|knob| knob.0 == key), "{key}");
    }
}

/// Keys of a scene and where they are turned. A new key does not compile here until it is named.
#[test]
fn no_other_knob_is_forgotten() {
    let LawSpec { k: _, tau: _, c: _, hc: _, cone_angle: _, fourier: _ } = LawSpec::default();
    let law = ["k", "tau", "c", "hc", "cone_angle", "fourier"].map(|key| format!("model.law.{key}"));
    let Output { vtk: _, table: _, pictures: _, volume: _, fields: _ } = Output::default();
    let run = |RunSpec { until: _, frames: _, every: _, steps: _, variants: _ }: RunSpec| {};
    let source = |SourceSpec { shape: _, rate: _, value: _, from: _, until: _ }: SourceSpec| {};
    let medium = |medium: Medium| match medium {
        Medium::Still | Medium::Uniform(_) => {}
        Medium::Analytic(Flow::Rotation { center: _, rate: _ } | Flow::Deformation { period: _ }) => {}
        Medium::Solved { velocity: _, walls: _, force: _, buoyancy: _, jets: _ } => {}
    };
    let _ = (run, source, medium);
    let rest = [
        // Volumes need a third axis, fields and variants files: tests/perform.rs; walls of a flow and jets: tests/fluid.rs.
        "output.vtk",
        "output.table",
        "output.pictures",
        "run.until",
        "run.frames",
        "run.every",
        "run.steps",
        "model.sources.rate",
        "model.sources.value",
        "model.sources.from",
        "model.sources.until",
        "model.medium.center",
        "model.medium.rate",
        "model.medium.period",
        "model.medium.velocity",
        "model.medium.force",
        "model.medium.buoyancy",
    ];
    for key in law.iter().map(String::as_str).chain(rest) {
        assert!(OTHERS.iter().any(|knob| knob.0 == key), "{key}");
    }
}

#[test]
fn explicit_waves_are_chosen_where_they_are_cheaper_and_the_reason_is_told() {
    let pace = |sets: &[&str]| {
        let experiment = unfold(WAKE, sets);
        cf_scene::Pace::of(&experiment.runs[0])
    };
    let explicit = pace(&["model.law.fourier=0.0"]);
    assert_eq!(explicit.integrator, Some(cf_scene::spec::Integrator::Kdk));
    assert!(explicit.integrator_reason.contains("of its stability limit"), "{}", explicit.integrator_reason);
    // The explicit limit of a short memory is that of heat: h²/4k = 1 ms, a twentieth of the step and less.
    for (k, integrator) in [("1.0", cf_scene::spec::Integrator::Kdk), ("4.0", cf_scene::spec::Integrator::Sdirk2)] {
        let law = format!("model.law=(k: {k}, tau: 1e-9)");
        let chosen = pace(&[&law, "accuracy.dt=0.015"]);
        assert_eq!(chosen.integrator, Some(integrator), "{}", chosen.integrator_reason);
    }
}
