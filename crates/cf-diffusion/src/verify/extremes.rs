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

/// A corner's random case, in any precision and dimension. The result is in units of what is allowed.
pub(super) trait Check {
    const NAME: &'static str;
    const EXPECTED: &'static str;
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured;
}

fn one<C: Check>(seed: u64) -> Measured {
    let mut random = Random(seed);
    match random.below(4) {
        0 => C::run::<f32, 2>(&mut random),
        1 => C::run::<f32, 3>(&mut random),
        2 => C::run::<f64, 2>(&mut random),
        _ => C::run::<f64, 3>(&mut random),
    }
}

impl Corner {
    /// Runs `cases` cases with seeds drawn from `seeds`; each returns what it found in units of what is allowed.
    pub fn of(
        name: &'static str,
        expected: &'static str,
        cases: usize,
        seeds: &mut Random,
        case: impl Fn(u64) -> Measured,
    ) -> Self {
        let mut all =
            Self { name, expected, cases, worst: f64::NEG_INFINITY, seed: 0, pass: true, note: String::new() };
        for _ in 0..cases {
            let seed = seeds.bits();
            let (found, note) = match case(seed) {
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

macro_rules! corners {
    ($($name:ident),+ $(,)?) => {
        /// Runs `count` cases in all, the same for the same `seed`.
        pub fn extremes(count: usize, seed: u64) -> Vec<Corner> {
            let kinds = [$(corners::$name::NAME),+].len();
            let each = count.div_ceil(kinds);
            let mut seeds = Random(seed);
            vec![$({
                type Kind = corners::$name;
                Corner::of(Kind::NAME, Kind::EXPECTED, each, &mut seeds, one::<Kind>)
            }),+]
        }

        /// Runs one case of a corner again; `None` if there is no corner of that name.
        pub fn repeat(name: &str, seed: u64) -> Option<Measured> {
            $(if name == corners::$name::NAME {
                return Some(one::<corners::$name>(seed));
            })+
            None
        }
    };
}

corners!(
    Relaxation,
    Step,
    Share,
    Diffusivity,
    Spacing,
    Amplitude,
    Offset,
    Transport,
    Pockets,
    Walls,
    Input,
    Explicit,
    Stiffness,
    Residual,
    LongRun,
    Single,
    Budget,
    Fronts,
);
