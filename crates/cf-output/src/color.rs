//! From numbers to colours: maps, ranges, display scalings, light and dark themes.

/// Red, green, blue, 0 to 255.
pub type Rgb = [u8; 3];

/// A colour map. All but [`Grey`](Self::Grey) are read well by colour-blind people and on most screens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ColorMap {
    /// Dark blue to yellow, perceptually even; for quantities without a middle.
    #[default]
    Viridis,
    /// Black to pale yellow, perceptually even; for plumes and fronts.
    Inferno,
    /// Black to pale pink, perceptually even.
    Magma,
    /// Blue to yellow, even also for colour-blind people.
    Cividis,
    /// Black to white.
    Grey,
    /// Blue through white to red; for signed quantities, with [`ColorRange::Symmetric`].
    BlueRed,
    /// Purple through white to green; for signed quantities.
    PurpleGreen,
    /// Black at zero, wherever that is in the range; above it [`Inferno`](Self::Inferno), below it teal to pale ice, equal
    /// sizes about equally bright. For plumes that may dip below zero.
    FireIce,
}

/// What is below zero on [`ColorMap::FireIce`], from zero on.
const ICE: [Rgb; 5] = [[0, 0, 4], [0, 50, 66], [0, 112, 122], [58, 186, 172], [216, 255, 240]];

impl ColorMap {
    /// The colour at `t`, cut to 0..1.
    pub fn at(self, t: f64) -> Rgb {
        let t = t.clamp(0.0, 1.0);
        let color = match self {
            Self::Viridis => colorous::VIRIDIS.eval_continuous(t),
            Self::Inferno => colorous::INFERNO.eval_continuous(t),
            Self::Magma => colorous::MAGMA.eval_continuous(t),
            Self::Cividis => colorous::CIVIDIS.eval_continuous(t),
            Self::Grey => colorous::GREYS.eval_continuous(1.0 - t),
            Self::BlueRed => colorous::RED_BLUE.eval_continuous(1.0 - t),
            Self::PurpleGreen => colorous::PURPLE_GREEN.eval_continuous(t),
            Self::FireIce if t < 0.5 => return between(&ICE, 1.0 - 2.0 * t),
            Self::FireIce => colorous::INFERNO.eval_continuous(2.0 * t - 1.0),
        };
        [color.r, color.g, color.b]
    }

    /// The colour at `t` of a range in which zero is at `zero`: on [`FireIce`](Self::FireIce) the longer side of zero takes
    /// a whole half of the map, and the other as much of its half as it is long.
    pub(crate) fn around(self, t: f64, zero: f64) -> Rgb {
        match self {
            Self::FireIce => self.at(0.5 + 0.5 * (t - zero) / zero.max(1.0 - zero)),
            _ => self.at(t),
        }
    }
}

/// Which values the ends of the colour map stand for. Values beyond an end take its colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ColorRange {
    /// Smallest to largest finite value of the picture.
    #[default]
    Auto,
    /// From, to.
    Fixed(f64, f64),
    /// Minus to plus the largest magnitude, for diverging maps.
    Symmetric,
}

impl ColorRange {
    /// The range for data between `data[0]` and `data[1]`: ordered, finite and not empty, whatever comes in.
    pub fn resolve(self, data: [f64; 2]) -> [f64; 2] {
        let [low, high] = match self {
            Self::Auto => data,
            Self::Fixed(a, b) => [a.min(b), a.max(b)],
            Self::Symmetric => {
                let largest = data[0].abs().max(data[1].abs());
                [-largest, largest]
            }
        };
        widen([low, high])
    }
}

/// Whether data go visibly beyond the low and the high end of a range: by a 256th of it, a step of colour.
pub fn clipped(data: [f64; 2], [low, high]: [f64; 2]) -> [bool; 2] {
    let step = (high - low) / 256.0;
    [data[0] < low - step, data[1] > high + step]
}

/// Makes an interval finite and non-empty without changing one that is.
pub(crate) fn widen([low, high]: [f64; 2]) -> [f64; 2] {
    const LIMIT: f64 = 1e300; // so that differences stay finite
    if !low.is_finite() || !high.is_finite() || low > high {
        return [0.0, 1.0];
    }
    let [low, high] = [low.clamp(-LIMIT, LIMIT), high.clamp(-LIMIT, LIMIT)];
    let least = 1e-12 * low.abs().max(high.abs());
    if high - low > least {
        [low, high]
    } else if low == 0.0 && high == 0.0 {
        [0.0, 1.0]
    } else {
        let middle = 0.5 * low + 0.5 * high;
        [middle - 0.5 * middle.abs(), middle + 0.5 * middle.abs()]
    }
}

/// How values are spread over the map. For display only: the data are not changed and the colour bar shows it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Display {
    /// Evenly.
    #[default]
    Linear,
    /// By the logarithm; values at or below zero take the lowest colour. The lowest value shown is the larger of the
    /// range's and its top times 10⁻ⁿ with the given number of decades.
    Log(u32),
    /// By a power of the position in the range; below 1 lifts small values.
    Gamma(f64),
    /// By a power of the size of the value, its sign kept; below 1 lifts small values on both sides of zero.
    Power(f64),
}

