//! The canonical problems with their solutions.

use crate::disc::Disc;
use crate::error::TradeoffError;
use crate::judge;
use crate::measured::{Measured, median};
use crate::run::{self, Run};
use crate::setting::{Numbers, Scheme, Setting};
use crate::wake::Wake;
use cf_diffusion::exact::Telegraph;
use cf_diffusion::{Law, Medium, Source, State};
use cf_grid::{Axis, CellField, Grid, Sides, Wall};
use cf_spectral::{Spectral, smooth};

/// A first run longer than this \[s\] needs no warming up and counts.
const LONG: f64 = 1.0;

/// A problem on one grid in two or three dimensions, without slow flux at the start.
pub struct Problem {
    name: String,
    kind: Kind,
}

enum Kind {
    Plane(Box<On<2>>),
    Space(Box<On<3>>),
}

/// A problem on a grid.
pub(crate) struct On<const D: usize> {
    pub grid: Grid<D>,
    pub sides: Sides<Wall, D>,
    pub law: Law,
    /// Of the medium \[m/s\].
    pub velocity: [f64; D],
    /// W \[P/s\].
    pub rate: Option<CellField<f64>>,
    /// When it is judged \[s\].
    pub end: f64,
    /// phi at the start.
    pub start: CellField<f64>,
    /// phi at the end.
    pub exact: CellField<f64>,
    /// phi at the end of the equations that are discrete in space alone, where they are known.
    pub semi: Option<CellField<f64>>,
    /// Height of the front at the end, on a line.
    pub front: Option<f64>,
    /// Height of the jump at the start.
    pub jump: Option<f64>,
    /// The cone of the source.
    pub wake: Option<Wake>,
}

impl Problem {
    /// P1: φ₀ = e^{−(r/0.05)²} in the middle of a closed unit box in `dimension` = 2 or 3 dimensions, until 1 s.
    pub fn gaussian(dimension: usize, n: usize, law: Law) -> Result<Self, TradeoffError> {
        let name = format!("P1 {dimension}D, F_T = {}, tau = {} s", law.fourier_share(), law.tau());
        let kind = match dimension {
            3 => Kind::Space(Box::new(gaussian(n, law, 0.05, 1.0)?)),
            _ => Kind::Plane(Box::new(gaussian(n, law, 0.05, 1.0)?)),
        };
        Ok(Self { name, kind })
    }

    /// The Gaussian that other programs are timed on: k = 0.05 m²/s, τ = 0.02 s, until 0.2 s.
    pub fn telegraph(n: usize) -> Result<Self, TradeoffError> {
        let on = gaussian(n, Law::cattaneo(0.05, 0.02)?, 0.05, 0.2)?;
        Ok(Self { name: "telegraph".into(), kind: Kind::Plane(Box::new(on)) })
    }

    /// The line of 1 m with a Gaussian in its middle, periodic, on which the integrators' errors in time are tabulated.
    pub fn orders(n: usize, law: Law) -> Result<Self, TradeoffError> {
        Ok(Self { name: "line".into(), kind: Kind::Plane(Box::new(crate::line::gaussian(n, law)?)) })
    }

    /// P2 in one dimension: 1 on the left half of 3 cτ, 0 on the right, c = τ = 1, until 0.8 τ.
    /// `n` must be even.
    pub fn line(n: usize) -> Result<Self, TradeoffError> {
        let grid = Grid::<2>::new([n, 1], 3.0 / n as f64)?;
        let sides = Sides([Axis::Walls([Wall::CLOSED; 2]), Axis::Periodic]);
        let law = Law::cattaneo(1.0, 1.0)?;
        let Some(telegraph) = Telegraph::new(&law) else { unreachable!("a law of waves has a telegraph equation") };
        let start = field(&grid, |cell| telegraph.riemann_phi(grid.centre(cell)[0] - 1.5, 0.0));
        // Means over cells: the front stands inside one.
        const POINTS: usize = 256;
        let exact = field(&grid, |cell| {
            let at = |s: usize| (cell[0] as f64 + (s as f64 + 0.5) / POINTS as f64) * grid.h() - 1.5;
            (0..POINTS).map(|s| telegraph.riemann_phi(at(s), 0.8)).sum::<f64>() / POINTS as f64
        });
        let mut on = On::still(grid, sides, law, 0.8, start, exact)?;
        (on.front, on.jump) = (Some(telegraph.front(0.8)), Some(1.0));
        Ok(Self { name: "P2 line".into(), kind: Kind::Plane(Box::new(on)) })
    }

