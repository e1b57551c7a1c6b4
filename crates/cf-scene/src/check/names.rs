//! Names: of variants, presets and claims, and the references between them.

use super::Checker;
use crate::error::{Detail, SceneError, shorten};
use crate::experiment::PRESETS;
use crate::spec::{Quantity, SceneSpec, Statement};
use crate::suggest::{nearest, one_of};
use crate::text::merged::Merged;
use std::collections::{BTreeSet, HashSet};

/// The most runs of one scene.
const MAX_RUNS: usize = 1000;

/// Checks every name and every reference to a name.
pub(crate) fn names(spec: &SceneSpec, merged: &Merged) -> Vec<SceneError> {
    let mut check = Checker::new(merged);
    let variants = &spec.run.variants;
    check.require(variants.len() <= MAX_RUNS, "run.variants", || {
        Detail::new("too many runs").expected(format!("at most {MAX_RUNS}")).found(variants.len().to_string())
    });
    let mut seen = HashSet::new();
    for (i, variant) in variants.iter().take(MAX_RUNS).enumerate() {
        let path = format!("run.variants[{i}].name");
        file_name(&mut check, &path, &variant.name);
        unique(&mut check, &path, &variant.name, &mut seen);
    }
    for preset in spec.about.presets.keys() {
        file_name(&mut check, "about.presets", preset);
    }
    let presets: BTreeSet<&str> = spec.about.presets.keys().map(String::as_str).chain(PRESETS).collect();
    let alone = variants.is_empty().then_some("main");
    let runs: BTreeSet<&str> = variants.iter().map(|variant| variant.name.as_str()).chain(alone).collect();
    let mut seen = HashSet::new();
    for (i, claim) in spec.claims.iter().enumerate() {
        let path = format!("claims[{i}]");
        check.require(!claim.name.trim().is_empty(), &format!("{path}.name"), || Detail::new("a claim needs a name"));
        unique(&mut check, &format!("{path}.name"), &claim.name, &mut seen);
        for (j, preset) in claim.presets.iter().flatten().enumerate() {
            known_name(&mut check, &format!("{path}.presets[{j}]"), "preset", preset, &presets);
        }
        for (place, run) in runs_of(&claim.statement) {
            known_name(&mut check, &format!("{path}.statement.{place}"), "run", run, &runs);
        }
    }
    check.problems
}

/// The runs a statement names, each with its key.
fn runs_of(statement: &Statement) -> Vec<(String, &str)> {
    fn named(runs: &[String]) -> impl Iterator<Item = (String, &str)> {
        runs.iter().enumerate().map(|(i, run)| (format!("runs[{i}]"), run.as_str()))
    }
    match statement {
        Statement::ConeAngle { run, .. }
        | Statement::NoUpstreamTail { run, .. }
        | Statement::Within { run, .. }
        | Statement::Speed { run, .. } => vec![("run".to_owned(), run)],
        Statement::Monotone { runs, .. } => named(runs).collect(),
        Statement::EqualBits { runs: (a, b) } => vec![("runs[0]".to_owned(), a), ("runs[1]".to_owned(), b)],
        Statement::Order { runs, reference, .. } => {
            named(runs).chain([("reference".to_owned(), reference.as_str())]).collect()
        }
        Statement::MassBudget { .. } => Vec::new(),
    }
}

fn known_name(check: &mut Checker<'_>, path: &str, what: &str, name: &str, known: &BTreeSet<&str>) {
    check.require(known.contains(name), path, || {
        Detail::new(format!("there is no {what} called `{}`", shorten(name)))
            .expected(one_of(known.iter().copied()))
            .nearest(nearest(name, known.iter().copied()))
    });
}

fn unique<'a>(check: &mut Checker<'_>, path: &str, name: &'a str, seen: &mut HashSet<&'a str>) {
    check.require(seen.insert(name), path, || {
        Detail::new(format!("the name `{}` is already taken", shorten(name))).advice("give every entry its own name")
    });
}

/// Names become parts of file names.
fn file_name(check: &mut Checker<'_>, path: &str, name: &str) {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    let good = !name.is_empty() && name.len() <= 60 && name.chars().all(plain);
    check.require(good, path, || {
        Detail::new("this name cannot be part of a file name")
            .expected("1 to 60 of a-z, A-Z, 0-9, `_` and `-`")
            .found(format!("{:?}", shorten(name)))
    });
}

/// The source a quantity refers to, with how far upstream of it \[cells\], if it does.
pub(super) fn source_of(quantity: &Quantity) -> Option<usize> {
    match quantity {
        Quantity::UpstreamLeak { source, .. } | Quantity::OutsideCone { source } => Some(*source),
        Quantity::Mass | Quantity::Maximum | Quantity::Minimum | Quantity::RadiusOfGyration => None,
    }
}
