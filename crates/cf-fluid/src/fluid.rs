//! The flow: velocity, pressure and the two halves of a step.

use cf_diffusion::Medium;
use cf_grid::{CellField, FaceField, Grid, Mask, Pool, Real, Sides, once};

use crate::calculus::max_speed;
use crate::carry::Carry;
use crate::combine::{combine, push, scale};
use crate::emit::{Emitter, Jet};
use crate::error::FlowError;
use crate::gates::Held;
use crate::project::Projection;
use crate::settings::{FlowObserver, FlowPhase, FlowReport, FlowSettings, Scheme};
use crate::wall::FlowWall;

/// An incompressible inviscid flow u_t + (u·grad) u = -(1/rho) grad p + b, div u = 0 on the MAC grid.
///
/// A step has two halves, between which a quantity can be carried by the velocity of the middle of the step:
/// [`begin`](Self::begin) gives that velocity, [`finish`](Self::finish) ends the step; [`step`](Self::step) is both.
///
/// Memory between steps: two velocities ([`Scheme::Draft`]: one), one to three scalars for pressures, and the levels of the solver. Within
/// a step there are two velocities at a time, three with buoyancy; they, transport and solves take turns with the arrays of a pool, five
/// besides these velocities, which can be [shared](Self::share).
pub struct Fluid<T, const D: usize> {
    pub(crate) grid: Grid<D>,
    pub(crate) settings: FlowSettings<D>,
    pub(crate) carry: Carry<D>,
    pub(crate) projection: Projection<T, D>,
    /// u^n.
    pub(crate) u: FaceField<T, D>,
    /// u^(n-1) between steps; the advecting velocity within one; empty where there is none.
    pub(crate) before: FaceField<T, D>,
    /// What becomes u^(n+1); empty where there is none.
    pub(crate) next: FaceField<T, D>,
    /// p/(rho h) \[m/s²\]: the gradient that [`Scheme::Cnp`] carries.
    pub(crate) pressure: Option<CellField<T>>,
    /// s of the last step's projections \[m/s\], guesses for the next; empty for schemes that keep none.
    pub(crate) potential: [CellField<T>; 2],
    /// Stages of [`Scheme::CentralRk4`].
    pub(crate) stages: Option<[FaceField<T, D>; 2]>,
    pub(crate) emitters: Vec<(Emitter<D>, Vec<Held>)>,
    pub(crate) time: f64,
    pub(crate) history: History,
    pub(crate) stage: Option<Stage>,
    /// Scratch of a fluid on its own; no pool where it [shares](Self::share) another.
    pub(crate) own: Pool<T>,
    /// The velocity lent to the transport, and whose place it left empty.
    pub(crate) medium: Medium<T, D>,
    lent: Lent,
}

/// What earlier steps left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct History {
    /// Length \[s\] and scheme of the last step; `None` where `before` and the pressure say nothing.
    pub last: Option<(f64, Scheme)>,
    /// Whether `pressure` holds the pressure.
    pub pressure: bool,
}

/// A step under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stage {
    pub dt: f64,
    pub report: FlowReport,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Lent {
    Nothing,
    Now,
    Before,
    Next,
}

impl<T: Real, const D: usize> Fluid<T, D> {
    /// Fluid at rest on `grid` between `sides`, around the solids of `mask`.
    pub fn new(
        grid: &Grid<D>,
        sides: &Sides<FlowWall<D>, D>,
        mask: Option<&Mask<D>>,
        settings: FlowSettings<D>,
    ) -> Result<Self, FlowError> {
        (compiled::<T, D>().new)(grid, sides, mask, settings)
    }

