//! The project's commands as a library, so that tests run what users run: [`main_with`] takes the command line and a
//! flag that asks for a stop, and gives the [`Exit`].
//!
//! One module per command. What they share: `failure` (what went wrong, as an exit code and a caret under the culprit),
//! `open` (from a request to a checked experiment), `plan` (what a run will do), `predict` (what it costs here), `terminal` (progress), `perform`
//! (the one door to the run loop).

#[macro_use]
mod say;

mod bench;
mod check;
mod cli;
mod compare;
mod failure;
mod figure;
mod figures;
mod golden;
mod list;
mod open;
mod perform;
mod plan;
mod pool;
mod predict;
mod regress;
mod show;
mod table;
mod terminal;
mod tradeoff;
mod verify;

use clap::Parser;
use cli::{Command, CommandLine};
use std::ffi::OsString;
use std::sync::atomic::AtomicBool;

pub use failure::Exit;

/// Runs a command line, program name first. When `stop` becomes true, a run ends after its step and leaves a checkpoint.
pub fn main_with(args: impl IntoIterator<Item = impl Into<OsString> + Clone>, stop: &AtomicBool) -> Exit {
    let line = match CommandLine::try_parse_from(args) {
        Ok(line) => line,
        Err(error) => {
            let _ = error.print();
            return if error.use_stderr() { Exit::BadInput } else { Exit::Fine };
        }
    };
    let outcome = match line.command {
        Command::List => list::list(),
        Command::Figure(asked) => figure::figure(&asked, stop),
        Command::Table(asked) => table::table(&asked, stop),
        Command::Run(asked) => figure::run(&asked, stop),
        Command::Check(asked) => check::check(&asked),
        Command::Verify(asked) => verify::verify(&asked),
        Command::Regress(asked) => regress::regress(&asked, stop),
        Command::Bench(asked) => bench::bench(&asked, stop),
        Command::Tradeoff(asked) => tradeoff::tradeoff(&asked, stop),
    };
    outcome.map_or_else(|failure| failure.report(), |()| Exit::Fine)
}
