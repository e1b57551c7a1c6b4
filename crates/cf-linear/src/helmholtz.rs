//! What is solved: alpha x - div(beta grad x) = b, described by numbers and, where a scene needs them, by a mask.

use cf_grid::{Axis, FaceField, Layout, Mask, Real, Sides};

use crate::axis::AxisTable;
use crate::error::SolveError;
use crate::level::{Coefficients, LevelOperator};
use crate::stencil::{BoxStencil, StoredStencil};

/// The Helmholtz operator A = alpha - div(beta grad) on cell values, with homogeneous walls folded in:
///
/// (A x)_c = alpha x_c + Σ_f w_f (x_c - x_n), w_f = kappa = beta/h² on inner faces.
///
/// A wall face has an outer value of zero and its own conductance: 0 closed, 2 kappa for a held value half a cell away,
/// dt c/h for an absorbing wall. Inhomogeneous parts belong into the right-hand side. A periodic axis of one cell has no
/// faces. A is symmetric and, for alpha > 0, positive definite with row sums >= alpha (docs/paper-map.md).
/// Solid cells are outside the system: their right-hand side is not read and their solution is zero.
///
/// Nothing is checked here: [`Solver::new`](crate::Solver::new) refuses coefficients that are negative or not finite.
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

    /// Variable coefficients: every face conductance, of walls too, is multiplied by its share >= 0 (by face slot; a
    /// periodic seam at the low slot). A share of zero closes the face.
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

    /// kappa = 0 and no conducting wall: A = alpha.
    pub(crate) fn is_diagonal(&self) -> bool {
        self.kappa == 0.0 && self.conserves()
    }

    /// The unit in which solvers work, so that no coefficient leaves [0, 1] whatever kappa is: a bound of the diagonal,
    /// alpha + 2 D kappa unless walls or shares exceed that.
    pub fn scale(&self) -> f64 {
        self.alpha + self.conductance().max(2.0 * self.kappa)
    }

    /// A bound of the sum of a cell's conductances, exact where shares are 1.
    pub fn conductance(&self) -> f64 {
        let sum: f64 = (0..D)
            .map(|a| match (self.walls.0[a], self.layout.cells()[a]) {
                (Axis::Periodic, 1) => 0.0,
                (Axis::Walls([low, high]), 1) => low + high,
                (Axis::Periodic, _) => 2.0 * self.kappa,
                (Axis::Walls([low, high]), 2) => self.kappa + low.max(high),
                (Axis::Walls([low, high]), _) => self.kappa + self.kappa.max(low).max(high),
            })
            .sum();
        sum * self.largest_share()
    }

    /// The largest share of any face, at least 1.
    pub(crate) fn largest_share(&self) -> f64 {
        let Some(shares) = self.shares else { return 1.0 };
        (0..D).map(|a| self.layout.max_abs(shares.axis(a)).max(self.high_walls(a, shares))).fold(1.0, f64::max)
    }

    /// The largest share on the faces behind the last cells, which no sweep over cells sees.
    fn high_walls(&self, a: usize, shares: &FaceField<f64, D>) -> f64 {
        let mut region = self.layout.faces_region(a, self.walls.is_periodic(a));
        region.low[a] = self.layout.cells()[a];
        let mut largest = 0f64;
        self.layout.each_cell(region, |at| largest = largest.max(shares.axis(a)[at.slot()].abs()));
        largest
    }

    /// The diagonal of a cell far from walls, where shares are 1, but not more than [`scale`](Self::scale).
    pub(crate) fn inner(&self) -> f64 {
        (self.alpha + 2.0 * D as f64 * self.kappa).min(self.scale())
    }

    /// Refuses what no solver can use.
    pub(crate) fn check(&self) -> Result<(), SolveError> {
        let refuse = |name, value| Err(SolveError::Coefficient { name, value });
        let valid = |v: f64| v.is_finite() && v >= 0.0;
        if !valid(self.alpha) {
            return refuse("alpha", self.alpha);
        }
        if !valid(self.kappa) {
            return refuse("kappa", self.kappa);
        }
        if let Some((_, _, value)) = self.walls.walls().find(|(_, _, w)| !valid(*w)) {
            return refuse("wall conductance", value);
        }
        if let Some(mask) = self.mask
            && mask.layout() != &self.layout
        {
            return Err(SolveError::Length {
                what: "mask",
                expected: self.layout.slots(),
                found: mask.layout().slots(),
            });
        }
        if let Some(shares) = self.shares {
            for a in 0..D {
                let values = shares.axis(a);
                if values.len() != self.layout.slots() {
                    let (expected, found) = (self.layout.slots(), values.len());
                    return Err(SolveError::Length { what: "shares", expected, found });
                }
                let mut wrong = None;
                let faces = self.layout.faces_region(a, self.walls.is_periodic(a));
                self.layout.each_cell(faces, |at| {
                    if !valid(values[at.slot()]) {
                        wrong.get_or_insert(values[at.slot()]);
                    }
                });
                if let Some(value) = wrong {
                    return refuse("share", value);
                }
            }
        }
        match self.scale() {
            _ if self.alpha == 0.0 && self.kappa == 0.0 => Err(SolveError::Empty),
            scale if !scale.is_finite() => refuse("alpha + 2 D kappa", scale),
            _ => Ok(()),
        }
    }

    /// Whether a cell is in the system.
    pub(crate) fn is_fluid(&self, cell: [usize; D]) -> bool {
        self.mask.is_none_or(|m| m.fluid()[self.layout.slot(cell)])
    }

    /// The faces of a fluid cell: the cell on the other side (`None` behind a wall) and the conductance.
    pub(crate) fn faces_of(&self, cell: [usize; D]) -> impl Iterator<Item = (Option<[usize; D]>, f64)> + '_ {
        (0..2 * D).map(move |side| {
            let (a, high) = (side / 2, side % 2);
            let n = self.layout.cells()[a];
            let (i, mut face) = (cell[a], cell);
            face[a] = i + high;
            let (neighbour, whole) = match self.walls.0[a] {
                Axis::Periodic if n == 1 => (None, 0.0),
                Axis::Walls(walls) if (high == 0 && i == 0) || (high == 1 && i + 1 == n) => (None, walls[high]),
                axis => {
                    if axis == Axis::Periodic && face[a] == n {
                        face[a] = 0;
                    }
                    let mut next = cell;
                    next[a] = (i + high + n + high - 1) % n;
                    (Some(next), if self.is_fluid(next) { self.kappa } else { 0.0 })
                }
            };
            let share = self.shares.map_or(1.0, |s| s.axis(a)[self.layout.slot(face)]);
            (neighbour, whole * share)
        })
    }

    /// Whether any coefficient is stored per cell.
    pub fn is_stored(&self) -> bool {
        self.mask.is_some() || self.shares.is_some()
    }

    /// Open volume of each cell in units of h^D; empty where no coefficient is stored.
    pub(crate) fn open(&self) -> Vec<f64> {
        if !self.is_stored() {
            return Vec::new();
        }
        let mut open = vec![0.0; self.layout.slots()];
        self.layout.par_cells(&mut open, |at| if self.is_fluid(at.cell) { 1.0 } else { 0.0 });
        open
    }

    /// The finest level, divided by [`scale`](Self::scale).
    pub(crate) fn level<T: Real>(&self) -> LevelOperator<T, D> {
        let scale = self.scale();
        let (alpha, kappa) = (self.alpha / scale, self.kappa / scale);
        let axes: [AxisTable; D] = std::array::from_fn(|a| {
            let walls = match self.walls.0[a] {
                Axis::Periodic => None,
                Axis::Walls(w) => Some(w.map(|w| w / scale)),
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
