//! `bench`: kernels against the memory bandwidth of this machine, measured in the same run.
//!
//! A pass is one read or write of one array of the grid's size. Time × bandwidth / (bytes of an array) is the number of
//! passes a kernel cost; what it must read and write at least is a fact of the method, so the ratio says how well it runs.
//!
//! `problem` says what is solved, `cases` which problems, `solver` solves one, `peers` does so in turn with `hypre`, `step`
//! makes whole diffusion steps, `fluid` moves fluid, `stream` measures the memory, `table` prints and writes.

mod cases;
mod fluid;
mod hypre;
mod peers;
mod problem;
mod solver;
mod step;
pub(crate) mod stream;
mod table;
pub(crate) mod timing;

use crate::cli::{Bench, BenchArgs, SolverArgs};
use crate::failure::{Exit, Failure};
use crate::pool;
use cf_linear::Kernel;
use cf_scene::Limits;
use peers::Comparison;
use problem::Problem;
use serde_json::{Value, json};
use solver::Measured;
use std::sync::atomic::{AtomicBool, Ordering};
use stream::Bandwidth;

pub use problem::{Cells, Numbers, Solids, Strength, Tolerance, Walls};

/// Measures and prints; ends after the measurement at hand when `stop` becomes true.
pub fn bench(asked: &BenchArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let wants = |what: Bench| asked.what == what || asked.what == Bench::All;
    if !wants(Bench::Solver) && asked.solver != SolverArgs::default() {
        return Err(Failure::usage(
            "sizes, walls, kappa, runs and peers are those of solves: cargo xtask bench solver",
        ));
    }
    if let Some(path) = &asked.json
        && path.exists()
        && !path.is_file()
    {
        return Err(Failure::usage(format!(
            "--json {}: expected the name of a file to write, found something else; nothing was measured",
            path.display()
        )));
    }
    let threads = pool::threads(None);
    let work = if wants(Bench::Solver) { Work::new(&asked.solver, threads)? } else { Work::default() };
    let mut bandwidth = Bandwidth::measure(&work.threads(threads))?;
    let solves = work.run(stop);
    let steps = match wants(Bench::Step) && !stop.load(Ordering::Relaxed) {
        true => pool::within(threads, step::steps)??,
        false => Vec::new(),
    };
    let flows = match wants(Bench::Fluid) {
        true => fluid::measure(&fluid::SIZES, threads, stop)?,
        false => Vec::new(),
    };
    bandwidth.again()?;
    bandwidth.print();
    let rows = solves.rows();
    if !rows.is_empty() {
        table::print(&rows, &bandwidth);
    }
    for (problem, kernels) in &solves.kernels {
        table::print_kernels(problem, kernels, &bandwidth);
    }
    if !solves.comparisons.is_empty() {
        table::print_comparisons(&solves.comparisons);
    }
    if !steps.is_empty() {
        step::print(&steps, threads, &bandwidth);
    }
    if !flows.is_empty() {
        fluid::print(&flows, &bandwidth);
    }
    if let Some(path) = &asked.json {
        let kernels = [step::document(&steps, threads, &bandwidth), fluid::document(&flows, &bandwidth)].concat();
        let document = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "stream": bandwidth.document(),
            "rows": rows.iter().map(|row| table::row(row, &bandwidth)).collect::<Vec<Value>>(),
            "comparisons": solves.comparisons.iter().map(table::comparison).collect::<Vec<Value>>(),
            "sweeps": solves.kernels.iter().map(|(problem, of)| table::kernels(problem, of, &bandwidth)).collect::<Vec<Value>>(),
            "skipped": work.skipped,
            "kernels": kernels,
        });
        let text = serde_json::to_string_pretty(&document).map_err(|error| Failure::io(error.to_string()))?;
        cf_output::write_text(path, &(text + "\n"))?;
        say!("\nwritten to {}", path.display());
    }
    match solves.failures.first() {
        Some(&exit) => Err(Failure::Words(exit, format!("not solved as they should be: {}", solves.failures.len()))),
        None if stop.load(Ordering::Relaxed) => {
            Err(Failure::Words(Exit::Interrupted, "stopped before all was measured".into()))
        }
        None => Ok(()),
    }
}

/// What is to be solved.
#[derive(Default)]
struct Work {
    alone: Vec<Problem>,
    in_turn: Vec<Problem>,
    peer: Option<hypre::Hypre>,
    skipped: Vec<String>,
    runs: usize,
    kernels: bool,
}

/// What was solved, and what went wrong; the others went on.
#[derive(Default)]
struct Solves {
    alone: Vec<Measured>,
    comparisons: Vec<Comparison>,
    kernels: Vec<(Problem, Vec<Kernel>)>,
    failures: Vec<Exit>,
}

