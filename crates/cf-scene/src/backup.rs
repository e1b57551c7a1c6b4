//! A copy of a model's state, to go back to.

use crate::model::{Model, Values, ValuesMut};

/// The state of a model at some time.
#[derive(Default)]
pub(crate) struct Backup {
    parts: Vec<Part>,
    reversed: bool,
}

enum Part {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl Part {
    fn of(values: &Values<'_>) -> Part {
        match values {
            Values::F32(values) => Part::F32(values.to_vec()),
            Values::F64(values) => Part::F64(values.to_vec()),
        }
    }

    fn values(&self) -> Values<'_> {
        match self {
            Part::F32(values) => Values::F32(values),
            Part::F64(values) => Values::F64(values),
        }
    }
}

impl Backup {
    /// Copies the state; the memory of an earlier copy is used again.
    pub fn keep(&mut self, model: &dyn Model) {
        self.reversed = model.reversed();
        let state = model.state();
        if state.len() != self.parts.len() {
            self.parts = state.iter().map(|(_, values)| Part::of(values)).collect();
            return;
        }
        for (part, (_, values)) in self.parts.iter_mut().zip(&state) {
            match (&mut *part, values) {
                (Part::F32(to), Values::F32(from)) if to.len() == from.len() => to.copy_from_slice(from),
                (Part::F64(to), Values::F64(from)) if to.len() == from.len() => to.copy_from_slice(from),
                _ => *part = Part::of(values),
            }
        }
    }

    /// Puts it back.
    pub fn restore(&self, model: &mut dyn Model) {
        for (part, (_, values)) in self.parts.iter().zip(model.state_mut()) {
            match (part, values) {
                (Part::F32(from), ValuesMut::F32(to)) => to.copy_from_slice(from),
                (Part::F64(from), ValuesMut::F64(to)) => to.copy_from_slice(from),
                // The model has one precision from its start to its end.
                _ => {}
            }
        }
        model.set_reversed(self.reversed);
    }
}

/// A copy of `phi`, the first part of the state.
pub(crate) struct PhiCopy(Part);

impl PhiCopy {
    /// Copies it; `None` for a model without state.
    pub fn of(model: &dyn Model) -> Option<Self> {
        model.state().first().map(|(_, values)| PhiCopy(Part::of(values)))
    }

    /// The copy.
    pub fn values(&self) -> Values<'_> {
        self.0.values()
    }
}
