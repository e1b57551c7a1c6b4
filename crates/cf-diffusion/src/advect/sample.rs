//! A field between its values: tensor Lagrange interpolation over `K` points per axis, held within the range of the
//! enclosing values (K = 4 cubic, K = 2 linear).

use cf_grid::{End, Real};
use nalgebra::SVector;

use super::sites::Sites;
use super::trace::floor;

/// Indices and weights along one axis.
#[derive(Debug, Clone, Copy)]
struct Nodes<T, const K: usize> {
    index: [usize; K],
    weight: [T; K],
    /// Place of the lower of the two enclosing indices.
    enclosing: usize,
}

/// The value of `field` at the foot of `cell` moved by `displacement` \[cells\].
///
/// A foot behind a wall that lets the medium in takes what it carries (of several, at the wall crossed first); between the
/// outermost value and the wall the sample goes over to it linearly. Feet do not cross closed walls: they stop at the
/// outermost value. A foot whose points touch a solid takes the linear weights of the fluid corners around it, or the
/// value of `cell` where there is none.
#[inline(always)]
pub(super) fn at_foot<T: Real, const D: usize, const K: usize>(
    sites: &Sites<D>,
    fluid: Option<&[bool]>,
    field: &[T],
    cell: [usize; D],
    displacement: SVector<f64, D>,
) -> T {
    let mut nodes = [Nodes { index: [0; K], weight: [T::ZERO; K], enclosing: 0 }; D];
    let mut blend = [(T::ZERO, T::ZERO); D];
    let mut carried_in: Option<(f64, T)> = None;
    for a in 0..D {
        if sites.edges.is_periodic(a) {
            let (i, t) = floor(displacement[a]);
            nodes[a] = periodic(cell[a] as i64 + i, sites.layout.cells()[a], t);
            continue;
        }
        let (first, last) = sites.span(a);
        let x = cell[a] as f64 + displacement[a];
        if x >= first as f64 && x <= last as f64 {
            nodes[a] = walled(x, first, last);
            continue;
        }
        for (end, excess) in [(End::Low, first as f64 - x), (End::High, x - last as f64)] {
            let Some(edge) = sites.edges.wall(a, end).filter(|_| excess > 0.0) else { continue };
            let Some(carried) = edge.carried else { continue };
            if excess > edge.reach {
                let inside = displacement[a].abs() - (excess - edge.reach);
                let when = inside / displacement[a].abs();
                if carried_in.is_none_or(|(first, _)| when < first) {
                    carried_in = Some((when, T::of(carried)));
                }
            } else {
                blend[a] = (T::of(excess / edge.reach), T::of(carried));
            }
        }
        nodes[a] = walled(x.clamp(first as f64, last as f64), first, last);
    }
    if let Some((_, carried)) = carried_in {
        return carried;
    }
    let blocked = |fluid: &&[bool]| !all_fluid(sites, &nodes, fluid);
    let mut value = match fluid.filter(blocked) {
        Some(fluid) => among_fluid(sites, &nodes, fluid, field).unwrap_or(field[sites.layout.slot(cell)]),
        None => clamped(sites, &nodes, field),
    };
    let total = blend.iter().fold(T::ZERO, |sum, b| sum + b.0);
    if total > T::ZERO {
        // Over several walls at once: written so that equal values give that value to the bit.
        let keep = blend.iter().fold(T::ONE, |product, b| product * (T::ONE - b.0));
        let mean = blend.iter().fold(T::ZERO, |sum, b| sum + b.0 / total * (b.1 - value));
        value += (T::ONE - keep) * mean;
    }
    value
}

#[inline(always)]
fn periodic<T: Real, const K: usize>(below: i64, n: usize, t: f64) -> Nodes<T, K> {
    let enclosing = K / 2 - 1;
    let first = below - enclosing as i64;
    let index = if first >= 0 && first <= n as i64 - K as i64 {
        std::array::from_fn(|k| first as usize + k)
    } else {
        std::array::from_fn(|k| (first + k as i64).rem_euclid(n as i64) as usize)
    };
    Nodes { index, weight: weights(t + enclosing as f64), enclosing }
}

/// Near walls the points move inwards; where there are fewer than K the sample is linear.
#[inline(always)]
fn walled<T: Real, const K: usize>(x: f64, first: usize, last: usize) -> Nodes<T, K> {
    let below = (x as i64 as usize).min(last.saturating_sub(1)).max(first);
    if last - first + 1 < K {
        let t = x - below as f64;
        let weight = std::array::from_fn(|k| {
            T::of(if k == 0 {
                1.0 - t
            } else if k == 1 {
                t
            } else {
                0.0
            })
        });
        return Nodes { index: std::array::from_fn(|k| (below + k).min(last)), weight, enclosing: 0 };
    }
    let start = (below + 1).saturating_sub(K / 2).clamp(first, last + 1 - K);
    Nodes { index: std::array::from_fn(|k| start + k), weight: weights(x - start as f64), enclosing: below - start }
}

