//! A solved fluid and what it carries: how one is made of a scene, how far it may go in a step, what it tells.

use super::BuildError;
use super::stepper::{Domain, settings};
use crate::model::{FlowStep, Number, StepFailure, Values, ValuesMut};
use crate::pace::Pace;
use crate::scene::{self, Numerics};
use crate::spec::{self, FlowScheme, Grip};
use crate::stopwatch::Stopwatch;
use crate::summary::HcSummary;
use cf_diffusion::{Diffusion, Source, State, StepReport};
use cf_fluid::{Buoyancy, Coupled, Emitter, Flow, FlowSettings, FlowWall, Fluid, Jet, Scheme, Shape};
use cf_grid::{Axis, FaceField, Layout, Reduce, Sides};

/// A fluid with phi and q_C.
pub(super) struct Carried<T, const D: usize> {
    pub coupled: Coupled<T, D>,
    pub state: State<T, D>,
    /// What the fluid remembers between steps, its speed and the power of its forces after the last, kept where a checkpoint can reach it.
    memory: [f64; 5],
    /// The last step.
    pub last: Option<FlowStep>,
}

const VELOCITY: [&str; 3] = ["u along x", "u along y", "u along z"];
const BEFORE: [&str; 3] = ["u before along x", "u before along y", "u before along z"];
const PRESSURE: &str = "pressure";
const POTENTIALS: [&str; 2] = ["potential", "second potential"];
const MEMORY: &str = "memory of the flow";

impl<T: Number, const D: usize> Carried<T, D> {
    pub fn new(
        domain: Domain<'_, T, D>,
        spec: &scene::Fluid,
        numerics: &Numerics,
        pace: &Pace,
    ) -> Result<Self, BuildError> {
        let Domain { grid, sides, mask, law, .. } = domain;
        let jets = spec.jets.iter().map(emitter).collect::<Result<Vec<_>, _>>()?;
        let walls = walls(spec, &sides)?;
        let fluid = Fluid::new(grid, &walls, mask.as_ref(), flow_settings(spec, numerics)?)?;
        let mut fluid = fluid.with_emitters(&jets)?;
        let start: [f64; D] = array(&spec.velocity)?;
        if start.iter().any(|component| *component != 0.0) {
            let mut u = FaceField::new(grid.layout());
            for (axis, component) in start.into_iter().enumerate() {
                u.axis_mut(axis).fill(T::of(component));
            }
            fluid.set_velocity(&u)?;
        }
        let state = State::new(grid, &law);
        let diffusion = Diffusion::new(grid, &sides, mask, law, settings(numerics, pace))?;
        let speed = speeds(&fluid, &state, f64::INFINITY).most;
        let [length, scheme, pressure] = fluid.memory();
        let coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[])?;
        Ok(Carried { coupled, state, memory: [length, scheme, pressure, speed, 0.0], last: None })
    }

    fn fluid_mut(&mut self) -> Option<&mut Fluid<T, D>> {
        match &mut self.coupled.flow {
            Flow::Solved(fluid) => Some(fluid),
            Flow::Prescribed(_) => None,
        }
    }

    pub fn fluid(&self) -> Option<&Fluid<T, D>> {
        self.coupled.flow.fluid()
    }

    pub fn step(
        &mut self,
        from: f64,
        dt: f64,
        source: Source<'_, T>,
        watch: &mut Stopwatch,
    ) -> Result<StepReport, StepFailure> {
        let [length, scheme, pressure, speed, power] = self.memory;
        if let Some(fluid) = self.fluid_mut() {
            fluid.recall([length, scheme, pressure]);
        }
        self.coupled.set_time(from);
        let made = self.coupled.step_with(&mut self.state, source, dt, watch)?;
        if let (Some(fluid), Some(report)) = (self.coupled.flow.fluid(), made.flow) {
            let now = speeds(fluid, &self.state, f64::INFINITY);
            let [length, scheme, pressure] = fluid.memory();
            self.memory = [length, scheme, pressure, now.most, now.power];
            self.last = Some(FlowStep { report, speed: speed.max(now.most), power: 0.5 * (power + now.power) });
        }
        Ok(made.scalar)
    }

    /// The longest step \[s\] from `time` on for a Courant number: what the flow and its jets allow now, and buoyancy.
    pub fn longest(&mut self, time: f64, cfl: f64) -> f64 {
        self.coupled.set_time(time);
        self.fluid().map_or(f64::INFINITY, |fluid| fluid.dt_for(cfl).min(fluid.buoyancy_dt(&self.state.phi)))
    }

    /// |u|/c over the fluid cells.
    pub fn hc(&self) -> Option<HcSummary> {
        let (fluid, c) = (self.fluid()?, self.coupled.diffusion.law().speed().filter(|c| *c > 0.0)?);
        let found = speeds(fluid, &self.state, c);
        let cells = fluid.mask().map_or(fluid.grid().layout().count(), |mask| mask.fluid_cells()).max(1) as f64;
        Some(HcSummary { mean: found.sum / c / cells, max: found.most / c, above_one: found.above / cells })
    }

    /// All unknowns by name, after those of phi.
    pub fn unknowns(&self) -> Vec<(&'static str, Values<'_>)> {
        let Some(fluid) = self.fluid() else { return Vec::new() };
        let parts = fluid.state();
        let named = names(fluid).into_iter().zip(parts).map(|(name, part)| (name, T::values(part)));
        named.chain([(MEMORY, Values::F64(&self.memory))]).collect()
    }

    /// phi and q_C, and what [`unknowns`](Self::unknowns) lists, to be filled.
    pub fn split_mut(&mut self) -> (&mut State<T, D>, Vec<(&'static str, ValuesMut<'_>)>) {
        let Self { coupled, state, memory, .. } = self;
        let Flow::Solved(fluid) = &mut coupled.flow else { return (state, Vec::new()) };
        let names = names(fluid);
        let named = names.into_iter().zip(fluid.state_mut()).map(|(name, part)| (name, T::values_mut(part)));
        (state, named.chain([(MEMORY, ValuesMut::F64(memory))]).collect())
    }
}

