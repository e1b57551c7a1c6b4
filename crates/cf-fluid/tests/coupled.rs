//! What the flow carries, and what that takes; mass and prescribed streams are in `verify::flows`.

use std::f64::consts::TAU;

use cf_diffusion::{Advection, Diffusion, Integrator, Law, Medium, Settings, Source, Splitting, State};
use cf_fluid::exact::taylor_green;
use cf_fluid::{
    Buoyancy, Coupled, Emission, Emitter, Flow, FlowSettings, FlowWall, Fluid, Jet, Scheme, Shape, obstacles,
};
use cf_grid::{Axis, Grid, Sides, Wall};
use cf_linear::Plan;

use crate::common::random_faces;

/// Flow and diffusion take turns with solver vectors, levels and buffers: four arrays for all of them, and the levels.
#[test]
fn scratch_is_shared() {
    let grid = Grid::<3>::new([32; 3], 1.0 / 32.0).unwrap();
    let flow = FlowSettings { scheme: Scheme::Cnp, ..Default::default() };
    let fluid = Fluid::<f32, 3>::new(&grid, &Sides::all(FlowWall::Closed), None, flow).unwrap();
    let law = Law::new(0.1, 1.0, 0.5).unwrap();
    let settings = Settings { integrator: Integrator::PaperBe, plan: Some(Plan::Multigrid), ..Default::default() };
    let diffusion = || Diffusion::new(&grid, &Sides::all(Wall::CLOSED), None, law, settings).unwrap();
    let mut coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion(), &[]).unwrap();
    let mut state = State::new(&grid, &law);
    let mut u = random_faces::<f32, 3>(grid.layout(), 3);
    u.axes_mut().into_iter().flatten().for_each(|v| *v *= 0.1);
    if let Flow::Solved(fluid) = &mut coupled.flow {
        fluid.set_velocity(&u).unwrap();
    }
    state.phi[grid.layout().slot([16; 3])] = 1.0;
    let array = 4 * grid.layout().slots();
    let flow = coupled.flow.bytes();
    // On its own a stepper keeps a solution, three solver vectors and two buffers.
    let (mut alone, mut copy) = (diffusion(), state.clone());
    let medium = Medium::Field(coupled.flow.fluid().unwrap().velocity().clone());
    alone.step(&mut copy, &medium, Source::NONE, 0.02).unwrap();
    for _ in 0..3 {
        let report = coupled.step(&mut state, 0.02).unwrap();
        assert!(report.scalar.iterations > 0 && report.flow.is_some_and(|flow| flow.projections > 0));
        assert_eq!(coupled.flow.bytes(), flow);
        // And the levels of solvers, an eighth of an array for each of x and b, and so on.
        let (lent, shared) =
            (alone.bytes() - coupled.diffusion.bytes(), coupled.bytes() - flow - coupled.diffusion.bytes());
        assert!(lent / array == 6 && lent % array < array / 2, "{lent} of {array}");
        assert!(shared / array == 4 && shared % array < array / 2, "{shared} of {array}");
    }
}

#[test]
fn a_prescribed_velocity_costs_nothing() {
    let flow = Flow::<f64, 3>::Prescribed(Medium::Uniform([1.0, 0.0, 0.0].into()));
    assert_eq!(flow.bytes(), 0);
    let grid = Grid::<2>::new([8, 8], TAU / 8.0).unwrap();
    let field = taylor_green::<f32>(&grid, [0.0; 2], 0.0).unwrap();
    let bytes = field.bytes();
    let mut flow = Flow::Prescribed(Medium::Field(field));
    assert_eq!(flow.bytes(), bytes);
    flow.begin(0.1, None, &mut ()).unwrap();
    assert_eq!(flow.finish(None, &mut ()).unwrap(), None);
    assert_eq!(flow.bytes(), bytes);
}

/// phi carried by the translating vortices, passive and pushing them, differences between runs of 8, 16 and 32 steps on
/// one grid.
#[test]
fn the_order_in_time_is_that_of_the_splitting() {
    let n = 64;
    let grid = Grid::<2>::new([n, n], TAU / n as f64).unwrap();
    let law = Law::cattaneo(0.1, 0.5).unwrap();
    let run = |steps: usize, scheme: Scheme, splitting: Splitting, strength: f64| {
        let buoyancy = (strength != 0.0).then_some(Buoyancy { strength, reference: 0.0, up: [0.6, 0.8] });
        let settings = FlowSettings { scheme, eta_div: 1e-9, buoyancy, ..FlowSettings::default() };
        let mut fluid = Fluid::new(&grid, &Sides::periodic(), None, settings).unwrap();
        fluid.set_velocity(&taylor_green(&grid, [1.0, 0.5], 0.0).unwrap()).unwrap();
        let choice = Settings { splitting, tolerance: 1e-9, advection: Advection::Cubic, ..Settings::default() };
        let diffusion = Diffusion::new(&grid, &Sides::periodic(), None, law, choice).unwrap();
        let mut coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[]).unwrap();
        let mut state = State::<f64, 2>::new(&grid, &law);
        grid.layout().par_cells(&mut state.phi, |at| {
            let x = grid.centre(at.cell);
            (-(x[0] - 3.0).powi(2) - (x[1] - 3.0).powi(2)).exp()
        });
        for _ in 0..steps {
            coupled.step(&mut state, 1.0 / steps as f64).unwrap();
        }
        let velocity = coupled.flow.fluid().unwrap().velocity().clone();
        [state.phi.to_vec(), velocity.axis(0).to_vec(), velocity.axis(1).to_vec()]
    };
    let distance = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        let mut sum = 0.0;
        for (a, b) in a.iter().zip(b) {
            grid.layout().each_cell(grid.layout().cells_region(), |at| sum += (a[at.slot()] - b[at.slot()]).powi(2));
        }
        sum.sqrt()
    };
    for (scheme, splitting, strength, order) in [
        (Scheme::Cnp, Splitting::Strang, 0.0, 1.7..9.0),
        (Scheme::ReflectionExtrapolated, Splitting::Strang, 0.0, 1.7..9.0),
        (Scheme::Draft, Splitting::Paper, 0.0, 0.7..1.5),
        (Scheme::Cnp, Splitting::Strang, 2.0, 1.7..9.0),
        (Scheme::ReflectionExtrapolated, Splitting::Strang, 2.0, 1.7..9.0),
        (Scheme::Draft, Splitting::Paper, 2.0, 0.7..1.5),
    ] {
        let [a, b, c] = [8, 16, 32].map(|steps| run(steps, scheme, splitting, strength));
        for (what, fields) in [("phi", 0..1), ("u", 1..3)] {
            let [ab, bc] = [distance(&a[fields.clone()], &b[fields.clone()]), distance(&b[fields.clone()], &c[fields])];
            let found = (ab / bc).log2();
            println!(
                "{scheme:?} {splitting:?}, buoyancy {strength}, {what}: differences {ab:.2e} {bc:.2e}, order {found:.2}"
            );
            assert!(order.contains(&found), "{scheme:?}, buoyancy {strength}, {what}: order {found}");
        }
    }
}

