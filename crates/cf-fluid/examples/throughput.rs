//! Cells per second of semi-Lagrangian transport, one scalar and three velocity components, and of whole steps.
//!
//! ```text
//! cargo run --release -p cf-fluid --example throughput -- [cells per axis] [threads]
//! ```

use std::f64::consts::TAU;
use std::time::Instant;

use cf_fluid::exact::taylor_green_3d;
use cf_fluid::{FlowSettings, FlowWall, Fluid, Interpolation, Scheme, Transport};
use cf_grid::{CellField, Grid, Sides};

fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let mut arguments = std::env::args().skip(1);
    let n: usize = arguments.next().map_or(Ok(256), |a| a.parse())?;
    let threads: usize = arguments.next().map_or(Ok(1), |a| a.parse())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| measure(n, threads))
}

fn measure(n: usize, threads: usize) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let grid = Grid::<3>::new([n; 3], TAU / n as f64)?;
    let cells = grid.layout().count() as f64;
    for (name, sides) in [("periodic", Sides::periodic()), ("closed", Sides::all(FlowWall::Closed))] {
        let mut by = taylor_green_3d::<f32>(&grid)?;
        let mut u = by.clone();
        let mut phi = CellField::<f32>::new(grid.layout());
        let mut transport = Transport::new(&grid, &sides, None, |_, _| 0.0);
        for how in [Interpolation::Linear, Interpolation::Cubic, Interpolation::MacCormack] {
            for cfl in [0.7, 5.0] {
                let dt = cfl * grid.h();
                let mut best = f64::INFINITY;
                for _ in 0..3 {
                    let start = Instant::now();
                    transport.all(&mut phi, &mut u, &mut by, dt, how);
                    best = best.min(start.elapsed().as_secs_f64());
                }
                println!(
                    "{name} {how:?} CFL {cfl}: {:.1} M cells/s per core (scalar and three components, f32)",
                    cells / best / 1e6 / threads as f64
                );
            }
        }
    }
    for scheme in [Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft] {
        let settings = FlowSettings { scheme, ..FlowSettings::default() };
        let mut fluid = Fluid::<f32, 3>::new(&grid, &Sides::periodic(), None, settings)?;
        fluid.set_velocity(&taylor_green_3d(&grid)?)?;
        let dt = 0.7 * grid.h();
        fluid.step(dt)?;
        let start = Instant::now();
        let mut iterations = 0;
        for _ in 0..3 {
            iterations += fluid.step(dt)?.iterations;
        }
        println!(
            "{scheme:?}: {:.2} s a step, {:.1} iterations, {:.0} MB",
            start.elapsed().as_secs_f64() / 3.0,
            f64::from(iterations as u32) / 3.0,
            fluid.bytes() as f64 / 1e6
        );
    }
    Ok(())
}
