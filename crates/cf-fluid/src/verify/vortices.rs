//! Vortices with known solutions: how far a scheme is from them, at which order it comes closer, what energy it keeps.

use std::f64::consts::TAU;

use cf_diffusion::verify::{Measured, Row, Table};
use cf_grid::{FaceField, Grid, Sides};

use crate::calculus::kinetic_energy;
use crate::carry::Interpolation;
use crate::exact::{lamb_chaplygin, taylor_green};
use crate::fluid::Fluid;
use crate::settings::{FlowSettings, Scheme};
use crate::wall::FlowWall;

const DRIFT: [f64; 2] = [1.0, 0.5];

/// A scheme, and how it interpolates where that is not its own choice.
type How = (Scheme, Option<Interpolation>);

fn named((scheme, interpolation): How) -> String {
    interpolation.map_or_else(|| format!("{scheme:?}"), |by| format!("{scheme:?}, {by:?}"))
}

/// Errors of the velocity and what became of the energy at t = 2, relative to the vortices alone.
fn carried(n: usize, cfl: f64, drift: [f64; 2], (scheme, interpolation): How) -> Measured<[f64; 2]> {
    let grid = Grid::<2>::new([n, n], TAU / n as f64)?;
    let sides = Sides::<FlowWall<2>, 2>::periodic();
    let settings = FlowSettings { scheme, interpolation, eta_div: 1e-10, ..FlowSettings::default() };
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

/// Of a dipole of radius 1 m that moves for 2 s at 1 m/s between walls 5 m away, which slow it down by O(1/25): its speed along
/// x \[m/s\] and what is left of its peak vorticity.
fn dipole(scheme: Scheme, cfl: f64) -> Measured<[f64; 2]> {
    let n = 128;
    let grid = Grid::<2>::new([n, n], 10.0 / n as f64)?;
    let settings = FlowSettings { scheme, eta_div: 1e-6, ..FlowSettings::default() };
    let mut fluid = Fluid::<f64, 2>::new(&grid, &Sides::all(FlowWall::Closed), None, settings)?;
    fluid.set_velocity(&lamb_chaplygin(&grid, [4.0, 5.0], 1.0, 1.0)?)?;
    let (start, peak) = vortex(&grid, fluid.velocity());
    let mut time = 0.0;
    while time < 2.0 - 1e-9 {
        let dt = fluid.dt_for(cfl).min(2.0 - time);
        fluid.step(dt)?;
        time += dt;
    }
    let (end, after) = vortex(&grid, fluid.velocity());
    if (end[1] - start[1]).abs() > 1e-3 {
        return Err(format!("it left its line by {:.1e} m", end[1] - start[1]).into());
    }
    Ok([(end[0] - start[0]) / time, after / peak])
}

/// Centroid of the squared vorticity \[m\], and its peak \[1/s\].
fn vortex(grid: &Grid<2>, u: &FaceField<f64, 2>) -> ([f64; 2], f64) {
    let (layout, h, mut moment, mut total, mut peak) = (grid.layout(), grid.h(), [0.0; 2], 0.0, 0f64);
    layout.each_cell(layout.cells_region(), |at| {
        if at.cell[0] > 0 && at.cell[1] > 0 {
            let along = u.axis(1)[at.slot()] - u.axis(1)[at.low(0)];
            let curl = (along - (u.axis(0)[at.slot()] - u.axis(0)[at.low(1)])) / h;
            (0..2).for_each(|a| moment[a] += curl * curl * at.cell[a] as f64 * h);
            total += curl * curl;
            peak = peak.max(curl.abs());
        }
    });
    (moment.map(|m| m / total), peak)
}

/// An error, relative energy change: of vortices on n² cells at a Courant number; no energy where none is known.
type Expected = ([f64; 2], usize, f64, f64, Option<f64>);

/// What each scheme should come to, from prototypes of the schemes in another language.
fn expected() -> Vec<(How, Vec<Expected>)> {
    use Interpolation::{Cubic, Linear, MacCormack};
    use Scheme::{CentralRk4, Cnp, Draft, ReflectionExtrapolated};
    let still = [0.0; 2];
    let steady = |e: [f64; 3], energy| {
        vec![(still, 64, 0.5, e[0], Some(energy)), (still, 128, 0.5, e[1], None), (still, 64, 2.0, e[2], None)]
    };
    let moving = |cases: &[(usize, f64, f64, Option<f64>)]| {
        cases.iter().map(|&(n, cfl, error, energy)| (DRIFT, n, cfl, error, energy)).collect::<Vec<_>>()
    };
    let linear = [
        steady([7.6e-2, 4.0e-2, 9.7e-2], -0.15),
        moving(&[(64, 0.5, 1.2e-1, Some(-0.22)), (64, 2.0, 9.0e-2, Some(-0.14))]),
    ];
    let mac = [
        steady([2.4e-2, 1.3e-2, 8.3e-2], -0.046),
        moving(&[(64, 0.5, 2.1e-2, Some(-0.024)), (64, 2.0, 7.1e-2, Some(-0.086))]),
    ];
    let cubic = [
        steady([2.5e-2, 1.3e-2, 8.3e-2], -0.047),
        moving(&[(64, 0.5, 1.9e-2, Some(-0.024)), (64, 2.0, 6.9e-2, Some(-0.086))]),
    ];
    vec![
        ((Draft, Some(Linear)), linear.concat()),
        ((Draft, Some(MacCormack)), mac.concat()),
        ((Draft, Some(Cubic)), cubic.concat()),
        (
            (Cnp, None),
            moving(&[
                (32, 0.5, 3.3e-3, None),
                (64, 0.5, 6.4e-4, Some(-7e-4)),
                (64, 1.0, 1.9e-3, Some(-2e-3)),
                (64, 2.0, 6.8e-3, Some(-6e-3)),
            ]),
        ),
        (
            (Cnp, Some(MacCormack)),
            moving(&[
                (32, 0.5, 2.0e-2, None),
                (64, 0.5, 4.9e-3, None),
                (64, 1.0, 5.0e-3, None),
                (64, 2.0, 9.1e-3, None),
            ]),
        ),
        (
            (ReflectionExtrapolated, None),
            moving(&[
                (32, 0.5, 2.3e-3, None),
                (64, 0.5, 3.3e-4, Some(-5e-4)),
                (64, 1.0, 5.9e-4, Some(-4e-4)),
                (64, 2.0, 1.9e-3, Some(-3e-4)),
            ]),
        ),
        (
            (ReflectionExtrapolated, Some(MacCormack)),
            moving(&[
                (32, 0.5, 1.8e-2, None),
                (64, 0.5, 4.4e-3, None),
                (64, 1.0, 4.8e-3, None),
                (64, 2.0, 4.7e-3, None),
            ]),
        ),
        ((CentralRk4, None), moving(&[(32, 0.5, 1.4e-2, None), (64, 0.5, 3.6e-3, None)])),
    ]
}

/// Taylor and Green's vortices, steady ones and such that a stream carries, which tells schemes apart that the steady ones do
/// not, and a dipole.
pub fn vortices() -> Table {
    use Scheme::{Auto, CentralRk4, Cnp, Draft, ReflectionExtrapolated};
    let mut rows = Vec::new();
    for (how, cases) in expected() {
        for (drift, n, cfl, error, energy) in cases {
            let which = if drift == DRIFT { "moving" } else { "steady" };
            let parameters = format!("{}, {n}², CFL {cfl}", named(how));
            let (error_found, change) = match carried(n, cfl, drift, how) {
                Ok([error, change]) => (Ok(error), Ok(change)),
                Err(why) => (Err(why.to_string().into()), Err(why)),
            };
            rows.push(Row::within_two(&format!("error, {which} vortices"), parameters.clone(), error, error_found));
            // A loss may be twice what is expected; none may gain.
            let least = energy.map_or(f64::NEG_INFINITY, |energy| 2.0 * energy);
            let mut row = Row::at_most("their energy grows by", parameters, 1e-4, change);
            row.pass &= row.measured > least;
            rows.push(row);
        }
    }
    for (scheme, order) in [(Draft, 1.0), (Cnp, 2.3), (ReflectionExtrapolated, 2.7), (CentralRk4, 2.0), (Auto, 2.3)] {
        let error = |n| carried(n, 0.5, DRIFT, (scheme, None));
        let found = error(32).and_then(|coarse| Ok((coarse[0] / error(64)?[0]).log2()));
        rows.push(Row::at_least(
            "order, moving vortices",
            format!("{scheme:?}, 32² to 64², CFL 0.5"),
            order,
            0.1,
            found,
        ));
    }
    let central = |drift| carried(64, 0.5, drift, (CentralRk4, None));
    let parameters = || "CentralRk4, 64², CFL 0.5".to_owned();
    rows.push(Row::at_most("error, steady vortices", parameters(), 1e-10, central([0.0; 2]).map(|[error, _]| error)));
    rows.push(Row::near("energy, moving vortices", parameters(), 0.0, 5e-9, central(DRIFT).map(|[_, change]| change)));
    for (scheme, cfl, slow) in [
        (Cnp, 0.8, 0.06),
        (ReflectionExtrapolated, 0.8, 0.06),
        (ReflectionExtrapolated, 2.0, 0.06),
        (CentralRk4, 0.5, 0.08),
    ] {
        let parameters = format!("{scheme:?}, 128², CFL {cfl}");
        let (speed, peak) = match dipole(scheme, cfl) {
            Ok([speed, peak]) => (Ok(speed), Ok(peak)),
            Err(why) => (Err(why.to_string().into()), Err(why)),
        };
        rows.push(Row::near("speed of a dipole", parameters.clone(), 1.0, slow, speed));
        rows.push(Row::near("what is left of its peak", parameters, 1.0, 0.1, peak));
    }
    Table { title: "incompressible flow against exact solutions", rows }
}
