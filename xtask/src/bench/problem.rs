//! What is solved: a box, its walls, a strength, a tolerance, numbers, threads.

use cf_grid::{Layout, Mask, Real, Sides};
use clap::ValueEnum;
use std::fmt;
use std::str::FromStr;

/// Cells per axis, two or three of them: `256x256x256`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cells(pub Vec<usize>);

/// What all sides of the box are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Walls {
    /// Nothing goes through.
    Closed,
    /// Held at zero half a cell behind the last cell: conductance 2 kappa.
    Valued,
    /// Opposite sides are joined.
    Periodic,
}

/// Obstacles in the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Solids {
    /// None.
    Open,
    /// A ball of half the box's width in its middle.
    Ball,
    /// A wall of one cell across x, with a gap of two cells at one end.
    Wall,
    /// 15 % of the cells, chosen at random.
    Random,
    /// Seven walls of one cell across x, with gaps of two cells at alternate ends.
    Maze,
}

/// The equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Strength {
    /// alpha = 1 and this kappa = beta/h².
    Kappa(f64),
    /// alpha = 0 and kappa = 1.
    Poisson,
}

/// Precision of the vectors and of the preconditioner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Numbers {
    /// Both in double precision.
    F64,
    /// Double precision, preconditioned in single.
    Mixed,
    /// Both in single precision.
    F32,
}

/// Relative 2-norm of the residual at which a solve ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance(pub f64);

/// A solve to be measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    pub cells: Cells,
    pub walls: Walls,
    pub solids: Solids,
    pub strength: Strength,
    pub tolerance: Tolerance,
    pub numbers: Numbers,
    pub threads: usize,
}

impl Problem {
    /// The cells that are not solid; `None` where none is.
    pub fn mask<const D: usize>(&self, layout: &Layout<D>) -> Option<Mask<D>> {
        (self.solids != Solids::Open).then(|| Mask::new(layout, |cell| !self.solids.has(&cell, &self.cells.0)))
    }

    /// (alpha, kappa).
    pub fn coefficients(&self) -> (f64, f64) {
        match self.strength {
            Strength::Kappa(kappa) => (1.0, kappa),
            Strength::Poisson => (0.0, 1.0),
        }
    }

    /// The conductances of the walls.
    pub fn sides<const D: usize>(&self) -> Sides<f64, D> {
        match self.walls {
            Walls::Closed => Sides::all(0.0),
            Walls::Valued => Sides::all(2.0 * self.coefficients().1),
            Walls::Periodic => Sides::periodic(),
        }
    }

    /// Bytes of one number of a vector.
    pub fn bytes(&self) -> usize {
        if self.numbers == Numbers::F32 { size_of::<f32>() } else { size_of::<f64>() }
    }
}

impl Solids {
    /// Whether a cell of a box of `n` cells is solid.
    fn has(self, cell: &[usize], n: &[usize]) -> bool {
        // Wall `k` of so many: its gap is at the low end of y, or at the high one.
        let barrier = |walls: usize| {
            (1..=walls).any(|k| {
                let gap = if k % 2 == 1 { cell[1] < 2 } else { cell[1] + 2 >= n[1] };
                cell[0] == k * n[0] / (walls + 1) && !gap
            })
        };
        match self {
            Solids::Open => false,
            Solids::Ball => {
                let radius = 0.25 * n.iter().copied().min().unwrap_or(0) as f64;
                let away = |(&i, &n): (&usize, &usize)| (i as f64 + 0.5 - 0.5 * n as f64).powi(2);
                cell.iter().zip(n).map(away).sum::<f64>() < radius * radius
            }
            Solids::Wall => barrier(1),
            Solids::Random => {
                let other = cell.iter().map(|i| i + 1_000_000).collect::<Vec<_>>();
                0.5 * (rough(&other) + 1.0) < 0.15
            }
            Solids::Maze => barrier(7),
        }
    }
}

/// Noise in the fluid without its mean in each component: a right-hand side with every frequency, which a Poisson problem can
/// satisfy.
pub fn noise_around<T: Real, const D: usize>(mask: &Mask<D>, sides: &Sides<f64, D>) -> Vec<T> {
    let (layout, components) = (mask.layout(), mask.components(sides));
    let mut sums = vec![0.0; components.cells.len()];
    let component = |slot: usize| (components.label[slot] as usize).checked_sub(1);
    layout.each_cell(layout.cells_region(), |at| {
        if let Some(i) = component(at.slot()) {
            sums[i] += T::of(rough(&at.cell)).f64();
        }
    });
    let mut b = vec![T::ZERO; layout.slots()];
    layout.par_cells(&mut b, |at| match component(at.slot()) {
        Some(i) => T::of(T::of(rough(&at.cell)).f64() - sums[i] / components.cells[i] as f64),
        None => T::ZERO,
    });
    b
}

/// Noise without its mean: a right-hand side with every frequency, which a Poisson problem can satisfy.
pub fn noise<T: Real, const D: usize>(layout: &Layout<D>) -> Vec<T> {
    let mut b = vec![T::ZERO; layout.slots()];
    layout.par_cells(&mut b, |at| T::of(rough(&at.cell)));
    let mean = layout.sum(&b) / layout.count() as f64;
    // From the rounded numbers, so that a single cell gets zero in any precision.
    layout.par_cells(&mut b, |at| T::of(T::of(rough(&at.cell)).f64() - mean));
    b
}

