//! The spectral step against single modes, itself, and the steps of `cf-diffusion`.

use cf_diffusion::exact::{AxisModes, Gaussian, Walls, modes, source};
use cf_diffusion::verify::{Case, Random};
use cf_diffusion::{Integrator, Law, Medium, Source, State};
use cf_grid::{Axis, Sides, Wall};
use cf_spectral::{Spectral, SpectralError, smooth, wake};
use nalgebra::SVector;

const ALL: [Walls; 5] = [Walls::Periodic, Walls::Closed, Walls::Valued, Walls::ClosedValued, Walls::ValuedClosed];

fn axis(walls: Walls) -> Axis<Wall> {
    let (closed, valued) = (Wall::CLOSED, Wall::Value(0.0));
    match walls {
        Walls::Periodic => Axis::Periodic,
        Walls::Closed => Axis::Walls([closed, closed]),
        Walls::Valued => Axis::Walls([valued, valued]),
        Walls::ClosedValued => Axis::Walls([closed, valued]),
        Walls::ValuedClosed => Axis::Walls([valued, closed]),
    }
}

fn case<const D: usize>(cells: [usize; D], sides: Sides<Wall, D>, law: Law) -> Case<D> {
    let mut case = Case::new(cells, 0.1, law, Integrator::Sdirk2, 0.0).unwrap();
    case.sides = sides;
    case
}

fn spectral<const D: usize>(case: &Case<D>) -> Spectral<D> {
    Spectral::new(&case.grid, &case.sides, case.law).unwrap()
}

/// The largest difference of phi, and of q_C in units of phi, where they live.
fn distance<const D: usize>(case: &Case<D>, a: &State<f64, D>, b: &State<f64, D>) -> f64 {
    let layout = case.grid.layout();
    let mut far = 0.0f64;
    layout.each_cell(layout.cells_region(), |at| far = far.max((a.phi[at.slot()] - b.phi[at.slot()]).abs()));
    if let (Some(a), Some(b)) = (&a.slow_flux, &b.slow_flux) {
        for i in 0..D {
            layout.each_cell(layout.faces_region(i, case.sides.is_periodic(i)), |at| {
                far = far.max((a.axis(i)[at.slot()] - b.axis(i)[at.slot()]).abs() / case.flux_unit());
            });
        }
    }
    far
}

/// One mode per box, with a slow flux of its own.
fn single_mode<const D: usize>(walls: [Walls; D], cells: [usize; D], numbers: [usize; D], law: Law, t: f64) -> f64 {
    let axes: [AxisModes; D] = std::array::from_fn(|a| AxisModes::new(walls[a], cells[a], 0.1).unwrap());
    let case = case(cells, Sides(walls.map(axis)), law);
    let lambda: f64 = (0..D).map(|a| axes[a].eigenvalue(numbers[a])).sum();
    let shape = |cell: [usize; D]| (0..D).map(|a| axes[a].vector(numbers[a], cell[a])).product::<f64>();
    let mut state = State::<f64, D>::new(&case.grid, &law);
    case.set_phi(&mut state, shape);
    let slope = if law.has_memory() { -0.7 * law.k_cattaneo() } else { 0.0 };
    case.set_gradient(&mut state, slope);
    let mut expected = state.clone();
    let [phi, flux] = modes::evolve(&law, lambda, t, [1.0, -slope * lambda]);
    // In the order that set_gradient needs: the flux of a phi of 1, then phi.
    case.set_gradient(&mut expected, if lambda > 0.0 { -flux / lambda } else { 0.0 });
    case.set_phi(&mut expected, |cell| phi * shape(cell));
    spectral(&case).step(&mut state, &Medium::Still, Source::NONE, t).unwrap();
    distance(&case, &state, &expected)
}

