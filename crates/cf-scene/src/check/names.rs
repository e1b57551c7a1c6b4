//! Names: of variants, presets and claims, and the references between them.

use super::{Checker, MAX_PROBLEMS};
use crate::error::{Detail, SceneError, shorten};
use crate::experiment::PRESETS;
use crate::spec::{Quantity, SceneSpec, Statement, VariantSpec};
use crate::suggest::{nearest, one_of};
use crate::text::merged::Merged;
use crate::text::path::{Path, Step};
use crate::text::tree::{Node, Shape};
use std::collections::{BTreeSet, HashMap, HashSet};

/// The most runs of one scene.
const MAX_RUNS: usize = 1000;
/// The most characters of a title, a label or the name of a claim.
const LONGEST_LINE: usize = 200;

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
    twins(&mut check, variants);
    for (i, variant) in variants.iter().take(MAX_RUNS).enumerate() {
        one_line(&mut check, &format!("run.variants[{i}].label"), variant.label.as_deref().unwrap_or_default());
    }
    one_line(&mut check, "about.title", &spec.about.title);
    one_line(&mut check, "about.figure", spec.about.figure.as_deref().unwrap_or_default());
    preset_names(&mut check, merged);
    let presets = BTreeSet::from(PRESETS);
    let alone = variants.is_empty().then_some("main");
    let runs: BTreeSet<&str> = variants.iter().map(|variant| variant.name.as_str()).chain(alone).collect();
    let mut seen = HashSet::new();
    for (i, claim) in spec.claims.iter().enumerate() {
        let path = format!("claims[{i}]");
        check.require(!claim.name.trim().is_empty(), &format!("{path}.name"), || Detail::new("a claim needs a name"));
        one_line(&mut check, &format!("{path}.name"), &claim.name);
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
        | Statement::Front { run, .. }
        | Statement::Speed { run, .. } => vec![("run".to_owned(), run)],
        Statement::Monotone { runs, .. } => named(runs).collect(),
        Statement::EqualBits { runs: (a, b) } | Statement::Ratio { runs: (a, b), .. } => {
            vec![("runs[0]".to_owned(), a), ("runs[1]".to_owned(), b)]
        }
        Statement::Order { runs, reference, .. } => {
            named(runs).chain([("reference".to_owned(), reference.as_str())]).collect()
        }
        Statement::MassBudget { .. }
        | Statement::Divergence { .. }
        | Statement::Iterations { .. }
        | Statement::FlowIterations { .. }
        | Statement::NoPressure => Vec::new(),
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

/// Files of names that differ only in case are one file on some systems.
fn twins(check: &mut Checker<'_>, variants: &[VariantSpec]) {
    let mut seen: HashMap<String, &str> = HashMap::new();
    for (i, variant) in variants.iter().take(MAX_RUNS).enumerate() {
        let first = seen.entry(variant.name.to_lowercase()).or_insert(&variant.name);
        check.require(*first == variant.name, &format!("run.variants[{i}].name"), || {
            let (name, first) = (shorten(&variant.name), shorten(first));
            Detail::new(format!("`{name}` differs from `{first}` only in case, which file names may not tell apart"))
        });
    }
}

/// Sizes have the names that `--preset` takes.
fn preset_names(check: &mut Checker<'_>, merged: &Merged) {
    let table = Path(["about", "presets"].map(|key| Step::Key(key.to_owned())).into());
    let Some(Node { shape: Shape::Map(entries), .. }) = merged.tree.get(&table) else { return };
    for (key, _) in entries {
        let Shape::Text(name) = &key.shape else { continue };
        if !PRESETS.contains(&name.as_str()) && check.problems.len() < MAX_PROBLEMS {
            let detail = Detail::new(format!("`{}` is no preset", shorten(name)))
                .expected(one_of(PRESETS))
                .nearest(nearest(name, PRESETS));
            check.problems.push(merged.error(key.span.clone(), detail.at(table.to_string())));
        }
    }
}

/// What stands in tables and headings: one line that is no page.
fn one_line(check: &mut Checker<'_>, path: &str, text: &str) {
    let good = text.chars().count() <= LONGEST_LINE && !text.chars().any(char::is_control);
    check.require(good, path, || {
        Detail::new("this does not fit on a line")
            .expected(format!("at most {LONGEST_LINE} characters, no line break or other control character"))
            .found(format!("{:?}", shorten(text)))
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
        Quantity::Mass
        | Quantity::Maximum
        | Quantity::Minimum
        | Quantity::RadiusOfGyration
        | Quantity::RadiusAbout(_)
        | Quantity::Centre(_)
        | Quantity::EnergyPerWork
        | Quantity::DiffusionSeconds
        | Quantity::PeakMemory => None,
    }
}
