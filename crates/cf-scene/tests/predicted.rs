//! How many steps a fluid is thought to take before it has moved, against how many it takes.

use cf_scene::progress::Silent;
use cf_scene::{Experiment, Limits, Options, Pace, SceneFile, Set, catalog, perform};

fn small(name: &str, cells: &str) -> Experiment {
    let scene = catalog::SCENES.iter().find(|scene| scene.name == name).unwrap();
    let sets: Vec<Set> =
        [&format!("grid.cells={cells}"), "output.volume=None"].iter().map(|flag| Set::parse(flag).unwrap()).collect();
    let file = SceneFile::parse(&scene.file(), scene.text).unwrap();
    file.experiment(Some("draft"), &sets, &Limits { memory: 1 << 30 }).unwrap()
}

fn plane(walls: &str, medium: &str, rest: &str) -> Experiment {
    let text = format!(
        "(grid: (cells: (32, 64), extent: (1.0, 2.0)), sides: ({walls}), model: Diffusion(law: (k: 0.0, tau: 0.0), \
         medium: Solved({medium}), {rest}), accuracy: (flow: Draft, eta_div: 1e-2), run: (until: 3.0, frames: 3))"
    );
    let file = SceneFile::parse("plane.ron", &text).unwrap();
    file.experiment(None, &[], &Limits { memory: 1 << 30 }).unwrap()
}

/// Predicted and taken steps of the first run.
fn steps(mut experiment: Experiment) -> (f64, f64) {
    experiment.runs.truncate(1);
    experiment.claims.clear();
    let scene = &experiment.runs[0];
    let predicted = Pace::of(scene).steps(scene);
    let options = Options { write: false, estimate: false, ..Options::new("predicted", "nowhere") };
    (predicted, perform(&experiment, &options, &mut Silent).unwrap().runs[0].steps as f64)
}

#[test]
fn flows_at_rest_take_about_the_steps_that_are_predicted() {
    let open = "x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open)";
    let warm = "buoyancy: (strength: 4.0)";
    let cases = [
        ("smoke_sphere", small("smoke_sphere", "(20, 28, 20)")),
        ("ink_sinking", small("ink_sinking", "(16, 32, 16)")),
        ("fig05_ink", small("fig05_ink", "(16, 32, 16)")),
        ("falls freely", plane("x: Periodic, y: Periodic", "force: (0.0, -2.0)", "")),
        ("falls out", plane(open, "force: (0.0, -2.0)", "")),
        ("stands", plane("", "force: (0.0, -2.0)", "")),
        ("emitted", plane(open, warm, "sources: [(shape: Ball(center: (0.5, 0.3), radius: 0.1), rate: 10.0)]")),
        ("held", plane(open, warm, "sources: [(shape: Ball(center: (0.5, 0.3), radius: 0.1), value: 1.0)]")),
        ("a drop", plane("", warm, "initial: [(shape: Ball(center: (0.5, 0.5), radius: 0.2), value: 1.0)]")),
    ];
    for (name, experiment) in cases {
        let (predicted, taken) = steps(experiment);
        println!("{name}: {predicted} predicted, {taken} taken");
        assert!(predicted < 2.0 * taken && taken < 2.0 * predicted, "{name}: {predicted} predicted, {taken} taken");
    }
}
