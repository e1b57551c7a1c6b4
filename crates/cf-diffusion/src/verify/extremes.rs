//! Random cases at the edges of every parameter: tau, dt, F_T, k, h, amplitudes, offsets, media, grids, walls, input.

use std::fmt;

use super::Measured;
use super::amplification::Precise;
use super::corners;
use super::random::Random;

/// A corner of the parameters and how its cases went.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// What is at its edge.
    pub name: &'static str,
    /// What was expected of every case.
    pub expected: &'static str,
    /// Cases run.
    pub cases: usize,
    /// The worst case in units of what is allowed: above 1 it fails.
    pub worst: f64,
    /// Seed of that case, for [`repeat`].
    pub seed: u64,
    /// Whether every case passed.
    pub pass: bool,
    /// The error of a case that could not be run, else empty.
    pub note: String,
}

impl fmt::Display for Corner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = if self.pass { "ok  " } else { "FAIL" };
        write!(f, "{verdict} {:<12} {:>6} cases, worst {:>9.2e}", self.name, self.cases, self.worst)?;
        write!(f, " (seed {:#018x}): {}", self.seed, self.expected)?;
        if self.note.is_empty() { Ok(()) } else { write!(f, "; {}", self.note) }
    }
}

/// A random case, in any precision and dimension. The result is in units of what is allowed.
pub trait Check {
    /// What is at its edge.
    const NAME: &'static str;
    /// What is expected.
    const EXPECTED: &'static str;
    /// One case.
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured;
}

/// A [`Check`] in `f32` and `f64`, in two and three dimensions.
#[derive(Clone, Copy)]
pub struct Edge {
    name: &'static str,
    expected: &'static str,
    kinds: [fn(&mut Random) -> Measured; 4],
}

impl Edge {
    /// That of a check.
    pub const fn of<C: Check>() -> Self {
        let kinds = [C::run::<f32, 2>, C::run::<f32, 3>, C::run::<f64, 2>, C::run::<f64, 3>];
        Self { name: C::NAME, expected: C::EXPECTED, kinds }
    }

    fn case(&self, seed: u64) -> Measured {
        let mut random = Random(seed);
        self.kinds[random.below(4)](&mut random)
    }

    /// Runs `count` cases in all at `edges`, the same for the same `seed`.
    pub fn run_all(edges: &[Edge], count: usize, seed: u64) -> Vec<Corner> {
        let each = count.div_ceil(edges.len().max(1));
        let mut seeds = Random(seed);
        edges.iter().map(|edge| Corner::of(edge, each, &mut seeds)).collect()
    }

    /// The names of all.
    pub fn names(edges: &[Edge]) -> Vec<&'static str> {
        edges.iter().map(|edge| edge.name).collect()
    }

    /// Runs `count` cases of one corner, the same for the same `seed`; `None` if there is no corner of that name.
    pub fn run_one(edges: &[Edge], name: &str, count: usize, seed: u64) -> Option<Corner> {
        edges.iter().find(|edge| edge.name == name).map(|edge| Corner::of(edge, count, &mut Random(seed)))
    }

    /// Runs one case of a corner again; `None` if there is no corner of that name.
    pub fn repeat(edges: &[Edge], name: &str, seed: u64) -> Option<Measured> {
        edges.iter().find(|edge| edge.name == name).map(|edge| edge.case(seed))
    }
}

impl Corner {
    /// Runs `cases` cases with seeds drawn from `seeds`.
    fn of(edge: &Edge, cases: usize, seeds: &mut Random) -> Self {
        let Edge { name, expected, .. } = *edge;
        let mut all =
            Self { name, expected, cases, worst: f64::NEG_INFINITY, seed: 0, pass: true, note: String::new() };
        for _ in 0..cases {
            let seed = seeds.bits();
            let (found, note) = match edge.case(seed) {
                Ok(found) => (found, String::new()),
                Err(why) => (f64::INFINITY, why.to_string()),
            };
            // NaN is worse than anything.
            let pass = found <= 1.0;
            let worse = found > all.worst || found.is_nan();
            if worse && all.worst != f64::INFINITY {
                (all.worst, all.seed, all.note) = (if found.is_nan() { f64::INFINITY } else { found }, seed, note);
            }
            all.pass &= pass;
        }
        all
    }
}

const EDGES: [Edge; 18] = [
    Edge::of::<corners::Relaxation>(),
    Edge::of::<corners::Step>(),
    Edge::of::<corners::Share>(),
    Edge::of::<corners::Diffusivity>(),
    Edge::of::<corners::Spacing>(),
    Edge::of::<corners::Amplitude>(),
    Edge::of::<corners::Offset>(),
    Edge::of::<corners::Transport>(),
    Edge::of::<corners::Pockets>(),
    Edge::of::<corners::Walls>(),
    Edge::of::<corners::Input>(),
    Edge::of::<corners::Explicit>(),
    Edge::of::<corners::Stiffness>(),
    Edge::of::<corners::Residual>(),
    Edge::of::<corners::LongRun>(),
    Edge::of::<corners::Single>(),
    Edge::of::<corners::Budget>(),
    Edge::of::<corners::Fronts>(),
];

/// Runs `count` cases in all, the same for the same `seed`.
pub fn extremes(count: usize, seed: u64) -> Vec<Corner> {
    Edge::run_all(&EDGES, count, seed)
}

/// The names of the corners.
pub fn corner_names() -> Vec<&'static str> {
    Edge::names(&EDGES)
}

/// Runs `count` cases of one corner; `None` if there is no corner of that name.
pub fn corner(name: &str, count: usize, seed: u64) -> Option<Corner> {
    Edge::run_one(&EDGES, name, count, seed)
}

/// Runs one case of a corner again; `None` if there is no corner of that name.
pub fn repeat(name: &str, seed: u64) -> Option<Measured> {
    Edge::repeat(&EDGES, name, seed)
}
