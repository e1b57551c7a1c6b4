//! Iteration counts of the multigrid solves over kappa and sizes.

use cf_grid::{Axis, Layout, Mask, Sides};
use cf_linear::{Helmholtz, Options, Plan, Solver, Stop};

use super::random::Random;
use super::{Measured, Row, Table};

/// PCG iterations to a residual of 1e-6 of a random right-hand side, and the levels used.
pub(super) fn count<const D: usize>(
    cells: [usize; D],
    kappa: f64,
    walls: Sides<f64, D>,
    mask: Option<&Mask<D>>,
    seed: u64,
) -> Measured {
    let layout = Layout::new(cells)?;
    let mut operator = Helmholtz::new(&layout, 1.0, kappa, walls);
    if let Some(mask) = mask {
        operator = operator.with_mask(mask);
    }
    let mut solver = Solver::<f64, D>::new(&operator, Options { plan: Some(Plan::Multigrid), ..Options::default() })?;
    let (mut b, mut x, mut random) = (vec![0.0; layout.slots()], vec![0.0; layout.slots()], Random(seed));
    layout.each_cell(layout.cells_region(), |at| {
        if mask.is_none_or(|m| m.fluid()[at.slot()]) {
            b[at.slot()] = random.between(-1.0, 1.0);
        }
    });
    Ok(solver.solve(&b, &mut x, Stop::Relative(1e-6))?.iterations as f64)
}

/// Counts to 1e-6: at most 8 on sizes that halve evenly, 10 on others.
pub fn iterations() -> Table {
    let mut rows = Vec::new();
    for kappa in [0.3, 10.0, 1e3, 1e6, 1e12, 1e300] {
        let walls =
            [("closed", Axis::Walls([0.0; 2])), ("periodic", Axis::Periodic), ("value", Axis::Walls([2.0 * kappa; 2]))];
        for (name, axis) in walls {
            for cells in [[64, 64], [128, 32], [97, 61]] {
                let most = if cells[0] % 2 == 0 { 8.0 } else { 10.0 };
                let text = format!("{}x{} {name} kappa={kappa:.0e}", cells[0], cells[1]);
                rows.push(Row::at_most("iterations", text, most, count(cells, kappa, Sides([axis; 2]), None, 7)));
            }
            for cells in [[32, 32, 32], [33, 21, 17]] {
                let most = if cells[0] % 2 == 0 { 8.0 } else { 10.0 };
                let text = format!("{}x{}x{} {name} kappa={kappa:.0e}", cells[0], cells[1], cells[2]);
                rows.push(Row::at_most("iterations", text, most, count(cells, kappa, Sides([axis; 3]), None, 7)));
            }
        }
    }
    Table { title: "Multigrid iterations to a residual of 1e-6", rows }
}
