//! Fronts: the characteristic MUSCL scheme for F_T = 0.
//!
//! Cattaneo's law in a medium of uniform velocity u is hyperbolic,
//!
//! ```text
//! phi_t + u·grad phi + div q = W             phi [P], q [P m/s], k [m²/s], tau [s], u [m/s], W [P/s]
//! q_t + u·grad q + q/tau = - c² grad phi     c = sqrt(k/tau) [m/s]
//! ```
//!
//! and a jump of phi stays a jump: a front that moves at c and fades as e^{-t/2tau}. Centred schemes ring there (12 to
//! 20 % of the jump) and backward Euler smears it over tens of cells. This scheme follows the waves. Along an axis w± =
//! phi ± q_axis/c move at u_axis ± c, and the other components of q at u_axis; a sub-step is, with all of phi and q at
//! cell centres,
//!
//! ```text
//! phi += dt/2 W;   x sweep;   y sweep;   z sweep;   phi += dt/2 W            (next time z, y, x)
//! sweep: q_axis *= e^{-dt/2tau};  every wave moves, upwind by its own sign, MC-limited;  q_axis *= e^{-dt/2tau}
//! ```
//!
//! Second order for smooth data, no new extrema in one dimension, mass exact to rounding, and every wall reports what
//! leaves through it. Since each wave looks upwind only, nothing at all travels against a medium of |u_a| >= c: at
//! u_a = c the slow wave stands still.
//!
//! What is meant by the walls is in the table of [`Wall`]: `Flux`, `Value` and `Absorbing` say the same as for
//! [`Diffusion`](crate::Diffusion); `Open` lets waves leave too, what comes in through it is phi = inflow, q = 0.
//!
//! Range: R_h = h/(c tau) <= 0.3 ([`Front::validity`]). On coarser cells relaxation and transport no longer balance;
//! the relative error grows from 4e-3 at 0.3 to 2 % at 1 and 14 % at 3.

mod checks;
mod content;
mod error;
mod kernel;
mod state;
mod sweep;
#[cfg(test)]
mod tests;
mod wave;

use std::mem::swap;

use cf_grid::{CellField, Grid, Real, Sides, Wall, once};
use nalgebra::SVector;

pub use error::FrontError;
pub use state::FrontState;

use crate::law::Law;
use crate::medium::Medium;
use crate::source::Source;
use crate::stepper::StepReport;
use content::{Carried, Sound};
use sweep::Sweep;
use wave::Line;

/// A stepper of sharp fronts on one box: two cell-sized arrays of scratch, made once.
///
/// ```
/// use cf_diffusion::front::{Front, FrontState};
/// use cf_diffusion::{Law, Source};
/// use cf_grid::{Grid, Sides, Wall};
/// use nalgebra::SVector;
///
/// let grid = Grid::<2>::new([64, 64], 1.0 / 64.0)?;
/// let law = Law::cattaneo(0.25, 4.0)?; // c = 0.25 m/s
/// let still = SVector::zeros();
/// let mut front = Front::<f64, 2>::new(&grid, &Sides::all(Wall::CLOSED), law, still)?;
/// assert!(front.validity().is_ok());
/// let mut state = FrontState::new(&grid);
/// state.phi[grid.layout().slot([32, 32])] = 1.0;
/// let report = front.step(&mut state, Source::NONE, 0.5)?;
/// assert_eq!((report.substeps, report.outflow), (16, 0.0));
/// assert!((state.mass(&grid) - grid.cell_volume()).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Front<T, const D: usize> {
    grid: Grid<D>,
    sides: Sides<Wall, D>,
    law: Law,
    speed: f64,
    velocity: SVector<f64, D>,
    courant: f64,
    work: [CellField<T>; 2],
    reversed: bool,
}

impl<T: Real, const D: usize> Front<T, D> {
    /// Largest (max|u_a| + c) dt/h of a sub-step. Splitting overshoots beyond: by less than 0.1 % for a sharp disc at
    /// 0.5, by 20 % at 0.9.
    pub const COURANT: f64 = 0.5;
    /// The same where only one axis has more than one cell; there is no splitting then, and longer steps are sharper.
    pub const COURANT_LINE: f64 = 0.9;
    /// Largest R_h = h/(c tau) of the documented range.
    pub const CELL_RATIO: f64 = 0.3;
    /// Most sub-steps per step.
    pub const SUBSTEPS: usize = 100_000;

