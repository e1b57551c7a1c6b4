//! Speed against accuracy in scenes: every knob turns something, targets are reached, steps are adapted, errors are told.

mod adaptive;
mod knobs;
mod target;

use cf_scene::progress::Silent;
use cf_scene::summary::{RunSummary, Summary};
use cf_scene::{Experiment, Limits, Options, Problems, SceneFile, Set, perform};

/// What `accuracy` is about here: the wake of a smooth source, as in figure 3.
const WAKE: &str = r#"(
    about: (title: "Wake"),
    grid: (cells: (32, 64), extent: (2.0, 4.0)),
    sides: (x: Walls(low: Absorbing(speed: 0.25), high: Absorbing(speed: 0.25)),
            y: Walls(low: Absorbing(speed: 0.25), high: Absorbing(speed: 0.25))),
    model: Diffusion(
        law: (k: 0.25, tau: 4.0, fourier: 0.1),
        medium: Uniform((0.0, 0.5)),
        sources: [(shape: Gaussian(center: (1.0, 1.0), width: 0.2), rate: 50.0)],
    ),
    accuracy: (level: Standard, precision: f64),
    run: (until: 2.0, frames: 2),
    output: (pictures: Off, table: false),
)"#;

fn try_unfold(text: &str, sets: &[&str]) -> Result<Experiment, Problems> {
    let sets: Result<Vec<Set>, _> = sets.iter().map(|flag| Set::parse(flag)).collect();
    SceneFile::parse("wake.ron", text)?.experiment(None, &sets?, &Limits { memory: 1 << 30 })
}

fn unfold(text: &str, sets: &[&str]) -> Experiment {
    try_unfold(text, sets).unwrap_or_else(|problems| panic!("{sets:?}: {problems}"))
}

/// The summary of a run, and phi at its end.
struct Ran {
    summary: Summary,
    phi: Vec<f64>,
}

impl Ran {
    fn of(text: &str, sets: &[&str]) -> Ran {
        let folder = tempfile::tempdir().expect("a folder");
        let experiment = unfold(text, sets);
        let options = Options::new("wake", folder.path());
        let summary = perform(&experiment, &options, &mut Silent).unwrap_or_else(|error| panic!("{sets:?}: {error}"));
        let run = &summary.runs[0];
        let last = run.files.iter().rfind(|file| file.ends_with(".vti"));
        let phi = last.map_or_else(Vec::new, |file| {
            let image = cf_output::read_image(&folder.path().join(file)).expect("a file of ours");
            image.arrays[0].values.clone()
        });
        Ran { summary, phi }
    }

    fn run(&self) -> &RunSummary {
        &self.summary.runs[0]
    }

    fn cells(&self) -> f64 {
        self.run().cells.iter().map(|n| *n as f64).product()
    }

    /// Relative to a reference on the same cells or on twice, four times .. as many along each axis, in the mean square.
    fn error(&self, reference: &Ran) -> f64 {
        let (nx, ny) = (self.run().cells[0], self.run().cells[1]);
        let by = reference.run().cells[0] / nx;
        let mut means = vec![0.0; nx * ny];
        for (index, value) in reference.phi.iter().enumerate() {
            let (x, y) = (index % (nx * by), index / (nx * by));
            means[x / by + nx * (y / by)] += value / (by * by) as f64;
        }
        let off: f64 = means.iter().zip(&self.phi).map(|(a, b)| (a - b) * (a - b)).sum();
        (off / means.iter().map(|v| v * v).sum::<f64>()).sqrt()
    }
}
