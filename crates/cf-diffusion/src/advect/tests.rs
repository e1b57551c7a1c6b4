//! Transport as a whole: mass, constants, bounds, order, walls, threads.

use std::f64::consts::{PI, TAU};

use cf_grid::{Axis, CellField, End, FaceField, Grid, Mask, Real, Sides, Wall};
use nalgebra::SVector;
use proptest::prelude::*;

use super::{AdvectError, Advection, Advector};
use crate::medium::{Medium, MediumError, sample, stream_function, vector_potential};

const METHODS: [Advection; 3] = [Advection::Muscl, Advection::Cubic, Advection::Linear];

fn noise(seed: usize) -> f64 {
    ((seed.wrapping_mul(2654435761) ^ 0x5bd1) % 100_003) as f64 / 100_003.0
}

fn noisy<T: Real, const D: usize>(grid: &Grid<D>) -> CellField<T> {
    let mut phi = CellField::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| T::of(noise(at.slot()) + 0.25));
    phi
}

fn noisy_flux<T: Real, const D: usize>(grid: &Grid<D>, sides: &Sides<Wall, D>) -> FaceField<T, D> {
    let mut q = FaceField::new(grid.layout());
    for a in 0..D {
        let sites = super::Sites::faces(grid.layout(), sides, a);
        grid.layout().par_region(sites.region, q.axis_mut(a), |at| T::of(noise(7 * at.slot() + a) - 0.5));
    }
    q
}

fn mass<T: Real, const D: usize>(grid: &Grid<D>, phi: &CellField<T>) -> f64 {
    grid.layout().sum(phi) * grid.cell_volume()
}

fn bump(x: f64) -> f64 {
    1.0 + (TAU * x).sin()
}

/// A vortex that touches no wall of the unit square, and one that turns in a periodic box.
fn vortex<T: Real>(grid: &Grid<2>) -> Medium<T, 2> {
    let psi = |x: SVector<f64, 2>| (PI * x[0]).sin().powi(2) * (PI * x[1]).sin().powi(2) / PI;
    Medium::Field(stream_function(grid, psi).unwrap())
}

fn walls_2d() -> Vec<Sides<Wall, 2>> {
    let open = Wall::Open { inflow: 0.5 };
    let absorbing = Wall::Absorbing { speed: 1.0, far: -0.25 };
    vec![
        Sides::periodic(),
        Sides::all(open),
        Sides([Axis::Walls([Wall::Value(2.0), open]), Axis::Walls([absorbing, Wall::Value(-1.0)])]),
        Sides([Axis::Periodic, Axis::Walls([absorbing, absorbing])]),
        Sides([Axis::Walls([open, Wall::Value(1.0)]), Axis::Periodic]),
    ]
}

fn books_balance<T: Real>(cells: [usize; 2], sides: Sides<Wall, 2>, medium: &Medium<T, 2>, mask: Option<&Mask<2>>, dt: f64) {
    let grid = Grid::new(cells, 0.125).unwrap();
    let mut advector = Advector::new(&grid, &sides, mask, Advection::Muscl);
    let mut phi = noisy::<T, 2>(&grid);
    let scale = grid.layout().sum_abs(&phi) * grid.cell_volume();
    let (before, mut left) = (mass(&grid, &phi), 0.0);
    for _ in 0..5 {
        left += advector.advect(&mut phi, None, medium, dt).unwrap().outflow;
    }
    let error = (mass(&grid, &phi) + left - before).abs() / scale;
    let limit = if T::NAME == "f64" { 1e-13 } else { 1e-6 };
    assert!(error < limit, "{} {sides:?} {cells:?}: {error:e}", T::NAME);
}

