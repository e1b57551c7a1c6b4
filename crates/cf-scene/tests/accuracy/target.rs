//! `accuracy: Target(E)`: the error is E or less, and costs the more the smaller E.

use super::{Ran, WAKE, unfold};
use cf_scene::progress::Silent;
use cf_scene::{Options, perform};

/// Cells times steps of the run that counts.
fn cost(ran: &Ran) -> f64 {
    ran.cells() * ran.run().steps as f64
}

#[test]
fn targets_are_reached_and_cost_the_more_the_smaller_they_are() {
    // Cattaneo waves, Jeffreys' law, Fourier's, in a flow and in a still medium.
    for (sets, goals) in [
        (&["model.law.fourier=0.0"][..], &["1e-1", "1e-2", "1e-3"][..]),
        (&["model.law.fourier=0.1"], &["1e-1", "1e-2", "1e-3"]),
        (&["model.law=(k: 0.05, tau: 0.0)", "model.medium=Still"], &["1e-1", "1e-2", "1e-3"]),
    ] {
        let sized: Vec<&str> = sets.iter().copied().chain(["grid.cells=(256, 512)", "run.until=1.0"]).collect();
        let fine: Vec<&str> = sized.iter().copied().chain(["accuracy.level=Accurate"]).collect();
        let reference = Ran::of(WAKE, &fine);
        let mut costs = Vec::new();
        for goal in goals {
            let flag = format!("accuracy=Target({goal})");
            let ran = Ran::of(WAKE, &sized.iter().copied().chain([flag.as_str()]).collect::<Vec<_>>());
            let (wanted, error) = (goal.parse::<f64>().expect("a number"), ran.error(&reference));
            let target = ran.run().target.as_ref().expect("what came of the target");
            println!("{sets:?} {goal}: {:?}, error {error:.2e}, {}", ran.run().cells, target.words);
            assert!(error <= 2.0 * wanted, "{sets:?} {goal}: {error:e}");
            assert_eq!(target.reached, target.achieved <= wanted);
            if ran.cells() < 256.0 * 512.0 {
                assert!(target.reached, "{}", target.words);
            }
            costs.push(cost(&ran));
        }
        assert!(costs.is_sorted() && costs.first() < costs.last(), "{sets:?}: {costs:?}");
    }
}

#[test]
fn what_is_not_reached_is_said() {
    let ran = Ran::of(WAKE, &["accuracy=Target(1e-6)", "run.until=0.5"]);
    let target = ran.run().target.as_ref().expect("what came of the target");
    assert!(!target.reached && target.words.contains("is not reached") && target.words.contains("times as many cells"));
    assert!(ran.run().warnings.iter().any(|words| words == &target.words), "{:?}", ran.run().warnings);
    assert_eq!(ran.run().cells, [32, 64]);
    assert_eq!(target.rungs.last().map(|rung| rung.cells.clone()), Some(vec![32, 64]));
}

#[test]
fn the_way_to_a_target_does_not_depend_on_threads() {
    let experiment = unfold(WAKE, &["accuracy=Target(3e-2)", "run.until=1.0"]);
    let options = Options { write: false, ..Options::new("wake", "nowhere") };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let run = pool.install(|| perform(&experiment, &options, &mut Silent)).expect("a run").runs.remove(0);
        format!("{:?} {:?} {:?} {:?}", run.cells, run.ranges, run.mass, run.target)
    };
    let one = on(1);
    assert_eq!(on(2), one);
    assert_eq!(on(5), one);
}

/// The error of cell means of what a target chose, against the scene's own grid.
fn error_of(text: &str, level: &str) -> (Ran, f64) {
    let chosen = Ran::of(text, &[&format!("accuracy.level=Target({level})")]);
    let error = chosen.error(&Ran::of(text, &["accuracy.level=Accurate"]));
    let words = &chosen.run().target.as_ref().expect("what came of the target").words;
    println!("{:?}, error {error:.1e}: {words}", chosen.run().cells);
    (chosen, error)
}

fn still(law: &str, more: &str) -> String {
    format!(
        "(grid: (cells: (128, 128), extent: (1.0, 1.0)), model: Diffusion(law: {law}, {more}), \
         accuracy: (level: Standard, precision: f64), run: (until: 0.5, frames: 1), output: (pictures: Off, table: false))"
    )
}

/// On 8 and 16 cells waves of 1/16 become constants, on 8 and 16 cells a wall of a fiftieth is not there.
#[test]
fn a_grid_that_does_not_show_the_scene_is_no_answer() {
    let waves = "initial: [(shape: Everywhere, value: 1.0), (shape: Cosine(modes: (32, 0)), value: 1.0)]";
    let wall = "initial: [(shape: Gaussian(center: (0.25, 0.5), width: 0.08), value: 1.0)], \
        obstacles: [Box(low: (0.49, 0.0), high: (0.51, 1.0))]";
    for (law, more) in [("(k: 1e-4, tau: 1.0, fourier: 1.0)", waves), ("(k: 0.04, tau: 1.0, fourier: 1.0)", wall)] {
        let (ran, error) = error_of(&still(law, more), "1e-2");
        let target = ran.run().target.as_ref().expect("what came of the target");
        assert!(error <= 2.0 * target.achieved.max(1e-3) && (error <= 2e-2 || !target.reached), "{more}: {error:e}");
    }
}

/// A disc sends out a jump, which centred steps follow worse than those along the characteristics.
#[test]
fn a_front_is_followed_along_its_characteristics() {
    let disc = "initial: [(shape: Ball(center: (0.5, 0.5), radius: 0.17), value: 1.0)]";
    let ran = Ran::of(&still("(k: 0.17, tau: 1.0)", disc), &["accuracy.level=Target(5e-2)"]);
    assert_eq!(ran.run().integrator, "Characteristic", "{:?}", ran.run().target);
}
