//! `output`: colour ranges that are ranges, fields named once.

use super::{Checker, out_of_range};
use crate::error::{Detail, number};
use crate::spec::{Output, Pictures};

/// Checks what is to be written.
pub(super) fn output(check: &mut Checker<'_>, spec: &Output, dimension: usize) {
    match spec.pictures {
        Pictures::Off | Pictures::Auto => {}
        Pictures::Linear { low, high } => ordered(check, low, high),
        Pictures::Log { low, high } => {
            check.positive("output.pictures.low", low);
            ordered(check, low, high);
        }
    }
    if let Some(volume) = &spec.volume {
        check.require(dimension == 3, "output.volume", || {
            Detail::new("a cloud needs three dimensions").found(format!("a grid of {dimension}")).advice("remove it")
        });
        if let Some(high) = volume.high {
            check.require(volume.low < high, "output.volume.high", || {
                out_of_range(&format!("above low, which is {}", number(volume.low)), high)
            });
        }
        let (_, above) = volume.eye.unwrap_or_default();
        check.require((-90.0..=90.0).contains(&above), "output.volume.eye", || {
            out_of_range("(around, above) with above from -90 to 90 degrees", above)
        });
    }
    for (i, field) in spec.fields.iter().enumerate() {
        let first = !spec.fields.iter().take(i).any(|earlier| earlier == field);
        if !check.require(first, &format!("output.fields[{i}]"), || Detail::new("this field is already listed")) {
            return;
        }
    }
    check.require(!spec.vtk || !spec.fields.is_empty(), "output.fields", || {
        Detail::new("there is nothing to write").expected("at least `phi`").advice("or set vtk: false")
    });
}

fn ordered(check: &mut Checker<'_>, low: f64, high: f64) {
    check.require(low < high, "output.pictures.high", || {
        out_of_range(&format!("above low, which is {}", number(low)), high)
    });
}
