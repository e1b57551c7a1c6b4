//! Steps as long as a tolerance allows.
//!
//! The estimate of [`Integrator::Sdirk2`](crate::Integrator::Sdirk2) for a step of dt is e; a step with e > tol is made
//! again, and the next one is
//!
//! ```text
//! dt <- dt clip(0.9 (tol/e)^0.35, 0.2, 4)
//! ```
//!
//! Both are relative to the largest norm sqrt(2E') met so far, so that a field that has decayed is not followed to digits
//! that no longer matter. The error at the end was measured as 0.8 tol for waves, 0.2 tol for Jeffreys' law, and 0.03 to
//! 0.06 tol where memory is short: the tolerance is met and never missed. What it costs against the best fixed step is
//! little for waves and a factor of three for diffusion, so fixed steps are the default.
//!
//! The estimate sees the diffusion. A moving medium is split from it, and that error it does not see: bound the step with
//! [`Controller::with_longest`] there.

use cf_grid::Real;

use crate::medium::Medium;
use crate::source::Source;
use crate::state::State;
use crate::step_error::StepError;
use crate::stepper::{Diffusion, StepReport};

/// Chooses steps and counts what became of them. Pure arithmetic: the same errors give the same steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Controller {
    tolerance: f64,
    next: f64,
    longest: f64,
    scale: f64,
    /// Steps taken.
    pub accepted: u64,
    /// Steps made again.
    pub rejected: u64,
    /// The shortest and the longest step taken \[s\]; 0 before the first.
    pub taken: [f64; 2],
}

impl Controller {
    /// Where steps shorter than this part of the first one or of the longest are needed, the tolerance is out of reach.
    const SHORTEST: f64 = 1e-9;

    /// A controller for a relative `tolerance` in (0, 1), with a guess of the first step \[s\].
    ///
    /// # Errors
    /// [`StepError::Tolerance`] and [`StepError::TimeStep`] for numbers that are none of these.
    pub fn new(tolerance: f64, first: f64) -> Result<Self, StepError> {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(StepError::Tolerance(tolerance));
        }
        if !(first > 0.0 && first.is_finite()) {
            return Err(StepError::TimeStep(first));
        }
        let (next, longest) = (first, f64::INFINITY);
        Ok(Self { tolerance, next, longest, scale: 0.0, accepted: 0, rejected: 0, taken: [0.0; 2] })
    }

    /// The same, with no step longer than `longest` \[s\].
    pub fn with_longest(mut self, longest: f64) -> Self {
        (self.longest, self.next) = (longest, self.next.min(longest));
        self
    }

    /// The relative tolerance.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The next step \[s\] where `remaining` \[s\] are left: all of it, or an equal part, so that no sliver is left over.
    pub fn propose(&self, remaining: f64) -> f64 {
        let parts = (remaining / self.next - 1e-6).ceil();
        if parts > 1.0 { remaining / parts } else { remaining }
    }

    /// Whether a step of `dt` \[s\] with the estimate `error` stands, and how long the next one is. `size` is the norm of
    /// the state after the step.
    ///
    /// # Errors
    /// [`StepError::OutOfReach`] where rejections have made steps a billionth of what they were.
    pub fn judge(&mut self, dt: f64, error: f64, size: f64) -> Result<bool, StepError> {
        self.scale = self.scale.max(size);
        let relative = if error == 0.0 { 0.0 } else { error / self.scale };
        let factor = (0.9 * (self.tolerance / relative).powf(0.35)).clamp(0.2, 4.0);
        if relative <= self.tolerance {
            // A step that an event cut short says nothing against the longer one that was meant.
            let kept = if factor >= 1.0 { self.next } else { 0.0 };
            self.next = (dt * factor).max(kept).min(self.longest);
            self.accepted += 1;
            let [low, high] = self.taken;
            self.taken = [if low == 0.0 { dt } else { low.min(dt) }, high.max(dt)];
            return Ok(true);
        }
        self.rejected += 1;
        // NaN fails every comparison and takes the shortest way.
        self.next = dt * if factor.is_finite() { factor } else { 0.2 };
        let longest = self.taken[1].max(if self.longest.is_finite() { self.longest } else { dt });
        if self.next < Self::SHORTEST * longest || self.rejected > 1000 + 10 * self.accepted {
            return Err(StepError::OutOfReach { tolerance: self.tolerance, error: relative, dt });
        }
        Ok(false)
    }
}

/// A [`Diffusion`] whose steps a [`Controller`] chooses; keeps a copy of the state to go back to.
///
/// ```
/// use cf_diffusion::{Adaptive, Controller, Diffusion, Law, Medium, Settings, Source, State};
/// use cf_grid::{Grid, Sides, Wall};
///
/// let grid = Grid::<2>::new([32, 32], 1.0 / 32.0)?;
/// let law = Law::jeffreys(0.25, 4.0, 0.1)?;
/// let mut state = State::<f64, 2>::new(&grid, &law);
/// state.phi[grid.layout().slot([16, 16])] = 1.0;
/// let settings = Settings { tolerance: 1e-7, ..Settings::default() };
/// let diffusion = Diffusion::new(&grid, &Sides::all(Wall::CLOSED), None, law, settings)?;
/// let mut adaptive = Adaptive::new(diffusion, Controller::new(1e-2, 1e-3)?)?;
/// let report = adaptive.advance(&mut state, &Medium::Still, Source::NONE, 1.0)?;
/// assert_eq!(report.solves as u64, 2 * (adaptive.controller().accepted + adaptive.controller().rejected));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Adaptive<T, const D: usize> {
    diffusion: Diffusion<T, D>,
    controller: Controller,
    before: State<T, D>,
}

