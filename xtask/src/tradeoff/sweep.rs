//! Which settings are tried on which problem.

use super::levels;
use crate::bench::numerical;
use crate::failure::{Exit, Failure};
use cf_diffusion::{Advection, Law, Splitting, kdk_limit};
use cf_fluid::Scheme as Flow;
use cf_tradeoff::deformation::{self, Convergence, Shape};
use cf_tradeoff::vortices;
use cf_tradeoff::{Level, Measured, Numbers, Problem, Scheme, Setting};
use std::sync::atomic::{AtomicBool, Ordering};

/// Timed runs after one that warms up.
pub const RUNS: usize = 5;

/// What is known while the sweep runs.
pub struct Sweep<'a> {
    /// Small grids only.
    pub quick: bool,
    /// All threads of the machine.
    pub threads: usize,
    /// Ends it between two settings.
    pub stop: &'a AtomicBool,
    /// What has been measured.
    pub rows: Vec<Measured>,
    /// phi of the disc by three schemes, for a picture; and of the line.
    pub shown: Vec<Shown>,
    /// The deforming flow with diffusion.
    pub convergence: Vec<Convergence>,
    /// Half angles of the cones of P3 in the solution \[degrees\], by problem and cells per axis.
    pub angles: Vec<(String, usize, f64)>,
}

/// phi at the end, to be drawn.
pub struct Shown {
    /// The problem.
    pub problem: String,
    /// The scheme in words.
    pub words: String,
    /// Cells per axis.
    pub cells: [usize; 2],
    /// phi by cell, x contiguous.
    pub phi: Vec<f64>,
}

impl<'a> Sweep<'a> {
    /// Nothing measured yet.
    pub fn new(quick: bool, threads: usize, stop: &'a AtomicBool) -> Self {
        Self { quick, threads, stop, rows: vec![], shown: vec![], convergence: vec![], angles: vec![] }
    }

