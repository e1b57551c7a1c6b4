//! A scene instead of a problem with a known solution: its knobs turned one at a time, against its own tightest run.

use super::sweep::RUNS;
use super::write::{self, Found};
use super::{drawn_of, recommend};
use crate::bench::stream::Bandwidth;
use crate::cli::{SceneOptions, TradeoffArgs};
use crate::failure::{Exit, Failure};
use crate::pool;
use cf_fluid::Scheme as Flow;
use cf_output::read_image;
use cf_scene::spec::{Field, FlowScheme, Pictures};
use cf_scene::{Experiment, Limits, Model, Scene, SceneFile, Set, catalog, progress};
use cf_tradeoff::{Level, Measured, Numbers, Scheme, Setting, median};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A scene's text and name.
pub struct Source {
    /// Without extension.
    pub name: String,
    file: SceneFile,
    preset: String,
    sets: Vec<Set>,
}

/// The runs of a scene among which there is something to trade.
pub struct Runs {
    source: Source,
    runs: Vec<Scene>,
}

impl Runs {
    /// Those of a file, or of the first scene of a figure.
    pub fn open(request: &str, options: &SceneOptions) -> Result<Self, Failure> {
        let source = Source::open(request, options)?;
        let runs = source.runs()?;
        if runs.is_empty() {
            return Err(Failure::usage(format!("{request}: every run is solved exactly; there is nothing to trade")));
        }
        Ok(Self { source, runs })
    }
}

impl Source {
    /// A scene of the catalogue.
    pub fn of(scene: &catalog::CatalogScene, options: &SceneOptions) -> Result<Self, Failure> {
        Self::parse(scene.name.to_owned(), &scene.file(), scene.text, options)
    }

    /// A file, or the first scene of a figure.
    pub fn open(request: &str, options: &SceneOptions) -> Result<Self, Failure> {
        let path = Path::new(request);
        if !path.is_file() {
            let found = catalog::find(request)?;
            let scene = found.first().ok_or_else(|| Failure::usage(format!("{request}: no such scene")))?;
            return Self::of(scene, options);
        }
        let text = std::fs::read_to_string(path).map_err(|e| Failure::io(format!("{request}: cannot be read: {e}")))?;
        let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
        Self::parse(name, request, &text, options)
    }

    fn parse(name: String, shown: &str, text: &str, options: &SceneOptions) -> Result<Self, Failure> {
        let failed = |problems| Failure::Scene(Box::new(problems), Some(text.to_owned()));
        let file = SceneFile::parse(shown, text).map_err(failed)?;
        let sets = options.sets.iter().map(|flag| Set::parse(flag)).collect::<Result<_, _>>()?;
        let made = Self { name, file, preset: options.preset.clone(), sets };
        made.experiment(&[]).map_err(|problems| Failure::Scene(problems, Some(text.to_owned())))?;
        Ok(made)
    }

    /// All runs with further overrides.
    fn experiment(&self, flags: &[String]) -> Result<Experiment, Box<cf_scene::Problems>> {
        let mut sets = self.sets.clone();
        for flag in flags {
            sets.push(Set::parse(flag).map_err(|error| Box::new(error.into()))?);
        }
        self.file.experiment(Some(&self.preset), &sets, &Limits::of_this_machine()).map_err(Box::new)
    }

    /// The runs that are solved by steps and differ in more than their numerics.
    pub fn runs(&self) -> Result<Vec<Scene>, Failure> {
        let experiment = self.experiment(&[]).map_err(|problems| Failure::Scene(problems, None))?;
        let mut different: Vec<Scene> = Vec::new();
        for scene in experiment.runs {
            let same = |other: &Scene| other.model == scene.model && other.sides == scene.sides;
            if matches!(scene.model, Model::Diffusion(_)) && !different.iter().any(same) {
                different.push(scene);
            }
        }
        Ok(different)
    }

    /// One run with overrides: `None` where the scene refuses them, or steps fail, which is no point of the front.
    pub fn attempt(&self, run: &str, flags: &[String], threads: usize) -> Result<Option<Ran>, Failure> {
        match self.run(run, flags, threads) {
            Err(Failure::Scene(..) | Failure::Words(Exit::Numerical, _)) => Ok(None),
            other => other.map(Some),
        }
    }

