//! Hydrostatics, streams, walls, energy around obstacles; dipoles and other flows are in `verify::vortices` and `verify::flows`.

use std::f64::consts::{PI, TAU};

use cf_fluid::exact::taylor_green;
use cf_fluid::{Buoyancy, FlowSettings, FlowWall, Fluid, Scheme, Shape, obstacles, verify};
use cf_grid::{Axis, CellField, FaceField, Grid, Sides};

const SCHEMES: [Scheme; 4] = [Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft, Scheme::CentralRk4];

fn settings<const D: usize>(scheme: Scheme, eta_div: f64) -> FlowSettings<D> {
    FlowSettings { scheme, eta_div, ..FlowSettings::default() }
}

/// Steady vortices between slip walls: the same flow as in the periodic box, with a wall where it has planes of symmetry.
#[test]
fn walls_are_planes_of_symmetry() {
    for (scheme, bound) in [(Scheme::Cnp, 4e-4), (Scheme::ReflectionExtrapolated, 4e-4), (Scheme::Draft, 5e-2)] {
        let error = |n: usize, closed: bool| {
            let grid = Grid::<2>::new([n, n], TAU / n as f64).unwrap().with_origin([0.5 * PI, 0.5 * PI]).unwrap();
            let sides = if closed { Sides::all(FlowWall::Closed) } else { Sides::periodic() };
            let mut fluid = Fluid::<f64, 2>::new(&grid, &sides, None, settings(scheme, 1e-10)).unwrap();
            let start = taylor_green(&grid, [0.0; 2], 0.0).unwrap();
            fluid.set_velocity(&start).unwrap();
            for _ in 0..n * 41 / 64 {
                fluid.step(2.0 / (n * 41 / 64) as f64).unwrap();
            }
            let mut sum = [0.0; 2];
            for a in 0..2 {
                grid.layout().each_cell(grid.layout().cells_region(), |at| {
                    let (u, v) = (fluid.velocity().axis(a)[at.slot()], start.axis(a)[at.slot()]);
                    sum[0] += (u - v).powi(2);
                    sum[1] += v * v;
                });
            }
            (sum[0] / sum[1]).sqrt()
        };
        let (walls, ring, fine) = (error(64, true), error(64, false), error(128, true));
        println!("{scheme:?}: closed {walls:.2e}, periodic {ring:.2e}, closed at 128 {fine:.2e}");
        assert!(walls < bound && walls < 1.5 * ring + 1e-12, "{scheme:?}");
        assert!(fine < 0.55 * walls, "{scheme:?}");
    }
}

#[test]
fn a_constant_force_or_a_stratified_fluid_moves_nothing() {
    let grid = Grid::<2>::new([12, 20], 0.1).unwrap();
    let mask = obstacles(&grid, &[Shape::Sphere { center: [0.6, 0.9], radius: 0.25 }]).unwrap();
    let mut phi = CellField::<f64>::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| (0.3 * at.cell[1] as f64).sin());
    for scheme in SCHEMES {
        for mask in [None, Some(&mask)] {
            let buoyancy = Buoyancy { strength: 3.0, reference: 0.2, up: [0.0, 1.0] };
            let choice = FlowSettings { force: [0.0, -9.81], buoyancy: Some(buoyancy), ..settings(scheme, 1e-9) };
            let mut fluid = Fluid::new(&grid, &Sides::all(FlowWall::Closed), mask, choice).unwrap();
            for _ in 0..10 {
                fluid.begin(0.01, Some(&phi), &mut ()).unwrap();
                let report = fluid.finish(Some(&phi), &mut ()).unwrap();
                assert!(report.divergence <= 1e-9);
            }
            // 10 steps of 0.01 s at 10 m/s² would give 1 m/s.
            assert!(fluid.max_speed() < 2e-7, "{scheme:?}: {}", fluid.max_speed());
        }
        // The same force in a box with an open top falls freely through a periodic one.
        let choice = FlowSettings { force: [0.0, -9.81], ..settings(scheme, 1e-9) };
        let mut fluid = Fluid::<f64, 2>::new(&grid, &Sides::periodic(), None, choice).unwrap();
        (0..10).for_each(|_| assert!(fluid.step(0.01).unwrap().divergence <= 1e-9));
        let slot = grid.layout().slot([3, 3]);
        assert!((fluid.velocity().axis(1)[slot] + 0.981).abs() < 1e-9);
    }
}

