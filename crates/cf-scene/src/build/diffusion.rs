//! Cattaneo-Fourier diffusion in a medium, as a model.

use super::flow::MakeFlow;
use super::stepper::{Domain, Flux, Stepper, Velocity};
use super::{BuildError, coverage};
use crate::model::{FlowState, FlowStep, Model, Number, StepFailure, Totals, Values, ValuesMut};
use crate::pace::Pace;
use crate::scene::{self, Scene};
use crate::solid::Solid;
use crate::spec::{self, AxisSides, Field, Shape, SourceSpec};
use crate::stopwatch::Stopwatch;
use crate::summary::{FLOW_FIELDS, FieldBytes, Range};
use cf_diffusion::{Law, Rate, Source, StepReport};
use cf_grid::{Axis, CellField, FaceField, Grid, Mask, Sides, Wall};
use cf_output::{Array, OutputError, Slice};

/// The sources and who steps them.
pub(super) struct DiffusionModel<T, const D: usize> {
    grid: Grid<D>,
    sources: Vec<SourceSpec>,
    /// Where phi was put in at the start.
    initial: Vec<Shape>,
    /// The share of the step for which each source acts, and the rate that follows: its values from the slot `first` on.
    shares: Vec<f64>,
    rate: Vec<T>,
    first: usize,
    stepper: Stepper<T, D>,
}

impl<T: Number, const D: usize> DiffusionModel<T, D> {
    pub fn new(scene: &Scene, model: &scene::Diffusion, pace: &Pace, make: MakeFlow<T, D>) -> Result<Self, BuildError> {
        let grid = grid(&scene.grid)?;
        let law = Law::new(model.law.k, model.law.tau, model.law.fourier)?;
        let obstacles = Solid::of(scene);
        let mask = (!obstacles.is_empty()).then(|| mask(&grid, &obstacles));
        let solid: Vec<usize> =
            mask.iter().flat_map(|mask| mask.fluid()).enumerate().filter(|(_, f)| !**f).map(|(i, _)| i).collect();
        let (medium, fluid) = (&model.medium, model.fluid.as_ref());
        let domain = Domain { grid: &grid, sides: sides(scene, &law), mask, law, medium, fluid, make };
        let mut stepper = Stepper::new(domain, &scene.numerics, pace)?;
        let phi = stepper.phi_mut();
        for deposit in &model.initial {
            coverage::deposit(&grid, &deposit.shape, deposit.value, phi);
        }
        for slot in solid {
            phi[slot] = T::ZERO;
        }
        let (sources, shares) = (model.sources.clone(), vec![0.0; model.sources.len()]);
        let emitting = sources.iter().filter(|source| source.rate.is_some()).map(|source| &source.shape);
        let planes = coverage::planes(&grid, emitting);
        let (first, rate) = (planes.start, vec![T::ZERO; planes.len()]);
        let starts = model.initial.iter().filter(|deposit| deposit.value != 0.0);
        let initial = starts.map(|deposit| deposit.shape.clone()).collect();
        Ok(DiffusionModel { grid, sources, initial, shares, rate, first, stepper })
    }

    /// Brings the rate field up to date for a step.
    fn emit(&mut self, from: f64, dt: f64) {
        let shares: Vec<f64> = self.sources.iter().map(|source| share(source, from, dt)).collect();
        if shares == self.shares {
            return;
        }
        self.rate.fill(T::ZERO);
        for (source, share) in self.sources.iter().zip(&shares).filter(|(_, share)| **share > 0.0) {
            if let Some(rate) = source.rate {
                coverage::deposit_within(&self.grid, &source.shape, rate * share, self.first, &mut self.rate);
            }
        }
        self.shares = shares;
    }

    /// Sets phi where sources hold it in the middle of a step; gives the mass that this added \[P m^D\].
    fn hold(&mut self, from: f64, dt: f64) -> f64 {
        let (grid, middle) = (&self.grid, from + 0.5 * dt);
        let (phi, mask) = self.stepper.held_mut();
        let mut added = 0.0;
        for source in &self.sources {
            let Some(value) = source.value else { continue };
            if source.from <= middle && source.until.is_none_or(|until| middle < until) {
                let inside = |cell| {
                    let (origin, extent) = (grid.origin(), grid.extent());
                    source.shape.weight(grid.centre(cell).as_slice(), origin.as_slice(), extent.as_slice()) > 0.0
                };
                grid.layout().each_cell(coverage::around(grid, &source.shape), |at| {
                    if mask.is_none_or(|mask| mask.fluid()[at.slot()]) && inside(at.cell) {
                        let old = phi[at.slot()].f64();
                        phi[at.slot()] = T::of(value);
                        added += phi[at.slot()].f64() - old;
                    }
                });
            }
        }
        added * grid.cell_volume()
    }

