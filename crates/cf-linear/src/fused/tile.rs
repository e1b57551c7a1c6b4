//! Slabs for threads and rings for caches.
//!
//! A sweep is cut into slabs of planes, which threads take, and each slab into strips of rows, which follow the planes
//! one after the other while the last few planes of every intermediate result stay in a ring in the L2 cache. What a
//! slab or a strip needs of its neighbours' results it computes again, so that every slab writes only its own planes,
//! reads nothing that another one writes, and gives the same bits however the sweep is cut.

use std::ops::Range;

use cf_grid::{Real, join, vectorised};

/// Bytes of a core's L2 cache that the rings of a strip may fill.
const CACHE: usize = 512 << 10;
/// Cells below which a sweep is not worth a second thread.
const SMALL: usize = 1 << 14;
/// Fewest planes of a slab.
const THIN: usize = 8;

/// Slabs for a sweep over `planes` planes of `cells` cells.
pub(crate) fn slabs(planes: usize, cells: usize) -> usize {
    let threads = rayon::current_num_threads();
    if threads == 1 || cells < SMALL { 1 } else { (2 * threads).min(planes / THIN).max(1) }
}

/// Numbers in a cache line.
const fn line<T>() -> usize {
    64 / size_of::<T>()
}

/// Distance of rows of `padded` numbers whose entries 1, the first cells, all begin a cache line. The entry before them
/// ends the line before.
fn pitch<T>(padded: usize) -> usize {
    (padded - 1).next_multiple_of(line::<T>()) + line::<T>()
}

/// Rows of a strip (even) whose rings of `halves` half planes with `halo` more rows on either side fit the cache.
pub(crate) fn strip<T>(padded: usize, halves: usize, halo: usize) -> usize {
    let rows = CACHE / (halves * pitch::<T>(padded) * size_of::<T>());
    (rows.saturating_sub(2 * halo) / 2 * 2).max(8)
}

/// Numbers of scratch from which [`Ring::cut`] cuts `rings` rings of `rows` rows together.
pub(crate) fn room<T>(rings: usize, rows: usize, padded: usize) -> usize {
    rows * pitch::<T>(padded) + (rings + 1) * line::<T>()
}

/// Calls `body(planes, out, sums, scratch)` for `parts` slabs of `planes` in parallel. `out` holds `plane` slots and
/// `sums` one entry a plane; each part has its own scratch.
pub(crate) fn each_slab<T: Send, P: Send, S: Send>(
    planes: Range<usize>,
    parts: usize,
    plane: usize,
    out: &mut [T],
    sums: &mut [P],
    scratch: &mut [S],
    body: impl Fn(Range<usize>, &mut [T], &mut [P], &mut S) + Sync,
) {
    halve(planes, parts, plane, out, sums, scratch, &body);
}

fn halve<T: Send, P: Send, S: Send>(
    planes: Range<usize>,
    parts: usize,
    plane: usize,
    out: &mut [T],
    sums: &mut [P],
    scratch: &mut [S],
    body: &(impl Fn(Range<usize>, &mut [T], &mut [P], &mut S) + Sync),
) {
    if parts <= 1 {
        if let Some(scratch) = scratch.first_mut() {
            vectorised(
                #[inline(always)]
                || body(planes, out, sums, scratch),
            );
        }
        return;
    }
    let (left, count) = (parts / 2, planes.len());
    let cut = count * left / parts;
    let (out_low, out_high) = out.split_at_mut(cut * plane);
    let (sums_low, sums_high) = sums.split_at_mut(cut);
    let (scratch_low, scratch_high) = scratch.split_at_mut(left);
    let middle = planes.start + cut;
    join(
        || halve(planes.start..middle, left, plane, out_low, sums_low, scratch_low, body),
        || halve(middle..planes.end, parts - left, plane, out_high, sums_high, scratch_high, body),
    );
}

/// The part of `scratch` that begins with a cache line.
pub(crate) fn aligned<T>(scratch: &mut [T]) -> &mut [T] {
    let offset = scratch.as_ptr().align_offset(64).min(line::<T>() - 1);
    &mut scratch[offset..]
}

/// A table that begins a cache line.
#[derive(Debug, Clone)]
pub(crate) struct Lines<T>(Vec<T>, usize);

impl<T: Real> FromIterator<f64> for Lines<T> {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let values = values.into_iter();
        let mut data: Vec<T> = Vec::with_capacity(values.size_hint().1.unwrap_or(0) + line::<T>());
        let offset = data.as_ptr().align_offset(64).min(line::<T>() - 1);
        data.resize(offset, T::ZERO);
        data.extend(values.map(T::of));
        Self(data, offset)
    }
}

impl<T> Lines<T> {
    #[inline(always)]
    pub fn get(&self) -> &[T] {
        &self.0[self.1..]
    }

    pub fn bytes(&self) -> usize {
        size_of_val(self.get())
    }
}

/// The last planes of half rows of one colour, `rows` rows of `padded` numbers each.
pub(crate) struct Ring<'s, T> {
    data: &'s mut [T],
    planes: usize,
    rows: usize,
    padded: usize,
    pitch: usize,
}

impl<'s, T: Real> Ring<'s, T> {
    /// Cut off the front of an [`aligned`] `scratch`.
    #[inline(always)]
    pub fn cut(scratch: &mut &'s mut [T], planes: usize, rows: usize, padded: usize) -> Self {
        let pitch = pitch::<T>(padded);
        let (data, rest) = std::mem::take(scratch).split_at_mut(planes * rows * pitch + line::<T>());
        *scratch = rest;
        Self { data, planes, rows, padded, pitch }
    }

    #[inline(always)]
    fn start(&self, plane: isize, row: usize) -> usize {
        let plane = plane.rem_euclid(self.planes as isize) as usize;
        (plane * self.rows + row) * self.pitch + line::<T>() - 1
    }

    /// Row `row` of plane `plane`, any number.
    #[inline(always)]
    pub fn row(&self, plane: isize, row: usize) -> &[T] {
        let start = self.start(plane, row);
        &self.data[start..start + self.padded]
    }

    /// The same, to be written.
    #[inline(always)]
    pub fn row_mut(&mut self, plane: isize, row: usize) -> &mut [T] {
        let start = self.start(plane, row);
        &mut self.data[start..start + self.padded]
    }
}