/// The names of the parts of a fluid's state, in their order.
fn names<T: Number, const D: usize>(fluid: &Fluid<T, D>) -> Vec<&'static str> {
    let scheme = fluid.settings().scheme;
    let before = BEFORE.into_iter().take(if scheme.keeps_before() { D } else { 0 });
    let pressure = scheme.keeps_pressure().then_some(PRESSURE);
    let potentials = POTENTIALS.into_iter().take(scheme.potentials());
    VELOCITY.into_iter().take(D).chain(before).chain(pressure).chain(potentials).collect()
}

fn array<const D: usize>(axes: &spec::Axes<f64>) -> Result<[f64; D], BuildError> {
    axes.to_array().ok_or(BuildError::Dimension { axes: D, what: "such velocity" })
}

fn emitter<const D: usize>(jet: &spec::JetSpec) -> Result<Emitter<D>, BuildError> {
    let shape = match &jet.shape {
        spec::Shape::Box { low, high } => Shape::Box { low: array(low)?, high: array(high)? },
        spec::Shape::Ball { center, radius } => Shape::Sphere { center: array(center)?, radius: *radius },
        _ => return Err(BuildError::Dimension { axes: D, what: "jet of this shape" }),
    };
    let velocity = array(&jet.velocity)?;
    let grip = match jet.how {
        Grip::Hold => Jet::Hold(velocity),
        Grip::Set => Jet::Set(velocity),
    };
    let until = jet.until.unwrap_or(f64::INFINITY);
    Ok(Emitter { from: jet.from, until, ..Emitter::new(shape, Some(grip), None) })
}

fn walls<const D: usize>(
    spec: &scene::Fluid,
    phi: &Sides<cf_grid::Wall, D>,
) -> Result<Sides<FlowWall<D>, D>, BuildError> {
    let wall = |wall: &spec::FlowWall| {
        Ok::<_, BuildError>(match wall {
            spec::FlowWall::Closed => FlowWall::Closed,
            spec::FlowWall::Open => FlowWall::OPEN,
            spec::FlowWall::Inflow(velocity) => FlowWall::Inflow(array(velocity)?),
        })
    };
    let mut sides = Sides::all(FlowWall::Closed);
    for (axis, ends) in spec.walls.iter().enumerate().take(D) {
        sides.0[axis] =
            if phi.is_periodic(axis) { Axis::Periodic } else { Axis::Walls([wall(&ends[0])?, wall(&ends[1])?]) };
    }
    Ok(sides)
}

/// The scheme of cf-fluid that a scene names.
pub(crate) fn scheme(flow: FlowScheme) -> Scheme {
    match flow {
        FlowScheme::Auto => Scheme::Auto,
        FlowScheme::Cnp => Scheme::Cnp,
        FlowScheme::ReflectionExtrapolated => Scheme::ReflectionExtrapolated,
        FlowScheme::Draft => Scheme::Draft,
        FlowScheme::CentralRk4 => Scheme::CentralRk4,
    }
}