    fn new_here(
        grid: &Grid<D>,
        sides: &Sides<FlowWall<D>, D>,
        mask: Option<&Mask<D>>,
        settings: FlowSettings<D>,
    ) -> Result<Self, FlowError> {
        settings.check()?;
        let layout = grid.layout();
        let own = Pool::new();
        let mut projection = Projection::new(grid, sides, mask, settings.precision)?;
        projection.share(&own);
        let faces = || FaceField::new(layout);
        let scalar = || CellField::new(layout);
        let kept = settings.scheme.potentials();
        Ok(Self {
            grid: *grid,
            settings,
            carry: Carry::new(layout, sides, mask),
            projection,
            u: faces(),
            before: if settings.scheme.keeps_before() { faces() } else { FaceField::default() },
            next: FaceField::default(),
            pressure: settings.scheme.keeps_pressure().then(scalar),
            potential: std::array::from_fn(|which| if which < kept { scalar() } else { CellField::default() }),
            stages: (settings.scheme == Scheme::CentralRk4).then(|| [faces(), faces()]),
            emitters: Vec::new(),
            time: 0.0,
            history: History::default(),
            stage: None,
            own,
            medium: Medium::Still,
            lent: Lent::Nothing,
        })
    }

    /// Adds emitters; only their jets matter here.
    pub fn with_emitters(mut self, emitters: &[Emitter<D>]) -> Result<Self, FlowError> {
        for emitter in emitters {
            emitter.check()?;
            let faces = emitter.faces(&self.grid, self.projection.sides(), self.projection.mask());
            self.emitters.push((*emitter, faces));
        }
        Ok(self)
    }

    /// From now on scratch comes from `pool` and goes back to it within each half of a step.
    pub fn share(&mut self, pool: &Pool<T>) {
        self.projection.share(pool);
        self.own = Pool::default();
    }

    /// Sets the velocity \[m/s\], makes it free of divergence, and forgets earlier steps.
    pub fn set_velocity(&mut self, u: &FaceField<T, D>) -> Result<FlowReport, FlowError> {
        (compiled::<T, D>().set_velocity)(self, u)
    }

    fn set_velocity_here(&mut self, u: &FaceField<T, D>) -> Result<FlowReport, FlowError> {
        self.give_back();
        self.stage = None;
        for a in 0..D {
            let (expected, found) = (self.grid.layout().slots(), u.axis(a).len());
            if expected != found {
                return Err(FlowError::Layout { what: "the velocity", expected, found });
            }
            self.u.axis_mut(a).copy_from_slice(u.axis(a));
        }
        // What was before is nothing now, and its arrays serve the solve.
        self.drop_before();
        // A velocity moved over a cell is to be as free of divergence as a step would leave it.
        let speed = max_speed(self.grid.layout(), self.projection.sides(), &self.u);
        let dt = if speed > 0.0 { self.grid.h() / speed } else { 0.0 };
        let mut report = FlowReport::default();
        let mut potential = CellField::default();
        self.projection.pool().fetch(self.grid.layout(), [&mut potential]);
        let done = self.projection.project(&mut self.u, &mut potential, dt, self.settings.eta_div);
        self.projection.pool().release([&mut potential]);
        self.projection.release();
        self.forget();
        report.count(done?);
        Ok(report)
    }

    /// The velocity \[m/s\] on faces: zero in solids, held values on closed faces.
    pub fn velocity(&self) -> &FaceField<T, D> {
        match (&self.medium, self.lent) {
            (Medium::Field(u), Lent::Now) => u,
            _ => &self.u,
        }
    }

    /// Between steps, every field that the next one depends on, with its rim: u and u before it along each axis, the pressure
    /// where it is kept, the potentials of all projections. With [`memory`](Self::memory), all that a resumed run needs.
    pub fn state(&self) -> Vec<&[T]> {
        let scalars = self.pressure.iter().chain(&self.potential).map(|field| &field[..]);
        let parts = self.u.axes().into_iter().chain(self.before.axes()).chain(scalars);
        parts.filter(|part| !part.is_empty()).collect()
    }