    fn each_cell(&self, mut visit: impl FnMut([usize; D], f64)) {
        let (layout, phi) = (self.grid.layout(), self.stepper.phi());
        layout.each_cell(layout.cells_region(), |at| visit(at.cell, phi[at.slot()].f64()));
    }
}

impl<T: Number, const D: usize> DiffusionModel<T, D> {
    fn face_ranges(&self, names: [&str; 3], field: &FaceField<T, D>) -> Vec<Range> {
        let layout = self.grid.layout();
        let range = |(axis, values): (usize, &[T])| {
            let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
            layout.each_cell(layout.faces_region(axis, self.stepper.sides().is_periodic(axis)), |at| {
                (min, max) = (min.min(values[at.slot()].f64()), max.max(values[at.slot()].f64()));
            });
            Range { field: names[axis].into(), min, max }
        };
        field.axes().into_iter().enumerate().map(range).collect()
    }
}

/// The share of a step for which a source acts.
fn share(source: &SourceSpec, from: f64, dt: f64) -> f64 {
    let until = source.until.unwrap_or(f64::INFINITY);
    let share = (until.min(from + dt) - source.from.max(from)) / dt;
    // Steps end at the switches up to rounding.
    match share {
        s if s < 1e-6 => 0.0,
        s if s > 1.0 - 1e-6 => 1.0,
        s => s,
    }
}

/// The grid of a scene with as many axes.
pub(super) fn grid<const D: usize>(grid: &scene::Grid) -> Result<Grid<D>, BuildError> {
    let wrong = |what| BuildError::Dimension { axes: grid.dimension(), what };
    let cells = grid.cells.to_array().ok_or(wrong("such grid"))?;
    let origin = grid.origin.to_array().ok_or(wrong("such origin"))?;
    Ok(Grid::new(cells, grid.spacing)?.with_origin(origin)?)
}

/// The walls of a scene; absorbing ones take the speed of the law's waves unless they have their own.
pub(super) fn sides<const D: usize>(scene: &Scene, law: &Law) -> Sides<Wall, D> {
    let wall = |wall: &spec::Wall| match *wall {
        spec::Wall::Closed => Wall::CLOSED,
        spec::Wall::Flux(flux) => Wall::Flux(flux),
        spec::Wall::Value(value) => Wall::Value(value),
        spec::Wall::Absorbing { far, speed } => Wall::Absorbing { speed: speed.or(law.speed()).unwrap_or(0.0), far },
        spec::Wall::Open { inflow } => Wall::Open { inflow },
    };
    Sides(std::array::from_fn(|axis| match scene.sides.get(axis) {
        Some(AxisSides::Periodic) => Axis::Periodic,
        Some(AxisSides::Walls { low, high }) => Axis::Walls([wall(low), wall(high)]),
        None => Axis::Walls([Wall::CLOSED; 2]),
    }))
}

fn mask<const D: usize>(grid: &Grid<D>, solid: &Solid<'_>) -> Mask<D> {
    Mask::new(grid.layout(), |cell| !solid.holds(grid.centre(cell).as_slice()))
}

const FLUX: [&str; 3] = ["q_C along x", "q_C along y", "q_C along z"];
const SPEED: [&str; 3] = ["u along x", "u along y", "u along z"];

impl<T: Number, const D: usize> Model for DiffusionModel<T, D> {
    fn advance(&mut self, from: f64, dt: f64, watch: &mut Stopwatch) -> Result<StepReport, StepFailure> {
        self.emit(from, dt);
        let adds = |(source, share): (&SourceSpec, &f64)| *share > 0.0 && source.rate.is_some();
        let active = self.sources.iter().zip(&self.shares).any(adds);
        let held = if self.sources.iter().any(|source| source.value.is_some()) { self.hold(from, dt) } else { 0.0 };
        let source = if active { Source::steady(Rate { first: self.first, values: &self.rate }) } else { Source::NONE };
        let report = self.stepper.step(from, dt, source, watch)?;
        Ok(StepReport { emitted: report.emitted + held, ..report })
    }

    fn flow(&self) -> Option<FlowStep> {
        self.stepper.flow()
    }

