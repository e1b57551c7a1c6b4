//! The surface of the box as the steps see it.
//!
//! | wall | operator | right-hand side | q_C on the face |
//! |---|---|---|---|
//! | flux g | 0 | - dt g/h | none |
//! | value v | 2 kappa | 2 kappa v | stored, gradient over h/2 |
//! | absorbing c | dt c/h | dt c far/h | none, q·n = c (phi - far) |
//! | open | 0 | 0 | none |

use std::sync::OnceLock;

use cf_grid::{Components, End, FaceField, Layout, Mask, Real, Sides, Wall};

/// One fluid cell on a wall.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WallCell {
    pub axis: usize,
    pub end: End,
    pub wall: Wall,
    /// Slot of the cell.
    pub cell: usize,
    /// Slot of its wall face.
    pub face: usize,
}

/// A fluid cell on absorbing walls, all of its walls together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Absorber {
    /// Slot of the cell.
    pub cell: usize,
    /// Σ c \[m/s\].
    pub speed: f64,
    /// far, weighted by c \[P\].
    pub far: f64,
}

/// The connected parts of the fluid.
#[derive(Debug, Clone)]
pub(crate) struct Parts {
    /// Labels and cell counts; `None` without a mask, when all is one part.
    pub components: Option<Components>,
    /// Per part: whether a wall lets phi pass according to its value, so that no sum is conserved.
    pub held: Vec<bool>,
    /// Per part: whether no wall lets phi or the medium pass.
    pub sealed: Vec<bool>,
}

impl Parts {
    /// The part of a fluid cell.
    pub fn of(&self, slot: usize) -> usize {
        self.components.as_ref().map_or(0, |c| (c.label[slot] as usize).saturating_sub(1))
    }

    /// Cells of a part.
    pub fn cells<const D: usize>(&self, part: usize, layout: &Layout<D>) -> f64 {
        self.components.as_ref().map_or(layout.count(), |c| c.cells[part]) as f64
    }
}

/// The walls of a domain: sides, obstacles, and which faces are open.
#[derive(Debug, Clone)]
pub(crate) struct Walls<T, const D: usize> {
    pub layout: Layout<D>,
    pub sides: Sides<Wall, D>,
    pub mask: Option<Mask<D>>,
    /// 1 on faces between fluid cells, 0 elsewhere; only with a mask.
    pub open: Option<FaceField<T, D>>,
    /// Walls that hold phi at a level or move it by a flux, with the number of their faces.
    pub moving: Vec<(Wall, usize)>,
    /// Cells on absorbing walls, by slot.
    pub absorbers: Vec<Absorber>,
    first_fluid: Option<usize>,
    parts: OnceLock<Parts>,
}

impl<T: Real, const D: usize> Walls<T, D> {
    pub fn new(layout: &Layout<D>, sides: &Sides<Wall, D>, mask: Option<Mask<D>>) -> Self {
        let open = mask.as_ref().map(|mask| {
            let mut open = FaceField::new(layout);
            for a in 0..D {
                let last = layout.cells()[a] - 1;
                layout.par_region(layout.faces_region(a, false), open.axis_mut(a), |at| {
                    let i = at.cell[a];
                    let mut pair = [at.cell; 2];
                    if i > 0 {
                        pair[0][a] = i - 1;
                    } else {
                        pair[0][a] = last;
                    }
                    if i > last {
                        pair[1][a] = 0;
                    }
                    let inner = (i > 0 && i <= last) || sides.is_periodic(a);
                    let wet = pair.map(|c| mask.fluid()[layout.slot(c)]);
                    if inner && wet[0] && wet[1] { T::ONE } else { T::ZERO }
                });
            }
            open
        });
        let mut walls = Self {
            layout: *layout,
            sides: *sides,
            mask,
            open,
            moving: Vec::new(),
            absorbers: Vec::new(),
            first_fluid: None,
            parts: OnceLock::new(),
        };
        walls.first_fluid = walls.first(|_| true).map(|cell| layout.slot(cell));
        let (mut absorbers, mut moving) = (Vec::new(), Vec::<(Wall, usize)>::new());
        walls.each(|w| {
            if !matches!(w.wall, Wall::CLOSED | Wall::Open { .. }) {
                match moving.last_mut() {
                    Some((last, count)) if *last == w.wall => *count += 1,
                    _ => moving.push((w.wall, 1)),
                }
            }
            if let Wall::Absorbing { speed, far } = w.wall {
                absorbers.push(Absorber { cell: w.cell, speed, far });
            }
        });
        absorbers.sort_by_key(|a| a.cell);
        absorbers.retain(|a| a.speed > 0.0);
        absorbers.dedup_by(|next, kept| {
            let same = next.cell == kept.cell;
            if same {
                kept.speed += next.speed;
                // Exact where both are equal.
                kept.far += (next.far - kept.far) * (next.speed / kept.speed);
            }
            same
        });
        (walls.absorbers, walls.moving) = (absorbers, moving);
        walls
    }

