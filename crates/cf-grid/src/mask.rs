//! Obstacles: which cells are fluid, and which fluid cells hang together.

use crate::{GridError, Layout, Sides};

/// Fluid or solid, per cell. The rim counts as solid.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask<const D: usize> {
    layout: Layout<D>,
    fluid: Vec<bool>,
}

impl<const D: usize> Mask<D> {
    /// A mask by predicate: `fluid(cell)` is true where the quantity lives.
    pub fn new(layout: &Layout<D>, fluid: impl Fn([usize; D]) -> bool) -> Self {
        let mut values = vec![false; layout.slots()];
        layout.each_row(layout.cells_region(), |run| {
            for at in run.ats() {
                values[at.slot()] = fluid(at.cell);
            }
        });
        Self { layout: *layout, fluid: values }
    }

    /// A mask from one flag per slot, as another field stores it.
    pub fn from_slots(layout: &Layout<D>, fluid: &[bool]) -> Result<Self, GridError> {
        if fluid.len() != layout.slots() {
            return Err(GridError::Length { expected: layout.slots(), found: fluid.len() });
        }
        Ok(Self::new(layout, |cell| fluid[layout.slot(cell)]))
    }

    /// Fluid flags by slot.
    pub fn fluid(&self) -> &[bool] {
        &self.fluid
    }

    /// The layout it belongs to.
    pub fn layout(&self) -> &Layout<D> {
        &self.layout
    }

    /// Number of fluid cells.
    pub fn fluid_cells(&self) -> usize {
        self.fluid.iter().filter(|&&f| f).count()
    }

    /// Labels the fluid cells by connected component; cells touch through faces, periodic axes wrap.
    pub fn components<W: Copy>(&self, sides: &Sides<W, D>) -> Components {
        let layout = &self.layout;
        let mut label = vec![0u32; layout.slots()];
        let mut cells = Vec::new();
        let mut queue = Vec::new();
        layout.each_row(layout.cells_region(), |run| {
            for at in run.ats() {
                if !self.fluid[at.slot()] || label[at.slot()] != 0 {
                    continue;
                }
                cells.push(0);
                let id = cells.len() as u32;
                label[at.slot()] = id;
                queue.push(at.cell);
                while let Some(cell) = queue.pop() {
                    cells[id as usize - 1] += 1;
                    for a in 0..D {
                        let n = layout.cells()[a];
                        let steps = [cell[a].checked_sub(1), Some(cell[a] + 1).filter(|&i| i < n)];
                        let wrapped = [n - 1, 0];
                        for (step, wrap) in steps.into_iter().zip(wrapped) {
                            let Some(i) = step.or(sides.is_periodic(a).then_some(wrap)) else {
                                continue;
                            };
                            let mut next = cell;
                            next[a] = i;
                            let slot = layout.slot(next);
                            if self.fluid[slot] && label[slot] == 0 {
                                label[slot] = id;
                                queue.push(next);
                            }
                        }
                    }
                }
            }
        });
        Components { label, cells }
    }
}

/// Connected fluid components of a [`Mask`].
#[derive(Debug, Clone, PartialEq)]
pub struct Components {
    /// Per slot: 0 for solid, otherwise 1 + the component's number.
    pub label: Vec<u32>,
    /// Cells of each component.
    pub cells: Vec<usize>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Axis, Wall};

    #[test]
    fn components_respect_walls_and_periodic_seams() {
        let layout = Layout::new([5, 3]).unwrap();
        let mask = Mask::new(&layout, |c| c[0] != 2);
        let closed = mask.components(&Sides::all(Wall::CLOSED));
        assert_eq!(closed.cells, [6, 6]);
        let wrapped = mask.components::<Wall>(&Sides([Axis::Periodic, Axis::Walls([Wall::CLOSED; 2])]));
        assert_eq!(wrapped.cells, [12]);
        assert_eq!(mask.fluid_cells(), 12);
        assert!(Mask::from_slots(&layout, &[true; 3]).is_err());
    }
}
