//! The schemes, in the two halves of a step.

use cf_grid::{CellField, Real};

use crate::carry::Interpolation;
use crate::central::momentum;
use crate::combine::{add, combine};
use crate::error::FlowError;
use crate::fluid::{Fluid, Lent};
use crate::settings::{FlowObserver, FlowPhase, FlowReport, Scheme};

impl<T: Real, const D: usize> Fluid<T, D> {
    /// All that comes before the transport of other quantities; says which velocity carries them.
    pub(crate) fn first_half(
        &mut self,
        scheme: Scheme,
        dt: f64,
        phi: Option<&CellField<T>>,
        observer: &mut dyn FlowObserver,
    ) -> Result<Lent, FlowError> {
        self.hold_emitters(dt)?;
        observer.begin(FlowPhase::Advection);
        match scheme {
            Scheme::Cnp | Scheme::Auto => {
                self.start_pressure(dt, phi, observer)?;
                self.cnp_predictor(dt);
                self.push(0.5 * dt, phi);
                self.projection.impose(&mut self.before);
                observer.end(FlowPhase::Advection);
                Ok(Lent::Before)
            }
            Scheme::ReflectionExtrapolated => {
                // To the middle of the first half step.
                self.extrapolate(0.25 * dt);
                self.copy_next();
                self.push(0.5 * dt, phi);
                self.advect(0.5 * dt, Interpolation::Cubic);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
                let guess = self.ratio(scheme, dt);
                let done = self.project(0, guess, dt, observer)?;
                self.count(done);
                Ok(Lent::Next)
            }
            Scheme::Draft => {
                self.mix_before(1.0, 0.0);
                self.copy_next();
                self.advect(dt, Interpolation::MacCormack);
                self.push(0.5 * dt, phi);
                self.projection.impose(&mut self.before);
                observer.end(FlowPhase::Advection);
                Ok(Lent::Before)
            }
            Scheme::CentralRk4 => {
                self.extrapolate(0.5 * dt);
                self.projection.impose(&mut self.before);
                observer.end(FlowPhase::Advection);
                Ok(Lent::Before)
            }
        }
    }

    /// All that comes after; `next` gets the new velocity.
    pub(crate) fn second_half(
        &mut self,
        scheme: Scheme,
        dt: f64,
        phi: Option<&CellField<T>>,
        report: &mut FlowReport,
        observer: &mut dyn FlowObserver,
    ) -> Result<(), FlowError> {
        match scheme {
            Scheme::Cnp | Scheme::Auto => {
                self.push(0.5 * dt, phi);
                self.set_jets(dt);
                // The increment of the pressure is of second order in the step.
                let guess = self.ratio(scheme, dt).powi(2);
                report.count(self.project(0, guess, dt, observer)?);
                self.keep_pressure(1.0, &[(0, 1.0 / dt)]);
            }
            Scheme::ReflectionExtrapolated => {
                observer.begin(FlowPhase::Advection);
                // To the middle of the second half step: 1.5 u_m - .5 u^n.
                combine(self.grid.layout(), self.projection.sides(), 1.5, &self.next, 0.0, &mut self.before);
                self.mix_before(-0.5, 1.0);
                // 2 u_m - u~ = u_m - grad s.
                self.projection.subtract_gradient(1.0, &self.potential[0], &mut self.next);
                self.push(0.5 * dt, phi);
                self.advect(0.5 * dt, Interpolation::Cubic);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
                let guess = self.ratio(scheme, dt).powi(2);
                report.count(self.project(1, guess, dt, observer)?);
                self.keep_pressure(0.0, &[(0, 2.0 / dt), (1, 1.0 / dt)]);
            }
            Scheme::Draft => {
                self.push(0.5 * dt, phi);
                self.set_jets(dt);
                let guess = self.ratio(scheme, dt);
                report.count(self.project(0, guess, dt, observer)?);
            }
            Scheme::CentralRk4 => self.runge_kutta(dt, phi, report, observer)?,
        }
        Ok(())
    }

    fn count(&mut self, done: crate::Projected) {
        if let Some(stage) = &mut self.stage {
            stage.report.count(done);
        }
    }

    /// dt over the last step's; 0 where that had another scheme.
    fn ratio(&self, scheme: Scheme, dt: f64) -> f64 {
        match self.history.last {
            Some((last, before)) if before == scheme => dt / last,
            _ => 0.0,
        }
    }

    /// before := the velocity `ahead` \[s\] after u^n, from the last two.
    fn extrapolate(&mut self, ahead: f64) {
        let share = self.history.last.map_or(0.0, |(last, _)| ahead / last);
        self.mix_before(1.0 + share, -share);
    }

