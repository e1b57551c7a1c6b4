//! f32 against f64: on every run of figures 3 and 4, and where f32 stops being enough.

use super::scene::{Ran, Source, cells, coarsened, distance};
use super::sweep::RUNS;
use super::write::{Grid, json_file};
use crate::bench::numerical;
use crate::cli::TradeoffArgs;
use crate::failure::{Exit, Failure};
use crate::pool;
use cf_diffusion::Law;
use cf_scene::{Scene, catalog};
use cf_tradeoff::{Numbers, Problem, Scheme, Setting, median};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, Ordering};

/// Rounding below this share of the grid's error does not show.
const SHARE: f64 = 0.1;

/// Measures, writes, prints.
pub fn numbers(asked: &TradeoffArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let threads = pool::threads(None);
    let (mut scenes, mut documents) = (Vec::new(), Vec::new());
    for figure in ["3", "4"] {
        for scene in catalog::find(figure)? {
            let source = Source::of(scene, &asked.options)?;
            for scene in source.runs()? {
                if stop.load(Ordering::Relaxed) {
                    return Err(Failure::Words(Exit::Interrupted, "stopped before all was measured".into()));
                }
                let (row, document) = compared(&source, &scene, threads, asked.quick)?;
                complain!("{}", row.join("  "));
                scenes.push(row);
                documents.push(document);
            }
        }
    }
    let scenes = Grid {
        heads: vec![
            "scene",
            "run",
            "cells",
            "integrator",
            "steps",
            "error of the grid",
            "error of f32",
            "f64 ms",
            "f32 ms",
            "f32 is",
            "f32 is enough",
        ],
        rows: scenes,
    };
    let floor = floor(threads)?;
    say!("{}\n{}", scenes.text(), floor.text());
    json_file(&json!({ "scenes": documents }), &asked.out.join("numbers.json"))?;
    if let Some(docs) = &asked.docs {
        let text = format!(
            "# f32 against f64\n\nWritten by `cargo xtask tradeoff --numbers --docs docs/tradeoff`.\n\n\
             phi at the end of every run of figures 3 and 4 that differs in more than its numerics, preset {}, with the scene's own knobs but for the precision. \
             Error of the grid: f64 on these cells against f64 on half as many per axis, by means over cells, over 3 (second \
             order). Error of f32: f32 against f64 on the same cells. Both are 2-norms relative to f64. Times are medians \
             of at least five runs, steps alone, {threads} threads. f32 is enough where its error is below a tenth of the \
             grid's.\n\n{}\n## Where f32 stops being enough\n\nA Gaussian on a periodic line of 256 cells, k = 0.04 m²/s, \
             tau = 1 s, F_T = 0, after 1 s: error in time against the integrator that is exact in time, solves as tight as \
             each precision allows (1e-7 and 1e-11). Where the columns part, rounding rules.\n\n{}",
            asked.options.preset,
            scenes.markdown(),
            floor.markdown()
        );
        cf_output::write_text(&docs.join("numbers.md"), &text)?;
    }
    Ok(())
}

/// A run in both precisions.
fn compared(source: &Source, scene: &Scene, threads: usize, quick: bool) -> Result<(Vec<String>, Value), Failure> {
    let solve = |flags: &[String]| -> Result<(Ran, f64), Failure> {
        let first = source.run(&scene.run, flags, threads)?;
        let mut times = Vec::new();
        while times.len() < if quick { 1 } else { RUNS } {
            times.push(source.run(&scene.run, flags, threads)?.seconds);
        }
        Ok((first, median(times.into_iter())))
    };
    let (double, double_seconds) = solve(&["accuracy.precision=f64".into()])?;
    let (single, single_seconds) = solve(&["accuracy.precision=f32".into()])?;
    let rounding = distance(&single.phi, &double.phi)[0];
    let half =
        cells(scene, -1).map(|half| source.attempt(&scene.run, &["accuracy.precision=f64".into(), half], threads));
    let grid = half.transpose()?.flatten().map_or(f64::NAN, |coarse| {
        let mean = coarsened(&double.phi, &double.cells, &coarse.cells);
        mean.map_or(f64::NAN, |mean| distance(&coarse.phi, &mean)[0] / 3.0)
    });
    let enough = rounding < SHARE * grid;
    let row = vec![
        source.name.clone(),
        scene.run.clone(),
        crate::show::cells(&double.cells),
        double.setting.scheme.to_string(),
        double.setting.steps.to_string(),
        format!("{grid:.1e}"),
        format!("{rounding:.1e}"),
        format!("{:.0}", 1e3 * double_seconds),
        format!("{:.0}", 1e3 * single_seconds),
        format!("{:.2} times faster", double_seconds / single_seconds),
        if enough { "yes" } else { "no" }.into(),
    ];
    let document = json!({ "scene": source.name, "run": scene.run, "cells": double.cells, "grid_error": grid,
        "rounding_error": rounding, "f64_seconds": double_seconds, "f32_seconds": single_seconds, "enough": enough });
    Ok((row, document))
}

/// Errors in time of both precisions as steps grow.
fn floor(threads: usize) -> Result<Grid, Failure> {
    let law = Law::cattaneo(0.04, 1.0).map_err(numerical)?;
    let problem = Problem::orders(256, law).map_err(numerical)?;
    let mut rows = Vec::new();
    for scheme in [Scheme::Kdk, Scheme::Sdirk2] {
        for steps in [160, 640, 2560, 10240] {
            let error = |numbers, tolerance| {
                let setting = Setting { numbers, tolerance, ..Setting::new(scheme, steps, threads) };
                problem.measure(&setting, 0).map(|(m, _)| m.time_error).map_err(numerical)
            };
            let (double, single) = (error(Numbers::F64, 1e-11)?, error(Numbers::F32, 1e-7)?);
            rows.push(vec![
                scheme.to_string(),
                steps.to_string(),
                format!("{double:.1e}"),
                format!("{single:.1e}"),
                if single < 1.1 * double { "yes" } else { "no" }.into(),
            ]);
        }
    }
    Ok(Grid { heads: vec!["integrator", "steps", "f64", "f32", "f32 is enough"], rows })
}