#[test]
fn light_fluid_rises() {
    let grid = Grid::<2>::new([16, 32], 0.1).unwrap();
    let mut phi = CellField::<f64>::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| f64::from(at.cell[0].abs_diff(8) < 3 && at.cell[1].abs_diff(8) < 3));
    for scheme in SCHEMES {
        let buoyancy = Some(Buoyancy { strength: 1.0, reference: 0.0, up: [0.0, 1.0] });
        let choice = FlowSettings { buoyancy, ..settings(scheme, 1e-8) };
        let mut fluid = Fluid::new(&grid, &Sides::all(FlowWall::Closed), None, choice).unwrap();
        assert!(fluid.step(0.1).is_err(), "buoyancy without phi");
        assert!((fluid.buoyancy_dt(&phi) - 0.1f64.sqrt()).abs() < 1e-12);
        fluid.begin(0.1, Some(&phi), &mut ()).unwrap();
        fluid.finish(Some(&phi), &mut ()).unwrap();
        let v = fluid.velocity().axis(1)[grid.layout().slot([8, 9])];
        assert!(v > 0.03 && v < 0.1, "{scheme:?}: {v}");
    }
}

fn stream<const D: usize>(speed: f64) -> Sides<FlowWall<D>, D> {
    let mut u = [0.0; D];
    u[0] = speed;
    let mut sides = Sides::all(FlowWall::Open(u));
    sides.0[0] = Axis::Walls([FlowWall::Inflow(u), FlowWall::Open(u)]);
    sides
}

#[test]
fn a_uniform_stream_through_an_open_box_stays_what_it_is() {
    let grid = Grid::<3>::new([12, 9, 10], 0.1).unwrap();
    for scheme in SCHEMES {
        for speed in [0.4, -0.4] {
            let sides = stream::<3>(speed);
            let mut fluid = Fluid::<f64, 3>::new(&grid, &sides, None, settings(scheme, 1e-6)).unwrap();
            let mut start = FaceField::new(grid.layout());
            start.axis_mut(0).fill(speed);
            fluid.set_velocity(&start).unwrap();
            for dt in [0.1, 0.2, 0.2, 0.05] {
                assert_eq!(fluid.step(dt).unwrap().imbalance, 0.0);
            }
            for a in 0..3 {
                grid.layout().each_cell(grid.layout().faces_region(a, false), |at| {
                    let expected = if a == 0 { speed } else { 0.0 };
                    let found = fluid.velocity().axis(a)[at.slot()];
                    assert!((found - expected).abs() < 1e-13, "{scheme:?} {speed} {found} {:?}", at.cell);
                });
            }
        }
    }
}

/// Energy around obstacles in a closed box, which the model's tables leave out.
#[test]
fn obstacles_add_no_energy() {
    let n = 48;
    let grid = Grid::<2>::new([n, n], 1.0 / n as f64).unwrap();
    let shapes = [
        Shape::Sphere { center: [0.3, 0.35], radius: 0.12 },
        Shape::Box { low: [0.6, 0.55], high: [0.75, 0.8] },
        Shape::Box { low: [0.0, 0.7], high: [0.3, 0.72] },
    ];
    let mask = obstacles(&grid, &shapes).unwrap();
    for (scheme, cfls) in [
        (Scheme::Cnp, [0.5, 1.0]),
        (Scheme::ReflectionExtrapolated, [1.0, 5.0]),
        (Scheme::Auto, [2.0, 20.0]),
        (Scheme::Draft, [1.0, 5.0]),
    ] {
        for cfl in cfls {
            let mut fluid =
                Fluid::<f64, 2>::new(&grid, &Sides::all(FlowWall::Closed), Some(&mask), settings(scheme, 1e-6))
                    .unwrap();
            fluid.set_velocity(&verify::random_flow(n, 4, false).unwrap()).unwrap();
            let start = fluid.kinetic_energy();
            let dt = cfl * grid.h() / fluid.max_speed();
            let end = 10.0 * 0.25 / fluid.max_speed();
            let (mut time, mut most, mut iterations, mut steps) = (0.0, 0f64, 0, 0);
            while time < end {
                let report = fluid.step(dt).unwrap();
                assert!(report.divergence <= 1e-6);
                iterations += report.iterations;
                steps += 1;
                time += dt;
                most = most.max(fluid.kinetic_energy() / start);
            }
            let kept = fluid.kinetic_energy() / start;
            let per = iterations as f64 / steps as f64;
            println!("obstacles {scheme:?} CFL {cfl}: kept {kept:.3}, most {most:.4}, {per:.1} iterations a step");
            assert!(most < 1.003, "{scheme:?} CFL {cfl}: {most}");
        }
    }
}
