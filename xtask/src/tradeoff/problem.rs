//! The canonical problems with their solutions (model/diffusion.md 7).

use crate::bench::numerical;
use crate::failure::Failure;
use cf_diffusion::exact::Telegraph;
use cf_diffusion::{Law, Medium, Source, State};
use cf_grid::{Axis, CellField, Grid, Sides, Wall};
use cf_spectral::{Spectral, smooth};

/// A problem on one grid, at rest and without slow flux at the start.
pub struct Problem<const D: usize> {
    /// Its name, without the grid.
    pub name: String,
    /// The grid.
    pub grid: Grid<D>,
    /// The walls.
    pub sides: Sides<Wall, D>,
    /// The law.
    pub law: Law,
    /// When it is judged \[s\].
    pub end: f64,
    /// phi at the start.
    pub start: CellField<f64>,
    /// phi at the end.
    pub exact: CellField<f64>,
    /// phi at the end of the equations that are discrete in space alone.
    pub semi: CellField<f64>,
    /// Height of the front, in one dimension.
    pub jump: Option<f64>,
}

/// What `error` is measured against, by problem.
pub const REFERENCES: [&str; 3] = [
    "P1: the continuous equations, by transforms with the eigenvalues K² (error: space and time).",
    "P2 line: the telegraph equation's closed form with Bessel functions, at the centres of cells.",
    "P2 disc: the continuous equations by transforms on a grid 8 times finer, averaged over blocks of cells.",
];

/// P1: φ₀ = e^{−(r/0.05)²} in a closed unit box, k = 0.04 m²/s, τ = 1 s, until 1 s.
pub fn gaussian<const D: usize>(n: usize, share: f64) -> Result<Problem<D>, Failure> {
    let grid = Grid::<D>::new([n; D], 1.0 / n as f64).map_err(numerical)?;
    let sides = Sides::all(Wall::CLOSED);
    let law = Law::new(0.04, 1.0, share).map_err(numerical)?;
    let mut start = CellField::new(grid.layout());
    grid.layout().par_cells(&mut start, |at| {
        let x = grid.centre(at.cell);
        (-(0..D).map(|a| (x[a] - 0.5).powi(2)).sum::<f64>() / 0.0025).exp()
    });
    let mut exact = start.clone();
    smooth(&grid, &sides, &law, &mut exact, 1.0).map_err(numerical)?;
    let semi = in_time(&grid, &sides, law, &start, 1.0)?;
    let name = format!("P1 {D}D, F_T = {share}");
    Ok(Problem { name, grid, sides, law, end: 1.0, start, exact, semi, jump: None })
}

/// P2 in one dimension: 1 on the left half of 3 cτ, 0 on the right, c = τ = 1, until 0.8 τ.
pub fn line(n: usize) -> Result<Problem<2>, Failure> {
    let grid = Grid::<2>::new([n, 1], 3.0 / n as f64).map_err(numerical)?;
    let sides = Sides([Axis::Walls([Wall::CLOSED; 2]), Axis::Periodic]);
    let law = Law::cattaneo(1.0, 1.0).map_err(numerical)?;
    let telegraph = Telegraph::new(&law).ok_or_else(|| numerical("a law of waves has no telegraph equation"))?;
    let (mut start, mut exact) = (CellField::new(grid.layout()), CellField::new(grid.layout()));
    let x = |cell: [usize; 2]| grid.centre(cell)[0] - 1.5;
    grid.layout().par_cells(&mut start, |at| telegraph.riemann_phi(x(at.cell), 0.0));
    grid.layout().par_cells(&mut exact, |at| telegraph.riemann_phi(x(at.cell), 0.8));
    let semi = in_time(&grid, &sides, law, &start, 0.8)?;
    let jump = Some(telegraph.front(0.8));
    Ok(Problem { name: "P2 line".into(), grid, sides, law, end: 0.8, start, exact, semi, jump })
}

/// How much finer the grid is that the disc's solution comes from.
const FINER: usize = 8;

/// P2 in two: 1 in a disc of radius 0.4 cτ amid a box of 2.4 cτ, c = τ = 1, until 0.6 τ.
pub fn disc(n: usize) -> Result<Problem<2>, Failure> {
    let sides = Sides::all(Wall::CLOSED);
    let law = Law::cattaneo(1.0, 1.0).map_err(numerical)?;
    let grid = Grid::<2>::new([n; 2], 2.4 / n as f64).map_err(numerical)?;
    let fine = Grid::<2>::new([FINER * n; 2], grid.h() / FINER as f64).map_err(numerical)?;
    let mut sharp = CellField::new(fine.layout());
    fine.layout().par_cells(&mut sharp, |at| {
        let x = fine.centre(at.cell);
        f64::from((x[0] - 1.2).hypot(x[1] - 1.2) < 0.4)
    });
    let start = averaged(&grid, &fine, &sharp);
    // Differences would ring at the jump on any grid; waves at their true speed ring only where the average removes it.
    let mut after = sharp;
    smooth(&fine, &sides, &law, &mut after, 0.6).map_err(numerical)?;
    let exact = averaged(&grid, &fine, &after);
    let semi = in_time(&grid, &sides, law, &start, 0.6)?;
    Ok(Problem { name: "P2 disc".into(), grid, sides, law, end: 0.6, start, exact, semi, jump: None })
}

/// phi after `end`, exact in time.
pub fn in_time<const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    law: Law,
    start: &[f64],
    end: f64,
) -> Result<CellField<f64>, Failure> {
    let mut state = State::<f64, D>::new(grid, &law);
    state.phi.copy_from_slice(start);
    let mut spectral = Spectral::new(grid, sides, law).map_err(numerical)?;
    spectral.step(&mut state, &Medium::Still, Source::NONE, end).map_err(numerical)?;
    Ok(state.phi)
}

fn averaged(grid: &Grid<2>, fine: &Grid<2>, phi: &[f64]) -> CellField<f64> {
    let mut mean = CellField::new(grid.layout());
    grid.layout().par_cells(&mut mean, |at| {
        let [x, y] = at.cell.map(|i| FINER * i);
        let block = (0..FINER * FINER).map(|i| phi[fine.layout().slot([x + i % FINER, y + i / FINER])]);
        block.sum::<f64>() / (FINER * FINER) as f64
    });
    mean
}
