//! The moving medium that carries φ and q_C: at rest, in uniform motion, or with a velocity on every face
//! (model section 1: u \[m/s\]).

use cf_grid::{End, FaceField, Grid, Layout, Max, Real, Reduce, Region, Sides, Wall};
use nalgebra::SVector;

/// How the medium moves.
#[derive(Debug, Clone, PartialEq)]
pub enum Medium<T, const D: usize> {
    /// At rest: nothing is transported, nothing is stored.
    Still,
    /// The same velocity \[m/s\] everywhere, stored as `D` numbers.
    Uniform(SVector<f64, D>),
    /// The normal velocity \[m/s\] on every face. On a periodic axis only the seam face at the low slot is read.
    Field(FaceField<T, D>),
}

/// Why a medium is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MediumError {
    /// A velocity, stream function or vector potential that is infinite or not a number.
    #[error("the medium's velocity along axis {axis} is {value} at the face of cell {cell:?}, expected a finite velocity")]
    NotFinite {
        /// Axis of the velocity component.
        axis: usize,
        /// Cell above the face, in the first `D` entries (zeros for a uniform velocity).
        cell: [usize; 3],
        /// The value found \[m/s\].
        value: f64,
    },
    /// The medium flows through a wall with a prescribed flux.
    #[error(
        "the medium crosses the {end:?} wall of axis {axis} at {value:e} m/s, but a Flux wall lets no medium pass; \
         use an Open, Absorbing or Value wall there, or a velocity without normal component"
    )]
    CrossesClosedWall {
        /// Axis normal to the wall.
        axis: usize,
        /// End of the axis.
        end: End,
        /// Largest normal speed found on the wall \[m/s\].
        value: f64,
    },
    /// A velocity field of another layout.
    #[error("the medium's velocity has {found} slots per axis, expected {expected}; make it on the same grid")]
    Layout {
        /// Slots of the grid's layout.
        expected: usize,
        /// Slots of the velocity field.
        found: usize,
    },
}

/// Largest speeds and their largest changes across a cell, per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Survey<const D: usize> {
    /// max |u_a| \[m/s\].
    pub speed: [f64; D],
    /// max |u_a(right face) − u_a(left face)| \[m/s\].
    pub change: [f64; D],
}

impl<T: Real, const D: usize> Medium<T, D> {
    /// Whether every velocity is zero by construction.
    pub fn is_still(&self) -> bool {
        match self {
            Medium::Still => true,
            Medium::Uniform(u) => u.iter().all(|&v| v == 0.0),
            Medium::Field(_) => false,
        }
    }

    /// Bytes of storage behind the velocity; only a field has any.
    pub fn bytes(&self) -> usize {
        if let Medium::Field(u) = self { u.bytes() } else { 0 }
    }

    /// Refuses velocities that are not finite, fields of another layout, and flow through a [`Wall::Flux`].
    ///
    /// A wall counts as crossed when the normal speed on it exceeds 64 ε max|u|, with ε the spacing of `T` at 1: the
    /// rounding of a velocity made by differences. What stays below is treated as zero by the transport.
    pub fn check(&self, grid: &Grid<D>, sides: &Sides<Wall, D>) -> Result<(), MediumError> {
        self.survey(grid, sides).map(|_| ())
    }

    /// max |u_a| \[m/s\] per axis, over the faces that exist.
    pub fn max_speed(&self, grid: &Grid<D>, sides: &Sides<Wall, D>) -> Result<SVector<f64, D>, MediumError> {
        Ok(SVector::from(self.survey(grid, sides)?.speed))
    }

    /// Courant number of a step `dt` \[s\]: the maximum over the axes of max|u_a| dt/h \[1\] (not their sum: transport is
    /// split by dimension).
    pub fn courant(&self, grid: &Grid<D>, sides: &Sides<Wall, D>, dt: f64) -> Result<f64, MediumError> {
        Ok(self.max_speed(grid, sides)?.max() * dt / grid.h())
    }

    /// max |div u| over the cells \[1/s\], div u = Σ_a (u_R − u_L)/h.
    pub fn divergence(&self, grid: &Grid<D>, sides: &Sides<Wall, D>) -> Result<f64, MediumError> {
        self.survey(grid, sides)?;
        let Medium::Field(u) = self else { return Ok(0.0) };
        let layout = grid.layout();
        let max: Max = layout.par_runs(layout.cells_region(), (), |run, ()| {
            run.ats().fold(Max(0.0), |max, at| {
                let sum: f64 = (0..D)
                    .map(|a| {
                        let seam = sides.is_periodic(a) && at.cell[a] + 1 == layout.cells()[a];
                        let high = if seam { seam_slot(layout, a, at.cell) } else { at.high(a) };
                        u.axis(a)[high].f64() - u.axis(a)[at.slot()].f64()
                    })
                    .sum();
                max.merge(Max(sum.abs()))
            })
        });
        Ok(max.0 / grid.h())
    }