#[test]
fn emitters_emit_what_they_say() {
    let grid = Grid::<2>::new([20, 40], 0.1).unwrap();
    let law = Law::cattaneo(0.01, 1.0).unwrap();
    let open = Sides::all(FlowWall::OPEN);
    let base = Shape::Box { low: [0.8, 0.0], high: [1.2, 0.22] };
    let jet = Emitter {
        from: 0.1,
        until: 0.55,
        ..Emitter::new(base, Some(Jet::Hold([0.0, 1.0])), Some(Emission::Rate(50.0)))
    };
    let mut floor = open;
    floor.0[1] = Axis::Walls([FlowWall::Closed, FlowWall::OPEN]);
    let mut walls = Sides::all(Wall::Open { inflow: 0.0 });
    walls.0[1] = Axis::Walls([Wall::Value(0.0), Wall::Open { inflow: 0.0 }]);
    let fluid =
        Fluid::<f64, 2>::new(&grid, &floor, None, FlowSettings::default()).unwrap().with_emitters(&[jet]).unwrap();
    let diffusion = Diffusion::new(&grid, &walls, None, law, Settings::default()).unwrap();
    let mut coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[jet]).unwrap();
    let mut state = State::new(&grid, &law);
    let (mut emitted, mut left) = (0.0, 0.0);
    for step in 0..10 {
        let report = coupled.step(&mut state, 0.1).unwrap();
        let flow = report.flow.unwrap();
        assert!(flow.divergence <= 1e-4 && flow.imbalance < 1e-12, "{flow:?}");
        emitted += report.scalar.emitted;
        left += report.scalar.outflow;
        let u = coupled.flow.fluid().unwrap().velocity();
        let acts = (1..5).contains(&step);
        let (inside, inlet) = (u.axis(1)[grid.layout().slot([9, 2])], u.axis(1)[grid.layout().slot([10, 0])]);
        assert_eq!(inside == 1.0 && inlet == 1.0, acts, "step {step}: {inside} {inlet}");
    }
    // 50 per second into 4 x 2 cells for 0.45 s.
    let whole = 50.0 * 8.0 * 0.01 * 0.45;
    assert!((emitted - whole).abs() < 1e-12, "{emitted} {whole}");
    assert!((state.mass(&grid) + left - emitted).abs() < 1e-9);

    // A held value says what it added; a set jet drives without holding.
    let ink = Emitter::new(base, Some(Jet::Set([0.0, 1.0])), Some(Emission::Value(2.0)));
    let fluid =
        Fluid::<f64, 2>::new(&grid, &floor, None, FlowSettings::default()).unwrap().with_emitters(&[ink]).unwrap();
    let diffusion = Diffusion::new(&grid, &walls, None, law, Settings::default()).unwrap();
    let mut coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[ink]).unwrap();
    let mut state = State::new(&grid, &law);
    let report = coupled.step(&mut state, 0.05).unwrap();
    assert!((report.set - 2.0 * 8.0 * 0.01).abs() < 1e-12, "{}", report.set);
    let fluid = coupled.flow.fluid().unwrap();
    let v = fluid.velocity().axis(1)[grid.layout().slot([9, 1])];
    assert!(v > 0.1 && v < 1.0, "{v}");
    assert!(coupled.hc().unwrap() > 1.0);
}

#[test]
fn what_does_not_fit_is_refused() {
    let grid = Grid::<2>::new([4, 4], 1.0).unwrap();
    let law = Law::fourier(1.0).unwrap();
    let mask = obstacles(&grid, &[Shape::Sphere { center: [2.0, 2.0], radius: 0.9 }]).unwrap();
    let diffusion = Diffusion::<f64, 2>::new(&grid, &Sides::all(Wall::CLOSED), None, law, Settings::default()).unwrap();
    let fluid = Fluid::new(&grid, &Sides::all(FlowWall::Closed), Some(&mask), FlowSettings::default()).unwrap();
    let error = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[]).err().unwrap();
    assert!(error.to_string().contains("mask"), "{error}");
}
