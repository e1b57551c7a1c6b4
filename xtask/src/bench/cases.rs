//! Which problems are measured. Without flags, every axis is varied around one central case; a flag fixes an axis, the
//! others stay at the centre; `--all` takes every combination.

use super::problem::{Cells, Numbers, Problem, Solids, Strength, Tolerance, Walls};
use crate::cli::SolverArgs;

/// Smaller tolerances are below what single precision resolves.
const FINEST_F32: f64 = f32::EPSILON as f64;

/// Values per axis.
#[derive(Clone)]
struct Axes {
    cells: Vec<Cells>,
    walls: Vec<Walls>,
    solids: Vec<Solids>,
    strength: Vec<Strength>,
    tolerance: Vec<Tolerance>,
    numbers: Vec<Numbers>,
    threads: Vec<usize>,
}

impl Axes {
    /// 256³ between closed walls, Poisson, to 1e-6 in f64 with all threads.
    fn centre(threads: usize) -> Self {
        Axes {
            cells: vec![Cells(vec![256; 3])],
            walls: vec![Walls::Closed],
            solids: vec![Solids::Open],
            strength: vec![Strength::Poisson],
            tolerance: vec![Tolerance(1e-6)],
            numbers: vec![Numbers::F64],
            threads: vec![threads],
        }
    }

    /// Everything.
    fn whole(threads: usize) -> Self {
        let cells: [&[usize]; 5] = [&[1024; 2], &[2048; 2], &[128; 3], &[256; 3], &[512, 256, 256]];
        Axes {
            cells: cells.map(|axes| Cells(axes.to_vec())).to_vec(),
            walls: vec![Walls::Closed, Walls::Valued, Walls::Periodic],
            // A maze takes three times as many iterations, and is only measured where asked for.
            solids: vec![Solids::Open, Solids::Ball, Solids::Wall, Solids::Random],
            strength: [0.1, 10.0, 1e3, 1e5].map(Strength::Kappa).into_iter().chain([Strength::Poisson]).collect(),
            tolerance: vec![Tolerance(1e-6), Tolerance(1e-10)],
            numbers: vec![Numbers::F64, Numbers::Mixed, Numbers::F32],
            threads: one_and(threads),
        }
    }

    /// What is compared with others.
    fn peers(threads: usize) -> Self {
        Axes {
            cells: vec![Cells(vec![128; 3]), Cells(vec![256; 3])],
            tolerance: vec![Tolerance(1e-6), Tolerance(1e-10)],
            threads: one_and(threads),
            ..Axes::centre(threads)
        }
    }

    /// With the axes that were asked for in place of its own.
    fn asked(self, asked: &SolverArgs) -> Self {
        Axes {
            cells: asked_or(&asked.cells, self.cells),
            walls: asked_or(&asked.walls, self.walls),
            solids: asked_or(&asked.solids, self.solids),
            strength: asked_or(&asked.kappa, self.strength),
            tolerance: asked_or(&asked.tolerance, self.tolerance),
            numbers: asked_or(&asked.precision, self.numbers),
            threads: asked_or(&asked.threads.iter().map(|&n| n.into()).collect::<Vec<_>>(), self.threads),
        }
    }

    /// Every combination that the numbers can resolve.
    fn product(&self) -> Vec<Problem> {
        let boxes = pairs(&pairs(&self.cells, &self.walls), &self.solids);
        let operators = pairs(&boxes, &self.strength);
        let methods = pairs(&pairs(&self.tolerance, &self.numbers), &self.threads);
        let mut cases: Vec<Problem> = pairs(&operators, &methods)
            .into_iter()
            .map(|((((cells, walls), solids), strength), ((tolerance, numbers), threads))| Problem {
                cells,
                walls,
                solids,
                strength,
                tolerance,
                numbers,
                threads,
            })
            .collect();
        cases.retain(|case| case.numbers != Numbers::F32 || case.tolerance.0 >= FINEST_F32);
        cases
    }

