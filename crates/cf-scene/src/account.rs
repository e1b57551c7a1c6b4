//! The summary of a finished run.

use crate::ledger::Ledger;
use crate::model::Model;
use crate::pace::Pace;
use crate::run::Runner;
use crate::scene::{self, Scene};
use crate::spec::{Integrator, Precision};
use crate::stopwatch::Stopwatch;
use crate::summary::{FlowSummary, Iterations, Mass, RegimeSummary, RunSummary, Seconds};
use cf_diffusion::{Law, Regime, hc};

/// Puts the numbers of a run together.
pub(crate) fn account(
    runner: &Runner<'_>,
    pace: &Pace,
    model: &dyn Model,
    ledger: &Ledger,
    stopwatch: &Stopwatch,
) -> RunSummary {
    let scene = runner.scene;
    let totals = model.totals();
    let (solver, solver_reason) = model.solver();
    let steps = ledger.step.max(1) as f64;
    RunSummary {
        name: scene.run.clone(),
        label: scene.label.clone(),
        dimension: scene.grid.dimension(),
        cells: scene.grid.cells.to_vec(),
        spacing: scene.grid.spacing,
        precision: match scene.numerics.precision {
            Precision::F32 => "f32".into(),
            Precision::Mixed => "mixed".into(),
            Precision::F64 => "f64".into(),
        },
        threads: runner.options.threads,
        steps: ledger.step,
        dt: ledger.dt.map_or([pace.dt; 2], |(low, high)| [low, high]),
        dt_reason: pace.dt_reason.clone(),
        time: ledger.time,
        integrator: pace.integrator.map_or("exact".into(), |integrator| format!("{integrator:?}")),
        integrator_reason: pace.integrator_reason.clone(),
        advection: advection(scene, pace),
        solver,
        solver_reason,
        iterations: Iterations {
            solves: ledger.solves,
            mean: ledger.iterations as f64 / ledger.solves.max(1) as f64,
            max: ledger.most_iterations,
        },
        seconds: Seconds {
            total: ledger.seconds,
            per_step: STEPPING.iter().map(|phase| stopwatch.seconds(phase)).sum::<f64>() / steps,
            phases: stopwatch.phases().clone(),
        },
        peak_memory: peak_memory(),
        fields: model.fields(),
        mass: Mass {
            start: ledger.start,
            end: totals.mass,
            emitted: ledger.emitted,
            outflow: ledger.outflow,
            drift: ledger.drift(totals),
        },
        ranges: model.ranges(),
        regime: regime(scene),
        residual: ledger.residual,
        flow: flow(scene, model, ledger),
        error: ledger.samples.summary(scene, pace, ledger.step),
        rejections: ledger.controller.map_or(0, |controller| controller.rejected),
        target: None,
        warnings: warnings(scene, pace, ledger, ledger.drift(totals)),
        files: ledger.files.clone(),
    }
}

/// The phases of a step.
const STEPPING: [&str; 4] = ["advection", "projection", "transport", "diffusion"];

fn flow(scene: &Scene, model: &dyn Model, ledger: &Ledger) -> Option<FlowSummary> {
    let (state, counts) = (model.flow_state()?, &ledger.flow);
    let schemes: Vec<String> = counts.schemes.iter().map(|(name, steps)| format!("{name} ({steps} steps)")).collect();
    Some(FlowSummary {
        scheme: schemes.join(", "),
        solver: state.solver,
        solver_reason: state.reason,
        projections: Iterations {
            solves: counts.projections,
            mean: counts.iterations as f64 / counts.projections.max(1) as f64,
            max: counts.most_iterations,
        },
        divergence: counts.divergence,
        eta_div: scene.numerics.eta_div,
        at_floor: counts.at_floor,
        imbalance: counts.imbalance,
        courant: counts.courant,
        speed: counts.speed,
        energy: state.energy,
        work: counts.work,
        hc: state.hc,
    })
}

fn advection(scene: &Scene, pace: &Pace) -> String {
    match &scene.model {
        scene::Model::Diffusion(_) if pace.integrator == Some(Integrator::Characteristic) => "Characteristic".into(),
        scene::Model::Diffusion(_) if scene.moves() => format!("{:?}", scene.numerics.advection),
        scene::Model::Diffusion(_) => "none".into(),
        scene::Model::SingleField(_) => "exact".into(),
    }
}

