//! Orders of accuracy in time and space, measured against exact solutions.

use std::f64::consts::{PI, TAU};

use cf_grid::{Axis, Sides, Wall};
use nalgebra::SVector;

use super::case::Case;
use super::{Measured, Row, Table};
use crate::advect::{Advection, Advector};
use crate::exact::{AxisModes, Walls, modes, source};
use crate::{Integrator, Law, Medium, Source, Splitting, State, kdk_limit, medium};

/// log2 of the ratio of two errors, the second on half the step.
fn order(errors: [f64; 2]) -> f64 {
    (errors[0] / errors[1]).log2()
}

/// The error at `end` of a sum of two discrete modes, from q_C = 0 and with a steady source on the first: time error only.
/// Relative to the largest value at the start.
fn in_time(law: Law, integrator: Integrator, steps: u32, end: f64, emission: f64) -> Measured {
    let (cells, h) = ([16, 12], 1.0 / 16.0);
    let mut case = Case::new(cells, h, law, integrator, end / f64::from(steps))?;
    case.settings.tolerance = 1e-13;
    case.sides = Sides([Axis::Walls([Wall::Value(0.0), Wall::CLOSED]), Axis::Periodic]);
    let x = AxisModes::new(Walls::ValuedClosed, cells[0], h).ok_or("no modes")?;
    let y = AxisModes::new(Walls::Periodic, cells[1], h).ok_or("no modes")?;
    let parts = [(0, 0, 4.0, emission), (1, 1, 2.0, 0.0)];
    let shape = |m: usize, l: usize, c: [usize; 2]| x.vector(m, c[0]) * y.vector(l, c[1]);
    let lambda = |m, l| x.eigenvalue(m) + y.eigenvalue(l);
    let mut state = State::<f64, 2>::new(&case.grid, &law);
    case.set_phi(&mut state, |c| parts.iter().map(|&(m, l, a, _)| a * shape(m, l, c)).sum());
    let mut rate = state.clone();
    case.set_phi(&mut rate, |c| parts.iter().map(|&(m, l, _, w)| w * shape(m, l, c)).sum());
    let mut expected = state.clone();
    let factors = parts.map(|(m, l, a, w)| {
        a * modes::response(&law, lambda(m, l), end) + w * source::still(&law, lambda(m, l), end)[0]
    });
    case.set_phi(&mut expected, |c| parts.iter().zip(factors).map(|(&(m, l, ..), f)| f * shape(m, l, c)).sum());
    let size = case.grid.layout().max_abs(&state.phi);
    let mut stepper = case.stepper::<f64>()?;
    for _ in 0..steps {
        stepper.step(&mut state, &Medium::Still, Source::steady(&rate.phi), case.dt)?;
    }
    Ok(largest_difference(&case, &state, &expected) / size)
}

fn largest_difference<const D: usize>(case: &Case<D>, one: &State<f64, D>, other: &State<f64, D>) -> f64 {
    let mut difference = one.phi.clone();
    difference.iter_mut().zip(other.phi.iter()).for_each(|(d, o)| *d -= o);
    case.grid.layout().max_abs(&difference)
}

/// The error of a wave between closed and valued walls against the continuous solution, dt in proportion to h.
fn in_space(law: Law, integrator: Integrator, n: usize) -> Measured {
    let (h, end) = (1.0 / n as f64, 0.25);
    let wave = law.speed().map_or(1.0, |c| 1.0 / c);
    let steps = (end / (0.4 * h * wave)).ceil();
    let mut case = Case::new([n, n / 2], h, law, integrator, end / steps)?;
    case.settings.tolerance = 1e-12;
    case.sides = Sides([Axis::Walls([Wall::CLOSED, Wall::Value(0.0)]), Axis::Periodic]);
    let (kx, ky) = (0.5 * PI, 2.0 * TAU);
    let grid = case.grid;
    let shape = |c: [usize; 2]| (kx * grid.centre(c)[0]).cos() * (ky * grid.centre(c)[1]).cos();
    let mut state = State::<f64, 2>::new(&grid, &law);
    case.set_phi(&mut state, shape);
    let factor = modes::response(&law, kx * kx + ky * ky, end);
    let mut expected = state.clone();
    case.set_phi(&mut expected, |c| factor * shape(c));
    case.run(&mut state, steps as usize)?;
    Ok(largest_difference(&case, &state, &expected))
}

