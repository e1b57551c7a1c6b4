//! Where the medium at a place came from: the midpoint rule backwards in time (model section 6.6).

use cf_grid::{Layout, Real, Sides};
use nalgebra::SVector;

use crate::medium::Medium;

use super::sites::{Edge, Sites};

/// Displacement from an arrival point to its foot, in cells.
///
/// x_m = x − (Δt/2) u(x), foot = x − Δt u(x_m), with u interpolated linearly from the faces; outside the box u is that of
/// the nearest point in it. `ratio` = Δt/h \[s/m\]. Kept apart from the place itself, so that the fraction of a cell does
/// not lose digits to the index.
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
            let mut x = SVector::from(cell).map(|i: usize| i as f64);
            if let Some(a) = sites.normal {
                x[a] -= 0.5;
            }
            let velocity = |x: SVector<f64, D>| {
                SVector::<f64, D>::from_fn(|a, _| component(&sites.layout, &sites.edges, a, field.axis(a), x))
            };
            velocity(x - velocity(x) * (0.5 * ratio)) * -ratio
        }
    }
}

/// Linear interpolation of one velocity component at `x` \[cells\].
fn component<T: Real, const D: usize>(
    layout: &Layout<D>,
    edges: &Sides<Edge, D>,
    axis: usize,
    u: &[T],
    x: SVector<f64, D>,
) -> f64 {
    let mut index = [[0; 2]; D];
    let mut weight = [[1.0, 0.0]; D];
    for a in 0..D {
        let (n, shift) = (layout.cells()[a], if a == axis { 0.5 } else { 0.0 });
        let (pair, t) = if edges.is_periodic(a) {
            let (i, t) = floor(x[a] + shift);
            let wrap = |i: i64| i.rem_euclid(n as i64) as usize;
            ([wrap(i), wrap(i + 1)], t)
        } else {
            let last = n - 1 + usize::from(a == axis);
            let (i, t) = floor((x[a] + shift).clamp(0.0, last as f64));
            ([i as usize, (i as usize + 1).min(last)], t)
        };
        index[a] = pair;
        weight[a] = [1.0 - t, t];
    }
    let mut sum = 0.0;
    for corner in 0..1 << D {
        let side = |a: usize| corner >> a & 1;
        let slot = layout.slot(std::array::from_fn(|a| index[a][side(a)]));
        let w: f64 = (0..D).map(|a| weight[a][side(a)]).product();
        sum += w * u[slot].f64();
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
    use cf_grid::{Grid, Wall};

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
            let exact = SVector::from([
                r[0] * dt.cos() + r[1] * dt.sin(),
                r[1] * dt.cos() - r[0] * dt.sin(),
            ]) - r;
            assert!((d - exact).norm() < 2e-4 * r.norm(), "{d} {exact}");
        }
    }
}
