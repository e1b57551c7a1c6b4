//! How far a time step goes and who makes it: a pure function of the scene, with its reasons in words.
//!
//! Transport along one axis of a uniform medium is exact where it moves everything by whole cells. Explicit diffusion
//! carries once per step, `D(dt/2) A(dt) D(dt/2)`, so the step is h/|u|; implicit diffusion carries half a step twice,
//! `A(dt/2) D(dt) A(dt/2)`, so it is 2h/|u|. Both are taken as long as the waves move at most one cell, c dt <= h.
//! Otherwise dt = cfl·h/(|u| + c). What the scene leaves open goes no further than 1/64 of the run (a draft in a still medium:
//! 1/16), which is what bounds a still medium without waves; a step or a cfl that the scene gives is taken as it is. Explicit waves in a still
//! medium are most accurate just below their stability limit, where errors in time and space cancel, so that is the step.
//!
//! A solved fluid finds its step as it goes: dt = min(cfl·h/max|u|, 1/√(g beta max|grad phi|)), where u counts jets and
//! inflows that act. While it is at rest, the time in which a force moves it bounds the step, and 1/64 of the run. How many
//! steps that makes is guessed from what moves it (`drive`).

use crate::drive::{self, Drive};
use crate::scene::{Diffusion, Fluid, Model, Scene, Schedule, TimeStep};
use crate::spec::{Integrator, Level, Medium, Splitting};
use cf_diffusion::kdk_limit;

/// Explicit sub-steps in one step up to which they beat two implicit solves.
const MOST_EXPLICIT: f64 = 20.0;
/// The fewest steps of a run whose step is chosen for it.
const FEWEST_STEPS: f64 = 64.0;
/// The same for a draft whose steps are of second order.
const FEWEST_OF_A_DRAFT: f64 = 16.0;
/// Explicit steps in a still medium, where splitting is no concern.
const BELOW_THE_LIMIT: f64 = 0.98;
/// The most steps of a run.
pub(crate) const MOST_STEPS: f64 = 1e10;

/// The time step and the integrator of a run, with reasons.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// The longest step \[s\]; frames and switching sources shorten it.
    pub dt: f64,
    /// The step that is likely \[s\], for predictions; the same unless a fluid is solved for, which finds its own.
    pub likely: f64,
    /// Why.
    pub dt_reason: String,
    /// How diffusion is integrated; `None` for a model that is solved exactly.
    pub integrator: Option<Integrator>,
    /// Why.
    pub integrator_reason: String,
    /// What moves a fluid that finds its own step.
    drive: Option<Drive>,
}

impl Pace {
    /// The pace of a scene.
    pub fn of(scene: &Scene) -> Pace {
        let Model::Diffusion(model) = &scene.model else {
            return Pace {
                dt: scene.schedule.interval,
                likely: scene.schedule.interval,
                dt_reason: "the exact solution needs no steps between frames".into(),
                integrator: None,
                integrator_reason: "every Fourier mode has a closed form".into(),
                drive: None,
            };
        };
        if let TimeStep::Adaptive(tolerance) = scene.numerics.step {
            return adaptive(scene, tolerance);
        }
        let drive = match (scene.numerics.step, &model.fluid) {
            (TimeStep::Courant(cfl), Some(fluid)) => Some(Drive::of(scene, fluid, cfl)),
            _ => None,
        };
        if let Some(integrator) = scene.numerics.integrator {
            let (dt, likely, dt_reason) = step(scene, model, integrator);
            let given = "the scene's choice".into();
            return Pace { dt, likely, dt_reason, integrator: Some(integrator), integrator_reason: given, drive };
        }
        let waves = model.law.tau > 0.0 && model.law.fourier == 0.0;
        let (dt, likely, dt_reason) = step(scene, model, Integrator::Kdk);
        let ratio = likely / explicit_limit(scene, model);
        if waves && ratio <= MOST_EXPLICIT {
            let why = format!("pure waves (F_T = 0): explicit, at {ratio:.2} of its stability limit a step");
            let integrator = Some(Integrator::Kdk);
            return Pace { dt, likely, dt_reason, integrator, integrator_reason: why, drive };
        }
        let why = if waves {
            format!("tau is so short that explicit steps would need {ratio:.0} sub-steps each")
        } else if model.law.k == 0.0 {
            "nothing diffuses (k = 0)".into()
        } else {
            "a part of the flux has no memory (F_T > 0 or tau = 0), which only implicit steps take at this length"
                .into()
        };
        // Backward Euler is dearer at equal error, but keeps the long steps of a draft from falling below zero where the medium
        // carries what its sources put in.
        let blunt = scene.numerics.level == Level::Draft && !matches!(model.medium, Medium::Still);
        let integrator = if blunt { Integrator::PaperBe } else { Integrator::Sdirk2 };
        let (dt, likely, dt_reason) = step(scene, model, integrator);
        Pace { dt, likely, dt_reason, integrator: Some(integrator), integrator_reason: why, drive }
    }

