//! `tradeoff` as a user meets it, and its references against each other.

use cf_diffusion::Law;
use serde_json::Value;
use std::fs;
use std::sync::atomic::AtomicBool;
use xtask::{Exit, main_with};

fn run(arguments: &[&str]) -> Exit {
    main_with(["xtask", "tradeoff"].iter().chain(arguments), &AtomicBool::new(false))
}

#[test]
fn a_quick_run_leaves_files_that_programs_read() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    assert_eq!(run(&["--problem", "P4", "--quick", "--target-error", "0.5", "--out", out]), Exit::Fine);
    let csv = fs::read_to_string(folder.path().join("tradeoff.csv")).unwrap();
    let mut lines = csv.lines();
    let columns = lines.next().unwrap().split(',').count();
    assert!(csv.lines().count() > 5 && lines.all(|line| line.split(',').count() == columns), "{csv}");
    let text = fs::read_to_string(folder.path().join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    let rows = summary["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["seconds"].as_f64().unwrap() > 0.0 && row["runs"].as_u64().unwrap() >= 5));
    for order in summary["convergence"].as_array().unwrap() {
        assert!(order["order"].as_f64().unwrap() > 0.3, "{order}");
    }
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("pareto_p4_bell.png") && folder.path().join("pareto_p4_bell.png").is_file());
}

#[test]
fn a_scene_is_traded_against_its_own_tightest_run() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("pulse.ron");
    // In a still medium levels of explicit waves differ in nothing but their numbers.
    let text = "(grid: (cells: (16, 16), extent: (1.0, 1.0)), sides: (x: Periodic, y: Periodic), \
        model: Diffusion(law: (k: 0.04, tau: 1.0, fourier: 0.2), medium: Uniform((1.0, 0.5)), \
        initial: [(shape: Gaussian(center: (0.5, 0.5), width: 0.1), value: 1.0)]), run: (until: 0.5))";
    fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    assert_eq!(run(&[scene.to_str().unwrap(), "--quick", "--out", out.to_str().unwrap()]), Exit::Fine);
    let text = fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&text).unwrap();
    let rows = summary["rows"].as_array().unwrap();
    let error = |level: &str| {
        let row = rows.iter().find(|row| row["level"] == level).unwrap_or_else(|| panic!("no {level} in {summary}"));
        row["error"].as_f64().unwrap()
    };
    assert!(error("accurate") < error("draft") && error("standard") < error("draft"));
    assert_eq!(run(&["no_such.ron", "--out", out.to_str().unwrap()]), Exit::BadInput);
}

/// Transforms with the eigenvalues of cells go over into those of waves as cells shrink: two references, second order.
#[test]
fn the_references_of_p1_meet() {
    let law = Law::cattaneo(0.04, 1.0).unwrap();
    let off = |n: usize| {
        let problem = cf_tradeoff::Problem::gaussian(2, n, law).unwrap();
        let setting = cf_tradeoff::Setting::new(cf_tradeoff::Scheme::Spectral, 1, 1);
        problem.measure(&setting, 0).unwrap().0.error
    };
    let order = (off(128) / off(256)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
}