    /// P2 in two: 1 in a disc of radius 0.4 cτ amid a box of 2.4 cτ, c = τ = 1, until 0.6 τ: its inner front has been
    /// through the centre, its outer one has not reached the walls. `n` must be even.
    pub fn disc(n: usize) -> Result<Self, TradeoffError> {
        const RADIUS: f64 = 0.4;
        let law = Law::cattaneo(1.0, 1.0)?;
        let Some(disc) = Disc::new(&law, RADIUS) else { unreachable!("a law of waves has fronts") };
        let half = n / 2;
        let grid = Grid::<2>::new([2 * half; 2], 1.2 / half as f64)?;
        let quarter = disc.means(half, grid.h(), 0.6);
        let fold = |i: usize| if i < half { half - 1 - i } else { i - half };
        let exact = field(&grid, |cell| quarter[fold(cell[1]) * half + fold(cell[0])]);
        const POINTS: usize = 32;
        let start = field(&grid, |cell| {
            let inside = |s: usize| {
                let at = |i: usize, s: usize| (i as f64 + (s as f64 + 0.5) / POINTS as f64) * grid.h() - 1.2;
                at(cell[0], s % POINTS).hypot(at(cell[1], s / POINTS)) < RADIUS
            };
            (0..POINTS * POINTS).filter(|&s| inside(s)).count() as f64 / (POINTS * POINTS) as f64
        });
        let mut on = On::still(grid, Sides::all(Wall::CLOSED), law, 0.6, start, exact)?;
        on.jump = Some(1.0);
        Ok(Self { name: "P2 disc".into(), kind: Kind::Plane(Box::new(on)) })
    }

    /// P3: a steady Gaussian source in a uniform flow of 1 m/s, H_c = |u|/c by the total k, periodic in both directions
    /// and judged before anything has come around.
    pub fn wake(n: usize, hc: f64, share: f64) -> Result<Self, TradeoffError> {
        let name = format!("P3 H_c = {hc:.3}, F_T = {share}");
        Ok(Self { name, kind: Kind::Plane(Box::new(crate::wake::wake(n, hc, share)?)) })
    }

    /// Its name, without the grid.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The law.
    pub fn law(&self) -> &Law {
        match &self.kind {
            Kind::Plane(on) => &on.law,
            Kind::Space(on) => &on.law,
        }
    }

    /// When it is judged \[s\].
    pub fn end(&self) -> f64 {
        match &self.kind {
            Kind::Plane(on) => on.end,
            Kind::Space(on) => on.end,
        }
    }

    /// Cell size \[m\].
    pub fn h(&self) -> f64 {
        match &self.kind {
            Kind::Plane(on) => on.grid.h(),
            Kind::Space(on) => on.grid.h(),
        }
    }

    /// Cells per axis.
    pub fn cells(&self) -> Vec<usize> {
        match &self.kind {
            Kind::Plane(on) => on.grid.cells().to_vec(),
            Kind::Space(on) => on.grid.cells().to_vec(),
        }
    }

    /// φ at the start by cell, x contiguous.
    pub fn start(&self) -> Vec<f64> {
        match &self.kind {
            Kind::Plane(on) => judge::compact(on, &on.start),
            Kind::Space(on) => judge::compact(on, &on.start),
        }
    }

    /// φ at the end by cell, x contiguous.
    pub fn exact(&self) -> Vec<f64> {
        match &self.kind {
            Kind::Plane(on) => judge::compact(on, &on.exact),
            Kind::Space(on) => judge::compact(on, &on.exact),
        }
    }

