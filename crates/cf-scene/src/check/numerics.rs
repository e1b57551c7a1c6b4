//! `accuracy`: what each level means, and which knobs suit which law.
//!
//! The levels are those of `model/diffusion.md`, section 7.

use super::{Checker, out_of_range};
use crate::error::Detail;
use crate::scene::{Model, Numerics, TimeStep};
use crate::spec::{AccuracySpec, Advection, Integrator, Level, Medium, Precision, Solver, Splitting};

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
    };
    match level {
        Level::Draft => Numerics {
            integrator: Some(Integrator::PaperBe),
            advection: Advection::Linear,
            splitting: Splitting::Lie,
            step: TimeStep::Bounded(1.0),
            tolerance: 1e-3,
            ..standard
        },
        Level::Standard | Level::Target(_) => standard,
        Level::Accurate => {
            Numerics { step: TimeStep::Bounded(0.25), tolerance: 1e-8, precision: Precision::Mixed, ..standard }
        }
    }
}

/// Decides every knob.
pub(super) fn numerics(check: &mut Checker<'_>, spec: &AccuracySpec, model: &Model, preset: Option<&str>) -> Numerics {
    let implied = if preset == Some("draft") { Level::Draft } else { Level::Standard };
    let level = spec.level.unwrap_or(implied);
    if let Level::Target(error) = level {
        let detail = Detail::new(format!("choosing the knobs for an error of {error} comes with the trade-off study"));
        check.fail("accuracy.level", detail.expected("`Draft`, `Standard` or `Accurate`"));
    }
    for (name, value) in [("dt", spec.dt), ("cfl", spec.cfl)] {
        if let Some(value) = value {
            check.positive(&format!("accuracy.{name}"), value);
        }
    }
    check.require(spec.dt.is_none() || spec.cfl.is_none(), "accuracy.cfl", || {
        Detail::new("dt and cfl both fix the time step").advice("remove one, or set one to None")
    });
    let base = chosen(level);
    // A pulse that is solved exactly is solved in double precision.
    let exact = matches!(model, Model::SingleField(_));
    let step = match (spec.dt, spec.cfl) {
        (Some(dt), _) => TimeStep::Fixed(dt),
        (None, Some(cfl)) => TimeStep::Cfl(cfl),
        (None, None) => base.step,
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
    };
    let smallest = if numerics.precision == Precision::F32 { 1e-7 } else { 1e-15 };
    check.require((smallest..1.0).contains(&numerics.tolerance), "accuracy.tolerance", || {
        out_of_range(&format!("from {smallest:e} (rounding) to below 1"), numerics.tolerance)
    });
    suits_the_law(check, numerics.integrator, model);
    numerics
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
