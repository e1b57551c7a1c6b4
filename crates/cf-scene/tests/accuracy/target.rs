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
