//! What the tests share: noise, every mix of walls, masks, and the operator assembled by plain index loops.

use cf_grid::{Axis, FaceField, Layout, Mask, Real, Sides};
use cf_linear::Helmholtz;
use faer::Mat;

/// Deterministic noise in [-1, 1).
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A field of noise, zero in the rim.
pub fn random_field<T: Real, const D: usize>(layout: &Layout<D>, seed: u64) -> Vec<T> {
    let (mut random, mut x) = (noise(seed), vec![T::ZERO; layout.slots()]);
    layout.each_cell(layout.cells_region(), |at| x[at.slot()] = T::of(random()));
    x
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    Closed,
    Held,
    Absorbing,
}

/// An axis: periodic, or two ends.
pub type Mix = Option<[End; 2]>;

pub const CLOSED: Mix = Some([End::Closed; 2]);
pub const HELD: Mix = Some([End::Held; 2]);

/// Every kind of axis.
pub const MIXES: [Mix; 5] = [None, CLOSED, HELD, Some([End::Closed, End::Held]), Some([End::Absorbing, End::Closed])];

pub fn mixes_2d() -> Vec<[Mix; 2]> {
    MIXES.iter().flat_map(|&a| MIXES.iter().map(move |&b| [a, b])).collect()
}

/// All 125 mixes of an axis' five kinds.
pub fn all_mixes_3d() -> Vec<[Mix; 3]> {
    let m = MIXES;
    (0..125).map(|i| [m[i % 5], m[i / 5 % 5], m[i / 25]]).collect()
}

/// Every kind on every axis, in 15 mixes, for sizes that take long.
pub fn mixes_3d() -> Vec<[Mix; 3]> {
    let m = MIXES;
    (0..5).flat_map(|i| [[m[i]; 3], [m[i], m[(i + 1) % 5], m[(i + 2) % 5]], [m[i], m[(i + 3) % 5], m[1]]]).collect()
}

pub fn sides<const D: usize>(mix: [Mix; D], kappa: f64) -> Sides<f64, D> {
    let conductance = |end| match end {
        End::Closed => 0.0,
        End::Held => 2.0 * kappa,
        End::Absorbing => 0.7 * kappa.sqrt(),
    };
    Sides(mix.map(|m| m.map_or(Axis::Periodic, |ends| Axis::Walls(ends.map(conductance)))))
}

/// An operator with everything it borrows.
#[derive(Clone)]
pub struct Case<const D: usize> {
    pub layout: Layout<D>,
    pub alpha: f64,
    pub kappa: f64,
    pub walls: Sides<f64, D>,
    pub mask: Option<Mask<D>>,
    pub shares: Option<FaceField<f64, D>>,
}

impl<const D: usize> Case<D> {
    pub fn new(cells: [usize; D], mix: [Mix; D], alpha: f64, kappa: f64) -> Self {
        let layout = Layout::new(cells).unwrap();
        Self { layout, alpha, kappa, walls: sides(mix, kappa), mask: None, shares: None }
    }

    pub fn masked(mut self, fluid: impl Fn([usize; D]) -> bool) -> Self {
        self.mask = Some(Mask::new(&self.layout, fluid));
        self
    }

    /// Random shares in [0.1, 1.9], one in eight zero if `closing`.
    pub fn shared(mut self, seed: u64, closing: bool) -> Self {
        let (mut random, mut shares) = (noise(seed), FaceField::new(&self.layout));
        for a in 0..D {
            let w = shares.axis_mut(a);
            self.layout.each_cell(self.layout.faces_region(a, false), |at| {
                let v = random();
                w[at.slot()] = if closing && v < -0.75 { 0.0 } else { 1.0 + 0.9 * v };
            });
        }
        self.shares = Some(shares);
        self
    }

