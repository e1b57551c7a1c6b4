//! What was measured, for people and for programs.

use super::peers::Comparison;
use super::problem::{Problem, Strength};
use super::solver::Measured;
use super::stream::Bandwidth;
use crate::show;
use cf_linear::Kernel;
use serde_json::{Value, json};

/// What a method cost, from the medians of its turns.
struct Cost {
    seconds: f64,
    setup: f64,
    new: f64,
    per_iteration: f64,
    passes: f64,
    bytes_per_cell: f64,
}

impl Cost {
    fn of(measured: &Measured, bandwidth: &Bandwidth) -> Self {
        let problem = &measured.problem;
        let cells = problem.cells.count() as f64;
        let seconds = measured.median(|turn| turn.seconds);
        let per_iteration = seconds / measured.iterations().max(1) as f64;
        Cost {
            seconds,
            setup: measured.median(|turn| turn.setup_seconds),
            new: measured.median(|turn| turn.new_seconds),
            per_iteration,
            passes: per_iteration * bandwidth.with(problem.threads) / (cells * problem.bytes() as f64),
            bytes_per_cell: measured.median(|turn| turn.bytes) / cells,
        }
    }
}

/// The columns that say what was solved.
const PROBLEM: [&str; 7] = ["cells", "walls", "solids", "kappa", "to", "numbers", "threads"];

fn problem(problem: &Problem) -> Vec<String> {
    let Problem { cells, walls, solids, strength, tolerance, numbers, threads } = problem;
    [cells as &dyn ToString, walls, solids, strength, tolerance, numbers, threads]
        .map(|entry| entry.to_string())
        .to_vec()
}

/// A line for each method and problem, and why the plan where it was not given.
pub fn print(rows: &[&Measured], bandwidth: &Bandwidth) {
    let costs = [
        "method",
        "iterations",
        "residual",
        "ended",
        "ms",
        "ms/iteration",
        "passes/iteration",
        "B/cell",
        "set-up ms",
        "new ms",
        "runs",
    ];
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|measured| {
            let cost = Cost::of(measured, bandwidth);
            let mut line = problem(&measured.problem);
            line.extend([
                measured.method.clone(),
                measured.iterations().to_string(),
                format!("{:.1e}", measured.median(|turn| turn.residual)),
                measured.status().to_string(),
                format!("{:.2}", 1e3 * cost.seconds),
                format!("{:.2}", 1e3 * cost.per_iteration),
                format!("{:.1}", cost.passes),
                format!("{:.1}", cost.bytes_per_cell),
                format!("{:.2}", 1e3 * cost.setup),
                format!("{:.2}", 1e3 * cost.new),
                measured.turns.len().to_string(),
            ]);
            line
        })
        .collect();
    say!("\nSolves, medians");
    say_part!("{}", show::table(&[&PROBLEM[..], &costs].concat(), &lines));
    for measured in rows {
        let small =
            matches!(measured.problem.strength, Strength::Kappa(kappa) if kappa < super::solver::MULTIGRID_FROM);
        if let (true, Some(plan)) = (small, measured.turns.iter().find_map(|turn| turn.plan.as_ref())) {
            say!("{}: {plan}", measured.problem);
        }
    }
    say!("\nResidual: |b - A x|/|b| formed anew; ended: the tolerance was met, or rounding leaves more than that.");
    say!("A pass reads or writes one array of the grid's size once, at the stream bandwidth of as many threads.");
    say!("New: what the first iteration took longer than later ones, because the system had to hand out the memory.");
}

/// A line for each problem: how much longer theirs took, and that both solved the same.
pub fn print_comparisons(comparisons: &[Comparison]) {
    let heads = ["hypre/ours", "with set-up", "|x| ours", "|x| hypre", "residual ours", "residual hypre"];
    let lines: Vec<Vec<String>> = comparisons
        .iter()
        .map(|compared| {
            let mut line = problem(&compared.ours.problem);
            line.extend([compared.ratio(), compared.ratio_with_setup()].map(|ratio| format!("{ratio:.2}")));
            let both = [&compared.ours, &compared.theirs];
            line.extend(both.map(|measured| format!("{:.9e}", measured.median(|turn| turn.norm))));
            line.extend(both.map(|measured| format!("{:.1e}", measured.median(|turn| turn.residual))));
            line
        })
        .collect();
    say!("\nIn turn with hypre: its median time over ours, the 2-norm of x without its mean, |b - A x|/|b|");
    say_part!("{}", show::table(&[&PROBLEM[..], &heads].concat(), &lines));
}