    /// Every fluid cell on every wall.
    pub fn each(&self, mut f: impl FnMut(WallCell)) {
        for (axis, end, wall) in self.sides.walls() {
            let mut region = self.layout.cells_region();
            match end {
                End::Low => region.high[axis] = 1,
                End::High => region.low[axis] = self.layout.cells()[axis] - 1,
            }
            self.layout.each_cell(region, |at| {
                if self.mask.as_ref().is_none_or(|m| m.fluid()[at.slot()]) {
                    let face = if end == End::Low { at.slot() } else { at.high(axis) };
                    f(WallCell { axis, end, wall, cell: at.slot(), face });
                }
            });
        }
    }

    /// Fills the rim of a cell field: copies across periodic seams, mirrors at walls.
    pub fn fill_rim(&self, x: &mut [T]) {
        for a in 0..D {
            if self.sides.is_periodic(a) {
                self.layout.wrap_rim(a, x);
            } else {
                self.layout.mirror_rim(a, x);
            }
        }
    }

    /// Copies seam faces to the high rim, where divergences read them.
    pub fn fill_seams(&self, q: &mut FaceField<T, D>) {
        for a in (0..D).filter(|&a| self.sides.is_periodic(a)) {
            self.layout.wrap_rim(a, q.axis_mut(a));
        }
    }

    /// The connected parts of the fluid, found at the first call.
    pub fn parts(&self) -> &Parts {
        self.parts.get_or_init(|| {
            let components = self.mask.as_ref().map(|m| m.components(&self.sides));
            let count = components.as_ref().map_or(1, |c| c.cells.len());
            let (mut held, mut sealed) = (vec![false; count], vec![true; count]);
            let parts = Parts { components, held: Vec::new(), sealed: Vec::new() };
            self.each(|w| {
                let part = parts.of(w.cell);
                held[part] |= matches!(w.wall, Wall::Value(_) | Wall::Absorbing { .. });
                sealed[part] &= w.wall == Wall::CLOSED;
            });
            Parts { held, sealed, ..parts }
        })
    }

    /// The mean of x over the fluid cells, exact for constants; 0 without fluid.
    pub fn fluid_mean(&self, x: &[T]) -> f64 {
        const LANES: usize = 8;
        let Some(base) = self.first_fluid.map(|slot| x[slot].f64()) else { return 0.0 };
        let layout = &self.layout;
        let Some(mask) = &self.mask else {
            let sum: f64 = layout.par_runs(layout.cells_region(), (), |run, ()| {
                let chunks = run.row(x).chunks_exact(LANES);
                let mut lanes = [0.0; LANES];
                for (lane, v) in lanes.iter_mut().zip(chunks.remainder()) {
                    *lane = v.f64() - base;
                }
                for chunk in chunks {
                    for (lane, v) in lanes.iter_mut().zip(chunk) {
                        *lane += v.f64() - base;
                    }
                }
                lanes.iter().sum::<f64>()
            });
            return base + sum / layout.count() as f64;
        };
        let (sum, count): (f64, usize) = layout.par_runs(layout.cells_region(), (), |run, ()| {
            let wet = run.row(x).iter().zip(run.row(mask.fluid())).filter(|&(_, &fluid)| fluid);
            wet.fold((0.0, 0), |(sum, n), (v, _)| (sum + (v.f64() - base), n + 1))
        });
        base + sum / count as f64
    }

    /// The first fluid cell of which something is true.
    /// The first fluid cell whose slot is `found`.
    pub fn first(&self, found: impl Fn(usize) -> bool) -> Option<[usize; D]> {
        let mut first = None;
        self.layout.each_cell(self.layout.cells_region(), |at| {
            let fluid = self.mask.as_ref().is_none_or(|m| m.fluid()[at.slot()]);
            if first.is_none() && fluid && found(at.slot()) {
                first = Some(at.cell);
            }
        });
        first
    }

    /// The first fluid cell in which x is not finite.
    pub fn first_bad(&self, x: &[T]) -> Option<[usize; D]> {
        self.first(|slot| !x[slot].is_finite())
    }
}