fn regime(scene: &Scene) -> RegimeSummary {
    let speed = scene.medium_speed();
    let law = match &scene.model {
        scene::Model::Diffusion(model) => model.law,
        scene::Model::SingleField(model) => model.law,
    };
    let Ok(law) = Law::new(law.k, law.tau, law.fourier) else { return RegimeSummary::default() };
    let regime = Regime::of(&law, speed);
    RegimeSummary {
        name: regime.name().into(),
        speed: law.speed(),
        hc: hc(&law, speed).filter(|ratio| ratio.is_finite()),
        half_angle: match regime {
            Regime::Supercritical { half_angle } => Some(half_angle.to_degrees()),
            Regime::Critical => Some(90.0),
            Regime::Fourier | Regime::Subcritical => None,
        },
    }
}

fn warnings(scene: &Scene, pace: &Pace, ledger: &Ledger, drift: f64) -> Vec<String> {
    let mut warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    if drift.abs() > 1e-3 {
        warnings.push(format!(
            "the mass account is off by {drift:.1e}: semi-Lagrangian transport does not conserve mass; \
             use accuracy.advection: Muscl where it matters"
        ));
    }
    if ledger.time < scene.schedule.until {
        let (time, until) = (ledger.time, scene.schedule.until);
        warnings.push(format!("run.steps ended the run at t = {time} s, before {until} s"));
    }
    let split = if scene.numerics.splitting == crate::spec::Splitting::Strang { 2 } else { 1 };
    let allowed = if pace.integrator == Some(Integrator::Characteristic) { 1 } else { split };
    if ledger.substeps > allowed {
        warnings.push(format!("explicit diffusion took {} sub-steps a step to stay stable", ledger.substeps));
    }
    if ledger.transport_substeps > split {
        warnings.push(format!("transport took {} sub-steps a step to stay stable", ledger.transport_substeps));
    }
    if let (scene::Model::Diffusion(model), Some(Integrator::Characteristic)) = (&scene.model, pace.integrator) {
        let ratio = scene.grid.spacing / (model.law.speed().unwrap_or(0.0) * model.law.tau);
        if ratio > 0.3 {
            warnings
                .push(format!("h/(c tau) = {ratio:.2} is above 0.3: cells too coarse for fronts, use Kdk or Sdirk2"));
        }
    }
    if let scene::Model::Diffusion(model) = &scene.model {
        let (speed, wave) = (scene.medium_speed(), model.law.speed().unwrap_or(0.0));
        let longest = ledger.dt.map_or(0.0, |(_, longest)| longest);
        let courant = (speed + wave) * longest / scene.grid.spacing;
        let given = matches!(scene.numerics.step, scene::TimeStep::Fixed(_) | scene::TimeStep::Cfl(_));
        if given && courant > 4.0 {
            let cells = if courant < 1e4 { format!("{courant:.1}") } else { format!("{courant:.1e}") };
            warnings.push(format!("a step moves waves and medium by up to {cells} cells; fronts will be blunt"));
        }
    }
    if ledger.flow.imbalance > 0.0 {
        warnings.push(format!(
            "jets and inflows do not balance: a part of the fluid without an open wall gains or loses {:.2e} of its volume \
             a second, which no pressure can prevent; open a wall in model.medium.walls",
            ledger.flow.imbalance
        ));
    }
    if ledger.flow.at_floor > 0 {
        warnings.push(format!(
            "{} steps ended at the rounding floor, above accuracy.eta_div: raise it, or use precision: f64",
            ledger.flow.at_floor
        ));
    }
    let lowest = ledger.rows.iter().map(|row| row.min).fold(0.0, f64::min);
    let highest = ledger.rows.iter().map(|row| row.max).fold(0.0, f64::max);
    if lowest < -0.01 * highest {
        let share =
            if highest > 0.0 { format!(", {:.2} of its largest value", -lowest / highest) } else { String::new() };
        warnings.push(format!("phi fell to {lowest:.3e}{share}; nothing is clamped, waves may dip below zero"));
    }
    warnings
}

/// Peak resident memory of this process \[bytes\]; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let kilobytes = || {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    };
    kilobytes().map_or(0, |kilobytes| kilobytes.saturating_mul(1024))
}
