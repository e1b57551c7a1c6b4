//! Dimension splitting: which sweep reads and writes what.

use std::ops::Range;

use cf_grid::{Layout, Max, Real, Region, Run};

use super::flow::Stream;
use super::sites::{CHUNK, Chunk, Sites, unit};
use super::sweep::{Dilatation, Start, Sweep, divergence, divergent};

/// Whether sums or bounds come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// φ_t + div(u φ) = 0. The dilatation term takes the start-of-step φ in every sweep; the last one takes all of it
    /// back. Without divergence that is its own share, so that constants stay constant; with one it is still conservative.
    Conservative,
    /// q_t + u·grad q = 0, each sweep by itself ([`Dilatation::Along`]): a sweep makes no new extrema, none needs more than
    /// it reads, and u may diverge.
    Advective,
}

/// Carries `field` through sweeps along `axes` (in this order) over one sub-step. Returns what left through the walls, in
/// units of a cell's content.
pub(super) fn step<T: Real, const D: usize>(
    sites: &Sites<D>,
    stream: Stream<'_, T, D>,
    (form, divergent): (Form, Option<&[bool]>),
    axes: &[usize],
    field: &mut [T],
    (work, second): (&mut [T], &mut [T]),
) -> f64 {
    let varying = axes.iter().any(|&a| stream.uniform(a).is_none());
    let divergent = divergent.filter(|_| form == Form::Conservative);
    let sweep = |axis| Sweep { sites, stream, axis, dilatation: Dilatation::Absent, divergent };
    let keep = form == Form::Conservative && varying;
    // What every sweep but the last of several in flux form has.
    let own = match form {
        _ if !varying => Dilatation::Absent,
        Form::Conservative => Dilatation::Own(Start::Read),
        Form::Advective => Dilatation::Along,
    };
    let with = |axis, dilatation| Sweep { dilatation, ..sweep(axis) };
    let leaves = |axis, now: &[T]| match form {
        Form::Conservative => sweep(axis).outflow(now),
        Form::Advective => 0.0,
    };
    let mut out = 0.0;
    match *axes {
        // One sweep: nothing to split. Flux form is conservative, u·grad takes its own dilatation.
        [axis] => {
            let whole = if form == Form::Advective { own } else { Dilatation::Absent };
            out += leaves(axis, field);
            if axis == 0 {
                with(axis, whole).run(None, field);
            } else {
                with(axis, whole).run(Some(field), work);
                copy(&sites.layout, sites.region, work, field);
            }
        }
        [a, b] => {
            out += leaves(a, field);
            with(a, own).run(Some(field), work);
            out += leaves(b, work);
            let last = if keep { Dilatation::Undo(&axes[..1], Start::Written) } else { own };
            with(b, last).run(Some(work), field);
        }
        [a, b, c] if keep => {
            out += leaves(a, field);
            with(a, own).run(Some(field), work);
            out += leaves(b, work);
            let start = Dilatation::Own(Start::Field(field));
            Sweep { sites, stream, axis: b, dilatation: start, divergent }.run(Some(work), second);
            out += leaves(c, second);
            with(c, Dilatation::Undo(&axes[..2], Start::Written)).run(Some(second), field);
        }
        // x in place, so that the other two end where they began.
        [_, _, _] => {
            let mut held = false;
            for &axis in axes {
                let sweep = with(axis, own);
                let now: &[T] = if held { work } else { field };
                out += leaves(axis, now);
                match (axis, held) {
                    (0, false) => sweep.run(None, field),
                    (0, true) => sweep.run(None, work),
                    (_, false) => sweep.run(Some(field), work),
                    (_, true) => sweep.run(Some(work), field),
                }
                held ^= axis != 0;
            }
        }
        _ => {}
    }
    out
}

/// Flags the cells that are [`divergent`] in a sub-step along the axes that move, and their neighbours, through which they
/// would still see slopes; `None` if there is none.
pub(super) fn divergent_cells<'f, T: Real, const D: usize>(
    sites: &Sites<D>,
    stream: &Stream<'_, T, D>,
    moving: [bool; D],
    [own, flags]: &'f mut [Vec<bool>; 2],
) -> Option<&'f [bool]> {
    let (mut axes, mut count) = ([0; D], 0);
    for axis in (0..D).filter(|&a| moving[a]) {
        axes[count] = axis;
        count += 1;
    }
    let axes = &axes[..count];
    if axes.iter().all(|&a| stream.uniform(a).is_some()) {
        return None;
    }
    let layout = &sites.layout;
    let net_of = |run: &Run<'_, D>, range: &Range<usize>| {
        let mut net = [T::ZERO; CHUNK];
        divergence(sites, stream, axes, Chunk::of(run, range), &mut net[..range.len()]);
        net
    };
    let largest: Max = layout.par_runs(sites.region, (), |run, ()| {
        let net = |range| net_of(&run, &range).into_iter().fold(0.0, |m: f64, net| m.max(net.f64().abs()));
        Max(Chunk::<D>::ranges(run.len()).map(net).fold(0.0, f64::max))
    });
    if !divergent(largest.0) {
        return None;
    }
    own.resize(layout.slots(), false);
    flags.resize(layout.slots(), false);
    layout.par_runs(sites.region, &mut own[..], |run, flags: &mut [bool]| {
        for range in Chunk::<D>::ranges(run.len()) {
            let net = net_of(&run, &range);
            for (flag, net) in flags[range].iter_mut().zip(net) {
                *flag = divergent(net.f64());
            }
        }
    });
    layout.par_cells(&mut flags[..], |at| {
        let cell = std::array::from_fn(|a| at.cell[a]);
        let beside = |axis| [-1, 1].into_iter().any(|by| own[sites.slot(cell, unit(axis, by))]);
        own[at.slot()] || axes.iter().any(|&axis| beside(axis))
    });
    Some(flags)
}

/// Copies the values of a region.
pub(super) fn copy<T: Real, const D: usize>(layout: &Layout<D>, region: Region<D>, from: &[T], to: &mut [T]) {
    layout.par_runs(region, to, |run, row: &mut [T]| row.copy_from_slice(run.row(from)));
}