    pub fn helmholtz(&self) -> Helmholtz<'_, D> {
        let mut operator = Helmholtz::new(&self.layout, self.alpha, self.kappa, self.walls);
        if let Some(mask) = &self.mask {
            operator = operator.with_mask(mask);
        }
        if let Some(shares) = &self.shares {
            operator = operator.with_shares(shares);
        }
        operator
    }

    pub fn is_fluid(&self, cell: [usize; D]) -> bool {
        self.mask.as_ref().is_none_or(|m| m.fluid()[self.layout.slot(cell)])
    }

    /// Fluid cells in the order of the dense operator.
    pub fn cells(&self) -> Vec<[usize; D]> {
        let mut cells = Vec::new();
        self.layout.each_cell(self.layout.cells_region(), |at| cells.push(at.cell));
        cells.retain(|&c| self.is_fluid(c));
        cells
    }

    /// The operator face by face: face `i` of an axis lies between cells `i - 1` and `i`.
    pub fn dense(&self) -> Mat<f64> {
        let cells = self.cells();
        let row = |cell: [usize; D]| cells.iter().position(|&c| c == cell);
        let mut a = Mat::from_fn(cells.len(), cells.len(), |i, j| if i == j { self.alpha } else { 0.0 });
        for axis in 0..D {
            let n = self.layout.cells()[axis];
            self.layout.each_cell(self.layout.faces_region(axis, false), |at| {
                let i = at.cell[axis];
                let share = self.shares.as_ref().map_or(1.0, |s| s.axis(axis)[at.slot()]);
                let (mut low, high) = (at.cell, at.cell);
                match self.walls.0[axis] {
                    Axis::Periodic if n == 1 || i == n => {}
                    Axis::Walls([w, _]) if i == 0 => row(high).into_iter().for_each(|h| a[(h, h)] += w * share),
                    Axis::Walls([_, w]) if i == n => {
                        low[axis] = n - 1;
                        row(low).into_iter().for_each(|l| a[(l, l)] += w * share);
                    }
                    _ => {
                        low[axis] = if i == 0 { n - 1 } else { i - 1 };
                        if let (Some(l), Some(h)) = (row(low), row(high)) {
                            let w = self.kappa * share;
                            a[(l, l)] += w;
                            a[(h, h)] += w;
                            a[(l, h)] -= w;
                            a[(h, l)] -= w;
                        }
                    }
                }
            });
        }
        a
    }

    /// The values of fluid cells as a column, and back.
    pub fn gather<T: Real>(&self, x: &[T]) -> Mat<f64> {
        let cells = self.cells();
        Mat::from_fn(cells.len(), 1, |i, _| x[self.layout.slot(cells[i])].f64())
    }

    pub fn scatter(&self, x: &Mat<f64>) -> Vec<f64> {
        let mut field = vec![0.0; self.layout.slots()];
        self.cells().iter().enumerate().for_each(|(i, &c)| field[self.layout.slot(c)] = x[(i, 0)]);
        field
    }
}

/// Largest absolute value of a column.
pub fn largest(x: &Mat<f64>) -> f64 {
    x.col_iter().flat_map(|c| c.iter().copied().collect::<Vec<_>>()).fold(0.0, |m, v| v.abs().max(m))
}

/// Fluid with about `percent` % random solids.
pub fn random_solids<const D: usize>(percent: f64, seed: u64) -> impl Fn([usize; D]) -> bool {
    move |cell| {
        let key = cell.iter().fold(seed, |k, &i| (k ^ i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29));
        noise(key)() > percent / 50.0 - 1.0
    }
}

/// Walls of one cell every `gap` cells along axis 0, with an opening at alternating ends of axis 1.
pub fn maze<const D: usize>(cells: [usize; D], gap: usize) -> impl Fn([usize; D]) -> bool {
    move |c| {
        let wall = c[0] % gap == gap - 1 && c[0] + 1 < cells[0];
        let open = if (c[0] / gap).is_multiple_of(2) { c[1] < 2 } else { c[1] + 2 >= cells[1] };
        !wall || open
    }
}

/// Cells with their neighbours solid, one cell pockets in a lattice, and free space elsewhere.
pub fn pockets<const D: usize>(cell: [usize; D]) -> bool {
    let ring = cell.iter().map(|&i| i.abs_diff(3)).max().unwrap_or(0);
    ring != 1
}
