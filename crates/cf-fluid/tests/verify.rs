//! The tables and corners that `cargo xtask verify` prints.

use cf_diffusion::verify::Table;
use cf_fluid::verify;

fn assert_passes(table: Table) {
    assert!(table.pass() && !table.rows.is_empty(), "{table}");
}

#[test]
fn vortices() {
    assert_passes(verify::vortices());
}

#[test]
fn flows() {
    assert_passes(verify::flows());
}

#[test]
fn projector() {
    assert_passes(verify::projector());
}

#[test]
fn extremes() {
    for corner in verify::extremes(400, 20) {
        assert!(corner.pass, "{corner}");
        assert!(verify::repeat(corner.name, corner.seed).is_some_and(|case| case.unwrap() == corner.worst.max(0.0)));
    }
}
