//! Where the medium at a place came from: the midpoint rule backwards in time.

use cf_grid::{FaceField, Layout, Real};
use nalgebra::SVector;

use crate::medium::Medium;

use super::sites::{Sites, unit};

/// Displacement from an arrival point to its foot, in cells.
///
/// x_m = x − (Δt/2) u(x), foot = x − Δt u(x_m), with u interpolated linearly from the faces; outside the box u is that of
/// the nearest point in it. `ratio` = Δt/h \[s/m\]. Kept apart from the place itself, so that the fraction of a cell does
/// not lose digits to the index.
#[inline(always)]
pub(super) fn displacement<T: Real, const D: usize>(
    sites: &Sites<D>,
    medium: &Medium<T, D>,
    ratio: f64,
    cell: [usize; D],
) -> SVector<f64, D> {
    match medium {
        Medium::Still => SVector::zeros(),
        Medium::Uniform(u) => -u * ratio,
        Medium::Field(field) => {
            // Coordinates in cells: cell i is centred at i.
            let mut x = cell.map(|i| i as f64);
            if let Some(a) = sites.normal {
                x[a] -= 0.5;
            }
            let here = match sites.normal {
                None => at_centre(sites, field, cell),
                Some(_) => velocity(sites, field, x),
            };
            for a in 0..D {
                x[a] -= 0.5 * ratio * here[a];
            }
            SVector::from(velocity(sites, field, x).map(|u| -ratio * u))
        }
    }
}

/// The velocity at the centre of a cell.
#[inline(always)]
fn at_centre<T: Real, const D: usize>(sites: &Sites<D>, u: &FaceField<T, D>, cell: [usize; D]) -> [f64; D] {
    let slot = sites.layout.slot(cell);
    let mut v = [0.0; D];
    for a in 0..D {
        let next = sites.slot(cell, unit(a, 1));
        v[a] = 0.5 * (u.axis(a)[slot].f64() + u.axis(a)[next].f64());
    }
    v
}

/// The velocity at `x` \[cells\], each component interpolated linearly between its faces.
#[inline(always)]
fn velocity<T: Real, const D: usize>(sites: &Sites<D>, u: &FaceField<T, D>, x: [f64; D]) -> [f64; D] {
    let mut centred = [([0; 2], 0.0); D];
    let mut faced = [([0; 2], 0.0); D];
    for a in 0..D {
        let (n, wraps) = (sites.layout.cells()[a], sites.edges.is_periodic(a));
        centred[a] = between(x[a], n, n - 1, wraps);
        faced[a] = between(x[a] + 0.5, n, n, wraps);
    }
    let mut v = [0.0; D];
    for a in 0..D {
        let mut nodes = centred;
        nodes[a] = faced[a];
        v[a] = linear(&sites.layout, u.axis(a), nodes);
    }
    v
}

/// The two indices around `x` and the weight of the upper one; periodic axes wrap, others stop at 0 and `last`.
#[inline(always)]
fn between(x: f64, n: usize, last: usize, wraps: bool) -> ([usize; 2], f64) {
    if x >= 0.0 && x < (n - 1) as f64 {
        let i = x as i64 as usize;
        return ([i, i + 1], x - i as f64);
    }
    if wraps {
        let (i, t) = floor(x);
        let wrap = |i: i64| i.rem_euclid(n as i64) as usize;
        return ([wrap(i), wrap(i.saturating_add(1))], t);
    }
    let (i, t) = floor(x.clamp(0.0, last as f64));
    ([i as usize, (i as usize + 1).min(last)], t)
}

#[inline(always)]
fn linear<T: Real, const D: usize>(layout: &Layout<D>, u: &[T], nodes: [([usize; 2], f64); D]) -> f64 {
    let ([left, right], t) = nodes[0];
    let mut sum = 0.0;
    for corner in 0..1 << (D - 1) {
        let (mut cell, mut w) = ([0; D], 1.0);
        for a in 1..D {
            let (index, t) = nodes[a];
            let upper = corner >> (a - 1) & 1 == 1;
            cell[a] = index[usize::from(upper)];
            w *= if upper { t } else { 1.0 - t };
        }
        let row = layout.slot(cell);
        let (l, r) = (u[row + left].f64(), u[row + right].f64());
        sum += w * (l + t * (r - l));
    }
    sum
}

/// The integer below and the fraction above it.
#[inline(always)]
pub(super) fn floor(x: f64) -> (i64, f64) {
    let i = x as i64;
    let i = i - i64::from((i as f64) > x);
    (i, x - i as f64)
}

#[cfg(test)]
mod tests {
    use cf_grid::{Grid, Sides, Wall};

    use super::*;

    #[test]
    fn floors_of_either_sign() {
        assert_eq!(floor(2.25), (2, 0.25));
        assert_eq!(floor(-2.25), (-3, 0.75));
        assert_eq!(floor(-2.0), (-2, 0.0));
    }

    #[test]
    fn the_midpoint_rule_turns_a_vortex() {
        let grid = Grid::new([40, 40], 0.1).unwrap();
        let spin = |x: SVector<f64, 2>| SVector::from([2.0 - x[1], x[0] - 2.0]);
        let u = Medium::Field(crate::medium::sample::<f64, 2>(&grid, spin).unwrap());
        let sides = Sides::all(Wall::Open { inflow: 0.0 });
        for sites in [Sites::cells(grid.layout(), &sides), Sites::faces(grid.layout(), &sides, 1)] {
            let (cell, dt) = ([25, 13], 0.1);
            let d = displacement(&sites, &u, dt / grid.h(), cell) * grid.h();
            let x = if sites.normal.is_some() { grid.face(1, cell) } else { grid.centre(cell) };
            let r = x - SVector::from([2.0, 2.0]);
            let exact = SVector::from([r[0] * dt.cos() + r[1] * dt.sin(), r[1] * dt.cos() - r[0] * dt.sin()]) - r;
            assert!((d - exact).norm() < 2e-4 * r.norm(), "{d} {exact}");
        }
    }
}
