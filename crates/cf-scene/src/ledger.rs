//! What a run has counted so far: the numbers behind its summary and its table, kept in checkpoints.

use crate::model::{FlowStep, Totals};
use crate::run::Front;
use crate::sample::Samples;
use cf_diffusion::{Controller, StepReport};
use cf_output::{Cell, OutputError, Table};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The counts of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ledger {
    /// Steps made.
    pub step: u64,
    /// Time reached \[s\].
    pub time: f64,
    /// Mass at the start \[P m^D\].
    pub start: f64,
    /// Added by sources.
    pub emitted: f64,
    /// Left through the walls.
    pub outflow: f64,
    pub solves: usize,
    pub iterations: usize,
    /// The most of one solve.
    pub most_iterations: usize,
    pub residual: f64,
    /// Explicit and transport sub-steps, the most in one step.
    pub substeps: usize,
    pub transport_substeps: usize,
    /// Smallest and largest step \[s\].
    pub dt: Option<(f64, f64)>,
    /// The solved fluid.
    pub flow: FlowCounts,
    /// The controller of adaptive steps.
    pub controller: Option<Controller>,
    /// What samples of steps told of their errors.
    pub samples: Samples,
    /// Wall seconds by phase, and in all.
    pub phases: BTreeMap<String, f64>,
    pub seconds: f64,
    /// One row a frame.
    pub rows: Vec<Row>,
    /// Records of the field files, as JSON.
    pub records: Vec<String>,
    /// Files written.
    pub files: Vec<String>,
    /// `phi` at half time, where a claim needs it.
    pub half: Option<Vec<f64>>,
    /// The front at every frame, where a claim needs it.
    pub fronts: Vec<Front>,
    /// Whether pictures and tables are done.
    pub finished: bool,
}

/// The counts of a solved fluid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FlowCounts {
    /// Steps by scheme.
    pub schemes: BTreeMap<String, u64>,
    pub projections: usize,
    pub iterations: usize,
    /// The most of one projection.
    pub most_iterations: usize,
    pub divergence: f64,
    pub at_floor: u64,
    pub imbalance: f64,
    pub courant: f64,
    pub speed: f64,
    /// ∫ max |u| dt \[m\]: how far it can have carried anything.
    pub carried: f64,
    /// Of buoyancy and force \[m^(D+2)/s²\].
    pub work: f64,
}

impl FlowCounts {
    fn count(&mut self, step: &FlowStep, dt: f64) {
        let report = &step.report;
        *self.schemes.entry(format!("{:?}", report.scheme)).or_default() += 1;
        self.projections += report.projections;
        self.iterations += report.iterations;
        self.most_iterations = self.most_iterations.max(report.most_iterations);
        // What does not balance stays in u, whatever the projection does about the rest.
        self.divergence = self.divergence.max(report.divergence + report.imbalance * dt);
        self.at_floor += u64::from(report.at_floor);
        self.imbalance = self.imbalance.max(report.imbalance);
        self.courant = self.courant.max(report.courant);
        self.speed = self.speed.max(step.speed);
        self.carried += step.speed * dt;
        self.work += step.power * dt;
    }
}

/// One row of the table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    pub frame: u32,
    pub step: u64,
    pub time: f64,
    pub mass: f64,
    pub emitted: f64,
    pub outflow: f64,
    pub magnitude: f64,
    pub min: f64,
    pub max: f64,
}

impl Ledger {
    /// Counts a step of `dt` \[s\], with what a solved fluid did in it.
    pub fn count(&mut self, report: &StepReport, flow: Option<&FlowStep>, dt: f64) {
        self.step += 1;
        flow.iter().for_each(|step| self.flow.count(step, dt));
        self.emitted += report.emitted;
        self.outflow += report.outflow;
        self.solves += report.solves;
        self.iterations += report.iterations;
        self.most_iterations = self.most_iterations.max(report.most_iterations);
        self.residual = self.residual.max(report.residual);
        self.substeps = self.substeps.max(report.substeps);
        self.transport_substeps = self.transport_substeps.max(report.transport_substeps);
        let (low, high) = self.dt.unwrap_or((dt, dt));
        self.dt = Some((low.min(dt), high.max(dt)));
    }

    /// Adds the row of a frame.
    pub fn enter(&mut self, frame: u32, totals: Totals) {
        self.rows.push(Row {
            frame,
            step: self.step,
            time: self.time,
            mass: totals.mass,
            emitted: self.emitted,
            outflow: self.outflow,
            magnitude: totals.magnitude,
            min: totals.min,
            max: totals.max,
        });
    }

    /// What the mass budget misses, relative to the largest of the sum of |phi|, what was emitted, and what was there at the start.
    pub fn drift(&self, totals: Totals) -> f64 {
        let missing = totals.mass - self.start - self.emitted + self.outflow;
        let scale = totals.magnitude.max(self.emitted.abs()).max(self.start.abs());
        if missing == 0.0 { 0.0 } else { missing / scale }
    }

    /// The rows as a table.
    pub fn table(&self) -> Result<Table, OutputError> {
        let mut table = Table::new(&[
            "frame",
            "step",
            "time [s]",
            "mass [P m^D]",
            "emitted [P m^D]",
            "outflow [P m^D]",
            "missing [P m^D]",
            "sum |phi| [P m^D]",
            "min phi [P]",
            "max phi [P]",
        ]);
        for row in &self.rows {
            table.push([
                Cell::Count(row.frame.into()),
                row.step.into(),
                row.time.into(),
                row.mass.into(),
                row.emitted.into(),
                row.outflow.into(),
                (row.mass - self.start - row.emitted + row.outflow).into(),
                row.magnitude.into(),
                row.min.into(),
                row.max.into(),
            ])?;
        }
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mass_budget_is_relative_to_the_largest_of_what_it_says() {
        let drift = |start: f64, emitted: f64, magnitude: f64| {
            let ledger = Ledger { start, emitted, ..Ledger::default() };
            ledger.drift(Totals { mass: start + emitted + 1.0, magnitude, ..Totals::default() })
        };
        assert_eq!(drift(10.0, 0.0, 5.0), 0.1);
        assert_eq!(drift(4.0, 10.0, 5.0), 0.1);
        assert_eq!(drift(4.0, -2.0, 10.0), 0.1);
    }
}