    /// Checks everything and measures the speeds in one reading of the velocity.
    pub(crate) fn survey(&self, grid: &Grid<D>, sides: &Sides<Wall, D>) -> Result<Survey<D>, MediumError> {
        let mut survey = Survey { speed: [0.0; D], change: [0.0; D] };
        match self {
            Medium::Still => return Ok(survey),
            Medium::Uniform(u) => {
                for (axis, &value) in u.iter().enumerate() {
                    if !value.is_finite() {
                        return Err(MediumError::NotFinite { axis, cell: [0; 3], value });
                    }
                    survey.speed[axis] = value.abs();
                }
            }
            Medium::Field(u) => {
                for axis in 0..D {
                    let (values, layout) = (u.axis(axis), grid.layout());
                    if values.len() != layout.slots() {
                        return Err(MediumError::Layout { expected: layout.slots(), found: values.len() });
                    }
                    let (speed, change) = measure(layout, sides.is_periodic(axis), axis, values);
                    if !speed.is_finite() {
                        let region = layout.faces_region(axis, sides.is_periodic(axis));
                        all_finite(layout, region, axis, values)?;
                    }
                    (survey.speed[axis], survey.change[axis]) = (speed, change);
                }
            }
        }
        let tolerance = 64.0 * T::EPSILON * survey.speed.into_iter().fold(0.0, f64::max);
        for (axis, end, wall) in sides.walls() {
            let value = match self {
                Medium::Field(u) if wall.carried_in().is_none() => on_wall(grid.layout(), axis, end, u.axis(axis)),
                _ => survey.speed[axis],
            };
            if wall.carried_in().is_none() && value > tolerance {
                return Err(MediumError::CrossesClosedWall { axis, end, value });
            }
        }
        Ok(survey)
    }
}

fn seam_slot<const D: usize>(layout: &Layout<D>, axis: usize, mut cell: [usize; D]) -> usize {
    cell[axis] = 0;
    layout.slot(cell)
}

/// max |u| and max |u_R − u_L| along `axis`; NaN or infinite where a value is.
fn measure<T: Real, const D: usize>(layout: &Layout<D>, periodic: bool, axis: usize, u: &[T]) -> (f64, f64) {
    let last = layout.cells()[axis] - 1;
    let (speed, change): (Max, Max) = layout.par_runs(layout.cells_region(), (), |run, ()| {
        let row = run.row(u);
        if !periodic {
            measure_row(row, run.high(axis, u))
        } else if axis == 0 {
            measure_row(row, &row[1..]).merge(measure_row(&row[row.len() - 1..], row))
        } else if run.cell[axis] == last {
            measure_row(row, run.wrapped(axis, 1).row(u))
        } else {
            measure_row(row, run.high(axis, u))
        }
    });
    (speed.0, change.0)
}

/// The same for the pairs of two rows, in fixed lanes; v − v turns what is not finite into NaN.
fn measure_row<T: Real>(low: &[T], high: &[T]) -> (Max, Max) {
    const LANES: usize = 8;
    let (mut speed, mut change, mut poison) = ([T::ZERO; LANES], [T::ZERO; LANES], [T::ZERO; LANES]);
    let mut pair = |lane: usize, l: T, h: T| {
        speed[lane] = speed[lane].max(l.abs()).max(h.abs());
        change[lane] = change[lane].max((h - l).abs());
        poison[lane] += (l - l) + (h - h);
    };
    let n = low.len().min(high.len());
    let (lows, highs) = (low[..n].chunks_exact(LANES), high[..n].chunks_exact(LANES));
    for (&l, &h) in lows.remainder().iter().zip(highs.remainder()) {
        pair(0, l, h);
    }
    for (l, h) in lows.zip(highs) {
        for lane in 0..LANES {
            pair(lane, l[lane], h[lane]);
        }
    }
    let top = |lanes: [T; LANES]| lanes.iter().fold(0.0, |m: f64, v| m.max(v.f64()));
    let poison: f64 = poison.iter().map(|v| v.f64()).sum();
    (Max(top(speed) + poison), Max(top(change) + poison))
}

