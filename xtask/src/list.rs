//! `list`: every figure, what it shows, its sizes and what they cost.

use crate::failure::Failure;
use crate::figures::{FIGURES, Figure};
use crate::{plan, show};
use cf_scene::catalog::CatalogScene;
use cf_scene::{Limits, PRESETS, Problems, SceneFile};

/// Prints the list.
pub fn list() -> Result<(), Failure> {
    let mut rows = Vec::new();
    for figure in FIGURES {
        let before = rows.len();
        for scene in figure.scenes() {
            rows.extend(
                rows_of(figure, scene)
                    .map_err(|problems| Failure::Scene(Box::new(problems), Some(scene.text.to_owned())))?,
            );
        }
        if rows.len() == before {
            let dash = || "-".to_owned();
            rows.push(vec![
                figure.number.into(),
                figure.shows.into(),
                "not yet".into(),
                dash(),
                dash(),
                dash(),
                dash(),
            ]);
        }
    }
    say_part!("{}", show::table(&["figure", "shows", "preset", "runs", "cells", "memory", "time"], &rows));
    say!(
        "\nMemory is the largest run's, time that of all runs on two cores, within a factor of two or three;\npictures of volumes come on top."
    );
    say!("Run one with `cargo xtask figure <figure> --preset <preset>`, look closer with `cargo xtask check`.");
    Ok(())
}

fn rows_of(figure: &Figure, scene: &CatalogScene) -> Result<Vec<Vec<String>>, Problems> {
    let file = SceneFile::parse(&scene.file(), scene.text)?;
    let mut rows = Vec::new();
    for preset in PRESETS {
        let experiment = file.experiment(Some(preset), &[], &Limits { memory: u64::MAX })?;
        let memory = experiment.runs.iter().map(|run| run.memory().total()).max().unwrap_or(0);
        let seconds = experiment.runs.iter().map(|run| plan::plan(run).seconds).sum();
        let cells = experiment.runs.first().map(|run| show::cells(&run.grid.cells)).unwrap_or_default();
        let first = rows.is_empty();
        rows.push(vec![
            if first { figure.number.to_owned() } else { String::new() },
            if first { file.about().title.clone() } else { String::new() },
            preset.to_owned(),
            experiment.runs.len().to_string(),
            cells,
            show::bytes(memory),
            show::seconds(seconds),
        ]);
    }
    Ok(rows)
}
