//! Sources W \[P/s\] inside a time step.

use cf_grid::{CellField, Layout, Real};

/// A rate per cell and the share of the step during which it acts.
///
/// The share makes sources that switch on or off within a step emit exactly what they should; a constant rate over the
/// step is second order for time-dependent sources if it is their mean.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a, T> {
    /// W; `None` for no source.
    pub rate: Option<Rate<'a, T>>,
    /// Acting time over step length, in [0, 1].
    pub share: f64,
}

impl<'a, T> Source<'a, T> {
    /// Nothing is emitted.
    pub const NONE: Self = Self { rate: None, share: 0.0 };

    /// Acting for the whole step.
    pub fn steady(rate: impl Into<Rate<'a, T>>) -> Self {
        Self::during(rate, 1.0)
    }

    /// Acting for a share of the step, in [0, 1].
    pub fn during(rate: impl Into<Rate<'a, T>>, share: f64) -> Self {
        Self { rate: Some(rate.into()), share }
    }
}

/// W \[P/s\] of a stretch of cell slots; it is zero in all others. A slice counts from slot 0.
///
/// Sources are mostly small: the planes that hold one take a few percent of a field.
#[derive(Debug, Clone, Copy)]
pub struct Rate<'a, T> {
    /// The slot of the first value.
    pub first: usize,
    /// The values, rim included.
    pub values: &'a [T],
}

impl<'a, T> From<&'a [T]> for Rate<'a, T> {
    fn from(values: &'a [T]) -> Self {
        Self { first: 0, values }
    }
}

impl<'a, T> From<&'a Vec<T>> for Rate<'a, T> {
    fn from(values: &'a Vec<T>) -> Self {
        values.as_slice().into()
    }
}

impl<'a, T> From<&'a CellField<T>> for Rate<'a, T> {
    fn from(values: &'a CellField<T>) -> Self {
        values[..].into()
    }
}

impl<'a, T: Real> Rate<'a, T> {
    /// Its part within the `len` slots from `slot` on: how many of them come before it, and its values.
    #[inline(always)]
    pub fn within(&self, slot: usize, len: usize) -> (usize, &'a [T]) {
        let (low, high) = (slot.max(self.first), (slot + len).min(self.first + self.values.len()));
        if low < high { (low - slot, &self.values[low - self.first..high - self.first]) } else { (0, &[]) }
    }

    /// W of a slot.
    pub fn at(&self, slot: usize) -> T {
        slot.checked_sub(self.first).and_then(|i| self.values.get(i)).copied().unwrap_or(T::ZERO)
    }

    /// Σ W over the cells that `counts` by slot.
    pub fn sum<const D: usize>(&self, layout: &Layout<D>, counts: impl Fn(usize) -> bool + Sync) -> f64 {
        layout.par_runs(layout.cells_region(), (), |run, ()| {
            let (skipped, values) = self.within(run.slot(), run.len());
            let slots = run.slot() + skipped..;
            slots.zip(values).map(|(slot, w)| if counts(slot) { w.f64() } else { 0.0 }).sum::<f64>()
        })
    }

    /// The slots of a field that it belongs to: `slots` for a stretch that lies within so many. One that begins at slot 0 is a
    /// whole field.
    pub fn reach(&self, slots: usize) -> usize {
        let end = self.first.saturating_add(self.values.len());
        if self.first > 0 && end <= slots { slots } else { end }
    }
}
