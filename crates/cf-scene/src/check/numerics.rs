//! `accuracy`: what each level means, and which knobs suit which law.

use super::{Checker, out_of_range};
use crate::error::{Detail, number};
use crate::scene::{Diffusion, Grid, Model, Numerics, TimeStep};
use crate::spec::{
    AccuracySpec, Advection, FlowScheme, Integrator, Level, Medium, Precision, Solver, Splitting, StepRule,
};
use crate::target;
use cf_diffusion::Front;

/// What a level chooses.
fn chosen(level: Level) -> Numerics {
    let standard = Numerics {
        level,
        integrator: None,
        advection: Advection::Muscl,
        splitting: Splitting::Strang,
        step: TimeStep::Shift(0.5),
        tolerance: 1e-5,
        precision: Precision::F32,
        solver: Solver::Auto,
        flow: FlowScheme::Auto,
        eta_div: 1e-4,
    };
    match level {
        Level::Draft => Numerics {
            advection: Advection::Linear,
            splitting: Splitting::Lie,
            step: TimeStep::Bounded(1.0),
            tolerance: 1e-3,
            flow: FlowScheme::Draft,
            eta_div: 1e-2,
            ..standard
        },
        Level::Standard => standard,
        // Rounding and loose solves stay a hundred times below.
        Level::Target(error) => Numerics {
            tolerance: (1e-2 * error).clamp(1e-9, 1e-3),
            precision: if error < 1e-4 { Precision::F64 } else { Precision::F32 },
            ..standard
        },
        Level::Accurate => {
            let step = TimeStep::Bounded(0.25);
            Numerics { step, tolerance: 1e-8, precision: Precision::Mixed, eta_div: 1e-7, ..standard }
        }
    }
}

/// Cells that a solved fluid moves in a step, unless the scene says.
const FLOW_CFL: f64 = 0.8;

/// What a fluid that is solved for does not go with, and the range of its tolerance.
fn suits_a_fluid(check: &mut Checker<'_>, spec: &AccuracySpec, level: Level) {
    let fluid = "where a fluid is solved for, its own speed decides how long steps are";
    let how = "accuracy.cfl, in cells that the fluid moves, or accuracy.dt";
    check.require(!matches!(level, Level::Target(_)), "accuracy.level", || {
        Detail::new(format!("{fluid}, so Target cannot")).expected("Draft, Standard or Accurate").advice(how)
    });
    check.require(spec.step.is_none(), "accuracy.step", || Detail::new(fluid).expected(how));
    if let Some(eta) = spec.eta_div {
        check.require(eta > 0.0 && eta < 1.0, "accuracy.eta_div", || out_of_range("above 0 and below 1", eta));
    }
}

