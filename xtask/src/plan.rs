//! What a run will do and roughly cost, from its scene alone.

use crate::show;
use cf_diffusion::{Coefficients, Law, Regime, hc, kdk_limit};
use cf_linear::Plan;
use cf_scene::spec::{FlowScheme, Integrator, Precision};
use cf_scene::{Model, Pace, Scene, TimeStep};

/// What a run will do.
#[derive(Debug, Clone, PartialEq)]
pub struct RunPlan {
    /// Precision, transport and splitting.
    pub numerics: String,
    /// Regime of the law in its medium, in words.
    pub regime: String,
    /// The time step \[s\].
    pub dt: f64,
    /// Why this step.
    pub dt_reason: String,
    /// Steps to the end.
    pub steps: f64,
    /// The integrator and why.
    pub integrator: String,
    /// The solver and why.
    pub solver: String,
    /// Predicted wall seconds on two cores, within a factor of two or three.
    pub seconds: f64,
}

/// Plans a run.
pub fn plan(scene: &Scene) -> RunPlan {
    let pace = Pace::of(scene);
    let (steps, u) = (pace.steps(scene), scene.medium_speed());
    let law = match &scene.model {
        Model::Diffusion(model) => &model.law,
        Model::SingleField(pulse) => &pulse.law,
    };
    let law = Law::new(law.k, law.tau, law.fourier).ok();
    let (solver, cost) = match pace.integrator {
        Some(integrator) => solver(scene, law.as_ref(), u, integrator, pace.likely),
        None => ("none".into(), EXACT),
    };
    let carries = pace.integrator.is_some_and(|i| i != Integrator::Characteristic);
    let moves = if scene.moves() && carries { transport_cost(scene, law.as_ref()) } else { 0.0 };
    let moves = moves + flow_cost(scene);
    let numerics = &scene.numerics;
    let transport = if carries {
        format!("{:?}, splitting {:?}", numerics.advection, numerics.splitting)
    } else {
        "in the waves".into()
    };
    let name = pace.integrator.map_or_else(|| "exact".into(), |integrator| format!("{integrator:?}"));
    RunPlan {
        numerics: format!("{:?}, transport {transport}", numerics.precision),
        regime: words(&law, u),
        dt: pace.dt,
        dt_reason: pace.dt_reason,
        steps,
        integrator: format!("{name}: {}", pace.integrator_reason),
        solver,
        seconds: steps * cells(scene) * (cost + moves) * 1e-9 * word(scene) + frames(scene),
    }
}

fn cells(scene: &Scene) -> f64 {
    scene.grid.cells.iter().map(|&n| n as f64).product()
}

fn words(law: &Option<Law>, u: f64) -> String {
    let Some(law) = law else { return "unknown".into() };
    let regime = Regime::of(law, u);
    match (law.speed(), hc(law, u)) {
        (Some(c), Some(hc)) => format!("{regime}, c = {c:.4} m/s, |u| = {u:.4} m/s, H_c = {hc:.4}"),
        _ => format!("{regime}, no finite speed, |u| = {u:.4} m/s"),
    }
}

/// The solver in words, and what diffusion costs \[ns per cell and step in f64 on two cores\].
fn solver(scene: &Scene, law: Option<&Law>, u: f64, integrator: Integrator, dt: f64) -> (String, f64) {
    let (dimension, h) = (scene.grid.dimension(), scene.grid.spacing);
    let Some(law) = law else { return ("unknown".into(), 0.0) };
    if integrator == Integrator::Characteristic {
        let substeps =
            (dt * (u + law.speed().unwrap_or(0.0)) / (h * cf_diffusion::Front::<f64, 2>::COURANT)).ceil().max(1.0);
        return (format!("none; {substeps:.0} sub-steps of moving waves"), substeps * FRONT);
    }
    if integrator == Integrator::Kdk {
        let limit = kdk_limit(law, 4.0 * dimension as f64 / (h * h));
        let substeps = (dt / limit).ceil().max(1.0);
        let words = format!("none; {substeps:.0} explicit sub-steps, stable up to {limit:.3e} s");
        return (words, substeps * KDK);
    }
    let (stage, solves) = match integrator {
        Integrator::Sdirk2 => ((1.0 - std::f64::consts::FRAC_1_SQRT_2) * dt, 2.0),
        _ => (dt, 1.0),
    };
    let kappa = Coefficients::new(law, stage).beta / (h * h);
    let choice = match scene.numerics.solver {
        cf_scene::spec::Solver::Auto => {
            Plan::choose(dimension, 1.0, kappa, 2.0 * kappa, scene.numerics.tolerance).to_string()
        }
        asked => format!("{asked:?}, as the scene asks; kappa = {kappa:.2e}"),
    };
    let cost = if choice.starts_with("Multigrid") { MULTIGRID } else { CHEBYSHEV };
    let digits = -scene.numerics.tolerance.log10() / 5.0;
    (choice, solves * cost * digits)
}

