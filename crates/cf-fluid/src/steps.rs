//! The schemes, in the two halves of a step.

use cf_grid::{CellField, FaceField, Real};

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
                self.extrapolate(0.5 * dt);
                self.lift(dt, phi);
                self.projection.impose(&mut self.before);
                observer.end(FlowPhase::Advection);
                Ok(Lent::Before)
            }
            Scheme::ReflectionExtrapolated => {
                // To the middle of the first half step.
                self.extrapolate(0.25 * dt);
                self.copy_next();
                self.push(0.5 * dt, phi);
                self.advect_next(0.5 * dt);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
                let guess = self.ratio(scheme, dt);
                let done = self.project(0, guess, dt, observer)?;
                self.count(done);
                Ok(Lent::Next)
            }
            Scheme::Draft => {
                self.lift(dt, phi);
                self.projection.impose(&mut self.u);
                observer.end(FlowPhase::Advection);
                Ok(Lent::Now)
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
                observer.begin(FlowPhase::Advection);
                self.cnp_carry(dt);
                self.push(self.rest(dt), phi);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
                report.count(self.project_increment(dt, observer)?);
            }
            Scheme::ReflectionExtrapolated => {
                observer.begin(FlowPhase::Advection);
                self.fetch_before();
                // To the middle of the second half step: 1.5 u_m - .5 u^n.
                combine(self.grid.layout(), self.projection.sides(), 1.5, &self.next, 0.0, &mut self.before);
                self.mix_before(-0.5, 1.0);
                // 2 u_m - u~ = u_m - grad s.
                self.projection.subtract_gradient(1.0, &self.potential[0], &mut self.next);
                self.advect_next(0.5 * dt);
                self.push(0.5 * dt, phi);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
                let guess = self.ratio(scheme, dt).powi(2);
                report.count(self.project(1, guess, dt, observer)?);
                self.keep_pressure(&[(0, 2.0 / dt), (1, 1.0 / dt)]);
            }
            Scheme::Draft => {
                observer.begin(FlowPhase::Advection);
                self.draft_carry(dt);
                self.push(self.rest(dt), phi);
                self.set_jets(dt);
                observer.end(FlowPhase::Advection);
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

    /// Where phi pushes: next := u + dt/2 b, while phi is that of the start. It is carried along like u.
    fn lift(&mut self, dt: f64, phi: Option<&CellField<T>>) {
        if self.settings.buoyancy.is_some() {
            self.copy_next();
            self.push(0.5 * dt, phi);
        }
    }

    /// The part of the step for which forces have not pushed yet, after [`lift`](Self::lift).
    fn rest(&self, dt: f64) -> f64 {
        if self.settings.buoyancy.is_some() { 0.5 * dt } else { dt }
    }

    /// Prepares a velocity to carry and to be carried: continues it into solids and beyond walls. The faces of the flow are
    /// those of [`impose`](crate::Projection::impose) again afterwards.
    fn prepare(&self, u: &mut FaceField<T, D>) {
        self.carry.fill_solids(u);
        self.carry.continue_faces(u);
    }

    /// next := `from` carried by `by`, both prepared; all components at once, so that each trajectory is traced once.
    fn advect(&mut self, by: &FaceField<T, D>, from: &FaceField<T, D>, dt: f64, default: Interpolation) {
        let how = self.settings.interpolation.unwrap_or(default);
        let (pool, layout, ratio) = (self.projection.pool().clone(), *self.grid.layout(), dt / self.grid.h());
        let mut back = CellField::default();
        if how == Interpolation::MacCormack {
            pool.fetch(&layout, [&mut back]);
        }
        self.fetch_next();
        let lattices = self.carry.faces.each_ref();
        self.carry.carry_as(how, lattices, by, ratio, from.axes(), self.next.axes_mut(), &mut back);
        pool.release([&mut back]);
    }

    /// next := next carried by before, which is spent.
    fn advect_next(&mut self, dt: f64) {
        let [mut by, mut from] = [std::mem::take(&mut self.before), std::mem::take(&mut self.next)];
        self.prepare(&mut by);
        self.prepare(&mut from);
        self.advect(&by, &from, dt, Interpolation::Cubic);
        let pool = self.projection.pool();
        pool.release(by.fields_mut().iter_mut().chain(from.fields_mut()));
    }

    /// next := A(u' - dt/2 G; e) - dt/2 G with e = before, which is spent, and u' = next if there is one, else u.
    fn cnp_carry(&mut self, dt: f64) {
        let lifted = !self.next.axis(0).is_empty();
        let mut by = std::mem::take(&mut self.before);
        let mut from = std::mem::take(if lifted { &mut self.next } else { &mut self.u });
        self.add_gradient(-0.5 * dt, &mut from);
        self.prepare(&mut by);
        self.prepare(&mut from);
        self.advect(&by, &from, dt, Interpolation::Cubic);
        self.projection.pool().release(by.fields_mut());
        if lifted {
            self.projection.pool().release(from.fields_mut());
        } else {
            // u^n was changed in place, to save a velocity; it comes back up to rounding.
            self.add_gradient(0.5 * dt, &mut from);
            self.projection.impose(&mut from);
            self.u = from;
        }
        let mut next = std::mem::take(&mut self.next);
        self.add_gradient(-0.5 * dt, &mut next);
        self.next = next;
    }

    /// u += factor G.
    fn add_gradient(&self, factor: f64, u: &mut FaceField<T, D>) {
        if let Some(pressure) = &self.pressure {
            self.projection.subtract_gradient(-factor, pressure, u);
        }
    }

    /// next := A(u'; u) with u' = next if there is one, else u.
    fn draft_carry(&mut self, dt: f64) {
        let (mut by, mut from) = (std::mem::take(&mut self.u), std::mem::take(&mut self.next));
        self.prepare(&mut by);
        if from.axis(0).is_empty() {
            self.advect(&by, &by, dt, Interpolation::MacCormack);
        } else {
            self.prepare(&mut from);
            self.advect(&by, &from, dt, Interpolation::MacCormack);
            self.projection.pool().release(from.fields_mut());
        }
        self.projection.impose(&mut by);
        self.u = by;
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
        self.extrapolate(0.5 * dt);
        self.lift(dt, phi);
        self.cnp_carry(dt);
        self.push(self.rest(dt), phi);
        self.set_jets(dt);
        let done = self.project_increment(dt, observer)?;
        self.count(done);
        self.fetch_before();
        if self.history.last.is_none() {
            // before := 2 u - next, so that the extrapolation to the middle is the mean of both ends.
            combine(self.grid.layout(), self.projection.sides(), -1.0, &self.next, 0.0, &mut self.before);
            self.mix_before(2.0, 1.0);
            self.history.last = Some((dt, Scheme::Auto));
        } else {
            // What was before is spent: this step extrapolates from u alone.
            self.mix_before(1.0, 0.0);
        }
        self.drop_next();
        Ok(())
    }

    /// pressure := Σ factor s.
    fn keep_pressure(&mut self, parts: &[(usize, f64)]) {
        let Some(pressure) = &mut self.pressure else { return };
        pressure.fill(T::ZERO);
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
