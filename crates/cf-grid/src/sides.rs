//! What happens on the surface of the box.

/// The low or the high end of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Towards smaller coordinates.
    Low,
    /// Towards larger coordinates.
    High,
}

impl End {
    /// Both ends, low first.
    pub const BOTH: [End; 2] = [End::Low, End::High];

    /// Sign of the outward normal: -1 or +1.
    pub fn sign(self) -> f64 {
        match self {
            End::Low => -1.0,
            End::High => 1.0,
        }
    }
}

/// An axis either closes on itself or ends in two walls, low and high.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Axis<W> {
    /// The last cell's high neighbour is the first cell.
    Periodic,
    /// Low wall, high wall.
    Walls([W; 2]),
}

/// One entry per axis. Half-periodic axes cannot be written down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sides<W, const D: usize>(pub [Axis<W>; D]);

impl<W: Copy, const D: usize> Sides<W, D> {
    /// The same wall on every side.
    pub fn all(wall: W) -> Self {
        Self([Axis::Walls([wall; 2]); D])
    }

    /// Periodic along every axis.
    pub fn periodic() -> Self {
        Self([Axis::Periodic; D])
    }

    /// Whether an axis is periodic.
    pub fn is_periodic(&self, axis: usize) -> bool {
        matches!(self.0[axis], Axis::Periodic)
    }

    /// The wall at an end of an axis; `None` on periodic axes.
    pub fn wall(&self, axis: usize, end: End) -> Option<W> {
        match self.0[axis] {
            Axis::Periodic => None,
            Axis::Walls([low, high]) => Some(if end == End::Low { low } else { high }),
        }
    }

    /// The same sides with every wall replaced.
    pub fn map<V>(&self, mut f: impl FnMut(usize, End, W) -> V) -> Sides<V, D> {
        let mut axis = 0;
        Sides(self.0.map(|a| {
            let mapped = match a {
                Axis::Periodic => Axis::Periodic,
                Axis::Walls([l, h]) => Axis::Walls([f(axis, End::Low, l), f(axis, End::High, h)]),
            };
            axis += 1;
            mapped
        }))
    }

    /// Every wall with its place.
    pub fn walls(&self) -> impl Iterator<Item = (usize, End, W)> + '_ {
        (0..D).flat_map(move |a| End::BOTH.into_iter().filter_map(move |e| self.wall(a, e).map(|w| (a, e, w))))
    }
}

/// Physical wall of a transported and diffusing quantity phi \[P\]. Fluxes are positive outwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wall {
    /// Prescribed total flux g·n \[P m/s\]; `Flux(0.0)` is a closed wall. The medium must not cross it.
    Flux(f64),
    /// Prescribed value phi_b \[P\] on the wall face. A medium flowing in carries it.
    Value(f64),
    /// Lets waves leave: diffusive flux q·n = speed (phi - far). A medium flowing in carries `far`. phi is that of the
    /// outermost cell, half a cell inside: first order in the spacing, measured by `verify`.
    Absorbing {
        /// Wave speed c \[m/s\].
        speed: f64,
        /// Value at rest outside \[P\].
        far: f64,
    },
    /// No diffusive flux; the medium flows out freely and carries `inflow` \[P\] where it flows in. First order in the
    /// spacing where the medium passes, second at rest.
    Open {
        /// Value carried in \[P\].
        inflow: f64,
    },
}

impl Wall {
    /// Nothing passes.
    pub const CLOSED: Wall = Wall::Flux(0.0);

    /// The value a medium carries in through this wall \[P\]; `None` where it must not cross.
    pub fn carried_in(self) -> Option<f64> {
        match self {
            Wall::Flux(_) => None,
            Wall::Value(v) => Some(v),
            Wall::Absorbing { far, .. } => Some(far),
            Wall::Open { inflow } => Some(inflow),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_are_listed_with_their_place() {
        let sides: Sides<Wall, 2> = Sides([Axis::Periodic, Axis::Walls([Wall::CLOSED, Wall::Value(2.0)])]);
        let listed: Vec<_> = sides.walls().collect();
        assert_eq!(listed, [(1, End::Low, Wall::CLOSED), (1, End::High, Wall::Value(2.0))]);
        assert!(sides.is_periodic(0) && sides.wall(0, End::High).is_none());
        let signs = sides.map(|_, end, _| end.sign());
        assert_eq!(signs.0[1], Axis::Walls([-1.0, 1.0]));
    }
}
