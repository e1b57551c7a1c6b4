//! Progress: a bar on a terminal, otherwise a plain line about every ten seconds.

use crate::show;
use cf_scene::progress::{Progress, Watch, Wish};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often a plain line is printed.
const EVERY: Duration = Duration::from_secs(10);
/// How often the bar is redrawn.
const REDRAW: Duration = Duration::from_millis(100);
/// Parts of the bar.
const PARTS: u64 = 1000;

/// Shows how runs go on, and passes on the wish to stop.
pub struct Terminal<'a> {
    stop: &'a AtomicBool,
    quiet: bool,
    bar: Option<ProgressBar>,
    pace: Option<Pace>,
    shown: Instant,
}

/// When and where the present run was first seen.
struct Pace {
    run: usize,
    begun: Instant,
    step: u64,
    time: f64,
}

impl<'a> Terminal<'a> {
    /// Prints to standard error; nothing if `quiet`.
    pub fn new(stop: &'a AtomicBool, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr_with_hz(10));
            if let Ok(style) = ProgressStyle::with_template("{bar:28} {percent:>3}%  {wide_msg}") {
                bar.set_style(style.progress_chars("━╸─"));
            }
            bar
        });
        Terminal { stop, quiet, bar, pace: None, shown: Instant::now() }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }

    fn show(&mut self, progress: Progress<'_>) {
        let now = Instant::now();
        if self.pace.as_ref().is_none_or(|pace| pace.run != progress.index) {
            let (step, time) = (progress.step.saturating_sub(1), progress.time - progress.dt);
            self.pace = Some(Pace { run: progress.index, begun: now, step, time });
        }
        let due = if self.bar.is_some() { REDRAW } else { EVERY };
        if now.duration_since(self.shown) < due {
            return;
        }
        self.shown = now;
        let line = self.line(progress, now);
        match &self.bar {
            Some(bar) => {
                bar.set_position((PARTS as f64 * (progress.time / progress.until).clamp(0.0, 1.0)) as u64);
                bar.set_message(line);
            }
            None => complain!("{line}"),
        }
    }

    fn line(&self, progress: Progress<'_>, now: Instant) -> String {
        let Progress { run, index, runs, step, time, until, .. } = progress;
        let mut line = format!("[{}/{runs} {run}] t = {time:.4} of {until} s, step {step}", index + 1);
        if let Some(pace) = &self.pace {
            let elapsed = now.duration_since(pace.begun).as_secs_f64();
            let (steps, went) = ((step - pace.step.min(step)) as f64, time - pace.time);
            if elapsed > 0.0 && went > 0.0 {
                let left = show::seconds(elapsed * (until - time).max(0.0) / went);
                line += &format!(", {:.1} steps/s, {left} left", steps / elapsed);
            }
        }
        line
    }
}

impl Watch for Terminal<'_> {
    fn step(&mut self, progress: Progress<'_>) -> Wish {
        if !self.quiet {
            self.show(progress);
        }
        if self.stop.load(Ordering::Relaxed) { Wish::Stop } else { Wish::Continue }
    }

    fn note(&mut self, line: &str) {
        match &self.bar {
            _ if self.quiet => {}
            Some(bar) => bar.println(line),
            None => complain!("{line}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(step: u64, time: f64) -> Progress<'static> {
        Progress { run: "hc_2", index: 1, runs: 5, step, time, until: 10.0, dt: 0.1 }
    }

    #[test]
    fn a_line_says_where_the_run_is_and_how_long_it_will_take() {
        let stop = AtomicBool::new(false);
        let mut terminal = Terminal::new(&stop, true);
        let begun = Instant::now();
        terminal.pace = Some(Pace { run: 1, begun, step: 0, time: 0.0 });
        let line = terminal.line(at(50, 5.0), begun + Duration::from_secs(10));
        assert_eq!(line, "[2/5 hc_2] t = 5.0000 of 10 s, step 50, 5.0 steps/s, 10 s left");
    }

    #[test]
    fn the_wish_to_stop_is_passed_on() {
        let stop = AtomicBool::new(false);
        let mut terminal = Terminal::new(&stop, true);
        assert_eq!(terminal.step(at(1, 0.1)), Wish::Continue);
        stop.store(true, Ordering::Relaxed);
        assert_eq!(terminal.step(at(2, 0.2)), Wish::Stop);
    }
}