    fn go_on(&self) -> Result<(), Failure> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Failure::Words(Exit::Interrupted, "stopped before all was measured".into()));
        }
        Ok(())
    }

    fn keep(&mut self, measured: Measured) {
        complain!("{}: {} -> {:.2e}, {}", measured.problem, super::write::words(&measured), measured.error, {
            crate::show::seconds(measured.seconds)
        });
        self.rows.push(measured);
    }

    /// Measures one setting and tells so.
    fn take(&mut self, problem: &Problem, setting: Setting) -> Result<Vec<f64>, Failure> {
        self.go_on()?;
        let (measured, phi) = problem.measure(&setting, RUNS).map_err(numerical)?;
        self.keep(measured);
        Ok(phi)
    }

    fn all(&mut self, problem: &Problem, mut settings: Vec<Setting>) -> Result<(), Failure> {
        settings.retain(|s| s.threads <= self.threads);
        settings.into_iter().try_for_each(|setting| self.take(problem, setting).map(|_| ()))
    }

    fn levels(&mut self, problem: &Problem) -> Result<(), Failure> {
        for level in Level::ALL {
            let setting = levels::setting(level, problem, self.threads)?;
            self.take(problem, setting)?;
        }
        Ok(())
    }

    /// P1: step sizes of every integrator and the levels; around the middle ones tolerance, precision and threads.
    pub fn p1(&mut self) -> Result<(), Failure> {
        let sizes: &[usize] = if self.quick { &[64, 96] } else { &[128, 256] };
        for share in [0.0, 0.1, 1.0] {
            for &n in sizes {
                let problem = gaussian(2, n, 1.0, share)?;
                let at = |scheme, steps| Setting::new(scheme, steps, self.threads);
                let mut settings = self.steps(&problem, share, !self.quick);
                if Some(&n) == sizes.last() {
                    settings.extend(around(at(Scheme::Sdirk2, 40)));
                    settings.extend(around(at(Scheme::PaperBe, 160)));
                    if share == 0.0 {
                        settings.extend(around(at(Scheme::Kdk, 1)));
                        // Backward Euler is of first order: what an error of 1e-2 takes.
                        let more: &[usize] = if self.quick { &[] } else { &[2560, 3840, 5120] };
                        settings.extend(more.iter().map(|&s| at(Scheme::PaperBe, s)));
                    }
                }
                self.all(&problem, settings)?;
            }
            let sizes: &[usize] = if self.quick { &[64] } else { &[64, 96, 128, 160, 192, 256] };
            for &n in sizes {
                self.levels(&gaussian(2, n, 1.0, share)?)?;
            }
        }
        for tau in [1e-3, 1e3] {
            for share in [0.0, 0.1] {
                let problem = gaussian(2, if self.quick { 48 } else { 128 }, tau, share)?;
                let settings = self.steps(&problem, share, false);
                self.all(&problem, settings)?;
                self.levels(&problem)?;
            }
        }
        for (tau, share) in [(1.0, 0.0), (1.0, 0.1), (1.0, 1.0), (1e-3, 0.0), (1e3, 0.0)] {
            let sizes: &[usize] = match (self.quick, tau == 1.0) {
                (true, _) => &[24],
                (false, true) => &[32, 48],
                (false, false) => &[32],
            };
            for &n in sizes {
                let problem = gaussian(3, n, tau, share)?;
                let mut settings = self.steps(&problem, share, false);
                // A step in three dimensions costs too much for so many.
                settings.retain(|s| s.steps <= 40 || !s.scheme.is_implicit());
                self.all(&problem, settings)?;
                self.levels(&problem)?;
            }
        }
        Ok(())
    }

    /// Step sizes of every integrator that suits.
    fn steps(&self, problem: &Problem, share: f64, fine: bool) -> Vec<Setting> {
        let at = |scheme, steps| Setting::new(scheme, steps, self.threads);
        let fine: &[usize] = if fine { &[640, 1280] } else { &[] };
        let mut settings: Vec<Setting> = [10, 40, 160].iter().chain(fine).map(|&s| at(Scheme::PaperBe, s)).collect();
        settings.extend([5, 10, 20, 40, 80].map(|s| at(Scheme::Sdirk2, s)));
        if share == 0.0 {
            let dimension = problem.cells().len() as f64;
            let limit = kdk_limit(problem.law(), 4.0 * dimension / (problem.h() * problem.h()));
            // One call takes the longest stable sub-steps by itself.
            settings.push(at(Scheme::Kdk, 1));
            settings.push(at(Scheme::Kdk, (2.0 * problem.end() / limit).ceil() as usize));
        }
        settings.push(at(Scheme::Spectral, 1));
        settings
    }

    /// P2.
    pub fn p2(&mut self) -> Result<(), Failure> {
        for n in [100, 400] {
            let problem = Problem::line(n).map_err(numerical)?;
            if n == 100 {
                self.show(&problem, "exact".into(), problem.exact());
            }
            for (scheme, courant) in FRONTS {
                let phi = self.take(&problem, self.front(&problem, scheme, courant))?;
                if n == 100 && SHOWN_LINE.contains(&(scheme, courant)) {
                    self.show(&problem, format!("{scheme}, c dt/h = {courant}"), phi);
                }
            }
            self.levels(&problem)?;
        }
        let sizes: &[usize] = if self.quick { &[128] } else { &[128, 256] };
        for &n in sizes {
            let problem = Problem::disc(n).map_err(numerical)?;
            let drawn = n == 256 || self.quick;
            if drawn {
                self.show(&problem, "exact".into(), problem.exact());
            }
            for (scheme, courant) in FRONTS {
                let setting = self.front(&problem, scheme, courant);
                let phi = self.take(&problem, setting)?;
                if drawn && SHOWN_DISC.contains(&(scheme, courant)) {
                    self.show(&problem, format!("{scheme}, c dt/h = {courant}"), phi);
                }
                if scheme == Scheme::Front {
                    self.take(&problem, Setting { numbers: Numbers::F32, ..setting })?;
                }
            }
            self.levels(&problem)?;
        }
        Ok(())
    }

    fn front(&self, problem: &Problem, scheme: Scheme, courant: f64) -> Setting {
        let speed = problem.law().speed().unwrap_or(1.0);
        let steps = (problem.end() * speed / (courant * problem.h()) - 1e-9).ceil() as usize;
        Setting::new(scheme, steps, self.threads)
    }

    /// P3: every speed and share on one grid, pure waves on a finer one too.
    pub fn p3(&mut self) -> Result<(), Failure> {
        for hc in [0.5, 1.0, 2.0 / 3f64.sqrt(), std::f64::consts::SQRT_2, 2.0] {
            for share in [0.0, 0.05, 0.25, 1.0] {
                self.wake(if self.quick { 64 } else { 128 }, hc, share, &[4.0, 1.0, 0.25])?;
            }
            if !self.quick {
                self.wake(256, hc, 0.0, &[1.0])?;
            }
        }
        Ok(())
    }

    fn wake(&mut self, n: usize, hc: f64, share: f64, implicit: &[f64]) -> Result<(), Failure> {
        let problem = Problem::wake(n, hc, share).map_err(numerical)?;
        self.angles.push((problem.name().to_owned(), n, problem.exact_angle()));
        let speed = 1.0 / hc;
        let at = |scheme, courant: f64| {
            let steps = (problem.end() * speed / (courant * problem.h())).ceil() as usize;
            Setting::new(scheme, steps, self.threads)
        };
        let mut settings: Vec<Setting> = implicit.iter().map(|&courant| at(Scheme::PaperBe, courant)).collect();
        let paper = at(Scheme::PaperBe, 1.0);
        settings.push(Setting { advection: Advection::Linear, splitting: Splitting::Paper, ..paper });
        settings.extend(implicit.iter().map(|&courant| at(Scheme::Sdirk2, courant)));
        settings.push(Setting { advection: Advection::Cubic, ..at(Scheme::Sdirk2, 1.0) });
        if share == 0.0 {
            settings.extend([at(Scheme::Kdk, 0.5), at(Scheme::Kdk, 0.25)]);
            // The medium moves by whole cells.
            let whole = (problem.end() / problem.h()).round() as usize;
            settings.push(Setting::new(Scheme::Kdk, whole, self.threads));
            let steps = (problem.end() * (1.0 + speed) / (0.5 * problem.h())).ceil() as usize;
            settings.push(Setting::new(Scheme::Front, steps, self.threads));
        }
        self.all(&problem, settings)
    }

    /// P4.
    pub fn p4(&mut self) -> Result<(), Failure> {
        use Advection::{Cubic, Linear, Muscl};
        let mut cases = vec![(Shape::Bell, 128), (Shape::SlottedDisc, 128)];
        if self.quick {
            cases = vec![(Shape::Bell, 64)];
        } else {
            cases.insert(1, (Shape::Bell, 256));
        }
        for (shape, n) in cases {
            for (advection, courant) in
                [(Linear, 0.5), (Linear, 3.0), (Cubic, 0.5), (Cubic, 3.0), (Muscl, 0.5), (Muscl, 0.9)]
            {
                self.go_on()?;
                if n == 256 && advection == Muscl && courant < 0.9 {
                    continue;
                }
                let steps = (deformation::PERIOD * n as f64 / courant).ceil() as usize;
                let setting = Setting { advection, ..Setting::new(Scheme::Transport, steps, 1) };
                self.keep(deformation::round_trip(shape, n, &setting, RUNS).map_err(numerical)?);
            }
        }
        let n = if self.quick { 32 } else { 64 };
        for share in [0.0, 0.1] {
            let law = Law::new(0.01, 0.25, share).map_err(numerical)?;
            let steps = 4 * n;
            let mut settings = vec![
                Setting::new(Scheme::Sdirk2, steps, self.threads),
                Setting { advection: Cubic, ..Setting::new(Scheme::Sdirk2, steps, self.threads) },
                Setting {
                    advection: Linear,
                    splitting: Splitting::Paper,
                    ..Setting::new(Scheme::PaperBe, steps, self.threads)
                },
            ];
            if share == 0.0 {
                settings.insert(1, Setting::new(Scheme::Kdk, steps, self.threads));
            }
            for setting in settings {
                self.go_on()?;
                let found = deformation::self_convergence(n, law, &setting).map_err(numerical)?;
                complain!(
                    "P4 with diffusion: {}, {} {:?}: order {:.2}",
                    found.law,
                    setting.scheme,
                    setting.advection,
                    { found.order }
                );
                self.convergence.push(found);
            }
        }
        Ok(())
    }

    /// P5: steps of every scheme of the fluid; around the default one tolerance, precision and threads.
    pub fn p5(&mut self) -> Result<(), Failure> {
        let sizes: &[usize] = if self.quick { &[32] } else { &[32, 64, 128] };
        let mut cases = Vec::new();
        for &n in sizes {
            let at = |flow, courant| Setting {
                flow: Some(flow),
                ..Setting::new(Scheme::Transport, vortices::steps(n, courant), self.threads)
            };
            for flow in [Flow::Draft, Flow::Cnp, Flow::ReflectionExtrapolated] {
                cases.extend([0.25, 0.5, 1.0, 2.0, 4.0].map(|courant| (n, at(flow, courant))));
            }
            cases.extend([0.25, 0.5, 0.8].map(|courant| (n, at(Flow::CentralRk4, courant))));
            if Some(&n) == sizes.last() {
                let own = at(Flow::Cnp, 0.5);
                let mut turned =
                    vec![Setting { numbers: Numbers::F32, ..own }, Setting { numbers: Numbers::Mixed, ..own }];
                turned.extend([1e-2, 1e-3, 1e-4, 1e-6].map(|tolerance| Setting { tolerance, ..own }));
                turned.push(Setting { threads: 1, ..own });
                cases.extend(turned.into_iter().map(|setting| (n, setting)));
            }
        }
        for (n, setting) in cases {
            self.go_on()?;
            self.keep(vortices::carried(n, &setting, RUNS).map_err(numerical)?);
        }
        Ok(())
    }

    fn show(&mut self, problem: &Problem, words: String, phi: Vec<f64>) {
        let cells = problem.cells();
        self.shown.push(Shown { problem: problem.name().to_owned(), words, cells: [cells[0], cells[1]], phi });
    }
}

