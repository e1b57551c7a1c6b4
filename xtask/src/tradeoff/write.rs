//! The files: CSV, JSON, the table for the documentation and the page for a browser.

use super::claims::Claim;
use super::tables::Listed;
use crate::bench::stream::Bandwidth;
use crate::failure::Failure;
use crate::show;
use cf_output::{Cell, Table, escape};
use cf_tradeoff::deformation::Convergence;
use cf_tradeoff::{Measured, Setting};
use serde_json::{Value, json};
use std::path::Path;

/// Everything that was found.
pub struct Found<'a> {
    /// Settings on problems.
    pub rows: &'a [Measured],
    /// The specified tables.
    pub tables: &'a [Listed],
    /// The deforming flow with diffusion.
    pub convergence: &'a [Convergence],
    /// The claims.
    pub claims: &'a [Claim],
    /// Of this machine.
    pub bandwidth: &'a Bandwidth,
    /// Threads it was measured with.
    pub threads: usize,
}

/// What `error` is measured against, by problem.
pub const REFERENCES: [&str; 6] = [
    "P1, a Gaussian in a closed box: the continuous equations, by transforms with the eigenvalues K² (error: space and time).",
    "P2 line, a jump: the telegraph equation's closed form with Bessel functions, averaged over cells.",
    "P2 disc, a sharp edge: the integral over the Green's function of the plane, averaged over cells.",
    "P3, a steady Gaussian source in a uniform flow: the continuous equations, a quotient per wave.",
    "P4, a flow that deforms and returns: the start; with diffusion, three grids against each other.",
    "P5, vortices in a stream: Euler's equations, exactly; the error is that of u, relative to the vortices.",
];

/// The knobs in words.
pub fn words(m: &Measured) -> String {
    let Setting { steps, numbers, tolerance, threads, advection, level, .. } = m.setting;
    let cells = show::cells(&m.cells);
    let solve = if m.setting.solves() { format!(", tolerance {tolerance:e}") } else { String::new() };
    let carried = if carries(m) { format!(", {advection:?}") } else { String::new() };
    let level = level.map_or_else(String::new, |level| format!(" ({level})"));
    let plural = |n| if n == 1 { "" } else { "s" };
    format!(
        "{}{level}, {cells}, {steps} step{}, {numbers}{solve}{carried}, {threads} thread{}",
        m.setting.method(),
        plural(steps),
        plural(threads)
    )
}

/// Whether the medium moves.
fn carries(m: &Measured) -> bool {
    m.problem.starts_with("P3") || m.problem.starts_with("P4")
}

const COLUMNS: [&str; 25] = [
    "problem",
    "cells",
    "integrator",
    "fluid",
    "level",
    "steps",
    "c dt/h",
    "precision",
    "tolerance",
    "advection",
    "splitting",
    "threads",
    "error",
    "error in time",
    "error 1-norm",
    "error max",
    "overshoot",
    "mass drift",
    "front width [cells]",
    "ringing",
    "outside the cone",
    "cone angle [degrees]",
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
            s.flow.map_or(Cell::Empty, |flow| format!("{flow:?}").into()),
            s.level.map_or(Cell::Empty, |level| level.to_string().into()),
            s.steps.into(),
            m.courant.into(),
            s.numbers.to_string().into(),
            s.tolerance.into(),
            format!("{:?}", s.advection).into(),
            format!("{:?}", s.splitting).into(),
            s.threads.into(),
            m.error.into(),
            known(m.time_error),
            m.one.into(),
            m.worst.into(),
            m.overshoot.into(),
            m.drift.into(),
            known(m.width),
            known(m.ringing),
            known(m.outside),
            known(m.angle),
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
            "fluid": m.setting.flow.map(|flow| format!("{flow:?}")),
            "level": m.setting.level.map(|level| level.to_string()),
            "steps": m.setting.steps, "courant": m.courant, "precision": m.setting.numbers.to_string(),
            "tolerance": m.setting.tolerance, "threads": m.setting.threads,
            "advection": format!("{:?}", m.setting.advection), "splitting": format!("{:?}", m.setting.splitting),
            "error": m.error, "error_in_time": m.time_error, "error_1_norm": m.one, "error_max": m.worst,
            "overshoot": m.overshoot, "mass_drift": m.drift, "front_width_cells": m.width, "ringing": m.ringing,
            "outside_cone": m.outside, "cone_degrees": m.angle, "seconds": m.seconds, "runs": m.runs,
        })
    };
    let table = |t: &Listed| {
        let rows = t.rows.iter().map(|r| {
            json!({ "case": r.case, "scheme": r.scheme, "quantity": r.quantity, "expected": r.expected,
                "measured": r.measured, "pass": r.pass(), "reason": r.reason })
        });
        json!({ "name": t.name, "rows": rows.collect::<Vec<Value>>() })
    };
    let convergence = |c: &Convergence| {
        json!({ "law": c.law, "integrator": c.setting.scheme.to_string(), "advection": format!("{:?}", c.setting.advection),
            "cells": c.cells, "differences": c.differences, "order": c.order, "error": c.error, "seconds": c.seconds })
    };
    let claim = |c: &Claim| json!({ "name": c.name, "measured": c.measured, "pass": c.pass });
    let document = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "stream": found.bandwidth.document(),
        "references": REFERENCES,
        "rows": found.rows.iter().map(row).collect::<Vec<Value>>(),
        "tables": found.tables.iter().map(table).collect::<Vec<Value>>(),
        "convergence": found.convergence.iter().map(convergence).collect::<Vec<Value>>(),
        "claims": found.claims.iter().map(claim).collect::<Vec<Value>>(),
    });
    json_file(&document, path)
}

