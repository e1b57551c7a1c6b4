//! The two precisions of stored fields. Scalars (parameters, coefficients, sums) are always `f64`.

use std::fmt::{Debug, Display};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Precision of a stored field: `f32` or `f64`. Sealed.
pub trait Real:
    sealed::Sealed
    + Copy
    + Default
    + Debug
    + Display
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Distance from 1 to the next representable number, as `f64`.
    const EPSILON: f64;
    /// "f32" or "f64".
    const NAME: &'static str;
    /// Rounds an `f64` to this precision.
    fn of(value: f64) -> Self;
    /// Widens to `f64`.
    fn f64(self) -> f64;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// The same slice, if these are `f32`.
    fn f32s(x: &[Self]) -> Option<&[f32]>;
    /// The same slice, if these are `f64`.
    fn f64s(x: &[Self]) -> Option<&[f64]>;
    /// The same slice, if U is this type.
    fn same<U: Real>(x: &[U]) -> Option<&[Self]>;
}

macro_rules! real {
    ($t:ident, $slices:ident, $f32s:expr, $f64s:expr) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: f64 = $t::EPSILON as f64;
            const NAME: &'static str = stringify!($t);
            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            fn f32s(x: &[Self]) -> Option<&[f32]> {
                $f32s(x)
            }
            fn f64s(x: &[Self]) -> Option<&[f64]> {
                $f64s(x)
            }
            fn same<U: Real>(x: &[U]) -> Option<&[Self]> {
                U::$slices(x)
            }
        }
    };
}
real!(f32, f32s, Some, |_| None);
real!(f64, f64s, |_| None, Some);
