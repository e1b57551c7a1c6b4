//! What holds bit for bit, what is refused, and what is not stored.

mod common;

use cf_diffusion::verify::{Case, Random};
use cf_diffusion::{Diffusion, Integrator, Law, Medium, Rate, Settings, Source, Splitting, State, StepError};
use cf_grid::{Axis, CellField, Grid, Mask, Real, Sides, Wall};
use nalgebra::SVector;

fn on_threads<V: Send>(count: usize, run: impl FnOnce() -> V + Send) -> V {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(run)
}

fn same_for_any_threads<T: Real, const D: usize>(cells: [usize; D], u: [f64; D]) {
    for (integrator, kappa) in
        [(Integrator::PaperBe, 0.3), (Integrator::Sdirk2, 5.0), (Integrator::Sdirk2, 1e6), (Integrator::Kdk, 0.2)]
    {
        let law = Law::cattaneo(1.0, 1e3).unwrap();
        let h = 0.01;
        // kappa = k dt²/(tau h²) for dt << tau.
        let mut case = Case::<D>::new(cells, h, law, integrator, h * (kappa * 1e3f64).sqrt()).unwrap();
        case.settings.tolerance = 1e-4;
        for (mask, medium) in [(false, true), (true, false)] {
            case.sides = if medium { Sides::periodic() } else { Sides::all(Wall::Value(0.3)) };
            case.mask = mask.then(|| Mask::new(case.grid.layout(), |c| (c[0] * 7 + c[1] * 3) % 11 != 0));
            let speed = SVector::from(u) * (0.4 * h / case.dt);
            let medium = if medium { Medium::Uniform(speed) } else { Medium::Still };
            let start = case.random_state::<T>(&mut Random(9), 1.0, case.flux_unit());
            let run = || {
                let mut state = start.clone();
                let mut stepper = case.stepper::<T>().unwrap();
                for _ in 0..2 {
                    stepper.step(&mut state, &medium, Source::NONE, case.dt).unwrap();
                }
                state
            };
            assert!(on_threads(1, run) == on_threads(2, run), "{integrator:?} {kappa}");
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    same_for_any_threads::<f32, 2>([260, 190], [1.0, -0.7]);
    same_for_any_threads::<f64, 2>([150, 231], [1.0, -0.7]);
    same_for_any_threads::<f32, 3>([42, 31, 29], [1.0, -0.7, 0.4]);
    same_for_any_threads::<f64, 3>([30, 35, 28], [1.0, -0.7, 0.4]);
}

#[test]
fn without_memory_there_is_one_law() {
    let walls = Sides([Axis::Walls([Wall::Value(0.3), Wall::Flux(0.2)]), Axis::Periodic]);
    for integrator in [Integrator::PaperBe, Integrator::Sdirk2] {
        for dt in [1e-5, 0.01, 30.0] {
            let states = [(0.0, 0.0), (0.0, 0.7), (5.0, 1.0), (0.0, 1.0)].map(|(tau, share)| {
                let mut case = Case::new([9, 6], 0.1, Law::new(0.37, tau, share).unwrap(), integrator, dt).unwrap();
                (case.sides, case.settings.tolerance) = (walls, 1e-4);
                let mut state = case.random_state::<f32>(&mut Random(2), 1.0, 0.0);
                case.run(&mut state, 3).unwrap();
                state
            });
            assert!(states.iter().all(|s| *s == states[0]));
        }
    }
}

#[test]
fn no_time_no_change() {
    for integrator in [Integrator::PaperBe, Integrator::Sdirk2, Integrator::Kdk] {
        let mut case = Case::new([5, 4], 0.1, Law::cattaneo(1.0, 1.0).unwrap(), integrator, 0.0).unwrap();
        case.sides = Sides::all(Wall::Absorbing { speed: 1.0, far: 2.0 });
        let start = case.random_state::<f64>(&mut Random(2), 1.0, 1.0);
        let mut state = start.clone();
        let rate = vec![1.0; case.grid.layout().slots()];
        let mut stepper = case.stepper::<f64>().unwrap();
        let medium = Medium::Uniform(SVector::from([1.0, 2.0]));
        let report = stepper.step(&mut state, &medium, Source::steady(&rate), 0.0).unwrap();
        assert_eq!((state, report.emitted, report.outflow), (start, 0.0, 0.0));
    }
}

#[test]
fn a_flux_is_stored_only_for_memory() {
    let grid = Grid::new([16, 16], 1.0).unwrap();
    let cell = 18 * 18 * 4;
    for (tau, share, fields) in [(0.0, 0.0, 1), (1.0, 1.0, 1), (1.0, 0.5, 3), (1.0, 0.0, 3)] {
        let law = Law::new(1.0, tau, share).unwrap();
        let state = State::<f32, 2>::new(&grid, &law);
        assert_eq!((state.slow_flux.is_some(), state.bytes()), (fields == 3, fields * cell));
    }
    // The explicit stepper needs no solver and no scratch.
    let law = Law::cattaneo(1.0, 1.0).unwrap();
    let settings = Settings { integrator: Integrator::Kdk, ..Settings::default() };
    let stepper = Diffusion::<f32, 2>::new(&grid, &Sides::all(Wall::CLOSED), None, law, settings).unwrap();
    assert_eq!((stepper.bytes(), stepper.choice()), (0, None));
}

#[test]
fn unusable_input_is_refused() {
    let grid = Grid::new([4, 4], 0.5).unwrap();
    let (waves, sides) = (Law::cattaneo(1.0, 1.0).unwrap(), Sides::all(Wall::CLOSED));
    let new = |law, mask, settings| Diffusion::<f64, 2>::new(&grid, &sides, mask, law, settings);
    let explicit = Settings { integrator: Integrator::Kdk, ..Settings::default() };
    for law in [Law::jeffreys(1.0, 1.0, 0.1), Law::cattaneo(1.0, 0.0), Law::fourier(1.0)] {
        assert!(matches!(new(law.unwrap(), None, explicit).err(), Some(StepError::NeedsWaves { .. })));
    }
    let other = Grid::<2>::new([5, 4], 0.5).unwrap();
    let mask = Mask::new(other.layout(), |_| true);
    assert!(matches!(new(waves, Some(mask), explicit).err(), Some(StepError::Layout { what: "the mask", .. })));

    let mut stepper = new(waves, None, Settings::default()).unwrap();
    let mut step = |state: &mut State<f64, 2>, source, dt| stepper.step(state, &Medium::Still, source, dt);
    let mut state = State::new(&grid, &waves);
    for dt in [f64::NAN, f64::INFINITY, -1e-9] {
        assert!(matches!(step(&mut state, Source::NONE, dt), Err(StepError::TimeStep(_))));
    }
    let mut lacking = State { phi: CellField::new(grid.layout()), slow_flux: None };
    assert_eq!(step(&mut lacking, Source::NONE, 1.0), Err(StepError::SlowFlux { found: false }));
    let mut large = State::new(&other, &waves);
    assert!(matches!(step(&mut large, Source::NONE, 1.0), Err(StepError::Layout { .. })));
    assert!(matches!(
        step(&mut state, Source::steady(&[1.0][..]), 1.0),
        Err(StepError::Layout { what: "the source", .. })
    ));
    let rate = vec![f64::NAN; grid.layout().slots()];
    let refused = step(&mut state, Source::steady(&rate), 1.0).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the source is not finite at cell [0, 0]; check initial values, sources and the size of the step"
    );
    state.phi[grid.layout().slot([2, 1])] = f64::NAN;
    let refused = step(&mut state, Source::NONE, 1.0).unwrap_err();
    assert!(refused.to_string().starts_with("phi is not finite at cell [2, 1]"), "{refused}");
}

#[test]
fn explicit_steps_divide_themselves() {
    let law = Law::cattaneo(1.0, 0.3).unwrap();
    let case = |share: f64| {
        let mut case = Case::new([12, 12], 0.1, law, Integrator::Kdk, 1.0).unwrap();
        case.dt = share * case.stepper::<f64>().unwrap().explicit_limit();
        case
    };
    for (share, substeps) in [(0.999, 1), (1.001, 2), (7.5, 8)] {
        let case = case(share);
        let mut state = case.random_state::<f64>(&mut Random(3), 1.0, case.flux_unit());
        let start = case.energy(&state);
        assert_eq!(case.run(&mut state, 2000).unwrap().substeps, substeps);
        assert!(case.energy(&state) < start);
    }
    let absurd = case(1e8);
    let mut state = State::<f64, 2>::new(&absurd.grid, &law);
    let refused = absurd.stepper::<f64>().unwrap().step(&mut state, &Medium::Still, Source::NONE, absurd.dt);
    assert!(matches!(refused, Err(StepError::Unstable { .. })));
}

#[test]
fn sub_steps_are_steps() {
    let law = Law::cattaneo(1.0, 0.02).unwrap();
    let mut case = Case::new([9, 7], 0.1, law, Integrator::Kdk, 1.0).unwrap();
    case.sides = Sides([Axis::Walls([Wall::Value(0.4), Wall::Absorbing { speed: 7.0, far: 0.1 }]), Axis::Periodic]);
    case.dt = 3.4 * case.stepper::<f64>().unwrap().explicit_limit();
    let start = case.random_state::<f64>(&mut Random(3), 1.0, case.flux_unit());
    let (mut once, mut often) = (start.clone(), start);
    assert_eq!(case.run(&mut once, 1).unwrap().substeps, 4);
    case.dt *= 0.25;
    case.run(&mut often, 4).unwrap();
    assert!(common::largest(&once.phi, &often.phi) < 1e-13);
    let [one, other] = [&once, &often].map(|s| s.slow_flux.as_ref().unwrap());
    assert!((0..2).all(|a| common::largest(one.axis(a), other.axis(a)) < 1e-12));
}

#[test]
fn single_precision_keeps_the_mass_for_hundreds_of_steps() {
    for kappa in [1e4, 1e8] {
        let law = Law::fourier(1.0).unwrap();
        let case = Case::new([40, 30], 0.1, law, Integrator::Sdirk2, 0.01 * kappa).unwrap();
        let mut state = case.random_state::<f32>(&mut Random(8), 1.0, 0.0);
        state.phi.iter_mut().for_each(|phi| *phi += 3.0);
        let before = state.mass(&case.grid);
        case.run(&mut state, 300).unwrap();
        let drift = (state.mass(&case.grid) / before - 1.0).abs();
        assert!(drift < 4e-9, "{kappa:.0e}: {drift:.2e}");
    }
}

#[test]
fn both_splittings_balance_mass_through_open_walls() {
    let law = Law::cattaneo(0.02, 0.5).unwrap();
    for (integrator, splitting) in [
        (Integrator::PaperBe, Splitting::Paper),
        (Integrator::Sdirk2, Splitting::Strang),
        (Integrator::Kdk, Splitting::Strang),
        (Integrator::Kdk, Splitting::Paper),
    ] {
        let mut case = Case::new([20, 14], 0.05, law, integrator, 0.03).unwrap();
        (case.settings.splitting, case.settings.tolerance) = (splitting, 1e-3);
        let side = [Wall::Open { inflow: 0.7 }, Wall::Absorbing { speed: 0.2, far: 0.1 }];
        case.sides = Sides([Axis::Walls(side), Axis::Walls([Wall::Value(0.4), Wall::Value(-0.2)])]);
        case.mask = Some(Mask::new(case.grid.layout(), |c| c[0].abs_diff(8) > 2 || c[1].abs_diff(6) > 1));
        let mut state = case.random_state::<f64>(&mut Random(6), 1.0, case.flux_unit());
        let rate = case.random_state::<f64>(&mut Random(7), 3.0, 0.0).phi;
        let mut stepper = case.stepper::<f64>().unwrap();
        let medium = Medium::Uniform(SVector::from([0.9, -0.3]));
        let mut expected = state.mass(&case.grid);
        for share in [1.0, 0.25, 0.0, 1.0] {
            let source = Source::during(&rate[..], share);
            let report = stepper.step(&mut state, &medium, source, case.dt).unwrap();
            expected += report.emitted - report.outflow;
        }
        let size = case.grid.layout().sum_abs(&state.phi) * case.grid.cell_volume();
        assert!((state.mass(&case.grid) - expected).abs() < 1e-12 * size, "{integrator:?} {splitting:?}");
    }
}

/// A stretch of slots says the same as the field that is zero elsewhere; it need not begin or end with a row.
#[test]
fn a_rate_may_be_a_part_of_a_field() {
    let law = Law::cattaneo(0.1, 0.4).unwrap();
    for (integrator, splitting, dt) in [
        (Integrator::PaperBe, Splitting::Paper, 0.03),
        (Integrator::Sdirk2, Splitting::Strang, 0.03),
        (Integrator::Sdirk2, Splitting::Strang, 3e7),
        (Integrator::Kdk, Splitting::Strang, 0.03),
    ] {
        let mut case = Case::<3>::new([9, 7, 6], 0.05, law, integrator, dt).unwrap();
        (case.settings.splitting, case.settings.tolerance) = (splitting, 1e-4);
        case.mask = Some(Mask::new(case.grid.layout(), |c| c[0] != 4));
        let layout = *case.grid.layout();
        let (low, high) = (layout.slot([3, 2, 1]), layout.slot([6, 4, 4]));
        let mut rate = vec![0.0; layout.slots()];
        (low..high).for_each(|slot| rate[slot] = (slot as f64).sin());
        let run = |source: Source<'_, f64>| {
            let mut state = case.random_state::<f64>(&mut Random(6), 1.0, case.flux_unit());
            let report = case.stepper::<f64>().unwrap().step(&mut state, &Medium::Still, source, dt).unwrap();
            (state, report.emitted)
        };
        let part = Rate { first: low, values: &rate[low..high] };
        assert!(run(Source::during(part, 0.7)) == run(Source::during(&rate, 0.7)), "{integrator:?} {splitting:?} {dt}");
        let beyond = Rate { first: layout.slots() - 1, values: &rate[..2] };
        let mut state = State::new(&case.grid, &law);
        let refused = case.stepper::<f64>().unwrap().step(&mut state, &Medium::Still, Source::steady(beyond), dt);
        assert!(matches!(refused, Err(StepError::Layout { what: "the source", .. })));
    }
}
