//! One step on every mode of a box against its 2×2 matrix.

use cf_grid::{Axis, Real, Sides, Wall};

use super::case::Case;
use super::{Measured, Row, Table};
use crate::exact::amplification as exact;
use crate::exact::{AxisModes, Walls};
use crate::{Integrator, Law, Medium, Source, State, kdk_limit};

/// What the precisions promise.
pub trait Precise: Real {
    /// Error of one step relative to its start, in the energy norm, for kappa up to 1e3.
    const STEP: f64;
    /// Drift of the mass relative to the sum of |phi|.
    const MASS: f64;
    /// Growth of E' by rounding, relative.
    const ENERGY: f64;
}

impl Precise for f32 {
    const STEP: f64 = 1e-5;
    const MASS: f64 = 1e-6;
    const ENERGY: f64 = 1e-5;
}

impl Precise for f64 {
    const STEP: f64 = 1e-12;
    const MASS: f64 = 1e-12;
    const ENERGY: f64 = 1e-12;
}

/// The growing bound beyond kappa = 1e3: a relative rounding ε of phi is sqrt(kappa w) ε in the energy of the gradient's flux.
pub(super) fn rounding<T: Real>(kappa: f64) -> f64 {
    2.0 * T::EPSILON * kappa.sqrt()
}

/// The walls of an axis as a box has them.
fn axis_of(walls: Walls) -> Axis<Wall> {
    let (closed, valued) = (Wall::CLOSED, Wall::Value(0.0));
    match walls {
        Walls::Periodic => Axis::Periodic,
        Walls::Closed => Axis::Walls([closed; 2]),
        Walls::Valued => Axis::Walls([valued; 2]),
        Walls::ClosedValued => Axis::Walls([closed, valued]),
        Walls::ValuedClosed => Axis::Walls([valued, closed]),
    }
}

/// The largest error of one step over all modes of the case's box between `walls`, from phi = mode and from
/// div q_C = mode: the energy norm of the difference to the exact matrix, relative to that of the start.
pub fn one_step_error<T: Real, const D: usize>(case: &Case<D>, walls: [Walls; D]) -> Measured {
    let case = Case { sides: Sides(walls.map(axis_of)), mask: None, ..case.clone() };
    let (cells, h, law, dt) = (case.grid.cells(), case.grid.h(), case.law, case.dt);
    let axes = walls.into_iter().zip(cells).map(|(w, n)| AxisModes::new(w, n, h).ok_or("no modes"));
    let axes: Vec<AxisModes> = axes.collect::<Result<_, _>>()?;
    let matrix = |lambda| match case.settings.integrator {
        Integrator::PaperBe => exact::paper_be(&law, dt, lambda),
        Integrator::Sdirk2 => exact::sdirk2(&law, dt, lambda),
        Integrator::Kdk => exact::kdk(&law, dt, lambda),
    };
    let mut stepper = case.stepper::<T>()?;
    let mut worst: f64 = 0.0;
    for number in 0..cells.iter().product() {
        let mut left = number;
        let mode: [usize; D] = cells.map(|n| {
            let m = left % n;
            left /= n;
            m
        });
        let lambda: f64 = axes.iter().zip(mode).map(|(axis, m)| axis.eigenvalue(m)).sum();
        let shape = |cell: [usize; D]| (0..D).map(|a| axes[a].vector(mode[a], cell[a])).product::<f64>();
        let a = matrix(lambda);
        // What a step makes of the mode: phi = p shape, div q_C = d shape, that is q_C = -d/lambda Grad shape.
        let of = |p: f64, d: f64| -> State<f64, D> {
            let mut state = State::new(&case.grid, &law);
            case.set_phi(&mut state, shape);
            if lambda > 0.0 {
                case.set_gradient(&mut state, -d / lambda);
            }
            case.set_phi(&mut state, |cell| p * shape(cell));
            state
        };
        // phi and div q_C of equal energy.
        let unit = if law.has_memory() && lambda > 0.0 { (law.k() * lambda / law.tau()).sqrt() } else { 0.0 };
        for (p, d) in [(1.0, 0.0), (0.0, unit)] {
            if p == 0.0 && d == 0.0 {
                continue;
            }
            let start = of(p, d);
            let mut state = rounded::<T, f64, D>(&case, &start);
            stepper.step(&mut state, &Medium::Still, Source::NONE, dt)?;
            let expected = of(a[0][0] * p + a[0][1] * d, a[1][0] * p + a[1][1] * d);
            worst = worst.max(distance(&case, &state, &expected) / case.energy(&start).sqrt());
        }
    }
    Ok(worst)
}

/// A state in another precision.
pub(super) fn rounded<T: Real, S: Real, const D: usize>(case: &Case<D>, from: &State<S, D>) -> State<T, D> {
    let mut state = State::new(&case.grid, &case.law);
    for (to, x) in state.phi.iter_mut().zip(from.phi.iter()) {
        *to = T::of(x.f64());
    }
    if let (Some(q), Some(from)) = (&mut state.slow_flux, &from.slow_flux) {
        for (to, from) in q.axes_mut().into_iter().zip(from.axes()) {
            to.iter_mut().zip(from).for_each(|(to, x)| *to = T::of(x.f64()));
        }
    }
    state
}

