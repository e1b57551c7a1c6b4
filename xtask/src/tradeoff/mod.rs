//! `tradeoff`: what accuracy costs, on problems with known solutions, on scenes, and beside other programs.
//!
//! `cf-tradeoff` has the problems and runs them. Here, `sweep` has the combinations, `levels` what the accuracy levels of
//! scenes choose, `tables` repeats the tables of the specification, `claims` judges, `write` and `pictures` make the files;
//! `scene` does the same for a scene, `numbers` compares precisions on the scenes of two figures, `peers` other programs.

mod claims;
mod levels;
mod numbers;
mod peers;
mod pictures;
mod scene;
mod sweep;
mod tables;
mod write;

use crate::bench::stream::Bandwidth;
use crate::cli::{Canonical, TradeoffArgs};
use crate::failure::Failure;
use crate::{pool, show};
use cf_tradeoff::{Measured, cheapest};
use claims::Claim;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use sweep::Sweep;
use tables::Listed;
use write::Found;

/// Measures, writes, prints; fails where a claim does.
pub fn tradeoff(asked: &TradeoffArgs, stop: &AtomicBool) -> Result<(), Failure> {
    // A scene that is none leaves no folder.
    let scene = asked.scene.as_ref().map(|scene| scene::Runs::open(scene, &asked.options)).transpose()?;
    for folder in [Some(&asked.out), asked.docs.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::io(format!("cannot make the folder {}: {error}", folder.display())))?;
    }
    match scene {
        Some(runs) => scene::scene(&runs, asked, stop),
        None if asked.peers => peers::peers(asked, stop),
        None if asked.numbers => numbers::numbers(asked, stop),
        None => canonical(asked, stop),
    }
}

/// What came of one problem.
struct Part<'a> {
    sweep: Sweep<'a>,
    tables: Vec<Listed>,
    claims: Vec<Claim>,
}

impl<'a> Part<'a> {
    fn of(problem: Canonical, quick: bool, threads: usize, stop: &'a AtomicBool) -> Result<Self, Failure> {
        let mut sweep = Sweep::new(quick, threads, stop);
        let (mut tables, mut claims) = (Vec::new(), Vec::new());
        match problem {
            Canonical::P1 => {
                tables.push(tables::orders(threads)?);
                sweep.p1()?;
                claims.push(claims::cheaper(&sweep.rows));
            }
            Canonical::P2 => {
                sweep.p2()?;
                tables.push(tables::fronts(&sweep.rows));
                claims.extend(claims::fronts(&sweep.rows));
            }
            Canonical::P3 => {
                sweep.p3()?;
                claims.extend(claims::cones(&sweep.rows, &sweep.angles));
            }
            Canonical::P4 => {
                sweep.p4()?;
                tables.push(tables::transport(&sweep.rows));
            }
            Canonical::P5 | Canonical::All => {
                sweep.p5()?;
                claims.push(claims::fluids(&sweep.rows));
            }
        }
        claims.extend(tables.iter().filter(|table| !table.rows.is_empty()).map(claims::table));
        if quick {
            // Small grids show how it is done, not what holds.
            for Claim { name, measured, .. } in claims.iter().filter(|claim| !claim.pass) {
                complain!("not judged on grids this small: {name}: {measured}");
            }
            claims.retain(|claim| claim.pass);
        }
        Ok(Self { sweep, tables, claims })
    }
}

/// The problems with known solutions.
fn canonical(asked: &TradeoffArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let threads = pool::threads(None);
    let mut bandwidth = Bandwidth::measure(&[1, threads][usize::from(threads == 1)..])?;
    let mut whole = Part { sweep: Sweep::new(asked.quick, threads, stop), tables: vec![], claims: vec![] };
    for problem in [Canonical::P1, Canonical::P2, Canonical::P3, Canonical::P4, Canonical::P5] {
        if asked.problem != problem && asked.problem != Canonical::All {
            continue;
        }
        let part = Part::of(problem, asked.quick, threads, stop)?;
        bandwidth.again()?;
        if let Some(docs) = &asked.docs {
            let found = found(&part, &bandwidth, threads);
            let pictures = drawn(&found, &part.sweep, docs, &DRAWN)?;
            let name = format!("{problem:?}");
            let command = format!("cargo xtask tradeoff --problem {name} --docs docs/tradeoff");
            let page = write::page(&found, &pictures, &name, &command);
            cf_output::write_text(&docs.join(format!("{}.md", name.to_lowercase())), &page)?;
        }
        whole.sweep.rows.extend(part.sweep.rows);
        whole.sweep.shown.extend(part.sweep.shown);
        whole.sweep.convergence.extend(part.sweep.convergence);
        whole.tables.extend(part.tables);
        whole.claims.extend(part.claims);
    }
    let found = found(&whole, &bandwidth, threads);
    say(&found);
    files(&found, &whole.sweep, &asked.out)?;
    if let Some(error) = asked.target_error {
        recommend(&whole.sweep.rows, error);
    }
    say!("\nwritten to {}", asked.out.display());
    judge(&whole.claims)
}

