//! Runs a shipped scene and prints its claims: `cargo run --release -p cf-scene --example run -- fig03_cones standard OUT`.

use cf_scene::progress::{Progress, Watch, Wish};
use cf_scene::{Limits, Options, SceneFile, Set, catalog, perform};
use std::error::Error;

struct Lines;

impl Watch for Lines {
    fn step(&mut self, _: Progress<'_>) -> Wish {
        Wish::Continue
    }
    fn note(&mut self, line: &str) {
        println!("{line}");
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let scene = args.next().ok_or("name a scene")?;
    let preset = args.next();
    let out = args.next().unwrap_or_else(|| format!("out/{scene}"));
    let scene = catalog::find(&scene)?[0];
    let sets = args.map(|flag| Set::parse(&flag)).collect::<Result<Vec<_>, _>>()?;
    let experiment = SceneFile::parse(&scene.file(), scene.text)?.experiment(
        preset.as_deref(),
        &sets,
        &Limits::of_this_machine(),
    )?;
    let summary = perform(&experiment, &Options::new(scene.name, out), &mut Lines)?;
    for run in &summary.runs {
        println!(
            "{:18} {:8} dt {:.5} drift {:+.1e} {:?} {:?}",
            run.name, run.integrator, run.dt[1], run.mass.drift, run.seconds.phases, run.warnings
        );
    }
    for claim in &summary.claims {
        let mark = if claim.pass { "ok  " } else { "FAIL" };
        println!("{mark} [{}] {}: expected {}; measured {}", claim.kind, claim.name, claim.expected, claim.measured);
    }
    println!("{:.1} s", summary.seconds);
    Ok(())
}