/// P1 with k = 0.04 m²/s; waves that hardly fade (τ = 1000 s) get the k that makes them as fast as at τ = 1 s.
fn gaussian(dimension: usize, n: usize, tau: f64, share: f64) -> Result<Problem, Failure> {
    let k = if share == 0.0 { 0.04 * tau.max(1.0) } else { 0.04 };
    let law = Law::new(k, tau, share).map_err(numerical)?;
    Problem::gaussian(dimension, n, law).map_err(numerical)
}

/// One knob turned at a time.
fn around(setting: Setting) -> Vec<Setting> {
    let mut turned = vec![Setting { numbers: Numbers::F32, ..setting }, Setting { threads: 1, ..setting }];
    if setting.scheme.is_implicit() {
        turned.push(Setting { numbers: Numbers::Mixed, ..setting });
        turned.extend([1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10].map(|tolerance| Setting { tolerance, ..setting }));
    }
    turned
}

/// Schemes and c dt/h for fronts.
pub const FRONTS: [(Scheme, f64); 9] = [
    (Scheme::PaperBe, 4.0),
    (Scheme::PaperBe, 1.0),
    (Scheme::PaperBe, 0.25),
    (Scheme::Sdirk2, 4.0),
    (Scheme::Sdirk2, 1.0),
    (Scheme::Kdk, 0.5),
    (Scheme::Front, 0.5),
    (Scheme::Front, 0.9),
    (Scheme::Kdk, 0.7),
];
const SHOWN_LINE: [(Scheme, f64); 3] = [(Scheme::PaperBe, 4.0), (Scheme::Kdk, 0.5), (Scheme::Front, 0.5)];
const SHOWN_DISC: [(Scheme, f64); 3] = [(Scheme::PaperBe, 1.0), (Scheme::Kdk, 0.5), (Scheme::Front, 0.5)];
