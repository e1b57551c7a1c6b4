//! `accuracy: Target(E)`: the cheapest run of a scene whose error is E.
//!
//! The grids are those of the scene halved again and again, the time step is halved with them, so the error falls as one
//! power of h. Coarse runs come first. With d the relative difference of phi at the end between two grids, and p the order
//! that three grids show,
//!
//! ```text
//! p = log2(d_before/d) in [0.5, 2], 1 while there are only two grids        error of the finer = d/(2^p - 1)
//! ```
//!
//! A grid that was run is never thought better than its difference from the finest that was. A grid that does not show what
//! the scene's own does ([`Shown`]) is no answer: obstacles close or vanish on it, or the initial state aliases.
//!
//! The first grid that is going to be good enough is run in earnest, and judged again by its own difference; a finer one
//! follows where it was not. Whatever comes out, the summary says the error reached. For waves in a medium that is still or
//! uniform, the coarsest grids also decide between centred steps and those along the characteristics.
//!
//! All of it is counted and compared, nothing is timed: the same scene takes the same way on every machine.

use crate::build::Shown;
use crate::coarse;
use crate::pace::Pace;
use crate::perform::Options;
use crate::progress::{Progress, Watch, Wish};
use crate::run::{Needs, Outcome, Runner};
use crate::run_error::RunError;
use crate::scene::{Grid, Model, Scene, TimeStep};
use crate::spec::{Axes, Integrator, Medium, Pictures};
use crate::summary::{RungSummary, TargetSummary};
use cf_diffusion::Front;

/// Cells along an axis of a grid that is not halved further.
pub(crate) const FEWEST_CELLS: usize = 8;
/// Grids below that of the scene, at most.
const MOST_HALVINGS: usize = 5;
/// Runs that decide between schemes: three tell an order.
const PILOTS: usize = 3;
/// What a sub-step along the characteristics costs in explicit steps.
const FRONT_COST: f64 = 2.5;

/// The grids of a scene, coarsest first, its own last.
pub(crate) fn ladder(grid: &Grid) -> Vec<Grid> {
    let mut grids = vec![grid.clone()];
    while grids.len() <= MOST_HALVINGS {
        let Some(finer) = grids.last() else { break };
        if !finer.cells.iter().all(|n| n % 2 == 0 && n / 2 >= FEWEST_CELLS) {
            break;
        }
        let cells: Axes<usize> = finer.cells.iter().map(|n| n / 2).collect();
        grids.push(Grid { cells, spacing: 2.0 * finer.spacing, ..finer.clone() });
    }
    grids.reverse();
    grids
}

/// A run that is done, on its way to a target.
struct Rung {
    cells: Axes<usize>,
    steps: u64,
    phi: Vec<f64>,
    difference: Option<f64>,
}

impl Rung {
    fn of(scene: &Scene, outcome: &Outcome, before: Option<&Rung>) -> Rung {
        // What cannot be read again differs from everything.
        let phi = outcome.evidence.phi.as_ref().and_then(|phi| phi.get().ok()).unwrap_or_default();
        let difference = before.map(|coarse| coarse.off_from(&phi, &scene.grid.cells));
        Rung { cells: scene.grid.cells.clone(), steps: outcome.summary.steps, phi, difference }
    }

    /// The difference from phi on a finer grid, by means over these cells.
    fn off_from(&self, phi: &[f64], cells: &[usize]) -> f64 {
        if phi.len() != cells.iter().product::<usize>() {
            return f64::NAN;
        }
        let means = coarse::means(phi, cells, &self.cells);
        coarse::difference(self.phi.iter().copied().zip(means))
    }
}

/// What differences say.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Judgement {
    order: f64,
    /// The relative error of the finer grid of the newest difference.
    error: f64,
}

impl Judgement {
    /// From the differences of grids that follow each other.
    fn of(differences: &[f64]) -> Judgement {
        let (order, last) = match *differences {
            [.., before, last] if last > 0.0 && before.is_finite() => ((before / last).log2().clamp(0.5, 2.0), last),
            [.., last] => (1.0, last),
            [] => (1.0, f64::INFINITY),
        };
        Judgement { order, error: last / (order.exp2() - 1.0) }
    }

