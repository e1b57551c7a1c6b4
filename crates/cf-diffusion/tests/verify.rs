//! The tables of `verify`, asserted row by row.

use cf_diffusion::verify::{self, Table};

fn assert_passes(table: Table) {
    println!("{table}");
    assert!(!table.rows.is_empty() && table.pass(), "{table}");
}

#[test]
fn one_step_is_its_matrix_on_every_mode() {
    assert_passes(verify::amplification());
}

#[test]
fn orders_are_as_promised() {
    assert_passes(verify::orders());
}

#[test]
fn mass_stays_and_energy_decays() {
    assert_passes(verify::conservation());
}

#[test]
fn few_iterations_at_any_kappa() {
    assert_passes(verify::iterations());
}

#[test]
fn nothing_breaks_at_the_edges() {
    for corner in verify::extremes(640, 20) {
        assert!(corner.pass, "{corner}");
    }
}

/// Cases of long runs that once failed: a flux that underflows in single precision, walls whose flux dwarfs what is inside,
/// a solve that stops a rounding above its goal.
#[test]
fn corners_found_before_stay_mended() {
    let found = [("h", 0x50e7_f21c_2eb0_d7f0), ("walls", 0xdb78_ebb8_8c8d_c9b0), ("long run", 0x1473_53b3_73ae_7786)];
    for (name, seed) in found {
        let worst = verify::repeat(name, seed).expect("a corner of this name").expect("it runs");
        assert!(worst <= 1.0, "{name}: {worst}");
    }
}

#[test]
fn a_case_can_be_repeated() {
    for corner in verify::extremes(64, 5) {
        let again = verify::repeat(corner.name, corner.seed).expect("a corner of this name").expect("it ran before");
        assert_eq!(again, corner.worst, "{corner}");
    }
    assert!(verify::repeat("no such corner", 1).is_none());
}
