//! Sources W \[P/s\] inside a time step.

/// A rate per cell and the share of the step during which it acts.
///
/// The share makes sources that switch on or off within a step emit exactly what they should; a constant rate over the
/// step is second order for time-dependent sources if it is their mean.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a, T> {
    /// W \[P/s\] per cell slot; `None` for no source.
    pub rate: Option<&'a [T]>,
    /// Acting time over step length, in [0, 1].
    pub share: f64,
}

impl<'a, T> Source<'a, T> {
    /// Nothing is emitted.
    pub const NONE: Self = Self { rate: None, share: 0.0 };

    /// Acting for the whole step.
    pub fn steady(rate: &'a [T]) -> Self {
        Self { rate: Some(rate), share: 1.0 }
    }
}
