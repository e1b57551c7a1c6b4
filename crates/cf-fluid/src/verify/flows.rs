//! Flows whose behaviour is known: energy, streams past a sphere, and what a flow carries.

use std::f64::consts::TAU;

use cf_diffusion::medium::stream_function;
use cf_diffusion::verify::{Measured, Random, Row, Table};
use cf_diffusion::{Diffusion, Integrator, Law, Medium, Settings, State};
use cf_grid::{Axis, FaceField, Grid, Mask, Sides, Wall};

use crate::carry::Interpolation;
use crate::coupled::Coupled;
use crate::emit::{Emission, Emitter};
use crate::exact::taylor_green_3d;
use crate::flow::Flow;
use crate::fluid::Fluid;
use crate::settings::{Buoyancy, FlowSettings, Scheme};
use crate::shape::{Shape, obstacles};
use crate::wall::FlowWall;

use Scheme::{Auto, CentralRk4, Cnp, Draft, ReflectionExtrapolated};

fn settings<const D: usize>(scheme: Scheme, eta_div: f64) -> FlowSettings<D> {
    FlowSettings { scheme, eta_div, ..FlowSettings::default() }
}

/// A smooth flow on n² cells of a box of 1 m: a few random waves of a stream function, periodic, or between `closed` walls along y,
/// where it is zero.
pub fn random_flow(n: usize, seed: u64, closed: bool) -> Measured<FaceField<f64, 2>> {
    let mut bits = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut noise = || {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let pairs = (1..5).flat_map(|k| (1..5).map(move |l| [f64::from(k), f64::from(l)]));
    let waves: Vec<[f64; 4]> = pairs.map(|k| [k[0], k[1], noise(), TAU * noise()]).collect();
    let grid = Grid::<2>::new([n, n], 1.0 / n as f64)?;
    // Half waves: no periodic flow has them.
    let across = if closed { 0.5 * TAU } else { TAU };
    Ok(stream_function(&grid, |x| {
        let wave = |w: &[f64; 4]| {
            w[2] / (w[0] * w[0] + w[1] * w[1]) * (TAU * w[0] * x[0] + w[3]).sin() * (across * w[1] * x[1]).sin()
        };
        waves.iter().map(wave).sum()
    })?)
}

/// Energy that vortices in space change by in 2 s at CFL 0.5, and the largest gain on the way, both relative.
fn vortices_in_space(scheme: Scheme, n: usize) -> Measured<[f64; 2]> {
    let grid = Grid::<3>::new([n; 3], TAU / n as f64)?;
    let mut fluid = Fluid::<f64, 3>::new(&grid, &Sides::periodic(), None, settings(scheme, 1e-7))?;
    fluid.set_velocity(&taylor_green_3d(&grid)?)?;
    let (start, dt) = (fluid.kinetic_energy(), 0.5 * grid.h());
    let (mut time, mut last, mut most) = (0.0, start, 0f64);
    while time < 2.0 {
        fluid.step(dt)?;
        time += dt;
        let energy = fluid.kinetic_energy();
        // The second-order schemes gain a little while the vortices stretch; the others never.
        if !matches!(scheme, Cnp | ReflectionExtrapolated) && energy > last * (1.0 + 1e-7) {
            return Err(format!("energy rose from {last} to {energy} at {time} s").into());
        }
        most = most.max(energy / start - 1.0);
        last = energy;
    }
    Ok([last / start - 1.0, most])
}

/// Energy that a random flow keeps over 10 turnovers, and the most it had on the way, both relative.
fn kept(scheme: Scheme, interpolation: Option<Interpolation>, cfl: f64) -> Measured<[f64; 2]> {
    let n = 64;
    let grid = Grid::<2>::new([n, n], 1.0 / n as f64)?;
    let choice = FlowSettings { interpolation, ..settings(scheme, 1e-5) };
    let mut fluid = Fluid::<f64, 2>::new(&grid, &Sides::periodic(), None, choice)?;
    fluid.set_velocity(&random_flow(n, 11, false)?)?;
    let (start, speed) = (fluid.kinetic_energy(), fluid.max_speed());
    let (mut time, mut most) = (0.0, 1f64);
    while time < 2.5 / speed {
        fluid.step(cfl * grid.h() / speed)?;
        time += cfl * grid.h() / speed;
        most = most.max(fluid.kinetic_energy() / start);
    }
    Ok([fluid.kinetic_energy() / start, most])
}

/// The largest gain of energy of random flows, in units of 1e-3 a turnover, over 4 of them at CFL_u from 0.3 to `most`.
fn gain(scheme: Scheme, most: f64, closed: bool) -> Measured {
    let n = 32;
    let grid = Grid::<2>::new([n, n], 1.0 / n as f64)?;
    let mut sides = Sides::periodic();
    if closed {
        sides.0[1] = Axis::Walls([FlowWall::Closed; 2]);
    }
    let (mut random, mut worst) = (Random(5), f64::NEG_INFINITY);
    for _ in 0..4 {
        let cfl = random.between(0.3, most);
        let mut fluid = Fluid::<f64, 2>::new(&grid, &sides, None, settings(scheme, 1e-6))?;
        fluid.set_velocity(&random_flow(n, random.bits(), closed)?)?;
        let (start, speed) = (fluid.kinetic_energy(), fluid.max_speed());
        let (dt, turnover) = (cfl * grid.h() / speed, 0.25 / speed);
        let mut time = 0.0;
        while time < 4.0 * turnover {
            fluid.step(dt)?;
            time += dt;
            let growth = fluid.kinetic_energy() / start - 1.0;
            worst = worst.max(growth / (1e-3 * (time / turnover).max(1.0)));
        }
    }
    Ok(worst)
}

/// What a stream past a sphere does in 3 s.
struct Sphere {
    /// The largest normal velocity on a solid face \[m/s\].
    through: f64,
    /// The largest net outflow of the box in a step, as a share of its volume and of eta_div.
    balance: f64,
    /// The largest speed \[m/s\].
    speed: f64,
    /// What the energy grows by, and the distance from the potential flow, both relative.
    growth: f64,
    distance: f64,
}

/// A stream of 1 m/s, which begins as potential flow.
fn sphere(scheme: Scheme, cfl: f64) -> Measured<Sphere> {
    let grid = Grid::<3>::new([48, 24, 24], 0.1)?;
    let mask = obstacles(&grid, &[Shape::Sphere { center: [1.6, 1.2, 1.2], radius: 0.5 }])?;
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0, 0.0]), FlowWall::Open([1.0, 0.0, 0.0])]);
    let eta = 1e-4;
    let mut fluid = Fluid::<f32, 3>::new(&grid, &sides, Some(&mask), settings(scheme, eta))?;
    let mut start = FaceField::new(grid.layout());
    start.axis_mut(0).fill(1.0);
    fluid.set_velocity(&start)?;
    let (first, energy) = (fluid.velocity().clone(), fluid.kinetic_energy());
    let mut found = Sphere { through: 0.0, balance: 0.0, speed: 0.0, growth: 0.0, distance: 0.0 };
    let mut time = 0.0;
    while time < 3.0 {
        let dt = fluid.dt_for(cfl);
        let report = fluid.step(dt)?;
        if report.divergence > eta || report.at_floor || report.imbalance != 0.0 {
            return Err(format!("{report:?}").into());
        }
        found.balance = found.balance.max(fluid.net_outflow().abs() * dt / (eta * 4.8 * 2.4 * 2.4));
        found.speed = found.speed.max(fluid.max_speed());
        time += dt;
    }
    let (mut change, mut size) = (0.0, 0.0);
    for a in 0..3 {
        grid.layout().each_cell(grid.layout().cells_region(), |at| {
            let (u, v) = (f64::from(fluid.velocity().axis(a)[at.slot()]), f64::from(first.axis(a)[at.slot()]));
            change += (u - v).powi(2);
            size += v * v;
            if at.cell[a] > 0 && !(mask.fluid()[at.slot()] && mask.fluid()[at.low(a)]) {
                found.through = found.through.max(u.abs());
            }
        });
    }
    found.growth = fluid.kinetic_energy() / energy - 1.0;
    found.distance = (change / size).sqrt();
    Ok(found)
}