#[test]
fn mass_and_outflow_balance_on_every_wall_mix() {
    fn check<T: Real>() {
        for sides in walls_2d() {
            for cells in [[16, 16], [67, 3], [3, 70], [1, 9], [9, 1], [1, 1]] {
                let uniform = Medium::<T, 2>::Uniform(SVector::from([1.0, -0.7]));
                books_balance(cells, sides, &uniform, None, 0.3);
                let grid = Grid::new(cells, 0.125).unwrap();
                let wild = |x: SVector<f64, 2>| {
                    SVector::from([(TAU * x[1]).sin() + 0.3 * (TAU * x[0]).cos(), (TAU * x[0]).cos() - 0.2])
                };
                let field = Medium::Field(sample::<T, 2>(&grid, wild).unwrap());
                books_balance(cells, sides, &field, None, 0.2);
                let mask = Mask::new(grid.layout(), |c| (c[0] + 2 * c[1]) % 7 != 3);
                books_balance(cells, sides, &uniform, Some(&mask), 0.2);
                books_balance(cells, sides, &field, Some(&mask), 0.2);
            }
        }
    }
    check::<f64>();
    check::<f32>();
}

#[test]
fn closed_walls_keep_all_mass_in_three_dimensions() {
    for cells in [[3, 5, 7], [8, 1, 4], [1, 1, 1], [70, 4, 3]] {
        let grid = Grid::new(cells, 0.1).unwrap();
        let mut u = vector_potential::<f64>(&grid, |x| SVector::from([x[1], x[2] * x[0], x[0] * 3.0])).unwrap();
        let sides = Sides::all(Wall::Flux(1.0));
        for (axis, end, _) in sides.walls() {
            let mut layer = grid.layout().faces_region(axis, false);
            let at = if end == End::Low { 0 } else { cells[axis] };
            (layer.low[axis], layer.high[axis]) = (at, at + 1);
            grid.layout().par_region(layer, u.axis_mut(axis), |_| 0.0);
        }
        let mut advector = Advector::new(&grid, &sides, None, Advection::Muscl);
        let mut phi = noisy(&grid);
        let (before, mut q) = (mass(&grid, &phi), noisy_flux(&grid, &sides));
        for _ in 0..4 {
            let done = advector.advect(&mut phi, Some(&mut q), &Medium::Field(u.clone()), 0.01).unwrap();
            assert_eq!(done.outflow, 0.0);
        }
        assert!((mass(&grid, &phi) - before).abs() < 1e-14 * before);
    }
}

#[test]
fn constants_stay_constant() {
    fn check<T: Real, const D: usize>(grid: &Grid<D>, medium: &Medium<T, D>, sides: &Sides<Wall, D>, dt: f64) {
        for method in METHODS {
            let mut advector = Advector::new(grid, sides, None, method);
            let mut phi = CellField::<T>::new(grid.layout());
            phi.fill(T::of(3.0));
            for _ in 0..6 {
                advector.advect(&mut phi, None, medium, dt).unwrap();
            }
            let (low, high) = grid.layout().range(&phi);
            let limit = if matches!(medium, Medium::Uniform(_)) || method != Advection::Muscl { 0.0 } else { 400.0 * T::EPSILON };
            assert!(low >= 3.0 - limit && high <= 3.0 + limit, "{method:?} {low:e} {high:e}");
        }
    }
    let open = Sides::all(Wall::Open { inflow: 3.0 });
    let grid = Grid::new([33, 20], 1.0 / 33.0).unwrap();
    check(&grid, &vortex::<f64>(&grid), &open, 0.05);
    check(&grid, &vortex::<f32>(&grid), &open, 0.05);
    check(&grid, &Medium::<f32, 2>::Uniform(SVector::from([0.3, -2.0])), &open, 0.05);
    let grid = Grid::new([12, 9, 10], 0.1).unwrap();
    let swirl = |x: SVector<f64, 3>| SVector::from([(3.0 * x[1]).sin(), (4.0 * x[2]).cos() * x[0], (5.0 * x[0]).sin()]);
    let u = vector_potential::<f64>(&grid, swirl).unwrap();
    check(&grid, &Medium::Field(u), &open_3d(3.0), 0.05);
    check(&grid, &Medium::<f64, 3>::Uniform(SVector::from([1.0, -2.0, 0.5])), &open_3d(3.0), 0.05);
    check(&grid, &Medium::<f64, 3>::Uniform(SVector::from([1.0, -2.0, 0.5])), &Sides::periodic(), 0.05);
}

fn open_3d(inflow: f64) -> Sides<Wall, 3> {
    Sides::all(Wall::Open { inflow })
}

