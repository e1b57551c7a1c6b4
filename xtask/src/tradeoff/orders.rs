//! The table of model/diffusion.md 6.1, measured: error in time of a Gaussian on a line of 256 cells.

use super::problem::{Problem, in_time};
use super::setting::{Scheme, Setting};
use crate::bench::numerical;
use crate::failure::Failure;
use cf_diffusion::exact::{AxisModes, Walls, amplification, modes};
use cf_diffusion::{Law, kdk_limit};
use cf_grid::{Axis, CellField, Grid, Sides};

const CELLS: usize = 256;
const STEPS: [usize; 4] = [10, 40, 160, 640];
/// Relative difference from the model's number at which a row fails.
pub const WITHIN: f64 = 0.2;

/// One number of the table.
pub struct Row {
    /// tau \[s\] and F_T.
    pub law: String,
    /// The scheme.
    pub scheme: &'static str,
    /// Steps until 1 s.
    pub steps: usize,
    /// The model's number.
    pub expected: f64,
    /// Ours.
    pub measured: f64,
}

impl Row {
    /// Whether both agree within [`WITHIN`].
    pub fn pass(&self) -> bool {
        (self.measured / self.expected - 1.0).abs() <= WITHIN
    }
}

/// (tau, F_T, rows of (scheme, errors)) as the model has them; NaN where unstable.
type Case = (f64, f64, &'static [(&'static str, [f64; 4])]);

const N: f64 = f64::NAN;
const CASES: [Case; 4] = [
    (
        1.0,
        0.0,
        &[
            ("PaperBe", [4.0e-1, 1.8e-1, 6.0e-2, 1.6e-2]),
            ("CN", [1.4e-1, 1.0e-2, 6.3e-4, 3.9e-5]),
            ("Sdirk2", [7.2e-2, 4.9e-3, 3.0e-4, 1.9e-5]),
            ("Kdk", [N, N, 3.2e-4, 2.0e-5]),
        ],
    ),
    (1.0, 0.05, &[("PaperBe", [2.3e-1, 8.0e-2, 2.3e-2, 5.9e-3]), ("Sdirk2", [1.7e-2, 1.1e-3, 6.7e-5, 4.2e-6])]),
    (
        0.05,
        0.0,
        &[
            ("PaperBe", [3.7e-2, 9.7e-3, 2.4e-3, 6.1e-4]),
            ("CN", [8.0e-2, 2.4e-4, 8.4e-6, 5.0e-7]),
            ("Sdirk2", [2.2e-3, 7.5e-5, 4.0e-6, 2.4e-7]),
        ],
    ),
    (
        1.0,
        1.0,
        &[
            ("PaperBe", [3.3e-2, 8.5e-3, 2.1e-3, 5.4e-4]),
            ("CN", [1.8e-2, 6.3e-5, 4.0e-6, 2.5e-7]),
            ("Sdirk2", [5.0e-4, 3.1e-5, 1.9e-6, 1.2e-7]),
        ],
    ),
];

/// All rows, measured with the steppers; Crank-Nicolson, which no stepper offers, by its modes.
pub fn orders(threads: usize) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for (tau, share, schemes) in CASES {
        let problem = problem(Law::new(0.04, tau, share).map_err(numerical)?)?;
        for &(scheme, errors) in schemes {
            for (steps, expected) in STEPS.into_iter().zip(errors) {
                if expected.is_nan() {
                    continue;
                }
                let measured = match scheme {
                    "PaperBe" => stepped(&problem, Scheme::PaperBe, steps, threads)?,
                    "Sdirk2" => stepped(&problem, Scheme::Sdirk2, steps, threads)?,
                    "Kdk" if 1.0 / steps as f64 <= kdk_limit(&problem.law, 4.0 * (CELLS * CELLS) as f64 * 2.0) => {
                        stepped(&problem, Scheme::Kdk, steps, threads)?
                    }
                    "Kdk" => continue,
                    _ => crank_nicolson(&problem, steps),
                };
                rows.push(Row { law: format!("F_T = {share}, tau = {tau} s"), scheme, steps, expected, measured });
            }
        }
    }
    Ok(rows)
}

fn problem(law: Law) -> Result<Problem<2>, Failure> {
    let grid = Grid::<2>::new([CELLS, 1], 1.0 / CELLS as f64).map_err(numerical)?;
    let sides = Sides([Axis::Periodic; 2]);
    let mut start = CellField::new(grid.layout());
    grid.layout().par_cells(&mut start, |at| (-((grid.centre(at.cell)[0] - 0.5) / 0.05).powi(2)).exp());
    let semi = in_time(&grid, &sides, law, &start, 1.0)?;
    Ok(Problem { name: "6.1".into(), grid, sides, law, end: 1.0, start, exact: semi.clone(), semi, jump: None })
}

/// Error in time of a stepper, solved far below it.
fn stepped(problem: &Problem<2>, scheme: Scheme, steps: usize, threads: usize) -> Result<f64, Failure> {
    let setting = Setting { tolerance: 1e-11, ..Setting::new(scheme, steps, threads) };
    super::measure::error_in_time(problem, &setting)
}

/// The same of A = 2 (I − dt/2 M)⁻¹ − I, mode by mode.
fn crank_nicolson(problem: &Problem<2>, steps: usize) -> f64 {
    let Some(axis) = AxisModes::new(Walls::Periodic, CELLS, problem.grid.h()) else { return f64::NAN };
    let layout = problem.grid.layout();
    let (mut off, mut whole) = (0.0, 0.0);
    for m in 0..CELLS {
        let lambda = axis.eigenvalue(m);
        let part: f64 = (0..CELLS).map(|i| problem.start[layout.slot([i, 0])] * axis.vector(m, i)).sum();
        let half = amplification::paper_be(&problem.law, 0.5 / steps as f64, lambda);
        let mut state = [1.0, 0.0];
        for _ in 0..steps {
            let next = modes::apply(&half, state);
            state = [2.0 * next[0] - state[0], 2.0 * next[1] - state[1]];
        }
        let exact = modes::response(&problem.law, lambda, 1.0);
        off += (part * (state[0] - exact)).powi(2);
        whole += (part * exact).powi(2);
    }
    (off / whole).sqrt()
}