impl Work {
    fn new(asked: &SolverArgs, threads: usize) -> Result<Self, Failure> {
        let mut work = Work {
            runs: asked.runs.unwrap_or(3).into(),
            alone: cases::ours(asked, threads),
            kernels: asked.kernels,
            ..Work::default()
        };
        if asked.peers {
            match peers::prepare(asked)? {
                Ok(hypre) => {
                    work.peer = Some(hypre);
                    work.in_turn = cases::peers(asked, threads);
                    work.alone.retain(|problem| !work.in_turn.contains(problem));
                }
                Err(missing) => {
                    say!("SKIPPED: {}", missing.0);
                    work.skipped.push(missing.0);
                }
            }
        }
        let mut problems = work.alone.iter().chain(&work.in_turn).peekable();
        if problems.peek().is_none() {
            return Err(Failure::usage("nothing to solve: single precision does not resolve this tolerance"));
        }
        problems.try_for_each(fits)?;
        Ok(work)
    }

    /// Every number of threads the bandwidth is wanted for, 1 and all among them.
    fn threads(&self, all: usize) -> Vec<usize> {
        let used = self.alone.iter().chain(&self.in_turn).map(|problem| problem.threads);
        let mut counts: Vec<usize> = used.chain([1, all]).collect();
        counts.sort_unstable();
        counts.dedup();
        counts
    }

    fn run(&self, stop: &AtomicBool) -> Solves {
        let mut solves = Solves::default();
        let count = self.alone.len() + self.in_turn.len();
        for (i, problem) in self.alone.iter().chain(&self.in_turn).enumerate() {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            complain!("{}/{count}: {problem}", i + 1);
            let outcome = match &self.peer {
                Some(hypre) if i >= self.alone.len() => {
                    peers::compare(hypre, problem, self.runs).and_then(|(ours, theirs)| match theirs {
                        Ok(theirs) => {
                            let compared = Comparison { ours, theirs };
                            let checked = compared.check();
                            solves.comparisons.push(compared);
                            checked
                        }
                        Err(failure) => {
                            solves.alone.push(ours);
                            Err(failure)
                        }
                    })
                }
                _ => solver::measure(problem, self.runs).and_then(|measured| {
                    let checked = measured.check();
                    solves.alone.push(measured);
                    checked
                }),
            };
            let outcome = outcome.and_then(|()| {
                if self.kernels {
                    solves.kernels.push((problem.clone(), solver::turn(problem, RUNS_OF_A_SWEEP)?.kernels));
                }
                Ok(())
            });
            // Whoever asks for a stop may have stopped the peer as well.
            if let Err(failure) = outcome
                && !stop.load(Ordering::Relaxed)
            {
                solves.failures.push(failure.report());
            }
        }
        solves
    }
}

impl Solves {
    fn rows(&self) -> Vec<&Measured> {
        let compared = self.comparisons.iter().flat_map(|compared| [&compared.ours, &compared.theirs]);
        self.alone.iter().chain(compared).collect()
    }
}

/// Sweeps are short beside what disturbs them.
const RUNS_OF_A_SWEEP: usize = 7;

/// Refuses what this machine has no memory for.
fn fits(problem: &Problem) -> Result<(), Failure> {
    /// More than any of the methods takes.
    const BYTES_PER_CELL: usize = 200;
    let (needs, has) = (problem.cells.count().saturating_mul(BYTES_PER_CELL) as u64, Limits::of_this_machine().memory);
    if needs <= has {
        return Ok(());
    }
    let [needs, has] = [needs, has].map(crate::show::bytes);
    Err(Failure::usage(format!("{problem}: needs about {needs}, the machine has {has}")))
}

