//! Appendix A: a pulse on a periodic line, solved exactly mode by mode.

use super::BuildError;
use crate::model::{Model, StepFailure, Totals, Values, ValuesMut};
use crate::scene::{Scene, SingleField};
use crate::spec::{Field, SingleFieldForm};
use crate::stopwatch::Stopwatch;
use crate::summary::{FieldBytes, Range};
use cf_diffusion::exact::SingleField as Form;
use cf_diffusion::{Law, Observer, Phase, StepReport};
use cf_output::{Array, OutputError, Slice};

/// `phi` now, and what it came from.
pub(super) struct SingleFieldModel {
    form: Form,
    law: Law,
    velocity: f64,
    length: f64,
    spacing: f64,
    start: Vec<f64>,
    phi: Vec<f64>,
}

impl SingleFieldModel {
    pub fn new(scene: &Scene, model: &SingleField) -> Result<Self, BuildError> {
        let (grid, pulse) = (&scene.grid, model.pulse);
        let cells = grid.cells.first().copied().unwrap_or(0);
        let (origin, length) = (grid.origin.first().copied().unwrap_or(0.0), grid.spacing * cells as f64);
        let gauss = |x: f64| (-0.5 * (x / pulse.width).powi(2)).exp();
        let at = |i: usize| {
            let x = origin + (i as f64 + 0.5) * grid.spacing - pulse.center;
            gauss(x) + gauss(x - length) + gauss(x + length)
        };
        let phi: Vec<f64> = (0..cells).map(at).collect();
        Ok(SingleFieldModel {
            form: match model.form {
                SingleFieldForm::Printed => Form::Printed,
                SingleFieldForm::Material => Form::Material,
                SingleFieldForm::TwoField => Form::TwoField,
            },
            law: Law::new(model.law.k, model.law.tau, model.law.fourier)?,
            velocity: model.velocity,
            length,
            spacing: grid.spacing,
            start: phi.clone(),
            phi,
        })
    }

    fn range(&self) -> (f64, f64) {
        self.phi.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
    }
}

impl Model for SingleFieldModel {
    fn advance(&mut self, from: f64, dt: f64, watch: &mut Stopwatch) -> Result<StepReport, StepFailure> {
        watch.begin(Phase::Diffusion);
        self.phi = self.form.evolve(&self.start, self.length, &self.law, self.velocity, from + dt);
        watch.end(Phase::Diffusion);
        Ok(StepReport::default())
    }

    fn totals(&self) -> Totals {
        let (min, max) = self.range();
        let magnitude = self.phi.iter().map(|v| v.abs()).sum::<f64>() * self.spacing;
        Totals { mass: self.phi.iter().sum::<f64>() * self.spacing, magnitude, min, max }
    }

    fn arrays(&self, fields: &[Field]) -> Result<Vec<Array<'_>>, OutputError> {
        let phi = || Array::per_cell("phi", [self.phi.len(), 1, 1], |[i, _, _]| [self.phi[i]]);
        Ok(fields.iter().filter(|field| **field == Field::Phi).map(|_| phi()).collect())
    }

    fn phi(&self) -> Vec<f64> {
        self.phi.clone()
    }

    fn layer(&self, _: Slice) -> Vec<f64> {
        self.phi.clone()
    }

    fn flux(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }

    fn fields(&self) -> Vec<FieldBytes> {
        let bytes = std::mem::size_of_val(&self.phi[..]) as u64;
        ["phi", "phi at the start"].map(|name| FieldBytes { name: name.into(), bytes }).into()
    }

    fn ranges(&self) -> Vec<Range> {
        let (min, max) = self.range();
        vec![Range { field: "phi".into(), min, max }]
    }

    fn solver(&self) -> (String, String) {
        ("none".into(), "every mode has a closed form".into())
    }

    fn not_finite(&self) -> Option<(&'static str, Vec<usize>)> {
        self.phi.iter().position(|v| !v.is_finite()).map(|i| ("phi", vec![i]))
    }

    fn state(&self) -> Vec<(&'static str, Values<'_>)> {
        vec![("phi", Values::F64(&self.phi))]
    }

    fn state_mut(&mut self) -> Vec<(&'static str, ValuesMut<'_>)> {
        vec![("phi", ValuesMut::F64(&mut self.phi))]
    }

    fn estimate(&mut self, _: bool) {}

    fn norm(&self) -> f64 {
        0.0
    }

    fn distance(&self, _: Values<'_>) -> [f64; 2] {
        [0.0; 2]
    }

    fn reversed(&self) -> bool {
        false
    }

    fn set_reversed(&mut self, _: bool) {}
}