/// The largest difference of a plume in a solved stream from that in a given one, relative to the plume.
fn given_and_solved() -> Measured {
    let grid = Grid::<2>::new([24, 48], 1.0 / 24.0)?;
    let law = Law::from_hc(2.0, 1.0, 2.0, 0.0)?;
    let sides = Sides::all(Wall::Open { inflow: 0.0 });
    let up = [0.0, 1.0];
    let mut walls = Sides::all(FlowWall::Open(up));
    walls.0[1] = Axis::Walls([FlowWall::Inflow(up), FlowWall::Open(up)]);
    let choice = Settings { integrator: Integrator::Kdk, ..Settings::default() };
    let drop = Emitter::new(Shape::Sphere { center: [0.5, 0.5], radius: 0.06 }, None, Some(Emission::Rate(1.0)));
    let run = |flow: Flow<f64, 2>| -> Measured<State<f64, 2>> {
        let diffusion = Diffusion::new(&grid, &sides, None, law, choice)?;
        let mut coupled = Coupled::new(flow, diffusion, &[drop])?;
        let mut state = State::new(&grid, &law);
        for _ in 0..40 {
            coupled.step(&mut state, 0.02)?;
        }
        Ok(state)
    };
    let mut start = FaceField::new(grid.layout());
    start.axis_mut(1).fill(1.0);
    let mut fluid = Fluid::new(&grid, &walls, None, FlowSettings::default())?;
    fluid.set_velocity(&start)?;
    let solved = run(Flow::Solved(Box::new(fluid)))?;
    let given = run(Flow::Prescribed(Medium::Uniform(up.into())))?;
    let largest = grid.layout().max_abs(&given.phi);
    if largest < 0.05 {
        return Err("nothing was emitted".into());
    }
    let mut worst = 0f64;
    grid.layout().each_cell(grid.layout().cells_region(), |at| {
        worst = worst.max((solved.phi[at.slot()] - given.phi[at.slot()]).abs() / largest);
    });
    Ok(worst)
}

