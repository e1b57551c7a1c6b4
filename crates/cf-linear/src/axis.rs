//! One axis of a level: cell widths, face conductances, and how it coarsens.
//!
//! Levels are tensor products of axes. Coarsening joins cells in pairs; the last cell of an odd axis stays alone with
//! its true extent, so that coarse boxes have exactly the extent of fine ones. Lengths are in units of the fine spacing h.
//!
//! A lone cell stands for more than itself: interpolation spreads its value over part of the pair beside it. Its weight
//! in masses and in conductances across the axis is Pᵀ of the fine ones (for pairs of equal cells that is their sum), or
//! coarse corrections that vary across the axis would be too large there, several times on coarse levels.

/// Widths and conductances of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisTable {
    pub periodic: bool,
    /// kappa = beta/h²: conductance of a unit length.
    pub kappa: f64,
    /// Length of each cell.
    pub extent: Vec<f64>,
    /// Length that each cell stands for in masses and conductances across the axis.
    pub width: Vec<f64>,
    /// Conductance of each face per unit area, n + 1 entries; the ends are walls (or twice the seam).
    pub face: Vec<f64>,
}

/// Interpolation along one axis: fine cell `i` = `own[i]` · parent + `other[i]` · the coarse neighbour on its side.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Interpolation {
    /// False for an axis of one cell, which is its own parent.
    pub coarsened: bool,
    pub own: Vec<f64>,
    pub other: Vec<f64>,
    /// Part of each fine cell that the coarse neighbour on its side stands for: not zero beside a lone cell.
    pub lent: Vec<f64>,
}

impl AxisTable {
    /// `n` unit cells; `walls` are the absolute conductances of the two wall faces, `None` for a periodic axis.
    pub fn new(n: usize, kappa: f64, walls: Option<[f64; 2]>) -> Self {
        let mut face = vec![kappa; n + 1];
        match walls {
            Some([low, high]) => (face[0], face[n]) = (low, high),
            // A single periodic cell is its own neighbour: no operator.
            None if n == 1 => face.fill(0.0),
            None => {}
        }
        Self { periodic: walls.is_none(), kappa, extent: vec![1.0; n], width: vec![1.0; n], face }
    }

    pub fn len(&self) -> usize {
        self.width.len()
    }

    fn centres(extent: &[f64]) -> Vec<f64> {
        let mut edge = 0.0;
        extent
            .iter()
            .map(|w| {
                edge += w;
                edge - 0.5 * w
            })
            .collect()
    }

    /// The axis of half as many cells, and the interpolation from it.
    pub fn coarsen(&self) -> (Self, Interpolation) {
        let n = self.len();
        if n == 1 {
            return (
                self.clone(),
                Interpolation { coarsened: false, own: vec![1.0], other: vec![0.0], lent: vec![0.0] },
            );
        }
        let extent: Vec<f64> = self.extent.chunks(2).map(|pair| pair.iter().sum()).collect();
        let m = extent.len();
        let (fine, coarse) = (Self::centres(&self.extent), Self::centres(&extent));
        let length: f64 = self.extent.iter().sum();
        let mut face = vec![0.0; m + 1];
        for i in 1..m {
            face[i] = self.kappa / (coarse[i] - coarse[i - 1]);
        }
        let ends = [coarse[0] - fine[0], fine[n - 1] - coarse[m - 1]];
        if self.periodic {
            if m > 1 {
                face[0] = self.kappa / (coarse[0] + length - coarse[m - 1]);
                face[m] = face[0];
            }
        } else {
            // Wall resistance in series with the way from the fine to the coarse centre.
            face[0] = in_series(self.face[0], ends[0], self.kappa);
            face[m] = in_series(self.face[n], ends[1], self.kappa);
        }
        let (mut own, mut other) = (vec![1.0; n], vec![0.0; n]);
        for i in 0..n {
            let (parent, step) = (i / 2, fine[i] - coarse[i / 2]);
            let upward = i % 2 == 1;
            let gap = match (upward, parent) {
                (false, 0) if self.periodic => (m > 1).then(|| coarse[0] + length - coarse[m - 1]),
                (true, p) if p + 1 == m && self.periodic => (m > 1).then(|| coarse[0] + length - coarse[m - 1]),
                (false, 0) => None,
                (true, p) if p + 1 == m => None,
                (false, p) => Some(coarse[p] - coarse[p - 1]),
                (true, p) => Some(coarse[p + 1] - coarse[p]),
            };
            match gap {
                Some(gap) => {
                    other[i] = step.abs() / gap;
                    own[i] = 1.0 - other[i];
                }
                // Linear towards zero behind a conducting wall; a closed wall (conductance 0) keeps the parent's value.
                None if !self.periodic => own[i] = 1.0 - step.abs() * face[if upward { m } else { 0 }] / self.kappa,
                None => {}
            }
        }
        let mut lent = vec![0.0; n];
        if n % 2 == 1 {
            lent[n - 2] = other[n - 2];
            if self.periodic {
                lent[0] = other[0];
            }
        }
        let mut width = vec![0.0; m];
        for i in 0..n {
            width[i / 2] += (1.0 - lent[i]) * self.width[i];
            width[m - 1] += lent[i] * self.width[i];
        }
        (
            Self { periodic: self.periodic, kappa: self.kappa, extent, width, face },
            Interpolation { coarsened: true, own, other, lent },
        )
    }
}

/// A conductance in series with a unit-area column of `length`.
pub(crate) fn in_series(conductance: f64, length: f64, kappa: f64) -> f64 {
    if conductance == 0.0 { 0.0 } else { 1.0 / (1.0 / conductance + length / kappa) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_axes_coarsen_to_the_textbook_weights() {
        let (coarse, p) = AxisTable::new(8, 3.0, Some([0.0, 6.0])).coarsen();
        assert_eq!(coarse.width, [2.0; 4]);
        assert_eq!(coarse.face, [0.0, 1.5, 1.5, 1.5, 3.0]);
        assert_eq!(p.own, [1.0, 0.75, 0.75, 0.75, 0.75, 0.75, 0.75, 0.5]);
        assert_eq!(p.other, [0.0, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.0]);
    }

    #[test]
    fn odd_axes_keep_their_extent() {
        for walls in [None, Some([0.0, 0.0]), Some([2.0, 0.0])] {
            let mut axis = AxisTable::new(33, 1.0, walls);
            while axis.len() > 1 {
                axis = axis.coarsen().0;
                assert_eq!(axis.extent.iter().sum::<f64>(), 33.0);
                assert!((axis.width.iter().sum::<f64>() - 33.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn interpolation_keeps_constants_where_walls_are_closed() {
        for (n, walls) in [(7, None), (8, None), (2, None), (9, Some([0.0, 0.0])), (2, Some([0.0; 2]))] {
            let (_, p) = AxisTable::new(n, 1.0, walls).coarsen();
            assert!(p.own.iter().zip(&p.other).all(|(a, b)| (a + b - 1.0).abs() < 1e-15), "{n} {walls:?}");
        }
    }
}
