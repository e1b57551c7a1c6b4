//! What holds for every file.

use crate::manifest::{packages, root};
use cf_scene::{SceneFile, catalog};
use std::fs;
use std::path::{Path, PathBuf};

/// More lines than this and a file has more than one subject.
const MOST_LINES: usize = 700;

fn sources() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["crates", "xtask", "tests"] {
        collect(&root().join(folder), &mut found);
    }
    assert!(found.len() > 50, "only {} source files found", found.len());
    found
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() && entry.file_name().is_some_and(|name| name != "target") {
            collect(&entry, found);
        } else if entry.extension().is_some_and(|end| end == "rs") {
            found.push(entry);
        }
    }
}

#[test]
fn files_are_short() {
    for path in sources() {
        let lines = fs::read_to_string(&path).unwrap().lines().count();
        assert!(lines <= MOST_LINES, "{} has {lines} lines, more than {MOST_LINES}", path.display());
    }
}

#[test]
fn no_test_is_switched_off() {
    let word = concat!("#[", "ignore");
    for path in sources() {
        let text = fs::read_to_string(&path).unwrap();
        assert!(!text.contains(word), "{} has a test that does not run", path.display());
    }
}

#[test]
fn every_scene_has_a_golden_and_a_claim_that_must_hold() {
    for scene in catalog::SCENES {
        let golden = root().join("tests/golden").join(format!("{}.txt", scene.name));
        assert!(golden.is_file(), "{} is missing: cargo xtask regress --bless", golden.display());
        let file = SceneFile::parse(&scene.file(), scene.text).unwrap_or_else(|problems| panic!("{problems}"));
        let experiment = file.experiment(None, &[], &cf_scene::Limits { memory: u64::MAX }).unwrap();
        let must = experiment.claims.iter().filter(|claim| claim.kind == cf_scene::spec::Kind::Must);
        assert!(must.count() > 0, "{} claims nothing", scene.name);
    }
}

#[test]
fn every_scene_file_is_in_the_catalog() {
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known = catalog::SCENES.iter().any(|scene| format!("{}.ron", scene.name) == name);
        assert!(known, "scenes/{name} is not in the catalog");
    }
}

#[test]
fn the_architecture_names_every_crate() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    for package in packages() {
        assert!(text.contains(&format!("`{}`", package.name)), "ARCHITECTURE.md does not name {}", package.name);
    }
}

/// Every `name_of_a_test` that the map quotes in backticks after "test" exists, and so does every file.
#[test]
fn the_paper_map_names_only_what_exists() {
    let all: String = sources().iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    let map = fs::read_to_string(root().join("docs/paper-map.md")).unwrap();
    let quoted = map.split('`').skip(1).step_by(2);
    for name in quoted
        .filter(|name| name.contains('_') && name.chars().all(|c| c.is_ascii_lowercase() || "_0123456789".contains(c)))
    {
        assert!(all.contains(&format!("fn {name}")), "docs/paper-map.md names `{name}`, which does not exist");
    }
}
