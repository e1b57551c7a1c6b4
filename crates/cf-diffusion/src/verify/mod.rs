//! What this crate claims, measured: rows of numbers with the value expected, for a command or a test to print and judge.
//!
//! | function | claim |
//! |---|---|
//! | [`amplification`] | one step is the matrix of [`exact::amplification`](crate::exact::amplification) on every mode of a box |
//! | [`orders`] | errors fall with the step and the spacing at the promised order |
//! | [`conservation`] | mass is exact at any tolerance; E' never grows; backward Euler's energy identity |
//! | [`iterations`] | multigrid solves need few iterations at any kappa and size |
//! | [`extremes`](extremes()) | random cases at the edges of every parameter |
//!
//! Nothing here is needed for a simulation. Nothing panics: a step that fails makes its row fail and says why.

mod amplification;
mod case;
mod conservation;
mod corners;
mod dense;
mod extremes;
mod iterations;
mod orders;
mod random;

use std::error::Error;
use std::fmt;

pub use amplification::{Precise, amplification, one_step_error};
pub use case::{Case, Kinds};
pub use conservation::conservation;
pub use dense::dense_step;
pub use extremes::{Check, Corner, Edge, corner, corner_names, extremes, repeat};
pub use iterations::iterations;
pub use orders::orders;
pub use random::Random;

/// One claim and what was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// What is measured.
    pub name: String,
    /// Where.
    pub parameters: String,
    /// The value it should have.
    pub expected: f64,
    /// The value found; NaN if it could not be measured.
    pub measured: f64,
    /// Largest difference of the two that passes, on the side that is worse.
    pub tolerance: f64,
    /// Whether it is met.
    pub pass: bool,
    /// Why there is no value, else empty.
    pub note: String,
}

/// What a measurement gives.
pub type Measured<V = f64> = Result<V, Box<dyn Error>>;

impl Row {
    /// A value that should be `expected` within `tolerance`.
    pub fn near(name: &str, parameters: String, expected: f64, tolerance: f64, found: Measured) -> Self {
        let (measured, note) = match found {
            Ok(value) => (value, String::new()),
            Err(why) => (f64::NAN, why.to_string()),
        };
        let pass = (measured - expected).abs() <= tolerance;
        Self { name: name.into(), parameters, expected, measured, tolerance, pass, note }
    }

    /// A value that should be `expected`, no more than `tolerance` below it; larger values pass.
    pub fn at_least(name: &str, parameters: String, expected: f64, tolerance: f64, found: Measured) -> Self {
        let mut row = Self::near(name, parameters, expected, tolerance, found);
        row.pass = row.measured >= expected - tolerance;
        row
    }

    /// A value that should be `expected` within a factor of two.
    pub fn within_two(name: &str, parameters: String, expected: f64, found: Measured) -> Self {
        let mut row = Self::near(name, parameters, expected, expected, found);
        row.pass &= row.measured >= 0.5 * expected;
        row
    }

    /// An error that should be at most `tolerance`; negative values pass.
    pub fn at_most(name: &str, parameters: String, tolerance: f64, found: Measured) -> Self {
        let mut row = Self::near(name, parameters, 0.0, tolerance, found);
        row.pass = row.measured <= tolerance;
        row
    }
}

/// Rows on one subject.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The subject.
    pub title: &'static str,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Table {
    /// Whether every row passes.
    pub fn pass(&self) -> bool {
        self.rows.iter().all(|r| r.pass)
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.title)?;
        for r in &self.rows {
            let verdict = if r.pass { "ok  " } else { "FAIL" };
            write!(f, "{verdict} {:<28} {:<44}", r.name, r.parameters)?;
            write!(f, " {:>10.3e} expected {:.2e} within {:.1e}", r.measured, r.expected, r.tolerance)?;
            writeln!(f, "{}{}", if r.note.is_empty() { "" } else { ": " }, r.note)?;
        }
        Ok(())
    }
}
