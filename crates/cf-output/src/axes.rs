//! Axes: linear or logarithmic, with ticks at 1-2-5 steps or decades and labels a person would write.

use crate::color::widen;

/// How an axis is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AxisScale {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios; values at or below zero are not drawn.
    Log,
}

/// A tick: its value on the axis and its label.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tick {
    pub value: f64,
    pub label: String,
}

/// A resolved axis: finite, non-empty range with its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    pub scale: AxisScale,
    pub range: [f64; 2],
    pub ticks: Vec<Tick>,
    /// Power of ten taken out of all labels.
    pub exponent: Option<i32>,
}

impl Axis {
    /// An axis over exactly this range (made valid if need be) with about `count` ticks.
    pub fn new(scale: AxisScale, range: [f64; 2], count: usize) -> Self {
        let range = widen(range);
        match scale {
            AxisScale::Linear => {
                let (ticks, exponent) = linear_ticks(range, count);
                Self { scale, range, ticks, exponent }
            }
            AxisScale::Log => {
                let high = if range[1] > 0.0 { range[1] } else { 1.0 };
                let low = if range[0] > 0.0 { range[0] } else { 1e-3 * high };
                let low = low.max(f64::MIN_POSITIVE).min(0.999 * high);
                Self { scale, range: [low, high], ticks: log_ticks([low, high], count), exponent: None }
            }
        }
    }

    /// Position of a value, 0 at the low end and 1 at the high end; `None` where it has no place.
    pub fn position(&self, value: f64) -> Option<f64> {
        let [low, high] = self.range;
        match self.scale {
            _ if !value.is_finite() => None,
            AxisScale::Linear => Some((value - low) / (high - low)),
            AxisScale::Log if value <= 0.0 => None,
            // Differences of logarithms: the ratio of the ends may overflow.
            AxisScale::Log => Some((value.log10() - low.log10()) / (high.log10() - low.log10())),
        }
    }

    /// The axis label with the common power of ten.
    pub fn title(&self, label: &str) -> String {
        match self.exponent {
            Some(e) => format!("{label} (×{})", power(e)).trim_start().to_string(),
            None => label.to_string(),
        }
    }
}

/// Ten to an integer power, in raised digits.
fn power(exponent: i32) -> String {
    let digits = exponent.to_string();
    let raised = digits.chars().map(|c| match c {
        '-' => '⁻',
        digit => "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize - '0' as usize).unwrap_or(digit),
    });
    "10".chars().chain(raised).collect()
}

fn with_minus(label: String) -> String {
    label.replace('-', "−")
}

/// Smallest step of 1, 2 or 5 times a power of ten that needs at most `count` intervals: mantissa and exponent.
fn step([low, high]: [f64; 2], count: usize) -> Option<(f64, i32)> {
    let raw = (high - low) / count.max(1) as f64;
    if !raw.is_normal() {
        return None;
    }
    let exponent = raw.log10().floor() as i32;
    let rest = raw / 10_f64.powi(exponent);
    // A hair of tolerance keeps exact steps exact.
    let pick = [1.0, 2.0, 5.0].into_iter().find(|&m| rest <= m * (1.0 + 1e-9));
    Some(pick.map_or((1.0, exponent + 1), |m| (m, exponent)))
}

fn linear_ticks(range: [f64; 2], count: usize) -> (Vec<Tick>, Option<i32>) {
    let ends = || range.map(|value| Tick { value, label: with_minus(format!("{value:.3e}")) }).to_vec();
    let Some((mantissa, exponent)) = step(range, count) else { return (ends(), None) };
    let size = mantissa * 10_f64.powi(exponent);
    let first = (range[0] / size - 1e-9).ceil();
    let last = (range[1] / size + 1e-9).floor();
    if !size.is_normal() || (last - first).is_nan() || last - first > 100.0 {
        return (ends(), None);
    }
    let largest = range[0].abs().max(range[1].abs()).log10().floor() as i32;
    let common = (!(-3..5).contains(&largest)).then_some(largest);
    let decimals = (common.unwrap_or(0) - exponent).clamp(0, 12) as usize;
    let mut ticks = vec![];
    for n in 0..=(last - first).max(-1.0) as i64 {
        let value = (first + n as f64) * size;
        // Adding zero turns -0 into 0.
        let shown = match common {
            Some(e) => (first + n as f64) * mantissa * 10_f64.powi(exponent - e) + 0.0,
            None => value + 0.0,
        };
        ticks.push(Tick { value, label: with_minus(format!("{shown:.decimals$}")) });
    }
    (ticks, common)
}

