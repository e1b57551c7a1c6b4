//! PCG-multigrid iterations to a relative 2-norm residual of 1e-6 from a zero guess, on random right-hand sides.

use cf_grid::{Axis, Layout, Sides};
use cf_linear::{Helmholtz, Options, Plan, Precision, Solver, Stop};

/// Deterministic noise in [-1, 1).
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Closed,
    Held,
    Absorbing,
}

fn conductance(end: End, kappa: f64) -> f64 {
    match end {
        End::Closed => 0.0,
        End::Held => 2.0 * kappa,
        End::Absorbing => 0.7 * kappa.sqrt(),
    }
}

/// Every mix of an axis: periodic, or two of the ends.
fn axis_mixes() -> Vec<Option<[End; 2]>> {
    vec![
        None,
        Some([End::Closed, End::Closed]),
        Some([End::Held, End::Held]),
        Some([End::Closed, End::Held]),
        Some([End::Absorbing, End::Closed]),
    ]
}

fn solve<const D: usize>(
    cells: [usize; D],
    mix: [Option<[End; 2]>; D],
    alpha: f64,
    kappa: f64,
    precision: Precision,
) -> usize {
    let layout = Layout::new(cells).unwrap();
    let walls = Sides(mix.map(|m| match m {
        None => Axis::Periodic,
        Some(ends) => Axis::Walls(ends.map(|e| conductance(e, kappa))),
    }));
    let operator = Helmholtz::new(&layout, alpha, kappa, walls);
    let options = Options { plan: Some(Plan::Multigrid), precision, ..Default::default() };
    let mut solver = Solver::<f64, D>::new(&operator, options).unwrap();
    let mut random = noise(7);
    let mut b = vec![0.0; layout.slots()];
    layout.each_cell(layout.cells_region(), |at| b[at.slot()] = random());
    let mut x = vec![0.0; layout.slots()];
    match solver.solve(&b, &mut x, Stop::Relative(1e-6)) {
        Ok(s) => s.iterations,
        Err(e) => panic!("{cells:?} {mix:?} alpha {alpha} kappa {kappa:e}: {e}"),
    }
}

fn worst<const D: usize>(cells: [usize; D], mixes: &[[Option<[End; 2]>; D]], allowed: usize) {
    let mut worst = (0, String::new());
    for &mix in mixes {
        for kappa in [1e-6, 1e-3, 0.1, 1.0, 10.0, 1e3, 1e5, 1e8, 1e12] {
            let n = solve(cells, mix, 1.0, kappa, Precision::Full);
            if n > worst.0 {
                worst = (n, format!("{mix:?} kappa {kappa:e}"));
            }
        }
        let n = solve(cells, mix, 0.0, 1.0, Precision::Full);
        if n > worst.0 {
            worst = (n, format!("{mix:?} Poisson"));
        }
    }
    println!("{cells:?}: {} at {}", worst.0, worst.1);
    if std::env::var("SHOW").is_ok() {
        return;
    }
    assert!(worst.0 <= allowed, "{cells:?}: {} iterations at {}", worst.0, worst.1);
}

fn mixes_2d() -> Vec<[Option<[End; 2]>; 2]> {
    let m = axis_mixes();
    m.iter().flat_map(|&a| m.iter().map(move |&b| [a, b])).collect()
}

fn mixes_3d() -> Vec<[Option<[End; 2]>; 3]> {
    let m = axis_mixes();
    // Every kind on every axis, and the pure ones.
    (0..5).flat_map(|i| [[m[i]; 3], [m[i], m[(i + 1) % 5], m[(i + 2) % 5]], [m[i], m[(i + 3) % 5], m[1]]]).collect()
}

#[test]
fn even_boxes_need_at_most_8() {
    worst([128, 128], &mixes_2d(), 8);
    worst([32, 64], &mixes_2d(), 8);
    worst([32, 32, 32], &mixes_3d(), 8);
    worst([64, 32, 16], &mixes_3d(), 8);
}

#[test]
fn other_sizes_need_at_most_10() {
    worst([97, 61], &mixes_2d(), 10);
    worst([33, 33, 33], &mixes_3d(), 10);
    worst([97, 61, 45], &mixes_3d()[..6], 10);
    worst([3, 5, 7], &mixes_3d(), 10);
    for n in [1, 2, 3, 5, 17, 100, 1001] {
        worst([1, n], &mixes_2d(), 10);
        worst([n, 1], &mixes_2d(), 10);
    }
    worst([1, 1, 77], &mixes_3d(), 10);
    worst([50, 3], &mixes_2d(), 10);
    worst([127, 129], &mixes_2d(), 10);
}

#[test]
fn single_precision_cycles_need_no_more_iterations() {
    for kappa in [1.0, 1e4, 1e8] {
        for mix in [[None; 2], [Some([End::Closed; 2]); 2], [Some([End::Held; 2]); 2]] {
            let (full, single) = (
                solve([96, 64], mix, 1.0, kappa, Precision::Full),
                solve([96, 64], mix, 1.0, kappa, Precision::Single),
            );
            assert!(single <= full + 1, "kappa {kappa:e}: {full} {single}");
        }
    }
}