    /// The same, to be filled.
    pub fn state_mut(&mut self) -> Vec<&mut [T]> {
        self.give_back();
        let scalars = self.pressure.iter_mut().chain(&mut self.potential).map(|field| &mut field[..]);
        let parts = self.u.axes_mut().into_iter().chain(self.before.axes_mut()).chain(scalars);
        parts.filter(|part| !part.is_empty()).collect()
    }

    /// What the next step knows of the last one besides the fields: its length \[s\] (0: there was none), its scheme, and
    /// whether there is a pressure.
    pub fn memory(&self) -> [f64; 3] {
        let (length, scheme) =
            self.history.last.map_or((0.0, 0.0), |(length, scheme)| (length, f64::from(scheme as u8)));
        [length, scheme, f64::from(u8::from(self.history.pressure))]
    }

    /// Takes up the [`memory`](Self::memory) of another run; what is none counts as no last step.
    pub fn recall(&mut self, [length, scheme, pressure]: [f64; 3]) {
        let known = [Scheme::Auto, Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft, Scheme::CentralRk4];
        let scheme = known.into_iter().find(|known| f64::from(*known as u8) == scheme);
        let last = scheme.filter(|_| length > 0.0 && length.is_finite()).map(|scheme| (length, scheme));
        self.history = History { last, pressure: pressure == 1.0 };
    }

    /// Advances the velocity by `dt` \[s\]. `dt` = 0 changes nothing. Buoyancy needs [`begin`](Self::begin) and
    /// [`finish`](Self::finish).
    pub fn step(&mut self, dt: f64) -> Result<FlowReport, FlowError> {
        self.begin(dt, None, &mut ())?;
        self.finish(None, &mut ())
    }

    /// Begins a step of `dt` \[s\] and returns the velocity that carries other quantities over it: that of the middle of
    /// the step, free of divergence to eta_div; u^n for [`Scheme::Draft`]. `phi` causes buoyancy, as it is now.
    ///
    /// # Errors
    /// A step that is not finite and >= 0, one begun twice, missing `phi`, velocities that are not finite, and solves that do not
    /// converge. A step that failed is abandoned.
    pub fn begin(
        &mut self,
        dt: f64,
        phi: Option<&CellField<T>>,
        observer: &mut impl FlowObserver,
    ) -> Result<&Medium<T, D>, FlowError> {
        (compiled::<T, D>().begin)(self, dt, phi, observer)?;
        Ok(&self.medium)
    }