    /// One run with overrides.
    pub fn run(&self, run: &str, flags: &[String], threads: usize) -> Result<Ran, Failure> {
        let mut experiment = self.experiment(flags).map_err(|problems| Failure::Scene(problems, None))?;
        experiment.claims.clear();
        experiment.runs.retain(|scene| scene.run == run);
        let scene = experiment.runs.first_mut().ok_or_else(|| Failure::usage(format!("{run}: no such run")))?;
        let output = &mut scene.output;
        (output.vtk, output.table, output.pictures, output.fields) = (true, false, Pictures::Off, vec![Field::Phi]);
        (scene.schedule.frames, scene.schedule.interval) = (1, scene.schedule.until);
        let (numerics, solved) = (scene.numerics, scene.fluid().is_some());
        let folder = tempfile::tempdir().map_err(|e| Failure::io(format!("no temporary folder: {e}")))?;
        let options = cf_scene::Options { threads, ..cf_scene::Options::new(&self.name, folder.path()) };
        let watch = &mut progress::Silent;
        let summary = crate::perform::perform(&experiment, &options, watch)?;
        let mut image = read_image(&folder.path().join(format!("{run}_0001.vti")))?;
        let done = &summary.runs[0];
        let scheme = match done.integrator.as_str() {
            "PaperBe" => Scheme::PaperBe,
            "Kdk" => Scheme::Kdk,
            "Characteristic" => Scheme::Front,
            _ => Scheme::Sdirk2,
        };
        let numbers = match done.precision.as_str() {
            "f32" => Numbers::F32,
            "mixed" => Numbers::Mixed,
            _ => Numbers::F64,
        };
        let advection = match numerics.advection {
            cf_scene::spec::Advection::Muscl => cf_diffusion::Advection::Muscl,
            cf_scene::spec::Advection::Cubic => cf_diffusion::Advection::Cubic,
            cf_scene::spec::Advection::Linear => cf_diffusion::Advection::Linear,
        };
        let setting = Setting {
            numbers,
            tolerance: numerics.tolerance,
            advection,
            flow: solved.then(|| flow(numerics.flow)),
            ..Setting::new(scheme, done.steps as usize, threads)
        };
        let phases = &done.seconds.phases;
        Ok(Ran {
            phi: image.arrays.swap_remove(0).values,
            cells: done.cells.clone(),
            setting,
            courant: done.regime.speed.unwrap_or(0.0) * done.dt[1] / done.spacing,
            seconds: phases.iter().filter(|(name, _)| *name != "output").map(|(_, s)| s).sum(),
            drift: done.mass.drift,
        })
    }
}

/// The scheme of a scene's fluid.
fn flow(scheme: FlowScheme) -> Flow {
    match scheme {
        FlowScheme::Auto => Flow::Auto,
        FlowScheme::Cnp => Flow::Cnp,
        FlowScheme::ReflectionExtrapolated => Flow::ReflectionExtrapolated,
        FlowScheme::Draft => Flow::Draft,
        FlowScheme::CentralRk4 => Flow::CentralRk4,
    }
}

/// What a run left.
pub struct Ran {
    /// By cell, x contiguous.
    pub phi: Vec<f64>,
    /// Cells per axis.
    pub cells: Vec<usize>,
    /// Its knobs.
    pub setting: Setting,
    /// c dt/h.
    pub courant: f64,
    /// Steps alone.
    pub seconds: f64,
    /// Of the mass budget.
    pub drift: f64,
}

/// Means over blocks until there are as many cells as in `cells`; `None` where blocks do not fit.
pub fn coarsened(phi: &[f64], from: &[usize], cells: &[usize]) -> Option<Vec<f64>> {
    let fits = from.len() == cells.len() && from.iter().zip(cells).all(|(n, m)| *m > 0 && n % m == 0);
    let blocks: Vec<usize> = fits.then(|| from.iter().zip(cells).map(|(n, m)| n / m).collect())?;
    let mut mean = vec![0.0; cells.iter().product()];
    let share = 1.0 / blocks.iter().product::<usize>() as f64;
    for (i, value) in phi.iter().enumerate() {
        let (mut rest, mut place, mut stride) = (i, 0, 1);
        for a in 0..from.len() {
            place += rest % from[a] / blocks[a] * stride;
            rest /= from[a];
            stride *= cells[a];
        }
        mean[place] += share * value;
    }
    Some(mean)
}