/// sqrt E' of the difference of two states.
pub(super) fn distance<T: Real, const D: usize>(case: &Case<D>, one: &State<T, D>, other: &State<f64, D>) -> f64 {
    let mut difference = other.clone();
    for (d, x) in difference.phi.iter_mut().zip(one.phi.iter()) {
        *d -= x.f64();
    }
    if let (Some(q), Some(from)) = (&mut difference.slow_flux, &one.slow_flux) {
        for (d, from) in q.axes_mut().into_iter().zip(from.axes()) {
            d.iter_mut().zip(from).for_each(|(d, x)| *d -= x.f64());
        }
    }
    case.energy(&difference).sqrt()
}

/// Every mix of walls per axis.
fn mixes<const D: usize>() -> Vec<[Walls; D]> {
    let kinds = [Walls::Periodic, Walls::Closed, Walls::Valued, Walls::ClosedValued, Walls::ValuedClosed];
    (0..kinds.len().pow(D as u32))
        .map(|mut number| {
            [(); D].map(|()| {
                let kind = kinds[number % kinds.len()];
                number /= kinds.len();
                kind
            })
        })
        .collect()
}

/// The worst error over every mix of walls. `kappa` fixes the step of the implicit integrators; Kdk takes
/// 0.9 of its limit.
fn worst<T: Real, const D: usize>(cells: [usize; D], law: Law, integrator: Integrator, kappa: f64) -> Measured {
    let h = 0.3;
    let dt = match integrator {
        Integrator::Kdk => 0.9 * kdk_limit(&law, 4.0 * D as f64 / (h * h)),
        // beta = dt (k_F + k_C dt/(tau + dt)) by the root that does not cancel.
        _ => step_for(&law, kappa * h * h),
    };
    let case = Case::new(cells, h, law, integrator, dt)?;
    let errors = mixes::<D>().into_iter().map(|walls| one_step_error::<T, D>(&case, walls));
    errors.into_iter().try_fold(0.0, |most: f64, e| Ok(most.max(e?)))
}

/// The step for which the weight of the Laplacian is `beta` \[m²\].
pub(super) fn step_for(law: &Law, beta: f64) -> f64 {
    if !law.has_memory() {
        return beta / law.k();
    }
    // k dt² + (k_F tau - beta) dt - beta tau = 0.
    let (tau, half) = (law.tau(), 0.5 * (law.k_fourier() * law.tau() - beta));
    let root = half.hypot((law.k() * beta * tau).sqrt());
    if half > 0.0 { beta * tau / (half + root) } else { (root - half) / law.k() }
}

/// One step of each integrator against its matrices: walls mixed per axis, all modes, laws of every kind.
///
/// The errors are below 1e-12 (f64) and 1e-5 (f32) for kappa up to 1e3; beyond, below 2 ε sqrt(kappa) where that is more.
pub fn amplification() -> Table {
    let mut rows = Vec::new();
    let laws = [(0.7, 0.4, 0.0), (0.7, 0.4, 0.3), (0.7, 1e-9, 0.0), (0.7, 0.0, 0.5), (0.7, 1e9, 0.0), (0.7, 2.0, 1.0)];
    for (k, tau, share) in laws {
        let Ok(law) = Law::new(k, tau, share) else { continue };
        for integrator in [Integrator::PaperBe, Integrator::Sdirk2, Integrator::Kdk] {
            let kdk = integrator == Integrator::Kdk;
            if kdk && !(tau > 0.0 && share == 0.0) {
                continue;
            }
            let kappas: &[f64] = if kdk { &[0.0] } else { &[0.02, 3.0, 1e3, 1e6, 1e12] };
            for &kappa in kappas {
                let text = |t, d| format!("{integrator:?} {t} {d} tau={tau:.0e} F={share} kappa={kappa:.0e}");
                let found = worst::<f64, 2>([5, 4], law, integrator, kappa);
                rows.push(Row::at_most("one step", text("f64", "2D"), f64::STEP.max(rounding::<f64>(kappa)), found));
                let found = worst::<f32, 2>([5, 4], law, integrator, kappa);
                rows.push(Row::at_most("one step", text("f32", "2D"), f32::STEP.max(rounding::<f32>(kappa)), found));
                let found = worst::<f64, 3>([3, 4, 2], law, integrator, kappa);
                rows.push(Row::at_most("one step", text("f64", "3D"), f64::STEP.max(rounding::<f64>(kappa)), found));
                let found = worst::<f32, 3>([3, 4, 2], law, integrator, kappa);
                rows.push(Row::at_most("one step", text("f32", "3D"), f32::STEP.max(rounding::<f32>(kappa)), found));
            }
        }
    }
    Table { title: "Amplification of modes in one step", rows }
}