#[test]
fn single_modes_on_every_mix_of_walls() {
    let laws = [Law::cattaneo(0.3, 2.0), Law::jeffreys(0.3, 0.05, 0.1), Law::fourier(0.02), Law::new(0.3, 0.0, 0.4)];
    for law in laws.map(Result::unwrap) {
        for t in [1e-3, 0.2, 50.0] {
            for (x, y) in ALL.iter().flat_map(|x| ALL.map(|y| (*x, y))) {
                for numbers in [[0, 0], [2, 1], [8, 5], [4, 3]] {
                    let error = single_mode([x, y], [9, 6], numbers, law, t);
                    assert!(error < 1e-12, "{law:?} {x:?} {y:?} {numbers:?} t = {t}: {error:e}");
                }
                for z in ALL {
                    let error = single_mode([x, y, z], [5, 4, 3], [1, 3, 2], law, t);
                    assert!(error < 1e-12, "{law:?} {x:?} {y:?} {z:?} t = {t}: {error:e}");
                }
            }
        }
    }
}

#[test]
fn two_steps_are_one() {
    let mut random = Random(3);
    let values = [Axis::Walls([Wall::Value(2.0), Wall::Value(-1.0)]), Axis::Walls([Wall::CLOSED, Wall::Value(0.5)])];
    let moving = Medium::Uniform(SVector::from([0.0, 0.0, 3.7]));
    for law in [Law::cattaneo(0.3, 2.0), Law::jeffreys(0.3, 0.05, 0.1), Law::fourier(0.2)].map(Result::unwrap) {
        let case = case([6, 5, 7], Sides([values[0], values[1], Axis::Periodic]), law);
        let mut once = case.random_state::<f64>(&mut random, 1.0, case.flux_unit());
        let mut twice = once.clone();
        let mut stepper = spectral(&case);
        stepper.step(&mut once, &moving, Source::NONE, 0.4).unwrap();
        stepper.step(&mut twice, &moving, Source::NONE, 0.11).unwrap();
        stepper.step(&mut twice, &moving, Source::NONE, 0.29).unwrap();
        let error = distance(&case, &once, &twice);
        assert!(error < 1e-12, "{law:?}: {error:e}");
    }
}

#[test]
fn mass_stays_and_what_leaves_is_told() {
    let mut random = Random(5);
    let law = Law::cattaneo(0.3, 2.0).unwrap();
    for sides in [Sides::all(Wall::CLOSED), Sides::periodic(), Sides([Axis::Periodic, axis(Walls::Closed)])] {
        let case = case([31, 20], sides, law);
        let mut state = case.random_state::<f64>(&mut random, 1.0, case.flux_unit());
        let before = state.mass(&case.grid);
        let scale = case.grid.layout().sum_abs(&state.phi) * case.grid.cell_volume();
        for _ in 0..20 {
            let report = spectral(&case).step(&mut state, &Medium::Still, Source::NONE, 0.3).unwrap();
            assert_eq!(report.outflow, 0.0);
        }
        assert!((state.mass(&case.grid) - before).abs() < 1e-13 * scale);
    }
    let case = case([31, 20], Sides::all(Wall::Value(0.0)), law);
    let mut state = case.random_state::<f64>(&mut random, 1.0, 0.0);
    let before = state.mass(&case.grid);
    let report = spectral(&case).step(&mut state, &Medium::Still, Source::NONE, 1e9).unwrap();
    assert!((report.outflow - before).abs() < 1e-13);
}

/// Largest differences from the spectral step at the same time: Sdirk2 with a source between walls with values.
fn against_sdirk2(law: Law, steps: u32) -> f64 {
    let sides = Sides([Axis::Walls([Wall::Value(1.0), Wall::CLOSED]), Axis::Periodic]);
    let mut case = case([12, 10], sides, law);
    case.dt = 0.5 / f64::from(steps);
    case.settings.tolerance = 1e-13;
    let mut state = State::<f64, 2>::new(&case.grid, &law);
    case.set_phi(&mut state, |c| 1.0 + (0.3 * c[0] as f64).sin() * (std::f64::consts::TAU * c[1] as f64 / 10.0).cos());
    let rate = state.phi.clone();
    let mut exact = state.clone();
    let mut stepper = case.stepper::<f64>().unwrap();
    for _ in 0..steps {
        stepper.step(&mut state, &Medium::Still, Source::steady(&rate), case.dt).unwrap();
    }
    spectral(&case).step(&mut exact, &Medium::Still, Source::steady(&rate), 0.5).unwrap();
    distance(&case, &state, &exact)
}

