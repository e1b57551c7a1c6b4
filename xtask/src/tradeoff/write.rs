//! The files: CSV, JSON and the table for the documentation.

use super::claims::Claim;
use super::orders::Row;
use super::problem::REFERENCES;
use super::setting::Measured;
use crate::bench::stream::Bandwidth;
use crate::failure::Failure;
use crate::show;
use cf_output::{Cell, Table};
use serde_json::{Value, json};
use std::path::Path;

/// Everything that was found.
pub struct Found<'a> {
    /// Settings on problems.
    pub rows: &'a [Measured],
    /// The table of 6.1.
    pub orders: &'a [Row],
    /// The claims.
    pub claims: &'a [Claim],
    /// Of this machine.
    pub bandwidth: &'a Bandwidth,
    /// Threads it was measured with.
    pub threads: usize,
}

const COLUMNS: [&str; 19] = [
    "problem",
    "cells",
    "integrator",
    "steps",
    "c dt/h",
    "precision",
    "tolerance",
    "threads",
    "error",
    "error in time",
    "error 1-norm",
    "error max",
    "overshoot",
    "mass drift",
    "front width [cells]",
    "ringing",
    "iterations",
    "time [s]",
    "runs",
];

/// The rows as CSV.
pub fn csv(rows: &[Measured], path: &Path) -> Result<(), Failure> {
    let mut table = Table::new(&COLUMNS);
    for m in rows {
        let s = &m.setting;
        table.push([
            m.problem.as_str().into(),
            show::cells(&m.cells).into(),
            s.scheme.to_string().into(),
            s.steps.into(),
            m.courant.into(),
            s.numbers.to_string().into(),
            s.tolerance.into(),
            s.threads.into(),
            m.error.into(),
            m.time_error.into(),
            m.one.into(),
            m.worst.into(),
            m.overshoot.into(),
            m.drift.into(),
            known(m.width),
            known(m.ringing),
            m.iterations.into(),
            m.seconds.into(),
            m.runs.into(),
        ])?;
    }
    Ok(table.write(path)?)
}

fn known(value: f64) -> Cell {
    if value.is_nan() { Cell::Empty } else { value.into() }
}

/// For programs.
pub fn summary(found: &Found<'_>, path: &Path) -> Result<(), Failure> {
    let row = |m: &Measured| {
        json!({
            "problem": m.problem, "cells": m.cells, "integrator": m.setting.scheme.to_string(),
            "steps": m.setting.steps, "courant": m.courant, "precision": m.setting.numbers.to_string(),
            "tolerance": m.setting.tolerance, "threads": m.setting.threads, "error": m.error,
            "error_in_time": m.time_error, "overshoot": m.overshoot, "mass_drift": m.drift,
            "front_width_cells": m.width, "ringing": m.ringing, "seconds": m.seconds, "runs": m.runs,
        })
    };
    let order = |r: &Row| {
        json!({ "law": r.law, "scheme": r.scheme, "steps": r.steps, "expected": r.expected,
            "measured": r.measured, "pass": r.pass() })
    };
    let claim = |c: &Claim| json!({ "name": c.name, "measured": c.measured, "pass": c.pass });
    let document = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "stream": found.bandwidth.document(),
        "references": REFERENCES,
        "rows": found.rows.iter().map(row).collect::<Vec<Value>>(),
        "orders": found.orders.iter().map(order).collect::<Vec<Value>>(),
        "claims": found.claims.iter().map(claim).collect::<Vec<Value>>(),
    });
    let text = serde_json::to_string_pretty(&document).map_err(|error| Failure::io(error.to_string()))?;
    Ok(cf_output::write_text(path, &(text + "\n"))?)
}

