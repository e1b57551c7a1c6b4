//! Worker threads.

use crate::failure::Failure;
use std::num::NonZero;

/// As many as the machine has, or as asked.
pub fn threads(asked: Option<u16>) -> usize {
    let all = || std::thread::available_parallelism().map_or(1, NonZero::get);
    asked.map_or_else(all, usize::from)
}

/// Runs `work` with this many threads.
pub fn within<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> Result<R, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::io(format!("cannot start {threads} threads: {error}")))?;
    Ok(pool.install(work))
}
