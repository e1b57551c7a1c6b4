//! `check`: validates a scene, prints the plan of every run, and predicts what each size and level would take.

use crate::cli::{CheckArgs, SceneOptions};
use crate::failure::Failure;
use crate::open::{self, Opened};
use crate::{plan, predict, show};
use cf_scene::{PRESETS, Scene};
use std::path::Path;

/// The levels of the table, with the flags that set them.
const LEVELS: [(&str, &str); 3] = [
    ("draft", "accuracy.level=Draft"),
    ("standard", "accuracy.level=Standard"),
    ("accurate", "accuracy.level=Accurate"),
];

/// Checks a scene file, or a figure.
pub fn check(asked: &CheckArgs) -> Result<(), Failure> {
    let path = Path::new(&asked.scene);
    let is_file = path.is_file() || asked.scene.contains(['/', '\\']);
    let open = |options: &SceneOptions| match is_file {
        true => Ok(vec![open::file(path, options)?]),
        false => open::figure(&asked.scene, options),
    };
    for (index, opened) in open(&asked.options)?.iter().enumerate() {
        print(opened)?;
        if !asked.brief {
            sizes(opened, asked, |options| Ok(open(options)?.swap_remove(index)))?;
        }
        say!("Sound. Run it with `cargo xtask {}`.", opened.request);
    }
    Ok(())
}

fn print(opened: &Opened) -> Result<(), Failure> {
    let experiment = &opened.experiment;
    let title = if experiment.about.title.is_empty() { "Untitled" } else { &experiment.about.title };
    say!("{title} ({}), preset {}", opened.name, experiment.preset.as_deref().unwrap_or("none"));
    say_part!("{}", show::wrap(&experiment.about.text, "  ", 100));
    let mut seconds = 0.0;
    for scene in &experiment.runs {
        seconds += print_run(scene)?;
    }
    match experiment.claims.len() {
        0 => say!("\nThere are no claims to check."),
        1 => say!("\nOne claim will be checked:"),
        count => say!("\n{count} claims will be checked:"),
    }
    for claim in &experiment.claims {
        say!("  {:<10} {:<6} {}", kind(&claim.kind), format!("{:?}", claim.source), claim.name);
    }
    say!(
        "\nPredicted time in all: {} ({seconds:.2} s) without pictures, from steps measured just now.",
        show::seconds(seconds)
    );
    Ok(())
}

fn kind(kind: &cf_scene::spec::Kind) -> &'static str {
    match kind {
        cf_scene::spec::Kind::Must => "must hold",
        cf_scene::spec::Kind::Report => "reported",
        cf_scene::spec::Kind::KnownFalse(_) => "known not to hold",
    }
}

/// Prints one run and gives its predicted seconds.
fn print_run(scene: &Scene) -> Result<f64, Failure> {
    let plan = plan::plan(scene);
    let grid = &scene.grid;
    say!("\n{} ({})", scene.run, scene.label);
    let extent: Vec<String> = grid.extent.iter().map(ToString::to_string).collect();
    say!("  {:<15} {}, h = {:.6} m, box {} m", "cells", show::cells(&grid.cells), grid.spacing, extent.join(" x "));
    say!("  {:<15} {}", "numerics", plan.numerics);
    for (name, value) in plan.lines().into_iter().filter(|(name, _)| *name != "predicted time") {
        say!("  {name:<15} {value}");
    }
    let seconds = predict::seconds(scene, &predict::rate(scene)?);
    let caveat = predict::caveat(scene).map_or_else(String::new, |words| format!(" ({words})"));
    say!("  {:<15} {}{caveat}", "predicted time", show::seconds(seconds));
    let schedule = &scene.schedule;
    say!("  {:<15} {} after the first, to t = {} s", "frames", schedule.frames, schedule.until);
    let memory = scene.memory();
    for row in &memory.rows {
        say!("  {:<15} {:>10}  {}", "memory", show::bytes(row.bytes), row.name);
    }
    say!("  {:<15} {:>10}  in all", "memory", show::bytes(memory.total()));
    scene.warnings.iter().for_each(|warning| say!("  {:<15} {warning}", "warning"));
    Ok(seconds)
}

/// What every size and level would take. Sizes of the same cells are one.
fn sizes(
    opened: &Opened,
    asked: &CheckArgs,
    open: impl Fn(&SceneOptions) -> Result<Opened, Failure>,
) -> Result<(), Failure> {
    let mut seen: Vec<Vec<usize>> = Vec::new();
    let mut rows = Vec::new();
    let mut left_out = Vec::new();
    for preset in PRESETS {
        for (level, flag) in LEVELS {
            let sets = asked.options.sets.iter().cloned().chain([flag.to_owned()]).collect();
            let one = match open(&SceneOptions { preset: preset.to_owned(), sets }) {
                Ok(one) => one.experiment,
                // A size beyond this machine's memory, or a level that the scene's own knobs exclude.
                Err(_) => {
                    left_out.push(format!("{preset} {level}"));
                    continue;
                }
            };
            let cells = one.runs.first().map(|run| run.grid.cells.to_vec()).unwrap_or_default();
            if level == LEVELS[0].0 {
                if seen.contains(&cells) {
                    break;
                }
                seen.push(cells);
            }
            rows.push(predict::Row::of([preset, level], &one)?.entries());
        }
    }
    say!("\nSizes and levels of {}, all {} runs together", opened.name, opened.experiment.runs.len());
    say_part!("{}", show::table(&["size", "level", "cells", "steps", "memory", "time"], &rows));
    if !left_out.is_empty() {
        say!("Not possible here: {}; --preset and --set accuracy.level say why.", left_out.join(", "));
    }
    Ok(())
}