/// What total phi drifts by in 20 steps of a flow that buoyancy drives in a closed box, relative.
fn carried(eta_div: f64, scheme: Scheme, mask: Option<&Mask<2>>) -> Measured {
    let grid = Grid::<2>::new([24, 20], 0.05)?;
    let law = Law::cattaneo(1e-3, 0.5)?;
    let buoyancy = Some(Buoyancy { strength: 2.0, reference: 0.0, up: [0.3, 1.0] });
    let choice = FlowSettings { buoyancy, ..settings(scheme, eta_div) };
    let fluid = Fluid::new(&grid, &Sides::all(FlowWall::Closed), mask, choice)?;
    let diffusion = Diffusion::new(&grid, &Sides::all(Wall::CLOSED), mask.cloned(), law, Settings::default())?;
    let mut state = State::<f64, 2>::new(&grid, &law);
    let mut random = Random(2);
    grid.layout().each_cell(grid.layout().cells_region(), |at| {
        let fluid = mask.is_none_or(|m| m.fluid()[at.slot()]);
        state.phi[at.slot()] = if fluid { random.between(0.0, 2.0) } else { 0.0 };
    });
    let mut coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[])?;
    let before = state.mass(&grid);
    for _ in 0..20 {
        let report = coupled.step(&mut state, 0.05)?;
        if report.flow.is_none_or(|flow| flow.divergence > eta_div) {
            return Err("more divergence is left than allowed".into());
        }
    }
    if coupled.flow.fluid().is_none_or(|fluid| fluid.max_speed() < 0.05) {
        return Err("nothing moved".into());
    }
    Ok((state.mass(&grid) / before - 1.0).abs())
}

/// Two results of one measurement.
fn both(found: Measured<[f64; 2]>) -> [Measured; 2] {
    match found {
        Ok([one, other]) => [Ok(one), Ok(other)],
        Err(why) => [Err(why.to_string().into()), Err(why)],
    }
}

