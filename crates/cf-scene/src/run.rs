//! The run loop: from a scene's start to its end, frame by frame, watched.

use crate::build::build;
use crate::checkpoint;
use crate::frames::{self, Frames};
use crate::ledger::Ledger;
use crate::model::Model;
use crate::pace::{Leg, MOST_STEPS, Pace};
use crate::perform::Options;
use crate::progress::{Progress, Watch, Wish};
use crate::run_error::RunError;
use crate::scene::Scene;
use crate::stopwatch::Stopwatch;
use crate::summary::RunSummary;
use crate::view::View;
use cf_output::OutputError;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Steps between looks for numbers that are none.
const LOOK: u64 = 8;
/// Between checkpoints, which are written at frames.
const CHECKPOINT: Duration = Duration::from_secs(60);

/// What claims need of a run besides its summary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Needs {
    /// `phi` at the end.
    pub phi: bool,
    /// The slow flux at the end.
    pub flux: bool,
    /// `phi` at half time.
    pub half: bool,
}

/// What a run leaves in memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Evidence {
    pub time: f64,
    pub phi: Option<Vec<f64>>,
    pub flux: Option<Vec<Vec<f64>>>,
    pub half: Option<Vec<f64>>,
}

/// Everything that came out of a run.
pub(crate) struct Outcome {
    pub summary: RunSummary,
    pub evidence: Evidence,
    /// What the sheet shows of it.
    pub last: Vec<f64>,
}

/// One run of an experiment.
pub(crate) struct Runner<'a> {
    pub scene: &'a Scene,
    pub index: usize,
    pub runs: usize,
    pub needs: Needs,
    pub options: &'a Options,
}

impl Runner<'_> {
    /// Runs to the end.
    pub fn run(&self, watch: &mut dyn Watch) -> Result<Outcome, RunError> {
        let (scene, begun) = (self.scene, Instant::now());
        let pace = Pace::of(scene);
        let legs = self.legs(&pace)?;
        let mut model = build(scene, &pace).map_err(|source| RunError::Build { run: scene.run.clone(), source })?;
        let mut ledger = Ledger { start: model.totals().mass, ..Ledger::default() };
        if let Some(path) = self.checkpoint().filter(|_| self.options.resume) {
            let read = checkpoint::read(&path, scene, &mut *model);
            if let Some(old) = read.map_err(|source| RunError::Checkpoint { run: scene.run.clone(), source })? {
                watch.note(&format!("run `{}` goes on after step {}, t = {} s", scene.run, old.step, old.time));
                ledger = old;
            } else {
                watch.note(&format!("run `{}` has no checkpoint to go on from: it starts anew", scene.run));
            }
        }
        let mut running = Running {
            runner: self,
            stopwatch: Stopwatch::from_phases(std::mem::take(&mut ledger.phases)),
            before: ledger.seconds,
            ledger,
            model,
            frames: None,
            begun,
            saved: begun,
        };
        if self.options.write {
            let frames = Frames::begin(scene, &self.options.out, &running.ledger).map_err(|e| self.output(e))?;
            running.frames = Some(frames);
        }
        running.through(&legs, watch)?;
        running.finish(&pace, watch)
    }

    fn legs(&self, pace: &Pace) -> Result<Vec<Leg>, RunError> {
        let schedule = &self.scene.schedule;
        let legs = pace.legs(self.scene, self.needs.half.then_some(0.5 * schedule.until));
        let steps = pace.steps_of(schedule, &legs);
        if steps > MOST_STEPS {
            return Err(RunError::TooManySteps { run: self.scene.run.clone(), steps, dt: pace.dt });
        }
        Ok(legs)
    }

    fn checkpoint(&self) -> Option<PathBuf> {
        self.options.write.then(|| checkpoint::path(&self.options.out, &self.scene.run))
    }

    fn output(&self, source: OutputError) -> RunError {
        RunError::Output { run: self.scene.run.clone(), source }
    }
}

/// A run on its way.
struct Running<'a> {
    runner: &'a Runner<'a>,
    model: Box<dyn Model>,
    ledger: Ledger,
    stopwatch: Stopwatch,
    frames: Option<Frames<'a>>,
    /// Seconds before this program took it up.
    before: f64,
    begun: Instant,
    saved: Instant,
}