#[test]
fn one_dimension_has_no_new_extrema_and_no_more_variation() {
    for cells in [[150, 1], [1, 150]] {
        let grid = Grid::new(cells, 0.01).unwrap();
        let axis = usize::from(cells[0] == 1);
        for (speed, dt) in [(1.0, 0.009), (-1.0, 0.004), (0.3, 0.021)] {
            let mut u = SVector::zeros();
            u[axis] = speed;
            let mut advector = Advector::new(&grid, &Sides::periodic(), None, Advection::Muscl);
            let mut phi = noisy::<f64, 2>(&grid);
            let variation = |phi: &CellField<f64>| {
                let v: Vec<f64> = (0..150).map(|i| phi[grid.layout().slot(if axis == 0 { [i, 0] } else { [0, i] })]).collect();
                (0..150).map(|i| (v[i] - v[(i + 1) % 150]).abs()).sum::<f64>()
            };
            let ((low, high), mut before) = (grid.layout().range(&phi), variation(&phi));
            for _ in 0..50 {
                advector.advect(&mut phi, None, &Medium::Uniform(u), dt).unwrap();
                let now = variation(&phi);
                assert!(now <= before * (1.0 + 1e-14), "{now} {before}");
                before = now;
            }
            let after = grid.layout().range(&phi);
            assert!(after.0 >= low - 1e-15 && after.1 <= high + 1e-15);
        }
    }
}

/// Relative L1 error of one turn through a periodic box: everywhere, and away from the extrema, where limiting and
/// clamping are at work.
fn turn_error(method: Advection, n: usize, courant: f64) -> [f64; 2] {
    let grid = Grid::new([n, n], 1.0 / n as f64).unwrap();
    let medium = Medium::<f64, 2>::Uniform(SVector::from([1.0, 1.0]));
    let mut phi = CellField::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| bump(grid.centre(at.cell)[0]) + bump(grid.centre(at.cell)[1]));
    let start = phi.clone();
    let mut advector = Advector::new(&grid, &Sides::periodic(), None, method);
    let steps = (n as f64 / courant).ceil();
    for _ in 0..steps as usize {
        advector.advect(&mut phi, None, &medium, 1.0 / steps).unwrap();
    }
    let everywhere = difference(&grid, &phi, &start);
    let mut smooth = start.clone();
    grid.layout().par_cells(&mut smooth, |at| {
        let inner = grid.centre(at.cell).iter().all(|x| (TAU * x).cos().abs() > 0.7);
        if inner { phi[at.slot()] } else { start[at.slot()] }
    });
    [everywhere, difference(&grid, &smooth, &start)]
}

fn difference(grid: &Grid<2>, a: &CellField<f64>, b: &CellField<f64>) -> f64 {
    let mut d = a.clone();
    d.iter_mut().zip(b.iter()).for_each(|(a, b)| *a -= b);
    grid.layout().sum_abs(&d) / grid.layout().sum_abs(b)
}

#[test]
fn orders_of_accuracy() {
    for (method, least) in [(Advection::Muscl, [1.8, 1.9]), (Advection::Cubic, [1.9, 2.5]), (Advection::Linear, [0.8, 0.8])] {
        let errors = [64, 128].map(|n| turn_error(method, n, 0.45));
        for (i, place) in ["everywhere", "away from extrema"].into_iter().enumerate() {
            let order = (errors[0][i] / errors[1][i]).log2();
            println!("{method:?} {place}: {:.3e} {:.3e} order {order:.2}", errors[0][i], errors[1][i]);
            assert!(order > least[i], "{method:?} {place}: {errors:?} order {order}");
        }
    }
}

/// Relative L1 error of the reversing deformation flow of the model's section 6.6 after T = 2.
fn deformation(method: Advection, n: usize, courant: f64, initial: impl Fn(SVector<f64, 2>) -> f64 + Sync) -> f64 {
    let grid = Grid::new([n, n], 1.0 / n as f64).unwrap();
    let Medium::Field(base) = vortex::<f64>(&grid) else { return f64::NAN };
    let mut phi = CellField::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| initial(grid.centre(at.cell)));
    let start = phi.clone();
    let sides = Sides::all(Wall::CLOSED);
    let mut advector = Advector::new(&grid, &sides, None, method);
    let steps = (2.0 * n as f64 / courant).ceil() as usize;
    let mut now = base.clone();
    for step in 0..steps {
        let factor = (PI * (step as f64 + 0.5) / steps as f64).cos();
        for a in 0..2 {
            for (u, b) in now.axis_mut(a).iter_mut().zip(base.axis(a)) {
                *u = b * factor;
            }
        }
        advector.advect(&mut phi, None, &Medium::Field(now.clone()), 2.0 / steps as f64).unwrap();
    }
    difference(&grid, &phi, &start)
}

