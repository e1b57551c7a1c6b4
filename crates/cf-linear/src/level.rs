//! One level of the hierarchy: an operator on its layout, and whole-field sweeps of its row kernels.
//!
//! Passes of a sweep: 2 for y = A x or norms of b - A x, 3 for r -= a A x, half of that for one colour's smoothing; up to D + 2 more
//! where coefficients are stored.

use cf_grid::{At, Layout, Near, Real, Reduce, Region, Run, array, row_dot};

use crate::axis::AxisTable;
use crate::band::Band;
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
    /// Cells near obstacles.
    band: Option<Band>,
}

/// Sweeps over the band before and after each smoother.
const BAND_SWEEPS: usize = 2;

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
        Self { layout, axes, coefficients, parts, band: None }
    }

    /// With extra sweeps near obstacles; `open` is the open volume of each cell.
    pub fn with_band(mut self, open: &[f64]) -> Self {
        if let Coefficients::Stored(s) = &self.coefficients {
            self.band = Band::new(&self.layout, &self.axes, s, open);
        }
        self
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
        self.sweep(
            x,
            y,
            #[inline(always)]
            |ax, _| ax,
            #[inline(always)]
            |c, y| row_dot(&c[1..], y),
        )
    }

    /// y = f(A x, y), with `finish` of each row of x (one more value at either end) and y. The rim of `x` is overwritten
    /// along periodic axes.
    pub fn sweep<S: Reduce>(
        &self,
        x: &mut [T],
        y: &mut [T],
        f: impl Fn(T, T) -> T + Copy + Sync,
        finish: impl Fn(&[T], &[T]) -> S + Sync,
    ) -> S {
        self.wrap(x);
        let x = &*x;
        match &self.coefficients {
            Coefficients::Uniform(s) => self.sweep_rows(s, x, y, f, finish),
            Coefficients::Stored(s) => self.sweep_rows(s, x, y, f, finish),
        }
    }

    fn sweep_rows<S: Reduce>(
        &self,
        stencil: &impl Stencil<T, D>,
        x: &[T],
        y: &mut [T],
        f: impl Fn(T, T) -> T + Copy + Sync,
        finish: impl Fn(&[T], &[T]) -> S + Sync,
    ) -> S {
        self.layout.par_runs(
            self.layout.cells_region(),
            y,
            #[inline(always)]
            |run, y: &mut [T]| {
                let c = run.wide(x);
                stencil.apply(&run, c, Rows::of(&run, x), y, f);
                finish(c, y)
            },
        )
    }

    /// x·A x. The rim of `x` is overwritten along periodic axes.
    pub fn energy(&self, x: &mut [T]) -> f64 {
        let negative: f64 = self.deficit(
            x,
            #[inline(always)]
            |_, b| b.fill(T::ZERO),
            #[inline(always)]
            |[x, _, r]: [&[T]; 3]| row_dot(x, r),
        );
        -negative
    }

    /// What `finish` makes of x, diagonal · x and b - A x, chunk by chunk, without storing them: `fill` writes b. The rim
    /// of `x` is overwritten along periodic axes.
    pub fn deficit<S: Reduce>(
        &self,
        x: &mut [T],
        fill: impl Fn(&Run<'_, D>, &mut [T]) + Sync,
        finish: impl Fn([&[T]; 3]) -> S + Sync,
    ) -> S {
        self.wrap(x);
        let x = &*x;
        match &self.coefficients {
            Coefficients::Uniform(s) => self.deficit_rows(s, x, fill, finish),
            Coefficients::Stored(s) => self.deficit_rows(s, x, fill, finish),
        }
    }

    fn deficit_rows<S: Reduce>(
        &self,
        stencil: &impl Stencil<T, D>,
        x: &[T],
        fill: impl Fn(&Run<'_, D>, &mut [T]) + Sync,
        finish: impl Fn([&[T]; 3]) -> S + Sync,
    ) -> S {
        const CHUNK: usize = 256;
        self.layout.par_runs(
            self.layout.cells_region(),
            (),
            #[inline(always)]
            |run, ()| {
                let (mut chunk, mut weighted, mut total) = ([T::ZERO; CHUNK], [T::ZERO; CHUNK], S::default());
                for first in (0..run.len()).step_by(CHUNK) {
                    let part = run.part(first, CHUNK.min(run.len() - first));
                    let r = &mut chunk[..part.len()];
                    fill(&part, r);
                    stencil.apply(
                        &part,
                        part.wide(x),
                        Rows::of(&part, x),
                        r,
                        #[inline(always)]
                        |ax, b| b - ax,
                    );
                    let weighted = &mut weighted[..part.len()];
                    stencil.weigh(&part, part.row(x), weighted);
                    total = total.merge(finish([part.row(x), weighted, r]));
                }
                total
            },
        )
    }

    /// r = b - A x.
    pub fn residual(&self, b: &[T], x: &mut [T], r: &mut [T]) {
        self.layout.par_runs(
            self.layout.cells_region(),
            &mut *r,
            #[inline(always)]
            |run, r: &mut [T]| r.copy_from_slice(run.row(b)),
        );
        self.sweep(
            x,
            r,
            #[inline(always)]
            |ax, b| b - ax,
            |_, _| (),
        );
    }

    /// out = f(J x, out) with the Jacobi solution J of every cell. The rim of `x` is overwritten along periodic axes.
    pub fn jacobi(&self, b: &[T], x: &mut [T], out: &mut [T], f: impl Fn(T, T) -> T + Copy + Sync) {
        self.wrap(x);
        let x = &*x;
        match &self.coefficients {
            Coefficients::Uniform(s) => self.jacobi_rows(s, b, x, out, f),
            Coefficients::Stored(s) => self.jacobi_rows(s, b, x, out, f),
        }
    }

    fn jacobi_rows(
        &self,
        stencil: &impl Stencil<T, D>,
        b: &[T],
        x: &[T],
        out: &mut [T],
        f: impl Fn(T, T) -> T + Copy + Sync,
    ) {
        self.layout.par_runs(
            self.layout.cells_region(),
            out,
            #[inline(always)]
            |run, out: &mut [T]| {
                stencil.jacobi(&run, run.wide(x), Rows::of(&run, x), run.row(b), out, f);
            },
        );
    }

    /// One smoother: a red-black sweep, over obstacles with sweeps of the band before and after. `backward` reverses the
    /// order of colours and parts, so that a forward and a backward smoother make a symmetric pair.
    pub fn smooth(&self, b: &[T], x: &mut [T], backward: bool) {
        let band = |x: &mut [T]| {
            for _ in 0..BAND_SWEEPS {
                self.sweep_colours(backward, |part, colour| self.relax_band(part, b, x, colour));
            }
        };
        band(x);
        self.sweep_colours(backward, |part, colour| self.relax(part, b, x, colour));
        band(x);
    }

    fn sweep_colours(&self, backward: bool, mut relax: impl FnMut(Region<D>, usize)) {
        let steps = self.parts.len() * 2;
        for step in 0..steps {
            let step = if backward { steps - 1 - step } else { step };
            relax(self.parts[step / 2], step % 2);
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
        self.layout.par_rows_in_place(
            part,
            x,
            #[inline(always)]
            |run, row, near| {
                stencil.relax(&run, row, near_rows(&run, &near), run.row(b), colour);
            },
        );
    }

    fn relax_band(&self, part: Region<D>, b: &[T], x: &mut [T], colour: usize) {
        let (Coefficients::Stored(stencil), Some(band)) = (&self.coefficients, &self.band) else { return };
        self.wrap(x);
        self.layout.par_rows_in_place(
            part,
            x,
            #[inline(always)]
            |run, row, near| {
                for &[first, end] in band.row(&self.layout, run.cell) {
                    let (first, end) = ((first as usize).max(part.low[0]), (end as usize).min(part.high[0]));
                    if first < end {
                        let run = run.part(first - part.low[0], end - first);
                        stencil.relax(&run, row, near_rows(&run, &near), run.row(b), colour);
                    }
                }
            },
        );
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
        let stored = match &self.coefficients {
            Coefficients::Uniform(_) => 0,
            Coefficients::Stored(s) => (s.mass.len() * (D + 2)) * size_of::<T>(),
        };
        stored + self.band.as_ref().map_or(0, Band::bytes)
    }
}

/// Neighbour rows of a run.
#[inline(always)]
fn near_rows<'a, T, const D: usize>(run: &Run<'_, D>, near: &Near<'a, T, D>) -> Rows<'a, T, D> {
    let cells = run.cell[0] + 1..run.cell[0] + 1 + run.len();
    Rows {
        low: array(
            #[inline(always)]
            |a| &near.low[a][cells.clone()],
        ),
        high: array(
            #[inline(always)]
            |a| &near.high[a][cells.clone()],
        ),
    }
}
