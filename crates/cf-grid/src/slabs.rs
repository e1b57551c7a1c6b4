//! What a loop may write: one field, an array of fields, a tuple of either, or nothing.

/// Mutable storage that splits at a slot. A row of it has the same type, so a loop body written for `&mut [T]` gets
/// `&mut [T]` rows. Implemented for `&mut [T]`, arrays, pairs, triples and `()`.
pub trait Slabs: Sized + Send {
    /// Splits into the first `slots` slots and the rest.
    fn split_at(self, slots: usize) -> (Self, Self);
}

impl Slabs for () {
    #[inline(always)]
    fn split_at(self, _: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<T: Send> Slabs for &mut [T] {
    #[inline(always)]
    fn split_at(self, slots: usize) -> (Self, Self) {
        self.split_at_mut(slots)
    }
}

impl<S: Slabs, const N: usize> Slabs for [S; N] {
    #[inline(always)]
    fn split_at(self, slots: usize) -> (Self, Self) {
        let mut pairs = self.map(|s| {
            let (low, high) = s.split_at(slots);
            (Some(low), Some(high))
        });
        let low = std::array::from_fn(|i| taken(&mut pairs[i].0));
        let high = std::array::from_fn(|i| taken(&mut pairs[i].1));
        (low, high)
    }
}

#[inline(always)]
fn taken<S>(half: &mut Option<S>) -> S {
    half.take().unwrap_or_else(|| unreachable!("each half is taken once"))
}

macro_rules! tuple {
    ($($s:ident $i:tt),+) => {
        impl<$($s: Slabs),+> Slabs for ($($s,)+) {
            #[inline(always)]
            fn split_at(self, slots: usize) -> (Self, Self) {
                let halves = ($(self.$i.split_at(slots),)+);
                (($(halves.$i.0,)+), ($(halves.$i.1,)+))
            }
        }
    };
}
tuple!(A 0, B 1);
tuple!(A 0, B 1, C 2);
