//! One backward Euler stage without any of the solver's machinery: face fluxes written out, a dense matrix found by
//! probing them, Gaussian elimination. For boxes of up to some hundred cells.

use cf_grid::{End, Real, Wall};

use super::Measured;
use super::case::Case;
use crate::{Coefficients, Integrator, Source, State};

/// One step of PaperBe or Sdirk2 in `f64`, and what left through the walls \[P m^D\].
pub fn dense_step<T: Real, const D: usize>(
    case: &Case<D>,
    start: &State<f64, D>,
    source: Source<'_, T>,
) -> Measured<(State<f64, D>, f64)> {
    match case.settings.integrator {
        Integrator::Kdk => Err("Kdk has no matrix".into()),
        Integrator::PaperBe => stage(case, start, source, case.dt),
        Integrator::Sdirk2 => {
            let gamma = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
            let (first, left) = stage(case, start, source, gamma * case.dt)?;
            let stretch = (1.0 - gamma) / gamma;
            let mut middle = start.clone();
            let far = |to: &mut [f64], first: &[f64]| {
                to.iter_mut().zip(first).for_each(|(u, y)| *u += stretch * (y - *u));
            };
            far(&mut middle.phi, &first.phi);
            if let (Some(q), Some(y)) = (&mut middle.slow_flux, &first.slow_flux) {
                q.axes_mut().into_iter().zip(y.axes()).for_each(|(q, y)| far(q, y));
            }
            let (end, last) = stage(case, &middle, source, gamma * case.dt)?;
            Ok((end, stretch * left + last))
        }
    }
}

/// A face that carries a flux: the fluid cells below and above it, or the wall in the place of one.
struct Face {
    axis: usize,
    slot: usize,
    beside: [Option<usize>; 2],
    wall: Option<(End, Wall)>,
}

fn faces<const D: usize>(case: &Case<D>) -> Vec<Face> {
    let layout = case.grid.layout();
    let mut all = Vec::new();
    for axis in 0..D {
        let n = layout.cells()[axis];
        let periodic = case.sides.is_periodic(axis);
        layout.each_cell(layout.faces_region(axis, periodic), |at| {
            let i = at.cell[axis];
            let cell = |index: usize| {
                let mut cell = at.cell;
                cell[axis] = index;
                Some(layout.slot(cell)).filter(|&slot| case.is_fluid(slot))
            };
            let end = if i == 0 { End::Low } else { End::High };
            let wall = if periodic || (i > 0 && i < n) { None } else { case.sides.wall(axis, end).map(|w| (end, w)) };
            let below = if wall.is_some() && i == 0 { None } else { cell((i + n - 1) % n) };
            let above = if i == n { None } else { cell(i) };
            let count = [below, above].iter().flatten().count();
            if count == 2 || (count == 1 && wall.is_some()) {
                all.push(Face { axis, slot: at.slot(), beside: [below, above], wall });
            }
        });
    }
    all
}

fn stage<T: Real, const D: usize>(
    case: &Case<D>,
    start: &State<f64, D>,
    source: Source<'_, T>,
    dt: f64,
) -> Measured<(State<f64, D>, f64)> {
    let (h, law, layout) = (case.grid.h(), &case.law, *case.grid.layout());
    let c = Coefficients::new(law, dt);
    // Without memory all of k answers at once.
    let (slow, fast) = if law.has_memory() { (c.gain, c.fast) } else { (0.0, law.k()) };
    let faces = faces(case);
    let old = |f: &Face| start.slow_flux.as_ref().map_or(0.0, |q| q.axis(f.axis)[f.slot]);
    // What is given, walls and old state, counts `given` times: 1 for the step, 0 for its matrix.
    let gradient = |f: &Face, phi: &[f64], given: f64| match (f.beside, f.wall) {
        ([Some(low), Some(high)], _) => (phi[high] - phi[low]) / h,
        ([None, Some(high)], Some((_, Wall::Value(v)))) => (phi[high] - given * v) / (0.5 * h),
        ([Some(low), None], Some((_, Wall::Value(v)))) => (given * v - phi[low]) / (0.5 * h),
        _ => 0.0,
    };
    // The total flux along the axis.
    let flux = |f: &Face, phi: &[f64], given: f64| match f.wall {
        None | Some((_, Wall::Value(_))) => given * c.keep * old(f) - (slow + fast) * gradient(f, phi, given),
        Some((end, Wall::Flux(g))) => given * end.sign() * g,
        Some((end, Wall::Absorbing { speed, far })) => {
            let cell = f.beside[0].or(f.beside[1]).unwrap_or(0);
            end.sign() * speed * (phi[cell] - given * far)
        }
        Some((_, Wall::Open { .. })) => 0.0,
    };
    let mut fluid = Vec::new();
    layout.each_cell(layout.cells_region(), |at| {
        if case.is_fluid(at.slot()) {
            fluid.push(at.slot());
        }
    });
    // phi + dt Div flux(phi) - phi* - dt W, which is to vanish.
    let residual = |phi: &[f64], given: f64| -> Vec<f64> {
        let mut r = phi.to_vec();
        for (r, old) in r.iter_mut().zip(start.phi.iter()) {
            *r -= given * old;
        }
        if let Some(rate) = source.rate {
            fluid.iter().for_each(|&slot| r[slot] -= given * dt * source.share * rate.at(slot).f64());
        }
        for f in &faces {
            let passing = dt / h * flux(f, phi, given);
            if let Some(low) = f.beside[0] {
                r[low] += passing;
            }
            if let Some(high) = f.beside[1] {
                r[high] -= passing;
            }
        }
        fluid.iter().map(|&slot| r[slot]).collect()
    };
    let mut phi = start.phi.to_vec();
    let rest = residual(&phi, 1.0);
    let n = fluid.len();
    let mut a = vec![vec![0.0; n]; n];
    // Unit vectors alone: next to what large fluxes leave, their response would be rounded away.
    let mut probe = vec![0.0; phi.len()];
    for (j, &slot) in fluid.iter().enumerate() {
        probe[slot] = 1.0;
        for (i, r) in residual(&probe, 0.0).into_iter().enumerate() {
            a[i][j] = r;
        }
        probe[slot] = 0.0;
    }
    let step = eliminate(a, rest)?;
    for (&slot, step) in fluid.iter().zip(step) {
        phi[slot] -= step;
    }
    let mut end = start.clone();
    end.phi.copy_from_slice(&phi);
    let mut outflow = 0.0;
    for f in &faces {
        if let Some((side, _)) = f.wall {
            outflow += dt / h * side.sign() * flux(f, &phi, 1.0) * case.grid.cell_volume();
        }
        let stored = matches!(f.wall, None | Some((_, Wall::Value(_))));
        if let (Some(q), true) = (&mut end.slow_flux, stored) {
            q.axis_mut(f.axis)[f.slot] = c.keep * old(f) - slow * gradient(f, &phi, 1.0);
        }
    }
    Ok((end, outflow))
}

/// x of A x = b by elimination with row exchange.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Measured<Vec<f64>> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        if a[k][k] == 0.0 {
            return Err("the dense matrix is singular".into());
        }
        let (head, tail) = a.split_at_mut(k + 1);
        for (i, row) in tail.iter_mut().enumerate() {
            let factor = row[k] / head[k][k];
            if factor != 0.0 {
                row[k..].iter_mut().zip(&head[k][k..]).for_each(|(x, p)| *x -= factor * p);
                b[k + 1 + i] -= factor * b[k];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    Ok(b)
}
