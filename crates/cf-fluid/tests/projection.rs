//! Projector identities.

use cf_fluid::{FlowWall, Shape, net_outflow, obstacles};
use cf_grid::{Axis, CellField, FaceField, Grid, Mask, Sides};

use crate::common::{Noise, dot, projection, random_faces, wall_mixes};

fn minus<const D: usize>(u: &FaceField<f64, D>, v: &FaceField<f64, D>) -> FaceField<f64, D> {
    let mut w = u.clone();
    for a in 0..D {
        w.axis_mut(a).iter_mut().zip(v.axis(a)).for_each(|(w, v)| *w -= v);
    }
    w
}

fn identities<const D: usize>(cells: [usize; D], mask: Option<&dyn Fn([usize; D]) -> bool>) {
    let grid = Grid::new(cells, 0.3).unwrap();
    let layout = grid.layout();
    for sides in wall_mixes::<D>() {
        let mask = mask.map(|fluid| Mask::new(layout, fluid));
        let mut p = projection::<f64, D>(&grid, &sides, mask.as_ref());
        let mut start = random_faces::<f64, D>(layout, 7);
        p.impose(&mut start);
        let (mut u, mut s) = (start.clone(), CellField::new(layout));
        let done = p.project(&mut u, &mut s, 1.0, 1e-13).unwrap();
        // Inflow of a pocket that has no exit cannot balance; all else does.
        if done.imbalance == 0.0 {
            assert!(p.divergence(&mut u) < 1e-12, "{sides:?}");
        }
        // |u*|² = |Pu*|² + |u* - Pu*|², against the divergence-free field with zero held faces.
        let gradient = minus(&start, &u);
        let mut free = u.clone();
        let still = sides.map(|_, _, w| if let FlowWall::Open(_) = w { w } else { FlowWall::Closed });
        projection::<f64, D>(&grid, &still, mask.as_ref())
            .project(&mut free, &mut CellField::new(layout), 1.0, 1e-13)
            .unwrap();
        let size = dot(&grid, &sides, &start, &start).max(1e-300);
        let angle = dot(&grid, &sides, &gradient, &free) / size;
        assert!(angle.abs() < 1e-13, "{angle:e} {sides:?}");
        // P P u = P u.
        let mut again = u.clone();
        p.project(&mut again, &mut CellField::new(layout), 1.0, 1e-13).unwrap();
        let change = minus(&again, &u);
        assert!(dot(&grid, &sides, &change, &change).sqrt() < 1e-12, "{sides:?}");
        // P grad s = 0.
        let mut noise = Noise::new(3);
        let mut t = CellField::<f64>::new(layout);
        layout.each_cell(layout.cells_region(), |at| t[at.slot()] = noise.next());
        (0..D).filter(|&a| sides.is_periodic(a)).for_each(|a| layout.wrap_rim(a, &mut t));
        let mut q = projection::<f64, D>(&grid, &still, mask.as_ref());
        let mut slope = FaceField::new(layout);
        q.subtract_gradient(-1.0, &t, &mut slope);
        q.project(&mut slope, &mut CellField::new(layout), 1.0, 1e-13).unwrap();
        assert!(dot(&grid, &still, &slope, &slope).sqrt() < 1e-12, "{sides:?}");
    }
}

#[test]
fn the_projection_is_orthogonal_on_boxes() {
    identities([16, 12], None);
    identities([7, 9], None);
    identities([8, 6, 5], None);
    identities([1, 4], None);
    identities([1, 1], None);
}

#[test]
fn the_projection_is_orthogonal_around_obstacles_and_in_pockets() {
    // A ring of solid with a pocket inside, a closed single cell, a bar.
    let ring = |c: [usize; 2]| {
        let r = c[0].abs_diff(6).max(c[1].abs_diff(6));
        r != 3 && c != [13, 3] && c != [13, 1] && c != [12, 2] && c != [14, 2]
    };
    identities([16, 14], Some(&ring));
    let cave = |c: [usize; 3]| {
        let r = c[0].abs_diff(4).max(c[1].abs_diff(4)).max(c[2].abs_diff(4));
        r != 1 && !(c[0] == 8 && c[1] < 5)
    };
    identities([10, 9, 9], Some(&cave));
}

