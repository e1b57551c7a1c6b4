//! `tradeoff`: what accuracy costs, on problems with known solutions (model/diffusion.md 7).
//!
//! `problem` has the problems, `setting` the knobs, `sweep` the combinations, `measure` runs one, `orders` repeats the
//! table of 6.1, `claims` judges, `write` and `pictures` make the files.

mod claims;
mod measure;
mod orders;
mod pictures;
mod problem;
mod setting;
mod sweep;
mod write;

use crate::bench::stream::Bandwidth;
use crate::cli::{Canonical, TradeoffArgs};
use crate::failure::Failure;
use crate::{pool, show};
use claims::Claim;
use setting::{Measured, cheapest};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use sweep::Sweep;
use write::Found;

/// Measures, writes, prints; fails where a claim does.
pub fn tradeoff(asked: &TradeoffArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let wants = |problem: Canonical| asked.problem == problem || asked.problem == Canonical::All;
    let threads = pool::threads(None);
    for folder in [Some(&asked.out), asked.docs.as_ref()].into_iter().flatten() {
        std::fs::create_dir_all(folder)
            .map_err(|error| Failure::io(format!("cannot make the folder {}: {error}", folder.display())))?;
    }
    let mut bandwidth = Bandwidth::measure(&[1, threads][usize::from(threads == 1)..])?;
    let mut sweep = Sweep { quick: asked.quick, threads, stop, rows: vec![], shown: vec![] };
    let mut orders = Vec::new();
    let mut claims = Vec::new();
    if wants(Canonical::P1) {
        orders = orders::orders(threads)?;
        claims.push(claims::table(&orders));
        sweep.p1()?;
        claims.push(claims::cheaper(&sweep.rows));
    }
    if wants(Canonical::P2) {
        sweep.p2()?;
        claims.extend(claims::fronts(&sweep.rows));
    }
    bandwidth.again()?;
    let found = Found { rows: &sweep.rows, orders: &orders, claims: &claims, bandwidth: &bandwidth, threads };
    say(&found);
    files(&found, &sweep, &asked.out)?;
    if let Some(docs) = &asked.docs {
        let pictures = drawn(&found, &sweep, docs)?;
        cf_output::write_text(&docs.join("README.md"), &write::page(&found, &pictures))?;
    }
    if let Some(error) = asked.target_error {
        recommend(&sweep.rows, error);
    }
    say!("\nwritten to {}", asked.out.display());
    let failed: Vec<&str> = claims.iter().filter(|c| !c.pass).map(|c| c.name.as_str()).collect();
    if failed.is_empty() { Ok(()) } else { Err(Failure::failed(format!("does not hold: {}", failed.join("; ")))) }
}

fn say(found: &Found<'_>) {
    if !found.orders.is_empty() {
        say!("Errors in time on a line of 256 cells (model 6.1), 2-norm relative to the spectral integrator");
        say!("{}", show::table(&write::ORDERS, &write::orders(found.orders)));
    }
    let (heads, rows) = write::table(found.rows.iter());
    say!("Error of phi (2-norm, relative) against");
    for reference in problem::REFERENCES {
        say!("  {reference}");
    }
    say!("\"in time\": against the spectral integrator on the same grid. Median of three runs or more.\n");
    say!("{}", show::table(&heads, &rows));
    found.bandwidth.print();
    for Claim { name, measured, pass } in found.claims {
        say!("{} {name}: {measured}", if *pass { "holds" } else { "FAILS" });
    }
}

fn files(found: &Found<'_>, sweep: &Sweep<'_>, out: &Path) -> Result<(), Failure> {
    write::csv(found.rows, &out.join("tradeoff.csv"))?;
    write::summary(found, &out.join("summary.json"))?;
    let pictures = drawn(found, sweep, out)?;
    Ok(cf_output::write_text(&out.join("tradeoff.md"), &write::page(found, &pictures))?)
}

/// A Pareto plot per problem and the pictures of the fronts, by name.
fn drawn(found: &Found<'_>, sweep: &Sweep<'_>, out: &Path) -> Result<Vec<String>, Failure> {
    let mut names = Vec::new();
    for problem in problems(found.rows) {
        let rows: Vec<&Measured> = found.rows.iter().filter(|m| m.problem == problem).collect();
        let words: Vec<String> = problem
            .split(|c: char| !c.is_ascii_alphanumeric())
            .filter(|w| !w.is_empty())
            .map(str::to_lowercase)
            .collect();
        let name = format!("pareto_{}.png", words.join("_"));
        pictures::pareto(problem, &rows).write_png(&out.join(&name))?;
        names.push(name);
    }
    let fronts = pictures::fronts(&sweep.shown, out)?;
    names.extend(fronts.iter().filter_map(|path| Some(path.file_name()?.to_str()?.to_owned())));
    Ok(names)
}

/// The problems in their order.
fn problems(rows: &[Measured]) -> Vec<&str> {
    let mut names: Vec<&str> = rows.iter().map(|m| m.problem.as_str()).collect();
    names.dedup();
    names
}

/// The cheapest setting for an error, problem by problem.
fn recommend(rows: &[Measured], error: f64) {
    say!("\nCheapest setting with a relative error of at most {error:e}");
    for problem in problems(rows) {
        let own = |m: &&Measured| m.problem == problem;
        match cheapest(rows.iter().filter(own), error) {
            Some(m) => say!("  {problem}: {} ({}, error {:.1e})", m.words(), show::seconds(m.seconds), m.error),
            None => {
                let least = rows.iter().filter(own).map(|m| m.error).fold(f64::INFINITY, f64::min);
                say!("  {problem}: none; the best reached {least:.1e}: refine the grid");
            }
        }
    }
}