/// The heads and rows of the table for people, of one problem or of all.
pub fn table<'a>(rows: impl Iterator<Item = &'a Measured>) -> (Vec<&'static str>, Vec<Vec<String>>) {
    let heads = vec![
        "problem",
        "cells",
        "integrator",
        "steps",
        "c dt/h",
        "numbers",
        "tolerance",
        "threads",
        "error",
        "in time",
        "overshoot",
        "width",
        "ms",
    ];
    let or_dash = |x: f64, text: String| if x.is_nan() { "-".to_owned() } else { text };
    let rows = rows.map(|m| {
        let s = &m.setting;
        let front = m.problem.starts_with("P2");
        let over = if m.ringing.is_nan() { m.overshoot } else { m.ringing };
        vec![
            m.problem.clone(),
            show::cells(&m.cells),
            s.scheme.to_string(),
            s.steps.to_string(),
            format!("{:.3}", m.courant),
            s.numbers.to_string(),
            format!("{:e}", s.tolerance),
            s.threads.to_string(),
            format!("{:.2e}", m.error),
            format!("{:.2e}", m.time_error),
            if front { format!("{:.2} %", 100.0 * over) } else { "-".into() },
            or_dash(m.width, format!("{:.1}", m.width)),
            format!("{:.1}", 1e3 * m.seconds),
        ]
    });
    (heads, rows.collect())
}

/// The page of docs/tradeoff.
pub fn page(found: &Found<'_>, pictures: &[String]) -> String {
    let line = |entries: &[String]| format!("| {} |\n", entries.join(" | "));
    let grid = |heads: &[&str], rows: &[Vec<String>]| {
        let heads: Vec<String> = heads.iter().map(|h| (*h).to_owned()).collect();
        let rule = vec!["---".to_owned(); heads.len()];
        [heads, rule].iter().chain(rows).map(|row| line(row)).collect::<String>()
    };
    let mut text = String::from("# What accuracy costs\n\nWritten by `cargo xtask tradeoff --docs docs/tradeoff`.\n\n");
    text += "Median wall time of at least three runs, with set-up, against the error of phi in the 2-norm relative to the\n";
    text += "solution. \"in time\" is the error against the spectral integrator on the same grid. Overshoot: on the line the\n";
    text += "largest rise of phi, which should only fall, over the jump; on the disc the excess over the largest value.\n\n";
    for reference in REFERENCES {
        text += &format!("* {reference}\n");
    }
    text += &format!(
        "\nStream bandwidth here with {} threads: {:.1} GB/s.\n\n## Claims\n\n",
        found.threads,
        found.bandwidth.with(found.threads) / 1e9
    );
    let claims: Vec<Vec<String>> = found
        .claims
        .iter()
        .map(|c| vec![c.name.clone(), c.measured.clone(), if c.pass { "holds" } else { "fails" }.into()])
        .collect();
    text += &grid(&["claim", "measured", ""], &claims);
    if !pictures.is_empty() {
        text += "\n## Pictures\n\n";
        for picture in pictures {
            text += &format!("![{picture}]({picture})\n");
        }
    }
    if !found.orders.is_empty() {
        text += "\n## Errors in time on a line of 256 cells (model 6.1)\n\n";
        text += &grid(&ORDERS, &orders(found.orders));
    }
    text += "\n## All settings\n\n";
    let (heads, rows) = table(found.rows.iter());
    text + &grid(&heads, &rows)
}

/// Heads of the table of 6.1.
pub const ORDERS: [&str; 6] = ["law", "scheme", "steps", "model", "measured", ""];

/// Its rows.
pub fn orders(rows: &[Row]) -> Vec<Vec<String>> {
    let words = |r: &Row| {
        let verdict = if r.pass() { "agrees" } else { "differs" };
        let numbers = [r.expected, r.measured].map(|x| format!("{x:.1e}"));
        vec![
            r.law.clone(),
            r.scheme.into(),
            r.steps.to_string(),
            numbers[0].clone(),
            numbers[1].clone(),
            verdict.into(),
        ]
    };
    rows.iter().map(words).collect()
}