    /// The error on the grid `level` of a ladder, where this is that on the last of its `rungs`. Infinite where differences
    /// are no numbers.
    fn on(&self, level: usize, rungs: &[Rung]) -> f64 {
        let extrapolated = self.error * (self.order * (rungs.len() as f64 - 1.0 - level as f64)).exp2();
        let seen = match (rungs.get(level), rungs.last()) {
            (Some(rung), Some(finest)) if level + 1 < rungs.len() => rung.off_from(&finest.phi, &finest.cells),
            _ => 0.0,
        };
        let error = extrapolated.max(seen);
        if extrapolated.is_finite() && seen.is_finite() { error } else { f64::INFINITY }
    }
}

/// Runs a scene to a relative error of `wanted`; also gives the scene as it was run.
pub(crate) fn run(runner: &Runner<'_>, wanted: f64, watch: &mut dyn Watch) -> Result<(Scene, Outcome), RunError> {
    let (grids, valid) = shown(runner.scene, ladder(&runner.scene.grid))?;
    let last = grids.len() - 1;
    let Path { schedule_dt, integrator, mut rungs } = Path::choose(runner, &grids, wanted, watch)?;
    let on = |level: usize| rung(runner.scene, &grids[level], integrator, schedule_dt, level);
    // The first coarse runs are there. The next one is a further pilot unless it is going to be the last.
    let (mut level, pilots) = loop {
        let found = judge(&rungs, valid);
        let newest = rungs.len() - 1;
        if let Some(enough) = (valid..=newest).find(|level| found.on(*level, &rungs) <= wanted) {
            break (enough, newest);
        }
        let next = newest + 1;
        if next >= last || next >= valid && found.on(next, &rungs) <= wanted {
            break (next.min(last), newest);
        }
        let scene = on(newest + 1);
        let outcome = pilot(runner, &scene, watch)?;
        rungs.push(Rung::of(&scene, &outcome, rungs.last()));
    };
    loop {
        let scene = on(level);
        let needs = Needs { phi: true, ..runner.needs };
        let mut outcome = Runner { scene: &scene, needs, ..*runner }.run(watch)?;
        let verdict = |rungs: &[Rung]| {
            let judged = judge(rungs, valid);
            (judged.order, judged.on(level, rungs))
        };
        // Where a pilot was good enough, what all pilots say stands.
        let known = (level <= pilots).then(|| verdict(&rungs));
        let before = level.checked_sub(1).and_then(|coarser| rungs.get(coarser));
        let rung = Rung::of(&scene, &outcome, before);
        rungs.push(rung);
        let (order, achieved) = known.unwrap_or_else(|| verdict(&rungs));
        if achieved <= wanted || level == last {
            let summary = summary(&rungs, wanted, achieved, order);
            if !summary.reached {
                outcome.summary.warnings.push(summary.words.clone());
            }
            watch.note(&format!("run `{}`: {}", scene.run, summary.words));
            outcome.summary.target = Some(summary);
            if !runner.needs.phi {
                outcome.evidence.phi = None;
            }
            return Ok((scene, outcome));
        }
        level += 1;
    }
}

/// The grids that are worth running, and the first of them that shows what the scene's own, the last, does. Some coarser ones stay for
/// differences, and judge without being an answer.
fn shown(scene: &Scene, mut grids: Vec<Grid>) -> Result<(Vec<Grid>, usize), RunError> {
    let on = |grid: &Grid| {
        let shown = Shown::of(&Scene { grid: grid.clone(), ..scene.clone() });
        shown.map_err(|error| RunError::Build { run: scene.run.clone(), source: error })
    };
    let last = grids.len() - 1;
    let mut valid = 0;
    if let Some(own) = on(&scene.grid)? {
        for level in (0..last).rev() {
            if !on(&grids[level])?.is_some_and(|coarse| own.is_shown_by(&coarse)) {
                valid = level + 1;
                break;
            }
        }
    }
    // Both schemes are judged on the same grids, so those on which one of them is not valid are left out.
    let both = grids.iter().position(|grid| follows_fronts(scene, grid)).unwrap_or(0);
    let start = valid.max(both).min(last.saturating_sub(PILOTS));
    grids.drain(..start);
    Ok((grids, valid.saturating_sub(start)))
}