#[test]
fn the_deformation_flow_returns_as_the_model_measured() {
    let bell = |x: SVector<f64, 2>| {
        let r = (x - SVector::from([0.5, 0.75])).norm() / 0.15;
        if r < 1.0 { 0.5 * (1.0 + (PI * r).cos()) } else { 0.0 }
    };
    for (method, courant, model) in
        [(Advection::Linear, 0.5, 7.7e-1), (Advection::Cubic, 0.5, 5.8e-2), (Advection::Cubic, 3.0, 2.9e-2), (Advection::Muscl, 0.5, 7.7e-2), (Advection::Muscl, 0.9, 6.8e-2)]
    {
        let error = deformation(method, 128, courant, bell);
        println!("{method:?} CFL {courant}: {error:.3e}, model {model:.1e}");
        assert!(error < 1.5 * model, "{method:?} CFL {courant}: {error:.3e} against {model:.1e}");
    }
}

#[test]
fn semi_lagrangian_steps_of_any_length_stay_within_the_old_values() {
    for sides in walls_2d() {
        for cells in [[16, 12], [5, 1], [1, 3], [2, 3], [1, 1]] {
            let grid = Grid::new(cells, 0.125).unwrap();
            for method in [Advection::Cubic, Advection::Linear] {
                for dt in [0.05, 3.0, 1250.0] {
                    let whirl = |x: SVector<f64, 2>| SVector::from([(9.0 * x[1]).sin(), (7.0 * x[0]).cos()]);
                    for medium in [Medium::Uniform(SVector::from([0.9, -1.0])), Medium::Field(sample::<f32, 2>(&grid, whirl).unwrap())] {
                        let mut phi = noisy::<f32, 2>(&grid);
                        let mut q = noisy_flux::<f32, 2>(&grid, &sides);
                        let (low, high) = grid.layout().range(&phi);
                        let (low, high) = sides.walls().filter_map(|w| w.2.carried_in()).fold((low, high), |(l, h), v| (l.min(v), h.max(v)));
                        Advector::new(&grid, &sides, None, method).advect(&mut phi, Some(&mut q), &medium, dt).unwrap();
                        let now = grid.layout().range(&phi);
                        assert!(now.0 >= low - 1e-6 && now.1 <= high + 1e-6, "{now:?} {low} {high}");
                        assert!(q.axes().iter().all(|q| q.iter().all(|v| v.abs() <= 0.5)));
                    }
                }
            }
        }
    }
}

#[test]
fn faces_without_flux_stay_exactly_zero_and_bounded() {
    for sides in walls_2d() {
        let grid = Grid::new([70, 9], 0.125).unwrap();
        let mask = Mask::new(grid.layout(), |c| !(20..23).contains(&c[0]) || c[1] > 4);
        for mask in [None, Some(&mask)] {
            for method in METHODS {
                let mut q = noisy_flux::<f64, 2>(&grid, &sides);
                if let Some(mask) = mask {
                    for a in 0..2 {
                        let sites = super::Sites::faces(grid.layout(), &sides, a);
                        let old = q.axis(a).to_vec();
                        grid.layout().par_region(sites.region, q.axis_mut(a), |at| {
                            if sites.open(mask.fluid(), at.cell) { old[at.slot()] } else { 0.0 }
                        });
                    }
                }
                let zeros: Vec<Vec<bool>> = q.axes().iter().map(|q| q.iter().map(|&v| v == 0.0).collect()).collect();
                let mut advector = Advector::new(&grid, &sides, mask, method);
                let whirl = |x: SVector<f64, 2>| SVector::from([0.4 + (9.0 * x[1]).sin(), (7.0 * x[0]).cos()]);
                for medium in [Medium::Uniform(SVector::from([0.9, -1.0])), Medium::Field(sample(&grid, whirl).unwrap())] {
                    for _ in 0..3 {
                        advector.advect(&mut noisy(&grid), Some(&mut q), &medium, 0.09).unwrap();
                    }
                }
                for a in 0..2 {
                    for (slot, &v) in q.axis(a).iter().enumerate() {
                        assert!(!zeros[a][slot] || v == 0.0, "{method:?} face {a} slot {slot}: {v}");
                        assert!(v.abs() <= 0.5 + 1e-12, "{method:?} {v}");
                    }
                }
            }
        }
    }
}