/// A document on its own.
pub fn json_file(document: &Value, path: &Path) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(document).map_err(|error| Failure::io(error.to_string()))?;
    Ok(cf_output::write_text(path, &(text + "\n"))?)
}

/// Heads and rows for people.
pub struct Grid {
    /// The heads.
    pub heads: Vec<&'static str>,
    /// The rows.
    pub rows: Vec<Vec<String>>,
}

impl Grid {
    /// As Markdown.
    pub fn markdown(&self) -> String {
        let line = |entries: &[String]| format!("| {} |\n", entries.join(" | "));
        let heads: Vec<String> = self.heads.iter().map(|h| (*h).to_owned()).collect();
        let rule = vec!["---".to_owned(); heads.len()];
        [heads, rule].iter().chain(&self.rows).map(|row| line(row)).collect()
    }

    fn html(&self) -> String {
        let row = |tag: &str, entries: &mut dyn Iterator<Item = &str>| {
            let cells: String = entries.map(|e| format!("<{tag}>{}</{tag}>", escape(e))).collect();
            format!("<tr>{cells}</tr>\n")
        };
        let rows: String = self.rows.iter().map(|r| row("td", &mut r.iter().map(String::as_str))).collect();
        format!("<table>\n{}{rows}</table>\n", row("th", &mut self.heads.iter().copied()))
    }

    /// For a terminal.
    pub fn text(&self) -> String {
        show::table(&self.heads, &self.rows)
    }
}

/// All settings, or those of a problem.
pub fn settings<'a>(rows: impl Iterator<Item = &'a Measured>) -> Grid {
    let dash = |x: f64, text: String| if x.is_nan() { "-".to_owned() } else { text };
    let percent = |x: f64| dash(x, format!("{:.2} %", 100.0 * x));
    let heads = vec![
        "problem",
        "cells",
        "integrator",
        "level",
        "transport",
        "steps",
        "c dt/h",
        "numbers",
        "tolerance",
        "threads",
        "error",
        "in time",
        "1-norm",
        "overshoot",
        "width",
        "outside",
        "angle",
        "ms",
    ];
    let rows = rows.map(|m| {
        let s = &m.setting;
        let front = m.problem.starts_with("P2") || m.problem.starts_with("P4");
        let over = if m.ringing.is_nan() { m.overshoot } else { m.ringing };
        vec![
            m.problem.clone(),
            show::cells(&m.cells),
            s.method(),
            s.level.map_or_else(|| "-".into(), |level| level.to_string()),
            if carries(m) { format!("{:?}", s.advection) } else { "-".into() },
            s.steps.to_string(),
            format!("{:.3}", m.courant),
            s.numbers.to_string(),
            if s.solves() { format!("{:e}", s.tolerance) } else { "-".into() },
            s.threads.to_string(),
            format!("{:.2e}", m.error),
            dash(m.time_error, format!("{:.2e}", m.time_error)),
            format!("{:.2e}", m.one),
            if front { percent(over) } else { "-".into() },
            dash(m.width, format!("{:.1}", m.width)),
            percent(m.outside),
            dash(m.angle, format!("{:.2}", m.angle)),
            format!("{:.1}", 1e3 * m.seconds),
        ]
    });
    Grid { heads, rows: rows.collect() }
}

/// A specified table.
pub fn listed(table: &Listed) -> Grid {
    let rows = table.rows.iter().map(|r| {
        let verdict = match (r.pass(), r.reason) {
            (true, _) => "agrees",
            (false, Some(reason)) => reason,
            (false, None) => "differs",
        };
        let number = |x: f64| if r.quantity.contains('[') { format!("{x:.1}") } else { format!("{x:.1e}") };
        vec![
            r.case.clone(),
            r.scheme.clone(),
            r.quantity.into(),
            number(r.expected),
            number(r.measured),
            verdict.into(),
        ]
    });
    Grid { heads: vec!["case", "scheme", "quantity", "specified", "measured", ""], rows: rows.collect() }
}

