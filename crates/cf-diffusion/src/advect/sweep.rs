//! One sweep of flux-form MUSCL along one axis (paper eqs 11 and 12).

use cf_grid::{End, Real, Run, vectorised};

use super::flow::Stream;
use super::kernel::{Window, flux_form, flux_form_window, flux_form_with, uniform_five, uniform_window};
use super::sites::{CHUNK, Chunk, Sites, unit};

/// Which φ the dilatation term multiplies.
#[derive(Debug, Clone, Copy)]
pub(super) enum Start<'f, T> {
    /// What the sweep reads.
    Read,
    /// What lies where the sweep writes.
    Written,
    /// Another field.
    Field(&'f [T]),
}

/// The dilatation term of a sweep.
#[derive(Debug, Clone, Copy)]
pub(super) enum Dilatation<'f, T> {
    /// None: pure flux form.
    Absent,
    /// + (ν_R − ν_L) φ of this axis.
    Own(Start<'f, T>),
    /// q_t + u q_x = 0 to second order by itself: (ν_R − ν_L) q of what the sweep reads is added, and the whole change is
    /// taken 1 + (ν_R − ν_L)/2 times. For the fluxes hold (u² q_x)_x Δt²/2, one u u_x q_x more than q_tt = u (u q_x)_x.
    Along,
    /// − Σ (ν_R − ν_L) φ of the axes swept before: equal to `Own` where div u = 0, and what keeps the sum of all
    /// sweeps conservative where it is not.
    Undo(&'f [usize], Start<'f, T>),
}

/// A sweep along `axis`.
///
/// Only the kernels are compiled for the machine's vector registers: around them stands too much code to have it three
/// times.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sweep<'s, T, const D: usize> {
    pub sites: &'s Sites<D>,
    pub stream: Stream<'s, T, D>,
    pub axis: usize,
    pub dilatation: Dilatation<'s, T>,
    /// Flags by slot of the cells that are [`divergent`] and of their neighbours, if there are any.
    pub divergent: Option<&'s [bool]>,
}

/// Whether a cell gains or loses so much of its volume in a sub-step, Σ (ν_R − ν_L) over all axes, that slopes and the
/// splitting of the dilatation make no sense there. A cell that empties to both sides may lie on a steep slope between
/// large values of opposite sign: it would emit far more than it holds, a factor per sub-step without bound. Such cells
/// are constant inside and have no dilatation term: first-order flux form, of which Σ|φ| never grows. Leaving out any part
/// of the terms keeps the sum: what one sweep adds another takes back.
pub(super) fn divergent(net: f64) -> bool {
    net.abs() > 1.0 / 16.0
}

/// Σ (ν_R − ν_L) over `axes` for a chunk.
pub(super) fn divergence<T: Real, const D: usize>(
    sites: &Sites<D>,
    stream: &Stream<'_, T, D>,
    axes: &[usize],
    chunk: Chunk<D>,
    net: &mut [T],
) {
    let (mut low, mut high) = ([T::ZERO; CHUNK], [T::ZERO; CHUNK]);
    let (low, high) = (&mut low[..net.len()], &mut high[..net.len()]);
    net.fill(T::ZERO);
    for &axis in axes {
        stream.speeds(sites, axis, chunk, low, high);
        gain(T::ONE, low, high, net);
    }
}

type Row<T> = [T; CHUNK];

