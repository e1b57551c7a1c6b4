//! What the projection is: orthogonal, idempotent, zero on gradients; exact on faces that are held.

use cf_diffusion::verify::{Measured, Random, Row, Table};
use cf_grid::{Axis, CellField, FaceField, Grid, Mask, Sides};
use cf_linear::Precision;

use super::random_faces;
use crate::calculus::kinetic_energy;
use crate::fluid::Fluid;
use crate::project::Projection;
use crate::settings::{Buoyancy, FlowSettings, Scheme};
use crate::wall::FlowWall;

/// Rounding that a solve to 1e-13 leaves.
const ROUNDING: f64 = 1e-12;

fn less<const D: usize>(u: &FaceField<f64, D>, v: &FaceField<f64, D>) -> FaceField<f64, D> {
    let mut w = u.clone();
    for a in 0..D {
        w.axis_mut(a).iter_mut().zip(v.axis(a)).for_each(|(w, v)| *w -= v);
    }
    w
}

/// | |u|² - |Pu|² - |u - Pu|² |/|u|², |PPu - Pu|/|u| and |P grad s|/|grad s| for random u and s.
fn identities<const D: usize>(
    cells: [usize; D],
    sides: Sides<FlowWall<D>, D>,
    mask: Option<&Mask<D>>,
) -> Measured<[f64; 3]> {
    let grid = Grid::new(cells, 0.3)?;
    let layout = grid.layout();
    let mut random = Random(7);
    let mut p = Projection::<f64, D>::new(&grid, &sides, mask, Precision::Full)?;
    let mut project = |u: &mut FaceField<f64, D>| p.project(u, &mut CellField::new(layout), 1.0, 1e-13).map(drop);
    let square = |u: &FaceField<f64, D>| kinetic_energy(&grid, &sides, u);
    let mut start = random_faces::<f64, D>(layout, 1.0, &mut random);
    // Held faces belong to no unknown.
    let held = Projection::<f64, D>::new(&grid, &sides, mask, Precision::Full)?;
    held.impose(&mut start);
    let mut once = start.clone();
    project(&mut once)?;
    let mut twice = once.clone();
    project(&mut twice)?;
    let size = square(&start);
    let pythagoras = (size - square(&once) - square(&less(&start, &once))).abs() / size;
    let again = (square(&less(&twice, &once)) / size).sqrt();
    let mut s = CellField::<f64>::new(layout);
    layout.each_cell(layout.cells_region(), |at| s[at.slot()] = random.unit());
    (0..D).filter(|&a| sides.is_periodic(a)).for_each(|a| layout.wrap_rim(a, &mut s));
    let mut slope = FaceField::new(layout);
    held.subtract_gradient(-1.0, &s, &mut slope);
    let steep = square(&slope);
    project(&mut slope)?;
    Ok([pythagoras, again, (square(&slope) / steep).sqrt()])
}

/// max|u| after ten steps of a force that a pressure balances: gravity on a column of layers \[m/s\]. Alone it would give 1 m/s.
fn layers(scheme: Scheme) -> Measured {
    let grid = Grid::<2>::new([12, 16], 0.1)?;
    let mut phi = CellField::<f64>::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| (at.cell[1] as f64 * 0.7).sin());
    let buoyancy = Some(Buoyancy { strength: 3.0, reference: 0.2, up: [0.0, 1.0] });
    let settings = FlowSettings { scheme, eta_div: 1e-9, force: [0.0, -9.81], buoyancy, ..FlowSettings::default() };
    let mut fluid = Fluid::new(&grid, &Sides::all(FlowWall::Closed), None, settings)?;
    for _ in 0..10 {
        fluid.begin(0.01, Some(&phi), &mut ())?;
        fluid.finish(Some(&phi), &mut ())?;
    }
    Ok(fluid.max_speed())
}

