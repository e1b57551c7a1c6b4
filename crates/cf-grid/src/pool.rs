//! Scratch that several owners take turns with.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::{CellField, Layout, Real};

/// Arrays of one layout for owners that never need them at once: right-hand sides, solver vectors, transport buffers. A
/// pool grows to what is needed at one time and keeps it. Clones share the arrays.
///
/// The default is no pool: whoever has it keeps the arrays it fetched.
#[derive(Debug, Clone, Default)]
pub struct Pool<T>(Option<Arc<Mutex<Vec<CellField<T>>>>>);

impl<T: Real> Pool<T> {
    /// An empty pool.
    pub fn new() -> Self {
        Self(Some(Arc::default()))
    }

    /// Turns each empty array into one of zeros, from the pool if it has any; other arrays are left as they are.
    pub fn fetch<'a, const D: usize>(
        &self,
        layout: &Layout<D>,
        arrays: impl IntoIterator<Item = &'a mut CellField<T>>,
    ) {
        for array in arrays.into_iter().filter(|array| array.is_empty()) {
            *array = match self.take(layout.slots()) {
                Some(mut idle) => {
                    // What a step gives must not depend on who had the array before.
                    idle.par_chunks_mut(CHUNK).for_each(|chunk| chunk.fill(T::ZERO));
                    idle
                }
                None => CellField::new(layout),
            };
        }
    }

    /// Takes arrays back, which are empty then. Without a pool nothing happens.
    pub fn release<'a>(&self, arrays: impl IntoIterator<Item = &'a mut CellField<T>>) {
        let Some(pool) = &self.0 else { return };
        let mut idle = pool.lock().unwrap_or_else(PoisonError::into_inner);
        idle.extend(arrays.into_iter().filter(|array| !array.is_empty()).map(std::mem::take));
    }

    /// Bytes of the arrays that are idle now.
    pub fn bytes(&self) -> usize {
        let idle = self.0.as_ref().map(|pool| pool.lock().unwrap_or_else(PoisonError::into_inner));
        idle.iter().flat_map(|idle| idle.iter()).map(CellField::bytes).sum()
    }

    fn take(&self, slots: usize) -> Option<CellField<T>> {
        let mut idle = self.0.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner);
        let which = idle.iter().position(|array| array.len() == slots)?;
        Some(idle.swap_remove(which))
    }
}

const CHUNK: usize = 1 << 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_come_back_as_zeros_and_are_used_again() {
        let layout = Layout::new([4, 3]).unwrap();
        let (pool, mut a, mut b) = (Pool::<f64>::new(), CellField::default(), CellField::default());
        pool.clone().fetch(&layout, [&mut a, &mut b]);
        assert_eq!((a.len(), b.len(), pool.bytes()), (layout.slots(), layout.slots(), 0));
        a.fill(3.0);
        pool.release([&mut a, &mut b]);
        assert!(a.is_empty() && b.is_empty());
        assert_eq!(pool.bytes(), 2 * 8 * layout.slots());
        let mut again = [CellField::default(), CellField::default(), CellField::default()];
        pool.fetch(&layout, &mut again);
        assert!(again.iter().all(|array| array.len() == layout.slots() && array.iter().all(|v| *v == 0.0)));
        // One of another layout is no use.
        pool.release(&mut again);
        let larger = Layout::new([4, 4]).unwrap();
        pool.fetch(&larger, [&mut a]);
        assert_eq!((a.len(), pool.bytes()), (larger.slots(), 3 * 8 * layout.slots()));
    }

    #[test]
    fn without_a_pool_arrays_stay() {
        let layout = Layout::new([2, 2]).unwrap();
        let (pool, mut a) = (Pool::<f32>::default(), CellField::default());
        pool.fetch(&layout, [&mut a]);
        a.fill(2.0);
        pool.release([&mut a]);
        pool.fetch(&layout, [&mut a]);
        assert!(a.len() == layout.slots() && a.iter().all(|v| *v == 2.0) && pool.bytes() == 0);
    }
}