    /// The steps to the end of a scene, infinite where they would never get there; of adaptive steps the least number, of a
    /// solved fluid the likely one.
    pub fn steps(&self, scene: &Scene) -> f64 {
        if let Some(drive) = &self.drive {
            let legs = self.legs(scene, None);
            let steps: f64 = legs.iter().map(|leg| (drive.steps(leg, self.dt) - 1e-6).ceil().max(1.0)).sum();
            return scene.schedule.steps.map_or(steps, |most| steps.min(most as f64));
        }
        let likely = Pace { dt: self.likely, ..self.clone() };
        likely.steps_of(&scene.schedule, &likely.legs(scene, None))
    }

    /// The legs of a run: between frames, the times at which sources switch, and another time that must be hit.
    pub(crate) fn legs(&self, scene: &Scene, another: Option<f64>) -> Vec<Leg> {
        let sources = match &scene.model {
            Model::Diffusion(model) => model.sources.as_slice(),
            Model::SingleField(_) => &[],
        };
        let jets = scene.fluid().map_or(&[][..], |fluid| &fluid.jets);
        let times = sources.iter().map(|source| [Some(source.from), source.until]);
        let switches = times.chain(jets.iter().map(|jet| [Some(jet.from), jet.until])).flatten().flatten();
        legs(&scene.schedule, switches.chain(another), self.dt)
    }

    pub(crate) fn steps_of(&self, schedule: &Schedule, legs: &[Leg]) -> f64 {
        let steps: f64 = legs.iter().map(|leg| leg.steps as f64).sum();
        let steps = if self.dt > 0.0 || legs.is_empty() { steps } else { f64::INFINITY };
        schedule.steps.map_or(steps, |most| if steps.is_finite() { steps.min(most as f64) } else { steps })
    }
}

/// Steps that a controller chooses: at most from frame to frame, and in a moving medium, whose splitting from the diffusion
/// the estimate does not see, a cell in each half step of transport.
fn adaptive(scene: &Scene, tolerance: f64) -> Pace {
    let (u, interval) = (scene.medium_speed(), scene.schedule.interval);
    let carried = if u > 0.0 { 2.0 * scene.grid.spacing / u } else { f64::INFINITY };
    let (dt, most) = if carried < interval {
        (carried, "2 h/|u|, a cell in each half step of transport")
    } else {
        (interval, "the time between frames")
    };
    Pace {
        dt,
        likely: dt,
        dt_reason: format!("adaptive: the relative error of a step is at most {tolerance:e}; at most {most}"),
        integrator: Some(Integrator::Sdirk2),
        integrator_reason: "its two stages tell the error by which steps are chosen".into(),
        drive: None,
    }
}

/// The longest stable explicit step \[s\].
fn explicit_limit(scene: &Scene, model: &Diffusion) -> f64 {
    let (h, d) = (scene.grid.spacing, scene.grid.dimension() as f64);
    cf_diffusion::Law::new(model.law.k, model.law.tau, model.law.fourier)
        .map_or(f64::NAN, |law| kdk_limit(&law, 4.0 * d / (h * h)))
}

/// The longest step, the likely one, and why.
fn step(scene: &Scene, model: &Diffusion, integrator: Integrator) -> (f64, f64, String) {
    if let (TimeStep::Courant(cfl), Some(fluid)) = (scene.numerics.step, &model.fluid) {
        return of_a_fluid(scene, fluid, cfl);
    }
    let (dt, reason) = given(scene, model, integrator);
    (dt, dt, reason)
}

