//! The explicit staggered leapfrog KDK for F_T = 0, with exact relaxation:
//!
//! ```text
//! q <- e q - (1-e) k Grad phi;  phi <- phi - dt Div q + dt W;  q <- e q - (1-e) k Grad phi,   e = exp(-dt/2tau)
//! ```
//!
//! Second order, exactly conservative, no linear solve. Stable for k dt tanh(dt/2tau) 4 D/h² <= 2. Between sub-steps two
//! half kicks merge into one full kick. Absorbing walls are stepped by the trapezoidal rule, stable for any dt.

use cf_grid::{FaceField, Real, Wall, row_sum};

use crate::coefficients::{Kicks, kdk_limit};
use crate::implicit::{Moved, ROW, in_pieces, set_wall_flux};
use crate::law::Law;
use crate::source::Source;
use crate::state::State;
use crate::step_error::StepError;
use crate::sweeps::{net_outflow, update_flux};
use crate::walls::Walls;

/// The largest stable step on a grid of spacing `h` [m]: k dt tanh(dt/2tau) 4 D/h² = 2 \[s\].
pub(crate) fn limit<const D: usize>(law: &Law, h: f64) -> f64 {
    kdk_limit(law, 4.0 * D as f64 / (h * h))
}

/// `substeps` equal steps over `dt` \[s\] in all.
pub(crate) fn advance<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    h: f64,
    law: &Law,
    state: &mut State<T, D>,
    source: Source<'_, T>,
    dt: f64,
    substeps: usize,
) -> Result<Moved, StepError> {
    let limit = limit::<D>(law, h);
    let dt = dt / substeps as f64;
    // One part in 1e12: a step computed from the limit itself is meant to pass.
    if dt > limit * (1.0 + 1e-12) {
        return Err(StepError::Unstable { dt, limit });
    }
    let Some(q) = &mut state.slow_flux else { return Err(StepError::SlowFlux { found: false }) };
    let phi = &mut state.phi[..];
    let half = Kicks::new(law, dt);
    let (full_keep, full_gain) = (half.keep * half.keep, half.gain * (1.0 + half.keep));
    let mut outflow = 0.0;
    kick(walls, phi, q, half.keep, half.gain / h);
    for step in 1..=substeps {
        outflow += drift(walls, phi, q, source, dt, h)?;
        if step < substeps {
            kick(walls, phi, q, full_keep, full_gain / h);
        } else {
            kick(walls, phi, q, half.keep, half.gain / h);
        }
    }
    Ok(Moved { outflow, ..Default::default() })
}

fn kick<T: Real, const D: usize>(walls: &Walls<T, D>, phi: &mut [T], q: &mut FaceField<T, D>, keep: f64, gain: f64) {
    walls.fill_rim(phi);
    update_flux(walls, q, phi, keep, gain);
    walls.each(|w| {
        if let Wall::Value(v) = w.wall {
            set_wall_flux(q.axis_mut(w.axis), w, phi[w.cell].f64() - v, keep, gain);
        }
    });
}

/// Returns what left through the walls \[sum of phi\].
fn drift<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    phi: &mut [T],
    q: &mut FaceField<T, D>,
    source: Source<'_, T>,
    dt: f64,
    h: f64,
) -> Result<f64, StepError> {
    let layout = walls.layout;
    let per_h = dt / h;
    walls.fill_seams(q);
    let mut outflow = 0.0;
    walls.each(|w| {
        outflow += match w.wall {
            Wall::Flux(g) => {
                phi[w.cell] -= T::of(per_h * g);
                per_h * g
            }
            Wall::Value(_) => w.end.sign() * per_h * q.axis(w.axis)[w.face].f64(),
            Wall::Absorbing { .. } | Wall::Open { .. } => 0.0,
        };
    });
    // phi_new (1 + a) = phi_old (1 - a) + 2 a far + inner fluxes, a = c dt/2h: before and after the inner part. All walls of
    // a cell at once, so that phi = far stays in corners too.
    for w in &walls.absorbers {
        let before = phi[w.cell].f64();
        phi[w.cell] = T::of(before - 0.5 * per_h * w.speed * (before - w.far));
        outflow += before - phi[w.cell].f64();
    }
    let (flux, q) = (T::of(per_h), q.axes());
    let fluid = walls.mask.as_ref().map(|m| m.fluid());
    let poison: f64 = layout.par_runs(
        layout.cells_region(),
        &mut phi[..],
        #[inline(always)]
        |run, phi: &mut [T]| {
            let mut net = [T::ZERO; ROW];
            let mut poison = 0.0;
            in_pieces(
                &run,
                phi,
                #[inline(always)]
                |piece, phi| {
                    let net = &mut net[..phi.len()];
                    net_outflow(&piece, q, net);
                    for (phi, &net) in phi.iter_mut().zip(net.iter()) {
                        *phi -= flux * net;
                    }
                    if let Some(rate) = source.rate {
                        let emitted = T::of(dt * source.share);
                        let (skipped, rate) = rate.within(piece.slot(), phi.len());
                        for (i, (phi, &w)) in phi[skipped..].iter_mut().zip(rate).enumerate() {
                            if fluid.is_none_or(|f| f[piece.slot() + skipped + i]) {
                                *phi += emitted * w;
                            }
                        }
                    }
                    poison += row_sum(phi) * 0.0;
                },
            );
            poison
        },
    );
    if poison != 0.0
        && let Some(cell) = walls.first_bad(phi)
    {
        return Err(StepError::NotFinite { field: "phi", cell: cell.to_vec() });
    }
    for w in &walls.absorbers {
        let (a, before) = (0.5 * per_h * w.speed, phi[w.cell].f64());
        phi[w.cell] = T::of(before - a / (1.0 + a) * (before - w.far));
        outflow += before - phi[w.cell].f64();
    }
    Ok(outflow)
}