impl<T: Real, const D: usize> Sweep<'_, T, D> {
    /// Writes the swept values of `from` to `to`; `None` sweeps in place, which only the x axis can.
    pub fn run(&self, from: Option<&[T]>, to: &mut [T]) {
        let layout = &self.sites.layout;
        layout.par_runs(self.sites.region, to, |run, out: &mut [T]| match (self.axis, from) {
            (0, _) => self.along_x(run, from.map(|f| run.row(f)), out),
            (_, Some(from)) => self.across(run, from, out),
            _ => {}
        });
    }

    /// What left through the walls of the axis in this sweep of `from`, outward positive, in units of a cell's content.
    pub fn outflow(&self, from: &[T]) -> f64 {
        let layout = &self.sites.layout;
        let mut total = 0.0;
        for end in End::BOTH {
            let Some(carried) = self.sites.edges.wall(self.axis, end).and_then(|e| e.carried) else {
                continue;
            };
            let (first, last) = self.sites.span(self.axis);
            let mut layer = self.sites.region;
            (layer.low[self.axis], layer.high[self.axis]) = match end {
                End::Low => (first, first + 1),
                End::High => (last, last + 1),
            };
            let carried = T::of(carried);
            total += end.sign()
                * layout.par_runs(layer, (), |run, ()| {
                    Chunk::<D>::ranges(run.len())
                        .map(|range| {
                            let chunk = Chunk::of(&run, &range);
                            let nu = self.wall_speeds(end, chunk);
                            let row = chunk.row(layout, from);
                            let crossing = |(&nu, &own): (&T, &T)| (nu * upwind(end, nu, own, carried)).f64();
                            nu.iter().zip(row).map(crossing).sum::<f64>()
                        })
                        .sum::<f64>()
                });
        }
        total
    }

    /// ν on the wall side of a chunk at the outermost index.
    fn wall_speeds(&self, end: End, chunk: Chunk<D>) -> Row<T> {
        if let Some(nu) = self.stream.uniform(self.axis) {
            return [nu; CHUNK];
        }
        let (mut low, mut high) = ([T::ZERO; CHUNK], [T::ZERO; CHUNK]);
        let n = chunk.len;
        self.stream.speeds(self.sites, self.axis, chunk, &mut low[..n], &mut high[..n]);
        if end == End::Low { low } else { high }
    }

    /// The values beyond a wall: carried in where the medium flows in, else those inside.
    fn beyond(&self, end: End, chunk: Chunk<D>, inside: &[T]) -> Row<T> {
        let carried = self.sites.edges.wall(self.axis, end).and_then(|e| e.carried).unwrap_or(0.0);
        let mut values = self.wall_speeds(end, chunk);
        for (value, &inside) in values.iter_mut().zip(inside) {
            *value = upwind(end, *value, inside, T::of(carried));
        }
        values
    }

    fn beyond_one(&self, end: End, chunk: Chunk<D>, inside: T) -> T {
        let carried = self.sites.edges.wall(self.axis, end).and_then(|e| e.carried).unwrap_or(0.0);
        let nu = self.stream.uniform(self.axis).unwrap_or_else(|| {
            let (mut low, mut high) = ([T::ZERO], [T::ZERO]);
            self.stream.speeds(self.sites, self.axis, chunk, &mut low, &mut high);
            if end == End::Low { low[0] } else { high[0] }
        });
        upwind(end, nu, inside, T::of(carried))
    }

    /// A row of a sweep along y or z.
    fn across(&self, run: Run<'_, D>, from: &[T], out: &mut [T]) {
        let (axis, sites) = (self.axis, self.sites);
        let (first, last) = sites.span(axis);
        let index = run.cell[axis];
        let wraps = sites.edges.is_periodic(axis);
        let inner = wraps || (index >= first + 2 && index + 2 <= last);
        let place = |k: usize| (index as isize + k as isize - 2).rem_euclid(last as isize + 1) as usize;
        if let (true, Some(nu)) = (inner, self.stream.uniform(axis)) {
            let whole = Chunk { cell: run.cell, len: run.len() };
            let rows = std::array::from_fn(|k| whole.at(axis, place(k)).row(&sites.layout, from));
            return vectorised(
                #[inline(always)]
                || uniform_five(nu, rows, out),
            );
        }
        for range in Chunk::<D>::ranges(run.len()) {
            let chunk = Chunk::of(&run, &range);
            let row = |index: usize| chunk.at(axis, index).row(&sites.layout, from);
            if inner {
                self.chunk(chunk, std::array::from_fn(|k| row(place(k))), None, &mut out[range]);
                continue;
            }
            let below = self.beyond(End::Low, chunk.at(axis, first), row(first));
            let above = self.beyond(End::High, chunk.at(axis, last), row(last));
            let rows = std::array::from_fn(|k| match index + k {
                i if i < first + 2 => &below[..chunk.len],
                i if i > last + 2 => &above[..chunk.len],
                i => row(i - 2),
            });
            self.chunk(chunk, rows, None, &mut out[range]);
        }
    }

    /// A row of a sweep along x; the old values pass through a window, so that `out` may hold them.
    fn along_x(&self, run: Run<'_, D>, from: Option<&[T]>, out: &mut [T]) {
        let n = out.len();
        let old = |out: &[T], i: usize| from.map_or(out[i], |f| f[i]);
        let chunk = Chunk { cell: run.cell, len: n };
        let (before, behind) = if self.sites.edges.is_periodic(0) {
            let at = |i: isize| old(out, i.rem_euclid(n as isize) as usize);
            ([at(-2), at(-1)], [at(n as isize), at(n as isize + 1)])
        } else {
            let low = self.beyond_one(End::Low, chunk.one(0), old(out, 0));
            let high = self.beyond_one(End::High, chunk.one(n - 1), old(out, n - 1));
            ([low; 2], [high; 2])
        };
        let mut window = [T::ZERO; CHUNK + 4];
        window[..2].copy_from_slice(&before);
        for range in Chunk::<D>::ranges(n) {
            let (start, m) = (range.start, range.len());
            let ahead = start..(start + m + 2).min(n);
            let inside = ahead.len();
            window[2..2 + inside].copy_from_slice(&from.unwrap_or(&*out)[ahead]);
            for k in inside..m + 2 {
                window[2 + k] = behind[start + k - n];
            }
            let rows: [&[T]; 5] = std::array::from_fn(|k| &window[k..k + m]);
            match self.stream.uniform(0) {
                Some(nu) => {
                    let out = &mut out[range];
                    vectorised(
                        #[inline(always)]
                        || uniform_window(nu, &window, out),
                    );
                }
                None => self.chunk(Chunk::of(&run, &range), rows, Some(&window), &mut out[range]),
            }
            window.copy_within(m..m + 2, 0);
        }
    }

    /// The general step of a chunk: any velocity, any obstacle. Along x the rows are stretches of one window.
    fn chunk(&self, chunk: Chunk<D>, rows: [&[T]; 5], window: Option<&Window<T>>, out: &mut [T]) {
        let (n, sites) = (chunk.len, self.sites);
        let (mut low, mut high, mut add) = ([T::ZERO; CHUNK], [T::ZERO; CHUNK], [T::ZERO; CHUNK]);
        let (low, high, add) = (&mut low[..n], &mut high[..n], &mut add[..n]);
        let start = match self.dilatation {
            Dilatation::Absent => None,
            Dilatation::Own(_) | Dilatation::Along => {
                self.stream.speeds(sites, self.axis, chunk, low, high);
                gain(T::ONE, low, high, add);
                match self.dilatation {
                    Dilatation::Own(start) => Some(start),
                    _ => Some(Start::Read),
                }
            }
            Dilatation::Undo(axes, start) => {
                for &axis in axes {
                    self.stream.speeds(sites, axis, chunk, low, high);
                    gain(-T::ONE, low, high, add);
                }
                Some(start)
            }
        };
        if let Some(divergent) = self.divergent {
            for (add, &divergent) in add.iter_mut().zip(chunk.row(&sites.layout, divergent)) {
                *add = if divergent { T::ZERO } else { *add };
            }
        }
        if let Some(start) = start {
            let values = match start {
                Start::Read => rows[2],
                Start::Written => &*out,
                Start::Field(field) => chunk.row(&sites.layout, field),
            };
            for (add, &value) in add.iter_mut().zip(values) {
                *add *= value;
            }
        }
        if !matches!(self.dilatation, Dilatation::Own(_) | Dilatation::Along) {
            self.stream.speeds(sites, self.axis, chunk, low, high);
        }
        match (self.stream.fluid, window) {
            (None, Some(window)) if self.divergent.is_none() => {
                vectorised(
                    #[inline(always)]
                    || flux_form_window(window, low, high[n - 1], add, out),
                );
            }
            (None, _) => self.flux_form(chunk, rows, low, high, add, out),
            (Some(fluid), _) => self.chunk_with_solids(fluid, chunk, rows, low, high, add, out),
        }
        if matches!(self.dilatation, Dilatation::Along) {
            let half = T::of(0.5);
            for (((out, &own), &l), &h) in out.iter_mut().zip(rows[2]).zip(&*low).zip(&*high) {
                *out += half * (h - l) * (*out - own);
            }
        }
    }

    /// Flux form, with no slope in divergent cells.
    fn flux_form(&self, chunk: Chunk<D>, rows: [&[T]; 5], low: &[T], high: &[T], add: &[T], out: &mut [T]) {
        let Some(divergent) = self.divergent else {
            return vectorised(
                #[inline(always)]
                || flux_form(rows, low, high, add, out),
            );
        };
        let n = chunk.len;
        let mut steep = [[T::ONE; CHUNK]; 3];
        for (steep, by) in steep.iter_mut().zip(-1..=1) {
            for (i, steep) in steep[..n].iter_mut().enumerate() {
                if divergent[self.sites.slot(chunk.one(i).cell, unit(self.axis, by))] {
                    *steep = T::ZERO;
                }
            }
        }
        flux_form_with(rows, steep.each_ref().map(|row| &row[..n]), low, high, add, out);
    }

    /// Cells do not look into solids: a solid neighbour counts as equal, so that slopes next to it vanish. Faces on a
    /// solid stay at zero.
    #[allow(clippy::too_many_arguments)]
    fn chunk_with_solids(
        &self,
        fluid: &[bool],
        chunk: Chunk<D>,
        rows: [&[T]; 5],
        low: &[T],
        high: &[T],
        add: &[T],
        out: &mut [T],
    ) {
        let n = chunk.len;
        if let Some(normal) = self.sites.normal {
            flux_form(rows, low, high, add, out);
            if self.sites.clear(fluid, chunk, normal) {
                return;
            }
            for i in 0..n {
                if !self.sites.open(fluid, chunk.one(i).cell) {
                    out[i] = T::ZERO;
                }
            }
            return;
        }
        if self.sites.clear(fluid, chunk, self.axis) {
            return self.flux_form(chunk, rows, low, high, add, out);
        }
        let mut near = [[T::ZERO; CHUNK]; 5];
        for i in 0..n {
            let own = rows[2][i];
            let sees = |k: isize| self.sites.sees(fluid, chunk.one(i).cell, self.axis, k);
            let pick = |free: bool, value: T, other: T| if free { value } else { other };
            near[2][i] = own;
            near[1][i] = pick(sees(-1), rows[1][i], own);
            near[3][i] = pick(sees(1), rows[3][i], own);
            near[0][i] = pick(sees(-2), rows[0][i], near[1][i]);
            near[4][i] = pick(sees(2), rows[4][i], near[3][i]);
        }
        self.flux_form(chunk, near.each_ref().map(|row| &row[..n]), low, high, add, out);
    }
}

/// add += sign (ν_R − ν_L)
fn gain<T: Real>(sign: T, low: &[T], high: &[T], add: &mut [T]) {
    for ((add, &l), &h) in add.iter_mut().zip(low).zip(high) {
        *add += sign * (h - l);
    }
}

/// The value that crosses a wall with signed Courant number `nu` along the axis.
#[inline(always)]
fn upwind<T: Real>(end: End, nu: T, inside: T, carried: T) -> T {
    let enters = match end {
        End::Low => nu > T::ZERO,
        End::High => nu < T::ZERO,
    };
    if enters { carried } else { inside }
}