/// |a − b| over |b| in the 2-norm, the 1-norm and the largest.
pub fn distance(a: &[f64], b: &[f64]) -> [f64; 3] {
    let (mut off, mut whole) = ([0.0f64; 3], [0.0f64; 3]);
    for (a, b) in a.iter().zip(b) {
        for (sums, x) in [(&mut off, a - b), (&mut whole, *b)] {
            *sums = [sums[0] + x * x, sums[1] + x.abs(), sums[2].max(x.abs())];
        }
    }
    [(off[0] / whole[0]).sqrt(), off[1] / whole[1], off[2] / whole[2]]
}

/// `grid.cells` times a power of two; `None` where it does not divide.
pub fn cells(scene: &Scene, power: i32) -> Option<String> {
    let scaled = scene.grid.cells.iter().map(|&n| match power {
        0.. => Some(n << power),
        _ => (n % (1 << -power) == 0).then_some(n >> -power),
    });
    let numbers: Option<Vec<String>> = scaled.map(|n| n.map(|n| n.to_string())).collect();
    numbers.map(|numbers| format!("grid.cells=({})", numbers.join(", ")))
}

/// The tightest of everything but the grid.
const TIGHT: [&str; 5] = [
    "accuracy.level=Accurate",
    "accuracy.dt=None",
    "accuracy.cfl=0.25",
    "accuracy.tolerance=1e-10",
    "accuracy.precision=f64",
];

/// The scene's reference: its tightest run on a grid twice as fine, and what three grids tell about it.
pub struct Reference {
    /// The finest.
    pub ran: Ran,
    /// log2 of the ratio of the differences.
    pub order: f64,
    /// Estimated error of the finest, relative.
    pub error: f64,
}

impl Reference {
    /// Runs all three.
    pub fn of(source: &Source, scene: &Scene, threads: usize) -> Result<Self, Failure> {
        let refuse = || {
            let found = crate::show::cells(&scene.grid.cells);
            Failure::usage(format!(
                "{}: the reference takes half and twice as many cells along each axis: expected even numbers of cells, found {found}; \
                 --set grid.cells, where the scene allows it",
                scene.run
            ))
        };
        let mut solved = Vec::new();
        for power in [-1, 0, 1] {
            let mut flags: Vec<String> = TIGHT.iter().map(|&flag| flag.to_owned()).collect();
            flags.push(cells(scene, power).ok_or_else(refuse)?);
            if scene.numerics.integrator == Some(cf_scene::spec::Integrator::PaperBe) {
                flags.push("accuracy.integrator=None".into());
            }
            let ran = source.run(&scene.run, &flags, threads);
            solved.push(ran.inspect_err(|_| complain!("{}: no reference with {}", scene.run, flags.join(" ")))?);
        }
        let apart = |coarse: &Ran, fine: &Ran| {
            coarsened(&fine.phi, &fine.cells, &coarse.cells).map_or(f64::NAN, |mean| distance(&coarse.phi, &mean)[0])
        };
        let differences = [apart(&solved[0], &solved[1]), apart(&solved[1], &solved[2])];
        let order = (differences[0] / differences[1]).log2();
        // Sharp sources keep grids from converging as fast as the scheme would.
        let error = differences[1] / (order.clamp(0.5, 4.0).exp2() - 1.0);
        solved.pop().map(|ran| Self { ran, order, error }).ok_or_else(refuse)
    }

    /// The errors of a run against it, in three norms.
    pub fn errors(&self, ran: &Ran) -> [f64; 3] {
        coarsened(&self.ran.phi, &self.ran.cells, &ran.cells).map_or([f64::NAN; 3], |mean| distance(&ran.phi, &mean))
    }
}