/// A solve for `--json`.
pub fn row(measured: &Measured, bandwidth: &Bandwidth) -> Value {
    let cost = Cost::of(measured, bandwidth);
    let Problem { cells, walls, solids, strength, tolerance, numbers, threads } = &measured.problem;
    json!({
        "dimension": cells.0.len(),
        "cells": cells.0,
        "walls": walls.to_string(),
        "solids": solids.to_string(),
        "kappa": match strength {
            Strength::Kappa(kappa) => json!(kappa),
            Strength::Poisson => json!("poisson"),
        },
        "alpha": measured.problem.coefficients().0,
        "tolerance": tolerance.0,
        "precision": numbers.to_string(),
        "threads": threads,
        "method": measured.method,
        "plan": measured.turns.iter().find_map(|turn| turn.plan.as_ref()),
        "iterations": measured.iterations(),
        "runs": measured.turns.len(),
        "seconds": cost.seconds,
        "best_seconds": measured.turns.iter().map(|turn| turn.seconds).fold(f64::INFINITY, f64::min),
        "seconds_per_iteration": cost.per_iteration,
        "passes_per_iteration": cost.passes,
        "bytes_per_cell": cost.bytes_per_cell,
        "setup_seconds": cost.setup,
        "new_memory_seconds": cost.new,
        "residual": measured.median(|turn| turn.residual),
        "status": measured.status().to_string(),
        "norm": measured.median(|turn| turn.norm),
    })
}

/// The sweeps of a solve beside the model, and what an iteration of them comes to.
pub fn print_kernels(problem: &Problem, kernels: &[Kernel], bandwidth: &Bandwidth) {
    let array = (problem.cells.count() * problem.bytes()) as f64;
    let passes = |seconds: f64| seconds * bandwidth.with(problem.threads) / array;
    let line = |name: &str, times: String, model: f64, seconds: f64| {
        let model = if model.is_nan() { "-".to_owned() } else { format!("{model:.2}") };
        vec![name.to_owned(), times, model, format!("{:.2}", passes(seconds)), format!("{:.2}", 1e3 * seconds)]
    };
    let mut lines: Vec<_> = kernels
        .iter()
        .map(|kernel| {
            let times = if kernel.per_iteration > 0.0 { kernel.per_iteration.to_string() } else { "once".to_owned() };
            line(kernel.name, times, kernel.passes, kernel.seconds)
        })
        .collect();
    let sum = |of: fn(&Kernel) -> f64| kernels.iter().map(|kernel| kernel.per_iteration * of(kernel)).sum();
    let model = kernels.iter().filter(|kernel| kernel.per_iteration > 0.0).map(|k| k.per_iteration * k.passes).sum();
    lines.push(line("an iteration", "1".into(), model, sum(|kernel| kernel.seconds)));
    say!("\nSweeps of {problem}, each alone, the best of its runs");
    say_part!("{}", show::table(&["sweep", "per iteration", "passes, model", "measured", "ms"], &lines));
}

/// The same for `--json`.
pub fn kernels(problem: &Problem, kernels: &[Kernel], bandwidth: &Bandwidth) -> Value {
    let array = (problem.cells.count() * problem.bytes()) as f64;
    let sweep = |kernel: &Kernel| {
        json!({
            "sweep": kernel.name,
            "per_iteration": kernel.per_iteration,
            "model_passes": kernel.passes.is_finite().then_some(kernel.passes),
            "passes": kernel.seconds * bandwidth.with(problem.threads) / array,
            "seconds": kernel.seconds,
        })
    };
    json!({ "problem": problem.to_string(), "sweeps": kernels.iter().map(sweep).collect::<Vec<_>>() })
}

/// A comparison for `--json`; its two rows are among the others.
pub fn comparison(compared: &Comparison) -> Value {
    let Problem { cells, walls, strength, tolerance, threads, .. } = &compared.ours.problem;
    json!({
        "cells": cells.0,
        "walls": walls.to_string(),
        "kappa": strength.to_string(),
        "tolerance": tolerance.0,
        "threads": threads,
        "peer": compared.theirs.method,
        "ratio": compared.ratio(),
        "ratio_with_setup": compared.ratio_with_setup(),
        "norm_difference": compared.apart(),
    })
}
