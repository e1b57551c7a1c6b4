//! Beside other programs: the telegraph equation on 512 by 512 cells until a fixed time, error against wall seconds.

use super::write::{Grid, json_file, words};
use crate::bench::numerical;
use crate::cli::TradeoffArgs;
use crate::failure::{Exit, Failure};
use crate::pool;
use cf_output::{AxisScale, Curve, Join, Marker, Plot, PlotAxis};
use cf_tradeoff::{Measured, Numbers, Problem, Scheme, Setting, cheapest};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

/// Timed runs of ours.
const RUNS: usize = 7;

/// What another program did.
struct Peer {
    name: String,
    version: String,
    cells: usize,
    steps: usize,
    error: f64,
    seconds: f64,
    setup: f64,
}

/// How many times faster ours must be at equal error, by the peer's name.
const FASTER: [(&str, f64); 3] = [("NumPy leapfrog", 5.0), ("py-pde", 10.0), ("FiPy", 10.0)];

/// Measures, writes, prints; fails where ours is not that much faster.
pub fn peers(asked: &TradeoffArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let n = if asked.quick { 128 } else { 512 };
    let threads = pool::threads(None);
    let theirs = match run_peers(n, asked) {
        Ok(theirs) => theirs,
        Err(missing) => {
            say!("SKIPPED: other programs: {missing}");
            Vec::new()
        }
    };
    let mut ours = Vec::new();
    for n in [n / 4, n / 2, n] {
        let problem = Problem::telegraph(n).map_err(numerical)?;
        for threads in [1, threads] {
            for numbers in [Numbers::F64, Numbers::F32] {
                if stop.load(Ordering::Relaxed) {
                    return Err(Failure::Words(Exit::Interrupted, "stopped before all was measured".into()));
                }
                // One call takes the longest stable sub-steps by itself.
                for (scheme, steps) in [(Scheme::Kdk, 1), (Scheme::Sdirk2, 40), (Scheme::Spectral, 1)] {
                    let setting = Setting { numbers, ..Setting::new(scheme, steps, threads) };
                    ours.push(problem.measure(&setting, RUNS).map_err(numerical)?.0);
                }
            }
        }
    }
    let (grid, failed) = compared(&ours, &theirs, n);
    let settings = own(&ours);
    say!("{}\n{}", settings.text(), grid.text());
    plot(&ours, &theirs).write_png(&asked.out.join("peers.png"))?;
    json_file(&document(&ours, &theirs), &asked.out.join("peers.json"))?;
    if let Some(docs) = &asked.docs {
        plot(&ours, &theirs).write_png(&docs.join("peers.png"))?;
        let text = format!(
            "# Beside other programs\n\nWritten by `cargo xtask tradeoff --peers --docs docs/tradeoff`.\n\n\
             tau phi_tt + phi_t = k lap phi in a closed unit box, k = 0.05 m²/s, tau = 0.02 s, phi = e^(-(r/0.05)²) and \
             phi_t = 0 at the start, until 0.2 s. Errors are 2-norms relative to the continuous solution, by transforms with \
             the eigenvalues K² on the same cells; each side makes its own, and both are compared. How the others are set up \
             is in `benches/peers/telegraph`. Ours: the cheapest setting on one thread whose error is at most the other's, \
             with set-up; theirs without set-up and without compiling.\n\n![peers.png](peers.png)\n\n{}\n\
             ## Ours\n\nMedian of {RUNS} runs after one to warm up, with set-up.\n\n{}",
            grid.markdown(),
            settings.markdown()
        );
        cf_output::write_text(&docs.join("peers.md"), &text)?;
    }
    if failed.is_empty() { Ok(()) } else { Err(Failure::failed(failed.join("; "))) }
}

