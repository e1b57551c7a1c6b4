//! What stays within bounds: transport, walls, the explicit limit, stiffness, residuals, long runs, single precision.

use cf_grid::{Axis, FaceField, Grid, Sides, Wall};
use nalgebra::SVector;

use super::{finite, stiff};
use crate::verify::Measured;
use crate::verify::amplification::{Precise, distance, rounded};
use crate::verify::case::{Case, Kinds};
use crate::verify::conservation::mass_error;
use crate::verify::dense::dense_step;
use crate::verify::extremes::Check;
use crate::verify::iterations;
use crate::verify::random::Random;
use crate::{AdvectError, Advection, Integrator, Law, Medium, Source, Splitting, StepError, kdk_limit};

/// Media up to 1e4 cells per step, and media that converge by up to a cell per step.
pub(in crate::verify) struct Transport;

impl Check for Transport {
    const NAME: &'static str = "u";
    const EXPECTED: &'static str =
        "mass stays at any speed or the step is refused; semi-Lagrangian values keep their bounds";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 3.0);
        let mut case = stiff::<D>(random, Kinds::Closed, kappa)?;
        case.settings.splitting = random.pick([Splitting::Strang, Splitting::Paper]);
        let uniform = random.chance(0.5);
        let cells = random.decades(-3.0, if uniform { 4.0 } else { 0.0 });
        let speed = cells * case.grid.h() / case.dt;
        let layout = *case.grid.layout();
        let medium = if uniform {
            // Through obstacles it would not be free of divergence.
            (case.sides, case.mask) = (Sides::periodic(), None);
            Medium::Uniform(SVector::from_fn(|_, _| speed * random.between(-1.0, 1.0)))
        } else {
            let mut u = FaceField::<T, D>::new(&layout);
            for a in 0..D {
                let periodic = case.sides.is_periodic(a);
                layout.each_cell(layout.faces_region(a, periodic), |at| {
                    let on_wall = !periodic && (at.cell[a] == 0 || at.cell[a] == layout.cells()[a]);
                    u.axis_mut(a)[at.slot()] = if on_wall { T::ZERO } else { T::of(speed * random.between(-1.0, 1.0)) };
                });
            }
            Medium::Field(u)
        };
        case.settings.advection =
            random.pick([Advection::Muscl, Advection::Muscl, Advection::Cubic, Advection::Linear]);
        if case.settings.advection == Advection::Muscl {
            return match mass_error::<T, D>(&case, &medium, random, 1) {
                Err(why) => match why.downcast::<StepError>() {
                    Ok(why) if matches!(*why, StepError::Advect(AdvectError::TooManySubsteps { .. })) => Ok(0.0),
                    Ok(why) => Err(why),
                    Err(why) => Err(why),
                },
                // Rounding adds up over the sub-steps, about one per cell passed.
                found => Ok(found? / T::MASS / (1.0 + cells.sqrt())),
            };
        }
        // Transport alone.
        case.law = Law::new(0.0, 0.0, 1.0)?;
        case.settings.integrator = Integrator::PaperBe;
        let mut state = case.random_state::<T>(random, 1.0, 0.0);
        let before = layout.max_abs(&state.phi);
        case.stepper::<T>()?.step(&mut state, &medium, Source::NONE, case.dt)?;
        Ok(layout.max_abs(&state.phi) / before / (1.0 + 4.0 * T::EPSILON))
    }
}

/// All walls, mixed, with obstacles and sources.
pub(in crate::verify) struct Walls;

impl Check for Walls {
    const NAME: &'static str = "walls";
    const EXPECTED: &'static str = "phi, q_C and outflow of a dense solve, to 1e-12 (f64), 1e-5 (f32)";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 3.0);
        let mut case = stiff::<D>(random, Kinds::Any, kappa)?;
        let most = if D == 2 { 7 } else { 4 };
        let cells = std::array::from_fn(|a| case.grid.cells()[a].min(most));
        case.grid = Grid::new(cells, case.grid.h())?;
        if case.mask.is_some() {
            let solid: Vec<bool> = (0..case.grid.layout().slots()).map(|_| random.chance(0.3)).collect();
            let layout = *case.grid.layout();
            case.mask = Some(cf_grid::Mask::new(&layout, |cell| !solid[layout.slot(cell)]));
        }
        let start = case.random_state::<T>(random, 1.0, case.flux_unit());
        let rate = case.random_state::<T>(random, 1.0 / case.dt, 0.0).phi;
        let source = Source::during(&rate[..], random.unit());
        let start64 = rounded::<f64, T, D>(&case, &start);
        let (expected, outflow) = dense_step(&case, &start64, source)?;
        let mut state = start.clone();
        let report = case.stepper::<T>()?.step(&mut state, &Medium::Still, source, case.dt)?;
        let volume = case.grid.cell_volume();
        let size = (case.energy(&start64) + case.energy(&expected) + volume).sqrt();
        let wrong = distance(&case, &state, &expected) / size;
        let content = volume * case.grid.layout().count() as f64;
        // The dense outflow is a conductance times a difference: five roundings of phi (f64) grow by that.
        let stiff = 1.0 + 1e-3 * case.conductance(kappa);
        let through = (report.outflow - outflow).abs() / (outflow.abs() + content * stiff + case.passing());
        Ok(wrong.max(through) / T::STEP)
    }
}