    fn begin_here(
        &mut self,
        dt: f64,
        phi: Option<&CellField<T>>,
        observer: &mut dyn FlowObserver,
    ) -> Result<(), FlowError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(FlowError::TimeStep(dt));
        }
        if self.stage.is_some() {
            return Err(FlowError::Order("a second beginning"));
        }
        self.check_phi(phi)?;
        self.give_back();
        let courant = self.max_speed() * dt / self.grid.h();
        let scheme = match self.settings.scheme {
            Scheme::Auto if courant <= 1.0 => Scheme::Cnp,
            Scheme::Auto => Scheme::ReflectionExtrapolated,
            chosen => chosen,
        };
        self.stage = Some(Stage { dt, report: FlowReport { scheme, courant, ..FlowReport::default() } });
        let lent = if dt == 0.0 { Ok(Lent::Now) } else { self.first_half(scheme, dt, phi, observer) };
        self.projection.release();
        match lent {
            Ok(lent) => self.lend(lent),
            Err(error) => {
                self.stage = None;
                self.forget();
                return Err(error);
            }
        }
        Ok(())
    }

    /// Ends the step begun. `phi` causes buoyancy, as it is at the end of the step.
    pub fn finish(
        &mut self,
        phi: Option<&CellField<T>>,
        observer: &mut impl FlowObserver,
    ) -> Result<FlowReport, FlowError> {
        (compiled::<T, D>().finish)(self, phi, observer)
    }

    fn finish_here(
        &mut self,
        phi: Option<&CellField<T>>,
        observer: &mut dyn FlowObserver,
    ) -> Result<FlowReport, FlowError> {
        self.check_phi(phi)?;
        self.give_back();
        let Some(stage) = self.stage.take() else { return Err(FlowError::Order("an end without a beginning")) };
        if stage.dt == 0.0 {
            return Ok(stage.report);
        }
        let mut report = stage.report;
        let done = self.second_half(report.scheme, stage.dt, phi, &mut report, observer);
        self.projection.release();
        if let Err(error) = done {
            self.forget();
            return Err(error);
        }
        // u^n becomes u^(n-1), the new velocity u^n.
        std::mem::swap(&mut self.u, &mut self.next);
        std::mem::swap(&mut self.before, &mut self.next);
        self.drop_next();
        if !self.settings.scheme.keeps_before() {
            self.drop_before();
        }
        self.history.last = Some((stage.dt, report.scheme));
        self.time += stage.dt;
        Ok(report)
    }

    /// Abandons a step that has begun: the velocity stays that of its start.
    pub fn abandon(&mut self) {
        self.give_back();
        if self.stage.take().is_some_and(|stage| stage.dt > 0.0) {
            // What the advecting velocity was made of is gone.
            self.forget();
        }
    }

    /// Nothing is known of earlier steps.
    fn forget(&mut self) {
        self.history = History::default();
        self.drop_next();
        if self.settings.scheme.keeps_before() {
            self.fetch_before();
        } else {
            self.drop_before();
        }
    }

    pub(crate) fn fetch_next(&mut self) {
        self.projection.pool().fetch(self.grid.layout(), self.next.fields_mut());
    }

    pub(crate) fn fetch_before(&mut self) {
        self.projection.pool().fetch(self.grid.layout(), self.before.fields_mut());
    }

    pub(crate) fn drop_next(&mut self) {
        self.projection.pool().release(self.next.fields_mut());
    }

    pub(crate) fn drop_before(&mut self) {
        self.projection.pool().release(self.before.fields_mut());
    }

    fn check_phi(&self, phi: Option<&CellField<T>>) -> Result<(), FlowError> {
        let (expected, found) = (self.grid.layout().slots(), phi.map(|p| p.len()));
        match found {
            None if self.settings.buoyancy.is_some() => Err(FlowError::Order("buoyancy without phi")),
            Some(found) if found != expected => Err(FlowError::Layout { what: "phi", expected, found }),
            _ => Ok(()),
        }
    }

    /// Moves a velocity into the medium; its place is empty meanwhile.
    fn lend(&mut self, lent: Lent) {
        if let Some(field) = self.lendable(lent) {
            self.medium = Medium::Field(std::mem::take(field));
            self.lent = lent;
        }
    }

    pub(crate) fn give_back(&mut self) {
        if let Medium::Field(u) = std::mem::replace(&mut self.medium, Medium::Still)
            && let Some(field) = self.lendable(self.lent)
        {
            *field = u;
        }
        self.lent = Lent::Nothing;
    }

    fn lendable(&mut self, lent: Lent) -> Option<&mut FaceField<T, D>> {
        match lent {
            Lent::Nothing => None,
            Lent::Now => Some(&mut self.u),
            Lent::Before => Some(&mut self.before),
            Lent::Next => Some(&mut self.next),
        }
    }

    /// Sets the held faces of the step's middle.
    pub(crate) fn hold_emitters(&mut self, dt: f64) -> Result<(), FlowError> {
        let acting = self.emitters.iter().filter(|(e, _)| e.acts(self.time, dt));
        let held: Vec<Held> = acting
            .filter(|(e, _)| matches!(e.jet, Some(Jet::Hold(_))))
            .flat_map(|(_, faces)| faces.iter().copied())
            .collect();
        self.projection.hold(held)
    }

    /// Sets the velocity of jets that hold nothing.
    pub(crate) fn set_jets(&mut self, dt: f64) {
        for (emitter, faces) in &self.emitters {
            if emitter.acts(self.time, dt) && matches!(emitter.jet, Some(Jet::Set(_))) {
                for face in faces {
                    self.next.axis_mut(face.axis)[face.slot] = T::of(face.velocity);
                }
            }
        }
    }

    /// next += dt b.
    pub(crate) fn push(&mut self, dt: f64, phi: Option<&CellField<T>>) {
        let buoyancy = self.settings.buoyancy.zip(phi.map(|phi| &phi[..]));
        push(self.grid.layout(), self.projection.sides(), dt, self.settings.force, buoyancy, &mut self.next);
    }

    /// next := P next, with `potential[which]` scaled by `guess` as the start (0: none).
    pub(crate) fn project(
        &mut self,
        which: usize,
        guess: f64,
        dt: f64,
        observer: &mut dyn FlowObserver,
    ) -> Result<crate::Projected, FlowError> {
        observer.begin(FlowPhase::Projection);
        let s = &mut self.potential[which];
        if guess == 0.0 || !self.settings.warm_start {
            s.fill(T::ZERO);
        } else if guess != 1.0 {
            scale(guess, s);
        }
        let done = self.projection.project(&mut self.next, s, dt, self.settings.eta_div);
        observer.end(FlowPhase::Projection);
        done
    }

    /// next := P next, with pressure += s/dt.
    pub(crate) fn project_increment(
        &mut self,
        dt: f64,
        observer: &mut dyn FlowObserver,
    ) -> Result<crate::Projected, FlowError> {
        let Some(pressure) = &mut self.pressure else { return Err(FlowError::Order("a pressure that is not kept")) };
        observer.begin(FlowPhase::Projection);
        let done = self.projection.project_onto(&mut self.next, pressure, 1.0 / dt, dt, self.settings.eta_div);
        self.history.pressure |= done.is_ok();
        observer.end(FlowPhase::Projection);
        done
    }

    /// before := a u + b before.
    pub(crate) fn mix_before(&mut self, a: f64, b: f64) {
        combine(self.grid.layout(), self.projection.sides(), a, &self.u, b, &mut self.before);
    }

    /// next := u.
    pub(crate) fn copy_next(&mut self) {
        self.fetch_next();
        combine(self.grid.layout(), self.projection.sides(), 1.0, &self.u, 0.0, &mut self.next);
    }
}

