//! The command line.

use crate::bench::{Cells, Numbers, Solids, Strength, Tolerance, Walls};
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

const EXIT_CODES: &str = "\
Exit codes: 0 fine, 1 a claim, check or golden failed, 2 bad command line or scene (nothing is written), \
3 numerical failure, 4 input or output, 130 interrupted.";

const BENCH_EXAMPLES: &str = "\
Examples:
  cargo xtask bench solver --json bench.json
  cargo xtask bench fluid
  cargo xtask bench solver --cells 97x61x45 --walls valued --kappa 10,1e5 --threads 1
  cargo xtask bench solver --cells 128x128x128 --tolerance 1e-6 --peers";

const TRADEOFF_EXAMPLES: &str = "\
Examples:
  cargo xtask tradeoff --problem P1 --quick --target-error 1e-2
  cargo xtask tradeoff scenes/fig03_cones.ron --preset draft
  cargo xtask tradeoff --peers";

/// Diffusion at a finite speed: figures, scenes, checks and measurements.
#[derive(Parser, Debug)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version, after_help = EXIT_CODES)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Subcommand, Debug)]
pub enum Command {
    /// Every figure: what it shows, its sizes, the memory and time they are predicted to take.
    #[command(after_help = "Example: cargo xtask list")]
    List,
    /// Runs the scenes of a figure, writes fields, pictures and a report, and checks its claims.
    #[command(after_help = "Example: cargo xtask figure 3 --preset draft --set hc_2:model.law.k=0.2")]
    Figure(FigureArgs),
    /// Runs the scene of a table of the paper and prints the paper's numbers beside ours.
    #[command(after_help = "Example: cargo xtask table 2 --preset draft")]
    Table(TableArgs),
    /// Runs a scene of your own.
    #[command(after_help = "Example: cargo xtask run my.ron --out out/first --set 'grid.cells=(128, 128)'")]
    Run(RunArgs),
    /// Checks a scene and prints the plan of every run, without running anything.
    #[command(after_help = "Example: cargo xtask check scenes/fig03_cones.ron --preset paper")]
    Check(CheckArgs),
    /// Compares the solvers with exact solutions and with their own promises: order, mass, iterations, stability.
    #[command(after_help = "Example: cargo xtask verify --extremes --cases 2000 --seed 7")]
    Verify(VerifyArgs),
    /// Runs every scene at a small size and compares its numbers with the stored ones.
    #[command(after_help = "Example: cargo xtask regress")]
    Regress(RegressArgs),
    /// Measures this machine's memory and the kernels against it.
    #[command(after_help = BENCH_EXAMPLES)]
    Bench(BenchArgs),
    /// Measures what accuracy costs: error against wall time of every integrator, on problems with a known solution or on
    /// a scene.
    #[command(after_help = TRADEOFF_EXAMPLES)]
    Tradeoff(TradeoffArgs),
}

/// `figure`.
#[derive(Args, Debug)]
pub struct FigureArgs {
    /// Number in the paper (3, A) or name of a scene (fig03_cones).
    pub figure: String,
    /// How to run it.
    #[command(flatten)]
    pub options: RunOptions,
}

/// `table`.
#[derive(Args, Debug)]
pub struct TableArgs {
    /// Number in the paper: 2.
    pub table: String,
    /// How to run its scene.
    #[command(flatten)]
    pub options: RunOptions,
}

/// `run`.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// The scene file.
    pub scene: PathBuf,
    /// How to run it.
    #[command(flatten)]
    pub options: RunOptions,
}

/// Options of every command that runs scenes for their results.
#[derive(Args, Debug, Default)]
pub struct RunOptions {
    /// What to change in the scene.
    #[command(flatten)]
    pub scene: SceneOptions,
    /// Where to write; out/<scene> unless given.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Worker threads; as many as the machine has unless given. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Go on from the checkpoint in the output folder.
    #[arg(long)]
    pub resume: bool,
    /// Print errors only.
    #[arg(long, short)]
    pub quiet: bool,
}

/// Options that choose what a scene means.
#[derive(Args, Debug, Default)]
pub struct SceneOptions {
    /// The size: draft, standard or paper, as the scene's own table says.
    #[arg(long, default_value = "standard")]
    pub preset: String,
    /// Overrides a value of the scene, for every run or for one: model.law.k=0.25, hc_2:model.law.k=0.25.
    #[arg(long = "set", value_name = "[RUN:]PATH=VALUE")]
    pub sets: Vec<String>,
}

/// `check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// A scene file, or the number or name of a figure.
    pub scene: String,
    /// What to change in it.
    #[command(flatten)]
    pub options: SceneOptions,
    /// Leave out the table of sizes and levels, for which the steps of each are measured.
    #[arg(long)]
    pub brief: bool,
}

/// `verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Drawn parameters over the whole range a computer can hold, besides the tables.
    #[arg(long)]
    pub extremes: bool,
    /// How many to draw: 500 in a minute, 20000 at night.
    #[arg(long = "cases", alias = "count", value_name = "N", default_value_t = 1000, requires = "extremes")]
    pub cases: usize,
    /// Where the drawing starts; the same seed draws the same.
    #[arg(long, value_name = "S", default_value_t = 1, requires = "extremes")]
    pub seed: u64,
    /// Only the tables whose name contains this; with --extremes also corners of that name.
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
    /// One case of the corner --only again, by the seed that its line gives.
    #[arg(long, value_name = "SEED", requires = "only", value_parser = seed)]
    pub repeat: Option<u64>,
}

/// A seed as it is printed, 0x..., or in decimals.
fn seed(text: &str) -> Result<u64, std::num::ParseIntError> {
    text.strip_prefix("0x").map_or_else(|| text.parse(), |digits| u64::from_str_radix(digits, 16))
}

