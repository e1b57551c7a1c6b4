//! One value per axis, written `(x, y)` or `(x, y, z)`, or `(x)` in one dimension.

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Deref;

/// One to three values, one per axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axes<T>(Vec<T>);

impl<T: Copy> Axes<T> {
    /// The same value for every axis.
    pub fn splat(value: T, dimension: usize) -> Self {
        Axes(vec![value; dimension])
    }

    /// The values as an array, if there are `D` of them.
    pub fn to_array<const D: usize>(&self) -> Option<[T; D]> {
        self.0.as_slice().try_into().ok()
    }
}

impl<T> Deref for Axes<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<T> FromIterator<T> for Axes<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Axes(values.into_iter().collect())
    }
}

impl<T: fmt::Display> fmt::Display for Axes<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, value) in self.0.iter().enumerate() {
            write!(f, "{}{value}", if i == 0 { "(" } else { ", " })?;
        }
        f.write_str(")")
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Axes<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_tuple(3, AxesVisitor(PhantomData))
    }
}

struct AxesVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for AxesVisitor<T> {
    type Value = Axes<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("one number per axis, (x, y) or (x, y, z)")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Axes<T>, A::Error> {
        let mut values = Vec::with_capacity(3);
        while let Some(value) = seq.next_element()? {
            values.push(value);
            if values.len() > 3 {
                return Err(A::Error::invalid_length(4, &self));
            }
        }
        if values.is_empty() { Err(A::Error::invalid_length(0, &self)) } else { Ok(Axes(values)) }
    }
}