#[test]
fn sdirk2_converges_to_it_with_order_two() {
    for law in [Law::cattaneo(0.1, 0.4), Law::jeffreys(0.1, 0.4, 0.1), Law::fourier(0.1)].map(Result::unwrap) {
        let [coarse, fine] = [160, 320].map(|steps| against_sdirk2(law, steps));
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.1 && fine < 2e-3, "{law:?}: {coarse:e} {fine:e} order {order}");
    }
}

#[test]
fn values_on_walls_end_in_a_ramp() {
    let law = Law::cattaneo(0.3, 2.0).unwrap();
    let case = case([8, 3], Sides([Axis::Walls([Wall::Value(1.0), Wall::Value(3.0)]), axis(Walls::Closed)]), law);
    let mut state = case.random_state::<f64>(&mut Random(1), 1.0, 1.0);
    spectral(&case).step(&mut state, &Medium::Still, Source::NONE, 1e6).unwrap();
    let layout = case.grid.layout();
    layout.each_cell(layout.cells_region(), |at| {
        let x = (at.cell[0] as f64 + 0.5) / 8.0;
        assert!((state.phi[at.slot()] - 1.0 - 2.0 * x).abs() < 1e-13);
    });
    let q = state.slow_flux.unwrap();
    layout.each_cell(layout.faces_region(0, false), |at| {
        assert!((q.axis(0)[at.slot()] + 0.3 * 2.0 / 0.8).abs() < 1e-12);
    });
}

#[test]
fn a_source_adds_what_its_mode_should() {
    let law = Law::jeffreys(0.3, 0.5, 0.2).unwrap();
    let case = case([16, 4], Sides::all(Wall::CLOSED), law);
    let modes = AxisModes::new(Walls::Closed, 16, 0.1).unwrap();
    let mut state = State::<f64, 2>::new(&case.grid, &law);
    case.set_phi(&mut state, |c| 1.0 + modes.vector(3, c[0]));
    let rate = state.phi.clone();
    state.phi.fill(0.0);
    let report = spectral(&case).step(&mut state, &Medium::Still, Source::steady(&rate), 0.7).unwrap();
    let growth = source::still(&law, modes.eigenvalue(3), 0.7)[0];
    let layout = case.grid.layout();
    layout.each_cell(layout.cells_region(), |at| {
        assert!((state.phi[at.slot()] - 0.7 - growth * modes.vector(3, at.cell[0])).abs() < 1e-14);
    });
    assert!((report.emitted - state.mass(&case.grid)).abs() < 1e-14);
}

#[test]
fn a_medium_carries_phi_and_flux() {
    // Eight cells along a periodic axis, by motion and by counting.
    let law = Law::cattaneo(0.3, 2.0).unwrap();
    let case = case([7, 16], Sides([axis(Walls::Valued), Axis::Periodic]), law);
    let mut moved = State::<f64, 2>::new(&case.grid, &law);
    let wave = |c: [usize; 2]| (c[0] as f64).cos() * (std::f64::consts::TAU * (c[1] % 16) as f64 / 16.0).sin();
    case.set_phi(&mut moved, wave);
    case.set_gradient(&mut moved, 0.1);
    let mut still = moved.clone();
    case.set_phi(&mut still, |c| wave([c[0], c[1] + 8]));
    case.set_gradient(&mut still, 0.1);
    let medium = Medium::Uniform(SVector::from([0.0, 0.5]));
    spectral(&case).step(&mut moved, &medium, Source::NONE, 1.6).unwrap();
    spectral(&case).step(&mut still, &Medium::Still, Source::NONE, 1.6).unwrap();
    let error = distance(&case, &moved, &still);
    assert!(error < 1e-13, "{error:e}");
}

