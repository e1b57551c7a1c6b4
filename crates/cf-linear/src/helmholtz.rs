//! What is solved: alpha x - div(beta grad x) = b, described by numbers and, where a scene needs them, by a mask.

use cf_grid::{FaceField, Layout, Mask, Real, Sides};

use crate::axis::AxisTable;
use crate::level::{Coefficients, LevelOperator};
use crate::stencil::{BoxStencil, StoredStencil};

/// The Helmholtz operator A = alpha - div(beta grad) on cell values, with homogeneous walls folded in:
///
/// (A x)_c = alpha x_c + Σ_f w_f (x_c - x_n), w_f = kappa = beta/h² on inner faces.
///
/// A wall face has an outer value of zero and its own conductance: 0 closed, 2 kappa for a held value half a cell away,
/// dt c/h for an absorbing wall. Inhomogeneous parts belong into the right-hand side. A is symmetric and, for alpha > 0,
/// positive definite with row sums >= alpha (model/diffusion.md sections 3 to 5).
#[derive(Debug, Clone)]
pub struct Helmholtz<'m, const D: usize> {
    layout: Layout<D>,
    alpha: f64,
    kappa: f64,
    walls: Sides<f64, D>,
    mask: Option<&'m Mask<D>>,
    shares: Option<&'m FaceField<f64, D>>,
}

impl<'m, const D: usize> Helmholtz<'m, D> {
    /// Uniform coefficients on a box: `alpha` >= 0, `kappa` = beta/h² >= 0, wall conductances in the units of `kappa`.
    pub fn new(layout: &Layout<D>, alpha: f64, kappa: f64, walls: Sides<f64, D>) -> Self {
        Self { layout: *layout, alpha, kappa, walls, mask: None, shares: None }
    }

    /// The same operator on the fluid cells of a mask: faces between fluid and solid are closed.
    pub fn with_mask(mut self, mask: &'m Mask<D>) -> Self {
        self.mask = Some(mask);
        self
    }

    /// Variable coefficients: face conductances are `kappa` times these non-negative shares (by face slot).
    pub fn with_shares(mut self, shares: &'m FaceField<f64, D>) -> Self {
        self.shares = Some(shares);
        self
    }

    /// The layout of its vectors.
    pub fn layout(&self) -> &Layout<D> {
        &self.layout
    }

    /// The identity coefficient.
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// beta/h².
    pub fn kappa(&self) -> f64 {
        self.kappa
    }

    /// Wall conductances.
    pub fn walls(&self) -> &Sides<f64, D> {
        &self.walls
    }

    /// The mask, if any.
    pub fn mask(&self) -> Option<&'m Mask<D>> {
        self.mask
    }

    /// No wall conducts: constants (per connected component) are eigenvectors with eigenvalue alpha.
    pub fn conserves(&self) -> bool {
        self.walls.walls().all(|(_, _, w)| w == 0.0)
    }

    /// The largest possible diagonal, alpha + 2 D kappa: the unit in which solvers work, so that no coefficient leaves
    /// [0, 1] whatever kappa is. Walls may exceed it by a factor of 2.
    pub fn scale(&self) -> f64 {
        self.alpha + 2.0 * D as f64 * self.kappa
    }

    /// Whether any coefficient is stored per cell.
    pub fn is_stored(&self) -> bool {
        self.mask.is_some() || self.shares.is_some()
    }

    /// The finest level, divided by [`scale`](Self::scale).
    pub(crate) fn level<T: Real>(&self) -> LevelOperator<T, D> {
        let scale = self.scale();
        let (alpha, kappa) = (self.alpha / scale, self.kappa / scale);
        let axes: [AxisTable; D] = std::array::from_fn(|a| {
            let walls = match self.walls.0[a] {
                cf_grid::Axis::Periodic => None,
                cf_grid::Axis::Walls(w) => Some(w.map(|w| w / scale)),
            };
            AxisTable::new(self.layout.cells()[a], kappa, walls)
        });
        let coefficients = if self.is_stored() {
            let (mass, face) = self.stored(alpha, &axes);
            Coefficients::Stored(StoredStencil::new(&self.layout, &mass, &face))
        } else {
            Coefficients::Uniform(BoxStencil { alpha, axes: axes.clone() })
        };
        LevelOperator::new(self.layout, axes, coefficients)
    }

    fn stored(&self, alpha: f64, axes: &[AxisTable; D]) -> (Vec<f64>, [Vec<f64>; D]) {
        let layout = &self.layout;
        let fluid = |slot: usize| self.mask.is_none_or(|m| m.fluid()[slot]);
        let mut mass = vec![0.0; layout.slots()];
        layout.par_cells(&mut mass, |at| if fluid(at.slot()) { alpha } else { 0.0 });
        let face = std::array::from_fn(|a| {
            let n = layout.cells()[a];
            let mut w = vec![0.0; layout.slots()];
            layout.par_region(layout.faces_region(a, false), &mut w, |at| {
                let i = at.cell[a];
                // Low and high neighbour cells; across a seam the low one is the last cell.
                let mut pair = [at.cell, at.cell];
                pair[0][a] = if i > 0 { i - 1 } else { n - 1 };
                pair[1][a] = if i < n { i } else { 0 };
                let wet = pair.map(|c| fluid(layout.slot(c)));
                let open = match (axes[a].periodic, i) {
                    (false, 0) => wet[1],
                    (false, i) if i == n => wet[0],
                    _ => wet[0] && wet[1],
                };
                // The seam face of a periodic axis is stored at the low slot.
                let slot = if axes[a].periodic { layout.slot(pair[1]) } else { at.slot() };
                let share = self.shares.map_or(1.0, |s| s.axis(a)[slot]);
                if open { axes[a].face[i] * share } else { 0.0 }
            });
            w
        });
        (mass, face)
    }
}
