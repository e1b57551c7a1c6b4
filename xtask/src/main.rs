//! `cargo xtask`: the project's commands. Ctrl-C asks the running command to stop after its step.

use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

fn main() -> ExitCode {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    let handler = ctrlc::set_handler(move || {
        // The second time at once: a step of a large run may take long.
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        let _ = writeln!(std::io::stderr(), "\nstopping after this step; press Ctrl-C again to stop at once");
    });
    if let Err(error) = handler {
        let _ = writeln!(std::io::stderr(), "warning: Ctrl-C will end the program without a checkpoint ({error})");
    }
    xtask::main_with(std::env::args_os(), &stop).into()
}
