//! Orders of accuracy, the model's round trip, symmetry, threads.

use std::f64::consts::{PI, TAU};

use cf_grid::{Axis, CellField, Grid, Sides, Wall};
use nalgebra::SVector;

use super::{METHODS, difference, noisy, noisy_flux, vortex};
use crate::advect::{Advection, Advector};
use crate::medium::{Medium, sample};

fn bump(x: f64) -> f64 {
    1.0 + (TAU * x).sin()
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

#[test]
fn orders_of_accuracy() {
    for (method, least) in
        [(Advection::Muscl, [1.8, 1.9]), (Advection::Cubic, [1.9, 2.5]), (Advection::Linear, [0.8, 0.8])]
    {
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
    for (method, courant, model) in [
        (Advection::Linear, 0.5, 7.7e-1),
        (Advection::Cubic, 0.5, 5.8e-2),
        (Advection::Cubic, 3.0, 2.9e-2),
        (Advection::Muscl, 0.5, 7.7e-2),
        (Advection::Muscl, 0.9, 6.8e-2),
    ] {
        let error = deformation(method, 128, courant, bell);
        println!("{method:?} CFL {courant}: {error:.3e}, model {model:.1e}");
        assert!(error < 1.5 * model, "{method:?} CFL {courant}: {error:.3e} against {model:.1e}");
    }
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
            (
                Medium::Field(sample::<f64, 2>(&wide, whirl).unwrap()),
                Medium::Field(sample(&tall, whirl_turned).unwrap()),
            ),
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
                approx::assert_relative_eq!(
                    a[wide.layout().slot([i, j])],
                    b[tall.layout().slot([j, i])],
                    epsilon = 1e-12
                );
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

/// One cell per step in a uniform medium moves every value by one cell, to rounding, and needs no sub-steps.
#[test]
fn courant_one_is_an_exact_shift() {
    let grid = Grid::new([12, 9], 0.25).unwrap();
    let layout = *grid.layout();
    let mut phi = CellField::<f64>::new(&layout);
    layout.par_cells(&mut phi, |at| ((at.cell[0] * 31 + at.cell[1] * 17) % 23) as f64);
    let before = phi.clone();
    let mut advector = Advector::new(&grid, &Sides::periodic(), None, Advection::Muscl);
    let done = advector.advect(&mut phi, None, &Medium::Uniform(SVector::from([0.5, -0.5])), 0.5).unwrap();
    assert_eq!(done.substeps, 1);
    layout.each_cell(layout.cells_region(), |at| {
        let from = [(at.cell[0] + 11) % 12, (at.cell[1] + 1) % 9];
        assert!((phi[at.slot()] - before[layout.slot(from)]).abs() < 1e-13);
    });
}
