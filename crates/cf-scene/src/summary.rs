//! What a run leaves for machines: the content of `summary.json`, with stable keys.

use serde::Serialize;
use std::collections::BTreeMap;

/// One command's outcome: all runs of a scene file, and the claims about them.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Scene file name without extension.
    pub scene: String,
    /// Its title.
    pub title: String,
    /// Figure of the paper, if any.
    pub figure: Option<String>,
    /// Version of the program.
    pub version: String,
    /// Size preset.
    pub preset: Option<String>,
    /// `--set` flags, as given.
    pub overrides: Vec<String>,
    /// Runs in the order of the file.
    pub runs: Vec<RunSummary>,
    /// Claims that apply.
    pub claims: Vec<ClaimResult>,
    /// Wall seconds of everything, output included.
    pub seconds: f64,
    /// Files about all runs together, relative to the output folder.
    pub files: Vec<String>,
}

impl Summary {
    /// Claims that must hold and do not.
    pub fn failures(&self) -> impl Iterator<Item = &ClaimResult> {
        self.claims.iter().filter(|c| c.kind == "Must" && !c.pass)
    }
}

/// One run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RunSummary {
    /// Variant name, `main` without variants.
    pub name: String,
    /// What pictures call it.
    pub label: String,
    /// 1, 2 or 3.
    pub dimension: usize,
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// Cell edge \[m\].
    pub spacing: f64,
    /// `f32`, `mixed` or `f64`.
    pub precision: String,
    /// Worker threads.
    pub threads: usize,
    /// Time steps made.
    pub steps: u64,
    /// Smallest and largest time step \[s\].
    pub dt: [f64; 2],
    /// Why the step is what it is.
    pub dt_reason: String,
    /// Simulated time reached \[s\].
    pub time: f64,
    /// Integrator of the diffusion.
    pub integrator: String,
    /// Why this one.
    pub integrator_reason: String,
    /// Transport scheme.
    pub advection: String,
    /// Linear solver plan, or `none`.
    pub solver: String,
    /// Why this plan.
    pub solver_reason: String,
    /// Solver iterations per solve.
    pub iterations: Iterations,
    /// Wall seconds.
    pub seconds: Seconds,
    /// Peak resident memory of the process so far \[bytes\].
    pub peak_memory: u64,
    /// Fields and scratch with their bytes.
    pub fields: Vec<FieldBytes>,
    /// The mass budget \[P m^D\].
    pub mass: Mass,
    /// Smallest and largest value of every field at the end.
    pub ranges: Vec<Range>,
    /// Regime of the law in this medium.
    pub regime: RegimeSummary,
    /// Largest residual of any solve \[P\], a bound of what one solve adds to the error.
    pub residual: f64,
    /// The solved fluid, if there is one.
    pub flow: Option<FlowSummary>,
    /// What is known of the error.
    pub error: ErrorSummary,
    /// Steps made again because their error was above the tolerance; only adaptive steps are.
    pub rejections: u64,
    /// What `accuracy: Target(..)` came to.
    pub target: Option<TargetSummary>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Files written, relative to the output folder.
    pub files: Vec<String>,
}

/// Errors in time, estimated as the run went. All are relative.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ErrorSummary {
    /// The largest estimate e = 1/2 ||K2 - K1|| of a step from its own two stages, relative to the largest norm sqrt(2E') so
    /// far; of sampled steps, of all where steps are adaptive. Only Sdirk2 has it. It is an upper bound of the error in time
    /// at the end where the medium is still.
    pub embedded: Option<f64>,
    /// The mean error of a step of phi, transport included, by making sampled steps in one and in two; in the mean square.
    pub per_step: Option<f64>,
    /// That times the number of steps: the error in time at the end, if no error decayed or cancelled another.
    pub whole_run: Option<f64>,
    /// Steps that were sampled.
    pub samples: u64,
    /// How it was estimated, or why it was not.
    pub how: String,
}

impl ErrorSummary {
    /// The estimate in a few words.
    pub fn words(&self) -> String {
        // Sums of errors as large as phi itself bound nothing: beside small sources and fronts single steps err much, and what
        // they err fades. The stages, which see less than the whole step, tell as little then.
        let embedded = self.embedded.filter(|stages| *stages < BOUND);
        match (embedded, self.whole_run, self.per_step) {
            (_, Some(whole), Some(step)) if whole >= BOUND => format!(
                "a step errs by about {step:.1e} of phi; all of them would add up to {whole:.1e} if none faded, so this bounds nothing at the end"
            ),
            (Some(stages), Some(whole), _) => {
                format!("error in time about {whole:.1e}, at most {stages:.1e} a step from its stages")
            }
            (Some(stages), None, _) => format!("error in time at most {stages:.1e} a step, from its stages"),
            (None, Some(whole), _) => format!("error in time about {whole:.1e}"),
            (None, None, _) if self.embedded.is_some() => "steps too long for an estimate of the error".into(),
            (None, None, _) => format!("no estimate of the error: {}", self.how),
        }
    }

    /// The estimate, and where it comes from.
    pub fn sentence(&self) -> String {
        let words = self.words();
        // Without any estimate the words are the reason.
        match (self.embedded, self.whole_run) {
            (None, None) => words,
            _ => format!("{words}: {}", self.how),
        }
    }
}