/// The step in a medium that is given.
fn given(scene: &Scene, model: &Diffusion, integrator: Integrator) -> (f64, String) {
    let (cfl, may_shift) = match scene.numerics.step {
        TimeStep::Fixed(dt) => return (dt, "fixed by the scene".into()),
        TimeStep::Cfl(cfl) | TimeStep::Bounded(cfl) | TimeStep::Adaptive(cfl) | TimeStep::Courant(cfl) => (cfl, false),
        TimeStep::Shift(cfl) => (cfl, integrator != Integrator::Characteristic),
    };
    let (h, until) = (scene.grid.spacing, scene.schedule.until);
    if integrator == Integrator::Kdk
        && matches!(model.medium, Medium::Still)
        && !matches!(scene.numerics.step, TimeStep::Cfl(_))
    {
        let reason =
            format!("{BELOW_THE_LIMIT} of the stability limit: explicit waves in a still medium err least there");
        return (BELOW_THE_LIMIT * explicit_limit(scene, model), reason);
    }
    let (u, c) = (scene.medium_speed(), model.law.speed().unwrap_or(0.0));
    let halves = scene.numerics.splitting == Splitting::Strang && integrator != Integrator::Kdk;
    let cells = if halves { 2.0 } else { 1.0 };
    let shift = cells * h / u;
    let (dt, reason) = if may_shift && along_one_axis(&model.medium) && c * shift <= h * (1.0 + 1e-9) {
        let how = if halves { "each half step of transport" } else { "transport" };
        (shift, format!("|u| dt/h = {cells}: {how} moves everything by one whole cell, which is exact"))
    } else {
        (cfl * h / (u + c), format!("{cfl} h/(|u| + c) with |u| = {u} m/s and c = {c:.6} m/s"))
    };
    let long = scene.numerics.level == Level::Draft && integrator == Integrator::Sdirk2;
    let fewest = if long { FEWEST_OF_A_DRAFT } else { FEWEST_STEPS };
    let bound = until / fewest;
    if dt <= bound || bound == 0.0 || matches!(scene.numerics.step, TimeStep::Cfl(_)) {
        (dt, reason)
    } else {
        (bound, format!("1/{fewest} of the run; less than the {dt:.3e} s that waves and transport allow"))
    }
}

/// The longest step of a solved fluid, and the one that is likely: what is known before it moves.
fn of_a_fluid(scene: &Scene, fluid: &Fluid, cfl: f64) -> (f64, f64, String) {
    let (h, until) = (scene.grid.spacing, scene.schedule.until);
    let (whole, pull) = (until / FEWEST_STEPS, pull(scene, fluid));
    let free = (cfl * h / pull).sqrt();
    let (longest, bound) = if free < whole || whole == 0.0 && free.is_finite() {
        (free, format!("at most the time in which {pull:.3} m/s² move the fluid {cfl} cells"))
    } else {
        (whole, format!("at most 1/{FEWEST_STEPS} of the run"))
    };
    let drive = Drive::of(scene, fluid, cfl);
    let rate = drive.rate(0.0, until, longest);
    let likely = if rate > 0.0 { longest.min(1.0 / rate) } else { longest };
    let speed = drive.speed(until);
    let usual =
        if speed > 0.0 { format!(", likely {likely:.3e} s on average, for {speed:.2} m/s") } else { String::new() };
    (longest, likely, format!("{cfl} h/max|u| of each step{usual}; {bound}"))
}

/// The largest acceleration that is known before the run \[m/s²\]: of the force, and of what phi is given.
fn pull(scene: &Scene, fluid: &Fluid) -> f64 {
    let force = fluid.force.iter().map(|f| f * f).sum::<f64>().sqrt();
    let (Some(buoyancy), Model::Diffusion(model)) = (&fluid.buoyancy, &scene.model) else { return force };
    force + buoyancy.strength.abs() * drive::differing(model, buoyancy.reference)
}

fn along_one_axis(medium: &Medium) -> bool {
    matches!(medium, Medium::Uniform(u) if u.iter().filter(|component| **component != 0.0).count() == 1)
}

/// Equal steps from one event to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Leg {
    pub start: f64,
    pub end: f64,
    /// How many steps.
    pub steps: u64,
    /// The frame at the end, if there is one.
    pub frame: Option<u32>,
}

impl Leg {
    pub fn dt(&self) -> f64 {
        (self.end - self.start) / self.steps as f64
    }