/// Energy of vortices in space and of random flows, a sphere in a stream, and mass in flows of any divergence.
pub fn flows() -> Table {
    let mut rows = Vec::new();
    let mut draft = 0.0;
    for (scheme, n) in [
        (CentralRk4, 32),
        (Draft, 32),
        (Cnp, 32),
        (ReflectionExtrapolated, 32),
        (Cnp, 64),
        (ReflectionExtrapolated, 64),
    ] {
        let parameters = format!("{scheme:?}, {n}³, CFL 0.5");
        let [change, most] = both(vortices_in_space(scheme, n));
        rows.push(Row::at_most("vortices in space gain", parameters.clone(), 5e-4, most));
        match scheme {
            CentralRk4 => rows.push(Row::near("their energy changes by", parameters, 0.0, 1e-5, change)),
            Draft => {
                draft = *change.as_ref().unwrap_or(&f64::NAN);
                rows.push(Row::at_most("their energy changes by", parameters, 0.0, change));
            }
            // Less than the draft loses.
            _ => rows.push(Row::near("their energy changes by", parameters, 0.0, draft.abs().min(5e-4), change)),
        }
    }
    for (scheme, by, expected) in [
        (Draft, Some(Interpolation::Linear), [0.23, 0.36, 0.38]),
        (Draft, Some(Interpolation::Cubic), [0.70, 0.56, 0.44]),
        (Draft, Some(Interpolation::MacCormack), [0.74, 0.56, 0.42]),
        (ReflectionExtrapolated, None, [0.86, 0.88, 0.90]),
        (Cnp, None, [0.86, 0.88, 0.69]),
    ] {
        for (cfl, expected) in [0.5, 2.0, 5.0].into_iter().zip(expected) {
            let how = by.map_or_else(String::new, |by| format!(", {by:?}"));
            let parameters = format!("{scheme:?}{how}, 64², CFL {cfl}, 10 turnovers");
            let [left, most] = both(kept(scheme, by, cfl));
            let lost = left.map(|left| 1.0 - left);
            rows.push(Row::at_most("energy a random flow loses", parameters.clone(), 1.0 - expected, lost));
            rows.push(Row::near("the most it had", parameters, 1.0, 3e-3, most));
        }
    }
    for (scheme, most) in [(Auto, 5.0), (Cnp, 1.0), (Cnp, 5.0), (ReflectionExtrapolated, 5.0), (Draft, 5.0)] {
        for (closed, sides) in [(false, "periodic"), (true, "closed")] {
            let parameters = format!("{scheme:?}, 32² {sides}, CFL 0.3 to {most}");
            rows.push(Row::at_most("energy gain per 1e-3 turnover", parameters, 1.0, gain(scheme, most, closed)));
        }
    }
    for (scheme, cfl) in [(Cnp, 0.8), (ReflectionExtrapolated, 0.8), (ReflectionExtrapolated, 2.5), (Draft, 0.8)] {
        let parameters = format!("{scheme:?}, 48x24x24, f32, CFL {cfl}");
        let found = sphere(scheme, cfl).map_err(|why| why.to_string());
        let one = |part: fn(&Sphere) -> f64| found.as_ref().map(part).map_err(|why| why.clone().into());
        rows.push(Row::at_most("flow into a sphere", parameters.clone(), 0.0, one(|s| s.through)));
        rows.push(Row::at_most("net outflow per eta_div", parameters.clone(), 1.0, one(|s| s.balance)));
        rows.push(Row::at_most("largest speed around it", parameters.clone(), 2.0, one(|s| s.speed)));
        rows.push(Row::at_most("energy that it adds", parameters.clone(), 0.1, one(|s| s.growth)));
        rows.push(Row::at_most("distance from potential flow", parameters, 0.3, one(|s| s.distance)));
    }
    rows.push(Row::at_most("solved and given stream differ", "24x48, 40 steps".into(), 1e-4, given_and_solved()));
    let ball = Grid::<2>::new([24, 20], 0.05).map_err(|why| why.to_string()).and_then(|grid| {
        obstacles(&grid, &[Shape::Sphere { center: [0.5, 0.5], radius: 0.2 }]).map_err(|e| e.to_string())
    });
    for scheme in [Cnp, ReflectionExtrapolated, Draft] {
        for eta in [0.3, 1e-2, 1e-6] {
            for around in ["a plain box", "a ball in it"] {
                let found = match (&ball, around) {
                    (_, "a plain box") => carried(eta, scheme, None),
                    (Ok(mask), _) => carried(eta, scheme, Some(mask)),
                    (Err(why), _) => Err(why.clone().into()),
                };
                let parameters = format!("{scheme:?}, eta_div {eta:e}, {around}");
                rows.push(Row::at_most("total phi drifts by", parameters, 1e-12, found));
            }
        }
    }
    Table { title: "flows of known behaviour, and what they carry", rows }
}
