//! Dipoles, energy, hydrostatics, streams past obstacles, walls: flows whose behaviour is known.

use std::f64::consts::{PI, TAU};

use cf_diffusion::medium::stream_function;
use cf_fluid::exact::{lamb_chaplygin, taylor_green, taylor_green_3d};
use cf_fluid::{Buoyancy, FlowSettings, FlowWall, Fluid, Interpolation, Scheme, Shape, obstacles};
use cf_grid::{Axis, CellField, FaceField, Grid, Sides};
use proptest::prelude::*;

use crate::common::Noise;

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

/// The two schemes near obstacles, which the model's tables leave out: no-penetration, balance, and energy that no obstacle adds.
#[test]
fn a_stream_past_a_sphere() {
    let grid = Grid::<3>::new([48, 24, 24], 0.1).unwrap();
    let ball = Shape::Sphere { center: [1.6, 1.2, 1.2], radius: 0.5 };
    let mask = obstacles(&grid, &[ball]).unwrap();
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0, 0.0]), FlowWall::Open([1.0, 0.0, 0.0])]);
    for (scheme, cfl) in [
        (Scheme::Cnp, 0.8),
        (Scheme::ReflectionExtrapolated, 0.8),
        (Scheme::ReflectionExtrapolated, 2.5),
        (Scheme::Draft, 0.8),
    ] {
        let eta = 1e-4;
        let mut fluid = Fluid::<f32, 3>::new(&grid, &sides, Some(&mask), settings(scheme, eta)).unwrap();
        let mut start = FaceField::new(grid.layout());
        start.axis_mut(0).fill(1.0);
        fluid.set_velocity(&start).unwrap();
        // Potential flow, symmetric before and behind the sphere.
        let (first, energy) = (fluid.velocity().clone(), fluid.kinetic_energy());
        let (mut time, mut most): (f64, f64) = (0.0, 0.0);
        while time < 3.0 {
            let dt = fluid.dt_for(cfl);
            let report = fluid.step(dt).unwrap();
            assert!(report.divergence <= eta && !report.at_floor && report.imbalance == 0.0, "{report:?}");
            assert!(fluid.net_outflow().abs() * dt <= eta * 4.8 * 2.4 * 2.4);
            most = most.max(fluid.max_speed());
            time += dt;
        }
        for a in 0..3 {
            grid.layout().each_cell(grid.layout().cells_region(), |at| {
                if at.cell[a] > 0 && !(mask.fluid()[at.slot()] && mask.fluid()[at.low(a)]) {
                    assert_eq!(fluid.velocity().axis(a)[at.slot()], 0.0);
                }
            });
        }
        let (mut change, mut size) = (0.0, 0.0);
        for a in 0..3 {
            grid.layout().each_cell(grid.layout().cells_region(), |at| {
                let (u, v) = (f64::from(fluid.velocity().axis(a)[at.slot()]), f64::from(first.axis(a)[at.slot()]));
                change += (u - v).powi(2);
                size += v * v;
            });
        }
        let growth = fluid.kinetic_energy() / energy - 1.0;
        let change = (change / size).sqrt();
        println!(
            "sphere {scheme:?} CFL {cfl}: max|u| {most:.3}, energy {growth:+.2e}, distance from potential flow {change:.2e}"
        );
        assert!(most < 2.0 && growth < 1e-1 && change < 0.3, "{scheme:?}");
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
            fluid.set_velocity(&random_flow(n, 4)).unwrap();
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

#[test]
fn a_dipole_travels_at_its_speed() {
    let n = 128;
    let grid = Grid::<2>::new([n, n], 10.0 / n as f64).unwrap();
    let sides = Sides::all(FlowWall::Closed);
    // Images of the dipole in the walls, 5 R away, slow it down by O((R/L)²).
    for (scheme, cfl, slow) in [
        (Scheme::Cnp, 0.8, 0.06),
        (Scheme::ReflectionExtrapolated, 0.8, 0.06),
        (Scheme::ReflectionExtrapolated, 2.0, 0.06),
        (Scheme::CentralRk4, 0.5, 0.08),
    ] {
        let mut fluid = Fluid::<f64, 2>::new(&grid, &sides, None, settings(scheme, 1e-6)).unwrap();
        fluid.set_velocity(&lamb_chaplygin(&grid, [4.0, 5.0], 1.0, 1.0).unwrap()).unwrap();
        let (start, peak) = vortex(&grid, fluid.velocity());
        let mut time = 0.0;
        while time < 2.0 - 1e-9 {
            let dt = fluid.dt_for(cfl).min(2.0 - time);
            fluid.step(dt).unwrap();
            time += dt;
        }
        let (end, after) = vortex(&grid, fluid.velocity());
        let speed = (end[0] - start[0]) / time;
        println!("dipole {scheme:?} CFL {cfl}: speed {speed:.4}, peak vorticity {:.3}", after / peak);
        assert!((speed - 1.0).abs() < slow && (end[1] - start[1]).abs() < 1e-3, "{scheme:?}: {speed}");
        assert!(after / peak > 0.9 && after / peak < 1.1, "{scheme:?}: {}", after / peak);
    }
}

/// Centroid of |vorticity| where it counts, and its peak.
fn vortex(grid: &Grid<2>, u: &FaceField<f64, 2>) -> ([f64; 2], f64) {
    let (layout, mut moment, mut total, mut peak) = (grid.layout(), [0.0; 2], 0.0, 0f64);
    layout.each_cell(layout.cells_region(), |at| {
        if at.cell[0] == 0 || at.cell[1] == 0 {
            return;
        }
        let w =
            ((u.axis(1)[at.slot()] - u.axis(1)[at.low(0)]) - (u.axis(0)[at.slot()] - u.axis(0)[at.low(1)])) / grid.h();
        let w2 = w * w;
        total += w2;
        (0..2).for_each(|a| moment[a] += w2 * at.cell[a] as f64 * grid.h());
        peak = peak.max(w.abs());
    });
    (moment.map(|m| m / total), peak)
}

#[test]
fn vortices_in_three_dimensions() {
    let mut kept = Vec::new();
    for (scheme, n) in [
        (Scheme::CentralRk4, 32),
        (Scheme::Draft, 32),
        (Scheme::Cnp, 32),
        (Scheme::ReflectionExtrapolated, 32),
        (Scheme::Cnp, 64),
        (Scheme::ReflectionExtrapolated, 64),
    ] {
        let grid = Grid::<3>::new([n; 3], TAU / n as f64).unwrap();
        let mut fluid = Fluid::<f64, 3>::new(&grid, &Sides::periodic(), None, settings(scheme, 1e-7)).unwrap();
        fluid.set_velocity(&taylor_green_3d(&grid).unwrap()).unwrap();
        let start = fluid.kinetic_energy();
        let (mut time, mut last, mut most) = (0.0, start, 0f64);
        let dt = 0.5 * grid.h();
        while time < 2.0 {
            fluid.step(dt).unwrap();
            time += dt;
            let energy = fluid.kinetic_energy();
            // The second-order schemes gain a little while the vortices stretch; how much is measured below.
            let gains = matches!(scheme, Scheme::Cnp | Scheme::ReflectionExtrapolated);
            let monotone = gains || energy <= last * (1.0 + 1e-7);
            assert!(monotone, "{scheme:?} {n} at {time}: {energy} after {last}");
            most = most.max(energy / start - 1.0);
            last = energy;
        }
        println!(
            "3D Taylor-Green {scheme:?} n={n}: energy change {:.2e} at t = {time:.2}, most {most:.1e}",
            last / start - 1.0
        );
        assert!(most < 5e-4, "{scheme:?} {n}: {most:e}");
        kept.push(last / start - 1.0);
    }
    assert!(kept[0].abs() < 1e-5, "central: {}", kept[0]);
    assert!(kept[1] < kept[2] && kept[1] < kept[3], "draft loses most: {kept:?}");
    // What the second-order schemes gain and lose nearly cancels here: its sign changes between the two sizes.
    assert!(kept[2..].iter().all(|k| k.abs() < 5e-4), "{kept:?}");
}

/// Random smooth flow: a few waves of a stream function, zero on the walls.
fn random_flow(n: usize, seed: u64) -> FaceField<f64, 2> {
    let mut noise = Noise::new(seed);
    let waves: Vec<[f64; 4]> = (1..5)
        .flat_map(|k| (1..5).map(move |l| [f64::from(k), f64::from(l)]))
        .map(|k| [k[0], k[1], noise.next(), TAU * noise.next()])
        .collect();
    let grid = Grid::<2>::new([n, n], 1.0 / n as f64).unwrap();
    stream_function(&grid, |x| {
        let wave = |w: &[f64; 4]| {
            w[2] / (w[0] * w[0] + w[1] * w[1]) * (TAU * w[0] * x[0] + w[3]).sin() * (TAU * w[1] * x[1]).sin()
        };
        waves.iter().map(wave).sum()
    })
    .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    #[test]
    fn kinetic_energy_does_not_grow(seed in 0u64..1000, cfl in 0.3..5.0f64, scheme in 0usize..3, closed in any::<bool>()) {
        let n = 32;
        let scheme = [Scheme::Auto, Scheme::ReflectionExtrapolated, Scheme::Draft][scheme];
        let grid = Grid::<2>::new([n, n], 1.0 / n as f64).unwrap();
        let mut sides = Sides::periodic();
        if closed {
            sides.0[1] = Axis::Walls([FlowWall::Closed; 2]);
        }
        let mut fluid = Fluid::<f64, 2>::new(&grid, &sides, None, settings(scheme, 1e-6)).unwrap();
        fluid.set_velocity(&random_flow(n, seed)).unwrap();
        let (start, speed) = (fluid.kinetic_energy(), fluid.max_speed());
        let (dt, turnover) = (cfl * grid.h() / speed, 0.25 / speed);
        let mut time = 0.0;
        while time < 4.0 * turnover {
            fluid.step(dt).unwrap();
            time += dt;
            let growth = fluid.kinetic_energy() / start - 1.0;
            prop_assert!(growth <= 1e-3 * (time / turnover).max(1.0), "{scheme:?} CFL {cfl}: {growth:e} at {time}");
        }
    }
}

/// Energy kept after 10 turnover units.
#[test]
fn energy_kept_by_a_random_flow() {
    let n = 64;
    let grid = Grid::<2>::new([n, n], 1.0 / n as f64).unwrap();
    let mut table = Vec::new();
    for (name, scheme, how) in [
        ("single linear", Scheme::Draft, Some(Interpolation::Linear)),
        ("single cubic", Scheme::Draft, Some(Interpolation::Cubic)),
        ("single MacCormack", Scheme::Draft, None),
        ("CNP", Scheme::Cnp, None),
        ("R-ext", Scheme::ReflectionExtrapolated, None),
    ] {
        for cfl in [0.5, 2.0, 5.0] {
            let mut fluid = Fluid::<f64, 2>::new(
                &grid,
                &Sides::periodic(),
                None,
                FlowSettings { interpolation: how, ..settings(scheme, 1e-5) },
            )
            .unwrap();
            fluid.set_velocity(&random_flow(n, 11)).unwrap();
            let start = fluid.kinetic_energy();
            let dt = cfl * grid.h() / fluid.max_speed();
            let end = 10.0 * 0.25 / fluid.max_speed();
            let (mut time, mut most) = (0.0, start);
            while time < end {
                fluid.step(dt).unwrap();
                time += dt;
                most = most.max(fluid.kinetic_energy());
            }
            let kept = fluid.kinetic_energy() / start;
            println!("{name} CFL {cfl}: kept {kept:.3}, most {:.4}", most / start);
            assert!(most / start < 1.003, "{name} CFL {cfl}");
            table.push(kept);
        }
    }
    assert!(table[0] < table[3] && table[3] < table[9] && table[3] < table[12]);
}
