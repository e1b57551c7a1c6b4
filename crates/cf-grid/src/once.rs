//! Generic code that is compiled once.

use std::any::Any;

/// The table that has type `E`, of one for each precision and dimension there is.
///
/// A crate that is generic over both would compile what it calls in a generic crate below again, once for every
/// combination and every set of vector registers. Where the lower crate keeps pointers to its costly functions in
/// statics, these are compiled there, and its generic functions only look up which of them to call:
///
/// ```
/// use cf_grid::{Real, once};
///
/// struct Table<T, const D: usize>(fn(&[T]) -> f64);
/// impl<T: Real, const D: usize> Table<T, D> {
///     const HERE: Self = Self(costly::<T, D>);
/// }
/// static TABLES: (Table<f32, 2>, Table<f64, 2>, Table<f32, 3>, Table<f64, 3>) =
///     (Table::HERE, Table::HERE, Table::HERE, Table::HERE);
///
/// pub fn cheap<T: Real, const D: usize>(x: &[T]) -> f64 {
///     let t = &TABLES;
///     once::<Table<T, D>>([&t.0, &t.1, &t.2, &t.3]).0(x)
/// }
/// # fn costly<T: Real, const D: usize>(x: &[T]) -> f64 { x.iter().map(|v| v.f64()).sum() }
/// assert_eq!(cheap::<f32, 3>(&[1.0, 2.0]), 3.0);
/// ```
///
/// # Panics
/// If there is no such table: a fault of the crate that has them, not of any input.
pub fn once<E: 'static>(tables: [&'static dyn Any; 4]) -> &'static E {
    let found = tables.into_iter().find_map(<dyn Any>::downcast_ref);
    found.expect("a table for f32 and f64 in two and three dimensions")
}