/// The mean error of a wave carried by a uniform medium, against the continuous solution, dt in proportion to h.
fn carried(integrator: Integrator, splitting: Splitting, n: usize) -> Measured {
    let law = Law::new(0.05, 0.5, if integrator == Integrator::Kdk { 0.0 } else { 0.1 })?;
    let (h, end, u) = (1.0 / n as f64, 0.5, [0.8, -0.5]);
    let steps = (end / (0.5 * h)).ceil();
    let mut case = Case::new([n, n], h, law, integrator, end / steps)?;
    case.settings.tolerance = 1e-11;
    case.settings.splitting = splitting;
    case.sides = Sides::periodic();
    let (grid, k) = (case.grid, TAU);
    let wave = |c: [usize; 2], t: f64| (k * (grid.centre(c)[0] + grid.centre(c)[1] - (u[0] + u[1]) * t)).sin();
    let mut state = State::<f64, 2>::new(&grid, &law);
    case.set_phi(&mut state, |c| wave(c, 0.0));
    let factor = modes::response(&law, 2.0 * k * k, end);
    let mut stepper = case.stepper::<f64>()?;
    let medium = Medium::Uniform(SVector::from(u));
    for _ in 0..steps as usize {
        stepper.step(&mut state, &medium, Source::NONE, case.dt)?;
    }
    let mut error = state.clone();
    case.set_phi(&mut error, |c| state.phi[grid.layout().slot(c)] - factor * wave(c, end));
    Ok(grid.layout().sum_abs(&error.phi) / grid.layout().count() as f64)
}

/// What is carried by [`vortex`].
#[derive(Debug, Clone, Copy)]
enum Carried {
    /// phi, by whole steps.
    Phi(Integrator),
    /// q_C, by transport alone.
    SlowFlux,
}

/// n² values of phi in cells, or of q_C on low faces along x, at t = 0.4 in a vortex between closed walls, from bells
/// beside its centre; dt in proportion to h.
fn vortex(what: Carried, n: usize) -> Measured<Vec<f64>> {
    let integrator = if let Carried::Phi(integrator) = what { integrator } else { Integrator::Kdk };
    let law = Law::new(0.1, 0.5, if integrator == Integrator::Kdk { 0.0 } else { 0.1 })?;
    let (h, steps) = (1.0 / n as f64, n / 2);
    let mut case = Case::new([n, n], h, law, integrator, 0.4 / steps as f64)?;
    case.settings.tolerance = 1e-8;
    let grid = case.grid;
    let psi = |x: SVector<f64, 2>| 0.2 * ((PI * x[0]).sin() * (PI * x[1]).sin()).powi(2);
    let medium = Medium::Field(medium::stream_function(&grid, psi)?);
    let bell = |x: SVector<f64, 2>| (-(x - SVector::from([0.45, 0.6])).norm_squared() / 0.02).exp();
    let mut state = State::<f64, 2>::new(&grid, &law);
    case.set_phi(&mut state, |c| bell(grid.centre(c)));
    case.set_flux(&mut state, |axis, c, _| if axis == 0 { bell(grid.face(0, c)) } else { 0.0 });
    let mut stepper = case.stepper::<f64>()?;
    let mut advector = Advector::new(&grid, &case.sides, None, Advection::Muscl);
    for _ in 0..steps {
        match what {
            Carried::Phi(_) => _ = stepper.step(&mut state, &medium, Source::NONE, case.dt)?,
            Carried::SlowFlux => _ = advector.advect(&mut state.phi, state.slow_flux.as_mut(), &medium, case.dt)?,
        }
    }
    let values = match (what, &state.slow_flux) {
        (Carried::SlowFlux, Some(q)) => q.axis(0),
        _ => &state.phi[..],
    };
    Ok((0..n * n).map(|i| values[grid.layout().slot([i % n, i / n])]).collect())
}

/// phi of a bell after most of it has reached a wall at x = 1, along a line, by waves of speed 1 and a medium; dt in
/// proportion to h.
fn reaching_a_wall(wall: Wall, velocity: f64, integrator: Integrator, n: usize) -> Measured<Vec<f64>> {
    let law = Law::new(0.5, 0.5, 0.0)?;
    let (h, steps) = (1.0 / n as f64, n);
    let mut case = Case::new([n, 1], h, law, integrator, 0.5 / steps as f64)?;
    case.settings.tolerance = 1e-10;
    case.sides = Sides([Axis::Walls([Wall::Open { inflow: 0.0 }, wall]), Axis::Periodic]);
    let grid = case.grid;
    let mut state = State::<f64, 2>::new(&grid, &law);
    case.set_phi(&mut state, |c| (-((grid.centre(c)[0] - 0.6) / 0.1).powi(2)).exp());
    let mut stepper = case.stepper::<f64>()?;
    let medium = Medium::Uniform(SVector::from([velocity, 0.0]));
    for _ in 0..steps {
        stepper.step(&mut state, &medium, Source::NONE, case.dt)?;
    }
    Ok((0..n).map(|i| state.phi[grid.layout().slot([i, 0])]).collect())
}

/// Order by the mean differences of solutions on n, 2n and 4n cells.
fn at_a_wall(wall: Wall, velocity: f64, integrator: Integrator, n: usize) -> Measured {
    let apart = |coarse: &[f64], fine: &[f64]| {
        let pairs = coarse.iter().zip(fine.chunks_exact(2));
        pairs.map(|(value, pair)| (value - 0.5 * (pair[0] + pair[1])).abs()).sum::<f64>() / coarse.len() as f64
    };
    let solution = |n| reaching_a_wall(wall, velocity, integrator, n);
    let [coarse, middle, fine] = [solution(n)?, solution(2 * n)?, solution(4 * n)?];
    Ok(order([apart(&coarse, &middle), apart(&middle, &fine)]))
}

