//! One sweep along one axis: fields to waves, waves moved, fields updated, row by row.
//!
//! Rows are taken in chunks whose waves live on the stack. Along x a chunk is a window that slides over the row, so the
//! sweep works in place; along y and z five rows are read and one is written elsewhere.

use std::ops::Range;

use cf_grid::{End, Layout, Real, Run, row_sum};

use super::content::Content;
use super::kernel::{losses, rise};
use super::wave::Wave;

/// Longest chunk.
const CHUNK: usize = 64;

/// A sweep along `axis`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sweep<'s, T, C, const D: usize, const K: usize> {
    pub layout: &'s Layout<D>,
    pub axis: usize,
    pub periodic: bool,
    pub waves: [Wave<T>; K],
    pub content: C,
}

/// The waves of five rows around a chunk.
type Rows<'w, T, const K: usize> = [[&'w [T]; 5]; K];

impl<T: Real, C: Content<T, K>, const D: usize, const K: usize> Sweep<'_, T, C, D, K> {
    /// Sweeps `fields` in place; for `axis` = 0. Returns what left through the walls, outward positive, in units of a
    /// cell's phi; not finite where a field is not.
    pub fn in_place(&self, fields: [&mut [T]; K]) -> f64 {
        self.layout.par_runs(
            self.layout.cells_region(),
            fields,
            #[inline(always)]
            |run, mut rows: [&mut [T]; K]| {
                let outflow = self.along(run, &mut rows);
                outflow + 0.0 * row_sum(rows[0])
            },
        )
    }

    /// The same from one set of fields to another; for `axis` > 0.
    pub fn across(&self, from: [&[T]; K], to: [&mut [T]; K]) -> f64 {
        self.layout.par_runs(
            self.layout.cells_region(),
            to,
            #[inline(always)]
            |run, mut rows: [&mut [T]; K]| {
                let outflow = self.between(run, from, &mut rows);
                outflow + 0.0 * row_sum(rows[0])
            },
        )
    }

    #[inline(always)]
    fn along(&self, run: Run<'_, D>, rows: &mut [&mut [T]; K]) -> f64 {
        let n = run.len();
        let mut window = [[T::ZERO; CHUNK + 4]; K];
        let mut loss = [[T::ZERO; CHUNK]; K];
        let (mut before, mut behind) = ([[T::ZERO; 2]; K], [[T::ZERO; 2]; K]);
        for place in 0..2 {
            let low = self.outside(rows, n, place as isize - 2);
            let high = self.outside(rows, n, (n + place) as isize);
            for k in 0..K {
                (before[k][place], behind[k][place]) = (low[k], high[k]);
            }
        }
        for k in 0..K {
            window[k][..2].copy_from_slice(&before[k]);
        }
        let mut outflow = 0.0;
        for start in (0..n).step_by(CHUNK) {
            let m = CHUNK.min(n - start);
            let ahead = start..(start + m + 2).min(n);
            let inside = ahead.len();
            let values = rows.each_ref().map(|row| &row[ahead.clone()]);
            self.content.waves(values, window.each_mut().map(|w| &mut w[2..2 + inside]));
            for k in 0..K {
                for i in inside..m + 2 {
                    window[k][2 + i] = behind[k][start + i - n];
                }
            }
            let around: Rows<'_, T, K> =
                std::array::from_fn(|k| std::array::from_fn(|shift| &window[k][shift..shift + m]));
            let walls = [(start == 0).then_some(0..1), (start + m == n).then_some(m - 1..m)];
            outflow += self.lose(around, walls, m, &mut loss);
            let chunk = rows.each_mut().map(|row| &mut row[start..start + m]);
            self.content.update(loss.each_ref().map(|l| &l[..m]), chunk);
            for w in &mut window {
                w.copy_within(m..m + 2, 0);
            }
        }
        outflow
    }

    /// The waves at a place outside a row along x.
    fn outside(&self, rows: &[&mut [T]; K], n: usize, index: isize) -> [T; K] {
        let at = |i: usize| {
            let mut waves = [[T::ZERO]; K];
            self.content.waves(rows.each_ref().map(|row| &row[i..i + 1]), waves.each_mut().map(|w| &mut w[..]));
            waves.map(|[w]| w)
        };
        if self.periodic {
            return at(index.rem_euclid(n as isize) as usize);
        }
        let (end, mirror, wall) = image(index, n);
        let (mirror, wall) = (at(mirror), at(wall));
        std::array::from_fn(|k| self.beyond(end, k, mirror[K - 1 - k], wall[k]))
    }

    #[inline(always)]
    fn between(&self, run: Run<'_, D>, from: [&[T]; K], to: &mut [&mut [T]; K]) -> f64 {
        let (n, index) = (self.layout.cells()[self.axis], run.cell[self.axis]);
        let mut waves = [[[T::ZERO; CHUNK]; 5]; K];
        let mut loss = [[T::ZERO; CHUNK]; K];
        let mut outflow = 0.0;
        for start in (0..run.len()).step_by(CHUNK) {
            let m = CHUNK.min(run.len() - start);
            let chunk = run.part(start, m);
            for shift in 0..5 {
                let rows = waves.each_mut().map(|w| &mut w[shift][..m]);
                self.row(&chunk, shift as isize - 2, from, rows);
            }
            let around: Rows<'_, T, K> = std::array::from_fn(|k| std::array::from_fn(|shift| &waves[k][shift][..m]));
            let walls = [(index == 0).then_some(0..m), (index + 1 == n).then_some(0..m)];
            outflow += self.lose(around, walls, m, &mut loss);
            let new = to.each_mut().map(|row| &mut row[start..start + m]);
            for k in 0..K {
                new[k].copy_from_slice(chunk.row(from[k]));
            }
            self.content.update(loss.each_ref().map(|l| &l[..m]), new);
        }
        outflow
    }

    /// The waves of a chunk moved by `by` rows along an axis other than x.
    #[inline(always)]
    fn row(&self, chunk: &Run<'_, D>, by: isize, from: [&[T]; K], waves: [&mut [T]; K]) {
        let place = if self.periodic { Some(chunk.wrapped(self.axis, by)) } else { chunk.moved(self.axis, by) };
        match place {
            Some(place) => self.content.waves(from.map(|f| place.row(f)), waves),
            None => self.row_beyond(chunk, by, from, waves),
        }
    }

    fn row_beyond(&self, chunk: &Run<'_, D>, by: isize, from: [&[T]; K], waves: [&mut [T]; K]) {
        let (n, index) = (self.layout.cells()[self.axis], chunk.cell[self.axis] as isize);
        let (end, mirror, wall) = image(index + by, n);
        let mut values = [[[T::ZERO; CHUNK]; K]; 2];
        for (value, place) in values.iter_mut().zip([mirror, wall]) {
            // Both places are cells of the axis.
            if let Some(place) = chunk.moved(self.axis, place as isize - index) {
                let m = place.len();
                self.content.waves(from.map(|f| place.row(f)), value.each_mut().map(|v| &mut v[..m]));
            }
        }
        for (k, out) in waves.into_iter().enumerate() {
            for (i, out) in out.iter_mut().enumerate() {
                *out = self.beyond(end, k, values[0][K - 1 - k][i], values[1][k][i]);
            }
        }
    }

    #[inline(always)]
    fn beyond(&self, end: End, wave: usize, mirror: T, own: T) -> T {
        let b = &self.waves[wave].beyond[end as usize];
        b.add + b.mirror * mirror + b.own * own
    }

    /// Fills `loss` for a chunk of `m` cells, some of them on a wall, and returns what left there.
    #[inline(always)]
    fn lose(
        &self,
        rows: Rows<'_, T, K>,
        walls: [Option<Range<usize>>; 2],
        m: usize,
        loss: &mut [[T; CHUNK]; K],
    ) -> f64 {
        for k in 0..K {
            losses(self.waves[k].nu, self.waves[k].weight, rows[k], &mut loss[k][..m]);
        }
        let mut outflow = 0.0;
        if !self.periodic {
            for (end, cells) in End::BOTH.into_iter().zip(walls) {
                if let Some(cells) = cells {
                    outflow += self.through(end, rows, cells, loss);
                }
            }
        }
        outflow
    }

    /// What passes the wall on the outside of `cells`, outward positive. A value that comes in is taken at the time at
    /// which the wave it mirrors leaves, which changes what the cells lose.
    fn through(&self, end: End, rows: Rows<'_, T, K>, cells: Range<usize>, loss: &mut [[T; CHUNK]; K]) -> f64 {
        let mut outflow = 0.0;
        for i in cells {
            // Both waves of a cell at once: at a closed wall they cancel to the bit.
            let mut net = T::ZERO;
            for (k, wave) in self.waves.iter().enumerate() {
                let size = wave.nu.abs();
                let leaves = wave.nu.f64() * end.sign() > 0.0;
                // Outward from two cells inside, or inward from two cells outside.
                let order = match (end, leaves) {
                    (End::Low, true) => [3, 2, 1],
                    (End::High, true) => [1, 2, 3],
                    (End::Low, false) => [0, 1, 2],
                    (End::High, false) => [4, 3, 2],
                };
                let [behind, upwind, ahead] = order.map(|shift| rows[k][shift][i]);
                let rises = |weight| rise(weight, behind, upwind, ahead);
                if leaves {
                    net += size * (upwind + rises(wave.weight));
                } else {
                    let weight = wave.beyond[end as usize].weight;
                    loss[k][i] -= size * rises(weight - wave.weight);
                    net -= size * (upwind + rises(weight));
                }
            }
            outflow += net.f64();
        }
        C::PHI * outflow
    }
}

/// For an index outside `0..n`: the end it lies beyond, its mirror image, and the cell on that wall.
fn image(index: isize, n: usize) -> (End, usize, usize) {
    if index < 0 {
        (End::Low, (-index as usize - 1).min(n - 1), 0)
    } else {
        let depth = index as usize - n;
        (End::High, (n - 1).saturating_sub(depth), n - 1)
    }
}
