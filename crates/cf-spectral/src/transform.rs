//! The transform along one axis that belongs to its two ends: coefficients of the modes of −∇²_h ([`AxisModes`]).
//!
//! | ends | modes | there | back |
//! |---|---|---|---|
//! | closed, closed | cos πm(i+½)/n | DCT-II | DCT-III |
//! | valued, valued | sin π(m+1)(i+½)/n | DST-II | DST-III |
//! | closed, valued | cos π(m+½)(i+½)/n | DCT-IV | DCT-IV |
//! | valued, closed | sin π(m+½)(i+½)/n | DST-IV | DST-IV |
//! | periodic | cos 2πmi/n + sin 2πmi/n | Hartley, by an FFT | the same |

use std::f64::consts::PI;
use std::sync::Arc;

use cf_diffusion::exact::{AxisModes, Walls};
use rayon::prelude::*;
use rustdct::rustfft::num_complex::Complex;
use rustdct::rustfft::{Fft, FftPlanner};
use rustdct::{DctPlanner, TransformType2And3, TransformType4};

/// One axis: its transform and the eigenvalue of every mode.
pub(crate) struct AxisTransform {
    kind: Kind,
    cells: usize,
    eigenvalues: Vec<f64>,
}

enum Kind {
    Hartley(Arc<dyn Fft<f64>>),
    Cosine(Arc<dyn TransformType2And3<f64>>),
    Sine(Arc<dyn TransformType2And3<f64>>),
    CosineMixed(Arc<dyn TransformType4<f64>>),
    SineMixed(Arc<dyn TransformType4<f64>>),
}

/// From cells to modes, or back.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Direction {
    There,
    Back,
}

/// Whose eigenvalues the modes get; on both, the vectors are the same at the centres of cells.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Of {
    /// −∇²_h between neighbours.
    Cells,
    /// −∇² of the continuous waves.
    Waves,
}

impl AxisTransform {
    /// `None` for an axis that has no modes (no or too many cells).
    pub fn new(walls: Walls, cells: usize, h: f64, of: Of) -> Option<Self> {
        let modes = AxisModes::new(walls, cells, h)?;
        let eigenvalue = |m: usize| match of {
            Of::Cells => modes.eigenvalue(m),
            Of::Waves => (PI * half_waves(walls, cells, m) / (cells as f64 * h)).powi(2),
        };
        let mut planner = DctPlanner::new();
        let kind = match walls {
            Walls::Periodic => Kind::Hartley(FftPlanner::new().plan_fft_forward(cells)),
            Walls::Closed => Kind::Cosine(planner.plan_dct2(cells)),
            Walls::Valued => Kind::Sine(planner.plan_dst2(cells)),
            Walls::ClosedValued => Kind::CosineMixed(planner.plan_dct4(cells)),
            Walls::ValuedClosed => Kind::SineMixed(planner.plan_dst4(cells)),
        };
        Some(Self { kind, cells, eigenvalues: (0..cells).map(eigenvalue).collect() })
    }

    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Λ of every mode \[1/m²\].
    pub fn eigenvalues(&self) -> &[f64] {
        &self.eigenvalues
    }

    /// What `There` and `Back` multiply by together.
    fn gain(&self) -> f64 {
        let n = self.cells as f64;
        if matches!(self.kind, Kind::Hartley(_)) { n } else { 0.5 * n }
    }

    /// Transforms every row of `cells` numbers.
    pub fn rows(&self, direction: Direction, data: &mut [f64]) {
        let scale = if direction == Direction::There { 1.0 / self.gain() } else { 1.0 };
        let scratch = match &self.kind {
            Kind::Hartley(fft) => fft.get_inplace_scratch_len(),
            Kind::Cosine(t) | Kind::Sine(t) => t.get_scratch_len(),
            Kind::CosineMixed(t) | Kind::SineMixed(t) => t.get_scratch_len(),
        };
        let work = || match self.kind {
            Kind::Hartley(_) => (vec![], vec![Complex::default(); self.cells + scratch]),
            _ => (vec![0.0; scratch], vec![]),
        };
        data.par_chunks_mut(self.cells).with_min_len(16).for_each_init(work, |(real, complex), row| {
            match (&self.kind, direction) {
                (Kind::Hartley(fft), _) => hartley(fft.as_ref(), row, complex),
                (Kind::Cosine(t), Direction::There) => t.process_dct2_with_scratch(row, real),
                (Kind::Cosine(t), Direction::Back) => t.process_dct3_with_scratch(row, real),
                (Kind::Sine(t), Direction::There) => t.process_dst2_with_scratch(row, real),
                (Kind::Sine(t), Direction::Back) => t.process_dst3_with_scratch(row, real),
                (Kind::CosineMixed(t), _) => t.process_dct4_with_scratch(row, real),
                (Kind::SineMixed(t), _) => t.process_dst4_with_scratch(row, real),
            }
            row.iter_mut().for_each(|x| *x *= scale);
        });
    }
}

/// Half waves of mode m along an axis, the shortest that the cells show.
fn half_waves(walls: Walls, cells: usize, m: usize) -> f64 {
    match walls {
        Walls::Periodic => 2.0 * m.min(cells - m) as f64,
        Walls::Closed => m as f64,
        Walls::Valued => m as f64 + 1.0,
        Walls::ClosedValued | Walls::ValuedClosed => m as f64 + 0.5,
    }
}

/// Σ_i f_i (cos 2πmi/n + sin 2πmi/n), real part minus imaginary part of the Fourier transform.
fn hartley(fft: &dyn Fft<f64>, row: &mut [f64], work: &mut [Complex<f64>]) {
    let (line, scratch) = work.split_at_mut(row.len());
    line.iter_mut().zip(row.iter()).for_each(|(z, &x)| *z = Complex::new(x, 0.0));
    fft.process_with_scratch(line, scratch);
    row.iter_mut().zip(line.iter()).for_each(|(x, z)| *x = z.re - z.im);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_mode_becomes_one_coefficient_and_comes_back() {
        for walls in [Walls::Periodic, Walls::Closed, Walls::Valued, Walls::ClosedValued, Walls::ValuedClosed] {
            for n in [1, 2, 3, 7, 16, 33, 64] {
                let axis = AxisTransform::new(walls, n, 0.3, Of::Cells).unwrap();
                let modes = AxisModes::new(walls, n, 0.3).unwrap();
                for m in 0..n {
                    let f: Vec<f64> = (0..n).map(|i| modes.vector(m, i)).collect();
                    let mut g = f.clone();
                    axis.rows(Direction::There, &mut g);
                    let largest = g.iter().fold(0.0f64, |a, b| a.max(b.abs()));
                    for (l, x) in g.iter().enumerate() {
                        assert!((l == m) == (x.abs() == largest), "{walls:?} {n} {m}: {g:?}");
                        assert!(l == m || x.abs() < 1e-14, "{walls:?} {n} {m}: {g:?}");
                    }
                    axis.rows(Direction::Back, &mut g);
                    assert!(f.iter().zip(&g).all(|(a, b)| (a - b).abs() < 1e-14), "{walls:?} {n} {m}: {f:?} {g:?}");
                }
            }
        }
    }
}
