//! What the knobs of a flow change on Taylor and Green's vortices; errors, orders and energies are in `verify::vortices`.

use std::f64::consts::TAU;

use cf_fluid::exact::taylor_green;
use cf_fluid::{FlowSettings, Fluid, Scheme};
use cf_grid::{Grid, Sides};
use cf_linear::Precision;

const MOVING: [f64; 2] = [1.0, 0.5];

#[test]
fn a_loose_tolerance_and_a_cold_start_change_what_they_should() {
    let grid = Grid::<2>::new([64, 64], TAU / 64.0).unwrap();
    let count = |warm_start, eta_div| {
        let settings =
            FlowSettings { scheme: Scheme::ReflectionExtrapolated, eta_div, warm_start, ..FlowSettings::default() };
        let mut fluid = Fluid::<f64, 2>::new(&grid, &Sides::periodic(), None, settings).unwrap();
        fluid.set_velocity(&taylor_green(&grid, MOVING, 0.0).unwrap()).unwrap();
        (0..10).map(|_| fluid.step(0.025).unwrap().iterations).sum::<usize>()
    };
    let (warm, cold, loose) = (count(true, 1e-7), count(false, 1e-7), count(true, 1e-4));
    println!("iterations in 10 steps: warm {warm}, cold {cold}, loose {loose}");
    assert!(warm < cold && loose < warm);
}

#[test]
fn cycles_in_single_precision_save_memory_and_change_nothing_that_counts() {
    let grid = Grid::<2>::new([64, 64], TAU / 64.0).unwrap();
    let run = |precision| {
        let settings = FlowSettings { scheme: Scheme::Cnp, eta_div: 1e-9, precision, ..FlowSettings::default() };
        let mut fluid = Fluid::<f64, 2>::new(&grid, &Sides::periodic(), None, settings).unwrap();
        fluid.set_velocity(&taylor_green(&grid, MOVING, 0.0).unwrap()).unwrap();
        (0..5).for_each(|_| assert!(fluid.step(0.025).unwrap().divergence <= 1e-9));
        (fluid.bytes(), fluid.velocity().axis(0)[grid.layout().slot([20, 30])])
    };
    let ((full, u), (single, v)) = (run(Precision::Full), run(Precision::Single));
    assert!(single < full && (u - v).abs() < 1e-7, "{full} {single} {u} {v}");
}
