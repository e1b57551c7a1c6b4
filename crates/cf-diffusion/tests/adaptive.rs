//! Adaptive steps: the tolerance is met on waves, Jeffreys' law and diffusion, at any number of threads.

use cf_diffusion::exact::{AxisModes, Walls, modes};
use cf_diffusion::{Adaptive, Controller, Diffusion, Integrator, Law, Medium, Settings, Source, State, StepError};
use cf_grid::{Axis, Grid, Sides, Wall};

type Outcome<V = ()> = Result<V, Box<dyn std::error::Error>>;

const CELLS: [usize; 2] = [128, 4];
const END: f64 = 1.0;

/// A Gaussian of width 0.05 in the middle of a periodic line, as the sum of its discrete modes.
struct Line {
    grid: Grid<2>,
    sides: Sides<Wall, 2>,
    axis: AxisModes,
    start: Vec<f64>,
}

impl Line {
    fn new() -> Outcome<Self> {
        let h = 1.0 / CELLS[0] as f64;
        let grid = Grid::new(CELLS, h)?;
        let axis = AxisModes::new(Walls::Periodic, CELLS[0], h).ok_or("no modes")?;
        let gauss = |i: usize| (-0.5 * (((i as f64 + 0.5) * h - 0.5) / 0.05).powi(2)).exp();
        Ok(Line {
            grid,
            sides: Sides([Axis::Periodic, Axis::Periodic]),
            axis,
            start: (0..CELLS[0]).map(gauss).collect(),
        })
    }

    fn state(&self, law: &Law) -> State<f64, 2> {
        let mut state = State::new(&self.grid, law);
        self.grid.layout().par_cells(&mut state.phi, |at| self.start[at.cell[0]]);
        state
    }

    /// phi at the end without an error in time.
    fn exact(&self, law: &Law) -> Vec<f64> {
        let mut end = vec![0.0; CELLS[0]];
        for m in 0..self.axis.count() {
            let mode: Vec<f64> = (0..CELLS[0]).map(|i| self.axis.vector(m, i)).collect();
            let dot = |v: &[f64]| v.iter().zip(&mode).map(|(a, b)| a * b).sum::<f64>();
            let amount = dot(&self.start) / dot(&mode) * modes::response(law, self.axis.eigenvalue(m), END);
            end.iter_mut().zip(&mode).for_each(|(e, b)| *e += amount * b);
        }
        end
    }

    /// Relative to the start, as the tolerance is.
    fn error(&self, law: &Law, state: &State<f64, 2>) -> f64 {
        let layout = self.grid.layout();
        let square = |v: f64| v * v;
        let off: f64 =
            self.exact(law).iter().enumerate().map(|(i, e)| square(state.phi[layout.slot([i, 0])] - e)).sum();
        (off / self.start.iter().map(|v| square(*v)).sum::<f64>()).sqrt()
    }

    fn adaptive(&self, law: Law, tolerance: f64) -> Outcome<Adaptive<f64, 2>> {
        let settings = Settings { tolerance: 1e-3 * tolerance, ..Settings::default() };
        let diffusion = Diffusion::new(&self.grid, &self.sides, None, law, settings)?;
        Ok(Adaptive::new(diffusion, Controller::new(tolerance, 1e-3)?)?)
    }
}

#[test]
fn the_tolerance_is_met() -> Outcome {
    let line = Line::new()?;
    let laws = [
        ("wave", Law::from_speed(0.2, 1.0, 0.0)?, 1.0),
        ("Jeffreys", Law::from_speed(0.2, 1.0, 0.05)?, 1.0),
        ("short memory", Law::new(0.04, 1e-3, 0.0)?, 0.2),
        ("Fourier", Law::fourier(0.04)?, 0.2),
    ];
    for (name, law, least) in laws {
        let mut solves = Vec::new();
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let mut adaptive = line.adaptive(law, tolerance)?;
            let mut state = line.state(&law);
            let report = adaptive.advance(&mut state, &Medium::Still, Source::NONE, END)?;
            let error = line.error(&law, &state);
            println!("{name} {tolerance:e}: error/tolerance {:.3}, {:?}", error / tolerance, adaptive.controller());
            assert!(error <= least * tolerance, "{name}: {error:e} at {tolerance:e}");
            assert!(error >= 1e-3 * tolerance, "{name}: {error:e} at {tolerance:e} is wasteful");
            assert!(report.error.is_some_and(|e| e <= tolerance * adaptive.diffusion().norm(&line.state(&law))));
            solves.push(report.solves);
        }
        assert!(solves.is_sorted() && solves[0] < solves[2], "{name}: {solves:?}");
    }
    Ok(())
}

