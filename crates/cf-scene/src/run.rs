//! The run loop: from a scene's start to its end, frame by frame, watched.

use crate::backup::Backup;
use crate::build::build;
use crate::checkpoint;
use crate::frames::{self, Frames};
use crate::kept::Kept;
use crate::ledger::Ledger;
use crate::model::{Model, StepFailure};
use crate::pace::{Leg, MOST_STEPS, Pace};
use crate::perform::Options;
use crate::progress::{Progress, Watch, Wish};
use crate::run_error::RunError;
use crate::sample;
use crate::scene::{Scene, TimeStep};
use crate::stopwatch::Stopwatch;
use crate::summary::RunSummary;
use crate::view::View;
use cf_diffusion::{Controller, StepError};
use cf_output::OutputError;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Steps between looks for numbers that are none.
const LOOK: u64 = 8;
/// The first step of an adaptive run, as a part of the longest.
const FIRST: f64 = 1.0 / 64.0;
/// A step of a solved fluid that is shorter, as a part of the longest, is that of an unstable one.
const SHORTEST: f64 = 1e-6;
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
    /// At every frame, how far what is above this share of the largest |phi| has come.
    pub front: Option<f64>,
}

/// What a run leaves in memory.
#[derive(Debug, Default)]
pub(crate) struct Evidence {
    pub time: f64,
    pub phi: Option<Kept>,
    pub flux: Option<Vec<Kept>>,
    pub half: Option<Vec<f64>>,
    /// The front at every frame, where it was asked for.
    pub fronts: Vec<Front>,
}

/// How far phi has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Front {
    /// \[s\]
    pub time: f64,
    /// What counts, as a share of the largest |phi|.
    pub fraction: f64,
    /// From where it was put in \[m\].
    pub reach: f64,
    /// ∫ max|u| dt \[m\].
    pub carried: f64,
}

/// Everything that came out of a run.
pub(crate) struct Outcome {
    pub summary: RunSummary,
    pub evidence: Evidence,
    /// What the sheet shows of it.
    pub last: Vec<f64>,
    /// Numbers and times of its frames.
    pub frames: Vec<(u32, f64)>,
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
            steps: pace.steps_of(&scene.schedule, &legs),
            longest: pace.dt,
            before_step: Backup::default(),
        };
        if let (TimeStep::Adaptive(tolerance), None) = (scene.numerics.step, running.ledger.controller) {
            let controller = Controller::new(tolerance, FIRST * pace.dt).map(|made| made.with_longest(pace.dt));
            // A run of no length has no step to choose.
            running.ledger.controller = controller.ok();
        }
        running.model.estimate(running.ledger.controller.is_some());
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
    /// Steps in all, where they are fixed.
    steps: f64,
    /// The longest step \[s\].
    longest: f64,
    /// Where an adaptive step goes back to.
    before_step: Backup,
}