/// The deforming flow with diffusion.
pub fn convergence(found: &[Convergence]) -> Grid {
    let rows = found.iter().map(|c| {
        vec![
            c.law.clone(),
            c.setting.scheme.to_string(),
            format!("{:?}", c.setting.advection),
            format!("{0}, {1}, {2}", c.cells, 2 * c.cells, 4 * c.cells),
            format!("{:.2e}", c.differences[0]),
            format!("{:.2e}", c.differences[1]),
            format!("{:.2}", c.order),
            format!("{:.1e}", c.error),
            show::seconds(c.seconds),
        ]
    });
    let heads =
        vec!["law", "integrator", "transport", "cells", "first to second", "second to third", "order", "left", "time"];
    Grid { heads, rows: rows.collect() }
}

/// The claims.
pub fn claims(claims: &[Claim]) -> Grid {
    let rows =
        claims.iter().map(|c| vec![c.name.clone(), c.measured.clone(), if c.pass { "holds" } else { "fails" }.into()]);
    Grid { heads: vec!["claim", "measured", ""], rows: rows.collect() }
}

/// What the errors and the times are.
const ABOUT: &str = "Median wall time of at least five runs after one to warm up (a run above 1 s warms up and counts), with \
    set-up, against the error of phi (in P5 of u) in the 2-norm relative to the solution. \"in time\" is the error against the integrator that \
    is exact in time on the same grid. Overshoot is in % of the jump at the start: on the line the largest rise of phi, which \
    should only fall; in the disc and in P4 the excess over the largest exact value. Outside is the share of |phi| outside the cone \
    by more than three standard deviations of the source, angle the half angle of its ridges. Levels are the settings that a scene \
    of that accuracy level chooses.";

/// The sections of both pages: heading, text, grid.
fn sections(found: &Found<'_>) -> Vec<(String, String, Grid)> {
    let mut all = vec![("Claims".to_owned(), String::new(), claims(found.claims))];
    for table in found.tables {
        all.push((table.name.to_owned(), table.text.to_owned(), listed(table)));
    }
    if !found.convergence.is_empty() {
        let text = "The bell of P4 with k = 0.01 m²/s, tau = 0.25 s: differences between three grids in the 2-norm, steps in \
                    proportion to the cells, and what the order leaves for the finest.";
        all.push(("Moving and spreading".into(), text.into(), convergence(found.convergence)));
    }
    all.push(("All settings".into(), String::new(), settings(found.rows.iter())));
    all
}

fn bandwidth(found: &Found<'_>) -> String {
    format!(
        "Stream bandwidth here with {} threads: {:.1} GB/s.",
        found.threads,
        found.bandwidth.with(found.threads) / 1e9
    )
}

/// The page of a problem in docs/tradeoff.
pub fn page(found: &Found<'_>, pictures: &[String], problem: &str, command: &str) -> String {
    let mut text = format!("# What accuracy costs: {problem}\n\nWritten by `{command}`.\n\n{ABOUT}\n\n");
    for reference in REFERENCES.iter().filter(|reference| reference.starts_with(problem)) {
        text += &format!("* {reference}\n");
    }
    text += &format!("\n{}\n", bandwidth(found));
    for (heading, words, grid) in sections(found) {
        text += &format!("\n## {heading}\n\n");
        if !words.is_empty() {
            text += &format!("{words}\n\n");
        }
        text += &grid.markdown();
        if heading == "Claims" && !pictures.is_empty() {
            text += "\n## Pictures\n\n";
            for picture in pictures {
                text += &format!("![{picture}]({picture})\n");
            }
        }
    }
    text
}

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}\
    table{border-collapse:collapse;font-size:12px;display:block;overflow-x:auto}td,th{padding:2px 8px;border-bottom:1px solid \
    #ddd;text-align:left}img{max-width:100%;margin:.5em 0}";

/// The same for a browser.
pub fn report(found: &Found<'_>, pictures: &[String]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>What accuracy costs</title><style>{STYLE}</style>\n\
         <h1>What accuracy costs</h1>\n<p>{}</p>\n<ul>\n",
        escape(ABOUT)
    );
    for reference in REFERENCES {
        text += &format!("<li>{}</li>\n", escape(reference));
    }
    text += &format!("</ul>\n<p>{}</p>\n", escape(&bandwidth(found)));
    for (heading, words, grid) in sections(found) {
        text += &format!("<h2>{}</h2>\n<p>{}</p>\n{}", escape(&heading), escape(&words), grid.html());
        if heading == "Claims" {
            text += "<h2>Pictures</h2>\n";
            for picture in pictures {
                text += &format!("<img src=\"{0}\" alt=\"{0}\">\n", escape(picture));
            }
        }
    }
    text + "</html>\n"
}
