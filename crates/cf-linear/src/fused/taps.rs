//! The transfer weights of one pair of levels, sorted for half rows along x and for rows across.

use cf_grid::Real;

use super::rows::{BLOCK, block, blocks, blocks_mut, of, table};
use super::tile::Lines;
use crate::axis::Interpolation;

/// Linear interpolation along x for half rows of parity q.
#[derive(Debug, Clone)]
pub(crate) struct Along<T> {
    /// P: fine cell m = `own`\[q\]\[m\] · parent m + `beside`\[q\]\[m\] · coarse cell m - 1 (q = 0) or m + 1 (q = 1).
    own: [Lines<T>; 2],
    beside: [Lines<T>; 2],
    /// Pᵀ: coarse cell m takes `own`\[q\]\[m\] · fine cell m and `given`\[q\]\[m\] · fine cell m + 1 (q = 0) or m - 1 (q = 1).
    given: [Lines<T>; 2],
}

impl<T: Real> Along<T> {
    pub fn new(p: &Interpolation, periodic: bool) -> Self {
        let n = p.own.len();
        // The weight that the fine cell two away has for the coarse cell beside its own.
        let given = |i: usize, step: isize| {
            let far = i as isize + step;
            let wrapped = far.rem_euclid(n as isize);
            if far == wrapped || periodic { p.other[wrapped as usize] } else { 0.0 }
        };
        // Coarse cell m may have no second child, but then has one to give to it from the first cell of the next.
        let length = n.next_multiple_of(2);
        Self {
            own: std::array::from_fn(|q| table(n, q, |i| p.own[i])),
            beside: std::array::from_fn(|q| table(n, q, |i| p.other[i])),
            given: std::array::from_fn(|q| table(length, q, |i| given(i, [2, -2][q]))),
        }
    }

    /// Weights of P for the cells of parity `q`: of their parents, and of the coarse cells beside those.
    #[inline(always)]
    pub fn prolongation(&self, q: usize) -> (&[[T; BLOCK]], &[[T; BLOCK]]) {
        (of(&self.own[q]), of(&self.beside[q]))
    }

    /// coarse = Pᵀ fine, from a half row of parity `q` whose rim beyond its cells is zero or wrapped; both padded.
    #[inline(always)]
    pub fn restrict(&self, q: usize, fine: &[T], coarse: &mut [T]) {
        let (own, given) = (of(&self.own[q]), of(&self.given[q]));
        let count = own.len();
        let (child, side) = (blocks(fine, 1, count), blocks(fine, 2 - 2 * q, count));
        for (i, coarse) in blocks_mut(coarse, 1, count).iter_mut().enumerate() {
            let (own, given, child, side) = (&own[i], &given[i], &child[i], &side[i]);
            *coarse = block(
                #[inline(always)]
                |k| own[k] * child[k] + given[k] * side[k],
            );
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