    fn flow_state(&self) -> Option<FlowState> {
        let fluid = self.stepper.fluid()?;
        let (choice, levels) = fluid.projection().choice();
        let solver = format!("{:?}, {levels} levels", choice.plan);
        let (hc, energy) = (self.stepper.hc(), fluid.kinetic_energy());
        Some(FlowState { solver, reason: choice.reason.clone(), hc, energy })
    }

    fn longest(&mut self, time: f64, cfl: f64) -> f64 {
        self.stepper.longest(time, cfl)
    }

    fn reach(&self, fraction: f64) -> Option<f64> {
        let shapes: Vec<&Shape> = self.sources.iter().map(|source| &source.shape).chain(&self.initial).collect();
        let (low, high) = self.grid.layout().range(self.stepper.phi());
        let least = fraction * low.abs().max(high.abs());
        let half = 0.5 * self.grid.h();
        let mut reach = None;
        self.each_cell(|cell, phi| {
            if phi.abs() > least {
                let x = self.grid.centre(cell);
                // From the edge of the cell that is nearest: a cell that a shape touches has no distance.
                let gap = |shape: &&Shape| {
                    let along = |axis: usize| {
                        let (from, to) = shape.bounds(axis);
                        (from - x[axis]).max(x[axis] - to).max(half) - half
                    };
                    (0..D).map(|axis| along(axis).powi(2)).sum::<f64>().sqrt()
                };
                let nearest = shapes.iter().map(gap).fold(f64::INFINITY, f64::min);
                reach = Some(reach.map_or(nearest, |most: f64| most.max(nearest)));
            }
        });
        reach
    }

    fn totals(&self) -> Totals {
        let (layout, volume, phi) = (self.grid.layout(), self.grid.cell_volume(), self.stepper.phi());
        let (min, max) = layout.range(phi);
        Totals { mass: layout.sum(phi) * volume, magnitude: layout.sum_abs(phi) * volume, min, max }
    }