#[test]
fn the_flux_moves_with_the_medium() {
    // A bump of q_x and q_y in a periodic box moves as phi does, in both methods of higher order.
    for method in [Advection::Muscl, Advection::Cubic] {
        let grid = Grid::new([40, 30], 0.025).unwrap();
        let shape = |x: SVector<f64, 2>| (TAU * x[0]).sin() * (TAU * x[1] / 0.75).cos();
        let velocity = SVector::from([0.5, -0.25]);
        for medium in [Medium::Uniform(velocity), Medium::Field(sample::<f64, 2>(&grid, |_| velocity).unwrap())] {
            let mut q = FaceField::new(grid.layout());
            let mut phi = CellField::new(grid.layout());
            for a in 0..2 {
                grid.layout().par_cells(q.axis_mut(a), |at| shape(grid.face(a, at.cell)));
            }
            let mut advector = Advector::new(&grid, &Sides::periodic(), None, method);
            for _ in 0..20 {
                advector.advect(&mut phi, Some(&mut q), &medium, 0.02).unwrap();
            }
            for a in 0..2 {
                let mut error: f64 = 0.0;
                for j in 0..30 {
                    for i in 0..40 {
                        let exact = shape(grid.face(a, [i, j]) - velocity * 0.4);
                        error = error.max((q.axis(a)[grid.layout().slot([i, j])] - exact).abs());
                    }
                }
                assert!(error < 0.06, "{method:?} {error}");
            }
        }
    }
}

#[test]
fn rest_changes_no_bit() {
    let grid = Grid::new([9, 7], 0.1).unwrap();
    let sides = Sides::all(Wall::Value(4.0));
    for method in METHODS {
        let (mut phi, mut q) = (noisy::<f32, 2>(&grid), noisy_flux(&grid, &sides));
        let before = (phi.clone(), q.clone());
        let mut advector = Advector::new(&grid, &sides, None, method);
        let still = [Medium::Still, Medium::Uniform(SVector::zeros()), Medium::Field(FaceField::new(grid.layout()))];
        for medium in still {
            let done = advector.advect(&mut phi, Some(&mut q), &medium, 1e9).unwrap();
            assert_eq!((done.outflow, done.substeps), (0.0, 0));
            assert_eq!(advector.stable_dt(&medium), None);
        }
        let moving = Medium::Uniform(SVector::from([1.0, 2.0]));
        advector.advect(&mut phi, Some(&mut q), &moving, 0.0).unwrap();
        assert_eq!((phi, q), before);
        assert!(!advector.reversed());
    }
}

