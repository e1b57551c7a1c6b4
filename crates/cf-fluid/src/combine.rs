//! Sums of velocities, and forces.

use cf_grid::{FaceField, Layout, Real, Sides};

use crate::settings::Buoyancy;

/// y = a x + b y on all faces of the box.
pub(crate) fn combine<T: Real, W: Copy, const D: usize>(
    layout: &Layout<D>,
    sides: &Sides<W, D>,
    a: f64,
    x: &FaceField<T, D>,
    b: f64,
    y: &mut FaceField<T, D>,
) {
    let (a, b) = (T::of(a), T::of(b));
    for c in 0..D {
        let x = x.axis(c);
        layout.par_runs(
            layout.faces_region(c, sides.is_periodic(c)),
            y.axis_mut(c),
            #[inline(always)]
            |run, y: &mut [T]| {
                for (y, &x) in y.iter_mut().zip(run.row(x)) {
                    // What y held may be no number where it is not wanted.
                    *y = if b == T::ZERO { a * x } else { a * x + b * *y };
                }
            },
        );
    }
}

/// y += a x for potentials, rim included.
pub(crate) fn add<T: Real>(a: f64, x: &[T], y: &mut [T]) {
    let a = T::of(a);
    for (y, &x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// x *= a.
pub(crate) fn scale<T: Real>(a: f64, x: &mut [T]) {
    let a = T::of(a);
    x.iter_mut().for_each(|x| *x *= a);
}

/// u += dt (force + strength (phi - reference) up), phi as the mean of the two cells of a face, or of the one inside.
pub(crate) fn push<T: Real, W: Copy, const D: usize>(
    layout: &Layout<D>,
    sides: &Sides<W, D>,
    dt: f64,
    force: [f64; D],
    buoyancy: Option<(Buoyancy<D>, &[T])>,
    u: &mut FaceField<T, D>,
) {
    for a in 0..D {
        let lift = buoyancy.map(|(b, phi)| (b.strength * b.up[a], b.reference, phi)).filter(|l| l.0 != 0.0);
        if force[a] == 0.0 && lift.is_none() {
            continue;
        }
        let (n, periodic) = (layout.cells()[a], sides.is_periodic(a));
        layout.par_runs(layout.faces_region(a, periodic), u.axis_mut(a), |run, u: &mut [T]| {
            for (at, u) in run.ats().zip(u) {
                let mut b = force[a];
                if let Some((strength, reference, phi)) = lift {
                    let mut below = at.cell;
                    below[a] = match at.cell[a] {
                        0 if periodic => n - 1,
                        i => i.saturating_sub(1),
                    };
                    let above = if at.cell[a] < n { at.slot() } else { at.low(a) };
                    b += strength * (0.5 * (phi[layout.slot(below)].f64() + phi[above].f64()) - reference);
                }
                *u += T::of(dt * b);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_grid::Axis;

    /// phi = y + x/10 at centres, in units of h: on a face it is the mean of its two cells, on walls that of the one inside.
    #[test]
    fn buoyancy_takes_the_mean_of_a_face() {
        let layout = Layout::new([3, 4]).unwrap();
        let mut phi = vec![0.0; layout.slots()];
        layout.each_cell(layout.cells_region(), |at| phi[at.slot()] = at.cell[1] as f64 + 0.1 * at.cell[0] as f64);
        let buoyancy = Buoyancy { strength: 2.0, reference: 0.5, up: [0.0, 1.0] };
        for (y, low, high) in [(Axis::Walls([(); 2]), 0.0, 3.0), (Axis::Periodic, 1.5, f64::NAN)] {
            let sides = Sides([Axis::Walls([(); 2]), y]);
            let mut u = FaceField::<f64, 2>::new(&layout);
            push(&layout, &sides, 0.25, [0.0, 1.0], Some((buoyancy, &phi)), &mut u);
            for (j, mean) in [(0, low), (1, 0.5), (2, 1.5), (3, 2.5), (4, high)] {
                if !mean.is_nan() {
                    let expected = 0.25 * (1.0 + 2.0 * (mean + 0.2 - 0.5));
                    assert!((u.axis(1)[layout.slot([2, j])] - expected).abs() < 1e-15, "{y:?}, face {j}");
                }
            }
            assert!(u.axis(0).iter().all(|u| *u == 0.0));
        }
    }
}
