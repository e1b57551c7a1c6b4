//! `figure` and `run`: runs scenes, writes their files, checks their claims, says where to look.

use crate::cli::{FigureArgs, RunArgs, RunOptions};
use crate::failure::{Exit, Failure};
use crate::open::{self, Opened};
use crate::perform;
use crate::terminal::Terminal;
use crate::{pool, show};
use cf_scene::summary::{ClaimResult, Summary};
use cf_scene::{Options, report};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Runs all scenes of a figure.
pub fn figure(asked: &FigureArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let opened = open::figure(&asked.figure, &asked.options.scene)?;
    let several = opened.len() > 1;
    let folder = |scene: &Opened| match &asked.options.out {
        Some(out) if several => out.join(&scene.name),
        Some(out) => out.clone(),
        None => Path::new("out").join(&scene.name),
    };
    let mut failed = Vec::new();
    for scene in &opened {
        failed.extend(failures(&one(scene, folder(scene), &asked.options, stop)?));
    }
    verdict(&failed)
}

/// Runs the one scene of a figure, with what became of it and the folder of its files.
pub(crate) fn scene(figure: &str, options: &RunOptions, stop: &AtomicBool) -> Result<(Summary, PathBuf), Failure> {
    let opened = open::figure(figure, &options.scene)?;
    let Some(scene) = opened.first() else { return Err(Failure::usage(format!("figure {figure} has no scene"))) };
    let out = options.out.clone().unwrap_or_else(|| Path::new("out").join(&scene.name));
    Ok((one(scene, out.clone(), options, stop)?, out))
}

/// Runs a scene file.
pub fn run(asked: &RunArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let opened = open::file(&asked.scene, &asked.options.scene)?;
    let folder = asked.options.out.clone().unwrap_or_else(|| Path::new("out").join(&opened.name));
    verdict(&failures(&one(&opened, folder, &asked.options, stop)?))
}

pub(crate) fn verdict(failed: &[String]) -> Result<(), Failure> {
    if failed.is_empty() {
        return Ok(());
    }
    let list: String = failed.iter().map(|name| format!("\n  {name}")).collect();
    Err(Failure::failed(format!(
        "{} must hold and {} not:{list}",
        claims(failed.len()),
        if failed.len() == 1 { "does" } else { "do" }
    )))
}

fn claims(count: usize) -> String {
    if count == 1 { "1 claim".to_owned() } else { format!("{count} claims") }
}

/// The claims that failed, in words.
pub(crate) fn failures(summary: &Summary) -> Vec<String> {
    summary
        .failures()
        .map(|claim| format!("{}: expected {}, measured {}", claim.name, claim.expected, claim.measured))
        .collect()
}

/// Runs one scene and says how it went.
fn one(opened: &Opened, out: PathBuf, asked: &RunOptions, stop: &AtomicBool) -> Result<Summary, Failure> {
    let options = Options {
        overrides: asked.scene.sets.clone(),
        threads: pool::threads(asked.threads),
        resume: asked.resume,
        ..Options::new(opened.name.clone(), out)
    };
    let mut terminal = Terminal::new(stop, asked.quiet);
    let outcome = perform::perform(&opened.experiment, &options, &mut terminal);
    terminal.finish();
    let summary = match outcome {
        Err(Failure::Words(Exit::Interrupted, words)) => {
            return Err(Failure::Words(Exit::Interrupted, format!("{words}\ngo on with: {}", again(opened, asked))));
        }
        other => other?,
    };
    let page = report::write(&summary, &options.out)?;
    if !asked.quiet {
        print(&summary, &options.out, &page);
    }
    Ok(summary)
}

/// The command that continues an interrupted one.
fn again(opened: &Opened, asked: &RunOptions) -> String {
    let mut words = vec!["cargo xtask".to_owned(), opened.request.clone()];
    if asked.scene.preset != "standard" {
        words.push(format!("--preset {}", asked.scene.preset));
    }
    words.extend(asked.scene.sets.iter().map(|set| format!("--set '{}'", set.replace('\'', "'\\''"))));
    words.extend(asked.out.iter().map(|out| format!("--out {}", out.display())));
    words.push("--resume".to_owned());
    words.join(" ")
}

fn print(summary: &Summary, out: &Path, page: &Path) {
    let title = if summary.title.is_empty() { &summary.scene } else { &summary.title };
    say!("\n{title} in {}", show::seconds(summary.seconds));
    let rows: Vec<Vec<String>> = summary
        .runs
        .iter()
        .map(|run| {
            let iterations =
                if run.iterations.solves == 0 { "-".into() } else { format!("{:.1}", run.iterations.mean) };
            let projection = run.flow.as_ref().map_or("-".into(), |flow| format!("{:.1}", flow.projections.mean));
            vec![
                run.label.clone(),
                show::cells(&run.cells),
                run.steps.to_string(),
                iterations,
                projection,
                show::seconds(run.seconds.total),
                format!("{:.1e}", run.mass.drift),
            ]
        })
        .collect();
    say_part!("{}", show::table(&["run", "cells", "steps", "iterations", "projection", "time", "mass drift"], &rows));
    for run in &summary.runs {
        run.warnings.iter().for_each(|words| say!("warning: {}: {words}", run.label));
    }
    group(summary, "Must", "Claims that must hold");
    group(summary, "Report", "Reported");
    group(summary, "KnownFalse", "Known not to hold");
    say!("\nLook at");
    say!("  {}", page.display());
    let files = || summary.files.iter().chain(summary.runs.iter().flat_map(|run| &run.files));
    for (end, words) in [(".pvd", "ParaView"), (".png", "pictures"), (".csv", "tables")] {
        let found: Vec<&String> = files().filter(|file| file.ends_with(end)).collect();
        match found.as_slice() {
            [] => {}
            [one] => say!("  {} ({words})", out.join(one).display()),
            [first, ..] => say!("  {} and {} more ({words})", out.join(first).display(), found.len() - 1),
        }
    }
}

fn group(summary: &Summary, kind: &str, title: &str) {
    let claims: Vec<&ClaimResult> = summary.claims.iter().filter(|claim| claim.kind == kind).collect();
    if claims.is_empty() {
        return;
    }
    say!("\n{title}");
    for claim in claims {
        let verdict = match (kind, claim.pass) {
            ("Must", true) => "ok  ",
            ("Must", false) => "FAIL",
            _ => "-   ",
        };
        say!("  {verdict} {} ({})", claim.name, claim.source);
        say!("         expected {}, measured {}", claim.expected, claim.measured);
        claim.reason.iter().for_each(|reason| say!("         {reason}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::SceneOptions;

    #[test]
    fn the_way_to_go_on_repeats_what_was_asked() -> Result<(), Failure> {
        let scene = SceneOptions { preset: "draft".into(), sets: vec!["grid.cells=(32, 64)".into()] };
        let asked = RunOptions { out: Some("a".into()), scene, ..RunOptions::default() };
        let opened = open::figure("3", &asked.scene)?;
        let words = again(&opened[0], &asked);
        assert_eq!(words, "cargo xtask figure 3 --preset draft --set 'grid.cells=(32, 64)' --out a --resume");
        Ok(())
    }

    #[test]
    fn failed_claims_are_counted_and_named() {
        assert!(verdict(&[]).is_ok());
        let Err(Failure::Words(exit, words)) = verdict(&["a".into(), "b".into()]) else { panic!("no failure") };
        assert_eq!((exit, words.as_str()), (Exit::Failed, "2 claims must hold and do not:\n  a\n  b"));
    }
}
