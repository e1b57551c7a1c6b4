//! From an experiment to its results: all runs in turn, the sheet that compares them, the claims, the summary.

use crate::checkpoint;
use crate::cloud;
use crate::experiment::Experiment;
use crate::measure;
use crate::pictures::{self, Last};
use crate::progress::Watch;
use crate::run::{Outcome, Runner};
use crate::run_error::RunError;
use crate::scene::Scene;
use crate::spec::{Level, Pictures};
use crate::summary::Summary;
use crate::target;
use cf_output::{OutputError, write_text};
use std::io;
use std::path::PathBuf;
use std::time::Instant;

/// How to perform an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The scene file's name without its extension.
    pub name: String,
    /// `--set` flags as given, for the summary.
    pub overrides: Vec<String>,
    /// The folder for files.
    pub out: PathBuf,
    /// Worker threads of the pool that this is called in, for the summary.
    pub threads: usize,
    /// Go on from checkpoints in `out`; runs without one begin at their start.
    pub resume: bool,
    /// Write files; without, nothing touches the file system.
    pub write: bool,
    /// Sample the error of a few steps for the summary, at two steps more a sample.
    pub estimate: bool,
}

impl Options {
    /// Files of the scene `name` in `out`, from the start.
    pub fn new(name: impl Into<String>, out: impl Into<PathBuf>) -> Self {
        Options {
            name: name.into(),
            overrides: Vec::new(),
            out: out.into(),
            threads: rayon::current_num_threads(),
            resume: false,
            write: true,
            estimate: true,
        }
    }
}

/// Performs all runs of an experiment and checks its claims. A claim that does not hold is no error: see
/// [`Summary::failures`].
///
/// # Errors
/// [`RunError`]; files written so far stay, and so do the checkpoints of finished and of stopped runs.
pub fn perform(experiment: &Experiment, options: &Options, watch: &mut dyn Watch) -> Result<Summary, RunError> {
    let begun = Instant::now();
    let mut outcomes: Vec<(Scene, Outcome)> = Vec::new();
    let runs = experiment.runs.len();
    for (index, scene) in experiment.runs.iter().enumerate() {
        let needs = measure::needs(&scene.run, &experiment.claims);
        let runner = Runner { scene, index, runs, needs, options };
        outcomes.push(match scene.numerics.level {
            Level::Target(error) => target::run(&runner, error, watch)?,
            _ => (scene.clone(), runner.run(watch)?),
        });
    }
    let evidence =
        outcomes.iter().map(|(scene, outcome)| (scene, &outcome.summary, &outcome.evidence)).collect::<Vec<_>>();
    let claims = experiment.claims.iter().map(|claim| measure::check(claim, &evidence)).collect();
    let (mut summaries, mut lasts) = (Vec::new(), Vec::new());
    for (scene, outcome) in &mut outcomes {
        let (summary, values) = (std::mem::take(&mut outcome.summary), std::mem::take(&mut outcome.last));
        lasts.push(Last { scene, time: summary.time, values, frames: std::mem::take(&mut outcome.frames) });
        summaries.push(summary);
    }
    let mut summary = Summary {
        scene: options.name.clone(),
        title: experiment.about.title.clone(),
        figure: experiment.about.figure.clone(),
        version: env!("CARGO_PKG_VERSION").into(),
        preset: experiment.preset.clone(),
        overrides: options.overrides.clone(),
        runs: summaries,
        claims,
        seconds: 0.0,
        files: Vec::new(),
    };
    if options.write {
        let run = experiment.runs.first().map(|scene| scene.run.clone()).unwrap_or_default();
        leave(experiment, options, &lasts, &mut summary, begun).map_err(|source| RunError::Output { run, source })?;
    }
    summary.seconds = begun.elapsed().as_secs_f64();
    Ok(summary)
}

/// Writes what concerns all runs.
fn leave(
    experiment: &Experiment,
    options: &Options,
    lasts: &[Last<'_>],
    summary: &mut Summary,
    begun: Instant,
) -> Result<(), OutputError> {
    let out = &options.out;
    let pictures = experiment.runs.iter().any(|scene| scene.output.pictures != Pictures::Off);
    if pictures && let Some(sheet) = pictures::sheet(&experiment.about.title, lasts)? {
        let name = format!("{}.png", options.name);
        sheet.write_png(&out.join(&name))?;
        summary.files.push(name);
    }
    let clouds = cloud::draw(&options.name, out, lasts)?;
    for (run, files) in summary.runs.iter_mut().zip(clouds.runs) {
        run.files.extend(files);
    }
    // What people look at comes first.
    summary.files.splice(0..0, clouds.all);
    summary.files.push("summary.json".into());
    summary.seconds = begun.elapsed().as_secs_f64();
    let path = out.join("summary.json");
    let text = serde_json::to_string_pretty(summary).map_err(|error| OutputError::Io {
        path: path.clone(),
        action: "write",
        source: io::Error::other(error),
    })?;
    write_text(&path, &(text + "\n"))?;
    for scene in &experiment.runs {
        let path = checkpoint::path(out, &scene.run);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                return Err(OutputError::Io { path, action: "remove", source });
            }
            _ => {}
        }
    }
    Ok(())
}
