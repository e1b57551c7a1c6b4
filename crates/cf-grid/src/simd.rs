//! Loops compiled for the machine's vector registers.

/// Calls `f` compiled for the widest registers that the machine has (AVX-512 or AVX2 on x86-64), if all of it is inlined:
/// closures and functions in it need `#[inline(always)]`. The same operations in the same order: the same bits.
///
/// The loop primitives of [`Layout`](crate::Layout) go through here, so that `#[inline(always)]` on a row closure is all
/// that a kernel needs.
#[inline(always)]
pub fn vectorised<R>(f: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(f)
}

/// The closure itself: a place where one that gets a name can have `#[inline(always)]`, as arguments of calls can.
#[inline(always)]
pub fn inlined<F>(f: F) -> F {
    f
}

/// `[f(0), f(1), ..]`. Unlike `std::array::from_fn` it is inlined wherever it stands, which is what row kernels need.
#[inline(always)]
pub fn array<const N: usize, V: Copy + Default>(f: impl Fn(usize) -> V) -> [V; N] {
    let mut array = [V::default(); N];
    for i in 0..N {
        array[i] = f(i);
    }
    array
}
