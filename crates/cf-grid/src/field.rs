//! Fields: values on cells and on faces, one number per slot.

use std::ops::{Deref, DerefMut};

use crate::{Layout, Real};

/// One value per cell, stored by slot (rim included). A plain slice to every kernel. The default is empty: the place of an
/// array that is elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct CellField<T>(Vec<T>);

impl<T> Default for CellField<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: Real> CellField<T> {
    /// Zeros on a layout.
    pub fn new<const D: usize>(layout: &Layout<D>) -> Self {
        Self(vec![T::ZERO; layout.slots()])
    }

    /// Bytes of storage.
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(&self.0[..])
    }
}

impl<T> Deref for CellField<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T> DerefMut for CellField<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.0
    }
}

/// One normal component per face and axis: component `a` lives on faces normal to axis `a`, at the slot of the cell
/// above the face.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceField<T, const D: usize>([CellField<T>; D]);

impl<T, const D: usize> Default for FaceField<T, D> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| CellField::default()))
    }
}

impl<T: Real, const D: usize> FaceField<T, D> {
    /// Zeros on a layout.
    pub fn new(layout: &Layout<D>) -> Self {
        Self(std::array::from_fn(|_| CellField::new(layout)))
    }

    /// Component `axis` by slot.
    pub fn axis(&self, axis: usize) -> &[T] {
        &self.0[axis]
    }

    /// Component `axis` by slot, mutable.
    pub fn axis_mut(&mut self, axis: usize) -> &mut [T] {
        &mut self.0[axis]
    }

    /// All components.
    pub fn axes(&self) -> [&[T]; D] {
        std::array::from_fn(|a| &self.0[a][..])
    }

    /// All components, mutable.
    pub fn axes_mut(&mut self) -> [&mut [T]; D] {
        self.0.each_mut().map(|f| &mut f[..])
    }

    /// The components as fields, for swapping storage.
    pub fn fields_mut(&mut self) -> &mut [CellField<T>; D] {
        &mut self.0
    }

    /// Bytes of storage.
    pub fn bytes(&self) -> usize {
        self.0.iter().map(CellField::bytes).sum()
    }
}
