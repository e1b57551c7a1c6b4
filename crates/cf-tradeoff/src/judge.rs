//! What is wrong with a φ.

use crate::measured::Measured;
use crate::problem::On;
use crate::run::Run;
use crate::setting::Setting;

/// φ by cell without the rim, x contiguous.
pub(crate) fn compact<const D: usize>(on: &On<D>, phi: &[f64]) -> Vec<f64> {
    let layout = on.grid.layout();
    let mut values = Vec::with_capacity(layout.count());
    layout.each_cell(layout.cells_region(), |at| values.push(phi[at.slot()]));
    values
}

/// Sums over cells for the norms of a difference.
#[derive(Default)]
struct Norms {
    one: f64,
    two: f64,
    most: f64,
}

impl Norms {
    fn of<const D: usize>(on: &On<D>, value: impl Fn(usize) -> f64) -> Norms {
        let mut norms = Norms::default();
        let layout = on.grid.layout();
        layout.each_cell(layout.cells_region(), |at| {
            let v = value(at.slot()).abs();
            norms.one += v;
            norms.two += v * v;
            norms.most = norms.most.max(v);
        });
        norms
    }
}

pub(crate) fn judge<const D: usize>(on: &On<D>, setting: &Setting, run: &Run) -> Measured {
    let On { grid, law, exact, semi, start, .. } = on;
    let (phi, layout) = (&run.phi, grid.layout());
    let off = Norms::of(on, |i| phi[i] - exact[i]);
    let whole = Norms::of(on, |i| exact[i]);
    let time_error = semi.as_ref().map_or(f64::NAN, |semi| {
        let late = Norms::of(on, |i| phi[i] - semi[i]);
        (late.two / Norms::of(on, |i| semi[i]).two).sqrt()
    });
    let top = |values: &[f64]| layout.range(values).1;
    let (width, rise) = on.front.map_or((f64::NAN, f64::NAN), |front| shape(&compact(on, phi), front));
    let speed = law.speed().unwrap_or(0.0);
    let emitted = on.rate.as_ref().map_or(0.0, |rate| on.end * layout.sum(rate));
    Measured {
        problem: String::new(),
        cells: grid.cells().to_vec(),
        setting: *setting,
        courant: speed * on.end / run.steps as f64 / grid.h(),
        error: (off.two / whole.two).sqrt(),
        time_error,
        one: off.one / whole.one,
        worst: off.most / whole.most,
        overshoot: (top(phi) - top(exact)) / on.jump.unwrap_or(top(exact)),
        drift: (layout.sum(phi) - layout.sum(start) - emitted).abs() / layout.sum_abs(phi),
        width,
        ringing: rise / on.jump.unwrap_or(f64::NAN),
        outside: outside(on, phi),
        angle: angle(on, phi),
        iterations: run.iterations,
        seconds: run.seconds,
        runs: 1,
    }
}

/// Cells from 90 % to 10 % of the front on the right, and the largest rise.
fn shape(line: &[f64], front: f64) -> (f64, f64) {
    let (mut lowest, mut rise) = (f64::INFINITY, 0.0f64);
    for &value in line {
        lowest = lowest.min(value);
        rise = rise.max(value - lowest);
    }
    // Where phi first exceeds a level, coming from the right, between cells.
    let crossing = |level: f64| {
        let i = (1..line.len()).rev().find(|&i| line[i] < level && line[i - 1] >= level)?;
        Some(i as f64 - (level - line[i]) / (line[i - 1] - line[i]))
    };
    let width = crossing(0.1 * front).zip(crossing(0.9 * front)).map_or(f64::NAN, |(foot, head)| foot - head);
    (width, rise)
}

/// The share of |φ| outside the cone by more than three standard deviations of the source.
fn outside<const D: usize>(on: &On<D>, phi: &[f64]) -> f64 {
    let Some(wake) = &on.wake else { return f64::NAN };
    let (mut beyond, mut whole) = (0.0, 0.0);
    let layout = on.grid.layout();
    layout.each_cell(layout.cells_region(), |at| {
        let (x, value) = (on.grid.centre(at.cell), phi[at.slot()].abs());
        whole += value;
        if wake.beyond([x[0], x[1]]) > 3.0 * wake.sigma {
            beyond += value;
        }
    });
    beyond / whole
}

/// The half angle \[degrees\] of the line through the ridge of φ on the upper side, fitted by least squares over the
/// columns from 0.3 to 0.95 of where it ends; a ridge lies between cells, on the parabola through three of them.
pub(crate) fn angle<const D: usize>(on: &On<D>, phi: &[f64]) -> f64 {
    let Some(wake) = on.wake.as_ref().filter(|w| D == 2 && w.touch > 4.0 * w.sigma) else { return f64::NAN };
    let (layout, cells, h) = (on.grid.layout(), on.grid.cells(), on.grid.h());
    let [mut n, mut sx, mut sy, mut sxx, mut sxy] = [0.0; 5];
    for i in 0..cells[0] {
        let mut cell = [0; D];
        cell[0] = i;
        let along = on.grid.centre(cell)[0] - wake.source[0];
        if along < 0.3 * wake.touch || along > 0.95 * wake.touch {
            continue;
        }
        let value = |j: usize| {
            let mut cell = cell;
            cell[1] = j;
            phi[layout.slot(cell)]
        };
        let middle = (wake.source[1] / h) as usize;
        let Some(top) = (middle..cells[1] - 1).max_by(|&a, &b| value(a).total_cmp(&value(b))) else { continue };
        let [low, here, high] = [value(top - 1), value(top), value(top + 1)];
        let place = top as f64 + 0.5 + 0.5 * (high - low) / (2.0 * here - low - high);
        let across = place * h - wake.source[1];
        n += 1.0;
        sx += along;
        sy += across;
        sxx += along * along;
        sxy += along * across;
    }
    let slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    if n < 4.0 { f64::NAN } else { slope.atan().to_degrees() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_has_its_width_and_a_bump_its_height() {
        let ramp: Vec<f64> = (0..30).map(|i| (1.0 - (f64::from(i) - 10.0) / 10.0).clamp(0.0, 1.0)).collect();
        let (width, rise) = shape(&ramp, 1.0);
        assert!((width - 8.0).abs() < 1e-12 && rise == 0.0, "{width} {rise}");
        let mut bump = ramp;
        bump[25] = 0.4;
        assert!((shape(&bump, 0.5).1 - 0.4).abs() < 1e-12);
    }
}