    /// Where a step begins; step `steps` begins at the end exactly.
    pub fn time(&self, step: u64) -> f64 {
        if step >= self.steps {
            self.end
        } else {
            self.start + (self.end - self.start) * (step as f64 / self.steps as f64)
        }
    }
}

/// Legs between frames and other times that must be hit.
fn legs(schedule: &Schedule, others: impl Iterator<Item = f64>, dt: f64) -> Vec<Leg> {
    let near = 1e-9 * schedule.until;
    let inside = |time: &f64| *time > near && *time < schedule.until - near;
    let mut events: Vec<(f64, Option<u32>)> = others.filter(inside).map(|time| (time, None)).collect();
    events.extend((1..=schedule.frames).map(|frame| (schedule.frame_time(frame), Some(frame))));
    // At equal times the frame comes first and swallows what follows within rounding.
    events.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.is_some().cmp(&a.1.is_some())));
    let mut legs: Vec<Leg> = Vec::with_capacity(events.len());
    let mut start = 0.0;
    for (end, frame) in events {
        if end - start <= near {
            // An event just before a frame moves to the frame; one just after is dropped.
            match (legs.last_mut(), frame) {
                (Some(last), Some(_)) if last.frame.is_none() => (last.end, last.frame) = (end, frame),
                _ => continue,
            }
        } else {
            legs.push(Leg { start, end, steps: 1, frame });
        }
        start = end;
    }
    for leg in &mut legs {
        leg.steps = ((leg.end - leg.start) / dt - 1e-6).ceil().clamp(1.0, 1e15) as u64;
    }
    legs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, SceneFile, Set};

    const TEXT: &str = "(grid: (cells: (64, 128), extent: (4.0, 8.0)), \
        sides: (x: Walls(low: Open, high: Open), y: Walls(low: Open, high: Open)), \
        model: Diffusion(law: (k: 0.25, tau: 4.0), medium: Uniform((0.0, 0.5))), run: (until: 12.5, frames: 25))";

    fn pace(preset: &str, flags: &[&str]) -> Pace {
        let sets: Vec<Set> = flags.iter().map(|flag| Set::parse(flag).unwrap()).collect();
        let file = SceneFile::parse("s.ron", TEXT).unwrap();
        Pace::of(&file.experiment(Some(preset), &sets, &Limits { memory: 1 << 30 }).unwrap().runs[0])
    }

    #[test]
    fn a_uniform_medium_is_shifted_by_whole_cells() {
        let explicit = pace("standard", &[]);
        assert_eq!((explicit.integrator, explicit.dt), (Some(Integrator::Kdk), 0.125));
        assert!(explicit.dt_reason.contains("exact"), "{}", explicit.dt_reason);
        let implicit = pace("standard", &["model.law.fourier=0.5"]);
        assert_eq!((implicit.integrator, implicit.dt), (Some(Integrator::Sdirk2), 12.5 / 64.0));
        assert!(implicit.dt_reason.starts_with("1/64 of the run"), "{}", implicit.dt_reason);
        assert_eq!(pace("standard", &["run.until=125.0", "model.law.fourier=0.5"]).dt, 0.25);
        // Waves faster than a cell a step, and media across the axes, take the Courant rule.
        assert!(pace("standard", &["model.law.k=2.0"]).dt < 0.5 * 0.125);
        assert!(pace("standard", &["model.medium=Uniform((0.1, 0.5))"]).dt_reason.starts_with("0.5 h/"));
    }

    #[test]
    fn levels_and_laws_choose_the_integrator() {
        assert_eq!(pace("draft", &[]).integrator, Some(Integrator::Kdk));
        assert_eq!(pace("draft", &["model.law.fourier=0.5"]).integrator, Some(Integrator::PaperBe));
        let still = pace("draft", &["model.law.fourier=0.5", "model.medium=Still"]);
        assert_eq!(still.integrator, Some(Integrator::Sdirk2));
        assert!((still.dt - 0.0625 / (0.5f64 * 0.25 / 4.0).sqrt()).abs() < 1e-9, "{still:?}");
        let still = pace("draft", &["model.law.tau=0.0", "model.medium=Still"]);
        assert_eq!((still.integrator, still.dt), (Some(Integrator::Sdirk2), 12.5 / 16.0));
        assert_eq!(pace("standard", &["model.law.tau=0.0"]).integrator, Some(Integrator::Sdirk2));
        let stiff = pace("standard", &["model.law.tau=1e-6", "model.law.k=10.0", "accuracy.dt=0.1"]);
        assert_eq!(stiff.integrator, Some(Integrator::Sdirk2));
        assert!(stiff.integrator_reason.contains("sub-steps"), "{}", stiff.integrator_reason);
        assert_eq!(pace("standard", &["accuracy.integrator=PaperBe"]).integrator_reason, "the scene's choice");
        assert_eq!(pace("standard", &["accuracy.dt=0.01"]).dt, 0.01);
    }

    #[test]
    fn a_cfl_of_the_scene_is_not_cut_to_a_share_of_the_run() {
        let pace = pace("draft", &["accuracy.cfl=20", "run.frames=1"]);
        assert!((pace.dt - 20.0 * 0.0625 / 0.75).abs() < 1e-12 && pace.dt_reason.starts_with("20 h/"), "{pace:?}");
    }

    #[test]
    fn steps_are_counted_by_frames_and_may_be_endless() {
        let of = |flags: &[&str]| {
            let sets: Vec<Set> = flags.iter().map(|flag| Set::parse(flag).unwrap()).collect();
            let file = SceneFile::parse("s.ron", TEXT).unwrap();
            file.experiment(None, &sets, &Limits { memory: 1 << 30 }).unwrap().runs.remove(0)
        };
        let scene = of(&[]);
        assert_eq!(Pace::of(&scene).steps(&scene), 100.0);
        let scene = of(&["run.steps=7"]);
        assert_eq!(Pace::of(&scene).steps(&scene), 7.0);
        assert_eq!(Pace { dt: 0.0, likely: 0.0, ..Pace::of(&scene) }.steps(&scene), f64::INFINITY);
    }

    #[test]
    fn explicit_waves_in_a_still_medium_go_to_their_limit() {
        let still = ["model.medium=Still", "model.law.tau=1e3"];
        // c dt/h = 1/√2 in the plane.
        let c = (0.25f64 / 1e3).sqrt();
        for level in ["draft", "standard"] {
            let pace = pace(level, &still);
            assert!((pace.dt * c / 0.0625 - 0.98 * 0.5f64.sqrt()).abs() < 1e-3, "{pace:?}");
            assert_eq!(pace.integrator, Some(Integrator::Kdk));
        }
        assert_eq!(pace("standard", &[&still[..], &["accuracy.dt=0.01"]].concat()).dt, 0.01);
        let given = pace("standard", &[&still[..], &["accuracy.cfl=0.1"]].concat());
        assert!((given.dt * c / 0.0625 - 0.1).abs() < 1e-9, "{given:?}");
    }

    #[test]
    fn a_still_medium_without_waves_takes_64_steps() {
        let pace = pace("standard", &["model.medium=Still", "model.law.tau=0.0", "run.until=6.4"]);
        assert!((pace.dt - 0.1).abs() < 1e-12);
    }

    #[test]
    fn steps_divide_the_time_between_events() {
        let schedule = Schedule { until: 1.0, frames: 4, interval: 0.25, steps: None };
        let plain = legs(&schedule, std::iter::empty(), 0.1);
        assert_eq!(
            plain.iter().map(|leg| (leg.steps, leg.frame)).collect::<Vec<_>>(),
            [(3, Some(1)), (3, Some(2)), (3, Some(3)), (3, Some(4))]
        );
        let switched = legs(&schedule, [0.3, 0.5 + 1e-12, 0.5 - 1e-12, 0.0, 1.0, 7.0].into_iter(), 0.1);
        let ends: Vec<f64> = switched.iter().map(|leg| leg.end).collect();
        assert_eq!(ends, [0.25, 0.3, 0.5, 0.75, 1.0]);
        assert_eq!(switched.iter().filter_map(|leg| leg.frame).collect::<Vec<_>>(), [1, 2, 3, 4]);
        assert_eq!(switched[2].time(switched[2].steps), 0.5);
        let nothing = Schedule { until: 0.0, frames: 1, interval: 0.0, steps: None };
        assert!(legs(&nothing, std::iter::empty(), 0.1).is_empty());
        assert_eq!(legs(&schedule, std::iter::empty(), 0.25)[0].steps, 1);
    }
}
