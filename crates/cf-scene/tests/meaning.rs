//! What a scene means: the law from what users think in, levels, short forms, frames and shapes.

use cf_scene::spec::{Advection, Axes, AxisSides, Integrator, Level, Precision, Shape, Splitting, Wall};
use cf_scene::{Experiment, Law, Limits, Model, SceneFile, Set, TimeStep};

fn unfold(law: &str, preset: Option<&str>, flags: &[&str]) -> Experiment {
    let text = format!(
        "(grid: (cells: (20, 10), extent: (2.0, 1.0)), sides: (x: Walls(low: Open, high: Open)), \
         model: Diffusion(law: ({law}), medium: Uniform((0.8, 0.0))), run: (until: 1.0))"
    );
    let sets: Vec<Set> = flags.iter().map(|flag| Set::parse(flag).unwrap()).collect();
    let file = SceneFile::parse("s.ron", &text).unwrap();
    file.experiment(preset, &sets, &Limits { memory: 1 << 30 }).unwrap_or_else(|problems| panic!("{problems}"))
}

fn law(text: &str) -> Law {
    match &unfold(text, None, &[]).runs[0].model {
        Model::Diffusion(model) => model.law,
        Model::SingleField(_) => unreachable!(),
    }
}

#[test]
fn every_legal_set_gives_the_same_law() {
    for share in [0.0, 0.25] {
        let expected = Law { k: 0.16 * 4.0 / (1.0 - share), tau: 4.0, fourier: share };
        let k = expected.k;
        let sets = [
            format!("k: {k}, tau: 4.0"),
            "c: 0.4, tau: 4.0".to_owned(),
            "hc: 2.0, tau: 4.0".to_owned(),
            "cone_angle: 30.0, tau: 4.0".to_owned(),
            format!("k: {k}, c: 0.4"),
            format!("k: {k}, hc: 2"),
            format!("k: {k}, cone_angle: 30, c: None"),
        ];
        for set in sets {
            let law = law(&format!("{set}, fourier: {share}"));
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * b;
            assert!(close(law.k, expected.k) && close(law.tau, expected.tau) && law.fourier == share, "{set}: {law:?}");
            assert!(close(law.speed().unwrap(), 0.4), "{set}");
        }
    }
    assert!(!law("k: 1.0, tau: 0").has_memory() && !law("k: 1.0, tau: 4.0, fourier: 1.0").has_memory());
}

#[test]
fn size_and_accuracy_are_two_words() {
    let level = |preset, flags: &[&str]| unfold("k: 1, tau: 1", preset, flags).runs[0].numerics.level;
    assert_eq!(level(None, &[]), Level::Standard);
    assert_eq!(level(Some("paper"), &[]), Level::Standard);
    assert_eq!(level(Some("draft"), &[]), Level::Draft);
    assert_eq!(level(Some("draft"), &["accuracy=Accurate"]), Level::Accurate);
    assert_eq!(level(Some("draft"), &["accuracy.level=Standard"]), Level::Standard);
}

#[test]
fn every_knob_overrides_its_level() {
    let flags = [
        "accuracy=Accurate",
        "accuracy.integrator=Sdirk2",
        "accuracy.advection=Cubic",
        "accuracy.splitting=Lie",
        "accuracy.dt=0.125",
        "accuracy.tolerance=1e-6",
        "accuracy.precision=f64",
    ];
    let numerics = unfold("k: 1, tau: 1", None, &flags).runs[0].numerics;
    assert_eq!((numerics.integrator, numerics.advection), (Some(Integrator::Sdirk2), Advection::Cubic));
    assert_eq!((numerics.splitting, numerics.step), (Splitting::Lie, TimeStep::Fixed(0.125)));
    assert_eq!((numerics.tolerance, numerics.precision), (1e-6, Precision::F64));
}

#[test]
fn missing_sections_are_made_and_short_forms_written_out() {
    let scene = &unfold("k: 1, tau: 1", None, &["sides.x.high.inflow=2.0"]).runs[0];
    assert_eq!(scene.sides[0], AxisSides::Walls { low: Wall::Open { inflow: 0.0 }, high: Wall::Open { inflow: 2.0 } });
    let scene = &unfold("k: 1, tau: 1", None, &["sides.y=Walls(low: Absorbing)", "output.vtk=false"]).runs[0];
    let low = Wall::Absorbing { far: 0.0, speed: None };
    assert_eq!(scene.sides[1], AxisSides::Walls { low, high: Wall::Closed });
    assert!(!scene.output.vtk);
}

#[test]
fn frames_are_counted_or_timed() {
    let times = |flags: &[&str]| {
        let schedule = unfold("k: 1, tau: 1", None, flags).runs[0].schedule;
        (0..=schedule.frames).map(|frame| schedule.frame_time(frame)).collect::<Vec<_>>()
    };
    assert_eq!(times(&[]), [0.0, 1.0]);
    assert_eq!(times(&["run.frames=4"]), [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(times(&["run.every=0.375"]), [0.0, 0.375, 0.75, 1.0]);
    assert_eq!(times(&["run.every=0.1"]).len(), 11);
    assert_eq!(times(&["run.until=0"]), [0.0, 0.0]);
}

#[test]
fn shapes_weigh_points() {
    let two = |x: f64, y: f64| -> Axes<f64> { [x, y].into_iter().collect() };
    let weight = |shape: &Shape, x: f64, y: f64| shape.weight(&[x, y], &[0.0, 0.0], &[2.0, 1.0]);
    let ball = Shape::Ball { center: two(0.5, 0.5), radius: 0.25 };
    assert_eq!((weight(&ball, 0.75, 0.5), weight(&ball, 0.76, 0.5)), (1.0, 0.0));
    let gaussian = Shape::Gaussian { center: two(0.5, 0.5), width: 0.1 };
    assert!((weight(&gaussian, 0.6, 0.5) - (-0.5f64).exp()).abs() < 1e-14);
    let wave = Shape::Cosine { modes: [2, 0].into_iter().collect() };
    assert!((weight(&wave, 1.0, 0.3) + 1.0).abs() < 1e-14);
    assert_eq!(weight(&Shape::Everywhere, 9.0, 9.0), 1.0);
}
