//! The waves of an axis: how fast each moves, and what it meets beyond the walls (paper eqs 19 to 24).
//!
//! Along the axis, w+ = phi + q/c moves at u + c and w- = phi - q/c at u - c. At a wall with outward normal n the one
//! that comes in follows from the one that leaves, and so do the values beyond it,
//!
//! ```text
//! w_in = add + mirror w_out      flux g       q·n = g                 mirror  1               add -2 g/c
//!                                value v      phi = v                 mirror -1               add 2 v
//!                                absorbing s  q·n = s (phi - far)     mirror (c - s)/(c + s)  add (1 - mirror) far
//!                                open         what comes in is calm   mirror  0               add inflow
//! ```
//!
//! with w_out at the mirror image of the place. Where nothing leaves (u·n <= -c) both waves carry phi = v, far or
//! inflow, q = 0; where nothing comes in, nothing is needed. Components of q along the wall move at u, and come in as
//! 0.

use cf_grid::{Axis, End, Real, Sides, Wall};

/// Values beyond one end for one wave: add + mirror (the other wave at the mirror image) + own (this wave in the wall
/// cell).
#[derive(Debug, Clone, Copy)]
pub(super) struct Beyond<T> {
    pub add: T,
    pub mirror: T,
    pub own: T,
    /// Slope weight of the value that comes in: that of the wave it mirrors, so that both meet at the wall at one time.
    pub weight: T,
}

/// One wave of an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wave<T> {
    /// speed dt/h, signed.
    pub nu: T,
    /// (1 - |nu|)/4; 0 on an axis of one cell, which has no slopes.
    pub weight: T,
    /// Beyond the low and the high end.
    pub beyond: [Beyond<T>; 2],
}

/// An axis over one sub-step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Its ends.
    pub axis: Axis<Wall>,
    /// Velocity of the medium along it \[m/s\].
    pub u: f64,
    /// dt/h \[s/m\].
    pub ratio: f64,
    /// Cells along it.
    pub cells: usize,
}

/// Velocities closer to the sound speed than this, relative, are the sound speed: the slow wave stands still.
const CRITICAL: f64 = 4.0 * f64::EPSILON;

impl Line {
    pub fn new<const D: usize>(sides: &Sides<Wall, D>, axis: usize, u: f64, ratio: f64, cells: usize) -> Self {
        Self { axis: sides.0[axis], u, ratio, cells }
    }

    /// w+ and w-.
    pub fn sound<T: Real>(&self, c: f64) -> [Wave<T>; 2] {
        let speeds = [1.0, -1.0].map(|sign| {
            let speed = self.u + sign * c;
            if speed.abs() <= CRITICAL * c { 0.0 } else { speed }
        });
        [(speeds[0], speeds[1]), (speeds[1], speeds[0])].map(|(speed, other)| {
            self.wave(speed, |wall, sign| {
                let (mirror, add) = reflection(wall, c);
                let carried = wall.carried_in().unwrap_or(0.0);
                let (enters, other_leaves) = (speed * sign < 0.0, other * sign > 0.0);
                let (leaves, other_enters) = (speed * sign > 0.0, other * sign < 0.0);
                let weight = if mirror == 0.0 { self.weight(speed) } else { self.weight(other) };
                match (enters, other_leaves) {
                    (true, true) => [add, mirror, 0.0, weight],
                    (true, false) => [carried, 0.0, 0.0, self.weight(speed)],
                    // The inverse of a full reflection continues the leaving wave, slope and all.
                    _ if mirror.abs() == 1.0 && leaves && other_enters => [-mirror * add, mirror, 0.0, 0.0],
                    _ => [0.0, 0.0, 1.0, 0.0],
                }
            })
        })
    }