/// The finest of three divisions of the decades that has room for its labels.
fn log_ticks(range: [f64; 2], count: usize) -> Vec<Tick> {
    let nines: Vec<f64> = (1..10).map(f64::from).collect();
    let divisions: [&[f64]; 3] = [&nines, &[1.0, 2.0, 5.0], &[1.0]];
    let tries = divisions.into_iter().map(|within| decade_ticks(range, count, within));
    let ticks = tries.into_iter().find(|t| t.len() <= count.max(2) + 1).unwrap_or_default();
    if ticks.len() >= 2 {
        return ticks;
    }
    range.map(|value| Tick { value, label: with_minus(format!("{value:.3e}")) }).to_vec()
}

fn decade_ticks([low, high]: [f64; 2], count: usize, within: &[f64]) -> Vec<Tick> {
    let (first, last) = ((low.log10() - 1e-9).ceil() as i32, (high.log10() + 1e-9).floor() as i32);
    let plain = first >= -3 && last <= 4;
    let every = if within.len() > 1 { 1 } else { (last - first).max(0) / count.max(1) as i32 + 1 };
    let mut ticks = vec![];
    for e in (first - 1..=last).filter(|e| (e - first) % every == 0) {
        for m in within {
            let value = m * 10_f64.powi(e);
            if value < low * (1.0 - 1e-9) || value > high * (1.0 + 1e-9) {
                continue;
            }
            let label = match (plain, *m == 1.0) {
                (true, _) => format!("{value:.*}", (-e).max(0) as usize),
                (false, true) => power(e),
                (false, false) => format!("{m}·{}", power(e)),
            };
            ticks.push(Tick { value, label });
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|t| t.label.as_str()).collect()
    }

    #[test]
    fn linear_labels_are_what_a_person_would_write() {
        let axis = |a, b| Axis::new(AxisScale::Linear, [a, b], 5);
        assert_eq!(labels(&axis(0.0, 1.0)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&axis(-1.0, 1.0)), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(labels(&axis(0.0, 256.0)), ["0", "100", "200"]);
        let small = axis(0.0, 3e-5);
        assert_eq!((labels(&small), small.title("φ")), (vec!["0", "1", "2", "3"], "φ (×10⁻⁵)".to_string()));
        assert_eq!(axis(0.0, 2.5e7).title(""), "(×10⁷)");
    }

    #[test]
    fn log_labels_are_decades_or_plain_numbers() {
        let axis = |a, b| Axis::new(AxisScale::Log, [a, b], 6);
        assert_eq!(labels(&axis(1e-8, 1e-5)), ["10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵"]);
        assert_eq!(labels(&axis(0.01, 10.0)), ["0.01", "0.1", "1", "10"]);
        assert_eq!(labels(&axis(16.0, 200.0)), ["20", "50", "100", "200"]);
        assert!(axis(1e-300, 1e300).ticks.len() <= 7);
        assert_eq!(axis(0.0, 10.0).range, [0.01, 10.0]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_range_gives_a_usable_axis(a: f64, b: f64, count in 0_usize..12, v: f64) {
            for scale in [AxisScale::Linear, AxisScale::Log] {
                let axis = Axis::new(scale, [a, b], count);
                prop_assert!(axis.range[0] < axis.range[1]);
                prop_assert!(axis.ticks.len() <= 101);
                for tick in &axis.ticks {
                    let at = axis.position(tick.value);
                    prop_assert!(at.is_some_and(|p| (-0.01..=1.01).contains(&p)), "{:?} {:?}", tick, axis.range);
                }
                axis.position(v);
            }
        }

        #[test]
        fn ordinary_ranges_have_two_to_eleven_ticks(low in -1000_i32..1000, size in 1_i32..1000, e in -9_i32..9) {
            let scale = 10_f64.powi(e);
            let range = [f64::from(low) * scale, f64::from(low + size) * scale];
            let axis = Axis::new(AxisScale::Linear, range, 6);
            prop_assert!((2..=7).contains(&axis.ticks.len()), "{:?}", axis);
        }
    }
}
