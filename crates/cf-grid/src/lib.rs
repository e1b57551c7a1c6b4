//! Where values live: padded boxes of cells, fields on their cells and faces, walls, and the loops over them.
//!
//! A [`Layout`] is a box of `[usize; D]` cells (`D` = 2 or 3), stored with `x` contiguous and a one-cell rim on every
//! side. Cells and faces share its slot numbers: face `a` of a cell is its low face along axis `a`, and the face on the
//! high wall sits in the rim slot behind the last cell. The seam face of a periodic axis is stored once, at the low slot.
//!
//! ```text
//!        rim | cell 0 | cell 1 | … | cell n-1 | rim
//!            f0       f1       f2            fn          faces of this axis; f_i is the low face of cell i
//! ```
//!
//! Values live in [`CellField`] and [`FaceField`]; both are plain slices to every kernel. Loops come in two kinds:
//! [`Layout::par_cells`] for code that needs one value per cell, and [`Layout::par_runs`] for stencils, which hands out
//! whole rows and their equally long neighbour rows, so that no physics holds an index stride. Both split the outermost
//! axis by size alone and combine partial results in the order of that tree: every result has the same bits for any
//! number of threads. [`Layout::par_rows_in_place`] is the variant for coloured relaxation.
//!
//! What happens at the box's surface is a [`Sides`] value: periodicity belongs to an axis, a [`Wall`] to an end of one.
//! Obstacles are a [`Mask`] with its connected [components](Mask::components).
//!
//! ```
//! use cf_grid::{CellField, Layout};
//! let layout = Layout::new([8, 4])?;
//! let mut phi = CellField::<f64>::new(&layout);
//! layout.par_cells(&mut phi, |at| at.cell[0] as f64);
//! let mut slope = CellField::<f64>::new(&layout);
//! layout.par_runs(layout.cells_region(), &mut slope[..], |run, out: &mut [f64]| {
//!     let (low, high) = (run.low(0, &phi), run.row(&phi));
//!     for i in 1..out.len() {
//!         out[i] = high[i] - low[i];
//!     }
//! });
//! assert_eq!(layout.sum(&slope), 7.0 * 4.0);
//! # Ok::<(), cf_grid::GridError>(())
//! ```

mod error;
mod field;
mod grid;
mod in_place;
mod join;
mod layout;
mod mask;
mod once;
mod pool;
mod real;
mod reduce;
mod run;
mod sides;
mod simd;
mod slabs;
mod sweep;

pub use error::GridError;
pub use field::{CellField, FaceField};
pub use grid::Grid;
pub use in_place::Near;
pub use join::join;
pub use layout::{Layout, Region};
pub use mask::{Components, Mask};
pub use once::once;
pub use pool::Pool;
pub use real::Real;
pub use reduce::{Max, Reduce, row_dot, row_sum};
pub use run::{At, Run};
pub use sides::{Axis, End, Sides, Wall};
pub use simd::{array, inlined, vectorised};
pub use slabs::Slabs;
