//! PCG-multigrid over obstacles: it converges on all of them, in a number of steps that is written down here.

use cf_grid::Real;
use cf_linear::{Options, Plan, Precision, Solver, Stop};

use crate::common::*;

fn count<T: Real, const D: usize>(case: &Case<D>, precision: Precision, what: &str) -> usize {
    let options = Options { plan: Some(Plan::Multigrid), precision, ..Default::default() };
    let mut solver = Solver::<T, D>::new(&case.helmholtz(), options).unwrap();
    let (b, mut x) = (random_field::<T, D>(&case.layout, 7), vec![T::ZERO; case.layout.slots()]);
    match solver.solve(&b, &mut x, Stop::Relative(1e-6)) {
        Ok(s) => s.iterations,
        Err(e) => panic!("{what} kappa {:e} {} {precision:?}: {e}", case.kappa, T::NAME),
    }
}

/// Closed and periodic, f64, f32 and mixed, kappa 100, 1e5 and Poisson.
fn check<const D: usize>(cells: [usize; D], what: &str, allowed: usize, fluid: impl Fn([usize; D]) -> bool + Copy) {
    for mix in [[CLOSED; D], [None; D]] {
        let counts: Vec<[usize; 3]> = [(1.0, 100.0), (1.0, 1e5), (0.0, 1.0)]
            .into_iter()
            .map(|(alpha, kappa)| {
                let case = Case::new(cells, mix, alpha, kappa).masked(fluid);
                [
                    count::<f64, D>(&case, Precision::Full, what),
                    count::<f64, D>(&case, Precision::Single, what),
                    count::<f32, D>(&case, Precision::Full, what),
                ]
            })
            .collect();
        println!("{what} {:?} f64, mixed, f32 at kappa 100, 1e5, Poisson: {counts:?}", mix[0]);
        let worst = counts.as_flattened().iter().copied().max().unwrap_or(0);
        assert!(worst <= allowed, "{what} {:?}: {counts:?}", mix[0]);
    }
}

fn distance<const D: usize>(c: [usize; D], centre: [f64; D]) -> f64 {
    (0..D).map(|a| (c[a] as f64 + 0.5 - centre[a]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn discs() {
    check([128, 128], "disc", 8, |c| distance(c, [60.0, 70.0]) > 20.0);
    check([128, 128], "25 discs", 8, |c| distance(c.map(|i| i % 25), [12.0; 2]) > 7.0);
}

#[test]
fn thin_walls_and_random_solids() {
    check([128, 128], "one-cell wall", 12, |c| c[0] != 63 || c[1] < 20);
    check([128, 128], "15 % random", 12, random_pattern);
    check([97, 61], "15 % random, odd", 12, random_pattern);
    check([97, 61], "a cut box", 12, |c| c[0] != 40);
}

fn random_pattern<const D: usize>(c: [usize; D]) -> bool {
    random_solids(15.0, 11)(c)
}

#[test]
fn mazes_and_pockets_converge() {
    check([128, 128], "maze", 40, |c| maze([128, 128], 16)(c));
    check([61, 47], "narrow maze", 26, |c| maze([61, 47], 4)(c));
    check([64, 64], "pocket", 9, pockets);
    check([40, 64], "chequers", 9, |c| (c[0] + c[1]) % 2 == 0 || c[0] > 20);
    check([64, 64], "half of it random", 34, |c| random_solids(45.0, 11)(c));
    check([50, 50], "one cell", 1, |c| c == [20, 30]);
    check([50, 50], "solid", 0, |_| false);
}

#[test]
fn space() {
    check([32; 3], "sphere and plate", 12, |c| distance(c, [16.0, 15.0, 10.0]) > 6.0 && (c[2] != 21 || c[0] < 8));
    check([24; 3], "15 % random in space", 8, random_pattern);
    check([21, 24, 19], "maze in space", 16, |c| maze([21, 24, 19], 4)(c));
    check([16; 3], "pocket in space", 9, pockets);
}
