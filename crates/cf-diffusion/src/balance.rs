//! The mass of long runs in single precision.
//!
//! A cell rounds what it gains in a step. Near a steady state it rounds the same way every time, and the sum drifts by up
//! to half a unit in the last place per cell and step: 2e-5 of ∫|phi| after 6e4 steps, where 1e-6 is promised. So what the
//! cells gained is compared, in `f64`, with what the source and the walls report, and what rounding took is given back to
//! cells here and there, to none more than rounding may have taken from it. Cells that hold nothing are left alone:
//! nothing outruns a wave. What stays open is less than a unit in the last place of one cell, and zero in the mean.
//!
//! Two reads of phi per step in single precision; `f64` has digits to spare and pays nothing.

use cf_grid::{Layout, Real};

use crate::source::Source;
use crate::sweeps::part_sums;
use crate::walls::Walls;

/// Whether sums of `T` need a balance.
pub(crate) fn drifts<T: Real>() -> bool {
    T::EPSILON > 1e-10
}

/// What the fluid should hold \[sum of phi\]: first all parts together that a wall can reach, as the report counts them;
/// then, where there are several parts, every sealed one by itself.
#[derive(Debug, Clone, Default)]
pub(crate) struct Balance {
    due: Vec<f64>,
}

impl Balance {
    /// Counts what is there before `source` acts for `dt` \[s\].
    pub fn open<T: Real, const D: usize>(&mut self, walls: &Walls<T, D>, phi: &[T], source: Source<'_, T>, dt: f64) {
        if !drifts::<T>() {
            return;
        }
        self.due.clear();
        self.add(walls, phi, 1.0);
        if let (Some(rate), 2..) = (source.rate, self.due.len()) {
            let rest = self.due[0];
            let before: f64 = self.due[1..].iter().sum();
            self.add_parts(walls, |slot| rate.at(slot), source.share * dt);
            // The report counts all of the source: the rest does not get what sealed parts get.
            self.due[0] = rest - (self.due[1..].iter().sum::<f64>() - before);
        }
    }

    /// Gives back what rounding took from `phi`, after the walls and the source let in `gained` \[sum of phi\].
    pub fn settle<T: Real, const D: usize>(&mut self, walls: &Walls<T, D>, phi: &mut [T], gained: f64) {
        if !drifts::<T>() || self.due.is_empty() {
            return;
        }
        self.due[0] += gained;
        self.add(walls, phi, -1.0);
        let parts = walls.parts();
        match &parts.components {
            None => give_back(&walls.layout, phi, &mut self.due, |_| Some(0)),
            Some(components) => {
                let several = self.due.len() > 1;
                let pot = |slot: usize| {
                    let part = components.label[slot].checked_sub(1)? as usize;
                    Some(if several && parts.sealed[part] { 1 + part } else { 0 })
                };
                give_back(&walls.layout, phi, &mut self.due, pot);
            }
        }
    }

    /// due += weight Σ x, pot by pot.
    fn add<T: Real, const D: usize>(&mut self, walls: &Walls<T, D>, x: &[T], weight: f64) {
        let (layout, parts) = (walls.layout, walls.parts());
        if parts.sealed.len() < 2 || !parts.sealed.contains(&true) {
            let sum = match &walls.mask {
                None => layout.sum(x),
                Some(mask) => layout.par_runs(layout.cells_region(), (), |run, ()| {
                    let wet = run.row(x).iter().zip(run.row(mask.fluid())).filter(|&(_, &fluid)| fluid);
                    wet.map(|(v, _)| v.f64()).sum::<f64>()
                }),
            };
            self.due.resize(1, 0.0);
            self.due[0] += weight * sum;
            return;
        }
        self.due.resize(1 + parts.sealed.len(), 0.0);
        self.add_parts(walls, |slot| x[slot], weight);
    }

    /// The same where there are pots of sealed parts.
    fn add_parts<T: Real, const D: usize>(&mut self, walls: &Walls<T, D>, x: impl Fn(usize) -> T + Sync, weight: f64) {
        let parts = walls.parts();
        for (part, sum) in part_sums(walls, parts, |slot| x(slot).f64()).into_iter().enumerate() {
            self.due[if parts.sealed[part] { 1 + part } else { 0 }] += weight * sum;
        }
    }
}

/// Visits the cells, twice at most, in an order that jumps about and differs from step to step, and moves each towards what its pot
/// is due by at most ε |phi|. What is left when cells in a row are too coarse for it moves the next one by a whole unit or
/// not at all, by a chance that makes it right in the mean: it does not add up, and nothing has to be remembered.
pub(crate) fn give_back<T: Real, const D: usize>(
    layout: &Layout<D>,
    phi: &mut [T],
    due: &mut [f64],
    pot: impl Fn(usize) -> Option<usize>,
) {
    const PATIENCE: usize = 8;
    let open = |due: f64| due != 0.0 && due.is_finite();
    let mut left = due.iter().filter(|&&d| open(d)).count();
    let mut misses = PATIENCE * left;
    let cells = layout.count();
    let stride = if left > 0 { stride(cells) } else { return };
    let mut chance = due.iter().fold(0, |chance, &d| mix(chance, d));
    let mut index = (chance >> 11) as usize % cells;
    for visit in 0..2 * cells {
        index = (index + stride) % cells;
        let slot = slot_of(layout, index);
        let Some(due) = pot(slot).map(|pot| &mut due[pot]).filter(|due| open(**due)) else { continue };
        let (old, again) = (phi[slot].f64(), visit >= cells);
        if old == 0.0 {
            continue;
        }
        let unit = T::EPSILON * old.abs();
        // What all cells together cannot take in units of their own comes from larger numbers on the way: one takes it.
        let most = if again { due.abs() } else { unit };
        phi[slot] = T::of(old + due.clamp(-most, most));
        *due -= phi[slot].f64() - old;
        if phi[slot].f64() == old {
            chance = mix(chance, old);
            if misses == 0 || again {
                let next = T::of(old + (0.75 * unit).copysign(*due));
                if due.abs() > (next.f64() - old).abs() * fraction(chance) {
                    phi[slot] = next;
                }
                *due = 0.0;
            }
            misses = misses.saturating_sub(1);
        }
        if *due == 0.0 {
            left -= 1;
            if left == 0 {
                return;
            }
        }
    }
}

/// A number of the digits seen so far and those of `x`; its power of two does not count, so that a state times one is
/// treated alike.
fn mix(seen: u64, x: f64) -> u64 {
    let digits = x.to_bits() & ((1 << 52) - 1);
    let mixed = (seen ^ digits).wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed ^ (mixed >> 29)).wrapping_mul(0x94d0_49bb_1331_11eb)
}

/// In [0, 1).
fn fraction(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

/// About the golden section of the cells, and without a common factor: neighbours in order are far apart, none is left out.
fn stride(cells: usize) -> usize {
    let common = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let golden = (cells as f64 * 0.618_033_988_749_895) as usize;
    (golden.max(1)..=cells).find(|&s| common(s, cells) == 1).unwrap_or(1)
}

fn slot_of<const D: usize>(layout: &Layout<D>, mut index: usize) -> usize {
    let cells = layout.cells();
    layout.slot(std::array::from_fn(|a| {
        let i = index % cells[a];
        index /= cells[a];
        i
    }))
}
