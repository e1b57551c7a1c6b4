//! Slabs for threads and rings for caches.
//!
//! A sweep is cut into slabs of planes, which threads take, and each slab into strips of rows, which follow the planes
//! one after the other while the last few planes of every intermediate result stay in a ring in the L2 cache. What a
//! slab or a strip needs of its neighbours' results it computes again, so that every slab writes only its own planes,
//! reads nothing that another one writes, and gives the same bits however the sweep is cut.

use std::ops::Range;

use cf_grid::Real;

/// Bytes of a core's L2 cache that the rings of a strip may fill.
const CACHE: usize = 384 << 10;
/// Cells below which a sweep is not worth a second thread.
const SMALL: usize = 1 << 14;
/// Fewest planes of a slab.
const THIN: usize = 8;

/// Slabs for a sweep over `planes` planes of `cells` cells.
pub(crate) fn slabs(planes: usize, cells: usize) -> usize {
    let threads = rayon::current_num_threads();
    if threads == 1 || cells < SMALL { 1 } else { (2 * threads).min(planes / THIN).max(1) }
}

/// Rows of a strip (even) whose rings of `halves` half planes with `halo` more rows on either side fit the cache.
pub(crate) fn strip<T>(padded: usize, halves: usize, halo: usize) -> usize {
    let rows = CACHE / (halves * padded * size_of::<T>());
    (rows.saturating_sub(2 * halo) / 2 * 2).max(8)
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
    body: &(impl Fn(Range<usize>, &mut [T], &mut [P], &mut S) + Sync),
) {
    if parts <= 1 {
        if let Some(scratch) = scratch.first_mut() {
            pulp::Arch::new().dispatch(|| body(planes, out, sums, scratch));
        }
        return;
    }
    let (left, count) = (parts / 2, planes.len());
    let cut = count * left / parts;
    let (out_low, out_high) = out.split_at_mut(cut * plane);
    let (sums_low, sums_high) = sums.split_at_mut(cut);
    let (scratch_low, scratch_high) = scratch.split_at_mut(left);
    let middle = planes.start + cut;
    rayon::join(
        || each_slab(planes.start..middle, left, plane, out_low, sums_low, scratch_low, body),
        || each_slab(middle..planes.end, parts - left, plane, out_high, sums_high, scratch_high, body),
    );
}

/// The last planes of half rows of one colour, `rows` rows of `padded` numbers each.
pub(crate) struct Ring<'s, T> {
    data: &'s mut [T],
    planes: usize,
    rows: usize,
    padded: usize,
}

impl<'s, T: Real> Ring<'s, T> {
    /// Cut off the front of `scratch`.
    #[inline(always)]
    pub fn cut(scratch: &mut &'s mut [T], planes: usize, rows: usize, padded: usize) -> Self {
        let (data, rest) = std::mem::take(scratch).split_at_mut(planes * rows * padded);
        *scratch = rest;
        Self { data, planes, rows, padded }
    }

    #[inline(always)]
    fn start(&self, plane: isize, row: usize) -> usize {
        let plane = plane.rem_euclid(self.planes as isize) as usize;
        (plane * self.rows + row) * self.padded
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