impl Running<'_> {
    fn through(&mut self, legs: &[Leg], watch: &mut dyn Watch) -> Result<(), RunError> {
        let most = self.runner.scene.schedule.steps.unwrap_or(u64::MAX);
        if self.ledger.rows.is_empty() {
            self.frame(0)?;
        }
        let mut before = 0u64;
        for leg in legs {
            let first = self.ledger.step.saturating_sub(before);
            before = before.saturating_add(leg.steps);
            for step in first..leg.steps {
                if self.ledger.step >= most {
                    return self.frame_if_new();
                }
                self.step(leg, step)?;
                if step + 1 == leg.steps {
                    self.arrive(leg)?;
                }
                self.report(leg, watch)?;
            }
        }
        self.frame_if_new()
    }

    fn step(&mut self, leg: &Leg, step: u64) -> Result<(), RunError> {
        let (from, dt) = (leg.time(step), leg.dt());
        let run = || self.runner.scene.run.clone();
        let made = self.model.advance(from, dt, &mut self.stopwatch);
        let report =
            made.map_err(|source| RunError::Step { run: run(), step: self.ledger.step + 1, time: from, source })?;
        self.ledger.count(&report, dt);
        self.ledger.time = leg.time(step + 1);
        let look = self.ledger.step.is_multiple_of(LOOK) || step + 1 == leg.steps;
        if look
            && !self.model.totals().magnitude.is_finite()
            && let Some((field, cell)) = self.model.not_finite()
        {
            let (step, time) = (self.ledger.step, self.ledger.time);
            return Err(RunError::NotFinite { run: run(), step, time, field, cell });
        }
        Ok(())
    }

    /// At the end of a leg.
    fn arrive(&mut self, leg: &Leg) -> Result<(), RunError> {
        let half = 0.5 * self.runner.scene.schedule.until;
        if self.runner.needs.half && (leg.end - half).abs() <= 1e-9 * half {
            self.ledger.half = Some(self.model.phi());
        }
        let Some(frame) = leg.frame else { return Ok(()) };
        self.frame(frame)?;
        if self.saved.elapsed() > CHECKPOINT {
            self.save()?;
        }
        Ok(())
    }

    fn frame_if_new(&mut self) -> Result<(), RunError> {
        match self.ledger.rows.last() {
            Some(row) if row.step == self.ledger.step => Ok(()),
            row => self.frame(row.map_or(0, |row| row.frame + 1)),
        }
    }

    fn frame(&mut self, frame: u32) -> Result<(), RunError> {
        let begun = Instant::now();
        self.ledger.enter(frame, self.model.totals());
        let written = self.frames.as_mut().map(|frames| frames.write(frame, &*self.model, &mut self.ledger));
        self.stopwatch.add("output", begun.elapsed().as_secs_f64());
        written.unwrap_or(Ok(())).map_err(|error| self.runner.output(error))
    }

    fn report(&mut self, leg: &Leg, watch: &mut dyn Watch) -> Result<(), RunError> {
        let (scene, ledger) = (self.runner.scene, &self.ledger);
        let wish = watch.step(Progress {
            run: &scene.run,
            index: self.runner.index,
            runs: self.runner.runs,
            step: ledger.step,
            time: ledger.time,
            until: scene.schedule.until,
            dt: leg.dt(),
        });
        if wish == Wish::Continue {
            return Ok(());
        }
        self.save()?;
        let (step, time) = (self.ledger.step, self.ledger.time);
        Err(RunError::Stopped { run: scene.run.clone(), step, time, checkpoint: self.runner.checkpoint() })
    }

    fn save(&mut self) -> Result<(), RunError> {
        self.ledger.phases = self.stopwatch.phases().clone();
        self.ledger.seconds = self.before + self.begun.elapsed().as_secs_f64();
        self.saved = Instant::now();
        let Some(path) = self.runner.checkpoint() else { return Ok(()) };
        checkpoint::write(&path, self.runner.scene, &*self.model, &self.ledger).map_err(|e| self.runner.output(e))
    }

    fn finish(mut self, pace: &Pace, watch: &mut dyn Watch) -> Result<Outcome, RunError> {
        let (runner, begun) = (self.runner, Instant::now());
        if let Some(frames) = self.frames.take().filter(|_| !self.ledger.finished) {
            frames.finish(&mut self.ledger).map_err(|error| runner.output(error))?;
        }
        self.ledger.finished = true;
        self.stopwatch.add("output", begun.elapsed().as_secs_f64());
        if runner.runs > 1 {
            // The runs before a stop are not run again.
            self.save()?;
        }
        self.ledger.seconds = self.before + self.begun.elapsed().as_secs_f64();
        let Running { model, ledger, stopwatch, .. } = self;
        let summary = crate::account::account(runner, pace, &*model, &ledger, &stopwatch);
        watch.note(&format!("run `{}`: {} steps in {:.1} s", summary.name, summary.steps, summary.seconds.total));
        let last = frames::last(View::of(runner.scene).as_ref(), &*model);
        let Needs { phi, flux, .. } = runner.needs;
        let evidence = Evidence {
            time: ledger.time,
            phi: phi.then(|| model.phi()),
            flux: flux.then(|| model.flux()),
            half: ledger.half,
        };
        Ok(Outcome { summary, evidence, last })
    }
}