/// From the grids that show the scene, the first of which is `valid`; where no two do, from the last difference alone.
fn judge(rungs: &[Rung], valid: usize) -> Judgement {
    let differences: Vec<f64> = rungs.iter().filter_map(|rung| rung.difference).collect();
    let from = valid.min(differences.len().saturating_sub(1));
    Judgement::of(&differences[from..])
}

fn summary(rungs: &[Rung], wanted: f64, achieved: f64, order: f64) -> TargetSummary {
    let reached = achieved <= wanted;
    let words = if reached {
        format!(
            "the target {wanted:e} is reached: the error of cell means is about {achieved:.1e}, at order {order:.1}"
        )
    } else {
        let more = (achieved / wanted).powf(1.0 / order);
        let more = if more < 1e3 { format!("{more:.1}") } else { format!("{more:.0e}") };
        format!(
            "the target {wanted:e} is not reached: with the cells of the scene the error of cell means is about {achieved:.1e}, at order \
             {order:.1}; about {more} times as many cells along each axis would do"
        )
    };
    let one = |rung: &Rung| RungSummary { cells: rung.cells.to_vec(), steps: rung.steps, difference: rung.difference };
    TargetSummary { wanted, achieved, reached, order, rungs: rungs.iter().map(one).collect(), words }
}

/// The scheme, the step on the coarsest grid, and the first runs.
struct Path {
    schedule_dt: f64,
    integrator: Option<Integrator>,
    rungs: Vec<Rung>,
}

impl Path {
    fn choose(runner: &Runner<'_>, grids: &[Grid], wanted: f64, watch: &mut dyn Watch) -> Result<Path, RunError> {
        let mut best: Option<(f64, Path)> = None;
        let schemes = schemes(runner.scene, &grids[0]);
        let pilots = if schemes.len() > 1 { PILOTS } else { PILOTS - 1 };
        let halvings = grids.len() - 1;
        for integrator in schemes {
            let mut own = runner.scene.clone();
            own.numerics.integrator = integrator;
            let pace = Pace::of(&own);
            // On the coarsest grid as often the scene's own step as its cells are larger, and an equal part of the time between
            // frames, so that every halving of the step is one.
            let (interval, longest) = (runner.scene.schedule.interval, pace.dt * (halvings as f64).exp2());
            let schedule_dt = if longest < interval { interval / (interval / longest).ceil() } else { interval };
            let mut path = Path { schedule_dt, integrator: pace.integrator, rungs: Vec::new() };
            for level in 0..pilots.min(halvings) {
                let scene = rung(runner.scene, &grids[level], path.integrator, schedule_dt, level);
                let outcome = pilot(runner, &scene, watch)?;
                path.rungs.push(Rung::of(&scene, &outcome, path.rungs.last()));
            }
            // Cost grows with the power d + 1 of the cells along an axis, and they with the root of the error of the order seen.
            let weight = if integrator == Some(Integrator::Characteristic) { FRONT_COST } else { 1.0 };
            let Judgement { order, error } = judge(&path.rungs, 0);
            let cost = weight * (error / wanted).powf((grids[0].dimension() + 1) as f64 / order);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, path));
            }
        }
        let nothing = Path { schedule_dt: runner.scene.schedule.interval, integrator: None, rungs: Vec::new() };
        Ok(best.map_or(nothing, |(_, path)| path))
    }
}

/// Whether a grid may be stepped along the characteristics.
fn follows_fronts(scene: &Scene, grid: &Grid) -> bool {
    let Model::Diffusion(model) = &scene.model else { return false };
    let plain = matches!(model.medium, Medium::Still | Medium::Uniform(_)) && model.obstacles.is_empty();
    let resolved = model.law.speed().is_some_and(|c| {
        c > 0.0 && model.law.fourier == 0.0 && grid.spacing <= Front::<f64, 2>::CELL_RATIO * c * model.law.tau
    });
    scene.numerics.integrator.is_none() && plain && resolved
}

