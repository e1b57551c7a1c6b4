//! `model.mask`: solid cells from a file of bytes.

use super::Checker;
use crate::error::{Detail, shorten};
use crate::scene::Grid;
use crate::solid::MaskFile;
use crate::spec::MaskSpec;
use std::path::Path;

/// The most cells of a mask file.
const MAX_CELLS: u64 = 1 << 32;

/// Reads a mask file, whose path is relative to `folder`.
pub(super) fn mask(check: &mut Checker<'_>, spec: &MaskSpec, grid: &Grid, folder: &Path) -> Option<MaskFile> {
    let cells = spec.cells.clone().unwrap_or_else(|| grid.cells.clone());
    if !check.require(cells.len() == grid.dimension(), "model.mask.cells", || {
        Detail::new(format!("the grid has {} axes", grid.dimension()))
            .expected(format!("{} numbers", grid.dimension()))
            .found(cells.len().to_string())
    }) {
        return None;
    }
    let count = cells.iter().try_fold(1u64, |product, n| product.checked_mul(*n as u64));
    let Some(count) = count.filter(|count| (1..=MAX_CELLS).contains(count)) else {
        let detail = Detail::new("a mask of this size cannot be read").expected(format!("1 to {MAX_CELLS} cells"));
        check.fail("model.mask.cells", detail.found(cells.to_string()));
        return None;
    };
    let path = folder.join(&spec.file);
    let shown = shorten(&spec.file);
    let unreadable = |error: std::io::Error| {
        Detail::new(format!("the mask file `{shown}` cannot be read: {error}"))
            .expected("a file of bytes; its path is relative to the scene's file")
    };
    let length = match std::fs::metadata(&path) {
        Ok(data) if data.is_file() => data.len(),
        Ok(_) => {
            check.fail("model.mask.file", Detail::new(format!("`{shown}` is not a file")).expected("a file of bytes"));
            return None;
        }
        Err(error) => {
            check.fail("model.mask.file", unreadable(error));
            return None;
        }
    };
    if !check.require(length == count, "model.mask.file", || {
        Detail::new(format!("the mask file `{shown}` has another size"))
            .expected(format!("{count} bytes, one for each cell of {cells}"))
            .found(format!("{length} bytes"))
            .advice("give model.mask.cells where the mask has a grid of its own")
    }) {
        return None;
    }
    match std::fs::read(&path) {
        Ok(bytes) => Some(MaskFile { file: spec.file.clone(), cells, bytes: bytes.into() }),
        Err(error) => {
            check.fail("model.mask.file", unreadable(error));
            None
        }
    }
}