    fn arrays(&self, fields: &[Field]) -> Result<Vec<Array<'_>>, OutputError> {
        let cells = self.grid.cells();
        let periodic = std::array::from_fn(|axis| self.stepper.sides().is_periodic(axis));
        let box_of: [usize; 3] = std::array::from_fn(|a| cells.get(a).copied().unwrap_or(1));
        let one = |field: &Field| match (field, self.stepper.flux(), self.stepper.velocity()) {
            (Field::Phi, ..) => Some(Array::padded("phi", &self.stepper.phi()[..], cells)),
            (Field::SlowFlux, Flux::Faces(flux), _) => Some(Array::faces("q_C", flux.axes(), cells, periodic)),
            (Field::SlowFlux, Flux::Cells(flux), _) => {
                let layout = self.grid.layout();
                let value = move |index: [usize; 3]| {
                    let slot = layout.slot(std::array::from_fn(|a| index[a]));
                    std::array::from_fn(|a| flux.get(a).map_or(T::ZERO, |axis| axis[slot]))
                };
                Some(Ok(Array::per_cell::<T, 3>("q_C", box_of, value)))
            }
            (Field::SlowFlux, Flux::None, _) | (Field::Velocity, _, Velocity::None) => None,
            (Field::Velocity, _, Velocity::Faces(u)) => Some(Array::faces("u", u.axes(), cells, periodic)),
            (Field::Pressure, ..) => {
                let (fluid, layout) = (self.stepper.fluid()?, self.grid.layout());
                // Schemes that keep none have none anywhere.
                fluid.pressure(layout.slot([0; D]))?;
                let value = move |index: [usize; 3]| {
                    [fluid.pressure(layout.slot(std::array::from_fn(|a| index[a]))).unwrap_or(0.0) as f32]
                };
                Some(Ok(Array::per_cell("p", box_of, value)))
            }
            (Field::Velocity, _, Velocity::Uniform(u)) => {
                let u: [f32; 3] = std::array::from_fn(|a| u.get(a).map_or(0.0, |u| *u as f32));
                Some(Ok(Array::per_cell("u", box_of, move |_| u)))
            }
        };
        fields.iter().filter_map(one).collect()
    }

    fn phi(&self) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.grid.layout().count());
        self.each_cell(|_, phi| values.push(phi));
        values
    }

    fn end(self: Box<Self>, phi: bool, flux: bool) -> (Option<Vec<f64>>, Option<Vec<Vec<f64>>>) {
        let Self { grid, stepper, .. } = *self;
        let (field, parts) = stepper.into_fields();
        let values = phi.then(|| {
            let mut values = Vec::with_capacity(grid.layout().count());
            grid.layout().each_cell(grid.layout().cells_region(), |at| values.push(field[at.slot()].f64()));
            values
        });
        drop(field);
        let wide = |axis: CellField<T>| axis.iter().map(|value| value.f64()).collect();
        (values, flux.then(|| parts.into_iter().map(wide).collect()))
    }

    fn layer(&self, slice: Slice) -> Vec<f64> {
        let layout = self.grid.layout();
        let mut region = layout.cells_region();
        if let (Some(low), Some(high)) = (region.low.get_mut(slice.axis), region.high.get_mut(slice.axis)) {
            (*low, *high) = (slice.index.min(*high - 1), (slice.index + 1).min(*high));
        }
        let (mut values, phi) = (Vec::new(), self.stepper.phi());
        layout.each_cell(region, |at| values.push(phi[at.slot()].f64()));
        values
    }

    fn flux(&self) -> Vec<Vec<f64>> {
        let wide = |axis: &[T]| axis.iter().map(|value| value.f64()).collect();
        match self.stepper.flux() {
            Flux::None => Vec::new(),
            Flux::Faces(flux) => flux.axes().map(wide).into(),
            Flux::Cells(flux) => flux.each_ref().map(|axis| wide(axis)).into(),
        }
    }

    fn fields(&self) -> Vec<FieldBytes> {
        let flux = match self.stepper.flux() {
            Flux::None => 0,
            Flux::Faces(flux) => flux.bytes(),
            Flux::Cells(flux) => flux.iter().map(CellField::bytes).sum(),
        };
        let flow = self.stepper.fluid().map_or(0, |fluid| fluid.bytes());
        let velocity = match self.stepper.velocity() {
            Velocity::Faces(u) if flow == 0 => u.bytes(),
            _ => 0,
        };
        let rows = [
            ("phi", self.stepper.phi().bytes()),
            ("q_C", flux),
            ("sources", size_of_val(&self.rate[..])),
            ("velocity", velocity),
            (FLOW_FIELDS, flow),
            ("stepper: scratch, solver, transport", self.stepper.bytes()),
        ];
        let stored = rows.into_iter().filter(|(_, bytes)| *bytes > 0);
        stored.map(|(name, bytes)| FieldBytes { name: name.into(), bytes: bytes as u64 }).collect()
    }

    fn ranges(&self) -> Vec<Range> {
        let (min, max) = self.grid.layout().range(self.stepper.phi());
        let mut ranges = vec![Range { field: "phi".into(), min, max }];
        match self.stepper.flux() {
            Flux::None => {}
            Flux::Faces(flux) => ranges.extend(self.face_ranges(FLUX, flux)),
            Flux::Cells(flux) => ranges.extend(FLUX.into_iter().zip(flux).map(|(name, values)| {
                let (min, max) = self.grid.layout().range(values);
                Range { field: name.into(), min, max }
            })),
        }
        if let Velocity::Faces(velocity) = self.stepper.velocity() {
            ranges.extend(self.face_ranges(SPEED, velocity));
        }
        ranges
    }

    fn solver(&self) -> (String, String) {
        self.stepper.solver()
    }

    fn not_finite(&self) -> Option<(&'static str, Vec<usize>)> {
        let mut found = None;
        self.each_cell(|cell, phi| {
            if found.is_none() && !phi.is_finite() {
                found = Some(("phi", cell.to_vec()));
            }
        });
        found
    }

    fn state(&self) -> Vec<(&'static str, Values<'_>)> {
        self.stepper.unknowns()
    }

    fn state_mut(&mut self) -> Vec<(&'static str, ValuesMut<'_>)> {
        self.stepper.unknowns_mut()
    }

    fn estimate(&mut self, on: bool) {
        self.stepper.estimate(on);
    }

    fn norm(&self) -> f64 {
        self.stepper.norm()
    }

    fn distance(&self, other: Values<'_>) -> [f64; 2] {
        let (layout, phi) = (self.grid.layout(), self.stepper.phi());
        let Some(other) = T::of_values(other).filter(|other| other.len() == phi.len()) else { return [f64::NAN; 2] };
        let (difference, size) = layout.par_runs(layout.cells_region(), (), |run, ()| {
            run.row(phi).iter().zip(run.row(other)).fold((0.0, 0.0), |(difference, size), (a, b)| {
                let (a, b) = (a.f64(), b.f64());
                (difference + (a - b) * (a - b), size + a * a)
            })
        });
        [difference, size]
    }

    fn reversed(&self) -> bool {
        self.stepper.reversed()
    }

    fn set_reversed(&mut self, reversed: bool) {
        self.stepper.set_reversed(reversed);
    }
}
