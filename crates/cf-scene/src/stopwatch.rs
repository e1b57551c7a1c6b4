//! Wall time by phase: the clock that physics does not have.

use cf_diffusion::{Observer, Phase};
use std::collections::BTreeMap;
use std::time::Instant;

/// Seconds spent in each phase.
#[derive(Debug, Default)]
pub(crate) struct Stopwatch {
    phases: BTreeMap<String, f64>,
    begun: Option<Instant>,
}

impl Stopwatch {
    /// Goes on from seconds counted before.
    pub fn from_phases(phases: BTreeMap<String, f64>) -> Self {
        Stopwatch { phases, begun: None }
    }

    pub fn phases(&self) -> &BTreeMap<String, f64> {
        &self.phases
    }

    pub fn seconds(&self, phase: &str) -> f64 {
        self.phases.get(phase).copied().unwrap_or(0.0)
    }

    pub fn add(&mut self, phase: &str, seconds: f64) {
        *self.phases.entry(phase.to_owned()).or_default() += seconds;
    }
}

impl Observer for Stopwatch {
    fn begin(&mut self, _: Phase) {
        self.begun = Some(Instant::now());
    }

    fn end(&mut self, phase: Phase) {
        let name = match phase {
            Phase::Transport => "transport",
            Phase::Diffusion => "diffusion",
        };
        if let Some(begun) = self.begun.take() {
            self.add(name, begun.elapsed().as_secs_f64());
        }
    }
}
