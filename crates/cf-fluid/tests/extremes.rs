//! What no scene should ask for, and what happens then.

use cf_fluid::{FlowError, FlowSettings, FlowWall, Fluid, Interpolation, Scheme, Shape, Transport, obstacles};
use cf_grid::{Axis, CellField, FaceField, Grid, Mask, Real, Sides};

use crate::common::{random_faces, wall_mixes};

const SCHEMES: [Scheme; 5] =
    [Scheme::Auto, Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft, Scheme::CentralRk4];

fn flow<T: Real, const D: usize>(
    cells: [usize; D],
    sides: Sides<FlowWall<D>, D>,
    mask: Option<&Mask<D>>,
    scheme: Scheme,
) -> Fluid<T, D> {
    let grid = Grid::new(cells, 0.1).unwrap();
    Fluid::new(&grid, &sides, mask, FlowSettings { scheme, ..FlowSettings::default() }).unwrap()
}

#[test]
fn semi_lagrangian_steps_of_any_length() {
    for sides in wall_mixes::<2>() {
        for scheme in [Scheme::Auto, Scheme::ReflectionExtrapolated, Scheme::Draft] {
            let mut fluid = flow::<f64, 2>([17, 12], sides, None, scheme);
            fluid.set_velocity(&random_faces(fluid.grid().layout(), 1)).unwrap();
            let start = fluid.kinetic_energy();
            for cfl in [1e3, 1e2, 1e3, 3.0] {
                let dt = fluid.dt_for(cfl).min(1e6);
                let report = fluid.step(dt).unwrap();
                assert!(report.divergence <= 1e-4 || report.at_floor, "{report:?}");
                assert!(fluid.max_speed().is_finite());
            }
            let inflow = sides.walls().any(|(_, _, w)| matches!(w, FlowWall::Inflow(_)));
            assert!(inflow || fluid.kinetic_energy() <= 1.01 * start, "{scheme:?}");
        }
    }
}

#[test]
fn no_step_changes_nothing() {
    for scheme in SCHEMES {
        let mut fluid = flow::<f64, 2>([9, 8], Sides::periodic(), None, scheme);
        fluid.set_velocity(&random_faces(fluid.grid().layout(), 1)).unwrap();
        fluid.step(0.01).unwrap();
        let before = fluid.velocity().clone();
        let report = fluid.step(0.0).unwrap();
        assert_eq!((report.projections, report.iterations), (0, 0));
        assert_eq!(*fluid.velocity(), before);
        fluid.step(1e-300).unwrap();
        assert!(matches!(fluid.step(-1.0), Err(FlowError::TimeStep(_))));
        assert!(matches!(fluid.step(f64::NAN), Err(FlowError::TimeStep(_))));
    }
}

#[test]
fn fluid_at_rest_stays_at_rest() {
    for scheme in SCHEMES {
        let mut fluid = flow::<f32, 3>([5, 4, 3], Sides::all(FlowWall::Closed), None, scheme);
        let report = fluid.step(10.0).unwrap();
        assert_eq!((report.iterations, fluid.max_speed(), report.courant), (0, 0.0, 0.0));
        assert_eq!(fluid.dt_for(0.5), f64::INFINITY);
    }
}

#[test]
fn domains_of_one_cell() {
    for scheme in SCHEMES {
        for cells in [[1, 1], [1, 5], [4, 1], [2, 2]] {
            for sides in wall_mixes::<2>() {
                let mut fluid = flow::<f64, 2>(cells, sides, None, scheme);
                fluid.set_velocity(&random_faces(fluid.grid().layout(), 1)).unwrap();
                for _ in 0..3 {
                    let report = fluid.step(0.02).unwrap();
                    assert!(report.divergence <= 1e-4 || report.at_floor, "{scheme:?} {cells:?} {sides:?} {report:?}");
                }
            }
        }
        let mut fluid = flow::<f64, 3>([1, 1, 1], Sides::periodic(), None, scheme);
        fluid.set_velocity(&random_faces(fluid.grid().layout(), 1)).unwrap();
        fluid.step(0.3).unwrap();
    }
}

#[test]
fn closed_pockets_are_still() {
    let grid = Grid::<2>::new([16, 12], 0.1).unwrap();
    let ring = Mask::new(grid.layout(), |c| {
        let r = c[0].abs_diff(8).max(c[1].abs_diff(6));
        r != 3 && c != [1, 2] && c != [2, 1] && c != [0, 1] && c != [1, 0]
    });
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0]), FlowWall::OPEN]);
    for scheme in SCHEMES {
        let mut fluid = flow::<f64, 2>([16, 12], sides, Some(&ring), scheme);
        for _ in 0..5 {
            let report = fluid.step(0.03).unwrap();
            assert!(report.divergence <= 1e-4, "{scheme:?}");
            // The inflow into the corner that a solid closes has nowhere to go, and is reported.
            assert!(report.imbalance > 1.0, "{report:?}");
        }
        let inside = grid.layout().slot([8, 6]);
        assert!(fluid.velocity().axis(0)[inside].abs() < 1e-4);
        assert!(fluid.velocity().axis(0)[grid.layout().slot([4, 11])] > 0.5);
    }
}

