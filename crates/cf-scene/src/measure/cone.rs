//! The angle of a wake: in each row across the flow the place of the largest value on either side, to a fraction of a
//! cell by a parabola; then a line through these places.

use super::sample::Sample;

/// The fewest rows that make a line.
const FEWEST: usize = 4;

/// A measured half angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angle {
    /// The mean over the sides.
    pub degrees: f64,
    pub least: f64,
    pub most: f64,
    pub sides: usize,
}

/// The half angle of the ridges behind `source` in a flow along the unit vector `flow`, over rows from `rows.0` to
/// `rows.1` \[m\] downstream.
pub(super) fn half_angle(sample: &Sample, flow: &[f64], source: &[f64], rows: (f64, f64)) -> Result<Angle, String> {
    let mut angles = Vec::new();
    for across in laterals(flow) {
        angles.push(one_side(sample, flow, &across, source, rows)?.to_degrees());
    }
    let (least, most) = angles.iter().fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), v| (a.min(*v), b.max(*v)));
    let degrees = angles.iter().sum::<f64>() / angles.len() as f64;
    if degrees.is_finite() { Ok(Angle { degrees, least, most, sides: angles.len() }) } else { Err("no angle".into()) }
}

/// The unit vectors across the flow, both ways: two in a plane, four in space.
fn laterals(flow: &[f64]) -> Vec<Vec<f64>> {
    let negative = |v: &[f64]| v.iter().map(|x| -x).collect::<Vec<_>>();
    if let [u, v] = *flow {
        let across = vec![-v, u];
        return vec![negative(&across), across];
    }
    // Off the axis along which the flow is weakest.
    let axis = (0..flow.len()).fold(0, |best, a| if flow[a].abs() < flow[best].abs() { a } else { best });
    let mut first: Vec<f64> = (0..flow.len()).map(|a| f64::from(u8::from(a == axis)) - flow[axis] * flow[a]).collect();
    let length = first.iter().map(|x| x * x).sum::<f64>().sqrt();
    first.iter_mut().for_each(|x| *x /= length);
    let second: Vec<f64> =
        (0..3).map(|a| flow[(a + 1) % 3] * first[(a + 2) % 3] - flow[(a + 2) % 3] * first[(a + 1) % 3]).collect();
    vec![negative(&first), first, negative(&second), second]
}

/// Distances from `from` along `direction` at which samples lie: at centres where the direction is an axis.
fn first_distance(sample: &Sample, direction: &[f64], from: &[f64]) -> f64 {
    let along = (0..direction.len()).find(|a| direction[*a].abs() > 1.0 - 1e-9);
    along.map_or(0.5, |axis| {
        let place = (from[axis] - sample.origin[axis]) / sample.h - 0.5;
        let ahead = if direction[axis] > 0.0 { place.ceil() - place } else { place - place.floor() };
        if ahead < 1e-9 { 1.0 } else { ahead }
    }) * sample.h
}

fn one_side(sample: &Sample, flow: &[f64], across: &[f64], source: &[f64], rows: (f64, f64)) -> Result<f64, String> {
    let (first_row, first) = (first_distance(sample, flow, source), first_distance(sample, across, source));
    let (mut places, mut asked) = (Vec::new(), 0usize);
    // No row lies further away than the box is long.
    let longest = sample.h * sample.cells.iter().map(|n| (*n as f64).powi(2)).sum::<f64>().sqrt();
    for row in 0.. {
        let down = first_row + row as f64 * sample.h;
        if down > rows.1.min(longest) {
            break;
        }
        if down < rows.0 {
            continue;
        }
        asked += 1;
        let value = |j: usize| {
            let side = first + j as f64 * sample.h;
            let point: Vec<f64> = (0..source.len()).map(|a| source[a] + down * flow[a] + side * across[a]).collect();
            sample.at(&point)
        };
        let line: Vec<f64> = (0..).map_while(value).collect();
        places.extend(peak(&line).map(|place| (down, first + place * sample.h)));
    }
    if places.len() < FEWEST || 2 * places.len() < asked {
        return Err(format!("only {} of {asked} rows have a ridge beside the axis", places.len()));
    }
    Ok(slope(&places).atan())
}