fn on_wall<T: Real, const D: usize>(layout: &Layout<D>, axis: usize, end: End, u: &[T]) -> f64 {
    let mut layer = layout.faces_region(axis, false);
    match end {
        End::Low => layer.high[axis] = 1,
        End::High => layer.low[axis] = layer.high[axis] - 1,
    }
    let max: Max = layout.par_runs(layer, (), |run, ()| {
        run.row(u).iter().fold(Max(0.0), |m, v| m.merge(Max(v.f64().abs())))
    });
    max.0
}

/// The first offender in storage order.
#[derive(Default)]
struct First(Option<MediumError>);

impl Reduce for First {
    fn merge(self, next: Self) -> Self {
        First(self.0.or(next.0))
    }
}

fn all_finite<T: Real, const D: usize>(
    layout: &Layout<D>,
    region: Region<D>,
    axis: usize,
    u: &[T],
) -> Result<(), MediumError> {
    let first: First = layout.par_runs(region, (), |run, ()| {
        First(run.ats().find(|at| !u[at.slot()].is_finite()).map(|at| {
            let cell = std::array::from_fn(|a| at.cell.get(a).copied().unwrap_or(0));
            MediumError::NotFinite { axis, cell, value: u[at.slot()].f64() }
        }))
    });
    first.0.map_or(Ok(()), Err)
}

/// The velocity u(x) \[m/s\] at the centres x \[m\] of all faces, walls included.
pub fn sample<T: Real, const D: usize>(
    grid: &Grid<D>,
    velocity: impl Fn(SVector<f64, D>) -> SVector<f64, D> + Sync,
) -> Result<FaceField<T, D>, MediumError> {
    on_faces(grid, |axis, cell| velocity(grid.face(axis, cell))[axis])
}

/// A velocity without divergence from a stream function ψ \[m²/s\] sampled at the cell corners x \[m\]
/// (model/fluid section 1): u_x = ∂ψ/∂y, u_y = −∂ψ/∂x, as differences over one cell edge.
///
/// max|div u| is round-off in `T`. On periodic axes ψ must be periodic up to a linear function.
pub fn stream_function<T: Real>(
    grid: &Grid<2>,
    psi: impl Fn(SVector<f64, 2>) -> f64 + Sync,
) -> Result<FaceField<T, 2>, MediumError> {
    let corner = |i: [usize; 2]| psi(grid.origin() + SVector::from(i).map(|i: usize| i as f64 * grid.h()));
    on_faces(grid, |axis, [i, j]| match axis {
        0 => (corner([i, j + 1]) - corner([i, j])) / grid.h(),
        _ => (corner([i, j]) - corner([i + 1, j])) / grid.h(),
    })
}

/// A velocity without divergence from a vector potential A \[m²/s\] sampled at the middles x \[m\] of the cell edges
/// (model/fluid section 1): u = curl A, component by component as the circulation around the face.
///
/// max|div u| is round-off in `T`. On periodic axes A must be periodic up to a linear function.
pub fn vector_potential<T: Real>(
    grid: &Grid<3>,
    potential: impl Fn(SVector<f64, 3>) -> SVector<f64, 3> + Sync,
) -> Result<FaceField<T, 3>, MediumError> {
    // Component `along` at the middle of the edge that starts at a corner and runs along it.
    let edge = |along: usize, corner: [usize; 3]| {
        let mut at = SVector::from(corner).map(|i: usize| i as f64);
        at[along] += 0.5;
        potential(grid.origin() + at * grid.h())[along]
    };
    on_faces(grid, |axis, corner| {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let up = |a: usize| std::array::from_fn(|i| corner[i] + usize::from(i == a));
        ((edge(c, up(b)) - edge(c, corner)) - (edge(b, up(c)) - edge(b, corner))) / grid.h()
    })
}