/// The schemes to try: the scene's choice, or what the plan takes, and the characteristics where they are valid.
fn schemes(scene: &Scene, coarsest: &Grid) -> Vec<Option<Integrator>> {
    let mut schemes = vec![scene.numerics.integrator];
    if follows_fronts(scene, coarsest) {
        schemes.push(Some(Integrator::Characteristic));
    }
    schemes
}

/// The scene on a grid, with the step of the coarsest halved `level` times.
fn rung(scene: &Scene, grid: &Grid, integrator: Option<Integrator>, dt: f64, level: usize) -> Scene {
    let mut rung = Scene { grid: grid.clone(), ..scene.clone() };
    rung.numerics.integrator = integrator;
    rung.numerics.step = TimeStep::Fixed(dt / (level as f64).exp2());
    rung
}

/// A run without files and words.
fn pilot(runner: &Runner<'_>, scene: &Scene, watch: &mut dyn Watch) -> Result<Outcome, RunError> {
    let options = Options { write: false, estimate: false, resume: false, ..runner.options.clone() };
    let mut scene = scene.clone();
    scene.output.pictures = Pictures::Off;
    let needs = Needs { phi: true, ..Needs::default() };
    Runner { scene: &scene, needs, options: &options, ..*runner }.run(&mut Quiet(watch))
}

/// Watches steps and says nothing.
struct Quiet<'a>(&'a mut dyn Watch);

impl Watch for Quiet<'_> {
    fn step(&mut self, progress: Progress<'_>) -> Wish {
        self.0.step(progress)
    }
    fn note(&mut self, _: &str) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_are_halved_while_they_can_be() {
        let grid = |cells: &[usize]| Grid {
            cells: cells.iter().copied().collect(),
            spacing: 0.5,
            origin: cells.iter().map(|_| 0.0).collect(),
            extent: cells.iter().map(|n| 0.5 * *n as f64).collect(),
        };
        let cells = |of: &[usize]| ladder(&grid(of)).iter().map(|g| g.cells.to_vec()).collect::<Vec<_>>();
        assert_eq!(cells(&[64, 32]), [[16, 8], [32, 16], [64, 32]]);
        assert_eq!(cells(&[24, 20]), [[12, 10], [24, 20]]);
        assert_eq!(cells(&[7, 32]), [[7, 32]]);
        assert_eq!(cells(&[1024, 1024]).len(), 6);
        assert_eq!(ladder(&grid(&[64, 32]))[0].spacing, 2.0);
    }

    #[test]
    fn orders_and_errors_from_differences() {
        assert_eq!(Judgement::of(&[]).error, f64::INFINITY);
        assert_eq!(Judgement::of(&[0.1]), Judgement { order: 1.0, error: 0.1 });
        let second = Judgement::of(&[0.4, 0.1]);
        assert!((second.order - 2.0).abs() < 1e-12 && (second.error - 0.1 / 3.0).abs() < 1e-12);
        let rung = |n: usize, phi: f64| Rung {
            cells: [n, n].into_iter().collect(),
            steps: 1,
            phi: vec![phi; n * n],
            difference: None,
        };
        let rungs = |first: f64| vec![rung(2, first), rung(4, 1.0), rung(8, 1.0)];
        assert!((second.on(3, &rungs(1.0)) - 0.1 / 12.0).abs() < 1e-12);
        assert!((second.on(1, &rungs(1.0)) - 0.4 / 3.0).abs() < 1e-12);
        // Whatever is extrapolated, what was seen counts.
        assert!((second.on(0, &rungs(3.0)) - 2.0).abs() < 1e-12);
        assert_eq!(second.on(0, &rungs(f64::NAN)), f64::INFINITY);
        assert_eq!(Judgement::of(&[f64::INFINITY, 0.1]).order, 1.0);
        assert_eq!(Judgement::of(&[0.1, 0.2]).order, 0.5);
    }
}