/// Kdk just below and above its limit.
pub(in crate::verify) struct Explicit;

impl Check for Explicit {
    const NAME: &'static str = "Kdk";
    const EXPECTED: &'static str = "stable at 0.999 of its limit, two sub-steps at 1.001; absurd steps are refused";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let law = Law::cattaneo(random.decades(-3.0, 3.0), random.decades(-6.0, 6.0))?;
        let h = random.decades(-2.0, 2.0);
        let limit = kdk_limit(&law, 4.0 * D as f64 / (h * h));
        let share = random.pick([0.5, 0.999, 1.001, 3.3]);
        let mut case = Case::new([1; D], h, law, Integrator::Kdk, share * limit)?;
        case.random_box(random, Kinds::Dissipative, if D == 2 { 10 } else { 5 })?;
        let start = case.random_state::<T>(random, 1.0, case.flux_unit());
        let mut state = start.clone();
        let report = case.run(&mut state, 300)?;
        let substeps: usize = if share <= 1.0 { 1 } else { share.ceil() as usize };
        if report.substeps != substeps {
            return Err(format!("{} sub-steps at {share} of the limit", report.substeps).into());
        }
        case.dt = 1e9 * limit;
        if !matches!(case.run(&mut state.clone(), 1), Err(why) if why.to_string().contains("stability limit")) {
            return Err("1e9 limits were not refused".into());
        }
        // The conserved energy is E' times at least 1 - (dt/limit)^2.
        let allowed = 4.0 / (1.0 - (share / substeps as f64).powi(2)).max(1e-6);
        Ok(if finite(&case, &state) { case.energy(&state) / case.energy(&start) / allowed } else { f64::INFINITY })
    }
}

/// kappa from 1e-12 to 1e300.
pub(in crate::verify) struct Stiffness;

impl Check for Stiffness {
    const NAME: &'static str = "kappa";
    const EXPECTED: &'static str = "at most 10 multigrid iterations to 1e-6 on any box";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let most = if D == 2 { 40 } else { 14 };
        let cells: [usize; D] = std::array::from_fn(|_| 1 + random.below(most));
        let high = random.pick([6.0, 300.0]);
        let kappa = random.decades(-12.0, high);
        let sides = Sides(std::array::from_fn(|_| match random.below(4) {
            0 => Axis::Periodic,
            1 => Axis::Walls([0.0; 2]),
            2 => Axis::Walls([2.0 * kappa; 2]),
            _ => Axis::Walls([0.0, 2.0 * kappa]),
        }));
        Ok(iterations::count(cells, kappa, sides, None, random.bits())? / 10.0)
    }
}

/// Loose solves.
pub(in crate::verify) struct Residual;

impl Check for Residual {
    const NAME: &'static str = "residual";
    const EXPECTED: &'static str = "the residual reported by a loose solve bounds its error in phi";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 2.0);
        let mut case = stiff::<D>(random, Kinds::Any, kappa)?;
        case.settings.integrator = Integrator::PaperBe;
        let start = case.random_state::<T>(random, 1.0, case.flux_unit());
        let (mut tight, mut loose) = (start.clone(), start);
        case.run(&mut tight, 1)?;
        case.settings.tolerance = random.decades(-6.0, -1.0);
        let report = case.run(&mut loose, 1)?;
        let layout = case.grid.layout();
        let mut off: f64 = 0.0;
        layout.each_cell(layout.cells_region(), |at| {
            off = off.max((loose.phi[at.slot()].f64() - tight.phi[at.slot()].f64()).abs());
        });
        // phi is rebuilt from fluxes: their rounding is that of phi times what conducts.
        let size = layout.max_abs(&tight.phi).max(1.0) * (1.0 + case.conductance(kappa));
        Ok(off / (1.05 * report.residual + 100.0 * T::EPSILON * size))
    }
}

/// Hundreds of steps.
pub(in crate::verify) struct LongRun;

impl Check for LongRun {
    const NAME: &'static str = "long run";
    const EXPECTED: &'static str = "after 400 steps the mass is off by at most five times a step's allowance";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 6.0);
        let mut case = stiff::<D>(random, Kinds::Closed, kappa)?;
        case.settings.tolerance = 1e-4;
        // Each step may leave half a unit in the last place of one cell, of random sign: 1.2e-6 of a box of one cell.
        Ok(mass_error::<T, D>(&case, &Medium::Still, random, 400)? / (5.0 * T::MASS))
    }
}

/// The same step in f32 and f64.
pub(in crate::verify) struct Single;

impl Check for Single {
    const NAME: &'static str = "f32";
    const EXPECTED: &'static str = "three steps in f32 and f64 agree to 1e-4 of the start";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-6.0, 12.0);
        let mut case = stiff::<D>(random, Kinds::Dissipative, kappa)?;
        if random.chance(0.3) {
            case.sides = case.sides.map(|_, _, wall| if wall == Wall::CLOSED { wall } else { Wall::Value(1.0) });
        }
        let start = case.random_state::<f64>(random, 1.0, case.flux_unit());
        let (mut single, mut double) = (rounded::<f32, f64, D>(&case, &start), start.clone());
        case.run(&mut single, 3)?;
        case.run(&mut double, 3)?;
        let volume = case.grid.cell_volume();
        Ok(distance(&case, &single, &double) / (case.energy(&start) + volume).sqrt() / 1e-4)
    }
}