fn found<'a>(part: &'a Part<'_>, bandwidth: &'a Bandwidth, threads: usize) -> Found<'a> {
    Found {
        rows: &part.sweep.rows,
        tables: &part.tables,
        convergence: &part.sweep.convergence,
        claims: &part.claims,
        bandwidth,
        threads,
    }
}

/// Fails where a claim does.
fn judge(claims: &[Claim]) -> Result<(), Failure> {
    let failed: Vec<&str> = claims.iter().filter(|c| !c.pass).map(|c| c.name.as_str()).collect();
    if failed.is_empty() { Ok(()) } else { Err(Failure::failed(format!("does not hold: {}", failed.join("; ")))) }
}

fn say(found: &Found<'_>) {
    for table in found.tables {
        say!("{}. {}\n{}", table.name, table.text, write::listed(table).text());
    }
    if !found.convergence.is_empty() {
        say!("{}", write::convergence(found.convergence).text());
    }
    say!("Error of phi, in P5 of u (2-norm, relative) against");
    for reference in write::REFERENCES {
        say!("  {reference}");
    }
    say!("\"in time\": against the integrator that is exact in time on the same grid. Median of five runs or more.\n");
    say!("{}", write::settings(found.rows.iter()).text());
    found.bandwidth.print();
    for Claim { name, measured, pass } in found.claims {
        say!("{} {name}: {measured}", if *pass { "holds" } else { "FAILS" });
    }
}

fn files(found: &Found<'_>, sweep: &Sweep<'_>, out: &Path) -> Result<(), Failure> {
    write::csv(found.rows, &out.join("tradeoff.csv"))?;
    write::summary(found, &out.join("summary.json"))?;
    let pictures = drawn(found, sweep, out, &[])?;
    Ok(cf_output::write_text(&out.join("report.html"), &write::report(found, &pictures))?)
}

/// The Pareto plots of the documentation; all are in the report.
const DRAWN: [&str; 9] = [
    "P1 2D, F_T = 0, tau = 1 s",
    "P1 2D, F_T = 0.1, tau = 1 s",
    "P1 2D, F_T = 1, tau = 1 s",
    "P1 3D, F_T = 0, tau = 1 s",
    "P2 line",
    "P2 disc",
    "P3 H_c = 1.414, F_T = 0",
    "P4 bell",
    "P5 vortices",
];

/// A Pareto plot per problem and the pictures of the fronts, by name; only of some problems if `only` has any.
fn drawn(found: &Found<'_>, sweep: &Sweep<'_>, out: &Path, only: &[&str]) -> Result<Vec<String>, Failure> {
    let mut names = drawn_of(found.rows, out, only)?;
    let fronts = pictures::fronts(&sweep.shown, out)?;
    names.extend(fronts.iter().filter_map(|path| Some(path.file_name()?.to_str()?.to_owned())));
    Ok(names)
}

/// A Pareto plot per problem.
fn drawn_of(rows: &[Measured], out: &Path, only: &[&str]) -> Result<Vec<String>, Failure> {
    let mut names = Vec::new();
    for problem in problems(rows) {
        if !only.is_empty() && !only.contains(&problem) {
            continue;
        }
        let own: Vec<&Measured> = rows.iter().filter(|m| m.problem == problem).collect();
        let words: Vec<String> = problem
            .split(|c: char| !c.is_ascii_alphanumeric())
            .filter(|w| !w.is_empty())
            .map(str::to_lowercase)
            .collect();
        let name = format!("pareto_{}.png", words.join("_"));
        pictures::pareto(problem, &own).write_png(&out.join(&name))?;
        names.push(name);
    }
    Ok(names)
}

/// The problems in their order.
fn problems(rows: &[Measured]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for m in rows {
        if !names.contains(&m.problem.as_str()) {
            names.push(&m.problem);
        }
    }
    names
}

/// The cheapest setting for an error, problem by problem.
fn recommend(rows: &[Measured], error: f64) {
    say!("\nCheapest setting with a relative error of at most {error:e}");
    for problem in problems(rows) {
        let own = |m: &&Measured| m.problem == problem;
        match cheapest(rows.iter().filter(own), error) {
            Some(m) => say!("  {problem}: {} ({}, error {:.1e})", write::words(m), show::seconds(m.seconds), m.error),
            None => {
                let least = rows.iter().filter(own).map(|m| m.error).fold(f64::INFINITY, f64::min);
                say!("  {problem}: none; the best reached {least:.1e}: refine the grid");
            }
        }
    }
}
