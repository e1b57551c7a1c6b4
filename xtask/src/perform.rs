//! The one door to the run loop: a pool of threads around it, exit codes on the way back.

use crate::failure::{Exit, Failure};
use crate::pool;
use cf_scene::progress::Watch;
use cf_scene::summary::Summary;
use cf_scene::{Experiment, Options};

/// Runs an experiment with `options.threads` threads.
pub fn perform<W: Watch + Send>(experiment: &Experiment, options: &Options, watch: &mut W) -> Result<Summary, Failure> {
    pool::within(options.threads, || cf_scene::perform(experiment, options, watch))?.map_err(|error| {
        let exit = match error.failure() {
            cf_scene::Failure::Input => Exit::BadInput,
            cf_scene::Failure::Numerical => Exit::Numerical,
            cf_scene::Failure::Io => Exit::Io,
            cf_scene::Failure::Interrupted => Exit::Interrupted,
        };
        Failure::Words(exit, error.to_string())
    })
}