/// Ours on one thread against each of theirs, at equal error and with the same method; and what is not fast enough.
fn compared(ours: &[Measured], theirs: &[Peer], n: usize) -> (Grid, Vec<String>) {
    let (mut rows, mut failed) = (Vec::new(), Vec::new());
    for peer in theirs {
        let alone = |m: &&Measured| m.setting.threads == 1;
        let stepped = |m: &&Measured| m.setting.scheme == Scheme::Kdk && m.cells[0] >= peer.cells;
        let best = cheapest(ours.iter().filter(alone), peer.error);
        let same = cheapest(ours.iter().filter(alone).filter(stepped), peer.error);
        let ratio = |m: Option<&Measured>| m.map_or(f64::NAN, |m| peer.seconds / m.seconds);
        let shown = |m: Option<&Measured>| {
            m.map_or_else(|| ["-".to_owned(), "-".to_owned()], |m| [words(m), format!("{:.4}", m.seconds)])
        };
        let ([what, seconds], [_, stepping]) = (shown(best), shown(same));
        rows.push(vec![
            format!("{} {}", peer.name, peer.version),
            format!("{0} x {0}", peer.cells),
            peer.steps.to_string(),
            format!("{:.1e}", peer.error),
            format!("{:.3}", peer.seconds),
            format!("{:.1}", peer.setup),
            what,
            seconds,
            format!("{:.0}", ratio(best)),
            stepping,
            format!("{:.1}", ratio(same)),
        ]);
        let asked = FASTER.iter().find(|(name, _)| *name == peer.name).map_or(0.0, |(_, times)| *times);
        if peer.cells == n && (ratio(best) < asked || ratio(best).is_nan()) {
            failed.push(format!("{}: {:.1} times, expected {asked}", peer.name, ratio(best)));
        }
    }
    let heads = vec![
        "program",
        "cells",
        "steps",
        "error",
        "s",
        "set-up s",
        "ours, one thread",
        "s",
        "times faster",
        "Kdk, same cells: s",
        "times faster",
    ];
    (Grid { heads, rows }, failed)
}

fn own(ours: &[Measured]) -> Grid {
    let row = |m: &Measured| {
        vec![
            m.setting.scheme.to_string(),
            crate::show::cells(&m.cells),
            format!("{:.3}", m.courant),
            m.setting.numbers.to_string(),
            m.setting.threads.to_string(),
            format!("{:.2e}", m.error),
            format!("{:.4}", m.seconds),
        ]
    };
    let heads = vec!["integrator", "cells", "c dt/h", "numbers", "threads", "error", "s"];
    Grid { heads, rows: ours.iter().map(row).collect() }
}