    /// A quantity carried along at u.
    pub fn carried<T: Real>(&self) -> [Wave<T>; 1] {
        let weight = self.weight(self.u);
        let beyond = |sign: f64| if self.u * sign < 0.0 { [0.0, 0.0, 0.0, weight] } else { [0.0, 0.0, 1.0, 0.0] };
        [self.wave(self.u, |_, sign| beyond(sign))]
    }

    fn wave<T: Real>(&self, speed: f64, beyond: impl Fn(Wall, f64) -> [f64; 4]) -> Wave<T> {
        let at = |wall, end: End| {
            let [add, mirror, own, weight] = beyond(wall, end.sign()).map(T::of);
            Beyond { add, mirror, own, weight }
        };
        let nothing = Beyond { add: T::ZERO, mirror: T::ZERO, own: T::ONE, weight: T::ZERO };
        let beyond = match self.axis {
            Axis::Periodic => [nothing; 2],
            Axis::Walls([low, high]) => [at(low, End::Low), at(high, End::High)],
        };
        Wave { nu: T::of(speed * self.ratio), weight: T::of(self.weight(speed)), beyond }
    }

    fn weight(&self, speed: f64) -> f64 {
        if self.cells == 1 { 0.0 } else { 0.25 * (1.0 - (speed * self.ratio).abs()) }
    }
}

/// mirror and add of a wall for sound of speed `c`.
fn reflection(wall: Wall, c: f64) -> (f64, f64) {
    match wall {
        Wall::Flux(g) => (1.0, -2.0 * g / c),
        Wall::Value(v) => (-1.0, 2.0 * v),
        Wall::Absorbing { speed, far } => {
            let mirror = (c - speed) / (c + speed);
            (mirror, (1.0 - mirror) * far)
        }
        Wall::Open { inflow } => (0.0, inflow),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beyond(wall: Wall, u: f64) -> [[f64; 3]; 4] {
        let line = Line { axis: Axis::Walls([wall; 2]), u, ratio: 0.25, cells: 9 };
        let [plus, minus] = line.sound::<f64>(1.0);
        let of = |b: Beyond<f64>| [b.add, b.mirror, b.own];
        [of(plus.beyond[0]), of(plus.beyond[1]), of(minus.beyond[0]), of(minus.beyond[1])]
    }

    #[test]
    fn what_comes_in_follows_from_what_leaves() {
        let own = [0.0, 0.0, 1.0];
        assert_eq!(beyond(Wall::CLOSED, 0.0), [[0.0, 1.0, 0.0]; 4]);
        // q = 3 leaves either end: w+ - w- = -6 at the low wall, +6 at the high one.
        assert_eq!(beyond(Wall::Flux(3.0), 0.0).map(|b| b[0]), [-6.0, 6.0, 6.0, -6.0]);
        assert_eq!(beyond(Wall::Value(2.0), 0.5), [[4.0, -1.0, 0.0]; 4]);
        let calm = Wall::Absorbing { speed: 1.0, far: 7.0 };
        assert_eq!(beyond(calm, 0.0), [[7.0, 0.0, 0.0], own, own, [7.0, 0.0, 0.0]]);
        assert_eq!(beyond(Wall::Absorbing { speed: 0.0, far: 7.0 }, 0.0), [[0.0, 1.0, 0.0]; 4]);
        assert_eq!(beyond(Wall::Open { inflow: 7.0 }, 0.0), beyond(calm, 0.0));
        // Faster than sound: both waves come in at the low end, both leave at the high end.
        assert_eq!(beyond(Wall::Value(2.0), 1.5), [[2.0, 0.0, 0.0], own, [2.0, 0.0, 0.0], own]);
        // At the speed of sound the slow wave stands still.
        assert_eq!(beyond(Wall::Value(2.0), 1.0), [[2.0, 0.0, 0.0], own, own, own]);
        let line = Line { axis: Axis::Periodic, u: 0.3, ratio: 1.0, cells: 4 };
        assert_eq!(line.sound::<f64>(0.1 * 3.0)[1].nu, 0.0);
    }
}
