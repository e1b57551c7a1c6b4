//! From what was asked for to checked experiments. Nothing is written here.

use crate::cli::SceneOptions;
use crate::failure::Failure;
use crate::figures;
use cf_scene::{Experiment, Limits, SceneFile, Set, catalog};
use std::path::Path;

/// A scene that has passed every check.
#[derive(Debug)]
pub struct Opened {
    /// The scene file's name without its extension.
    pub name: String,
    /// All its runs.
    pub experiment: Experiment,
    /// What was asked for, to ask for it again.
    pub request: String,
}

/// The scenes of a figure, or the one of a name.
pub fn figure(request: &str, options: &SceneOptions) -> Result<Vec<Opened>, Failure> {
    if let Some(figure) = figures::unbuilt(request) {
        let words = format!(
            "{} ({}) is not built yet; `cargo xtask figure` runs {}",
            figure.title(),
            figure.shows,
            figures::built()
        );
        return Err(Failure::usage(words));
    }
    let sets = sets(options)?;
    let open = |scene: &&catalog::CatalogScene| {
        unfold(SceneFile::parse(&scene.file(), scene.text), scene.text, options, &sets).map(|experiment| Opened {
            name: scene.name.to_owned(),
            experiment,
            request: format!("figure {request}"),
        })
    };
    catalog::find(request)?.iter().map(open).collect()
}

/// A scene file.
pub fn file(path: &Path, options: &SceneOptions) -> Result<Opened, Failure> {
    let sets = sets(options)?;
    let shown = path.display().to_string();
    // A path may hold what a terminal or a line of a log should not.
    let shown: String = shown.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    let unreadable = |error: std::io::Error| {
        let words = format!("{shown}: cannot be read: {error}");
        if error.kind() == std::io::ErrorKind::NotFound { Failure::usage(words) } else { Failure::io(words) }
    };
    let size = std::fs::metadata(path).map_err(unreadable)?;
    if !size.is_file() {
        return Err(Failure::usage(format!("{shown}: this is not a file; a scene is one, such as my.ron")));
    }
    if size.len() > LARGEST_FILE {
        let words = format!("{shown}: a scene is a file of at most {} MB", LARGEST_FILE >> 20);
        return Err(Failure::usage(words));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let name = path.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let experiment = unfold(SceneFile::from_bytes(&shown, &bytes), &text, options, &sets)?;
    Ok(Opened { name, experiment, request: format!("run {shown}") })
}

/// Larger scene files are refused unread.
const LARGEST_FILE: u64 = 16 << 20;

fn sets(options: &SceneOptions) -> Result<Vec<Set>, Failure> {
    options.sets.iter().map(|flag| Set::parse(flag).map_err(Failure::from)).collect()
}

fn unfold(
    parsed: Result<SceneFile, cf_scene::Problems>,
    text: &str,
    options: &SceneOptions,
    sets: &[Set],
) -> Result<Experiment, Failure> {
    parsed
        .and_then(|file| file.experiment(Some(&options.preset), sets, &Limits::of_this_machine()))
        .map_err(|problems| Failure::Scene(Box::new(problems), Some(text.to_owned())))
}
