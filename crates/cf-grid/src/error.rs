//! What a grid refuses.

use thiserror::Error;

/// Why a layout, grid or mask could not be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GridError {
    /// Only two and three dimensions exist.
    #[error("expected 2 or 3 dimensions, found {0}")]
    Dimension(usize),
    /// An axis without cells.
    #[error("expected at least 1 cell along every axis, found {cells} along axis {axis}; give a positive cell count")]
    Empty {
        /// The axis.
        axis: usize,
        /// The cell count found.
        cells: usize,
    },
    /// More slots than memory can index.
    #[error("a box of {0:?} cells has more slots than this machine can address; reduce the cell counts")]
    TooLarge(Vec<usize>),
    /// A spacing that is not a positive finite length.
    #[error("expected a positive finite grid spacing, found {0}")]
    Spacing(f64),
    /// An origin that is not finite.
    #[error("expected a finite origin, found {value} along axis {axis}")]
    Origin {
        /// The axis.
        axis: usize,
        /// The value found.
        value: f64,
    },
    /// A field of another layout.
    #[error("expected a field of {expected} slots, found {found}; both must come from the same layout")]
    Length {
        /// Slots of the layout.
        expected: usize,
        /// Slots of the field.
        found: usize,
    },
}
