//! The moving medium that carries φ and q_C: at rest, in uniform motion, or with a velocity on every face
//! (paper eqs 8 to 10: u \[m/s\]).

mod make;
mod survey;

use cf_grid::{End, FaceField, Grid, Layout, Max, Real, Reduce, Sides, Wall};
use nalgebra::SVector;

pub use make::{sample, stream_function, vector_potential};
pub(crate) use survey::Survey;
use survey::{all_finite, measure, on_wall};

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
    #[error(
        "the medium's velocity along axis {axis} is {value} at the face of cell {cell:?}, expected a finite velocity"
    )]
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
        let mut survey = Survey { speed: [0.0; D], change: [0.0; D], uniform: !matches!(self, Medium::Field(_)) };
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
