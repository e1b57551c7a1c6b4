//! The continuous equations on smooth data: no error in space either.

use cf_diffusion::Law;
use cf_diffusion::exact::modes::response;
use cf_grid::{Grid, Real, Sides, Wall};

use crate::cells;
use crate::error::SpectralError;
use crate::modes::Modes;
use crate::transform::{Direction, Of};

/// φ at the centres of cells after `t` \[s\], from φ there and q_C = 0, at rest: the solution of
///
/// ```text
/// τ φ_tt + φ_t = k ∇²φ + τ k_F ∇²φ_t              φ [P], k [m²/s], τ [s]
/// ```
///
/// for the smoothest function through the centres that suits the walls. The eigenvalue of a wave
/// is K², not that of differences; so the error is what the grid cannot show of the initial data, e.g. e^{−(πs/h)²/2} for a
/// Gaussian of standard deviation s.
///
/// # Errors
/// Walls other than closed ones and values of 0; a field of another layout; `t` not finite or < 0; values not finite.
pub fn smooth<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    law: &Law,
    phi: &mut [T],
    t: f64,
) -> Result<(), SpectralError> {
    let lifted = |&(_, _, wall): &(usize, cf_grid::End, Wall)| matches!(wall, Wall::Value(v) if v != 0.0);
    if let Some((axis, end, wall)) = sides.walls().find(lifted) {
        return Err(SpectralError::Lifted { axis, end, wall });
    }
    if !(t.is_finite() && t >= 0.0) {
        return Err(SpectralError::TimeStep(t));
    }
    let (expected, found) = (grid.layout().slots(), phi.len());
    if expected != found {
        return Err(SpectralError::Layout { what: "phi", expected, found });
    }
    let modes = Modes::new(grid, sides, Of::Waves)?;
    let (mut values, mut work) = (vec![0.0; modes.count()], vec![0.0; modes.count()]);
    cells::take(grid, |slot| phi[slot], &mut values);
    modes.transform(Direction::There, &mut values, &mut work);
    modes.each(&mut values, &mut work, |_, lambda, value, _| *value *= response(law, lambda, t));
    modes.transform(Direction::Back, &mut values, &mut work);
    if values.iter().any(|value| !value.is_finite()) {
        return Err(SpectralError::NotFinite);
    }
    cells::put(grid, &values, phi);
    Ok(())
}
