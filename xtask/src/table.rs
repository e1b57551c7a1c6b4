//! `table`: the paper's Table 2 beside ours, from a run of its scene.

use crate::cli::TableArgs;
use crate::failure::Failure;
use crate::{figure, show};
use cf_linear::Plan;
use cf_output::{Cell, Table};
use cf_scene::summary::RunSummary;
use std::sync::atomic::AtomicBool;

/// A column of the paper's table: figure 5 (a) to (f), 256x512x256 cells, 8 threads of a Xeon Gold 6128, averages of a substep.
struct Printed {
    run: &'static str,
    share: &'static str,
    iterations: f64,
    /// Seconds of transport, of the diffusion, of the velocity's advection, of the projection, and in all.
    seconds: [f64; 5],
}

/// Rows DiffQC and CFluxAU together, TotDiffTime, VA, Projection, TotTime.
const PRINTED: [Printed; 6] = [
    Printed { run: "a", share: "0", iterations: 8.0, seconds: [7.01, 98.93, 4.90, 168.10, 279.52] },
    Printed { run: "b", share: "0.25", iterations: 28.0, seconds: [5.45, 131.06, 4.99, 167.27, 309.36] },
    Printed { run: "c", share: "0.5", iterations: 38.0, seconds: [5.51, 166.99, 4.91, 166.01, 343.98] },
    Printed { run: "d", share: "0.75", iterations: 43.0, seconds: [5.63, 185.66, 4.90, 160.19, 362.96] },
    Printed { run: "e", share: "1", iterations: 45.0, seconds: [5.51, 193.61, 4.88, 164.08, 368.66] },
    Printed { run: "f", share: "Fourier", iterations: 45.0, seconds: [0.59, 196.01, 4.88, 164.55, 366.45] },
];

const CELLS: f64 = 256.0 * 512.0 * 256.0;
const GIGABYTES: f64 = 3.456;
const PHASES: [&str; 4] = ["transport", "diffusion", "advection", "projection"];

/// Runs the scene of the table, prints both, and writes `table2.csv` beside the scene's files.
pub fn table(asked: &TableArgs, stop: &AtomicBool) -> Result<(), Failure> {
    if asked.table != "2" {
        return Err(Failure::usage(format!("there is no table `{}` to run; there is 2", asked.table)));
    }
    let (summary, out) = figure::scene("T2", &asked.options, stop)?;
    let rows: Vec<(&Printed, &RunSummary)> =
        PRINTED.iter().filter_map(|p| Some((p, summary.runs.iter().find(|run| run.name == p.run)?))).collect();
    if let Some((_, run)) = rows.first() {
        say!("\nTable 2: a substep of figure 5 (a) to (f)");
        say!("paper: 256 x 512 x 256 cells, 8 threads; 3.456 GB");
        let memory = summary.runs.iter().map(|run| run.peak_memory).max().unwrap_or(0);
        say!("ours:  {} cells, {} threads; {}", show::cells(&run.cells), run.threads, show::bytes(memory));
        say!("       {}; pressure: {}", run.integrator, pressure(run));
        print(&rows);
    }
    let path = out.join("table2.csv");
    csv(&rows)?.write(&path)?;
    say!("\n{}", path.display());
    figure::verdict(&figure::failures(&summary))
}

fn pressure(run: &RunSummary) -> String {
    run.flow.as_ref().map_or_else(|| "none".into(), |flow| format!("{}, {}", flow.scheme, flow.solver))
}

/// Seconds of a step by [`PHASES`] and in all.
fn seconds(run: &RunSummary) -> [f64; 5] {
    let phase = |i: usize| run.seconds.phases.get(PHASES[i]).copied().unwrap_or(0.0) / run.steps.max(1) as f64;
    [phase(0), phase(1), phase(2), phase(3), run.seconds.per_step]
}

/// How many times less our step takes for a cell.
fn times(printed: &Printed, run: &RunSummary) -> f64 {
    let cells: usize = run.cells.iter().product();
    (printed.seconds[4] / CELLS) / (run.seconds.per_step / cells as f64)
}

/// How a run's diffusion is solved.
fn method(run: &RunSummary) -> Option<Plan> {
    [Plan::Multigrid, Plan::Chebyshev, Plan::Diagonal]
        .into_iter()
        .find(|plan| run.solver.starts_with(&format!("{plan:?}")))
}

