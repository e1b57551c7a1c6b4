//! The memory bandwidth of this machine, by number of threads.

use super::timing::best;
use crate::failure::Failure;
use crate::pool;
use rayon::prelude::*;
use serde_json::{Value, json};

/// Doubles per array: far beyond any cache.
const LENGTH: usize = 1 << 24;

/// Bytes per second for each number of threads.
pub struct Bandwidth(Vec<(usize, f64)>);

impl Bandwidth {
    /// Measures with each of these numbers of threads.
    pub fn measure(threads: &[usize]) -> Result<Self, Failure> {
        threads.iter().map(|&n| Ok((n, pool::within(n, triad)??))).collect::<Result<_, _>>().map(Bandwidth)
    }

    /// Measures again, because other programs may have been busy before: the better rate is the machine's.
    pub fn again(&mut self) -> Result<(), Failure> {
        for (n, rate) in &mut self.0 {
            *rate = rate.max(pool::within(*n, triad)??);
        }
        Ok(())
    }

    /// With this number of threads; not a number where that was not measured.
    pub fn with(&self, threads: usize) -> f64 {
        self.0.iter().find(|(n, _)| *n == threads).map_or(f64::NAN, |(_, rate)| *rate)
    }

    /// A line for each number of threads.
    pub fn print(&self) {
        for (n, rate) in &self.0 {
            say!("stream bandwidth, {n} thread{}: {:.1} GB/s", if *n == 1 { "" } else { "s" }, rate / 1e9);
        }
    }

    /// For `--json`.
    pub fn document(&self) -> Value {
        self.0.iter().map(|(threads, rate)| json!({ "threads": threads, "bytes_per_second": rate })).collect()
    }
}

/// Bytes per second of a = b + s c, three passes.
fn triad() -> Result<f64, Failure> {
    let (mut a, b, c) = (vec![0.0_f64; LENGTH], vec![1.0_f64; LENGTH], vec![2.0_f64; LENGTH]);
    let seconds = best(8, || {
        let rows = a.par_chunks_mut(1 << 14).zip(b.par_chunks(1 << 14)).zip(c.par_chunks(1 << 14));
        rows.for_each(|((a, b), c)| a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 0.5 * c));
        Ok(())
    })?;
    std::hint::black_box(&a);
    Ok(3.0 * (LENGTH * size_of::<f64>()) as f64 / seconds)
}
