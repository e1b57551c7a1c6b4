//! How a running scene talks to whoever watches it. The run loop knows no terminal.

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Run name.
    pub run: &'a str,
    /// Which run of how many, from 0.
    pub index: usize,
    /// Runs in all.
    pub runs: usize,
    /// Steps made.
    pub step: u64,
    /// Simulated time \[s\].
    pub time: f64,
    /// Its end \[s\].
    pub until: f64,
    /// Current time step \[s\].
    pub dt: f64,
}

/// What the watcher wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Go on.
    Continue,
    /// Stop after this step, leave a checkpoint.
    Stop,
}

/// Watches a run.
pub trait Watch {
    /// After every step.
    fn step(&mut self, progress: Progress<'_>) -> Wish;
    /// A line worth printing (a file written, a run begun or done).
    fn note(&mut self, line: &str);
}

/// Watches nothing.
pub struct Silent;

impl Watch for Silent {
    fn step(&mut self, _: Progress<'_>) -> Wish {
        Wish::Continue
    }
    fn note(&mut self, _: &str) {}
}

/// Stops after so many steps in all, for programs that run in portions.
pub struct StopAfter(pub u64);

impl Watch for StopAfter {
    fn step(&mut self, _: Progress<'_>) -> Wish {
        self.0 = self.0.saturating_sub(1);
        if self.0 == 0 { Wish::Stop } else { Wish::Continue }
    }
    fn note(&mut self, _: &str) {}
}