impl Running<'_> {
    fn through(&mut self, legs: &[Leg], watch: &mut dyn Watch) -> Result<(), RunError> {
        let most = self.runner.scene.schedule.steps.unwrap_or(u64::MAX);
        if self.ledger.rows.is_empty() {
            self.frame(0)?;
        }
        let mut before = 0u64;
        if self.ledger.controller.is_some() || matches!(self.runner.scene.numerics.step, TimeStep::Courant(_)) {
            return self.through_adaptively(legs, most, watch);
        }
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

    /// The legs in steps that a controller or a fluid chooses; the ends of legs are met exactly.
    fn through_adaptively(&mut self, legs: &[Leg], most: u64, watch: &mut dyn Watch) -> Result<(), RunError> {
        for leg in legs {
            while self.ledger.time < leg.end {
                if self.ledger.step >= most {
                    return self.frame_if_new();
                }
                match self.runner.scene.numerics.step {
                    TimeStep::Courant(cfl) => self.flow(leg, cfl)?,
                    _ => self.adapt(leg)?,
                }
                if self.ledger.time == leg.end {
                    self.arrive(leg)?;
                }
                self.report(leg, watch)?;
            }
        }
        self.frame_if_new()
    }

    /// One step as long as a fluid allows now; the rest of the leg is divided equally.
    fn flow(&mut self, leg: &Leg, cfl: f64) -> Result<(), RunError> {
        let (from, run) = (self.ledger.time, || self.runner.scene.run.clone());
        let rest = leg.end - from;
        let longest = self.model.longest(from, cfl).min(self.longest);
        let wrong = |source| RunError::Step { run: run(), step: self.ledger.step + 1, time: from, source };
        // An unstable flow doubles its speed every few steps; it must not bring the run to a halt.
        if longest.is_nan() || longest < SHORTEST * self.longest {
            return Err(wrong(StepFailure::Runaway { dt: longest }));
        }
        let parts = (rest / longest - 1e-6).ceil().max(1.0);
        let dt = rest / parts;
        let report = self.model.advance(from, dt, &mut self.stopwatch).map_err(wrong)?;
        self.ledger.count(&report, self.model.flow().as_ref(), dt);
        self.ledger.time = if parts == 1.0 { leg.end } else { from + dt };
        self.look(parts == 1.0)
    }

    /// One step that stands, after as many as do not.
    fn adapt(&mut self, leg: &Leg) -> Result<(), RunError> {
        let (run, from) = (|| self.runner.scene.run.clone(), self.ledger.time);
        let wrong = |step, source| RunError::Step { run: run(), step, time: from, source };
        let Some(mut controller) = self.ledger.controller else { return Ok(()) };
        loop {
            let dt = controller.propose(leg.end - from);
            self.before_step.keep(&*self.model);
            let next = self.ledger.step + 1;
            let made = self.model.advance(from, dt, &mut self.stopwatch);
            let report = made.map_err(|source| wrong(next, source))?;
            let norm = self.model.norm();
            let stands = controller.judge(dt, report.error.unwrap_or(f64::NAN), norm);
            let stands = stands.map_err(|why: StepError| wrong(next, why.into()))?;
            self.ledger.controller = Some(controller);
            if stands {
                self.ledger.count(&report, None, dt);
                self.ledger.samples.embedded(report.error, norm);
                self.ledger.time = if dt == leg.end - from { leg.end } else { from + dt };
                return self.look(self.ledger.time == leg.end);
            }
            self.before_step.restore(&mut *self.model);
            // What it cost was spent all the same.
            self.ledger.solves += report.solves;
            self.ledger.iterations += report.iterations;
        }
    }

    fn step(&mut self, leg: &Leg, step: u64) -> Result<(), RunError> {
        let (from, dt) = (leg.time(step), leg.dt());
        let run = || self.runner.scene.run.clone();
        let (model, watch) = (&mut *self.model, &mut self.stopwatch);
        let sampled = self.runner.options.estimate && self.runner.scene.fluid().is_none();
        let made = if sampled && sample::is_due(self.ledger.step, self.steps) {
            self.ledger.samples.step(model, from, dt, watch)
        } else {
            model.advance(from, dt, watch)
        };
        let report =
            made.map_err(|source| RunError::Step { run: run(), step: self.ledger.step + 1, time: from, source })?;
        self.ledger.count(&report, self.model.flow().as_ref(), dt);
        self.ledger.time = leg.time(step + 1);
        self.look(step + 1 == leg.steps)
    }

    /// Looks for numbers that are none, now and then.
    fn look(&mut self, now: bool) -> Result<(), RunError> {
        let run = || self.runner.scene.run.clone();
        if (now || self.ledger.step.is_multiple_of(LOOK))
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
        if let Some(fraction) = self.runner.needs.front
            && let Some(reach) = self.model.reach(fraction)
        {
            let (time, given) = (self.ledger.time, self.runner.scene.medium_speed());
            let carried = if self.model.flow_state().is_some() { self.ledger.flow.carried } else { given * time };
            self.ledger.fronts.push(Front { time, fraction, reach, carried });
        }
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
        let RunSummary { name, steps, seconds, error, rejections, .. } = &summary;
        let again = if *rejections > 0 { format!(" and {rejections} made again") } else { String::new() };
        watch.note(&format!("run `{name}`: {steps} steps{again} in {:.1} s; {}", seconds.total, error.words()));
        let last = frames::last(View::of(runner.scene).as_ref(), &*model);
        let frames = ledger.rows.iter().map(|row| (row.frame, row.time)).collect();
        let Needs { phi, flux, .. } = runner.needs;
        let folder = runner.options.write.then_some(&*runner.options.out);
        let kept = |numbers| {
            let unkept = |source| OutputError::Io { path: runner.options.out.clone(), action: "keep phi in", source };
            Kept::new(numbers, folder).map_err(|error| runner.output(unkept(error)))
        };
        let (phi, flux) = model.end(phi, flux);
        let evidence = Evidence {
            time: ledger.time,
            phi: phi.map(kept).transpose()?,
            flux: flux.map(|axes| axes.into_iter().map(kept).collect()).transpose()?,
            half: ledger.half,
            fronts: ledger.fronts,
        };
        Ok(Outcome { summary, evidence, last, frames })
    }
}