impl Display {
    /// The range actually shown.
    pub(crate) fn range(self, [low, high]: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Log(decades) => {
                let high = if high > 0.0 { high } else { 1.0 };
                let floor = (high * 10_f64.powi(-(decades.clamp(1, 300) as i32))).max(f64::MIN_POSITIVE);
                [low.max(floor).min(0.5 * high), high]
            }
            _ => [low, high],
        }
    }

    /// Position of a value in 0..1 of a range from [`range`](Self::range); NaN stays NaN.
    pub(crate) fn position(self, value: f64, [low, high]: [f64; 2]) -> f64 {
        let even = ((value - low) / (high - low)).clamp(0.0, 1.0);
        match self {
            Self::Linear => even,
            Self::Gamma(gamma) if gamma.is_finite() && gamma > 0.0 => even.powf(gamma),
            Self::Power(power) if power.is_finite() && power > 0.0 => {
                // By the larger end, so that no power overflows.
                let largest = low.abs().max(high.abs());
                let lifted = |v: f64| (v.abs() / largest).powf(power).copysign(v);
                let place = (lifted(value) - lifted(low)) / (lifted(high) - lifted(low));
                // Nothing can be told apart by the smallest powers.
                if place.is_nan() && !value.is_nan() { even } else { place.clamp(0.0, 1.0) }
            }
            Self::Gamma(_) | Self::Power(_) => even,
            Self::Log(_) if value.is_nan() => value,
            Self::Log(_) if value <= low => 0.0,
            Self::Log(_) => ((value / low).ln() / (high / low).ln()).clamp(0.0, 1.0),
        }
    }
}

/// How the values of a range become colours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Palette {
    map: ColorMap,
    display: Display,
    range: [f64; 2],
    zero: f64,
}

impl Palette {
    /// For a range from [`Display::range`].
    pub fn new(map: ColorMap, display: Display, range: [f64; 2]) -> Self {
        Self { map, display, range, zero: display.position(0.0, range) }
    }

    /// The colour of a value that is a number.
    pub fn of(&self, value: f64) -> Rgb {
        self.at(self.display.position(value, self.range))
    }

    /// The colour at a position 0..1 of the range.
    pub fn at(&self, t: f64) -> Rgb {
        self.map.around(t, self.zero)
    }
}

/// Between colours at equal distances, `t` from 0 to 1.
fn between(colors: &[Rgb], t: f64) -> Rgb {
    let place = t.clamp(0.0, 1.0) * (colors.len() - 1) as f64;
    let low = (place as usize).min(colors.len().saturating_sub(2));
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(colors[low][c]), f64::from(colors[low + 1][c]));
        (a + (place - low as f64) * (b - a)).round() as u8
    })
}

/// Colours of everything that is not data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Theme {
    /// Dark on white, for paper.
    #[default]
    Light,
    /// Light on near-black, for slides.
    Dark,
}

impl Theme {
    /// Colour behind everything.
    pub fn background(self) -> Rgb {
        match self {
            Self::Light => [255, 255, 255],
            Self::Dark => [20, 22, 27],
        }
    }

    /// Colour of text and frames.
    pub fn ink(self) -> Rgb {
        match self {
            Self::Light => [32, 36, 42],
            Self::Dark => [222, 225, 230],
        }
    }

    /// Colour of grid lines.
    pub fn faint(self) -> Rgb {
        match self {
            Self::Light => [224, 227, 231],
            Self::Dark => [52, 56, 64],
        }
    }

    /// Colour of solid cells: a grey that no map but [`ColorMap::Grey`] has.
    pub fn solid(self) -> Rgb {
        match self {
            Self::Light => [150, 150, 150],
            Self::Dark => [110, 110, 110],
        }
    }

    /// Colour of cells without a number: on no map.
    pub fn missing(self) -> Rgb {
        [255, 0, 255]
    }
}