    /// A stepper for `law` on `grid` between `sides`, in a medium that moves at `velocity` \[m/s\] everywhere.
    ///
    /// # Errors
    /// Laws other than F_T = 0 with tau > 0 and k > 0, wall numbers that are not finite, and media that are not finite
    /// or cross a [`Wall::Flux`].
    pub fn new(
        grid: &Grid<D>,
        sides: &Sides<Wall, D>,
        law: Law,
        velocity: SVector<f64, D>,
    ) -> Result<Self, FrontError> {
        let (k, tau, fourier) = (law.k(), law.tau(), law.fourier_share());
        let speed = match law.speed() {
            Some(speed) if fourier == 0.0 && speed > 0.0 => speed,
            _ => return Err(FrontError::NeedsWaves { fourier, tau, k }),
        };
        let usable = |value: f64| T::of(value).is_finite() && T::of(value) > T::ZERO;
        if !(usable(speed) && usable(1.0 / speed)) {
            return Err(FrontError::Speed { speed, precision: T::NAME });
        }
        checks::walls(sides)?;
        Medium::<T, D>::Uniform(velocity).check(grid, sides)?;
        let mut velocity = velocity;
        for (axis, _, wall) in sides.walls() {
            if wall.carried_in().is_none() {
                velocity[axis] = 0.0; // the check let rounding pass
            }
        }
        let one_line = grid.cells().into_iter().filter(|&n| n > 1).count() <= 1;
        Ok(Self {
            grid: *grid,
            sides: *sides,
            law,
            speed,
            velocity,
            courant: if one_line { Self::COURANT_LINE } else { Self::COURANT },
            work: std::array::from_fn(|_| CellField::new(grid.layout())),
            reversed: false,
        })
    }

    /// The same stepper with another Courant limit in (0, 1], for experiments.
    pub fn with_courant(mut self, courant: f64) -> Result<Self, FrontError> {
        if !(courant > 0.0 && courant <= 1.0) {
            return Err(FrontError::Courant(courant));
        }
        self.courant = courant;
        Ok(self)
    }

    /// The law.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The walls.
    pub fn sides(&self) -> &Sides<Wall, D> {
        &self.sides
    }

    /// Velocity of the medium \[m/s\].
    pub fn velocity(&self) -> SVector<f64, D> {
        self.velocity
    }

    /// Speed of the fronts, c = sqrt(k/tau) \[m/s\].
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Longest step without sub-steps \[s\].
    pub fn stable_dt(&self) -> f64 {
        self.courant * self.grid.h() / (self.velocity.amax() + self.speed)
    }

    /// R_h = h/(c tau) \[1\] if it is in the documented range, the reason for a warning or a refusal if it is not. The
    /// scheme is stable either way.
    pub fn validity(&self) -> Result<f64, FrontError> {
        let (ratio, limit) = (self.grid.h() / (self.speed * self.law.tau()), Self::CELL_RATIO);
        if ratio <= limit { Ok(ratio) } else { Err(FrontError::TooCoarse { ratio, limit }) }
    }

    /// Bytes of scratch.
    pub fn bytes(&self) -> usize {
        self.work.iter().map(CellField::bytes).sum()
    }

    /// Whether the next sub-step sweeps the last axis first: with the state, all that a resumed run needs.
    pub fn sweep_reversed(&self) -> bool {
        self.reversed
    }

    /// Sets the order of the next sub-step.
    pub fn set_sweep_reversed(&mut self, reversed: bool) {
        self.reversed = reversed;
    }

    /// Advances `state` by `dt` \[s\] in equal sub-steps of at most [`stable_dt`](Self::stable_dt). `dt` = 0 changes
    /// nothing.
    ///
    /// # Errors
    /// Fields of another layout, steps that are negative, not finite or absurdly long, and values that are not finite.
    pub fn step(
        &mut self,
        state: &mut FrontState<T, D>,
        source: Source<'_, T>,
        dt: f64,
    ) -> Result<StepReport, FrontError> {
        let c = &COMPILED;
        once::<Step<T, D>>([&c.0, &c.1, &c.2, &c.3])(self, state, source, dt)
    }