#[test]
fn the_estimate_of_a_fixed_step_bounds_the_error_of_the_run() -> Outcome {
    let line = Line::new()?;
    for law in [Law::from_speed(0.2, 1.0, 0.0)?, Law::from_speed(0.2, 1.0, 0.05)?, Law::fourier(0.04)?] {
        let settings = Settings { tolerance: 1e-10, ..Settings::default() };
        let mut diffusion = Diffusion::new(&line.grid, &line.sides, None, law, settings)?;
        diffusion.estimate_errors(true)?;
        let mut state = line.state(&law);
        let (size, mut most) = (diffusion.norm(&state), 0.0f64);
        for _ in 0..40 {
            let report = diffusion.step(&mut state, &Medium::Still, Source::NONE, END / 40.0)?;
            most = most.max(report.error.ok_or("no estimate")? / size);
        }
        let error = line.error(&law, &state);
        assert!(error < most && most < 1e4 * error, "{law:?}: {error:e}, estimated {most:e}");
    }
    Ok(())
}

#[test]
fn estimates_change_no_bit() -> Outcome {
    let line = Line::new()?;
    let law = Law::from_speed(0.2, 1.0, 0.05)?;
    let run = |estimate| -> Outcome<State<f64, 2>> {
        let mut diffusion = Diffusion::new(&line.grid, &line.sides, None, law, Settings::default())?;
        diffusion.estimate_errors(estimate)?;
        let mut state = line.state(&law);
        for _ in 0..5 {
            let report = diffusion.step(&mut state, &Medium::Still, Source::NONE, 0.02)?;
            assert_eq!(report.error.is_some(), estimate);
        }
        Ok(state)
    };
    assert_eq!(run(true)?.phi, run(false)?.phi);
    Ok(())
}

#[test]
fn threads_leave_no_trace() -> Outcome {
    let line = Line::new()?;
    let law = Law::from_speed(0.2, 1.0, 0.05)?;
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut adaptive = line.adaptive(law, 1e-3).expect("a stepper");
            let mut state = line.state(&law);
            adaptive.advance(&mut state, &Medium::Still, Source::NONE, 0.3).expect("steps");
            (state.phi, *adaptive.controller())
        })
    };
    let one = with(1);
    assert_eq!(with(2), one);
    assert_eq!(with(5), one);
    Ok(())
}

#[test]
fn only_sdirk2_estimates_and_too_much_is_refused() -> Outcome {
    let line = Line::new()?;
    let law = Law::from_speed(0.2, 1.0, 0.0)?;
    for integrator in [Integrator::PaperBe, Integrator::Kdk] {
        let settings = Settings { integrator, ..Settings::default() };
        let diffusion = Diffusion::<f64, 2>::new(&line.grid, &line.sides, None, law, settings)?;
        let refused = Adaptive::new(diffusion, Controller::new(1e-3, 0.1)?).err();
        assert!(matches!(refused, Some(StepError::NoEstimate { .. })), "{refused:?}");
    }
    // Solves so loose that no step has an error of 1e-13.
    let diffusion = Diffusion::new(&line.grid, &line.sides, None, law, Settings::default())?;
    let mut adaptive = Adaptive::new(diffusion, Controller::new(1e-17, 0.1)?)?;
    let refused = adaptive.advance(&mut line.state(&law), &Medium::Still, Source::NONE, END);
    assert!(matches!(refused, Err(StepError::OutOfReach { .. })), "{refused:?}");
    Ok(())
}