fn on_faces<T: Real, const D: usize>(
    grid: &Grid<D>,
    value: impl Fn(usize, [usize; D]) -> f64 + Sync,
) -> Result<FaceField<T, D>, MediumError> {
    let layout = grid.layout();
    let mut u = FaceField::new(layout);
    for axis in 0..D {
        let region = layout.faces_region(axis, false);
        layout.par_region(region, u.axis_mut(axis), |at| T::of(value(axis, at.cell)));
        all_finite(layout, region, axis, u.axis(axis))?;
    }
    Ok(u)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use cf_grid::Axis;

    use super::*;

    #[test]
    fn curls_have_no_divergence() {
        let grid = Grid::new([9, 14], 0.1).unwrap();
        let u = stream_function::<f64>(&grid, |x| (x[0] * 3.0).sin() * (x[1] * 5.0).cos() + x[0] * x[1]).unwrap();
        let open = Sides::all(Wall::Open { inflow: 0.0 });
        assert!(Medium::Field(u).divergence(&grid, &open).unwrap() < 1e-12);

        let grid = Grid::new([5, 6, 7], 1.0 / 6.0).unwrap();
        let a = |x: SVector<f64, 3>| SVector::from([(x[1] * 5.0).sin(), x[2] * x[0], (x[0] - x[1]).cos()]);
        let u = Medium::Field(vector_potential::<f64>(&grid, a).unwrap());
        assert!(u.divergence(&grid, &Sides::all(Wall::Open { inflow: 0.0 })).unwrap() < 1e-12);
        assert!(u.max_speed(&grid, &Sides::periodic()).unwrap().min() > 0.1);
        // u = curl (0, 0, y) = (1, 0, 0)
        let u = vector_potential::<f64>(&grid, |x| SVector::from([0.0, 0.0, x[1]])).unwrap();
        assert!((u.axis(0)[grid.layout().slot([2, 3, 4])] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_divergence_of_a_known_field_and_the_courant_number() {
        let grid = Grid::new([8, 8], 0.25).unwrap();
        let open = Sides::all(Wall::Open { inflow: 0.0 });
        let u = Medium::Field(sample::<f64, 2>(&grid, |x| SVector::from([2.0 * x[0], -x[1]])).unwrap());
        assert!((u.divergence(&grid, &open).unwrap() - 1.0).abs() < 1e-13);
        assert_eq!(u.max_speed(&grid, &open).unwrap().as_slice(), [4.0, 2.0]);
        assert_eq!(u.courant(&grid, &open, 0.5).unwrap(), 8.0);
        let uniform = Medium::<f32, 2>::Uniform(SVector::from([-3.0, 1.0]));
        assert_eq!(uniform.courant(&grid, &open, 0.25).unwrap(), 3.0);
        assert_eq!(Medium::<f32, 2>::Still.courant(&grid, &open, 1.0).unwrap(), 0.0);
        // A periodic seam is read at the low slot, whatever lies in the rim.
        let mut u = stream_function::<f64>(&grid, |x| (TAU * x[0] / 2.0).sin()).unwrap();
        let rim = grid.layout().slot([0, 8]);
        u.axis_mut(1)[rim] = f64::NAN;
        let u = Medium::Field(u);
        assert!(u.divergence(&grid, &Sides::periodic()).unwrap() < 1e-12);
        assert!(matches!(u.check(&grid, &open), Err(MediumError::NotFinite { axis: 1, cell: [0, 8, 0], .. })));
    }

    #[test]
    fn closed_walls_and_bad_numbers_are_refused() {
        let grid = Grid::new([4, 3], 1.0).unwrap();
        let sides = Sides([Axis::Periodic, Axis::Walls([Wall::Open { inflow: 0.0 }, Wall::CLOSED])]);
        let along = Medium::<f64, 2>::Uniform(SVector::from([5.0, 0.0]));
        assert_eq!(along.check(&grid, &sides), Ok(()));
        let across = Medium::<f64, 2>::Uniform(SVector::from([5.0, -0.5]));
        let crosses = MediumError::CrossesClosedWall { axis: 1, end: End::High, value: 0.5 };
        assert_eq!(across.check(&grid, &sides), Err(crosses));
        assert!(crosses.to_string().contains("Open"));
        let field = sample::<f32, 2>(&grid, |_| SVector::from([5.0, -0.5])).unwrap();
        assert_eq!(Medium::Field(field.clone()).check(&grid, &sides), Err(crosses));
        let mut nearly = sample::<f64, 2>(&grid, |_| SVector::from([5.0, 0.0])).unwrap();
        nearly.axis_mut(1)[grid.layout().slot([1, 3])] = 1e-15;
        assert_eq!(Medium::Field(nearly).check(&grid, &sides), Ok(()));
        let other = Grid::new([5, 3], 1.0).unwrap();
        assert!(matches!(Medium::Field(field).check(&other, &sides), Err(MediumError::Layout { .. })));
        let nan = Medium::<f64, 2>::Uniform(SVector::from([0.0, f64::NAN]));
        assert!(matches!(nan.check(&grid, &sides), Err(MediumError::NotFinite { axis: 1, .. })));
        assert!(sample::<f64, 2>(&grid, |x| SVector::from([1.0 / (x[0] - 1.0), 0.0])).is_err());
        assert!(stream_function::<f32>(&grid, |_| f64::INFINITY).is_err());
    }
}