    /// The half angle that the ridges of the solution enclose with the flow \[degrees\]; not a number without a cone.
    pub fn exact_angle(&self) -> f64 {
        match &self.kind {
            Kind::Plane(on) => judge::angle(on, &on.exact),
            Kind::Space(_) => f64::NAN,
        }
    }

    /// Runs a setting once to warm up and `runs` times for its time, and judges φ; also gives φ by cell, x contiguous.
    pub fn measure(&self, setting: &Setting, runs: usize) -> Result<(Measured, Vec<f64>), TradeoffError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(setting.threads).build()?;
        pool.install(|| {
            let first = self.run(setting)?;
            let mut times: Vec<f64> =
                (first.seconds > LONG || runs == 0).then_some(first.seconds).into_iter().collect();
            while times.len() < runs {
                times.push(self.run(setting)?.seconds);
            }
            let mut measured = match &self.kind {
                Kind::Plane(on) => judge::judge(on, setting, &first),
                Kind::Space(on) => judge::judge(on, setting, &first),
            };
            measured.problem.clone_from(&self.name);
            (measured.seconds, measured.runs) = (median(times.iter().copied()), times.len());
            let phi = match &self.kind {
                Kind::Plane(on) => judge::compact(on, &first.phi),
                Kind::Space(on) => judge::compact(on, &first.phi),
            };
            Ok((measured, phi))
        })
    }

    fn run(&self, setting: &Setting) -> Result<Run, TradeoffError> {
        let single = setting.numbers == Numbers::F32;
        let unsuited = || TradeoffError::Unsuited { scheme: setting.scheme, problem: self.name.clone() };
        let moving = matches!(&self.kind, Kind::Plane(on) if on.rate.is_some());
        if setting.scheme == Scheme::Transport || moving && setting.scheme == Scheme::Spectral {
            return Err(unsuited());
        }
        match (&self.kind, single) {
            (Kind::Plane(on), true) => run::run::<f32, 2>(on, setting),
            (Kind::Plane(on), false) => run::run::<f64, 2>(on, setting),
            (Kind::Space(on), true) => run::run::<f32, 3>(on, setting),
            (Kind::Space(on), false) => run::run::<f64, 3>(on, setting),
        }
    }
}

impl<const D: usize> On<D> {
    /// At rest and without source.
    pub fn still(
        grid: Grid<D>,
        sides: Sides<Wall, D>,
        law: Law,
        end: f64,
        start: CellField<f64>,
        exact: CellField<f64>,
    ) -> Result<Self, TradeoffError> {
        let mut state = State::<f64, D>::new(&grid, &law);
        state.phi.copy_from_slice(&start);
        Spectral::new(&grid, &sides, law)?.step(&mut state, &Medium::Still, Source::NONE, end)?;
        let semi = Some(state.phi);
        Ok(Self {
            grid,
            sides,
            law,
            velocity: [0.0; D],
            rate: None,
            end,
            start,
            exact,
            semi,
            front: None,
            jump: None,
            wake: None,
        })
    }
}

/// e^{−(r/`width`)²} in the middle of a closed unit box.
fn gaussian<const D: usize>(n: usize, law: Law, width: f64, end: f64) -> Result<On<D>, TradeoffError> {
    let grid = Grid::<D>::new([n; D], 1.0 / n as f64)?;
    let sides = Sides::all(Wall::CLOSED);
    let start = field(&grid, |cell| {
        let x = grid.centre(cell);
        (-(0..D).map(|a| (x[a] - 0.5).powi(2)).sum::<f64>() / (width * width)).exp()
    });
    let mut exact = start.clone();
    smooth(&grid, &sides, &law, &mut exact, end)?;
    On::still(grid, sides, law, end, start, exact)
}

/// A field from its values by cell.
pub(crate) fn field<const D: usize>(grid: &Grid<D>, value: impl Fn([usize; D]) -> f64 + Sync) -> CellField<f64> {
    let mut made = CellField::new(grid.layout());
    grid.layout().par_cells(&mut made, |at| value(at.cell));
    made
}
