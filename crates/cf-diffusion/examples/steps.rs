//! Seconds of single steps: `cargo run --release -p cf-diffusion --example steps`.
//!
//! Each line is the best of several steps on one thread pool, in nanoseconds per cell and step: the explicit step, the two
//! stages of Sdirk2, the scheme for fronts, and transport by a uniform and by a rotating medium.

use std::time::Instant;

use cf_diffusion::{Advection, Diffusion, Front, FrontState, Integrator, Law, Medium, Settings, Source, State};
use cf_grid::{FaceField, Grid, Real, Sides, Wall};
use nalgebra::SVector;

type Outcome<V = ()> = Result<V, Box<dyn std::error::Error>>;

const REPEATS: usize = 7;

fn best(mut step: impl FnMut() -> Outcome) -> Outcome<f64> {
    step()?;
    let mut best = f64::INFINITY;
    for _ in 0..REPEATS {
        let begun = Instant::now();
        step()?;
        best = best.min(begun.elapsed().as_secs_f64());
    }
    Ok(best)
}

fn rough(cell: &[usize]) -> f64 {
    cell.iter().enumerate().map(|(axis, &i)| ((axis + 2) as f64 * 0.37 * i as f64).sin()).sum()
}

fn measure<T: Real, const D: usize>(cells: [usize; D]) -> Outcome {
    let grid = Grid::<D>::new(cells, 1.0 / cells[0] as f64)?;
    let law = Law::cattaneo(0.25, 4.0)?;
    let (sides, dt) = (Sides::all(Wall::CLOSED), 0.5 * grid.h() / law.speed().unwrap_or(1.0));
    let per_cell = 1e9 / grid.layout().count() as f64;
    let say = |what: &str, seconds: f64| println!("{D}D {:>3} {what:<28} {:8.2} ns", T::NAME, seconds * per_cell);
    let start = || {
        let mut state = State::<T, D>::new(&grid, &law);
        grid.layout().par_cells(&mut state.phi, |at| T::of(rough(&at.cell)));
        state
    };
    for integrator in [Integrator::Kdk, Integrator::Sdirk2] {
        let mut state = start();
        let mut diffusion = Diffusion::new(&grid, &sides, None, law, Settings { integrator, ..Settings::default() })?;
        let mut step = || Ok(diffusion.step(&mut state, &Medium::Still, Source::NONE, dt).map(drop)?);
        // Twice the limit of one sub-step in two dimensions would be two: the step above is one.
        say(&format!("{integrator:?}"), best(&mut step)?);
    }
    let open = Sides::all(Wall::Open { inflow: 0.0 });
    let mut uniform = SVector::<f64, D>::zeros();
    uniform.fill(0.3);
    for (name, velocity) in [("Front, still", SVector::zeros()), ("Front, moving", uniform)] {
        let mut front = Front::<T, D>::new(&grid, &open, law, velocity)?;
        let mut state = FrontState::new(&grid);
        grid.layout().par_cells(&mut state.phi, |at| T::of(rough(&at.cell)));
        let dt = front.stable_dt();
        say(name, best(|| Ok(front.step(&mut state, Source::NONE, dt).map(drop)?))?);
    }
    let mut faces = FaceField::<T, D>::new(grid.layout());
    for axis in 0..D {
        let low = (axis + 1) % D;
        grid.layout().par_cells(faces.axis_mut(axis), |at| {
            let across = at.cell[low] as f64 / cells[low] as f64;
            T::of(0.3 * (6.0 * across).cos())
        });
    }
    let still = Law::cattaneo(0.0, 4.0)?;
    for (name, medium) in [("Muscl, uniform", Medium::Uniform(uniform)), ("Muscl, field", Medium::Field(faces))] {
        let settings = Settings { integrator: Integrator::Kdk, advection: Advection::Muscl, ..Settings::default() };
        let mut diffusion = Diffusion::new(&grid, &open, None, still, settings)?;
        let mut state = start();
        let dt = 0.5 * grid.h() / 0.3;
        say(name, best(|| Ok(diffusion.step(&mut state, &medium, Source::NONE, dt).map(drop)?))?);
    }
    Ok(())
}

fn main() -> Outcome {
    measure::<f64, 2>([1024; 2])?;
    measure::<f32, 2>([1024; 2])?;
    measure::<f64, 3>([96; 3])?;
    measure::<f32, 3>([96; 3])
}