    fn step_here(
        &mut self,
        state: &mut FrontState<T, D>,
        source: Source<'_, T>,
        dt: f64,
    ) -> Result<StepReport, FrontError> {
        let substeps = self.substeps(dt)?;
        self.check_layout(state, source)?;
        if dt == 0.0 {
            return Ok(StepReport::default());
        }
        let layout = *self.grid.layout();
        let amount = source.rate.map_or(0.0, |rate| source.share * dt * rate.sum(&layout, |_| true));
        if !amount.is_finite() {
            let cell = source.rate.and_then(|rate| self.first_bad(|slot| rate.at(slot)));
            return Err(FrontError::NotFinite { field: "the source", cell: cell.unwrap_or_default() });
        }
        let step = dt / substeps as f64;
        let (mut outflow, mut left) = (0.0, 0.0);
        self.emit(state, source, 0.5 * step);
        for n in 1..=substeps {
            left = self.sweeps(state, step);
            outflow += left;
            self.emit(state, source, if n < substeps { step } else { 0.5 * step });
        }
        if !left.is_finite() {
            let cell = self.first_bad(|slot| state.phi[slot]).unwrap_or_default();
            return Err(FrontError::NotFinite { field: "phi", cell });
        }
        let volume = self.grid.cell_volume();
        let (outflow, emitted) = (outflow * volume, amount * volume);
        Ok(StepReport { substeps, outflow, emitted, ..StepReport::default() })
    }

    /// phi += dt W.
    fn emit(&self, state: &mut FrontState<T, D>, source: Source<'_, T>, dt: f64) {
        let Some(rate) = source.rate else { return };
        let (layout, dt) = (self.grid.layout(), T::of(source.share * dt));
        layout.par_runs(
            layout.cells_region(),
            &mut state.phi[..],
            #[inline(always)]
            |run, phi: &mut [T]| {
                let (skipped, rate) = rate.within(run.slot(), phi.len());
                for (phi, &w) in phi[skipped..].iter_mut().zip(rate) {
                    *phi += dt * w;
                }
            },
        );
    }

    /// Every axis once. Returns what left \[cells of phi\]; not finite where phi is not.
    fn sweeps(&mut self, state: &mut FrontState<T, D>, dt: f64) -> f64 {
        let outflow = (0..D).map(|i| self.sweep(state, if self.reversed { D - 1 - i } else { i }, dt)).sum();
        self.reversed = !self.reversed;
        outflow
    }

    fn sweep(&mut self, state: &mut FrontState<T, D>, axis: usize, dt: f64) -> f64 {
        let Self { grid, sides, law, speed, velocity, work: [work, second], .. } = self;
        let layout = grid.layout();
        let line = Line::new(sides, axis, velocity[axis], dt / grid.h(), layout.cells()[axis]);
        let periodic = sides.is_periodic(axis);
        let content = Sound::new(*speed, law.tau(), dt);
        let sound = Sweep { layout, axis, periodic, waves: line.sound(*speed), content };
        let (phi, q) = (&mut state.phi, &mut state.flux[axis]);
        let outflow = if axis == 0 {
            sound.in_place([phi, q])
        } else {
            let outflow = sound.across([phi, q], [work, second]);
            swap(phi, work);
            swap(q, second);
            outflow
        };
        if line.u != 0.0 {
            let carried = Sweep { layout, axis, periodic, waves: line.carried(), content: Carried };
            for (_, q) in state.flux.iter_mut().enumerate().filter(|&(a, _)| a != axis) {
                if axis == 0 {
                    carried.in_place([q]);
                } else {
                    carried.across([q], [work]);
                    swap(q, work);
                }
            }
        }
        outflow
    }
}

/// A step of one precision and dimension.
type Step<T, const D: usize> =
    fn(&mut Front<T, D>, &mut FrontState<T, D>, Source<'_, T>, f64) -> Result<StepReport, FrontError>;

/// Steps are compiled here, once, and not again in every crate that makes some.
static COMPILED: (Step<f32, 2>, Step<f64, 2>, Step<f32, 3>, Step<f64, 3>) =
    (Front::step_here, Front::step_here, Front::step_here, Front::step_here);