#[test]
fn opposing_jets() {
    // Two inflows against each other, out through the sides.
    let mut sides = Sides::all(FlowWall::OPEN);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0]), FlowWall::Inflow([-1.0, 0.0])]);
    for scheme in [Scheme::Auto, Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft] {
        let mut fluid = flow::<f32, 2>([32, 32], sides, None, scheme);
        for _ in 0..60 {
            let dt = fluid.dt_for(0.9);
            let report = fluid.step(dt).unwrap();
            assert!(report.divergence <= 1e-4 && report.imbalance == 0.0, "{scheme:?} {report:?}");
        }
        println!("opposing jets {scheme:?}: max|u| {:.3}", fluid.max_speed());
        assert!(fluid.max_speed() < 3.0, "{scheme:?}: {}", fluid.max_speed());
    }
    // The same without an exit cannot be.
    sides.0[1] = Axis::Walls([FlowWall::Closed; 2]);
    let mut fluid = flow::<f32, 2>([32, 32], sides, None, Scheme::Cnp);
    let report = fluid.step(0.01).unwrap();
    assert!((report.imbalance - 2.0 / 3.2).abs() < 1e-3, "{report:?}");
}

#[test]
fn a_step_is_begun_and_finished_in_turn() {
    let mut fluid = flow::<f64, 2>([4, 4], Sides::periodic(), None, Scheme::Auto);
    assert!(matches!(fluid.finish(None, &mut ()), Err(FlowError::Order(_))));
    fluid.begin(0.1, None, &mut ()).unwrap();
    assert!(matches!(fluid.begin(0.1, None, &mut ()), Err(FlowError::Order(_))));
    fluid.abandon();
    fluid.step(0.1).unwrap();
    let nan = FlowSettings::<2> { eta_div: f64::NAN, ..FlowSettings::default() };
    let grid = Grid::new([4, 4], 1.0).unwrap();
    assert!(matches!(Fluid::<f64, 2>::new(&grid, &Sides::periodic(), None, nan), Err(FlowError::Setting { .. })));
    let wind = Sides::all(FlowWall::Open([f64::NAN, 0.0]));
    let error = Fluid::<f64, 2>::new(&grid, &wind, None, FlowSettings::default()).err().unwrap();
    assert!(matches!(error, FlowError::Wall { axis: 0, component: 0, .. }), "{error}");
}

#[test]
fn threads_change_no_bit() {
    let grid = Grid::<3>::new([40, 24, 33], 0.1).unwrap();
    let mask = obstacles(&grid, &[Shape::Sphere { center: [2.0, 1.2, 1.6], radius: 0.5 }]).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut fluid = flow::<f32, 3>([40, 24, 33], Sides::all(FlowWall::Closed), Some(&mask), Scheme::Auto);
            fluid.set_velocity(&random_faces(grid.layout(), 1)).unwrap();
            (0..3).for_each(|_| assert!(fluid.step(0.08).is_ok()));
            fluid.velocity().clone()
        })
    };
    let (one, three) = (run(1), run(3));
    for a in 0..3 {
        assert!(one.axis(a).iter().zip(three.axis(a)).all(|(x, y)| x.to_bits() == y.to_bits()), "axis {a}");
    }
}

#[test]
fn a_cell_value_moves_with_the_stream() {
    let grid = Grid::<2>::new([40, 8], 0.1).unwrap();
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0]), FlowWall::OPEN]);
    let mut transport = Transport::<f32, 2>::new(&grid, &sides, None, |_, _| 5.0);
    let mut by = FaceField::new(grid.layout());
    by.axis_mut(0).fill(1.0);
    for how in [Interpolation::Linear, Interpolation::Cubic, Interpolation::MacCormack] {
        let mut phi = CellField::<f32>::new(grid.layout());
        grid.layout().par_cells(&mut phi, |at| at.cell[0] as f32);
        transport.cells(&mut phi, &mut by, 0.25, how);
        grid.layout().each_cell(grid.layout().cells_region(), |at| {
            let found = phi[at.slot()];
            let expected = at.cell[0] as f32 - 2.5;
            let good = if expected < -0.5 { found == 5.0 } else { expected < 1.0 || (found - expected).abs() < 1e-4 };
            assert!(good, "{how:?} {:?}: {found}", at.cell);
        });
    }
}

#[test]
fn a_small_stack_is_enough() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).stack_size(512 << 10).build().unwrap();
    let courant = pool.install(|| {
        let mut fluid = flow::<f64, 3>([24, 20, 80], Sides::periodic(), None, Scheme::Cnp);
        fluid.set_velocity(&random_faces(fluid.grid().layout(), 1)).unwrap();
        fluid.step(fluid.dt_for(0.5)).unwrap().courant
    });
    assert!((courant - 0.5).abs() < 1e-9);
}