/// What went wrong in the numbers, as a failure.
pub(crate) fn numerical(error: impl std::fmt::Display) -> Failure {
    Failure::Words(Exit::Numerical, error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::path::Path;

    fn run(arguments: &[&str]) -> Exit {
        crate::main_with(["xtask", "bench"].iter().chain(arguments), &AtomicBool::new(false))
    }

    #[test]
    fn rows_have_the_keys_that_are_promised() {
        let file = peers::folder().join("rows.json");
        let path = file.to_string_lossy();
        let tiny = ["solver", "--cells", "16x16,8x8x8", "--precision", "f64,mixed,f32", "--kappa", "0.1,10,poisson"];
        assert_eq!(run(&[&tiny[..], &["--runs", "1", "--json", &path]].concat()), Exit::Fine);
        let document: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let rows = document["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 2 * 3 * 3);
        let promised = [
            "dimension",
            "cells",
            "walls",
            "solids",
            "kappa",
            "tolerance",
            "precision",
            "threads",
            "method",
            "iterations",
            "seconds",
            "passes_per_iteration",
            "bytes_per_cell",
            "setup_seconds",
            "residual",
            "status",
        ];
        for row in rows {
            let keys: BTreeSet<&str> = row.as_object().unwrap().keys().map(String::as_str).collect();
            assert!(promised.iter().all(|key| keys.contains(key) && !row[*key].is_null()), "{row:#}");
            let large = row["kappa"] != json!(0.1);
            assert_eq!(row["method"], json!(if large { "cf Multigrid" } else { "cf Chebyshev" }), "{row:#}");
        }
        assert!(document["stream"][0]["bytes_per_second"].as_f64().unwrap() > 1e8);
    }

    #[test]
    fn sweeps_and_obstacles_have_rows_of_their_own() {
        let file = peers::folder().join("sweeps.json");
        let path = file.to_string_lossy();
        let line =
            ["solver", "--cells", "16x16x16", "--solids", "open,random,ball,wall,maze", "--precision", "f64,mixed,f32"];
        assert_eq!(run(&[&line[..], &["--kernels", "--runs", "1", "--json", &path]].concat()), Exit::Fine);
        let document: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        assert_eq!(document["rows"].as_array().map(Vec::len), Some(5 * 3));
        for row in document["rows"].as_array().unwrap() {
            assert!(row["solids"] == json!("open") || row["iterations"].as_u64().unwrap() >= 3, "{row:#}");
        }
        let sweeps = document["sweeps"].as_array().unwrap();
        assert_eq!(sweeps.len(), 5 * 3);
        // As docs/solver.md has it: 10.7 passes an iteration.
        let sum = |sweeps: &Value| -> f64 {
            let sweeps = sweeps["sweeps"].as_array().unwrap();
            let number = |sweep: &Value, key: &str| sweep[key].as_f64().unwrap();
            sweeps.iter().map(|sweep| number(sweep, "per_iteration") * number(sweep, "model_passes")).sum()
        };
        assert!((sum(&sweeps[0]) - 10.71).abs() < 0.01, "{:#}", sweeps[0]);
        assert!((sum(&sweeps[1]) - 9.36).abs() < 0.01, "{:#}", sweeps[1]);
    }

    #[test]
    fn residuals_are_judged_and_no_number_is_missing() {
        let file = peers::folder().join("residuals.json");
        let path = file.to_string_lossy();
        let line =
            ["solver", "--cells", "1x1,32x32", "--precision", "f64,f32", "--kappa", "1e5,poisson", "--runs", "1"];
        assert_eq!(run(&[&line[..], &["--walls", "valued", "--json", &path]].concat()), Exit::Fine);
        let document: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        for row in document["rows"].as_array().unwrap() {
            let (residual, status) = (row["residual"].as_f64().unwrap(), row["status"].as_str().unwrap());
            assert_eq!(status, if residual <= 2e-6 { "met" } else { "rounding" }, "{row:#}");
            assert!(residual <= 2e-6 || row["precision"] == json!("f32"), "{row:#}");
        }
        let line = ["solver", "--cells", "1x1", "--kappa", "poisson", "--runs", "1", "--json", &path];
        assert_eq!(run(&line), Exit::Fine);
        let document: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        assert_eq!(document["rows"][0]["residual"], json!(0.0));
    }

    #[test]
    fn a_missing_peer_is_skipped_and_the_rest_goes_on() {
        let file = peers::folder().join("skipped.json");
        let path = file.to_string_lossy();
        let line =
            ["solver", "--cells", "8x8", "--runs", "1", "--peers", "--mpicc", "no-such-compiler", "--json", &path];
        assert_eq!(run(&line), Exit::Fine);
        let document: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        assert!(document["skipped"][0].as_str().unwrap().contains("apt-get install libhypre-dev"), "{document:#}");
        assert_eq!(document["rows"].as_array().map(Vec::len), Some(1));
    }

    #[test]
    fn what_makes_no_sense_is_refused_before_anything_is_measured() {
        let lines: [&[&str]; 11] = [
            &["solver", "--cells", "8x0"],
            &["solver", "--cells", "1000000x1000000x1000000"],
            &["solver", "--cells", "9999999999x9999999999x9999999999"],
            &["solver", "--walls", "open"],
            &["solver", "--kappa", "-1"],
            &["solver", "--tolerance", "2"],
            &["solver", "--threads", "0"],
            &["solver", "--precision", "f32", "--tolerance", "1e-10"],
            &["solver", "--mpicc", "cc"],
            &["step", "--cells", "8x8"],
            &["fluid", "--walls", "closed"],
        ];
        for line in lines {
            let file = peers::folder().join("refused.json");
            assert_eq!(run(&[line, &["--json", &file.to_string_lossy()]].concat()), Exit::BadInput, "{line:?}");
            assert!(!Path::new(&file).exists(), "{line:?}");
        }
    }

    #[test]
    fn a_stop_leaves_what_was_measured() {
        for line in [&["solver", "--cells", "8x8", "--runs", "1"][..], &["fluid"]] {
            let line = ["xtask", "bench"].iter().chain(line);
            assert_eq!(crate::main_with(line, &AtomicBool::new(true)), Exit::Interrupted);
        }
    }
}