fn plot(ours: &[Measured], theirs: &[Peer]) -> Plot {
    let log = |name: &str| PlotAxis { name: name.into(), scale: AxisScale::Log, range: None };
    let mut curves = Vec::new();
    for (scheme, marker) in [(Scheme::Kdk, Marker::Circle), (Scheme::Spectral, Marker::Square)] {
        for threads in [1, ours.iter().map(|m| m.setting.threads).max().unwrap_or(1)] {
            for numbers in [Numbers::F64, Numbers::F32] {
                let chosen = ours.iter().filter(|m| {
                    m.setting.scheme == scheme && m.setting.threads == threads && m.setting.numbers == numbers
                });
                let points: Vec<[f64; 2]> = chosen.map(|m| [m.seconds, m.error]).collect();
                let plural = if threads == 1 { "" } else { "s" };
                let label = format!("ours: {scheme} {numbers}, {threads} thread{plural}");
                if !curves.iter().any(|c: &Curve| c.label == label) {
                    curves.push(Curve { marker, ..Curve::new(label, points) });
                }
            }
        }
    }
    for (name, _) in FASTER {
        let mut points: Vec<[f64; 2]> =
            theirs.iter().filter(|p| p.name == name).map(|p| [p.seconds, p.error]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if !points.is_empty() {
            curves.push(Curve { join: Join::Dashed, marker: Marker::Diamond, ..Curve::new(name, points) });
        }
    }
    Plot {
        title: "Telegraph equation until 0.2 s".into(),
        x: log("wall time [s]"),
        y: log("relative error, 2-norm [1]"),
        curves,
        size: [1000, 640],
        ..Plot::default()
    }
}

fn document(ours: &[Measured], theirs: &[Peer]) -> Value {
    let own = ours.iter().map(|m| {
        json!({ "integrator": m.setting.scheme.to_string(), "cells": m.cells, "threads": m.setting.threads,
            "precision": m.setting.numbers.to_string(), "error": m.error, "seconds": m.seconds })
    });
    let other = theirs.iter().map(|p| {
        json!({ "program": p.name, "version": p.version, "cells": p.cells, "steps": p.steps, "error": p.error,
            "seconds": p.seconds, "setup_seconds": p.setup })
    });
    json!({ "ours": own.collect::<Vec<Value>>(), "theirs": other.collect::<Vec<Value>>() })
}

/// The other programs, in an environment of their own below `target`; the reason where they cannot be had.
fn run_peers(n: usize, asked: &TradeoffArgs) -> Result<Vec<Peer>, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let sources = root.join("benches/peers/telegraph");
    let python = environment(&root.join("target/peers/python"), &sources.join("requirements.txt"))?;
    let reference = asked.out.join("peers_reference.f64");
    let mut command = Command::new(python);
    command.arg(sources.join("telegraph.py")).args(["--cells", &n.to_string()]).arg("--reference").arg(&reference);
    if asked.quick {
        command.arg("--quick");
    }
    // One thread each, as ours is compared on one.
    for name in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"] {
        command.env(name, "1");
    }
    complain!("running the other programs; FiPy takes minutes");
    let done = command.output().map_err(|error| error.to_string())?;
    if !done.status.success() {
        return Err(String::from_utf8_lossy(&done.stderr).lines().last().unwrap_or("they failed").to_owned());
    }
    let rows: Vec<Value> = serde_json::from_slice(&done.stdout).map_err(|error| error.to_string())?;
    same_reference(&reference, n)?;
    let peer = |row: &Value| {
        let text = |key: &str| row[key].as_str().map(str::to_owned);
        let number = |key: &str| row[key].as_f64();
        Some(Peer {
            name: text("program")?,
            version: text("version")?,
            cells: number("cells")? as usize,
            steps: number("steps")? as usize,
            error: number("error")?,
            seconds: number("seconds")?,
            setup: number("setup_seconds")?,
        })
    };
    rows.iter().map(peer).collect::<Option<_>>().ok_or_else(|| "their results cannot be read".to_owned())
}

/// Their reference must be ours.
fn same_reference(path: &Path, n: usize) -> Result<(), String> {
    let bytes = std::fs::read(path).map_err(|error| error.to_string())?;
    let theirs = bytes.chunks_exact(8).map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]));
    let ours = Problem::telegraph(n).map_err(|error| error.to_string())?.exact();
    if ours.len() * 8 != bytes.len() {
        return Err(format!("their reference has {} bytes, expected {}", bytes.len(), 8 * ours.len()));
    }
    let apart = theirs.zip(&ours).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    if apart < 1e-10 { Ok(()) } else { Err(format!("their reference differs from ours by {apart:.1e}")) }
}

/// Python with the pinned packages, made once.
fn environment(folder: &Path, requirements: &Path) -> Result<PathBuf, String> {
    let python = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let mark = folder.join("complete.txt");
    let wanted = std::fs::read_to_string(requirements).map_err(|error| error.to_string())?;
    if std::fs::read_to_string(&mark).is_ok_and(|had| had == wanted) {
        return Ok(python);
    }
    let run = |command: &mut Command, what: &str| {
        let done = command.output().map_err(|error| format!("{what}: {error}"))?;
        let last = || String::from_utf8_lossy(&done.stderr).lines().last().unwrap_or("failed").to_owned();
        if done.status.success() { Ok(()) } else { Err(format!("{what}: {}", last())) }
    };
    complain!("making an environment for the other programs in {}", folder.display());
    run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(folder), "python3 -m venv")?;
    run(Command::new(&python).args(["-m", "pip", "install", "--quiet", "-r"]).arg(requirements), "pip install")?;
    std::fs::write(&mark, wanted).map_err(|error| error.to_string())?;
    Ok(python)
}