/// Order by the mean differences of three solutions on n², (2n)² and (4n)² cells.
fn in_a_vortex(what: Carried, n: usize) -> Measured {
    let both: &[usize] = if matches!(what, Carried::SlowFlux) { &[0] } else { &[0, 1] };
    let apart = |n: usize, coarse: &[f64], fine: &[f64]| {
        let children =
            |i: usize| both.iter().flat_map(move |x| [0, 1].map(|y| (2 * (i / n) + y) * 2 * n + 2 * (i % n) + x));
        let mean = |i: usize| children(i).map(|child| fine[child]).sum::<f64>() / (2 * both.len()) as f64;
        coarse.iter().enumerate().map(|(i, value)| (value - mean(i)).abs()).sum::<f64>() / coarse.len() as f64
    };
    let [coarse, middle, fine] = [vortex(what, n)?, vortex(what, 2 * n)?, vortex(what, 4 * n)?];
    Ok(order([apart(n, &coarse, &middle), apart(2 * n, &middle, &fine)]))
}

fn pair(mut error: impl FnMut(usize) -> Measured, n: usize) -> Measured {
    Ok(order([error(n)?, error(2 * n)?]))
}

/// Orders of every integrator: in time for laws from tau = 0 to waves, with a source, in space, in a medium that moves
/// evenly or in a vortex, and at walls that let waves or the medium pass, where it is first.
pub fn orders() -> Table {
    let mut rows = Vec::new();
    let laws =
        [(0.3, 2.0, 0.0), (0.3, 0.05, 0.2), (0.3, 1e-4, 0.0), (0.3, 1e-9, 0.0), (0.3, 0.0, 0.0), (0.3, 1.0, 1.0)];
    for (k, tau, share) in laws {
        let Ok(law) = Law::new(k, tau, share) else { continue };
        for (integrator, expected) in [(Integrator::PaperBe, 1.0), (Integrator::Sdirk2, 2.0), (Integrator::Kdk, 2.0)] {
            let kdk = integrator == Integrator::Kdk;
            if kdk && (share > 0.0 || tau < 0.1) {
                continue;
            }
            let limit = kdk_limit(&law, 8.0 * 256.0);
            let steps = if kdk {
                (1.0 / limit).ceil() as usize
            } else if expected == 1.0 {
                160
            } else {
                80
            };
            for emission in [0.0, 3.0] {
                let text = format!("{integrator:?} tau={tau:.0e} F={share} W={emission}");
                let found = pair(|n| in_time(law, integrator, n as u32, 0.5, emission), steps);
                rows.push(Row::near("order in time", text, expected, 0.1, found));
            }
        }
    }
    for (tau, share, integrator) in [
        (1.0, 0.0, Integrator::Kdk),
        (1.0, 0.0, Integrator::Sdirk2),
        (1.0, 0.3, Integrator::Sdirk2),
        (0.0, 0.0, Integrator::Sdirk2),
    ] {
        let text = format!("{integrator:?} tau={tau} F={share}");
        let found = Law::new(0.1, tau, share).map_err(Into::into);
        let found = found.and_then(|law| pair(|n| in_space(law, integrator, n), 32));
        rows.push(Row::near("order in space", text, 2.0, 0.1, found));
    }
    for (integrator, splitting, expected, n) in [
        (Integrator::Sdirk2, Splitting::Strang, 2.0, 64),
        (Integrator::Kdk, Splitting::Strang, 2.0, 64),
        (Integrator::PaperBe, Splitting::Paper, 1.0, 128),
    ] {
        let text = format!("{integrator:?} {splitting:?}");
        let found = pair(|n| carried(integrator, splitting, n), n);
        rows.push(Row::near("order in a moving medium", text, expected, 0.1, found));
    }
    for (what, n) in
        [(Carried::SlowFlux, 128), (Carried::Phi(Integrator::Kdk), 64), (Carried::Phi(Integrator::Sdirk2), 32)]
    {
        rows.push(Row::at_least("order in a vortex", format!("{what:?}"), 2.0, 0.2, in_a_vortex(what, n)));
    }
    let walls = [("absorbing", Wall::Absorbing { speed: 1.0, far: 0.0 }), ("open", Wall::Open { inflow: 0.0 })];
    for (name, wall) in walls {
        for (velocity, integrator) in
            [0.0, 0.5, -0.5].into_iter().flat_map(|u| [(u, Integrator::Kdk), (u, Integrator::Sdirk2)])
        {
            let expected = if name == "open" && velocity == 0.0 { 2.0 } else { 1.0 };
            let text = format!("{integrator:?} {name} u={velocity}");
            let found = at_a_wall(wall, velocity, integrator, 256);
            rows.push(Row::at_least("order at a wall", text, expected, 0.1, found));
        }
    }
    Table { title: "Orders of accuracy", rows }
}
