//! What must stay, and what must not grow: mass, E', and the energy identity of backward Euler.

use cf_grid::{Axis, Grid, Mask, Real, Sides, Wall};

use super::amplification::{Precise, step_for};
use super::case::{Case, Kinds};
use super::random::Random;
use super::{Measured, Row, Table};
use crate::energy::face_square;
use crate::{Integrator, Law, Medium, Source, State, energy};

/// |change of ∫phi - emitted + outflow| over `steps` steps with a random source, relative to the largest ∫|phi| on the way.
pub(super) fn mass_error<T: Real, const D: usize>(
    case: &Case<D>,
    medium: &Medium<T, D>,
    random: &mut Random,
    steps: usize,
) -> Measured {
    let layout = case.grid.layout();
    let volume = case.grid.cell_volume();
    let mut state = case.random_state::<T>(random, 1.0, case.flux_unit());
    let rate = case.random_state::<T>(random, 1.0 / (case.dt * steps as f64), 0.0).phi;
    let share = random.pick([0.0, 0.3, 1.0]);
    let mut stepper = case.stepper::<T>()?;
    let before = state.mass(&case.grid);
    let mut size = layout.sum_abs(&state.phi) * volume;
    let (mut expected, mut passed) = (before, 0.0);
    for _ in 0..steps {
        let source = Source::during(&rate, share);
        let report = stepper.step(&mut state, medium, source, case.dt)?;
        expected += report.emitted - report.outflow;
        passed += report.emitted.abs() + report.outflow.abs();
        size = size.max(layout.sum_abs(&state.phi) * volume);
    }
    passed += steps as f64 * case.passing();
    Ok((state.mass(&case.grid) - expected).abs() / (size + passed))
}

/// The largest growth of E' in one of `steps` steps, relative to E' at the start.
pub(super) fn energy_growth<T: Real, const D: usize>(case: &Case<D>, random: &mut Random, steps: usize) -> Measured {
    let mut state = case.random_state::<T>(random, 1.0, case.flux_unit());
    // What stands in solid cells does not change and is left out.
    let layout = *case.grid.layout();
    layout.each_cell(layout.cells_region(), |at| {
        if !case.is_fluid(at.slot()) {
            state.phi[at.slot()] = T::ZERO;
        }
    });
    let mut stepper = case.stepper::<T>()?;
    let start = case.energy(&state);
    let (mut last, mut growth): (f64, f64) = (start, f64::NEG_INFINITY);
    for _ in 0..steps {
        stepper.step(&mut state, &Medium::Still, Source::NONE, case.dt)?;
        let now = case.energy(&state);
        growth = if now.is_finite() { growth.max((now - last) / start) } else { f64::INFINITY };
        last = now;
    }
    Ok(if start > 0.0 { growth } else { last })
}

/// The residual of the energy identity of one backward Euler step, relative to E:
/// E' - E = -1/2 |dphi|² - tau/2k_C |dq|² - dt k_F |G phi|² - dt/k_C |q|².
pub(super) fn identity_error<const D: usize>(case: &Case<D>, random: &mut Random) -> Measured {
    let (law, grid, sides) = (&case.law, &case.grid, &case.sides);
    let start = case.random_state::<f64>(random, 1.0, case.flux_unit());
    let mut end = start.clone();
    case.run(&mut end, 1)?;
    let square = |state: &State<f64, D>| -> f64 {
        let q = state.slow_flux.as_ref();
        q.map_or(0.0, |q| (0..D).map(|a| face_square(grid, sides, a, q.axis(a))).sum::<f64>()) * grid.cell_volume()
    };
    let mut change = end.clone();
    for (d, s) in change.phi.iter_mut().zip(start.phi.iter()) {
        *d -= s;
    }
    if let (Some(q), Some(old)) = (&mut change.slow_flux, &start.slow_flux) {
        for (d, s) in q.axes_mut().into_iter().zip(old.axes()) {
            d.iter_mut().zip(s).for_each(|(d, s)| *d -= s);
        }
    }
    let mut gradient = end.clone();
    case.set_gradient(&mut gradient, 1.0);
    let lost = energy::cattaneo_energy(grid, sides, law, &change)
        + case.dt * (law.k_fourier() * square(&gradient) + square(&end) / law.k_cattaneo());
    let [before, after] = [&start, &end].map(|s| energy::cattaneo_energy(grid, sides, law, s));
    Ok((after - before + lost).abs() / before)
}

