//! Vortices with known solutions: how far a scheme is from them, at which order it comes closer, what energy it keeps.

use std::f64::consts::TAU;

use cf_diffusion::verify::{Measured, Row, Table};
use cf_grid::{FaceField, Grid, Sides};

use crate::calculus::kinetic_energy;
use crate::exact::{lamb_chaplygin, taylor_green};
use crate::fluid::Fluid;
use crate::settings::{FlowSettings, Scheme};
use crate::wall::FlowWall;

const DRIFT: [f64; 2] = [1.0, 0.5];

/// Errors of the velocity and what became of the energy at t = 2, relative to the vortices alone.
fn carried(n: usize, cfl: f64, drift: [f64; 2], scheme: Scheme) -> Measured<[f64; 2]> {
    let grid = Grid::<2>::new([n, n], TAU / n as f64)?;
    let sides = Sides::<FlowWall<2>, 2>::periodic();
    let settings = FlowSettings { scheme, eta_div: 1e-10, ..FlowSettings::default() };
    let mut fluid = Fluid::<f64, 2>::new(&grid, &sides, None, settings)?;
    fluid.set_velocity(&taylor_green(&grid, drift, 0.0)?)?;
    let speed = 1.0 + drift[0].abs().max(drift[1].abs());
    let steps = (2.0 * speed / (cfl * grid.h()) - 1e-9).ceil() as usize;
    for _ in 0..steps {
        fluid.step(2.0 / steps as f64)?;
    }
    let exact = taylor_green::<f64>(&grid, drift, 2.0)?;
    let energy = |u: &FaceField<f64, 2>| kinetic_energy(&grid, &sides, u);
    let less = |u: &FaceField<f64, 2>, from: &dyn Fn(usize, usize) -> f64| {
        let mut rest = u.clone();
        for a in 0..2 {
            rest.axis_mut(a).iter_mut().enumerate().for_each(|(slot, v)| *v -= from(a, slot));
        }
        rest
    };
    let still = |a: usize, _: usize| drift[a];
    let whole = energy(&less(&exact, &still));
    let apart = energy(&less(fluid.velocity(), &|a, slot| exact.axis(a)[slot]));
    Ok([(apart / whole).sqrt(), energy(&less(fluid.velocity(), &still)) / whole - 1.0])
}

/// Distance that a dipole of radius 1 m moves in 2 s at 1 m/s between walls 5 m away, which slow it down by O(1/25).
fn dipole(scheme: Scheme, cfl: f64) -> Measured {
    let n = 128;
    let grid = Grid::<2>::new([n, n], 10.0 / n as f64)?;
    let settings = FlowSettings { scheme, eta_div: 1e-6, ..FlowSettings::default() };
    let mut fluid = Fluid::<f64, 2>::new(&grid, &Sides::all(FlowWall::Closed), None, settings)?;
    fluid.set_velocity(&lamb_chaplygin(&grid, [4.0, 5.0], 1.0, 1.0)?)?;
    let start = middle(&grid, fluid.velocity());
    let mut time = 0.0;
    while time < 2.0 - 1e-9 {
        let dt = fluid.dt_for(cfl).min(2.0 - time);
        fluid.step(dt)?;
        time += dt;
    }
    Ok((middle(&grid, fluid.velocity()) - start) / time)
}

/// Centroid along x of the squared vorticity \[m\].
fn middle(grid: &Grid<2>, u: &FaceField<f64, 2>) -> f64 {
    let (layout, mut moment, mut total) = (grid.layout(), 0.0, 0.0);
    layout.each_cell(layout.cells_region(), |at| {
        if at.cell[0] > 0 && at.cell[1] > 0 {
            let curl = (u.axis(1)[at.slot()] - u.axis(1)[at.low(0)]) - (u.axis(0)[at.slot()] - u.axis(0)[at.low(1)]);
            moment += curl * curl * at.cell[0] as f64 * grid.h();
            total += curl * curl;
        }
    });
    moment / total
}

/// Taylor and Green's vortices carried by a stream, which tells schemes apart that the steady ones do not, and a dipole.
pub fn vortices() -> Table {
    use Scheme::{CentralRk4, Cnp, Draft, ReflectionExtrapolated};
    let mut rows = Vec::new();
    for (scheme, cfl, error) in [
        (Draft, 0.5, 2.1e-2),
        (Cnp, 0.5, 6.4e-4),
        (Cnp, 1.0, 1.9e-3),
        (ReflectionExtrapolated, 0.5, 3.3e-4),
        (ReflectionExtrapolated, 2.0, 1.9e-3),
        (CentralRk4, 0.5, 3.6e-3),
    ] {
        let parameters = format!("{scheme:?}, 64², CFL {cfl}");
        let found = carried(64, cfl, DRIFT, scheme);
        let (error_found, energy) = match found {
            Ok([error, energy]) => (Ok(error), Ok(energy)),
            Err(why) => (Err(why.to_string().into()), Err(why)),
        };
        // Within a factor of two of the table.
        let mut row = Row::near("error, moving vortices", parameters.clone(), error, error, error_found);
        row.pass &= row.measured >= 0.5 * error;
        rows.push(row);
        rows.push(Row::at_most("their energy grows by", parameters, 1e-4, energy));
    }
    for (scheme, order) in [(Draft, 1.0), (Cnp, 2.0), (ReflectionExtrapolated, 2.0), (CentralRk4, 2.0)] {
        let found = carried(32, 0.5, DRIFT, scheme)
            .and_then(|coarse| Ok((coarse[0] / carried(64, 0.5, DRIFT, scheme)?[0]).log2()));
        rows.push(Row::at_least(
            "order, moving vortices",
            format!("{scheme:?}, 32² to 64², CFL 0.5"),
            order,
            0.1,
            found,
        ));
    }
    let steady = carried(64, 0.5, [0.0; 2], CentralRk4).map(|[error, _]| error);
    rows.push(Row::at_most("error, steady vortices", "CentralRk4, 64², CFL 0.5".into(), 1e-10, steady));
    for (scheme, cfl) in [(Cnp, 0.8), (ReflectionExtrapolated, 2.0)] {
        let parameters = format!("{scheme:?}, 128², CFL {cfl}");
        rows.push(Row::near("speed of a dipole", parameters, 1.0, 0.06, dipole(scheme, cfl)));
    }
    Table { title: "incompressible flow against exact solutions", rows }
}