/// Passes over the data of a solve of its diffusion.
fn passes(run: &RunSummary, iterations: f64) -> Option<f64> {
    method(run).map(|plan| plan.passes() * iterations)
}

fn print(rows: &[(&Printed, &RunSummary)]) {
    let Some((fourier, own)) = rows.iter().find(|(p, _)| p.run == "f") else { return };
    let both = |paper: f64, ours: f64| format!("{paper:.1} / {ours:.3}");
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|(p, run)| {
            let ours = seconds(run);
            let mut line = vec![
                format!("({}) {}", p.run, p.share),
                format!("{:.0} / {:.1} ({})", p.iterations, run.iterations.mean, run.iterations.max),
                method(run).map_or("-".into(), |plan| format!("{plan:?}")),
                passes(run, run.iterations.mean).map_or("-".into(), |n| format!("{n:.0}")),
                run.flow.as_ref().map_or("-".into(), |f| format!("{:.1} ({})", f.projections.mean, f.projections.max)),
                run.flow
                    .as_ref()
                    .map_or("-".into(), |f| format!("{:.0}", Plan::Multigrid.passes() * f.projections.mean)),
            ];
            line.extend((0..5).map(|i| both(p.seconds[i], ours[i])));
            let diffusion = ours[1] / seconds(own)[1];
            line.push(format!("{:.2} / {diffusion:.2}", p.seconds[1] / fourier.seconds[1]));
            line.push(format!("{:.0}", times(p, run)));
            line
        })
        .collect();
    let heads = [
        "F_T",
        "iterations",
        "method",
        "passes",
        "pressure its",
        "passes",
        "transport s",
        "C-F s",
        "velocity s",
        "projection s",
        "total s",
        "C-F/Fourier",
        "faster per cell",
    ];
    say_part!("\n{}", show::table(&heads, &lines));
    say!(
        "paper / ours; iterations are means of a solve, the most in brackets, to the tolerances of the scene; pressure\n\
         iterations are ours (the paper tells none) and begin at the pressure of the step before; passes are those of a\n\
         solve, a pass being a read or write of one number a cell. Ratios of phases a minute apart carry the load of the machine."
    );
}

fn csv(rows: &[(&Printed, &RunSummary)]) -> Result<Table, Failure> {
    let mut heads = vec!["F_T".to_owned(), "paper iterations".into(), "iterations".into(), "most iterations".into()];
    heads.extend(["method".into(), "passes".into()]);
    heads.extend(["pressure iterations".into(), "most pressure iterations".into(), "pressure passes".into()]);
    for name in PHASES.iter().chain(&["total"]) {
        heads.extend([format!("paper {name} [s]"), format!("{name} [s]")]);
    }
    heads.extend(["paper memory [GB]".into(), "memory [GB]".into(), "cells".into(), "threads".into()]);
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = Table::new(&heads);
    for (p, run) in rows {
        let flow = run.flow.as_ref();
        let mut row: Vec<Cell> = vec![p.share.into(), p.iterations.into(), run.iterations.mean.into()];
        row.push(run.iterations.max.into());
        row.push(method(run).map_or(Cell::Empty, |plan| format!("{plan:?}").into()));
        row.push(passes(run, run.iterations.mean).map_or(Cell::Empty, Cell::from));
        row.push(flow.map_or(Cell::Empty, |f| f.projections.mean.into()));
        row.push(flow.map_or(Cell::Empty, |f| f.projections.max.into()));
        row.push(flow.map_or(Cell::Empty, |f| (Plan::Multigrid.passes() * f.projections.mean).into()));
        for (paper, ours) in p.seconds.iter().zip(seconds(run)) {
            row.extend([Cell::from(*paper), ours.into()]);
        }
        let cells: usize = run.cells.iter().product();
        row.extend([Cell::from(GIGABYTES), (run.peak_memory as f64 / 1e9).into(), cells.into(), run.threads.into()]);
        table.push_slice(&row)?;
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_table_adds_up_as_the_paper_says() {
        // The paper: C-F is up to 5.62 times cheaper in iterations, and never dearer than Fourier's law.
        assert!((PRINTED[5].iterations / PRINTED[0].iterations - 5.62).abs() < 0.01);
        for p in &PRINTED {
            let parts: f64 = p.seconds[..4].iter().sum();
            assert!(parts <= p.seconds[4] + 0.5 && p.seconds[1] <= PRINTED[5].seconds[1], "({}) {parts}", p.run);
        }
    }
}
