//! What a level of scenes means on a problem: read off a scene of the same grid and law, not repeated here.

use crate::failure::{Exit, Failure};
use cf_diffusion::{Advection, Splitting};
use cf_scene::{Limits, Pace, SceneFile, spec};
use cf_tradeoff::{Level, Numbers, Problem, Scheme, Setting};

/// The knobs that a scene of this level decides on, and the steps it would take.
pub fn setting(level: Level, problem: &Problem, threads: usize) -> Result<Setting, Failure> {
    let cells = problem.cells();
    let list = |values: Vec<String>| values.join(", ");
    let law = problem.law();
    let text = format!(
        "(grid: (cells: ({}), extent: ({})), model: Diffusion(law: (k: {:?}, tau: {:?}, fourier: {:?})), \
         accuracy: (level: {}), run: (until: {:?}))",
        list(cells.iter().map(usize::to_string).collect()),
        list(cells.iter().map(|&n| format!("{:?}", n as f64 * problem.h())).collect()),
        law.k(),
        law.tau(),
        law.fourier_share(),
        match level {
            Level::Draft => "Draft",
            Level::Standard => "Standard",
            Level::Accurate => "Accurate",
        },
        problem.end(),
    );
    let scene = SceneFile::parse("level.ron", &text)
        .and_then(|file| file.experiment(None, &[], &Limits::of_this_machine()))
        .map_err(|problems| Failure::Scene(Box::new(problems), Some(text.clone())))?
        .runs
        .remove(0);
    let (pace, numerics) = (Pace::of(&scene), &scene.numerics);
    let scheme = match pace.integrator {
        Some(spec::Integrator::PaperBe) => Scheme::PaperBe,
        Some(spec::Integrator::Sdirk2) => Scheme::Sdirk2,
        Some(spec::Integrator::Kdk) => Scheme::Kdk,
        Some(spec::Integrator::Characteristic) => Scheme::Front,
        None => return Err(Failure::Words(Exit::Failed, "a level without an integrator".into())),
    };
    Ok(Setting {
        tolerance: numerics.tolerance,
        numbers: match numerics.precision {
            spec::Precision::F32 => Numbers::F32,
            spec::Precision::Mixed => Numbers::Mixed,
            spec::Precision::F64 => Numbers::F64,
        },
        advection: match numerics.advection {
            spec::Advection::Muscl => Advection::Muscl,
            spec::Advection::Cubic => Advection::Cubic,
            spec::Advection::Linear => Advection::Linear,
        },
        splitting: match numerics.splitting {
            spec::Splitting::Strang => Splitting::Strang,
            spec::Splitting::Lie => Splitting::Paper,
        },
        level: Some(level),
        ..Setting::new(scheme, pace.steps(&scene).ceil() as usize, threads)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_diffusion::Law;

    #[test]
    fn levels_are_those_of_scenes() {
        let problem = Problem::gaussian(2, 32, Law::cattaneo(0.04, 1.0).unwrap()).unwrap();
        let [draft, standard, accurate] = Level::ALL.map(|level| setting(level, &problem, 1).unwrap());
        assert_eq!((draft.scheme, draft.tolerance, draft.numbers), (Scheme::Kdk, 1e-3, Numbers::F32));
        assert_eq!((standard.scheme, standard.numbers), (Scheme::Kdk, Numbers::F32));
        assert_eq!((accurate.tolerance, accurate.numbers), (1e-8, Numbers::Mixed));
        assert!(draft.steps <= standard.steps && standard.steps <= accurate.steps);
        let fourier = Problem::gaussian(2, 32, Law::new(0.04, 1.0, 0.1).unwrap()).unwrap();
        assert_eq!(setting(Level::Standard, &fourier, 1).unwrap().scheme, Scheme::Sdirk2);
    }
}