fn mixed<const D: usize>(cells: [usize; D], law: Law, integrator: Integrator, kappa: f64) -> Measured<Case<D>> {
    let h = 0.2;
    let dt = step_for(&law, kappa * h * h);
    let mut case = Case::new(cells, h, law, integrator, dt)?;
    let walls = [Wall::CLOSED, Wall::Value(0.0)];
    case.sides = Sides(std::array::from_fn(|a| if a == 1 { Axis::Periodic } else { Axis::Walls(walls) }));
    Ok(case)
}

/// A bar, a pocket and scattered cells.
fn obstacles<const D: usize>(grid: &Grid<D>) -> Mask<D> {
    let n = grid.cells();
    Mask::new(grid.layout(), |c| {
        let (x, y) = (c[0], c[1]);
        let ring = x.abs_diff(n[0] / 2) <= 1 && y.abs_diff(n[1] / 2) <= 1 && (x, y) != (n[0] / 2, n[1] / 2);
        !(ring || x == 1 && y > 0 && y + 1 < n[1])
    })
}

fn mass_rows<T: Precise>(rows: &mut Vec<Row>, law: Law, random: &mut Random) {
    let text = |what: &str| format!("{} {what} tau={:.0e} F={}", T::NAME, law.tau(), law.fourier_share());
    for integrator in [Integrator::PaperBe, Integrator::Sdirk2] {
        for (kappa, tolerance) in [(0.3, 1e-1), (30.0, 1e-3), (1e4, 1e-1), (1e4, 1e-10)] {
            let found = mixed([17, 12], law, integrator, kappa).and_then(|mut case| {
                case.sides = Sides([Axis::Walls([Wall::CLOSED; 2]), Axis::Periodic]);
                case.settings.tolerance = tolerance;
                mass_error::<T, 2>(&case, &Medium::Still, random, 5)
            });
            let name = text(&format!("closed {integrator:?} kappa={kappa:.0e} eta={tolerance:.0e}"));
            rows.push(Row::at_most("mass", name, T::MASS, found));
        }
        for kappa in [1e-6, 1.0, 1e3, 1e6, 1e12] {
            let found = mixed([9, 10, 7], law, integrator, kappa).and_then(|mut case| {
                case.settings.tolerance = 1e-4;
                case.random_box(random, Kinds::Any, 9)?;
                case.mask = Some(obstacles(&case.grid));
                mass_error::<T, 3>(&case, &Medium::Still, random, 4)
            });
            rows.push(Row::at_most(
                "balance",
                text(&format!("walls {integrator:?} kappa={kappa:.0e}")),
                T::MASS,
                found,
            ));
        }
    }
}

fn energy_rows<T: Precise>(rows: &mut Vec<Row>, law: Law, random: &mut Random) {
    for integrator in [Integrator::PaperBe, Integrator::Sdirk2] {
        for kappa in [1e-6, 0.1, 10.0, 1e3, 1e6, 1e12] {
            let found = mixed([11, 8], law, integrator, kappa).and_then(|mut case| {
                case.mask = random.chance(0.5).then(|| obstacles(&case.grid));
                energy_growth::<T, 2>(&case, random, 6)
            });
            let (name, tau, share) = (T::NAME, law.tau(), law.fourier_share());
            let text = format!("{name} {integrator:?} tau={tau:.0e} F={share} kappa={kappa:.0e}");
            rows.push(Row::at_most("growth of E'", text, T::ENERGY, found));
        }
    }
}

/// Mass at any tolerance and with any walls, E' under every law, and the exact identity of backward Euler.
pub fn conservation() -> Table {
    let mut rows = Vec::new();
    let mut random = Random(1);
    let laws = [(1.0, 0.3, 0.0), (1.0, 0.3, 0.4), (1.0, 1e-9, 0.1), (1.0, 0.0, 0.0), (1.0, 1e6, 0.0), (1.0, 1.0, 1.0)];
    for (k, tau, share) in laws {
        let Ok(law) = Law::new(k, tau, share) else { continue };
        mass_rows::<f64>(&mut rows, law, &mut random);
        mass_rows::<f32>(&mut rows, law, &mut random);
        energy_rows::<f64>(&mut rows, law, &mut random);
        energy_rows::<f32>(&mut rows, law, &mut random);
        if !law.has_memory() {
            continue;
        }
        for kappa in [0.01, 1.0, 100.0] {
            let found = mixed([9, 11], law, Integrator::PaperBe, kappa).and_then(|mut case| {
                case.mask = Some(obstacles(&case.grid));
                identity_error(&case, &mut random)
            });
            let text = format!("tau={tau:.0e} F={share} kappa={kappa:.0e}");
            rows.push(Row::at_most("energy identity of PaperBe", text, 1e-12, found));
        }
    }
    Table { title: "Conservation of mass and decay of energy", rows }
}
