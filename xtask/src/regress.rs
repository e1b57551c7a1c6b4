//! `regress`: every scene at a small size against stored numbers.

use crate::cli::{RegressArgs, SceneOptions};
use crate::failure::Failure;
use crate::perform;
use crate::terminal::Terminal;
use crate::{compare, golden, open, pool, show};
use cf_scene::Options;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// A scene at a size that takes a second or two.
struct Case {
    /// Name of the golden.
    name: &'static str,
    /// The scene.
    scene: &'static str,
    /// The size and what else differs. Solves are tighter than the tolerance of the comparison, so that an iteration
    /// more or less does not show.
    sets: &'static [&'static str],
}

const CASES: &[Case] = &[
    Case {
        name: "fig03_cones",
        scene: "fig03_cones",
        sets: &[
            "grid.cells=(32, 64)",
            "run.until=6",
            "run.frames=2",
            "accuracy.level=Standard",
            "accuracy.tolerance=1e-12",
        ],
    },
    Case {
        name: "fig03_cones_f32",
        scene: "fig03_cones",
        sets: &[
            "grid.cells=(32, 64)",
            "run.until=6",
            "run.frames=2",
            "accuracy.level=Standard",
            "accuracy.precision=f32",
            "accuracy.tolerance=1e-6",
        ],
    },
    Case {
        name: "fig04_fourier_share",
        scene: "fig04_fourier_share",
        sets: &["grid.cells=(32, 64)", "run.until=2.5", "run.frames=1", "accuracy.tolerance=1e-12"],
    },
    Case {
        name: "fig06_spray",
        scene: "fig06_spray",
        sets: &[
            "grid.cells=(16, 32, 16)",
            "run.until=2.5",
            "run.frames=1",
            "accuracy.level=Standard",
            "accuracy.tolerance=1e-6",
        ],
    },
    Case {
        name: "fig05_ink",
        scene: "fig05_ink",
        sets: &[
            "grid.cells=(16, 32, 16)",
            "model.medium.jets[0].shape.low=(1.5, 0.0, 1.5)",
            "model.medium.jets[0].shape.high=(2.5, 0.3, 2.5)",
            "model.sources[0].shape.low=(1.5, 0.0, 1.5)",
            "model.sources[0].shape.high=(2.5, 0.3, 2.5)",
            "run.until=3",
            "run.every=1.5",
            "accuracy.level=Standard",
            "accuracy.precision=f64",
            "accuracy.tolerance=1e-12",
            "accuracy.eta_div=1e-10",
        ],
    },
    Case {
        name: "table2_ink",
        scene: "table2_ink",
        sets: &[
            "grid.cells=(16, 32, 16)",
            "run.until=0.5",
            "accuracy.precision=f64",
            "accuracy.tolerance=1e-12",
            "accuracy.eta_div=1e-10",
        ],
    },
    Case {
        name: "smoke_sphere",
        scene: "smoke_sphere",
        sets: &[
            "grid.cells=(20, 28, 20)",
            "run.until=3",
            "run.every=3",
            "accuracy.level=Standard",
            "accuracy.precision=f64",
            "accuracy.tolerance=1e-12",
            "accuracy.eta_div=1e-10",
        ],
    },
    Case {
        name: "ink_sinking",
        scene: "ink_sinking",
        sets: &[
            "grid.cells=(16, 32, 16)",
            "run.until=3",
            "run.every=3",
            "accuracy.level=Standard",
            "accuracy.precision=f64",
            "accuracy.tolerance=1e-12",
            "accuracy.eta_div=1e-10",
        ],
    },
    Case {
        name: "appendix_a_pitfall",
        scene: "appendix_a_pitfall",
        sets: &[
            "printed:grid.cells=(200)",
            "material:grid.cells=(200)",
            "two_field:grid.cells=(200)",
            "solver:grid.cells=(200, 1)",
            "solver:grid.extent=(8, 0.04)",
            "run.until=1",
        ],
    },
];

/// Where goldens are kept.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/golden")
}

/// Compares, or stores with `--bless`.
pub fn regress(asked: &RegressArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let wanted = |case: &&Case| asked.only.as_deref().is_none_or(|part| case.name.contains(part));
    let mut failed = Vec::new();
    let mut count = 0;
    for case in CASES.iter().filter(wanted) {
        count += 1;
        let begun = Instant::now();
        let lines = numbers(case, stop)?;
        let path = folder().join(format!("{}.txt", case.name));
        let took = show::seconds(begun.elapsed().as_secs_f64());
        if asked.bless {
            let heading = format!("{} with --preset draft --set {}", case.scene, case.sets.join(" --set "));
            cf_output::write_text(&path, &compare::text(&heading, &lines))?;
            say!("stored   {:<24} {:>4} numbers, {took}", case.name, lines.len());
            continue;
        }
        let stored = std::fs::read_to_string(&path).map_err(|error| {
            Failure::io(format!("tests/golden/{}.txt: {error}; store it with `cargo xtask regress --bless`", case.name))
        })?;
        match compare::differences(&stored, &lines) {
            None => say!("ok       {:<24} {:>4} numbers, {took}", case.name, lines.len()),
            Some(table) => {
                say!("DIFFERS  {:<24} {took}\n{table}", case.name);
                failed.push(case.name);
            }
        }
    }
    match (count, failed.as_slice()) {
        (0, _) => Err(Failure::usage("no scene has that in its name; see `cargo xtask list`")),
        (_, []) => Ok(()),
        (_, failed) => Err(Failure::failed(format!(
            "{} of {count} scenes differ from their goldens: {}; if that is meant, store them with `cargo xtask regress --bless`",
            failed.len(),
            failed.join(", ")
        ))),
    }
}

fn numbers(case: &Case, stop: &AtomicBool) -> Result<Vec<compare::Line>, Failure> {
    let fixed = ["output.vtk=true", "output.pictures=Off"];
    let sets = case.sets.iter().chain(&fixed).map(ToString::to_string).collect();
    let scene = SceneOptions { preset: "draft".into(), sets };
    let opened = open::figure(case.scene, &scene)?;
    let folder = Scratch::new(case.name)?;
    let mut lines = Vec::new();
    for one in &opened {
        let options = Options { threads: pool::threads(None), ..Options::new(one.name.clone(), &folder.0) };
        let summary = perform::perform(&one.experiment, &options, &mut Terminal::new(stop, true))?;
        lines.extend(golden::lines(&summary, &folder.0)?);
    }
    Ok(lines)
}

/// A folder that goes away again.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Result<Self, Failure> {
        let path = std::env::temp_dir().join(format!("cf-regress-{}-{name}", std::process::id()));
        let made = std::fs::create_dir_all(&path);
        made.map_err(|error| Failure::io(format!("{}: {error}", path.display())))?;
        Ok(Scratch(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_has_a_case() {
        for scene in cf_scene::catalog::SCENES {
            assert!(CASES.iter().any(|case| case.scene == scene.name), "{}", scene.name);
        }
    }
}