fn transport_cost(scene: &Scene, law: Option<&Law>) -> f64 {
    let dimension = scene.grid.dimension() as f64;
    if scene.fluid().is_none() {
        return TRANSPORT * (1.0 + dimension);
    }
    // The flux goes where phi went.
    let flux = if law.is_some_and(Law::has_memory) { dimension } else { 0.0 };
    TRANSPORT * (2.0 + flux) + if solid(scene) { AROUND } else { 0.0 }
}

/// What a fluid that is solved for costs: its own transport, and its projections.
fn flow_cost(scene: &Scene) -> f64 {
    if scene.fluid().is_none() {
        return 0.0;
    }
    let fast = matches!(scene.numerics.step, TimeStep::Courant(cfl) if cfl > 1.0);
    let (advection, projections) = match scene.numerics.flow {
        FlowScheme::Draft => (MACCORMACK, 1.0),
        FlowScheme::CentralRk4 => (CENTRAL, 4.0),
        FlowScheme::ReflectionExtrapolated => (2.0 * CUBIC, 2.0),
        FlowScheme::Auto if fast => (2.0 * CUBIC, 2.0),
        FlowScheme::Auto | FlowScheme::Cnp => (CUBIC, 1.0),
    };
    let digits = 1.0 - scene.numerics.eta_div.log10();
    advection + projections * digits * PROJECTION * if solid(scene) { 2.0 } else { 1.0 }
}

fn solid(scene: &Scene) -> bool {
    matches!(&scene.model, Model::Diffusion(model) if model.mask.is_some() || !model.obstacles.is_empty())
}

/// Files and pictures of all frames \[s\].
fn frames(scene: &Scene) -> f64 {
    let output = &scene.output;
    let fields = if output.vtk { output.fields.len() as f64 } else { 0.0 };
    let cloud = if output.volume.is_some() { CLOUD + CLOUD_CELL * cells(scene) } else { 0.0 };
    (1.0 + f64::from(scene.schedule.frames)) * (FRAME + cloud + FIELD * fields * cells(scene))
}

fn word(scene: &Scene) -> f64 {
    if scene.numerics.precision == Precision::F32 { 0.6 } else { 1.0 }
}

/// Costs in nanoseconds per cell on two cores in f64, rounded up: one explicit sub-step, one solve to five digits, and
/// the transport of one field over a step.
const KDK: f64 = 10.0;
const FRONT: f64 = 25.0;
const CHEBYSHEV: f64 = 60.0;
const MULTIGRID: f64 = 200.0;
const TRANSPORT: f64 = 25.0;
const EXACT: f64 = 1e3;
/// The same of a velocity in space: carried by cubic interpolation, by MacCormack's, by central differences; a digit of a projection.
const CUBIC: f64 = 200.0;
const MACCORMACK: f64 = 550.0;
const CENTRAL: f64 = 200.0;
const PROJECTION: f64 = 8.0;
/// What transport takes besides, where it may meet solids.
const AROUND: f64 = 120.0;
/// Pictures of a frame \[s\]; those of a cloud, and what they take for each cell; a field in a file, for each cell.
const FRAME: f64 = 0.02;
const CLOUD: f64 = 0.2;
const CLOUD_CELL: f64 = 4e-7;
const FIELD: f64 = 2e-8;

impl RunPlan {
    /// Lines for a person.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        vec![
            ("regime", self.regime.clone()),
            ("time step", format!("{:.4e} s: {}", self.dt, self.dt_reason)),
            ("steps", format!("{:.0}", self.steps)),
            ("integrator", self.integrator.clone()),
            ("solver", self.solver.clone()),
            ("predicted time", format!("about {}", show::seconds(self.seconds))),
        ]
    }
}
