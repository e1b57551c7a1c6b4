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
