//! `verify`: the tables of `cf_diffusion::verify`, printed and judged.

use crate::cli::VerifyArgs;
use crate::failure::Failure;
use crate::{pool, show};
use cf_diffusion::verify;
use std::time::Instant;

/// A table by name.
type Entry = (&'static str, fn() -> verify::Table);

const TABLES: [Entry; 4] = [
    ("amplification", verify::amplification),
    ("orders", verify::orders),
    ("conservation", verify::conservation),
    ("iterations", verify::iterations),
];

/// Prints the tables and fails where a row does.
pub fn verify(asked: &VerifyArgs) -> Result<(), Failure> {
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
    if asked.extremes && wanted("extremes") {
        count += 1;
        let begun = Instant::now();
        say!("extremes: {} random cases at the edges of the parameters, seed {}", asked.count, asked.seed);
        for corner in pool::within(pool::threads(None), || verify::extremes(asked.count, asked.seed))? {
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
            Err(Failure::usage(format!(
                "there is no such table; there are {}, and extremes with --extremes",
                names.join(", ")
            )))
        }
        (_, []) => {
            say!("all of it holds");
            Ok(())
        }
        (_, failed) => Err(Failure::failed(format!("not all of it holds: {}", failed.join(", ")))),
    }
}

fn took(begun: Instant) -> String {
    format!("in {}", show::seconds(begun.elapsed().as_secs_f64()))
}