/// Decides every knob.
pub(super) fn numerics(
    check: &mut Checker<'_>,
    spec: &AccuracySpec,
    grid: &Grid,
    model: &Model,
    preset: Option<&str>,
) -> Numerics {
    let implied = if preset == Some("draft") { Level::Draft } else { Level::Standard };
    let level = spec.level.unwrap_or(implied);
    if let Level::Target(error) = level {
        check.require(error > 0.0 && error < 1.0, "accuracy.level", || out_of_range("above 0 and below 1", error));
        check.require(target::ladder(grid).len() > 2, "accuracy.level", || {
            Detail::new(
                "Target measures errors between grids of half as many cells each, and these cannot be halved twice",
            )
            .expected(format!("cells along each axis divisible by 4, at least {} of them", 4 * target::FEWEST_CELLS))
            .found(format!("{:?}", grid.cells.to_vec()))
        });
        for (name, given) in [("dt", spec.dt.is_some()), ("cfl", spec.cfl.is_some()), ("step", spec.step.is_some())] {
            check.require(!given, &format!("accuracy.{name}"), || {
                Detail::new("Target chooses the time step itself").advice("remove one of the two, or set it to None")
            });
        }
    }
    for (name, value) in [("dt", spec.dt), ("cfl", spec.cfl)] {
        if let Some(value) = value {
            check.positive(&format!("accuracy.{name}"), value);
        }
    }
    check.require(spec.dt.is_none() || spec.cfl.is_none(), "accuracy.cfl", || {
        Detail::new("dt and cfl both fix the time step").advice("remove one, or set one to None")
    });
    if let Some(StepRule::Adaptive { tolerance }) = spec.step {
        let expected = "above 0 and below 1";
        check.require(tolerance > 0.0 && tolerance < 1.0, "accuracy.step.tolerance", || {
            out_of_range(expected, tolerance)
        });
        check.require(spec.dt.is_none() && spec.cfl.is_none(), "accuracy.step", || {
            Detail::new("dt and cfl fix the time step that an adaptive step varies").advice("remove one of them")
        });
        check.require(matches!(spec.integrator, None | Some(Integrator::Sdirk2)), "accuracy.step", || {
            Detail::new("only Sdirk2 estimates its own error, by which adaptive steps are chosen")
                .expected("integrator: Sdirk2, or none")
                .found(format!("{:?}", spec.integrator.unwrap_or(Integrator::Sdirk2)))
        });
    }
    let solved = matches!(model, Model::Diffusion(Diffusion { medium: Medium::Solved { .. }, .. }));
    if solved {
        suits_a_fluid(check, spec, level);
    }
    let mut base = chosen(level);
    // A pulse that is solved exactly is solved in double precision.
    let exact = matches!(model, Model::SingleField(_));
    let step = match (spec.dt, spec.cfl, spec.step) {
        (Some(dt), ..) => TimeStep::Fixed(dt),
        (None, cfl, _) if solved => TimeStep::Courant(cfl.unwrap_or(FLOW_CFL)),
        (None, Some(cfl), _) => TimeStep::Cfl(cfl),
        (None, None, Some(StepRule::Adaptive { tolerance })) => {
            base.integrator = Some(Integrator::Sdirk2);
            // What a solve leaves out must not be taken for an error in time.
            base.tolerance = base.tolerance.min(1e-2 * tolerance).max(1e-7);
            TimeStep::Adaptive(tolerance)
        }
        (None, None, None) => base.step,
    };
    let numerics = Numerics {
        level,
        integrator: spec.integrator.or(base.integrator),
        advection: spec.advection.unwrap_or(base.advection),
        splitting: spec.splitting.unwrap_or(base.splitting),
        step,
        tolerance: spec.tolerance.unwrap_or(base.tolerance),
        precision: if exact { Precision::F64 } else { spec.precision.unwrap_or(base.precision) },
        solver: spec.solver.unwrap_or(base.solver),
        flow: spec.flow.unwrap_or(base.flow),
        eta_div: spec.eta_div.unwrap_or(base.eta_div),
    };
    let smallest = if numerics.precision == Precision::F32 { 1e-7 } else { 1e-15 };
    check.require((smallest..1.0).contains(&numerics.tolerance), "accuracy.tolerance", || {
        out_of_range(&format!("from {smallest:e} (rounding) to below 1"), numerics.tolerance)
    });
    if let TimeStep::Adaptive(tolerance) = numerics.step {
        let least = if numerics.precision == Precision::F32 { 1e-5 } else { 1e-12 };
        check.require(tolerance >= least, "accuracy.step.tolerance", || {
            out_of_range(&format!("at least {least:e}, where rounding begins in {:?}", numerics.precision), tolerance)
                .advice("use precision: f64")
        });
    }
    suits_the_law(check, numerics.integrator, model);
    if numerics.integrator == Some(Integrator::Characteristic) {
        suits_fronts(check, grid, model);
    }
    numerics
}

/// Whether the cells resolve what the scheme for fronts needs: h <= 0.3 c tau.
fn suits_fronts(check: &mut Checker<'_>, grid: &Grid, model: &Model) {
    let Model::Diffusion(model) = model else { return };
    let Some(speed) = model.law.speed().filter(|c| *c > 0.0) else { return };
    let (ratio, limit) = (grid.spacing / (speed * model.law.tau), Front::<f64, 2>::CELL_RATIO);
    check.require(ratio <= limit, "accuracy.integrator", || {
        Detail::new(format!(
            "the cells are too coarse for Characteristic: h/(c tau) = {}. A front fades as e^(-t/2 tau), here before \
             it has crossed {} cells, and the scheme has errors of 2 % at 1 and of 14 % at 3",
            number((100.0 * ratio).round() / 100.0),
            number((20.0 / ratio).round() / 10.0)
        ))
        .expected(format!("h/(c tau) up to {limit}: h at most {:.3e} m", limit * speed * model.law.tau))
        .found(format!("h = {:.3e} m", grid.spacing))
        .advice("use more cells, or Kdk or Sdirk2, which have no such limit")
    });
}

fn suits_the_law(check: &mut Checker<'_>, integrator: Option<Integrator>, model: &Model) {
    let Model::Diffusion(model) = model else { return };
    let waves = model.law.fourier == 0.0 && model.law.tau > 0.0;
    if integrator == Some(Integrator::Characteristic) {
        let plain = matches!(model.medium, Medium::Still | Medium::Uniform(_)) && model.obstacles.is_empty();
        check.require(plain && waves && model.law.k > 0.0, "accuracy.integrator", || {
            Detail::new("Characteristic follows the waves of a uniform medium")
                .expected("fourier: 0, tau and k above 0, a medium Still or Uniform, and no obstacles")
                .advice("use Kdk, or Sdirk2 where a part of the flux has no memory")
        });
    }
    let explicit = integrator == Some(Integrator::Kdk);
    check.require(!explicit || waves, "accuracy.integrator", || {
        Detail::new("Kdk steps waves only")
            .expected("a law with fourier: 0 and tau above 0")
            .found(format!("fourier: {}, tau: {}", model.law.fourier, model.law.tau))
            .advice("use Sdirk2")
    });
}