/// What is costly to compile, of one precision and dimension.
#[allow(clippy::type_complexity)]
struct Compiled<T, const D: usize> {
    new: fn(&Grid<D>, &Sides<FlowWall<D>, D>, Option<&Mask<D>>, FlowSettings<D>) -> Result<Fluid<T, D>, FlowError>,
    set_velocity: fn(&mut Fluid<T, D>, &FaceField<T, D>) -> Result<FlowReport, FlowError>,
    begin: fn(&mut Fluid<T, D>, f64, Option<&CellField<T>>, &mut dyn FlowObserver) -> Result<(), FlowError>,
    finish: fn(&mut Fluid<T, D>, Option<&CellField<T>>, &mut dyn FlowObserver) -> Result<FlowReport, FlowError>,
}

impl<T: Real, const D: usize> Compiled<T, D> {
    const HERE: Self = Self {
        new: Fluid::new_here,
        set_velocity: Fluid::set_velocity_here,
        begin: Fluid::begin_here,
        finish: Fluid::finish_here,
    };
}

/// Steps are compiled here, once, and not again in every crate that makes some.
static COMPILED: (Compiled<f32, 2>, Compiled<f64, 2>, Compiled<f32, 3>, Compiled<f64, 3>) =
    (Compiled::HERE, Compiled::HERE, Compiled::HERE, Compiled::HERE);

fn compiled<T: Real, const D: usize>() -> &'static Compiled<T, D> {
    let c = &COMPILED;
    once([&c.0, &c.1, &c.2, &c.3])
}
