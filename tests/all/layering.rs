//! Which crate may use which: the arrows of ARCHITECTURE.md.

use crate::manifest::{cargo, packages};
use std::collections::BTreeMap;

/// What each crate may use among ours.
fn arrows() -> BTreeMap<&'static str, &'static [&'static str]> {
    BTreeMap::from([
        ("cf-grid", &[][..]),
        ("cf-linear", &["cf-grid"]),
        ("cf-diffusion", &["cf-grid", "cf-linear"]),
        ("cf-fluid", &["cf-diffusion", "cf-grid", "cf-linear"]),
        ("cf-spectral", &["cf-diffusion", "cf-grid"]),
        ("cf-tradeoff", &["cf-diffusion", "cf-fluid", "cf-grid", "cf-linear", "cf-spectral"]),
        ("cf-output", &["cf-grid"]),
        ("cf-scene", &["cf-diffusion", "cf-fluid", "cf-grid", "cf-linear", "cf-output"]),
        ("xtask", &["cf-diffusion", "cf-fluid", "cf-grid", "cf-linear", "cf-output", "cf-scene", "cf-tradeoff"]),
        ("cf-tests", &[]),
    ])
}

#[test]
fn crates_use_only_the_layers_below() {
    let arrows = arrows();
    for package in packages() {
        let name = package.name.as_str();
        let allowed = arrows.get(name).unwrap_or_else(|| panic!("{name} has no place in the layers: give it one here"));
        for need in &package.needs {
            assert!(allowed.contains(&need.as_str()), "{name} may not use {need}");
        }
    }
}

#[test]
fn the_diffusion_core_carries_no_files_and_no_formats() {
    let tree = cargo(&["tree", "-p", "cf-diffusion", "-e", "normal", "--offline", "--prefix", "none"]);
    let names: Vec<&str> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.contains(&"cf-linear"), "{tree}");
    let foreign = [
        "cf-output",
        "cf-scene",
        "serde",
        "serde_json",
        "ron",
        "vtkio",
        "png",
        "crc32fast",
        "flate2",
        "tempfile",
        "clap",
        "indicatif",
        "miette",
    ];
    for name in foreign {
        assert!(!names.contains(&name), "{name} is in the tree of cf-diffusion:\n{tree}");
    }
}