/// A number between -1 and 1 that has nothing to do with its neighbours'; `benches/peers` has the same formula.
pub fn rough(cell: &[usize]) -> f64 {
    let mixed = cell.iter().fold(0x9E37_79B9_7F4A_7C15_u64, |h, &i| {
        let h = (h ^ i as u64).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        h ^ (h >> 29)
    });
    (mixed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl Cells {
    /// Their number; the largest there is where it is larger.
    pub fn count(&self) -> usize {
        self.0.iter().fold(1, |count, &n| count.saturating_mul(n))
    }
}

impl FromStr for Cells {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let axes: Result<Vec<usize>, _> = text.split('x').map(str::parse).collect();
        match axes {
            Ok(axes) if (2..=3).contains(&axes.len()) && !axes.contains(&0) => Ok(Cells(axes)),
            _ => Err("expected two or three axes of at least one cell, such as 1024x1024 or 128x128x128".into()),
        }
    }
}

impl FromStr for Strength {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("poisson", _) => Ok(Strength::Poisson),
            (_, Ok(kappa)) if f64::is_finite(kappa) && kappa > 0.0 => Ok(Strength::Kappa(kappa)),
            _ => Err("expected a positive number or `poisson`".into()),
        }
    }
}

impl FromStr for Tolerance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(tolerance) if tolerance > 0.0 && tolerance < 1.0 => Ok(Tolerance(tolerance)),
            _ => Err("expected a number between 0 and 1, such as 1e-6".into()),
        }
    }
}

impl fmt::Display for Cells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axes: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&axes.join("x"))
    }
}

impl fmt::Display for Walls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Walls::Closed => "closed",
            Walls::Valued => "valued",
            Walls::Periodic => "periodic",
        })
    }
}

impl fmt::Display for Solids {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Solids::Open => "open",
            Solids::Ball => "ball",
            Solids::Wall => "wall",
            Solids::Random => "random",
            Solids::Maze => "maze",
        })
    }
}

impl fmt::Display for Strength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // As many digits as a person reads.
            Strength::Kappa(kappa) if !(1e-3..1e6).contains(kappa) => write!(f, "{kappa:e}"),
            Strength::Kappa(kappa) => write!(f, "{kappa}"),
            Strength::Poisson => f.write_str("poisson"),
        }
    }
}

impl fmt::Display for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Numbers::F64 => "f64",
            Numbers::Mixed => "mixed",
            Numbers::F32 => "f32",
        })
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:e}", self.0)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Problem { cells, walls, solids, strength, tolerance, numbers, threads } = self;
        let kappa = if *strength == Strength::Poisson { "" } else { "kappa " };
        let plural = if *threads == 1 { "" } else { "s" };
        let solids = if *solids == Solids::Open { String::new() } else { format!(" around {solids} solids") };
        write!(f, "{cells} {walls}{solids} {kappa}{strength} to {tolerance} in {numbers}, {threads} thread{plural}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_read_and_printed_alike() {
        for text in ["1024x1024", "97x61x45"] {
            assert_eq!(text.parse::<Cells>().map(|cells| cells.to_string()).as_deref(), Ok(text));
        }
        for text in ["", "64", "8x8x8x8", "8x0", "8x-8", "8 x 8"] {
            assert!(text.parse::<Cells>().is_err(), "{text}");
        }
        for text in ["poisson", "0.1", "100000", "1e300", "1e-9"] {
            assert_eq!(text.parse::<Strength>().map(|strength| strength.to_string()).as_deref(), Ok(text));
        }
        for text in ["0", "-1", "inf", "NaN", "Laplace"] {
            assert!(text.parse::<Strength>().is_err(), "{text}");
        }
        assert_eq!("0.000001".parse::<Tolerance>().map(|t| t.to_string()).as_deref(), Ok("1e-6"));
        assert!(["0", "1", "NaN"].iter().all(|text| text.parse::<Tolerance>().is_err()));
    }

    #[test]
    fn solids_leave_a_way_and_no_mean() {
        let layout = Layout::new([32, 24]).unwrap();
        let share = |solids: Solids| {
            let (cells, tolerance) = (Cells(vec![32, 24]), Tolerance(1e-6));
            let (walls, strength, numbers) = (Walls::Closed, Strength::Poisson, Numbers::F64);
            let problem = Problem { cells, walls, solids, strength, tolerance, numbers, threads: 1 };
            let mask = problem.mask(&layout).unwrap();
            let components = mask.components(&problem.sides::<2>());
            let b = noise_around::<f64, 2>(&mask, &problem.sides());
            for i in 0..components.cells.len() {
                let inside = components.label.iter().zip(&b).filter(|(label, _)| **label as usize == i + 1);
                assert!(inside.map(|(_, b)| b).sum::<f64>().abs() < 1e-12, "{solids}");
            }
            (1.0 - mask.fluid_cells() as f64 / layout.count() as f64, components.cells.len())
        };
        let [ball, wall, random, maze] = [Solids::Ball, Solids::Wall, Solids::Random, Solids::Maze].map(share);
        assert!((ball.0 - 0.147).abs() < 0.02 && ball.1 == 1, "{ball:?}");
        assert!((wall.0 - 22.0 / 768.0).abs() < 1e-12 && wall.1 == 1, "{wall:?}");
        assert!((random.0 - 0.15).abs() < 0.04, "{random:?}");
        assert!((maze.0 - 7.0 * 22.0 / 768.0).abs() < 1e-12 && maze.1 == 1, "{maze:?}");
    }

    #[test]
    fn noise_has_no_mean_and_is_no_smaller_anywhere() {
        let layout = Layout::new([16, 8]).unwrap();
        let b = noise::<f64, 2>(&layout);
        assert!(layout.sum(&b).abs() < 1e-13);
        let square = layout.dot(&b, &b) / layout.count() as f64;
        assert!((square - 1.0 / 3.0).abs() < 0.1, "{square}");
        let one = Layout::new([1, 1]).unwrap();
        assert!(noise::<f32, 2>(&one).iter().all(|v| *v == 0.0));
    }
}
