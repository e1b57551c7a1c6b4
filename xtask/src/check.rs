//! `check`: validates a scene and prints the plan of every run.

use crate::cli::CheckArgs;
use crate::failure::Failure;
use crate::open::{self, Opened};
use crate::{plan, show};
use cf_scene::Scene;
use std::path::Path;

/// Checks a scene file, or a figure.
pub fn check(asked: &CheckArgs) -> Result<(), Failure> {
    let path = Path::new(&asked.scene);
    let is_file = path.is_file() || asked.scene.contains(['/', '\\']);
    let opened =
        if is_file { vec![open::file(path, &asked.options)?] } else { open::figure(&asked.scene, &asked.options)? };
    opened.iter().for_each(print);
    Ok(())
}

fn print(opened: &Opened) {
    let experiment = &opened.experiment;
    let title = if experiment.about.title.is_empty() { "Untitled" } else { &experiment.about.title };
    say!("{title} ({}), preset {}", opened.name, experiment.preset.as_deref().unwrap_or("none"));
    say_part!("{}", show::wrap(&experiment.about.text, "  ", 100));
    let mut seconds = 0.0;
    for scene in &experiment.runs {
        seconds += print_run(scene);
    }
    match experiment.claims.len() {
        0 => say!("\nThere are no claims to check."),
        1 => say!("\nOne claim will be checked:"),
        count => say!("\n{count} claims will be checked:"),
    }
    for claim in &experiment.claims {
        say!("  {:<10} {:<6} {}", kind(&claim.kind), format!("{:?}", claim.source), claim.name);
    }
    say!("\nPredicted time in all: about {} on two cores, within a factor of two or three.", show::seconds(seconds));
    say!("Sound. Run it with `cargo xtask {}`.", opened.request);
}

fn kind(kind: &cf_scene::spec::Kind) -> &'static str {
    match kind {
        cf_scene::spec::Kind::Must => "must hold",
        cf_scene::spec::Kind::Report => "reported",
        cf_scene::spec::Kind::KnownFalse(_) => "known not to hold",
    }
}

/// Prints one run and gives its predicted seconds.
fn print_run(scene: &Scene) -> f64 {
    let plan = plan::plan(scene);
    let grid = &scene.grid;
    say!("\n{} ({})", scene.run, scene.label);
    let extent: Vec<String> = grid.extent.iter().map(ToString::to_string).collect();
    say!("  {:<15} {}, h = {:.6} m, box {} m", "cells", show::cells(&grid.cells), grid.spacing, extent.join(" x "));
    say!("  {:<15} {}", "numerics", plan.numerics);
    for (name, value) in plan.lines() {
        say!("  {name:<15} {value}");
    }
    let schedule = &scene.schedule;
    say!("  {:<15} {} after the first, to t = {} s", "frames", schedule.frames, schedule.until);
    let memory = scene.memory();
    for row in &memory.rows {
        say!("  {:<15} {:>10}  {}", "memory", show::bytes(row.bytes), row.name);
    }
    say!("  {:<15} {:>10}  in all", "memory", show::bytes(memory.total()));
    scene.warnings.iter().for_each(|warning| say!("  {:<15} {warning}", "warning"));
    plan.seconds
}
