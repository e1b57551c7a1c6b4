//! Central differences that conserve kinetic energy (Harlow and Welch 1965), for reference.

use cf_grid::{FaceField, Layout, Real, Sides};

use crate::calculus::fill_rims;

/// out = -Σ_b (F_b,high - F_b,low), F_ab = ubar_a ubar_b with two-point means, in (m/s)²: du_a/dt = out/h. Zero on wall faces.
/// The rims of `u` are filled.
pub(crate) fn momentum<T: Real, W: Copy, const D: usize>(
    layout: &Layout<D>,
    sides: &Sides<W, D>,
    u: &mut FaceField<T, D>,
    out: &mut FaceField<T, D>,
) {
    fill_rims(layout, sides, u);
    let u = u.axes();
    let quarter = T::of(0.25);
    for a in 0..D {
        let mut region = layout.faces_region(a, sides.is_periodic(a));
        out.axis_mut(a).fill(T::ZERO);
        if !sides.is_periodic(a) {
            region.low[a] += 1;
            region.high[a] -= 1;
        }
        layout.par_region(region, out.axis_mut(a), |at| {
            let slot = at.slot();
            let mut sum = T::ZERO;
            for b in 0..D {
                let (low, high) = (at.low(b), at.high(b));
                let side = if a == b {
                    let (l, h) = (u[a][low] + u[a][slot], u[a][slot] + u[a][high]);
                    h * h - l * l
                } else {
                    let back = layout.stride(a);
                    let l = (u[a][low] + u[a][slot]) * (u[b][slot - back] + u[b][slot]);
                    let h = (u[a][slot] + u[a][high]) * (u[b][high - back] + u[b][high]);
                    h - l
                };
                sum += side;
            }
            -quarter * sum
        });
    }
}