/// Largest change of a uniform stream through an open box in four steps, relative.
fn stream(scheme: Scheme) -> Measured {
    let grid = Grid::<3>::new([12, 9, 10], 0.1)?;
    let u = [0.4, 0.0, 0.0];
    let mut sides = Sides::all(FlowWall::Open(u));
    sides.0[0] = Axis::Walls([FlowWall::Inflow(u), FlowWall::Open(u)]);
    let settings = FlowSettings { scheme, eta_div: 1e-6, ..FlowSettings::default() };
    let mut fluid = Fluid::<f64, 3>::new(&grid, &sides, None, settings)?;
    let mut start = FaceField::new(grid.layout());
    start.axis_mut(0).fill(u[0]);
    fluid.set_velocity(&start)?;
    for dt in [0.1, 0.2, 0.2, 0.05] {
        fluid.step(dt)?;
    }
    let mut most = 0f64;
    for a in 0..3 {
        grid.layout().each_cell(grid.layout().faces_region(a, false), |at| {
            most = most.max((fluid.velocity().axis(a)[at.slot()] - u[a]).abs() / u[0]);
        });
    }
    Ok(most)
}

/// The identities on boxes, around obstacles and in pockets, and two flows that must not change.
pub fn projector() -> Table {
    let mut rows = Vec::new();
    let mut say = |parameters: String, found: Measured<[f64; 3]>| {
        let names = ["|u|² = |Pu|² + |u - Pu|²", "P P u = P u", "P grad s = 0"];
        let found = found.map_err(|why| why.to_string());
        for (i, name) in names.into_iter().enumerate() {
            let one = found.as_ref().map(|all| all[i]).map_err(|why| why.clone().into());
            rows.push(Row::at_most(name, parameters.clone(), ROUNDING, one));
        }
    };
    let half = |open: bool| {
        let mut sides = Sides::all(FlowWall::Closed);
        sides.0[0] = Axis::Periodic;
        sides.0[1] = Axis::Walls([FlowWall::Closed, if open { FlowWall::OPEN } else { FlowWall::Closed }]);
        sides
    };
    say("16x12 closed".into(), identities([16, 12], Sides::all(FlowWall::Closed), None));
    say("7x9 periodic, closed, open".into(), identities([7, 9], half(true), None));
    say("8x6x5 open".into(), identities([8, 6, 5], Sides::<FlowWall<3>, 3>::all(FlowWall::OPEN), None));
    say("1x4 closed".into(), identities([1, 4], Sides::all(FlowWall::Closed), None));
    // A ring of solid with a pocket inside, a closed cell, a bar.
    let ring = |c: [usize; 2]| {
        let r = c[0].abs_diff(6).max(c[1].abs_diff(6));
        r != 3 && c != [13, 3] && c != [13, 1] && c != [12, 2] && c != [14, 2]
    };
    let pockets = Grid::<2>::new([16, 14], 0.3).map(|grid| Mask::new(grid.layout(), ring));
    match pockets {
        Ok(mask) => say("16x14 with pockets, closed".into(), identities([16, 14], half(false), Some(&mask))),
        Err(why) => say("16x14 with pockets, closed".into(), Err(why.into())),
    }
    let cave = |c: [usize; 3]| {
        let r = c[0].abs_diff(4).max(c[1].abs_diff(4)).max(c[2].abs_diff(4));
        r != 1 && !(c[0] == 8 && c[1] < 5)
    };
    let mut half_open = Sides::all(FlowWall::Closed);
    half_open.0[2] = Axis::Walls([FlowWall::Closed, FlowWall::OPEN]);
    let found = Grid::<3>::new([10, 9, 9], 0.3).map(|grid| Mask::new(grid.layout(), cave));
    say(
        "10x9x9 with a cave, closed, open".into(),
        found.map_err(Into::into).and_then(|mask| identities([10, 9, 9], half_open, Some(&mask))),
    );
    for scheme in [Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft, Scheme::CentralRk4] {
        rows.push(Row::at_most("layers at rest, max|u|", format!("{scheme:?}, 10 steps"), 2e-7, layers(scheme)));
        rows.push(Row::at_most("a uniform stream changes by", format!("{scheme:?}, 4 steps"), 1e-12, stream(scheme)));
    }
    Table { title: "the projection, and what it must not move", rows }
}