#[test]
fn what_cannot_be_carried_is_refused_and_nothing_changes() {
    let grid = Grid::new([8, 8], 0.1).unwrap();
    let sides = Sides([Axis::Walls([Wall::Open { inflow: 0.0 }, Wall::CLOSED]), Axis::Periodic]);
    let mut advector = Advector::<f64, 2>::new(&grid, &sides, None, Advection::Muscl);
    let mut phi = noisy(&grid);
    let before = phi.clone();
    let along = Medium::Uniform(SVector::from([0.0, 1.0]));
    let nan = Medium::Uniform(SVector::from([0.0, f64::NAN]));
    let error = advector.advect(&mut phi, None, &nan, 0.1).unwrap_err();
    assert!(matches!(error, AdvectError::Medium(MediumError::NotFinite { axis: 1, .. })));
    let mut field = FaceField::new(grid.layout());
    field.axis_mut(0)[grid.layout().slot([3, 3])] = f64::NEG_INFINITY;
    let error = advector.advect(&mut phi, None, &Medium::Field(field), 0.1).unwrap_err();
    assert!(matches!(error, AdvectError::Medium(MediumError::NotFinite { axis: 0, cell: [3, 3, 0], .. })));
    let across = Medium::Uniform(SVector::from([1.0, 1.0]));
    let error = advector.advect(&mut phi, None, &across, 0.1).unwrap_err();
    assert!(matches!(error, AdvectError::Medium(MediumError::CrossesClosedWall { axis: 0, end: End::High, .. })));
    for dt in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(advector.advect(&mut phi, None, &along, dt), Err(AdvectError::Step { .. })));
    }
    let error = advector.advect(&mut phi, None, &along, 1e6).unwrap_err();
    assert!(matches!(error, AdvectError::TooManySubsteps { .. }) && error.to_string().contains("semi-Lagrangian"));
    let mut small = CellField::new(Grid::new([3, 3], 0.1).unwrap().layout());
    assert!(matches!(advector.advect(&mut small, None, &along, 0.1), Err(AdvectError::Layout { .. })));
    assert_eq!(phi, before);
    assert!((advector.stable_dt(&along).unwrap() - 0.09).abs() < 1e-15);
    assert_eq!(advector.advect(&mut phi, None, &along, 0.18 * (1.0 + 1e-15)).unwrap().substeps, 2);
    assert_eq!(advector.advect(&mut phi, None, &along, 0.19).unwrap().substeps, 3);
}

#[test]
fn transposed_data_in_a_transposed_flow_give_the_transposed_answer() {
    let (wide, tall) = (Grid::new([70, 11], 0.1).unwrap(), Grid::new([11, 70], 0.1).unwrap());
    let open = Wall::Open { inflow: 0.5 };
    for sides in [[Axis::Periodic; 2], [Axis::Walls([Wall::Value(2.0), open]), Axis::Walls([open; 2])]] {
        let turned = Sides([sides[1], sides[0]]);
        let whirl = |x: SVector<f64, 2>| SVector::from([(9.0 * x[1]).sin() + 0.5, (2.0 * x[0]).cos()]);
        let whirl_turned = |x: SVector<f64, 2>| SVector::from([(2.0 * x[1]).cos(), (9.0 * x[0]).sin() + 0.5]);
        let pairs = [
            (Medium::Uniform(SVector::from([0.7, -0.4])), Medium::Uniform(SVector::from([-0.4, 0.7]))),
            (Medium::Field(sample::<f64, 2>(&wide, whirl).unwrap()), Medium::Field(sample(&tall, whirl_turned).unwrap())),
        ];
        for ((medium, medium_turned), method) in pairs.iter().flat_map(|p| METHODS.map(|m| (p, m))) {
            let mut a = noisy::<f64, 2>(&wide);
            let mut b = CellField::new(tall.layout());
            tall.layout().par_cells(&mut b, |at| a[wide.layout().slot([at.cell[1], at.cell[0]])]);
            let mut first = Advector::new(&wide, &Sides(sides), None, method);
            let mut second = Advector::new(&tall, &turned, None, method);
            second.set_reversed(true);
            for _ in 0..4 {
                let x = first.advect(&mut a, None, medium, 0.11).unwrap();
                let y = second.advect(&mut b, None, medium_turned, 0.11).unwrap();
                approx::assert_relative_eq!(x.outflow, y.outflow, epsilon = 1e-13);
            }
            for at in 0..70 * 11 {
                let (i, j) = (at % 70, at / 70);
                approx::assert_relative_eq!(a[wide.layout().slot([i, j])], b[tall.layout().slot([j, i])], epsilon = 1e-12);
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let grid = Grid::new([203, 301], 0.01).unwrap();
            let sides = Sides([Axis::Periodic, Axis::Walls([Wall::Value(0.5); 2])]);
            let whirl = |x: SVector<f64, 2>| SVector::from([(9.0 * x[1]).sin(), (TAU * x[0] / 2.03).cos()]);
            let medium = Medium::Field(sample::<f32, 2>(&grid, whirl).unwrap());
            METHODS.map(|method| {
                let (mut phi, mut q) = (noisy::<f32, 2>(&grid), noisy_flux(&grid, &sides));
                let mut advector = Advector::new(&grid, &sides, None, method);
                let done = advector.advect(&mut phi, Some(&mut q), &medium, 0.02).unwrap();
                (phi, q, done.outflow.to_bits())
            })
        })
    };
    assert!(run(1) == run(2));
}

