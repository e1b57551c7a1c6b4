//! Scenes: from a text that a person writes to a typed description that a program can run.
//!
//! A scene is RON with eight sections in one fixed order: `about`, `grid`, `sides`, `model`, `accuracy`, `run`, `output`,
//! `claims`; only `grid`, `model` and `run` must be there. One file may hold several sizes (`about.presets`) and several
//! runs (`run.variants`); both are overrides `"path.to.key": value` of the scene as written, and so is a `--set` flag.
//! They are spliced into the *text*, which is then decoded as one scene, so a type error in an override is found like any
//! other and reported where it was typed: a line of the file, or the flag.
//!
//! ```
//! use cf_scene::{Limits, Model, SceneFile, Set};
//!
//! let text = r#"(
//!     grid: (cells: (64, 32), extent: (2.0, 1.0)),
//!     sides: (x: Walls(low: Open, high: Absorbing)),
//!     model: Diffusion(
//!         law: (tau: 4.0, cone_angle: 30.0),
//!         medium: Uniform((0.5, 0.0)),
//!         sources: [(shape: Ball(center: (0.5, 0.5), radius: 0.05), rate: 50.0)],
//!     ),
//!     run: (until: 3.0, variants: [(name: "fast"), (name: "slow", set: {"model.law.cone_angle": 10.0})]),
//! )"#;
//! let file = SceneFile::parse("wake.ron", text)?;
//! let finer = Set::parse("grid.cells=(128, 64)")?;
//! let experiment = file.experiment(None, &[finer], &Limits::of_this_machine())?;
//! let Model::Diffusion(model) = &experiment.runs[0].model else { unreachable!() };
//! assert!((model.law.k - 0.25).abs() < 1e-12); // c = |u| sin 30 degrees = 0.25 m/s, k = c² tau
//! assert_eq!(experiment.runs[1].grid.spacing, 1.0 / 64.0);
//!
//! let wrong = SceneFile::parse("wake.ron", &text.replace("tau", "tua")).unwrap_err();
//! assert!(wrong.to_string().starts_with("wake.ron:5:15: model.law: unknown key `tua`"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`SceneFile`] is a file whose text is sound; [`SceneFile::experiment`] unfolds it to an [`Experiment`]: one validated
//! [`Scene`] per run, and the [`Claim`](spec::Claim)s to check. Nothing is allocated for a scene before it has passed, its
//! predicted memory included ([`Scene::memory`]). Errors are [`SceneError`]s with place, path, expectation and advice; no
//! input panics.

mod account;
mod backup;
mod build;
pub mod catalog;
mod check;
mod checkpoint;
mod cloud;
mod coarse;
mod drive;
mod error;
mod experiment;
mod frames;
mod kept;
mod ledger;
mod measure;
mod model;
mod pace;
mod perform;
mod pictures;
pub mod progress;
pub mod report;
mod run;
mod run_error;
mod sample;
mod scene;
mod solid;
pub mod spec;
mod spool;
mod stopwatch;
mod suggest;
pub mod summary;
mod target;
mod text;
mod view;

pub use build::BuildError;
pub use check::{Limits, MemoryRow, MemoryTable};
pub use checkpoint::CheckpointError;
pub use error::{Detail, Place, Problems, SceneError};
pub use experiment::{Experiment, PRESETS, SceneFile};
pub use model::StepFailure;
pub use pace::Pace;
pub use perform::{Options, perform};
pub use run_error::{Failure, RunError};
pub use scene::{Diffusion, Grid, Law, Model, Numerics, Scene, Schedule, SingleField, TimeStep};
pub use suggest::nearest;
pub use text::splice::Set;
