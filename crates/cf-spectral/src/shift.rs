//! Uniform motion along a periodic axis: the field moves by any distance without change of shape.

use std::f64::consts::PI;
use std::sync::Arc;

use cf_grid::{Layout, Real, Region};
use rayon::prelude::*;
use rustdct::rustfft::num_complex::Complex;
use rustdct::rustfft::{Fft, FftPlanner};

/// Moves lines of one periodic axis by trigonometric interpolation.
pub(crate) struct Shift {
    axis: usize,
    there: Arc<dyn Fft<f64>>,
    back: Arc<dyn Fft<f64>>,
}

impl Shift {
    pub fn new(axis: usize, cells: usize) -> Self {
        let mut planner = FftPlanner::new();
        Self { axis, there: planner.plan_fft_forward(cells), back: planner.plan_fft_inverse(cells) }
    }

    /// `field(x)` becomes `field(x − distance)`, the distance in cells, on the cells or faces of `region`.
    pub fn apply<T: Real, const D: usize>(
        &self,
        layout: &Layout<D>,
        region: Region<D>,
        distance: f64,
        field: &mut [T],
    ) {
        let (n, axis) = (layout.cells()[self.axis], self.axis);
        // The whole turns are taken out, so that a long way costs no digits beyond those of the distance.
        let distance = distance % n as f64;
        let turns: Vec<Complex<f64>> = (0..n).map(|m| turn(m, n, distance) / n as f64).collect();
        let others = region.high.iter().enumerate().filter(|&(a, _)| a != axis).map(|(_, n)| n).product::<usize>();
        let mut lines = vec![Complex::default(); others * n];
        let spots = |row: usize| {
            let mut rest = row;
            std::array::from_fn(|a| {
                let i = if a == axis { 0 } else { rest % region.high[a] };
                rest /= if a == axis { 1 } else { region.high[a] };
                i
            })
        };
        let source = &*field;
        let scratch = self.there.get_inplace_scratch_len().max(self.back.get_inplace_scratch_len());
        let work = || vec![Complex::default(); scratch];
        lines.par_chunks_mut(n).enumerate().with_min_len(16).for_each_init(work, |work, (row, line)| {
            let slot = layout.slot(spots(row));
            let stride = layout.stride(axis);
            line.iter_mut().enumerate().for_each(|(i, z)| *z = Complex::new(source[slot + i * stride].f64(), 0.0));
            self.there.process_with_scratch(line, &mut work[..self.there.get_inplace_scratch_len()]);
            line.iter_mut().zip(&turns).for_each(|(z, t)| *z *= t);
            self.back.process_with_scratch(line, &mut work[..self.back.get_inplace_scratch_len()]);
        });
        layout.par_runs(region, field, |run, out: &mut [T]| {
            for (out, at) in out.iter_mut().zip(run.ats()) {
                let row = (0..D).rev().filter(|&a| a != axis).fold(0, |row, a| row * region.high[a] + at.cell[a]);
                *out = T::of(lines[row * n + at.cell[axis]].re);
            }
        });
    }
}

/// e^{−iKs} of mode m. The shortest wave of an even axis has no sine to turn into and takes the mean of both signs.
fn turn(m: usize, n: usize, distance: f64) -> Complex<f64> {
    let angle = 2.0 * PI * distance / n as f64;
    if 2 * m == n {
        return Complex::new((angle * m as f64).cos(), 0.0);
    }
    let signed = if 2 * m < n { m as f64 } else { m as f64 - n as f64 };
    Complex::cis(-angle * signed)
}