#[test]
fn solids_keep_their_values_and_nothing_leaks_through_them() {
    let grid = Grid::new([40, 12], 0.1).unwrap();
    // A full wall at x = 20: what is left of it never reaches the right.
    let mask = Mask::new(grid.layout(), |c| c[0] != 20);
    let sides = Sides([Axis::Walls([Wall::Open { inflow: 1.0 }; 2]), Axis::Periodic]);
    for method in [Advection::Muscl, Advection::Cubic, Advection::Linear] {
        let mut phi = CellField::<f64>::new(grid.layout());
        grid.layout().par_cells(&mut phi, |at| match at.cell[0] {
            20 => 77.0,
            i if i < 20 => 1.0,
            _ => 0.0,
        });
        let mut u = FaceField::new(grid.layout());
        grid.layout().par_region(grid.layout().faces_region(0, false), u.axis_mut(0), |at| if at.cell[0] < 20 { 1.0 } else { 0.0 });
        grid.layout().par_cells(u.axis_mut(1), |at| if at.cell[0] == 20 { 0.0 } else { 0.5 });
        let medium = Medium::Field(u);
        let mut advector = Advector::new(&grid, &sides, Some(&mask), method);
        for _ in 0..10 {
            advector.advect(&mut phi, None, &medium, 0.05).unwrap();
        }
        for j in 0..12 {
            let at = |i| phi[grid.layout().slot([i, j])];
            assert_eq!(at(20), 77.0);
            assert!((21..40).all(|i| at(i) == 0.0), "{method:?}");
            assert!((0..19).all(|i| (at(i) - 1.0).abs() < 1e-12), "{method:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn any_box_any_walls_any_velocity(
        cells in [1usize..20, 1..20, 1..8],
        kinds in [0usize..4, 0..4, 0..4],
        u in [-2.0f64..2.0, -2.0..2.0, -2.0..2.0],
        field in any::<bool>(),
        dt in 0.0f64..0.4,
    ) {
        let grid = Grid::new(cells, 0.1).unwrap();
        let axis = |kind| match kind {
            0 => Axis::Periodic,
            1 => Axis::Walls([Wall::Open { inflow: 0.3 }, Wall::Value(0.9)]),
            2 => Axis::Walls([Wall::Absorbing { speed: 1.0, far: 0.4 }, Wall::Open { inflow: 1.0 }]),
            _ => Axis::Walls([Wall::CLOSED, Wall::Flux(2.0)]),
        };
        let sides = Sides(kinds.map(axis));
        let mut velocity = SVector::from(u);
        for a in 0..3 {
            if kinds[a] == 3 { velocity[a] = 0.0 }
        }
        let wavy = |x: SVector<f64, 3>| SVector::<f64, 3>::from_fn(|a, _| velocity[a] * (1.0 + 0.5 * (x[(a + 1) % 3] * 7.0).sin()));
        let medium = if field { Medium::Field(sample::<f64, 3>(&grid, wavy).unwrap()) } else { Medium::Uniform(velocity) };
        for method in METHODS {
            let (mut phi, mut q) = (noisy::<f64, 3>(&grid), noisy_flux(&grid, &sides));
            let before = mass(&grid, &phi);
            let done = Advector::new(&grid, &sides, None, method).advect(&mut phi, Some(&mut q), &medium, dt).unwrap();
            let (low, high) = grid.layout().range(&phi);
            if method == Advection::Muscl {
                prop_assert!((mass(&grid, &phi) + done.outflow - before).abs() < 1e-12 * before.max(done.outflow.abs()));
                prop_assert!(low > -0.3 && high < 2.0, "{} {}", low, high);
            } else {
                prop_assert!(low >= 0.25 - 1e-12 && high <= 1.25 + 1e-12, "{} {}", low, high);
            }
            for q in q.axes() {
                prop_assert!(q.iter().all(|v| v.abs() <= 0.5 + 1e-12));
            }
        }
    }
}