/// Lagrange weights of the points 0, 1, …, K−1 at `t`.
#[inline(always)]
fn weights<T: Real, const K: usize>(t: f64) -> [T; K] {
    let mut w = [T::ZERO; K];
    if K == 2 {
        (w[0], w[1]) = (T::of(1.0 - t), T::of(t));
    } else {
        let (a, b, c) = (t - 1.0, t - 2.0, t - 3.0);
        w[0] = T::of(a * b * c * (-1.0 / 6.0));
        w[1] = T::of(t * b * c * 0.5);
        w[2] = T::of(t * a * c * -0.5);
        w[3] = T::of(t * a * b * (1.0 / 6.0));
    }
    w
}

/// Calls `f(row slot of x index 0, y place, z place)` for the K (or K²) rows of points.
#[inline(always)]
fn rows<T, const D: usize, const K: usize>(
    sites: &Sites<D>,
    nodes: &[Nodes<T, K>; D],
    mut f: impl FnMut(usize, usize, usize),
) {
    let mut cell = [0; D];
    let planes = if D == 3 { K } else { 1 };
    for z in 0..planes {
        if D == 3 {
            cell[2] = nodes[2].index[z];
        }
        for y in 0..K {
            cell[1] = nodes[1].index[y];
            f(sites.layout.slot(cell), y, z);
        }
    }
}

#[inline(always)]
fn clamped<T: Real, const D: usize, const K: usize>(sites: &Sites<D>, nodes: &[Nodes<T, K>; D], field: &[T]) -> T {
    let x = &nodes[0];
    let contiguous = x.index[K - 1] == x.index[0] + K - 1;
    // The clamp starts from a corner of the enclosing cell.
    let corner = field[sites.layout.slot(std::array::from_fn(|a| nodes[a].index[nodes[a].enclosing]))];
    let (mut sum, mut low, mut high) = (T::ZERO, corner, corner);
    rows(sites, nodes, |slot, y, z| {
        let mut v = [T::ZERO; K];
        if contiguous {
            v.copy_from_slice(&field[slot + x.index[0]..][..K]);
        } else {
            v = x.index.map(|i| field[slot + i]);
        }
        let mut line = T::ZERO;
        for k in 0..K {
            line += x.weight[k] * v[k];
        }
        let mut w = nodes[1].weight[y];
        let mut near = y == nodes[1].enclosing || y == nodes[1].enclosing + 1;
        if D == 3 {
            w *= nodes[2].weight[z];
            near &= z == nodes[2].enclosing || z == nodes[2].enclosing + 1;
        }
        sum += w * line;
        if near {
            let (a, b) = (v[x.enclosing], v[x.enclosing + 1]);
            low = low.min(a).min(b);
            high = high.max(a).max(b);
        }
    });
    sum.max(low).min(high)
}

fn all_fluid<T, const D: usize, const K: usize>(sites: &Sites<D>, nodes: &[Nodes<T, K>; D], fluid: &[bool]) -> bool {
    let mut all = true;
    rows(sites, nodes, |slot, _, _| all &= nodes[0].index.iter().all(|&i| fluid[slot + i]));
    all
}

/// Linear weights over the fluid corners of the enclosing cell.
fn among_fluid<T: Real, const D: usize, const K: usize>(
    sites: &Sites<D>,
    nodes: &[Nodes<T, K>; D],
    fluid: &[bool],
    field: &[T],
) -> Option<T> {
    let (mut sum, mut total) = (0.0, 0.0);
    let mut bounds: Option<(T, T)> = None;
    for corner in 0..1 << D {
        let place = |a: usize| nodes[a].enclosing + (corner >> a & 1);
        let slot = sites.layout.slot(std::array::from_fn(|a| nodes[a].index[place(a)]));
        if fluid[slot] {
            let value = field[slot];
            let w: f64 = (0..D).map(|a| linear(&nodes[a], corner >> a & 1)).product();
            (sum, total) = (sum + w * value.f64(), total + w);
            let (low, high) = bounds.unwrap_or((value, value));
            bounds = Some((low.min(value), high.max(value)));
        }
    }
    let (low, high) = bounds.filter(|_| total > 1e-6)?;
    Some(T::of(sum / total).max(low).min(high))
}

/// Linear weight of the lower (0) or upper (1) enclosing point: the fraction is the mean place Σ k w_k of the weights.
fn linear<T: Real, const K: usize>(nodes: &Nodes<T, K>, upper: usize) -> f64 {
    let place: f64 = (0..K).map(|k| k as f64 * nodes.weight[k].f64()).sum();
    let t = (place - nodes.enclosing as f64).clamp(0.0, 1.0);
    if upper == 1 { t } else { 1.0 - t }
}