#[test]
fn closed_faces_hold_for_any_tolerance_and_what_enters_leaves() {
    let grid = Grid::<3>::new([24, 12, 12], 0.1).unwrap();
    let ball = Shape::Sphere { center: [0.8, 0.6, 0.6], radius: 0.3 };
    let mask = obstacles(&grid, &[ball]).unwrap();
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0, 0.0]), FlowWall::Open([1.0, 0.0, 0.0])]);
    for eta in [1e-1, 1e-6] {
        let mut p = projection::<f64, 3>(&grid, &sides, Some(&mask));
        let mut u = random_faces(grid.layout(), 5);
        let (dt, layout) = (0.1, grid.layout());
        let done = p.project(&mut u, &mut CellField::new(layout), dt, eta).unwrap();
        assert!(done.divergence <= eta && p.divergence(&mut u) * dt <= eta);
        assert!(done.divergence > 1e-3 * eta, "stopped late: {done:?}");
        for a in 0..3 {
            layout.each_cell(layout.cells_region(), |at| {
                let fluid = mask.fluid();
                if at.cell[a] > 0 && !(fluid[at.slot()] && fluid[at.low(a)]) {
                    assert_eq!(u.axis(a)[at.slot()], 0.0);
                }
            });
        }
        let volume = 1.44 * 2.4;
        assert!(net_outflow(&grid, &sides, &u).abs() * dt <= eta * volume);
    }
}

#[test]
fn what_does_not_balance_is_reported() {
    let grid = Grid::<2>::new([8, 8], 0.5).unwrap();
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([2.0, 0.0]), FlowWall::Closed]);
    let mut p = projection::<f64, 2>(&grid, &sides, None);
    let mut u = FaceField::new(grid.layout());
    let done = p.project(&mut u, &mut CellField::new(grid.layout()), 0.1, 1e-6).unwrap();
    // 2 m/s through 4 m into 16 m².
    assert!((done.imbalance - 0.5).abs() < 1e-12, "{done:?}");
    assert!(done.divergence <= 1e-6);
}

#[test]
fn numbers_that_are_not_finite_are_located() {
    let grid = Grid::<2>::new([8, 8], 0.5).unwrap();
    let mut p = projection::<f32, 2>(&grid, &Sides::periodic(), None);
    let mut u = FaceField::new(grid.layout());
    u.axis_mut(1)[grid.layout().slot([3, 4])] = f32::NAN;
    let error = p.project(&mut u, &mut CellField::new(grid.layout()), 0.1, 1e-4).unwrap_err();
    assert!(error.to_string().contains("axis 1") && error.to_string().contains("[3, 4]"), "{error}");
}

#[test]
fn what_is_left_in_a_balanced_part_is_told_beside_an_imbalance() {
    let grid = Grid::<2>::new([17, 12], 0.1).unwrap();
    // The cell in the corner takes in what cannot leave, and has nothing else to solve for; the rest is closed.
    let mut sides = Sides::all(FlowWall::Closed);
    sides.0[0] = Axis::Walls([FlowWall::Inflow([1.0, 0.0]), FlowWall::Closed]);
    let mask = Mask::new(grid.layout(), |cell| cell == [0, 0] || cell[0] > 1);
    let mut projection = projection::<f64, 2>(&grid, &sides, Some(&mask));
    let mut u = FaceField::new(grid.layout());
    for a in 0..2 {
        u.axis_mut(a).iter_mut().enumerate().for_each(|(slot, u)| *u = ((slot * 7919 + a) % 101) as f64 / 101.0);
    }
    let (dt, eta) = (0.1, 1e-2);
    let done = projection.project(&mut u, &mut CellField::new(grid.layout()), dt, eta).unwrap();
    let mut left = 0f64;
    grid.layout().each_cell(grid.layout().cells_region(), |at| {
        if at.cell[0] > 1 {
            let out: f64 = (0..2).map(|a| u.axis(a)[at.high(a)] - u.axis(a)[at.slot()]).sum();
            left = left.max(out.abs() * dt / grid.h());
        }
    });
    assert!(done.imbalance > 1.0 && left > 1e-6 * eta && left <= eta, "{done:?}, left {left}");
    assert!(done.divergence >= 0.99 * left && done.divergence <= eta, "{done:?}, left {left}");
}