/// Eight line colours that colour-blind people can tell apart (after Okabe and Ito).
pub(crate) fn line_color(n: usize, theme: Theme) -> Rgb {
    const COLORS: [Rgb; 7] =
        [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [148, 103, 60]];
    match n % 8 {
        7 => theme.ink(),
        n => COLORS[n],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn maps_have_the_ends_they_promise() {
        let bright = |c: Rgb| c.iter().map(|&v| u32::from(v)).sum::<u32>();
        for map in [ColorMap::Viridis, ColorMap::Inferno, ColorMap::Magma, ColorMap::Cividis, ColorMap::Grey] {
            assert!(bright(map.at(0.0)) < bright(map.at(0.5)) && bright(map.at(0.5)) < bright(map.at(1.0)), "{map:?}");
        }
        let [red, _, blue] = ColorMap::BlueRed.at(1.0);
        assert!(red > blue && bright(ColorMap::BlueRed.at(0.5)) > 700);
    }

    #[test]
    fn the_grey_of_solid_cells_is_on_no_other_map() {
        let maps = [
            ColorMap::Viridis,
            ColorMap::Inferno,
            ColorMap::Magma,
            ColorMap::BlueRed,
            ColorMap::PurpleGreen,
            ColorMap::FireIce,
        ];
        for (theme, map) in [Theme::Light, Theme::Dark].into_iter().flat_map(|theme| maps.map(|map| (theme, map))) {
            let apart = |t: f64| map.at(t).iter().zip(theme.solid()).map(|(a, b)| a.abs_diff(b)).max();
            assert!((0..=1000).all(|n| apart(f64::from(n) / 1000.0) > Some(24)), "{map:?} {theme:?}");
        }
    }

    #[test]
    fn values_below_zero_have_a_hue_of_their_own_and_the_brightness_of_their_size() {
        let bright = |c: Rgb| 0.3 * f64::from(c[0]) + 0.6 * f64::from(c[1]) + 0.1 * f64::from(c[2]);
        for (range, display) in [([-1.0, 4.0], Display::Power(0.5)), ([-4.0, 1.0], Display::Linear)] {
            let palette = Palette::new(ColorMap::FireIce, display, range);
            assert!(bright(palette.of(0.0)) < 4.0);
            for size in [0.5, 0.75, 1.0] {
                let [fire, ice] = [palette.of(size), palette.of(-size)];
                assert!(fire[0] > fire[1] && ice[1] > ice[0] + 8 && ice[2] > ice[0] + 8, "{fire:?} {ice:?}");
                assert!((bright(fire) - bright(ice)).abs() < 40.0, "{size}: {fire:?} {ice:?}");
            }
            let at = |v: f64| bright(palette.of(v));
            let steps = |sign: f64| (0..20).map(move |n| sign * 0.05 * f64::from(n));
            for sign in [1.0, -1.0] {
                assert!(steps(sign).zip(steps(sign).skip(1)).all(|(a, b)| at(b) > at(a)), "{range:?} {sign}");
            }
        }
    }

    #[test]
    fn a_power_keeps_signs_and_lifts_both_sides_alike() {
        let at = |v: f64| Display::Power(0.5).position(v, [-4.0, 4.0]);
        assert!((at(1.0) - 0.75).abs() < 1e-12 && (at(-1.0) - 0.25).abs() < 1e-12 && (at(0.0) - 0.5).abs() < 1e-12);
        let from_zero =
            |v: f64| Display::Power(0.3).position(v, [0.0, 8.0]) - Display::Gamma(0.3).position(v, [0.0, 8.0]);
        assert!([0.0, 0.1, 5.0, 9.0].into_iter().all(|v| from_zero(v).abs() < 1e-12));
    }

    #[test]
    fn a_range_is_clipped_where_data_visibly_go_beyond() {
        assert_eq!(clipped([-0.001, 1.001], [0.0, 1.0]), [false, false]);
        assert_eq!(clipped([-0.01, 1.0], [0.0, 1.0]), [true, false]);
        assert_eq!(clipped([0.5, 2.0], [0.0, 1.0]), [false, true]);
        assert_eq!(clipped([f64::INFINITY, f64::NEG_INFINITY], [0.0, 1.0]), [false, false]);
    }

    #[test]
    fn log_display_starts_at_the_asked_decade() {
        let [low, high] = Display::Log(3).range([0.0, 10.0]);
        assert!((low - 0.01).abs() < 1e-15 && high == 10.0);
        assert!((Display::Log(3).position(0.1, [low, high]) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(Display::Log(3).position(-1.0, [low, high]), 0.0);
        assert!(Display::Log(3).position(f64::NAN, [low, high]).is_nan());
    }

    #[test]
    fn symmetric_ranges_have_zero_in_the_middle() {
        assert_eq!(ColorRange::Symmetric.resolve([-1.0, 3.0]), [-3.0, 3.0]);
        assert_eq!(ColorRange::Fixed(2.0, 1.0).resolve([0.0, 9.0]), [1.0, 2.0]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn every_value_has_a_place(a: f64, b: f64, v: f64, decades: u32, gamma: f64) {
            for range in [ColorRange::Auto, ColorRange::Symmetric, ColorRange::Fixed(b, a)] {
                let resolved = range.resolve([a, b]);
                prop_assert!(resolved[0] < resolved[1], "{:?}", resolved);
                for display in [Display::Linear, Display::Log(decades), Display::Gamma(gamma), Display::Power(gamma)] {
                    let shown = display.range(resolved);
                    prop_assert!(shown[0] < shown[1], "{:?} {:?}", display, shown);
                    let t = display.position(v, shown);
                    prop_assert!(t.is_nan() == v.is_nan() && (v.is_nan() || (0.0..=1.0).contains(&t)), "{} {:?}", t, display);
                }
            }
        }
    }
}
