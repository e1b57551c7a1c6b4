//! One level of the hierarchy: an operator on its layout, and whole-field sweeps of its row kernels.

use cf_grid::{At, Layout, Real, Reduce, Region, row_dot};

use crate::axis::AxisTable;
use crate::stencil::{BoxStencil, Rows, Stencil, StoredStencil};

/// Which coefficients a level has.
#[derive(Debug, Clone)]
pub(crate) enum Coefficients<T, const D: usize> {
    Uniform(BoxStencil<D>),
    Stored(StoredStencil<T, D>),
}

/// Operator, layout and colour order of one level.
#[derive(Debug, Clone)]
pub(crate) struct LevelOperator<T, const D: usize> {
    pub layout: Layout<D>,
    pub axes: [AxisTable; D],
    pub coefficients: Coefficients<T, D>,
    /// Boxes relaxed in turn, each in two colours: the bulk, then the seam planes of odd periodic axes, where two cells
    /// of one bulk colour would meet.
    parts: Vec<Region<D>>,
}

impl<T: Real, const D: usize> LevelOperator<T, D> {
    pub fn new(layout: Layout<D>, axes: [AxisTable; D], coefficients: Coefficients<T, D>) -> Self {
        let mut parts = vec![layout.cells_region()];
        for a in 0..D {
            let n = layout.cells()[a];
            if axes[a].periodic && n % 2 == 1 && n > 1 {
                let seams: Vec<_> = parts
                    .iter_mut()
                    .map(|bulk| {
                        let mut seam = *bulk;
                        seam.low[a] = n - 1;
                        bulk.high[a] = n - 1;
                        seam
                    })
                    .collect();
                parts.extend(seams);
            }
        }
        Self { layout, axes, coefficients, parts }
    }

    /// Fills the rim along periodic axes.
    pub fn wrap(&self, x: &mut [T]) {
        for a in 0..D {
            if self.axes[a].periodic {
                self.layout.wrap_rim(a, x);
            }
        }
    }

    /// y = A x; returns x·y. The rim of `x` is overwritten along periodic axes.
    pub fn apply(&self, x: &mut [T], y: &mut [T]) -> f64 {
        self.wrap(x);
        let x = &*x;
        match &self.coefficients {
            Coefficients::Uniform(s) => self.sweep(s, x, y, |c, y| row_dot(&c[1..], y)),
            Coefficients::Stored(s) => self.sweep(s, x, y, |c, y| row_dot(&c[1..], y)),
        }
    }

    fn sweep<S: Reduce>(
        &self,
        stencil: &impl Stencil<T, D>,
        x: &[T],
        y: &mut [T],
        finish: impl Fn(&[T], &mut [T]) -> S + Sync,
    ) -> S {
        self.layout.par_runs(self.layout.cells_region(), y, |run, out: &mut [T]| {
            let c = run.wide(x);
            stencil.apply(&run, c, Rows::of(&run, x), out);
            finish(c, out)
        })
    }

    /// r = b - A x.
    pub fn residual(&self, b: &[T], x: &mut [T], r: &mut [T]) {
        self.wrap(x);
        let x = &*x;
        match &self.coefficients {
            Coefficients::Uniform(s) => self.residual_rows(s, b, x, r),
            Coefficients::Stored(s) => self.residual_rows(s, b, x, r),
        }
    }

    fn residual_rows(&self, stencil: &impl Stencil<T, D>, b: &[T], x: &[T], r: &mut [T]) {
        self.layout.par_runs(self.layout.cells_region(), r, |run, out: &mut [T]| {
            stencil.apply(&run, run.wide(x), Rows::of(&run, x), out);
            for (r, &b) in out.iter_mut().zip(run.row(b)) {
                *r = b - *r;
            }
        });
    }

    /// out = f(J x, out) with the Jacobi solution J of every cell. The rim of `x` is overwritten along periodic axes.
    pub fn jacobi(&self, b: &[T], x: &mut [T], out: &mut [T], f: impl Fn(T, T) -> T + Sync) {
        self.wrap(x);
        let x = &*x;
        match &self.coefficients {
            Coefficients::Uniform(s) => self.jacobi_rows(s, b, x, out, f),
            Coefficients::Stored(s) => self.jacobi_rows(s, b, x, out, f),
        }
    }

    fn jacobi_rows(&self, stencil: &impl Stencil<T, D>, b: &[T], x: &[T], out: &mut [T], f: impl Fn(T, T) -> T + Sync) {
        self.layout.par_runs(self.layout.cells_region(), out, |run, out: &mut [T]| {
            stencil.jacobi(&run, run.wide(x), Rows::of(&run, x), run.row(b), out, &f);
        });
    }

    /// One red-black sweep; `backward` reverses the order of colours and parts, so that a forward and a backward sweep
    /// make a symmetric pair.
    pub fn smooth(&self, b: &[T], x: &mut [T], backward: bool) {
        let steps = self.parts.len() * 2;
        for step in 0..steps {
            let step = if backward { steps - 1 - step } else { step };
            self.relax(self.parts[step / 2], b, x, step % 2);
        }
    }

    fn relax(&self, part: Region<D>, b: &[T], x: &mut [T], colour: usize) {
        self.wrap(x);
        match &self.coefficients {
            Coefficients::Uniform(s) => self.relax_rows(s, part, b, x, colour),
            Coefficients::Stored(s) => self.relax_rows(s, part, b, x, colour),
        }
    }

    fn relax_rows(&self, stencil: &impl Stencil<T, D>, part: Region<D>, b: &[T], x: &mut [T], colour: usize) {
        self.layout.par_rows_in_place(part, x, |run, row, near| {
            let (first, n) = (run.cell[0] + 1, run.len());
            let cells = first..first + n;
            let rows = Rows { low: near.low.map(|r| &r[cells.clone()]), high: near.high.map(|r| &r[cells.clone()]) };
            stencil.relax(&run, row, rows, run.row(b), colour);
        });
    }

    /// Whether a conducting wall touches a cell.
    pub fn touches_wall(&self, at: At<'_, D>) -> bool {
        (0..D).filter(|&a| !self.axes[a].periodic).any(|a| {
            let (i, n) = (at.cell[a], self.axes[a].len());
            let weight = |face: usize, slot: usize| match &self.coefficients {
                Coefficients::Uniform(_) => self.axes[a].face[face],
                Coefficients::Stored(s) => s.face[a][slot].f64(),
            };
            (i == 0 && weight(0, at.slot()) > 0.0) || (i + 1 == n && weight(n, at.high(a)) > 0.0)
        })
    }

    /// Bytes of stored coefficients.
    pub fn bytes(&self) -> usize {
        match &self.coefficients {
            Coefficients::Uniform(_) => 0,
            Coefficients::Stored(s) => (s.mass.len() * (D + 2)) * size_of::<T>(),
        }
    }
}
