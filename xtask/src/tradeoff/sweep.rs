//! Which settings are tried on which problem.

use super::measure::measure;
use super::problem::{Problem, disc, gaussian, line};
use super::setting::{Measured, Scheme, Setting};
use crate::bench::Numbers;
use crate::failure::{Exit, Failure};
use cf_diffusion::kdk_limit;
use std::sync::atomic::{AtomicBool, Ordering};

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

impl Sweep<'_> {
    /// Measures one setting and tells so.
    fn take<const D: usize>(&mut self, problem: &Problem<D>, setting: Setting) -> Result<Vec<f64>, Failure> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Failure::Words(Exit::Interrupted, "stopped before all was measured".into()));
        }
        let (measured, phi) = measure(problem, &setting)?;
        complain!("{}: {} -> {:.2e}, {}", problem.name, measured.words(), measured.error, {
            crate::show::seconds(measured.seconds)
        });
        self.rows.push(measured);
        Ok(phi)
    }

    /// P1 on one grid: step sizes of every integrator, and around two of them precision, tolerance and threads.
    fn gaussian<const D: usize>(&mut self, n: usize, share: f64, around: bool) -> Result<(), Failure> {
        let problem = gaussian::<D>(n, share)?;
        let at = |scheme, steps| Setting::new(scheme, steps, self.threads);
        let least = (1.0 / kdk_limit(&problem.law, 4.0 * D as f64 * (n * n) as f64)).ceil() as usize;
        let fine: &[usize] = if D == 3 { &[] } else { &[640, 1280] };
        let mut settings: Vec<Setting> = [10, 40, 160].iter().chain(fine).map(|&s| at(Scheme::PaperBe, s)).collect();
        let second: &[usize] = if D == 3 { &[10, 40] } else { &[5, 10, 20, 40, 80] };
        settings.extend(second.iter().map(|&s| at(Scheme::Sdirk2, s)));
        let explicit = share == 0.0;
        if explicit {
            settings.extend([least, 2 * least].map(|s| at(Scheme::Kdk, s)));
        }
        settings.push(at(Scheme::Spectral, 1));
        if around {
            let mut middle = vec![at(Scheme::Sdirk2, 40), at(Scheme::PaperBe, 160)];
            middle.extend(explicit.then(|| at(Scheme::Kdk, least)));
            for setting in middle {
                let implicit = setting.scheme != Scheme::Kdk;
                settings.push(Setting { numbers: Numbers::F32, ..setting });
                settings.push(Setting { threads: 1, ..setting });
                if implicit {
                    settings.push(Setting { numbers: Numbers::Mixed, ..setting });
                    settings.extend([1e-3, 1e-8].map(|tolerance| Setting { tolerance, ..setting }));
                }
            }
        }
        settings.retain(|s| s.threads <= self.threads);
        settings.into_iter().try_for_each(|setting| self.take(&problem, setting).map(|_| ()))
    }

    /// P1.
    pub fn p1(&mut self) -> Result<(), Failure> {
        let sizes: &[usize] = if self.quick { &[96, 192] } else { &[128, 256] };
        for share in [0.0, 0.1, 1.0] {
            for &n in sizes {
                self.gaussian::<2>(n, share, Some(&n) == sizes.last())?;
            }
        }
        if !self.quick {
            for n in [48, 80] {
                self.gaussian::<3>(n, 0.0, false)?;
            }
        }
        Ok(())
    }

    /// P2.
    pub fn p2(&mut self) -> Result<(), Failure> {
        let sizes: &[usize] = if self.quick { &[100] } else { &[100, 400] };
        for &n in sizes {
            let problem = line(n)?;
            if n == sizes[0] {
                self.show(&problem, "exact".into(), &problem.exact);
            }
            for (scheme, courant) in FRONTS {
                let steps = (problem.end / (courant * problem.grid.h())).ceil() as usize;
                let phi = self.take(&problem, Setting::new(scheme, steps, self.threads))?;
                if n == sizes[0] && SHOWN_LINE.contains(&(scheme, courant)) {
                    self.show(&problem, format!("{scheme}, c dt/h = {courant}"), &phi);
                }
            }
        }
        let problem = disc(if self.quick { 128 } else { 256 })?;
        self.show(&problem, "reference".into(), &problem.exact);
        for (scheme, courant) in FRONTS {
            let steps = (problem.end / (courant * problem.grid.h())).ceil() as usize;
            let setting = Setting::new(scheme, steps, self.threads);
            let phi = self.take(&problem, setting)?;
            if SHOWN_DISC.contains(&(scheme, courant)) {
                self.show(&problem, format!("{scheme}, c dt/h = {courant}"), &phi);
            }
            if scheme == Scheme::Front {
                self.take(&problem, Setting { numbers: Numbers::F32, ..setting })?;
            }
        }
        Ok(())
    }

    fn show(&mut self, problem: &Problem<2>, words: String, phi: &[f64]) {
        let layout = problem.grid.layout();
        let mut values = Vec::with_capacity(layout.count());
        layout.each_cell(layout.cells_region(), |at| values.push(phi[at.slot()]));
        self.shown.push(Shown { problem: problem.name.clone(), words, cells: problem.grid.cells(), phi: values });
    }
}

/// Schemes and c dt/h for fronts.
const FRONTS: [(Scheme, f64); 8] = [
    (Scheme::PaperBe, 4.0),
    (Scheme::PaperBe, 1.0),
    (Scheme::PaperBe, 0.25),
    (Scheme::Sdirk2, 4.0),
    (Scheme::Sdirk2, 1.0),
    (Scheme::Kdk, 0.5),
    (Scheme::Front, 0.5),
    (Scheme::Front, 0.9),
];
const SHOWN_LINE: [(Scheme, f64); 3] = [(Scheme::PaperBe, 4.0), (Scheme::Kdk, 0.5), (Scheme::Front, 0.5)];
const SHOWN_DISC: [(Scheme, f64); 3] = [(Scheme::PaperBe, 1.0), (Scheme::Kdk, 0.5), (Scheme::Front, 0.5)];