#[test]
fn single_precision_is_rounded_once() {
    let law = Law::cattaneo(0.3, 2.0).unwrap();
    let case = case([20, 30], Sides::all(Wall::CLOSED), law);
    let mut single = case.random_state::<f32>(&mut Random(2), 1.0, 0.1);
    let mut double = State::<f64, 2>::new(&case.grid, &law);
    double.phi.iter_mut().zip(single.phi.iter()).for_each(|(d, &s)| *d = s.into());
    for a in 0..2 {
        let from = single.slow_flux.as_ref().unwrap().axis(a).to_vec();
        double.slow_flux.as_mut().unwrap().axis_mut(a).iter_mut().zip(from).for_each(|(d, s)| *d = s.into());
    }
    spectral(&case).step(&mut single, &Medium::Still, Source::NONE, 0.3).unwrap();
    spectral(&case).step(&mut double, &Medium::Still, Source::NONE, 0.3).unwrap();
    let far = single.phi.iter().zip(double.phi.iter()).fold(0.0, |m, (&s, d)| f64::max(m, (f64::from(s) - d).abs()));
    assert!(far < 1e-7, "{far:e}");
}

#[test]
fn what_it_cannot_do_it_refuses() {
    let law = Law::cattaneo(0.3, 2.0).unwrap();
    let box2 = case([4, 4], Sides([Axis::Periodic, axis(Walls::Closed)]), law);
    let open = Sides::all(Wall::Open { inflow: 0.0 });
    assert!(matches!(Spectral::new(&box2.grid, &open, law), Err(SpectralError::Wall { axis: 0, .. })));
    assert!(Spectral::new(&box2.grid, &Sides::all(Wall::Flux(1.0)), law).is_err());
    assert!(Spectral::new(&box2.grid, &Sides::all(Wall::Value(f64::NAN)), law).is_err());
    let mut stepper = spectral(&box2);
    let mut state = State::<f64, 2>::new(&box2.grid, &law);
    let medium = |u: [f64; 2]| Medium::Uniform(SVector::from(u));
    let mut step = |medium: &Medium<f64, 2>, source, dt| stepper.step(&mut state, medium, source, dt).unwrap_err();
    assert!(matches!(step(&Medium::Still, Source::NONE, -1.0), SpectralError::TimeStep(_)));
    let crosses = step(&medium([0.0, 1.0]), Source::NONE, 1.0);
    assert!(matches!(crosses, SpectralError::Velocity { axis: 1, .. }) && crosses.to_string().contains("periodic"));
    let rate = vec![0.0; box2.grid.layout().slots()];
    assert!(matches!(step(&medium([1.0, 0.0]), Source::steady(&rate), 1.0), SpectralError::MovingSource));
    assert!(matches!(step(&Medium::Still, Source::steady(&rate[1..]), 1.0), SpectralError::Layout { .. }));
    let endless = vec![f64::INFINITY; rate.len()];
    assert!(matches!(step(&Medium::Still, Source::steady(&endless), 1.0), SpectralError::NotFinite));
    let mut fourier = State::<f64, 2>::new(&box2.grid, &Law::fourier(1.0).unwrap());
    let refused = stepper.step(&mut fourier, &Medium::Still, Source::NONE, 1.0);
    assert!(matches!(refused, Err(SpectralError::SlowFlux { found: false })));
}