fn flow_settings<const D: usize>(spec: &scene::Fluid, numerics: &Numerics) -> Result<FlowSettings<D>, BuildError> {
    let buoyancy = match &spec.buoyancy {
        Some(one) => Some(Buoyancy { strength: one.strength, reference: one.reference, up: array(&one.up)? }),
        None => None,
    };
    Ok(FlowSettings {
        scheme: scheme(numerics.flow),
        eta_div: numerics.eta_div,
        precision: numerics.precision.cycles(),
        force: array(&spec.force)?,
        buoyancy,
        ..FlowSettings::default()
    })
}

/// Of |u| in cells: the largest, the sum, and how many cells are faster than some speed; of forces, their power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Speeds {
    most: f64,
    sum: f64,
    above: f64,
    /// Σ b·u h^D \[m^(D+2)/s³\].
    power: f64,
}

impl Reduce for Speeds {
    fn merge(self, next: Self) -> Self {
        Speeds {
            most: self.most.max(next.most),
            sum: self.sum + next.sum,
            above: self.above + next.above,
            power: self.power + next.power,
        }
    }
}

/// Cells of a row that are measured together: two registers of numbers, which are summed at the end of every row.
const PIECE: usize = 16;

/// |u| of every cell, from the means of its faces, and what forces do there; solid cells have none.
fn speeds<T: Number, const D: usize>(fluid: &Fluid<T, D>, state: &State<T, D>, limit: f64) -> Speeds {
    let (grid, sides, u, mask) = (fluid.grid(), fluid.sides(), fluid.velocity(), fluid.mask());
    let (force, buoyancy) = (fluid.settings().force, fluid.settings().buoyancy);
    let driven = buoyancy.is_some() || force.iter().any(|f| *f != 0.0);
    let layout: &Layout<D> = grid.layout();
    let volume = grid.cell_volume();
    let (strength, reference, up) = buoyancy.map_or((0.0, 0.0, [0.0; D]), |b| (b.strength, b.reference, b.up));
    layout.par_runs(
        layout.cells_region(),
        (),
        #[inline(always)]
        |run, ()| {
            let [mut most, mut sum, mut above, mut power] = [[0.0; PIECE]; 4];
            for first in (0..run.len()).step_by(PIECE) {
                let piece = run.part(first, PIECE.min(run.len() - first));
                let n = piece.len();
                let mut mean = [[0.0; PIECE]; D];
                for axis in 0..D {
                    let (u, last) = (u.axis(axis), layout.cells()[axis]);
                    let low = piece.row(u);
                    let mut high = piece.high(axis, u);
                    // Beyond the seam of a periodic axis comes its first face.
                    let mut start = piece.cell;
                    start[axis] = 0;
                    let seam = sides.is_periodic(axis).then_some(layout.slot(start));
                    if let Some(start) = seam.filter(|_| axis > 0 && piece.cell[axis] + 1 == last) {
                        high = &u[start..start + n];
                    }
                    for i in 0..n {
                        mean[axis][i] = 0.5 * (low[i].f64() + high[i].f64());
                    }
                    if let Some(start) = seam.filter(|_| axis == 0 && piece.cell[0] + n == last) {
                        mean[0][n - 1] = 0.5 * (low[n - 1].f64() + u[start].f64());
                    }
                }
                for i in 0..n {
                    let mut square = 0.0;
                    for axis in 0..D {
                        square += mean[axis][i] * mean[axis][i];
                    }
                    let speed = square.sqrt();
                    most[i] = f64::max(most[i], speed);
                    sum[i] += speed;
                    above[i] += if speed > limit { 1.0 } else { 0.0 };
                }
                if driven {
                    let (phi, wet) = (piece.row(&state.phi[..]), mask.map(|mask| piece.row(mask.fluid())));
                    for i in (0..n).filter(|&i| wet.is_none_or(|wet| wet[i])) {
                        let lift = strength * (phi[i].f64() - reference);
                        for axis in 0..D {
                            power[i] += volume * mean[axis][i] * (force[axis] + lift * up[axis]);
                        }
                    }
                }
            }
            let mut found = Speeds::default();
            for i in 0..PIECE {
                let one = Speeds { most: most[i], sum: sum[i], above: above[i], power: power[i] };
                found = found.merge(one);
            }
            found
        },
    )
}
