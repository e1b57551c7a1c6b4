//! P3: a small steady source in a uniform flow, and the cone behind it.
//!
//! u = 1 m/s along x, τ = 2 s, k = τ (u/H_c)², W = e^{−r²/2σ²}, σ = 0.04 m, at (0.75, 2) m of a periodic box of 4 m by
//! 4 m, from t = 0 until 1.5 s. For F_T = 0 and H_c > 1 what the source emits stays in a cone of half angle
//! α = asin(1/H_c), but for its own width.

use crate::error::TradeoffError;
use crate::problem::{On, field};
use cf_diffusion::{Law, half_angle};
use cf_grid::{CellField, Grid, Sides};

const FLOW: f64 = 1.0;
const TAU: f64 = 2.0;
const SIGMA: f64 = 0.04;
const SOURCE: [f64; 2] = [0.75, 2.0];
const SIDE: f64 = 4.0;
const END: f64 = 1.5;

/// The cone behind a source in a flow along x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wake {
    /// Half angle α \[rad\]; a right angle where waves are as fast as the flow.
    pub angle: f64,
    /// The source \[m\].
    pub source: [f64; 2],
    /// Its standard deviation \[m\].
    pub sigma: f64,
    /// From the source along the flow to where the newest and the oldest waves touch the cone \[m\].
    pub touch: f64,
}

impl Wake {
    /// How far a point lies outside the cone \[m\], negative inside.
    pub fn beyond(&self, x: [f64; 2]) -> f64 {
        let [along, across] = [x[0] - self.source[0], (x[1] - self.source[1]).abs()];
        // Nearest to the edge, or to the tip for points upstream of the edge's normal there.
        let foot = along * self.angle.cos() + across * self.angle.sin();
        if foot < 0.0 { along.hypot(across) } else { across * self.angle.cos() - along * self.angle.sin() }
    }
}

pub(crate) fn wake(n: usize, hc: f64, share: f64) -> Result<On<2>, TradeoffError> {
    let c = FLOW / hc;
    let law = Law::new(TAU * c * c, TAU, share)?;
    let grid = Grid::<2>::new([n; 2], SIDE / n as f64)?;
    let velocity = [FLOW, 0.0];
    let rate = field(&grid, |cell| {
        let x = grid.centre(cell);
        (-0.5 * ((x[0] - SOURCE[0]).powi(2) + (x[1] - SOURCE[1]).powi(2)) / (SIGMA * SIGMA)).exp()
    });
    let mut exact = CellField::new(grid.layout());
    cf_spectral::wake(&grid, &law, velocity, &rate, END, &mut exact)?;
    let wake = (hc >= 1.0 && share == 0.0).then(|| {
        let angle = half_angle(hc);
        Wake { angle, source: SOURCE, sigma: SIGMA, touch: FLOW * END * angle.cos().powi(2) }
    });
    Ok(On {
        grid,
        sides: Sides::periodic(),
        law,
        velocity,
        rate: Some(rate),
        end: END,
        start: CellField::new(grid.layout()),
        exact,
        semi: None,
        front: None,
        jump: None,
        wake,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_beyond_the_edge_or_behind_the_tip() {
        let wake = Wake { angle: std::f64::consts::FRAC_PI_4, source: [0.0; 2], sigma: 0.1, touch: 1.0 };
        assert!((wake.beyond([1.0, -3.0]) - 2f64.sqrt()).abs() < 1e-12);
        assert!((wake.beyond([-3.0, 0.0]) - 3.0).abs() < 1e-12);
        assert!(wake.beyond([1.0, 0.5]) < 0.0);
    }
}