/// The relative error from which on an estimate is none.
const BOUND: f64 = 0.3;

/// The way to a target.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TargetSummary {
    /// The relative error asked for.
    pub wanted: f64,
    /// The estimate of that of the run.
    pub achieved: f64,
    /// Whether it is small enough.
    pub reached: bool,
    /// The observed order, at most 2.
    pub order: f64,
    /// The grids in the order in which they were run, coarsest first, the run's own last.
    pub rungs: Vec<RungSummary>,
    /// The outcome in words.
    pub words: String,
}

/// A run on the way to a target.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RungSummary {
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// Steps made.
    pub steps: u64,
    /// Relative difference of phi at the end to the grid before, in the mean square.
    pub difference: Option<f64>,
}

/// Iterations per solve.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Iterations {
    /// Solves made.
    pub solves: usize,
    /// Mean.
    pub mean: f64,
    /// Largest mean over the solves of one step.
    pub max: usize,
}

/// What a solved fluid did.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FlowSummary {
    /// How it was stepped, with the number of steps of each scheme.
    pub scheme: String,
    /// The plan of the pressure solves.
    pub solver: String,
    /// Why this plan.
    pub solver_reason: String,
    /// Projections made, and the solver iterations of each.
    pub projections: Iterations,
    /// Largest max|div u| dt after any projection, with what held velocities force on the fluid.
    pub divergence: f64,
    /// What every projection was to reach.
    pub eta_div: f64,
    /// Projections that rounding kept above it.
    pub at_floor: u64,
    /// Largest mean of div u \[1/s\] over a part of the fluid whose held velocities do not balance; 0 where they do.
    pub imbalance: f64,
    /// Largest max|u_a| dt/h of a step.
    pub courant: f64,
    /// Largest |u| of any step \[m/s\].
    pub speed: f64,
    /// Kinetic energy at the end, ∫ u²/2 \[m^(D+2)/s²\].
    pub energy: f64,
    /// Work of buoyancy and force \[m^(D+2)/s²\].
    pub work: f64,
    /// H_c = |u|/c over the cells at the end; none without waves.
    pub hc: Option<HcSummary>,
}

/// H_c as a field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct HcSummary {
    /// Mean over the fluid cells.
    pub mean: f64,
    /// The largest.
    pub max: f64,
    /// Share of the fluid cells above 1, where the flow is faster than the waves.
    pub above_one: f64,
}

/// Wall seconds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Seconds {
    /// Steps and output.
    pub total: f64,
    /// Steps alone, per step.
    pub per_step: f64,
    /// By phase: `transport`, `diffusion`, `output`; of a solved fluid `advection` and `projection`.
    pub phases: BTreeMap<String, f64>,
}

/// The storage of a solved fluid, where fields are listed.
pub(crate) const FLOW_FIELDS: &str = "flow: velocities, pressure, solver";

/// Storage of one field.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FieldBytes {
    /// Its name.
    pub name: String,
    /// Its size \[bytes\].
    pub bytes: u64,
}

/// The mass budget \[P m^D\].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Mass {
    /// At the start.
    pub start: f64,
    /// At the end.
    pub end: f64,
    /// Added by sources.
    pub emitted: f64,
    /// Left through the walls.
    pub outflow: f64,
    /// (end - start - emitted + outflow) relative to the largest of the sum of |phi|, what was emitted, and the start.
    pub drift: f64,
}

/// Smallest and largest value.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Range {
    /// Field name.
    pub field: String,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

/// The law's regime.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RegimeSummary {
    /// Its name.
    pub name: String,
    /// Wave speed c \[m/s\].
    pub speed: Option<f64>,
    /// H_c = |u|/c.
    pub hc: Option<f64>,
    /// Half angle of the cone \[degrees\].
    pub half_angle: Option<f64>,
}

/// A claim with what was measured.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ClaimResult {
    /// What reports call it.
    pub name: String,
    /// `Paper` or `Ours`.
    pub source: String,
    /// `Must`, `Report` or `KnownFalse`.
    pub kind: String,
    /// Why it is known not to hold.
    pub reason: Option<String>,
    /// What was expected, in words with numbers.
    pub expected: String,
    /// What came out, in words with numbers.
    pub measured: String,
    /// The number compared, where there is one.
    pub value: Option<f64>,
    /// Whether that number depends on the machine and on what else it does.
    pub of_the_machine: bool,
    /// The tolerance, where there is one.
    pub tolerance: Option<f64>,
    /// Whether it holds.
    pub pass: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_that_bound_nothing_are_told_as_such() {
        let words = |embedded, per_step: f64, steps: f64| {
            ErrorSummary { embedded, per_step: Some(per_step), whole_run: Some(per_step * steps), ..Default::default() }
                .words()
        };
        assert_eq!(words(None, 1e-4, 100.0), "error in time about 1.0e-2");
        assert!(words(Some(0.02), 1e-4, 100.0).contains("at most 2.0e-2 a step from its stages"));
        let large = words(Some(14.0), 0.02, 65.0);
        assert!(large.starts_with("a step errs by about 2.0e-2 of phi") && large.contains("bounds nothing"), "{large}");
    }
}
