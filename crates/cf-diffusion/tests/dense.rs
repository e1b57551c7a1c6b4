//! Whole steps against an independent dense solve: every wall, obstacles, sources.

use cf_diffusion::verify::{Case, Random, dense_step};
use cf_diffusion::{Integrator, Law, Medium, Source, State};
use cf_grid::{Axis, Mask, Sides, Wall};

/// The walls of the test, for a law of speed about 1.
const WALLS: [Wall; 6] = [
    Wall::CLOSED,
    Wall::Flux(-0.7),
    Wall::Value(1.3),
    Wall::Value(-0.4),
    Wall::Absorbing { speed: 0.9, far: 0.6 },
    Wall::Open { inflow: 2.0 },
];

/// The worst difference of phi, q_C (in units of phi) and the outflow, relative.
fn compare<const D: usize>(case: &Case<D>, random: &mut Random) -> f64 {
    let start = case.random_state::<f64>(random, 1.0, case.flux_unit());
    let rate = case.random_state::<f64>(random, 1.0 / case.dt, 0.0).phi;
    let source = Source::during(&rate[..], 0.6);
    let (expected, outflow) = dense_step(case, &start, source).unwrap();
    let mut state = start.clone();
    let report = case.stepper::<f64>().unwrap().step(&mut state, &Medium::Still, source, case.dt).unwrap();
    let layout = *case.grid.layout();
    let size = 1.0 + layout.max_abs(&expected.phi);
    let mut worst: f64 = 0.0;
    layout.each_cell(layout.cells_region(), |at| {
        worst = worst.max((state.phi[at.slot()] - expected.phi[at.slot()]).abs() / size);
        if !case.is_fluid(at.slot()) {
            assert_eq!(state.phi[at.slot()].to_bits(), start.phi[at.slot()].to_bits());
        }
    });
    if let (Some(q), Some(other)) = (&state.slow_flux, &expected.slow_flux) {
        for a in 0..D {
            layout.each_cell(layout.faces_region(a, case.sides.is_periodic(a)), |at| {
                let off = (q.axis(a)[at.slot()] - other.axis(a)[at.slot()]).abs();
                worst = worst.max(off / case.flux_unit() / size);
            });
        }
    }
    let volume = case.grid.cell_volume();
    worst.max((report.outflow - outflow).abs() / (outflow.abs() + volume * layout.count() as f64))
}

fn all_walls<const D: usize>(cells: [usize; D], mask: impl Fn([usize; D]) -> bool, masked: bool) {
    let mut random = Random(11);
    let mut worst: f64 = 0.0;
    for round in 0..90 {
        let (tau, share) = random.pick([(0.4, 0.0), (0.4, 0.3), (0.0, 0.0), (3.0, 1.0), (1e-7, 0.0)]);
        let law = Law::new(0.8, tau, share).unwrap();
        let integrator = [Integrator::PaperBe, Integrator::Sdirk2][round % 2];
        // kappa up to a few hundred.
        let dt = random.decades(-2.0, 0.6);
        let mut case = Case::new(cells, 0.11, law, integrator, dt).unwrap();
        case.sides = Sides(std::array::from_fn(|_| match random.below(4) {
            0 => Axis::Periodic,
            _ => Axis::Walls([random.pick(WALLS), random.pick(WALLS)]),
        }));
        case.mask = masked.then(|| Mask::new(case.grid.layout(), &mask));
        worst = worst.max(compare(&case, &mut random));
    }
    assert!(worst < 1e-12, "{worst:.2e}");
}

#[test]
fn boxes_with_every_wall() {
    all_walls([7, 7], |_| true, false);
    all_walls([4, 4, 4], |_| true, false);
    all_walls([1, 7], |_| true, false);
    all_walls([2, 1, 3], |_| true, false);
}

#[test]
fn obstacles_pockets_and_enclosed_cells() {
    // A ring around one cell, a bar that cuts off a corner, single solids.
    let ring = |x: usize, y: usize| x.abs_diff(4) <= 1 && y.abs_diff(4) <= 1 && (x, y) != (4, 4);
    all_walls([7, 7], |c| !(ring(c[0], c[1]) || c[0] + c[1] == 2), true);
    all_walls([4, 4, 4], |c| !(c[0] == 1 && c[1] < 3 || c == [3, 3, 2] || c[0] + c[1] + c[2] == 8), true);
}

#[test]
fn without_fluid_nothing_happens() {
    for integrator in [Integrator::PaperBe, Integrator::Sdirk2, Integrator::Kdk] {
        let mut case = Case::new([4, 3], 0.1, Law::cattaneo(1.0, 1.0).unwrap(), integrator, 0.01).unwrap();
        case.sides = Sides::all(Wall::Value(1.0));
        case.mask = Some(Mask::new(case.grid.layout(), |_| false));
        let start = case.random_state::<f64>(&mut Random(1), 1.0, 1.0);
        let mut state = start.clone();
        let report = case.run(&mut state, 2).unwrap();
        assert_eq!((numbers(&case, &state), report.outflow), (numbers(&case, &start), 0.0));
    }
}

#[test]
fn what_solids_hold_does_not_matter() {
    for integrator in [Integrator::PaperBe, Integrator::Sdirk2, Integrator::Kdk] {
        for dt in [0.001, 1e4] {
            if integrator == Integrator::Kdk && dt > 1.0 {
                continue;
            }
            let mut case = Case::new([5, 6], 0.1, Law::cattaneo(1.0, 1.0).unwrap(), integrator, dt).unwrap();
            case.mask = Some(Mask::new(case.grid.layout(), |c| c[0] != 2 || c[1] == 0));
            let mut quiet = case.random_state::<f64>(&mut Random(4), 1.0, 1.0);
            let solid = case.grid.layout().slot([2, 3]);
            quiet.phi[solid] = 0.0;
            let mut loud = quiet.clone();
            loud.phi[solid] = 1e300;
            case.run(&mut quiet, 3).unwrap();
            case.run(&mut loud, 3).unwrap();
            assert_eq!(loud.phi[solid], 1e300);
            loud.phi[solid] = 0.0;
            assert_eq!(numbers(&case, &quiet), numbers(&case, &loud), "{integrator:?}");
        }
    }
}

/// phi and q_C of every cell, without the rims, which mirror solids too.
fn numbers(case: &Case<2>, state: &State<f64, 2>) -> Vec<f64> {
    let layout = case.grid.layout();
    let mut all = Vec::new();
    layout.each_cell(layout.cells_region(), |at| {
        let q = state.slow_flux.as_ref().map(|q| q.axes().map(|q| q[at.slot()]));
        all.extend(std::iter::once(state.phi[at.slot()]).chain(q.into_iter().flatten()));
    });
    all
}
