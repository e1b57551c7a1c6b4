//! What several tests share.

use cf_fluid::{FlowWall, Projection};
use cf_grid::{Axis, FaceField, Grid, Layout, Mask, Real, Sides};
use cf_linear::Precision;

/// Reproducible numbers in [-1, 1).
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

pub fn random_faces<T: Real, const D: usize>(layout: &Layout<D>, seed: u64) -> FaceField<T, D> {
    let (mut u, mut noise) = (FaceField::new(layout), Noise::new(seed));
    for a in 0..D {
        u.axis_mut(a).iter_mut().for_each(|v| *v = T::of(noise.next()));
    }
    u
}

pub fn projection<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<FlowWall<D>, D>,
    mask: Option<&Mask<D>>,
) -> Projection<T, D> {
    Projection::new(grid, sides, mask, Precision::Full).unwrap()
}

/// All mixes of walls worth a look.
pub fn wall_mixes<const D: usize>() -> Vec<Sides<FlowWall<D>, D>> {
    let open = FlowWall::OPEN;
    let mut mixes = vec![Sides::periodic(), Sides::all(FlowWall::Closed), Sides::all(open)];
    let mut channel = Sides::all(FlowWall::Closed);
    let mut stream = [0.0; D];
    stream[0] = 0.7;
    channel.0[0] = Axis::Walls([FlowWall::Inflow(stream), open]);
    channel.0[1] = Axis::Periodic;
    mixes.push(channel);
    let mut half = Sides::all(FlowWall::Closed);
    half.0[D - 1] = Axis::Walls([FlowWall::Closed, open]);
    half.0[0] = Axis::Periodic;
    mixes.push(half);
    mixes
}

/// Inner products over the faces that exist, without counting walls twice.
pub fn dot<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<FlowWall<D>, D>,
    u: &FaceField<T, D>,
    v: &FaceField<T, D>,
) -> f64 {
    let mut sum = 0.0;
    for a in 0..D {
        grid.layout().each_cell(grid.layout().faces_region(a, sides.is_periodic(a)), |at| {
            // An open wall face belongs to half a cell.
            let wall = !sides.is_periodic(a) && (at.cell[a] == 0 || at.cell[a] == grid.cells()[a]);
            let w = if wall { 0.5 } else { 1.0 };
            sum += w * u.axis(a)[at.slot()].f64() * v.axis(a)[at.slot()].f64();
        });
    }
    sum
}
