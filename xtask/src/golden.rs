//! The numbers of a run that are stored: counts, budgets, extremes, norms, probes, and what the claims measured.

use crate::compare::Line;
use crate::failure::Failure;
use cf_output::{ReadArray, read_image};
use cf_scene::summary::{RunSummary, Summary};
use std::path::Path;

/// Relative tolerance by precision.
fn tolerance(precision: &str) -> f64 {
    if precision == "f32" { 1e-4 } else { 1e-9 }
}

/// All lines of an outcome; fields are read back from `folder`.
pub fn lines(summary: &Summary, folder: &Path) -> Result<Vec<Line>, Failure> {
    let mut lines = Vec::new();
    for run in &summary.runs {
        lines.extend(run_lines(run, folder)?);
    }
    let loosest = summary.runs.iter().map(|run| tolerance(&run.precision)).fold(1e-9, f64::max);
    for claim in &summary.claims {
        if let Some(value) = claim.value.filter(|_| !claim.of_the_machine) {
            // Claims compare runs with each other, which costs digits.
            lines.push(Line::near("claim", &claim.name, value, 100.0 * loosest * value.abs().max(1.0)));
        }
    }
    Ok(lines)
}

fn run_lines(run: &RunSummary, folder: &Path) -> Result<Vec<Line>, Failure> {
    let name = &run.name;
    let relative = tolerance(&run.precision);
    let size = run.ranges.iter().find(|range| range.field == "phi").map_or(1.0, |r| r.min.abs().max(r.max.abs()));
    let near = |key: &str, value: f64, size: f64| Line::near(name, key, value, relative * value.abs().max(size));
    let count = |key: &str, value: f64| Line { allowed: 1.0, ..Line::near(name, key, value, 1.0) };
    let cells: Vec<String> = run.cells.iter().map(ToString::to_string).collect();
    let mut lines = vec![
        Line::exact(name, "cells", cells.join("x")),
        Line::exact(name, "precision", &run.precision),
        Line::exact(name, "integrator", run.integrator.split_whitespace().next().unwrap_or("-")),
        Line::exact(name, "steps", run.steps),
        Line::exact(name, "solves", run.iterations.solves),
        count("iterations.mean", run.iterations.mean),
        count("iterations.max", run.iterations.max as f64),
        near("time", run.time, 0.0),
        near("mass.end", run.mass.end, run.mass.emitted.abs()),
        near("mass.emitted", run.mass.emitted, 0.0),
        near("mass.outflow", run.mass.outflow, run.mass.emitted.abs()),
    ];
    for range in &run.ranges {
        let size = if range.field == "phi" { size } else { range.min.abs().max(range.max.abs()) };
        lines.push(near(&format!("{}.min", range.field), range.min, size));
        lines.push(near(&format!("{}.max", range.field), range.max, size));
    }
    let last = run.files.iter().filter(|file| file.ends_with(".vti")).max();
    if let Some(file) = last {
        let image = read_image(&folder.join(file))?;
        for array in image.arrays.iter().filter(|array| array.name == "phi") {
            lines.extend(norms(name, array, cells_of(&image.extent), relative, size));
        }
    }
    Ok(lines)
}

fn cells_of(extent: &[usize; 6]) -> [usize; 3] {
    [0, 2, 4].map(|axis| extent[axis + 1].saturating_sub(extent[axis]))
}

/// Mean magnitude, root mean square and a few cells, spread over the box.
fn norms(run: &str, array: &ReadArray, cells: [usize; 3], relative: f64, size: f64) -> Vec<Line> {
    let values = &array.values;
    let count = values.len().max(1) as f64;
    let one = values.iter().map(|v| v.abs()).sum::<f64>() / count;
    let two = (values.iter().map(|v| v * v).sum::<f64>() / count).sqrt();
    let mut lines =
        vec![Line::near(run, "phi.L1", one, relative * one), Line::near(run, "phi.L2", two, relative * two)];
    for eighths in [[2, 2], [4, 3], [4, 5], [6, 6]] {
        let at = |axis: usize| cells[axis] * eighths.get(axis).copied().unwrap_or(4) / 8;
        let (i, j, k) = (at(0), at(1).min(cells[1].saturating_sub(1)), at(2).min(cells[2].saturating_sub(1)));
        let cell = i + cells[0] * (j + cells[1] * k);
        if let Some(&value) = values.get(cell) {
            lines.push(Line::near(run, &format!("phi({i},{j},{k})"), value, relative * value.abs().max(size)));
        }
    }
    lines
}
