//! How long a run will take, from a short measurement of its own steps.
//!
//! What a step costs depends on the machine, on what else runs on it, and on how many iterations its solves take, so it is
//! measured when asked for: the run itself is begun, on its own grid or on one halved until it is small enough to be quick
//! and still larger than the caches, for two steps and for more, and a frame, with files in a folder that goes away. The time of the
//! whole is then
//!
//! ```text
//! seconds = (steps + samples of the error) x cells x seconds per cell and step + frames x cells x seconds per cell and frame
//! ```
//!
//! The step is shortened with the grid, so that waves and medium move as many cells as in the run.

use crate::failure::Failure;
use crate::{pool, show};
use cf_scene::progress::Silent;
use cf_scene::spec::{About, Level};
use cf_scene::summary::RunSummary;
use cf_scene::{Experiment, Options, Pace, Scene, TimeStep, perform};

/// Cells of a measurement, at most: more than the caches of a core hold.
const MOST_CELLS: usize = 1 << 19;
/// What the steps of a measurement take \[s\].
const ENOUGH: f64 = 0.08;
/// The first steps, which are measured apart.
const FIRST: u64 = 2;
/// Steps of a measurement, at most.
const MOST_STEPS: u64 = 400;
/// Halves of steps that a run makes to estimate its error.
const SAMPLES: f64 = 8.0;

/// What a run costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    /// Seconds per cell and step.
    step: f64,
    /// Seconds per cell and frame, files and pictures.
    frame: f64,
    /// Seconds that do not depend on anything: making solver and fields, the report.
    begin: f64,
}

/// Measures the rate of a run.
pub fn rate(scene: &Scene) -> Result<Rate, Failure> {
    let threads = pool::threads(None);
    pool::within(threads, || {
        let first = begin(scene, FIRST, threads)?;
        let per_step = first.seconds.per_step.max(1e-7);
        let steps = FIRST + ((ENOUGH / per_step) as u64).clamp(FIRST, MOST_STEPS);
        let run = begin(scene, steps, threads)?;
        let count = run.cells.iter().map(|&n| n as f64).product::<f64>();
        let phase = |name: &str| run.seconds.phases.get(name).copied().unwrap_or(0.0);
        // The start and the end are a frame each.
        let output = phase("output");
        // The first steps make solvers, touch new memory, and look for a pressure without a guess: they are no measure of the others.
        let stepping = |run: &RunSummary| run.seconds.per_step * run.steps as f64;
        let later = (stepping(&run) - stepping(&first)) / run.steps.saturating_sub(first.steps).max(1) as f64;
        let step = if later > 0.0 { later } else { run.seconds.per_step };
        let rest = run.seconds.total - output - step * run.steps as f64;
        Ok(Rate { step: step / count, frame: output / 2.0 / count, begin: rest.max(0.0) })
    })?
}

/// The first steps of a run, on a grid that is quick.
fn begin(scene: &Scene, steps: u64, threads: usize) -> Result<RunSummary, Failure> {
    let mut small = scene.clone();
    let mut dt = Pace::of(scene).likely;
    while small.grid.cells.iter().product::<usize>() > MOST_CELLS && small.grid.cells.iter().all(|n| n % 2 == 0) {
        small.grid.cells = small.grid.cells.iter().map(|n| n / 2).collect();
        (small.grid.spacing, dt) = (2.0 * small.grid.spacing, 2.0 * dt);
    }
    if matches!(small.numerics.level, Level::Target(_)) {
        small.numerics.level = Level::Standard;
    }
    // Frames cut steps to equal parts of the time between them.
    let interval = scene.schedule.interval;
    let cut = if dt > 0.0 && dt < interval { interval / (interval / dt).ceil() } else { dt };
    if Pace::of(scene).integrator.is_some() && !matches!(small.numerics.step, TimeStep::Adaptive(_)) {
        small.numerics.integrator = Pace::of(scene).integrator;
        small.numerics.step = TimeStep::Fixed(cut);
    }
    small.schedule.frames = 1;
    small.schedule.interval = small.schedule.until;
    small.schedule.steps = Some(steps);
    let folder = std::env::temp_dir().join(format!("cf-check-{}", std::process::id()));
    let options = Options { threads, estimate: false, ..Options::new("check", &folder) };
    let experiment = Experiment { about: About::default(), preset: None, runs: vec![small], claims: Vec::new() };
    let outcome = perform(&experiment, &options, &mut Silent);
    let _ = std::fs::remove_dir_all(&folder);
    let mut summary = outcome.map_err(|error| Failure::usage(format!("the first steps fail: {error}")))?;
    summary.runs.pop().ok_or_else(|| Failure::usage("the measurement made no run"))
}

/// The predicted seconds of a run.
pub fn seconds(scene: &Scene, rate: &Rate) -> f64 {
    let pace = Pace::of(scene);
    let count = scene.grid.cells.iter().map(|&n| n as f64).product::<f64>();
    let frames = 1.0 + f64::from(scene.schedule.frames);
    let (samples, steps) = (if pace.integrator.is_some() { SAMPLES } else { 0.0 }, pace.steps(scene));
    rate.begin + count * ((steps + samples.min(2.0 * steps)) * rate.step + frames * rate.frame)
}

/// What is said of a prediction that cannot be one.
pub fn caveat(scene: &Scene) -> Option<&'static str> {
    match (scene.numerics.level, scene.numerics.step) {
        (Level::Target(_), _) => {
            Some("Target: at most, on all cells of the scene, and about a third more for the way there")
        }
        (_, TimeStep::Adaptive(_)) => Some("adaptive steps: at least, with the longest step throughout"),
        _ => None,
    }
}

/// One size and level.
pub struct Row {
    /// What both are.
    pub name: [String; 2],
    /// Cells of the first run.
    pub cells: Vec<usize>,
    /// Steps of all runs.
    pub steps: f64,
    /// Bytes of the largest run.
    pub memory: u64,
    /// Seconds of all runs.
    pub seconds: f64,
}

impl Row {
    /// Measures and predicts all runs of an experiment.
    pub fn of(name: [&str; 2], experiment: &Experiment) -> Result<Row, Failure> {
        let mut seconds_of_all = 0.0;
        for scene in &experiment.runs {
            seconds_of_all += seconds(scene, &rate(scene)?);
        }
        Ok(Row {
            name: name.map(str::to_owned),
            cells: experiment.runs.first().map(|run| run.grid.cells.to_vec()).unwrap_or_default(),
            steps: experiment.runs.iter().map(|run| Pace::of(run).steps(run)).sum(),
            memory: experiment.runs.iter().map(|run| run.memory().total()).max().unwrap_or(0),
            seconds: seconds_of_all,
        })
    }

    /// Its entries.
    pub fn entries(&self) -> Vec<String> {
        let [size, level] = self.name.clone();
        let (steps, memory) = (format!("{:.0}", self.steps), show::bytes(self.memory));
        vec![size, level, show::cells(&self.cells), steps, memory, show::seconds(self.seconds)]
    }
}
