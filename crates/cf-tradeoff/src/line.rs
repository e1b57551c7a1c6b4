//! A Gaussian on a periodic line: for errors in time alone.

use crate::error::TradeoffError;
use crate::problem::{On, field};
use cf_diffusion::Law;
use cf_grid::{Grid, Sides};

/// e^{−((x − ½)/0.05)²} on a periodic line of 1 m, until 1 s; exact in time and discrete in space, twice.
pub(crate) fn gaussian(n: usize, law: Law) -> Result<On<2>, TradeoffError> {
    let grid = Grid::<2>::new([n, 1], 1.0 / n as f64)?;
    let start = field(&grid, |cell| (-((grid.centre(cell)[0] - 0.5) / 0.05).powi(2)).exp());
    let mut on = On::still(grid, Sides::periodic(), law, 1.0, start.clone(), start)?;
    if let Some(semi) = &on.semi {
        on.exact.clone_from(semi);
    }
    Ok(on)
}