    /// One axis at a time around the centre.
    fn star(self, centre: &Axes) -> Vec<Problem> {
        let arms = [
            Axes { cells: self.cells, ..centre.clone() },
            Axes { walls: self.walls, ..centre.clone() },
            Axes { solids: self.solids, ..centre.clone() },
            Axes { strength: self.strength, ..centre.clone() },
            Axes { tolerance: self.tolerance, ..centre.clone() },
            Axes { numbers: self.numbers, ..centre.clone() },
            Axes { threads: self.threads, ..centre.clone() },
        ];
        let mut cases: Vec<Problem> = Vec::new();
        for case in arms.iter().flat_map(Axes::product) {
            if !cases.contains(&case) {
                cases.push(case);
            }
        }
        cases
    }
}

/// Every value of one list with every value of another.
fn pairs<A: Clone, B: Clone>(a: &[A], b: &[B]) -> Vec<(A, B)> {
    a.iter().flat_map(|a| b.iter().map(move |b| (a.clone(), b.clone()))).collect()
}

/// 1 and all, which may be the same.
fn one_and(threads: usize) -> Vec<usize> {
    if threads > 1 { vec![1, threads] } else { vec![1] }
}

fn asked_or<V: Clone>(asked: &[V], own: Vec<V>) -> Vec<V> {
    if asked.is_empty() { own } else { asked.to_vec() }
}

/// What our solver is measured on; `threads` are all there are.
pub fn ours(asked: &SolverArgs, threads: usize) -> Vec<Problem> {
    let (centre, whole) = (Axes::centre(threads), Axes::whole(threads));
    match (asked.all, asked.fixes_an_axis()) {
        (true, _) => whole.asked(asked).product(),
        (false, true) => centre.asked(asked).product(),
        (false, false) => whole.star(&centre),
    }
}

/// What is compared with others, which know double precision and boxes without obstacles only.
pub fn peers(asked: &SolverArgs, threads: usize) -> Vec<Problem> {
    let mut cases = Axes::peers(threads).asked(asked).product();
    cases.retain(|case| case.numbers == Numbers::F64 && case.solids == Solids::Open);
    cases
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_varies_one_axis_at_a_time() {
        let cases = ours(&SolverArgs::default(), 2);
        assert_eq!(cases.len(), 1 + 4 + 2 + 3 + 4 + 1 + 2 + 1);
        assert_eq!(ours(&SolverArgs::default(), 1).len(), cases.len() - 1);
    }

    #[test]
    fn everything_is_every_combination_that_numbers_resolve() {
        let all = SolverArgs { all: true, ..SolverArgs::default() };
        assert_eq!(ours(&all, 2).len(), 5 * 3 * 4 * 5 * (2 * 2 + 1) * 2);
        let flat = SolverArgs { cells: vec![Cells(vec![8, 8])], ..all };
        assert_eq!(ours(&flat, 2).len(), 3 * 4 * 5 * (2 * 2 + 1) * 2);
    }

    #[test]
    fn a_flag_fixes_its_axis_and_leaves_the_others_at_the_centre() {
        let asked = SolverArgs { kappa: vec![Strength::Kappa(7.0)], ..SolverArgs::default() };
        let cases = ours(&asked, 2);
        assert_eq!(cases.len(), 1);
        assert_eq!(cases[0].to_string(), "256x256x256 closed kappa 7 to 1e-6 in f64, 2 threads");
        assert_eq!(peers(&asked, 2).len(), 2 * 2 * 2);
        let single = SolverArgs { precision: vec![Numbers::F32], ..SolverArgs::default() };
        assert!(peers(&single, 2).is_empty());
        let obstacles = SolverArgs { solids: vec![Solids::Maze], ..SolverArgs::default() };
        assert_eq!((ours(&obstacles, 2).len(), peers(&obstacles, 2).len()), (1, 0));
    }
}
