//! Wall time by phase: the clock that physics does not have.

use cf_diffusion::{Observer, Phase};
use cf_fluid::{FlowObserver, FlowPhase};
use std::collections::BTreeMap;
use std::time::Instant;

/// Seconds spent in each phase.
#[derive(Debug, Default)]
pub(crate) struct Stopwatch {
    phases: BTreeMap<String, f64>,
    /// Phases under way, each with the seconds spent in phases inside it.
    begun: Vec<(Instant, f64)>,
}

impl Stopwatch {
    /// Goes on from seconds counted before.
    pub fn from_phases(phases: BTreeMap<String, f64>) -> Self {
        Stopwatch { phases, begun: Vec::new() }
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

impl Stopwatch {
    fn start(&mut self) {
        self.begun.push((Instant::now(), 0.0));
    }

    /// Counts a phase without those inside it.
    fn stop(&mut self, name: &str) {
        let Some((begun, inside)) = self.begun.pop() else { return };
        let seconds = begun.elapsed().as_secs_f64();
        if let Some((_, outer)) = self.begun.last_mut() {
            *outer += seconds;
        }
        self.add(name, (seconds - inside).max(0.0));
    }
}

impl Observer for Stopwatch {
    fn begin(&mut self, _: Phase) {
        self.start();
    }

    fn end(&mut self, phase: Phase) {
        self.stop(match phase {
            Phase::Transport => "transport",
            Phase::Diffusion => "diffusion",
        });
    }
}

impl FlowObserver for Stopwatch {
    fn begin(&mut self, _: FlowPhase) {
        self.start();
    }

    fn end(&mut self, phase: FlowPhase) {
        self.stop(match phase {
            FlowPhase::Advection => "advection",
            FlowPhase::Projection => "projection",
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_phase_inside_another_is_not_counted_twice() {
        let mut watch = Stopwatch::default();
        FlowObserver::begin(&mut watch, FlowPhase::Advection);
        FlowObserver::begin(&mut watch, FlowPhase::Projection);
        std::thread::sleep(Duration::from_millis(20));
        FlowObserver::end(&mut watch, FlowPhase::Projection);
        FlowObserver::end(&mut watch, FlowPhase::Advection);
        assert!(watch.seconds("projection") >= 0.02 && watch.seconds("advection") < 0.01);
    }
}