#[test]
fn smooth_data_follow_the_continuous_equations() {
    // In free space until the walls are reached; and the grid's own solution comes nearer with the square of h.
    let gaussian = Gaussian { height: 1.0, sigma: 0.05 };
    for law in [Law::cattaneo(0.04, 1.0), Law::jeffreys(0.01, 0.3, 0.1), Law::fourier(0.005)].map(Result::unwrap) {
        let mut far = [0.0f64; 2];
        for (far, n) in far.iter_mut().zip([32, 64]) {
            let mut case = case([n, n], Sides([axis(Walls::Closed), Axis::Periodic]), law);
            case.grid = cf_grid::Grid::new([n, n], 1.0 / n as f64).unwrap();
            let r = |c: [usize; 2]| (case.grid.centre(c) - SVector::from([0.5, 0.5])).norm();
            let mut state = State::<f64, 2>::new(&case.grid, &law);
            case.set_phi(&mut state, |c| gaussian.free(&law, 2, r(c), 0.0));
            let mut phi = state.phi.clone();
            smooth(&case.grid, &case.sides, &law, &mut phi, 0.5).unwrap();
            spectral(&case).step(&mut state, &Medium::Still, Source::NONE, 0.5).unwrap();
            let layout = case.grid.layout();
            layout.each_cell(layout.cells_region(), |at| {
                if n == 64 && at.cell[0] % 7 == 0 && at.cell[1] % 5 == 0 {
                    let exact = gaussian.free(&law, 2, r(at.cell), 0.5);
                    assert!((phi[at.slot()] - exact).abs() < 2e-6, "{law:?} {:?}", at.cell);
                }
                *far = far.max((phi[at.slot()] - state.phi[at.slot()]).abs());
            });
        }
        assert!(((far[0] / far[1]).log2() - 2.0).abs() < 0.3, "{law:?}: {far:?}");
    }
    let grid = cf_grid::Grid::new([4, 4], 0.25).unwrap();
    let refused = smooth(&grid, &Sides::all(Wall::Value(1.0)), &Law::fourier(1.0).unwrap(), &mut [0.0; 36], 1.0);
    assert!(matches!(refused, Err(SpectralError::Lifted { axis: 0, .. })));
}

/// φ(x, t) = ∫₀ᵗ G(|x − us|, s) ds, where G is what a Gaussian that was emitted at once becomes, by its Hankel integral.
#[test]
fn a_wake_is_the_sum_of_all_that_was_emitted() {
    for share in [0.0, 0.2] {
        let law = Law::new(0.5, 2.0, share).unwrap();
        let grid = cf_grid::Grid::<2>::new([64, 48], 0.125).unwrap();
        let at = |cell: [usize; 2]| [grid.centre(cell)[0] - 4.0, grid.centre(cell)[1] - 3.0];
        let gaussian = Gaussian { height: 1.0, sigma: 0.25 };
        let mut rate = cf_grid::CellField::<f64>::new(grid.layout());
        grid.layout().par_cells(&mut rate, |c| {
            let [x, y] = at(c.cell);
            (-0.5 * (x * x + y * y) / 0.0625).exp()
        });
        let mut phi = cf_grid::CellField::<f64>::new(grid.layout());
        wake(&grid, &law, [0.8, -0.3], &rate, 1.5, &mut phi).unwrap();
        for cell in [[32, 24], [40, 22], [44, 18], [30, 25], [36, 28]] {
            let [x, y] = at(cell);
            let value = |s: f64| gaussian.free(&law, 2, (x - 0.8 * s).hypot(y + 0.3 * s), s);
            // Simpson's rule.
            let steps = 200;
            let weight = |i: usize| if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            let sum: f64 = (0..=steps).map(|i| weight(i) * value(1.5 * i as f64 / steps as f64)).sum();
            let exact = sum * 1.5 / steps as f64 / 3.0;
            let found = phi[grid.layout().slot(cell)];
            assert!((found - exact).abs() < 1e-6, "F_T = {share}, {cell:?}: {found} {exact}");
        }
    }
}

#[test]
fn a_wake_needs_numbers() {
    let grid = cf_grid::Grid::<2>::new([4, 4], 1.0).unwrap();
    let law = Law::cattaneo(1.0, 1.0).unwrap();
    let rate = cf_grid::CellField::<f64>::new(grid.layout());
    let mut phi = rate.clone();
    assert!(matches!(wake(&grid, &law, [0.0; 2], &rate, -1.0, &mut phi), Err(SpectralError::TimeStep(_))));
    assert!(matches!(
        wake(&grid, &law, [0.0, f64::NAN], &rate, 1.0, &mut phi),
        Err(SpectralError::Velocity { axis: 1, .. })
    ));
    assert!(matches!(wake(&grid, &law, [0.0; 2], &rate[1..], 1.0, &mut phi), Err(SpectralError::Layout { .. })));
}