/// Every knob, one at a time: overrides and whether one thread does it.
fn turned(scene: &Scene, quick: bool) -> Vec<(Option<Level>, Vec<String>, bool)> {
    let own = |text: &str| vec![text.to_owned()];
    let mut all = vec![(None, vec![], false)];
    for (level, name) in Level::ALL.into_iter().zip(["Draft", "Standard", "Accurate"]) {
        all.push((Some(level), own(&format!("accuracy.level={name}")), false));
    }
    let mut knobs: Vec<String> = Vec::new();
    knobs.extend(["PaperBe", "Sdirk2", "Kdk", "Characteristic"].map(|i| format!("accuracy.integrator={i}")));
    knobs.extend(["0.25", "1.0", "4.0"].map(|cfl| format!("accuracy.cfl={cfl}")));
    if !quick {
        knobs.extend(["Linear", "Cubic", "Muscl"].map(|a| format!("accuracy.advection={a}")));
        knobs.extend(["1e-2", "1e-3", "1e-4", "1e-6"].map(|t| format!("accuracy.tolerance={t}")));
    }
    if scene.fluid().is_some() {
        let schemes = ["Draft", "Cnp", "ReflectionExtrapolated", "CentralRk4"];
        knobs.extend(schemes.map(|scheme| format!("accuracy.flow={scheme}")));
    }
    knobs.extend(["f32", "mixed", "f64"].map(|p| format!("accuracy.precision={p}")));
    knobs.extend(cells(scene, -1));
    for knob in knobs {
        let mut flags = vec![knob.clone()];
        if knob.starts_with("accuracy.cfl") {
            flags.insert(0, "accuracy.dt=None".into());
        }
        all.push((None, flags.clone(), false));
        // Backward Euler at other steps, and other grids with it: the paper's front.
        if knob.starts_with("accuracy.cfl") || knob.starts_with("grid") {
            flags.push("accuracy.integrator=PaperBe".into());
            all.push((None, flags, false));
        }
    }
    all.push((None, vec![], true));
    all
}

/// Measures a scene, writes, prints.
pub fn scene(Runs { source, runs }: &Runs, asked: &TradeoffArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let threads = pool::threads(None);
    let mut bandwidth = Bandwidth::measure(&[1, threads][usize::from(threads == 1)..])?;
    let mut rows: Vec<Measured> = Vec::new();
    for scene in runs {
        let problem = format!("{}, {}", source.name, scene.run);
        complain!("{problem}: the reference, a run on each of three grids");
        let reference = Reference::of(source, scene, threads)?;
        say!(
            "{problem}: reference {} cells, {}, order {:.2} on three grids, error about {:.1e}",
            crate::show::cells(&reference.ran.cells),
            reference.ran.setting.scheme,
            reference.order,
            reference.error
        );
        for (level, flags, alone) in turned(scene, asked.quick) {
            if stop.load(Ordering::Relaxed) {
                return Err(Failure::Words(Exit::Interrupted, "stopped before all was measured".into()));
            }
            let threads = if alone { 1 } else { threads };
            let Some(first) = source.attempt(&scene.run, &flags, threads)? else { continue };
            let mut times = Vec::new();
            while times.len() < if asked.quick { 1 } else { RUNS } {
                times.push(source.run(&scene.run, &flags, threads)?.seconds);
            }
            let [error, one, worst] = reference.errors(&first);
            rows.push(Measured {
                problem: problem.clone(),
                cells: first.cells.clone(),
                setting: Setting { level, ..first.setting },
                courant: first.courant,
                error,
                time_error: f64::NAN,
                one,
                worst,
                overshoot: f64::NAN,
                drift: first.drift,
                width: f64::NAN,
                ringing: f64::NAN,
                outside: f64::NAN,
                angle: f64::NAN,
                iterations: 0,
                seconds: median(times.iter().copied()),
                runs: times.len(),
            });
            complain!("{problem}: {} -> {error:.2e}", flags.join(" "));
        }
    }
    bandwidth.again()?;
    let found = Found { rows: &rows, tables: &[], convergence: &[], claims: &[], bandwidth: &bandwidth, threads };
    say!("{}", write::settings(rows.iter()).text());
    found.bandwidth.print();
    write::csv(&rows, &asked.out.join("tradeoff.csv"))?;
    write::summary(&found, &asked.out.join("summary.json"))?;
    let pictures = drawn_of(&rows, &asked.out, &[])?;
    cf_output::write_text(&asked.out.join("report.html"), &write::report(&found, &pictures))?;
    if let Some(error) = asked.target_error {
        recommend(&rows, error);
    }
    say!("\nwritten to {}", asked.out.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_have_their_means() {
        let fine: Vec<f64> = (0..16).map(f64::from).collect();
        assert_eq!(coarsened(&fine, &[4, 4], &[2, 2]), Some(vec![2.5, 4.5, 10.5, 12.5]));
        assert_eq!(coarsened(&fine, &[4, 4], &[3, 2]), None);
        assert_eq!(coarsened(&fine, &[4, 2, 2], &[2, 1, 1]), Some(vec![6.5, 8.5]));
    }

    #[test]
    fn distances_are_relative() {
        assert_eq!(distance(&[1.0, 3.0], &[1.0, 2.0]), [0.2f64.sqrt(), 1.0 / 3.0, 0.5]);
    }
}
