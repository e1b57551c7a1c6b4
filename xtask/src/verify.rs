//! `verify`: the tables of `cf_diffusion::verify` and `cf_fluid::verify`, printed and judged.

use crate::cli::VerifyArgs;
use crate::failure::Failure;
use crate::{pool, show};
use cf_diffusion::verify;
use std::time::Instant;

/// A table by name.
type Entry = (&'static str, fn() -> verify::Table);

const TABLES: [Entry; 7] = [
    ("amplification", verify::amplification),
    ("orders", verify::orders),
    ("conservation", verify::conservation),
    ("iterations", verify::iterations),
    ("projector", cf_fluid::verify::projector),
    ("vortices", cf_fluid::verify::vortices),
    ("flows", cf_fluid::verify::flows),
];

/// Prints the tables and fails where a row does.
pub fn verify(asked: &VerifyArgs) -> Result<(), Failure> {
    if let (Some(seed), Some(corner)) = (asked.repeat, asked.only.as_deref()) {
        return repeat(corner, seed);
    }
    let wanted = |name: &str| asked.only.as_deref().is_none_or(|part| name.contains(part));
    let mut failed = Vec::new();
    let mut count = 0;
    for (name, table) in TABLES.into_iter().filter(|(name, _)| wanted(name)) {
        count += 1;
        let begun = Instant::now();
        let table = pool::within(pool::threads(None), table)?;
        say!("{name}: {table}{}\n", took(begun));
        if !table.pass() {
            failed.push(name.to_owned());
        }
    }
    let some: Vec<&str> = if wanted("extremes") { Vec::new() } else { corners().filter(|name| wanted(name)).collect() };
    if asked.extremes && (wanted("extremes") || !some.is_empty()) {
        count += 1;
        let begun = Instant::now();
        say!("extremes: {} random cases at the edges of the parameters, seed {}", asked.cases, asked.seed);
        for corner in pool::within(pool::threads(None), || match some.is_empty() {
            true => extremes(asked.cases, asked.seed),
            false => only(&some, asked.cases, asked.seed),
        })? {
            say!("{corner}");
            if !corner.pass {
                failed.push(format!("extremes ({})", corner.name));
            }
        }
        say!("{}\n", took(begun));
    }
    match (count, failed.as_slice()) {
        (0, _) => {
            let names: Vec<&str> = TABLES.iter().map(|(name, _)| *name).collect();
            let corners: Vec<&str> = corners().collect();
            Err(Failure::usage(format!(
                "there is no such table; there are {}, and with --extremes also extremes, of which the corners are {}",
                names.join(", "),
                corners.join(", ")
            )))
        }
        (_, []) => {
            say!("all of it holds");
            Ok(())
        }
        (_, failed) => Err(Failure::failed(format!("not all of it holds: {}", failed.join(", ")))),
    }
}

/// A quarter of the cases are of flows.
fn extremes(cases: usize, seed: u64) -> Vec<verify::Corner> {
    let flows = cases / 4;
    let mut corners = verify::extremes(cases - flows, seed);
    corners.extend(cf_fluid::verify::extremes(flows, seed));
    corners
}

/// The corners of both crates.
fn corners() -> impl Iterator<Item = &'static str> {
    verify::corner_names().into_iter().chain(cf_fluid::verify::corner_names())
}

/// All cases at a few corners.
fn only(names: &[&str], cases: usize, seed: u64) -> Vec<verify::Corner> {
    let each = cases.div_ceil(names.len().max(1));
    let one = |name: &&str| verify::corner(name, each, seed).or_else(|| cf_fluid::verify::corner(name, each, seed));
    names.iter().filter_map(one).collect()
}

/// One case again, with its error if it has one.
fn repeat(corner: &str, seed: u64) -> Result<(), Failure> {
    let found = pool::within(pool::threads(None), || {
        let case = verify::repeat(corner, seed).or_else(|| cf_fluid::verify::repeat(corner, seed));
        case.map(|found| found.map_err(|e| e.to_string()))
    });
    match found? {
        None => {
            Err(Failure::usage(format!("there is no corner `{corner}`; `cargo xtask verify --extremes` lists them")))
        }
        Some(Err(why)) => Err(Failure::failed(format!("{corner}, seed {seed:#x}: {why}"))),
        Some(Ok(worst)) if worst <= 1.0 => {
            say!("ok   {corner}, seed {seed:#x}: {worst:.2e} of what is allowed");
            Ok(())
        }
        Some(Ok(worst)) => Err(Failure::failed(format!("{corner}, seed {seed:#x}: {worst:.2e} times what is allowed"))),
    }
}

fn took(begun: Instant) -> String {
    format!("in {}", show::seconds(begun.elapsed().as_secs_f64()))
}
