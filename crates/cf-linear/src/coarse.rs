//! The coarsest level, solved exactly by a dense Cholesky factorisation (faer).

use cf_grid::{Layout, Real};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use crate::level::LevelOperator;

/// A factored coarsest operator.
pub(crate) struct CoarseSolver<const D: usize> {
    layout: Layout<D>,
    factor: Llt<f64>,
    rhs: Mat<f64>,
    /// Cells joined to nothing: their value is a constant, which callers know.
    lonely: Vec<usize>,
}

impl<const D: usize> CoarseSolver<D> {
    /// Assembles the operator column by column and factors it. A component that no conducting wall touches has the
    /// constant as (near) null vector: adding a rank-one term there fixes the constant and changes nothing else, since
    /// callers remove it. `None` if the factorisation fails.
    pub fn new<T: Real>(operator: &LevelOperator<T, D>) -> Option<Self> {
        let layout = operator.layout;
        let n = layout.count();
        let slots = slots(&layout);
        let mut a = Mat::<f64>::zeros(n, n);
        let (mut x, mut y) = (vec![T::ZERO; layout.slots()], vec![T::ZERO; layout.slots()]);
        for (j, &slot) in slots.iter().enumerate() {
            x.fill(T::ZERO);
            x[slot] = T::ONE;
            operator.apply(&mut x, &mut y);
            for (i, &slot) in slots.iter().enumerate() {
                a[(i, j)] = y[slot].f64();
            }
        }
        let mut held = Vec::with_capacity(n);
        layout.each_cell(layout.cells_region(), |at| held.push(operator.touches_wall(at)));
        let mut lonely = Vec::new();
        for component in components(&a) {
            if component.iter().any(|&i| held[i]) {
                continue;
            }
            if let [i] = component[..] {
                a[(i, i)] = 1.0;
                lonely.push(i);
            } else {
                let diagonal: f64 = component.iter().map(|&i| a[(i, i)]).sum();
                let shift = diagonal / (component.len() * component.len()) as f64;
                for &i in &component {
                    for &j in &component {
                        a[(i, j)] += shift;
                    }
                }
            }
        }
        // Rounding in T may have broken symmetry in the last digit.
        let a = Mat::from_fn(n, n, |i, j| 0.5 * (a[(i, j)] + a[(j, i)]));
        let factor = a.llt(Side::Lower).ok()?;
        Some(Self { layout, factor, rhs: Mat::zeros(n, 1), lonely })
    }

    /// x = A⁻¹ b.
    pub fn solve<T: Real>(&mut self, b: &[T], x: &mut [T]) {
        for (i, slot) in each_slot(&self.layout).enumerate() {
            self.rhs[(i, 0)] = b[slot].f64();
        }
        for &i in &self.lonely {
            self.rhs[(i, 0)] = 0.0;
        }
        self.factor.solve_in_place(self.rhs.as_mut());
        for (i, slot) in each_slot(&self.layout).enumerate() {
            x[slot] = T::of(self.rhs[(i, 0)]);
        }
    }
}

fn each_slot<const D: usize>(layout: &Layout<D>) -> impl Iterator<Item = usize> + '_ {
    let n = layout.cells();
    (0..layout.count()).map(move |mut i| {
        let cell = std::array::from_fn(|a| {
            let index = i % n[a];
            i /= n[a];
            index
        });
        layout.slot(cell)
    })
}

fn slots<const D: usize>(layout: &Layout<D>) -> Vec<usize> {
    each_slot(layout).collect()
}

/// Connected components of the matrix graph.
fn components(a: &Mat<f64>) -> Vec<Vec<usize>> {
    let n = a.nrows();
    let mut seen = vec![false; n];
    let mut found = Vec::new();
    for start in 0..n {
        if seen[start] {
            continue;
        }
        let mut component = vec![start];
        seen[start] = true;
        let mut next = 0;
        while next < component.len() {
            let i = component[next];
            next += 1;
            for j in 0..n {
                if !seen[j] && a[(j, i)] != 0.0 {
                    seen[j] = true;
                    component.push(j);
                }
            }
        }
        found.push(component);
    }
    found
}