    /// next carried by before.
    fn advect(&mut self, dt: f64, default: Interpolation) {
        let interpolation = self.settings.interpolation.unwrap_or(default);
        self.carry.fill_solids(&mut self.before);
        self.carry.fill_solids(&mut self.next);
        self.carry.continue_faces(&mut self.before);
        self.carry.continue_faces(&mut self.next);
        let (pool, layout, ratio) = (self.projection.pool().clone(), *self.grid.layout(), dt / self.grid.h());
        // All components at once, so that each trajectory is traced once.
        let mut carried: [CellField<T>; D] = std::array::from_fn(|_| CellField::default());
        pool.fetch(&layout, &mut carried);
        let [back, _] = self.projection.scratch();
        let (lattices, from) = (self.carry.faces.each_ref(), self.next.axes());
        let out = carried.each_mut().map(|out| &mut out[..]);
        self.carry.carry_as(interpolation, lattices, &self.before, ratio, from, out, back);
        self.next.fields_mut().swap_with_slice(&mut carried);
        pool.release(&mut carried);
    }

    /// before := e, next := A(u - dt/2 G; e) - dt/2 G.
    fn cnp_predictor(&mut self, dt: f64) {
        self.extrapolate(0.5 * dt);
        self.cnp_carry(dt);
    }

    fn cnp_carry(&mut self, dt: f64) {
        self.copy_next();
        if let Some(pressure) = &self.pressure {
            self.projection.subtract_gradient(0.5 * dt, pressure, &mut self.next);
        }
        self.advect(dt, Interpolation::Cubic);
        if let Some(pressure) = &self.pressure {
            self.projection.subtract_gradient(0.5 * dt, pressure, &mut self.next);
        }
    }

    /// The first step is made twice: once without pressure, to get it and the velocity at the end.
    fn start_pressure(
        &mut self,
        dt: f64,
        phi: Option<&CellField<T>>,
        observer: &mut dyn FlowObserver,
    ) -> Result<(), FlowError> {
        if self.history.pressure {
            return Ok(());
        }
        if let Some(pressure) = &mut self.pressure {
            pressure.fill(T::ZERO);
        }
        self.cnp_predictor(dt);
        self.push(dt, phi);
        self.set_jets(dt);
        let done = self.project(0, 0.0, dt, observer)?;
        self.count(done);
        self.keep_pressure(0.0, &[(0, 1.0 / dt)]);
        if self.history.last.is_none() {
            // before := 2 u - next, so that the extrapolation to the middle is the mean of both ends.
            combine(self.grid.layout(), self.projection.sides(), -1.0, &self.next, 0.0, &mut self.before);
            self.mix_before(2.0, 1.0);
            self.history.last = Some((dt, Scheme::Auto));
        }
        Ok(())
    }

    /// pressure := keep pressure + Σ factor s.
    fn keep_pressure(&mut self, keep: f64, parts: &[(usize, f64)]) {
        let Some(pressure) = &mut self.pressure else { return };
        if keep == 0.0 {
            pressure.fill(T::ZERO);
        }
        for &(which, factor) in parts {
            add(factor, &self.potential[which], pressure);
        }
        self.history.pressure = true;
    }

    /// Four stages, each projected.
    fn runge_kutta(
        &mut self,
        dt: f64,
        phi: Option<&CellField<T>>,
        report: &mut FlowReport,
        observer: &mut dyn FlowObserver,
    ) -> Result<(), FlowError> {
        let (layout, sides) = (*self.grid.layout(), *self.projection.sides());
        let ratio = dt / self.grid.h();
        self.copy_next();
        let Some([mut slope, mut total]) = self.stages.take() else { return Ok(()) };
        combine(&layout, &sides, 1.0, &self.u, 0.0, &mut total);
        let mut stages = || -> Result<(), FlowError> {
            for (stage, (share, ahead)) in
                [(1.0 / 6.0, 0.5), (1.0 / 3.0, 0.5), (1.0 / 3.0, 1.0), (1.0 / 6.0, 1.0)].into_iter().enumerate()
            {
                observer.begin(FlowPhase::Advection);
                momentum(&layout, &sides, &mut self.next, &mut slope);
                combine(&layout, &sides, share * ratio, &slope, 1.0, &mut total);
                if stage < 3 {
                    self.copy_next();
                    combine(&layout, &sides, ahead * ratio, &slope, 1.0, &mut self.next);
                } else {
                    combine(&layout, &sides, 1.0, &total, 0.0, &mut self.next);
                }
                self.push(ahead * dt, phi);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
                // The potentials of the stages differ by their share of the step only.
                let last = [1.0, 0.5, 0.5, 1.0][stage];
                let guess = if stage == 0 { 0.5 * self.ratio(Scheme::CentralRk4, dt) } else { ahead / last };
                report.count(self.project(0, guess, dt, observer)?);
            }
            Ok(())
        };
        let done = stages();
        self.stages = Some([slope, total]);
        done
    }
}