/// The place of the largest value, in samples; `None` where it is the first or the last, which is no ridge.
fn peak(line: &[f64]) -> Option<f64> {
    let most = (0..line.len()).max_by(|a, b| line[*a].total_cmp(&line[*b]))?;
    if most == 0 || most + 1 >= line.len() {
        return None;
    }
    let (low, middle, high) = (line[most - 1], line[most], line[most + 1]);
    let bend = low - 2.0 * middle + high;
    Some(most as f64 + if bend < 0.0 { 0.5 * (low - high) / bend } else { 0.0 })
}

/// The slope of the line of least squares.
pub(super) fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = points.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let (xy, xx) = points
        .iter()
        .fold((0.0, 0.0), |sum, (x, y)| (sum.0 + (x - mean.0) * (y - mean.1), sum.1 + (x - mean.0) * (x - mean.0)));
    xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ridges of width `w` at an angle behind a source.
    fn wake(cells: Vec<usize>, source: &[f64], flow: &[f64], degrees: f64) -> Sample {
        let h = 4.0 / cells[0] as f64;
        let mut sample = Sample { origin: vec![0.0; cells.len()], phi: vec![0.0; cells.iter().product()], cells, h };
        let tan = degrees.to_radians().tan();
        for i in 0..sample.phi.len() {
            let x = sample.centre_of(i);
            let d: Vec<f64> = source.iter().enumerate().map(|(a, s)| x[a] - s).collect();
            let down: f64 = d.iter().zip(flow).map(|(d, u)| d * u).sum();
            let side = (d.iter().map(|d| d * d).sum::<f64>() - down * down).max(0.0).sqrt();
            sample.phi[i] = if down > 0.0 { (-((side - down * tan) / 0.08).powi(2)).exp() } else { 0.0 };
        }
        sample
    }

    #[test]
    fn ridges_along_any_axis_have_their_angle() {
        for (flow, source) in [([0.0, 1.0], [2.0, 1.0]), ([0.0, -1.0], [2.0, 3.0]), ([1.0, 0.0], [1.0, 2.0])] {
            for degrees in [30.0, 45.0, 58.0] {
                let sample = wake(vec![128, 128], &source, &flow, degrees);
                let angle = half_angle(&sample, &flow, &source, (0.3, 1.0)).unwrap();
                assert!((angle.degrees - degrees).abs() < 0.2 && angle.sides == 2, "{flow:?} {degrees}: {angle:?}");
            }
        }
    }

    #[test]
    fn a_slanted_flow_and_space_work_too() {
        let flow = [0.8, 0.6];
        let angle =
            half_angle(&wake(vec![160, 160], &[1.5, 1.5], &flow, 30.0), &flow, &[1.5, 1.5], (0.3, 1.0)).unwrap();
        assert!((angle.degrees - 30.0).abs() < 0.5, "{angle:?}");
        let (flow, source) = ([0.0, 0.0, 1.0], [2.0, 2.0, 0.5]);
        let angle = half_angle(&wake(vec![64, 64, 32], &source, &flow, 45.0), &flow, &source, (0.3, 1.0)).unwrap();
        assert!((angle.degrees - 45.0).abs() < 0.5 && angle.sides == 4, "{angle:?}");
    }

    #[test]
    fn a_wake_without_ridges_has_no_angle() {
        let sample = wake(vec![64, 64], &[2.0, 1.0], &[0.0, 1.0], 0.0);
        assert!(half_angle(&sample, &[0.0, 1.0], &[2.0, 1.0], (0.3, 1.0)).unwrap_err().contains("rows"));
        assert!(half_angle(&sample, &[0.0, 1.0], &[2.0, 1.0], (0.3, 0.31)).is_err());
        assert!(half_angle(&sample, &[0.0, 1.0], &[2.0, 1.0], (30.0, 100.0)).is_err());
    }
}
