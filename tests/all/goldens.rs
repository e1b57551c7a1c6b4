//! Every scene at a small size against its stored numbers, as `cargo xtask regress` does.

use std::sync::atomic::AtomicBool;
use xtask::{Exit, main_with};

#[test]
fn scenes_give_the_stored_numbers() {
    let exit = main_with(["xtask", "regress"], &AtomicBool::new(false));
    assert_eq!(exit, Exit::Fine, "see the table above; if the change is meant: cargo xtask regress --bless");
}
