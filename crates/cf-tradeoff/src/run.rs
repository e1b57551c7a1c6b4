//! One setting on one problem, timed.

use crate::error::TradeoffError;
use crate::problem::On;
use crate::setting::{Numbers, Scheme, Setting};
use cf_diffusion::{Diffusion, Front, FrontState, Integrator, Medium, Settings, Source, State};
use cf_grid::{CellField, Real};
use cf_linear::Precision;
use cf_spectral::Spectral;
use nalgebra::SVector;
use std::time::Instant;

/// What a run left.
pub(crate) struct Run {
    /// With the rim.
    pub phi: Vec<f64>,
    /// Solver iterations.
    pub iterations: usize,
    /// Steps that were really made.
    pub steps: usize,
    /// With set-up, without initial values.
    pub seconds: f64,
}

pub(crate) fn run<T: Real, const D: usize>(on: &On<D>, setting: &Setting) -> Result<Run, TradeoffError> {
    let rate = on.rate.as_ref().map(|rate| {
        let mut narrow = CellField::<T>::new(on.grid.layout());
        narrow.iter_mut().zip(rate.iter()).for_each(|(w, &r)| *w = T::of(r));
        narrow
    });
    let source = rate.as_ref().map_or(Source::NONE, |rate| Source::steady(rate));
    match setting.scheme {
        Scheme::Front => front::<T, D>(on, setting, source),
        Scheme::Spectral => spectral::<T, D>(on, setting),
        _ => diffusion::<T, D>(on, setting, source),
    }
}

fn fill<T: Real>(phi: &mut [T], start: &[f64]) {
    phi.iter_mut().zip(start).for_each(|(p, &s)| *p = T::of(s));
}

fn widened<T: Real>(phi: &CellField<T>) -> Vec<f64> {
    phi.iter().map(|p| p.f64()).collect()
}

fn front<T: Real, const D: usize>(on: &On<D>, setting: &Setting, source: Source<'_, T>) -> Result<Run, TradeoffError> {
    let dt = on.end / setting.steps as f64;
    let mut state = FrontState::<T, D>::new(&on.grid);
    fill(&mut state.phi, &on.start);
    let begun = Instant::now();
    let front = Front::<T, D>::new(&on.grid, &on.sides, on.law, SVector::from(on.velocity))?;
    // The steps asked for, also beyond what the scheme would allow itself.
    let courant = (front.velocity().amax() + front.speed()) * dt / on.grid.h();
    let mut front = front.with_courant((courant * (1.0 + 1e-9)).min(1.0))?;
    let mut steps = 0;
    for _ in 0..setting.steps {
        steps += front.step(&mut state, source, dt)?.substeps;
    }
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Run { phi: widened(&state.phi), iterations: 0, steps, seconds })
}

fn spectral<T: Real, const D: usize>(on: &On<D>, setting: &Setting) -> Result<Run, TradeoffError> {
    let dt = on.end / setting.steps as f64;
    let mut state = State::<T, D>::new(&on.grid, &on.law);
    fill(&mut state.phi, &on.start);
    let begun = Instant::now();
    let mut spectral = Spectral::new(&on.grid, &on.sides, on.law)?;
    for _ in 0..setting.steps {
        spectral.step(&mut state, &Medium::Still, Source::NONE, dt)?;
    }
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Run { phi: widened(&state.phi), iterations: 0, steps: setting.steps, seconds })
}

fn diffusion<T: Real, const D: usize>(
    on: &On<D>,
    setting: &Setting,
    source: Source<'_, T>,
) -> Result<Run, TradeoffError> {
    let dt = on.end / setting.steps as f64;
    let integrator = match setting.scheme {
        Scheme::PaperBe => Integrator::PaperBe,
        Scheme::Kdk => Integrator::Kdk,
        _ => Integrator::Sdirk2,
    };
    let precision = if setting.numbers == Numbers::Mixed { Precision::Single } else { Precision::Full };
    let Setting { tolerance, advection, splitting, .. } = *setting;
    let settings = Settings { integrator, tolerance, precision, advection, splitting, ..Settings::default() };
    let moving = on.velocity.iter().any(|&u| u != 0.0);
    let medium = if moving { Medium::Uniform(SVector::from(on.velocity)) } else { Medium::Still };
    let mut state = State::<T, D>::new(&on.grid, &on.law);
    fill(&mut state.phi, &on.start);
    let (mut iterations, mut steps) = (0, 0);
    let begun = Instant::now();
    let mut diffusion = Diffusion::<T, D>::new(&on.grid, &on.sides, None, on.law, settings)?;
    for _ in 0..setting.steps {
        let report = diffusion.step(&mut state, &medium, source, dt)?;
        iterations += report.iterations;
        steps += report.substeps.max(1);
    }
    let seconds = begun.elapsed().as_secs_f64();
    Ok(Run { phi: widened(&state.phi), iterations, steps, seconds })
}