/// `regress`.
#[derive(Args, Debug, Default)]
pub struct RegressArgs {
    /// Store the new numbers instead of comparing.
    #[arg(long)]
    pub bless: bool,
    /// Only the scenes whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub only: Option<String>,
}

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Bench {
    /// Memory bandwidth.
    Stream,
    /// Elliptic solves.
    Solver,
    /// Whole diffusion steps.
    Step,
    /// Transport, projection and whole steps of a fluid.
    Fluid,
    /// All of them.
    All,
}

/// `bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// What to measure; the memory bandwidth is always measured along.
    #[arg(value_enum, default_value = "all")]
    pub what: Bench,
    /// Also write the numbers to this file.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// What to solve.
    #[command(flatten)]
    pub solver: SolverArgs,
}

/// What `bench solver` solves. Without these, one axis at a time is varied around 256x256x256, closed, poisson, 1e-6, f64,
/// all threads; an axis given here takes its values, the others stay there.
#[derive(Args, Debug, Default, PartialEq)]
#[command(next_help_heading = "Solves")]
pub struct SolverArgs {
    /// Every combination of sizes, walls, kappa, tolerances, precisions and threads: hours.
    #[arg(long)]
    pub all: bool,
    /// Sizes: 1024x1024,128x128x128.
    #[arg(long, value_name = "NxNxN", value_delimiter = ',')]
    pub cells: Vec<Cells>,
    /// What all sides of the box are.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub walls: Vec<Walls>,
    /// Obstacles; open where there are none.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub solids: Vec<Solids>,
    /// beta/h² beside alpha = 1, or poisson for alpha = 0.
    #[arg(long, value_name = "KAPPA|poisson", value_delimiter = ',')]
    pub kappa: Vec<Strength>,
    /// Residual relative to the right-hand side, in the 2-norm.
    #[arg(long, value_name = "TOLERANCE", value_delimiter = ',')]
    pub tolerance: Vec<Tolerance>,
    /// Numbers: f64, f32, or f64 with a preconditioner in f32 (mixed).
    #[arg(long, value_enum, value_delimiter = ',')]
    pub precision: Vec<Numbers>,
    /// Worker threads.
    #[arg(long, value_name = "N", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Vec<u16>,
    /// Times each solve is made at least; the median counts. 3 unless given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub runs: Option<u16>,
    /// Also each sweep of a solve alone, beside the passes that docs/solver.md counts.
    #[arg(long)]
    pub kernels: bool,
    /// In turn with hypre's PFMG: 128x128x128 and 256x256x256, both tolerances, 1 and all threads, unless given.
    #[arg(long)]
    pub peers: bool,
    /// The compiler for the peers; mpicc unless given.
    #[arg(long, value_name = "PROGRAM", requires = "peers")]
    pub mpicc: Option<PathBuf>,
}

impl SolverArgs {
    /// Whether any axis of the problems is given.
    pub fn fixes_an_axis(&self) -> bool {
        let SolverArgs { cells, walls, solids, kappa, tolerance, precision, threads, .. } = self;
        ![cells.len(), walls.len(), solids.len(), kappa.len(), tolerance.len(), precision.len(), threads.len()]
            .iter()
            .all(|&n| n == 0)
    }
}

/// The problems of `tradeoff`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Canonical {
    /// A Gaussian spreads in a box, F_T of 0, 0.1 and 1.
    #[value(name = "P1", alias = "p1")]
    P1,
    /// A jump moves on as a front, F_T = 0: a step in one dimension, a disc in two.
    #[value(name = "P2", alias = "p2")]
    P2,
    /// A steady source in a uniform flow, slower and faster than its waves.
    #[value(name = "P3", alias = "p3")]
    P3,
    /// A flow that deforms and returns, with and without diffusion.
    #[value(name = "P4", alias = "p4")]
    P4,
    /// Vortices in a stream: a fluid alone, by each of its schemes.
    #[value(name = "P5", alias = "p5")]
    P5,
    /// All of them.
    #[value(name = "all")]
    All,
}

/// `tradeoff`.
#[derive(Args, Debug)]
pub struct TradeoffArgs {
    /// A scene file, or the number or name of a figure, instead of the problems with known solutions; its reference is its
    /// own tightest run, whose error three grids tell.
    #[arg(value_name = "SCENE", conflicts_with_all = ["problem", "peers", "numbers"])]
    pub scene: Option<String>,
    /// What to change in the scene.
    #[command(flatten)]
    pub options: SceneOptions,
    /// Which problem.
    #[arg(long, value_enum, default_value = "all")]
    pub problem: Canonical,
    /// Smaller grids, fewer settings: about a minute.
    #[arg(long)]
    pub quick: bool,
    /// Print the cheapest setting whose relative error is at most this.
    #[arg(long, value_name = "E", value_parser = positive)]
    pub target_error: Option<f64>,
    /// Compare with py-pde, FiPy and a plain NumPy leapfrog on the telegraph equation, in an environment of their own.
    #[arg(long, conflicts_with = "numbers")]
    pub peers: bool,
    /// Compare f32 with f64 on every run of figures 3 and 4.
    #[arg(long)]
    pub numbers: bool,
    /// Where to write; out/tradeoff unless given.
    #[arg(long, value_name = "DIR", default_value = "out/tradeoff")]
    pub out: PathBuf,
    /// Also write the tables for docs/tradeoff into this folder.
    #[arg(long, value_name = "DIR")]
    pub docs: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("expected a number, found `{text}`"))?;
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(format!("expected a number above 0, found {value}")) }
}
