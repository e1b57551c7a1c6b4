//! The transfer weights of one pair of levels, sorted for half rows along x and for rows across.

use cf_grid::Real;

use crate::axis::Interpolation;

/// Linear interpolation along x for half rows of parity q.
#[derive(Debug, Clone)]
pub(crate) struct Along<T> {
    /// P: fine cell m = `own`\[q\]\[m\] · parent m + `beside`\[q\]\[m\] · coarse cell m - 1 (q = 0) or m + 1 (q = 1).
    own: [Vec<T>; 2],
    beside: [Vec<T>; 2],
    /// Pᵀ: coarse cell m takes `kept`\[q\]\[m\] · fine cell m and `given`\[q\]\[m\] · fine cell m + 1 (q = 0) or m - 1 (q = 1).
    kept: [Vec<T>; 2],
    given: [Vec<T>; 2],
}

impl<T: Real> Along<T> {
    pub fn new(p: &Interpolation, periodic: bool) -> Self {
        let n = p.own.len();
        let m = n.div_ceil(2);
        let at = |v: &[f64], i: isize| {
            let wrapped = i.rem_euclid(n as isize);
            if i == wrapped || periodic { v[wrapped as usize] } else { 0.0 }
        };
        let table = |v: &[f64], shift: [isize; 2]| -> [Vec<T>; 2] {
            std::array::from_fn(|q| (0..m).map(|c| T::of(at(v, 2 * c as isize + q as isize + shift[q]))).collect())
        };
        Self {
            own: table(&p.own, [0, 0]),
            beside: table(&p.other, [0, 0]),
            kept: table(&p.own, [0, 0]),
            given: table(&p.other, [2, -2]),
        }
    }

    /// fine += P coarse, on the cells of parity `q`; both padded.
    #[inline(always)]
    pub fn prolong_add(&self, q: usize, h: usize, coarse: &[T], fine: &mut [T]) {
        let side = if q == 0 { &coarse[..h] } else { &coarse[2..2 + h] };
        let (fine, parent) = (&mut fine[1..1 + h], &coarse[1..1 + h]);
        let (own, beside) = (&self.own[q][..h], &self.beside[q][..h]);
        for m in 0..h {
            fine[m] += own[m] * parent[m] + beside[m] * side[m];
        }
    }

    /// coarse = Pᵀ fine, from a padded half row of parity `q` whose rim beyond its cells is zero or wrapped.
    #[inline(always)]
    pub fn restrict(&self, q: usize, fine: &[T], coarse: &mut [T]) {
        let m = coarse.len();
        let side = if q == 0 { &fine[2..2 + m] } else { &fine[..m] };
        let (kept, given, fine) = (&self.kept[q][..m], &self.given[q][..m], &fine[1..1 + m]);
        for c in 0..m {
            coarse[c] = kept[c] * fine[c] + given[c] * side[c];
        }
    }
}

/// Interpolation along another axis.
#[derive(Debug, Clone)]
pub(crate) struct Across {
    coarsened: bool,
    own: Vec<f64>,
    other: Vec<f64>,
}

impl Across {
    pub fn new(p: &Interpolation) -> Self {
        Self { coarsened: p.coarsened, own: p.own.clone(), other: p.other.clone() }
    }

    /// The coarse indices that the fine index `i` (any, counted on across seams) takes part in, and the weights;
    /// `actual` is the same index inside the box.
    #[inline(always)]
    pub fn of(&self, i: isize, actual: usize) -> [(isize, f64); 2] {
        if !self.coarsened {
            return [(i, 1.0), (i, 0.0)];
        }
        let parent = i.div_euclid(2);
        let beside = if i.rem_euclid(2) == 1 { parent + 1 } else { parent - 1 };
        [(parent, self.own[actual]), (beside, self.other[actual])]
    }

    /// The fine indices that give to coarse indices `from..to`.
    pub fn givers(&self, from: usize, to: usize) -> (isize, isize) {
        let (from, to) = (from as isize, to as isize);
        if self.coarsened { (2 * from - 1, 2 * to + 1) } else { (from, to) }
    }
}