impl<T: Real, const D: usize> Adaptive<T, D> {
    /// Lets `controller` choose the steps of `diffusion`, whose solves should be a hundred times tighter than its tolerance.
    ///
    /// # Errors
    /// [`StepError::NoEstimate`] for integrators other than Sdirk2.
    pub fn new(mut diffusion: Diffusion<T, D>, controller: Controller) -> Result<Self, StepError> {
        diffusion.estimate_errors(true)?;
        let before = State::new(diffusion.grid(), diffusion.law());
        Ok(Self { diffusion, controller, before })
    }

    /// The stepper.
    pub fn diffusion(&self) -> &Diffusion<T, D> {
        &self.diffusion
    }

    /// What was chosen so far.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Advances `state` by exactly `time` \[s\], in as many steps as it takes. The report is of all of them, rejected ones'
    /// solves included; its `error` is the largest of the steps taken.
    ///
    /// # Errors
    /// Those of [`Diffusion::step`] and [`Controller::judge`].
    pub fn advance(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        source: Source<'_, T>,
        time: f64,
    ) -> Result<StepReport, StepError> {
        if !(time.is_finite() && time >= 0.0) {
            return Err(StepError::TimeStep(time));
        }
        let (mut all, mut done) = (StepReport::default(), 0.0);
        while done < time {
            let dt = self.controller.propose(time - done);
            let reversed = self.diffusion.sweep_reversed();
            self.diffusion.check(state, source)?;
            copy(state, &mut self.before);
            let report = self.diffusion.step(state, medium, source, dt)?;
            all.solves += report.solves;
            all.iterations += report.iterations;
            let (error, size) = (report.error.unwrap_or(f64::NAN), self.diffusion.norm(state));
            if !self.controller.judge(dt, error, size)? {
                copy(&self.before, state);
                if self.diffusion.sweep_reversed() != reversed {
                    self.diffusion.set_sweep_reversed(reversed);
                }
                continue;
            }
            all.error = Some(all.error.map_or(error, |most| most.max(error)));
            all.residual = all.residual.max(report.residual);
            all.outflow += report.outflow;
            all.emitted += report.emitted;
            all.transport_substeps += report.transport_substeps;
            done = if dt == time - done { time } else { done + dt };
        }
        Ok(all)
    }
}

fn copy<T: Real, const D: usize>(from: &State<T, D>, to: &mut State<T, D>) {
    to.phi.copy_from_slice(&from.phi);
    if let (Some(from), Some(to)) = (&from.slow_flux, &mut to.slow_flux) {
        to.axes_mut().into_iter().zip(from.axes()).for_each(|(to, from)| to.copy_from_slice(from));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_controller_is_the_formula() -> Result<(), StepError> {
        let mut controller = Controller::new(1e-3, 0.1)?;
        assert_eq!((controller.propose(1.0), controller.propose(0.05)), (0.1, 0.05));
        assert!(controller.judge(0.1, 1e-3 * 0.5, 1.0)?);
        let expected = 0.1 * 0.9 * 2f64.powf(0.35);
        assert!((controller.next - expected).abs() < 1e-15);
        assert!(!controller.judge(0.1, 1.0, 1.0)?);
        assert!((controller.next - 0.02).abs() < 1e-15, "at least a fifth");
        assert!(controller.judge(0.02, 0.0, 1.0)?);
        assert!((controller.next - 0.08).abs() < 1e-15, "at most four times");
        assert_eq!((controller.accepted, controller.rejected, controller.taken), (2, 1, [0.02, 0.1]));
        Ok(())
    }

    #[test]
    fn a_step_cut_short_by_an_event_does_not_shorten_the_next() -> Result<(), StepError> {
        let mut controller = Controller::new(1e-3, 0.1)?;
        assert!(controller.judge(1e-6, 1e-12, 1.0)?);
        assert_eq!(controller.propose(10.0), 0.1);
        Ok(())
    }

    #[test]
    fn errors_that_no_step_brings_down_end_it() -> Result<(), StepError> {
        let mut controller = Controller::new(1e-3, 0.1)?.with_longest(1.0);
        for _ in 0..100 {
            let dt = controller.propose(1.0);
            if let Err(why) = controller.judge(dt, f64::NAN, 1.0) {
                assert!(why.to_string().contains("0.001"), "{why}");
                return Ok(());
            }
        }
        panic!("it never ended");
    }

    #[test]
    fn what_is_no_tolerance_and_no_step_is_refused() {
        for bad in [0.0, 1.0, -1.0, f64::NAN] {
            assert!(matches!(Controller::new(bad, 1.0), Err(StepError::Tolerance(_))));
        }
        for bad in [0.0, f64::INFINITY, f64::NAN] {
            assert!(matches!(Controller::new(0.1, bad), Err(StepError::TimeStep(_))));
        }
    }
}
