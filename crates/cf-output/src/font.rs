//! A stroke font: letters as short pen movements, so that text is smooth at any size without a font file.
//!
//! Units: baseline 0, capitals 7 high, small letters 5, descenders to -2.2. `M` moves, `L` draws a line, `Q` a
//! quarter of an ellipse whose corner is the first point (any smooth bend, in general).

/// Height of a capital letter in font units.
pub(crate) const CAP: f64 = 7.0;
const GAP: f64 = 1.5;

/// Width of a text whose capitals are `cap` pixels high.
pub(crate) fn width(text: &str, cap: f64) -> f64 {
    let units: f64 = text.chars().map(|c| glyph(c).advance()).sum();
    (units - GAP).max(0.0) * cap / CAP
}

/// The pen strokes of a text starting at (0, 0), y up, with capitals `cap` pixels high.
pub(crate) fn strokes(text: &str, cap: f64) -> Vec<Vec<[f64; 2]>> {
    let scale = cap / CAP;
    let (mut out, mut x) = (vec![], 0.0);
    for c in text.chars() {
        let glyph = glyph(c);
        for stroke in parse(glyph.pen).into_iter().chain(glyph.accent_strokes()) {
            let place = |[u, v]: [f64; 2]| [(x + u * glyph.scale) * scale, (glyph.raise + v * glyph.scale) * scale];
            out.push(stroke.into_iter().map(place).collect());
        }
        x += glyph.advance();
    }
    out
}

struct Glyph {
    width: f64,
    pen: &'static str,
    /// Drawn above the letter: its pen, and how far up.
    accent: Option<(&'static str, f64)>,
    scale: f64,
    raise: f64,
}

impl Glyph {
    fn advance(&self) -> f64 {
        self.width * self.scale + GAP * self.scale.max(0.8)
    }

    fn accent_strokes(&self) -> Vec<Vec<[f64; 2]>> {
        let (pen, up) = self.accent.unwrap_or(("", 0.0));
        let place = |[x, y]: [f64; 2]| [0.5 * self.width + x, y + up];
        parse(pen).into_iter().map(|s| s.into_iter().map(place).collect()).collect()
    }
}

fn glyph(c: char) -> Glyph {
    let small = |digits: &str, raise: f64| {
        let at = digits.chars().position(|d| d == c)?;
        let (width, pen) = plain("0123456789-+".chars().nth(at)?)?;
        Some(Glyph { width, pen, accent: None, scale: 0.6, raise })
    };
    let accented = || {
        let (base, accent) = accented(c)?;
        let (width, pen) = plain(base)?;
        Some(Glyph {
            width,
            pen,
            accent: Some((accent, if base.is_uppercase() { 2.0 } else { 0.0 })),
            scale: 1.0,
            raise: 0.0,
        })
    };
    small("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", 3.6).or_else(|| small("₀₁₂₃₄₅₆₇₈₉", -1.4)).or_else(accented).unwrap_or_else(|| {
        // A character without a drawing shows as a box, as everywhere.
        let (width, pen) = plain(c).unwrap_or((3.6, "M0 0L3.6 0L3.6 7L0 7L0 0"));
        Glyph { width, pen, accent: None, scale: 1.0, raise: 0.0 }
    })
}

/// Letter and accent of the commonest accented letters in names.
fn accented(c: char) -> Option<(char, &'static str)> {
    const MARKS: [(&str, &str, &str); 4] = [
        ("äëïöüÄËÏÖÜ", "aeıouAEIOU", "M-1 6.7L-1 6.4M1 6.7L1 6.4"),
        ("áéíóúÁÉÍÓÚ", "aeıouAEIOU", "M-0.3 6.2L0.6 7.3"),
        ("àèìòùÀÈÌÒÙ", "aeıouAEIOU", "M0.3 6.2L-0.6 7.3"),
        ("âêîôûÂÊÎÔÛ", "aeıouAEIOU", "M-0.9 6.2L0 7.2L0.9 6.2"),
    ];
    MARKS.iter().find_map(|(letters, bases, mark)| {
        let at = letters.chars().position(|l| l == c)?;
        Some((bases.chars().nth(at)?, *mark))
    })
}

#[rustfmt::skip]
fn plain(c: char) -> Option<(f64, &'static str)> {
    Some(match c {
        ' ' => (1.8, ""),
        '0' => (4.0, "M2 7Q4 7 4 3.5Q4 0 2 0Q0 0 0 3.5Q0 7 2 7"),
        '1' => (4.0, "M0.7 5.6L2.3 7L2.3 0"),
        '2' => (4.0, "M0.1 5.2Q0.1 7 2 7Q3.9 7 3.9 5.2Q3.9 4 2.9 3L0 0L4 0"),
        '3' => (4.0, "M0.2 5.6Q0.5 7 2 7Q3.8 7 3.8 5.3Q3.8 3.7 1.9 3.7L1.4 3.7M1.9 3.7Q4 3.7 4 1.9Q4 0 2 0Q0.2 0 0 1.6"),
        '4' => (4.0, "M3.1 0L3.1 7L0 2L4.2 2"),
        '5' => (4.0, "M3.7 7L0.6 7L0.3 3.8Q0.9 4.5 2 4.5Q4 4.5 4 2.3Q4 0 1.9 0Q0.4 0 0 1.5"),
        '6' => (4.0, "M3.7 6Q3.2 7 2.1 7Q0 7 0 3.2Q0 0 2 0Q4 0 4 2.2Q4 4.3 2 4.3Q0.4 4.3 0 2.6"),
        '7' => (4.0, "M0 7L4 7Q1.8 4 1.5 0"),
        '8' => (4.0, "M2 3.8Q0.2 3.8 0.2 5.4Q0.2 7 2 7Q3.8 7 3.8 5.4Q3.8 3.8 2 3.8Q0 3.8 0 1.9Q0 0 2 0Q4 0 4 1.9Q4 3.8 2 3.8"),
        '9' => (4.0, "M0.3 1Q0.8 0 1.9 0Q4 0 4 3.8Q4 7 2 7Q0 7 0 4.8Q0 2.7 2 2.7Q3.6 2.7 4 4.4"),
        'A' => (5.0, "M0 0L2.5 7L5 0M0.9 2.4L4.1 2.4"),
        'B' => (4.5, "M0 0L0 7L2.4 7Q4.2 7 4.2 5.3Q4.2 3.7 2.4 3.7L0 3.7M2.4 3.7Q4.5 3.7 4.5 1.9Q4.5 0 2.4 0L0 0"),
        'C' => (4.8, "M4.8 5.3Q4.3 7 2.6 7Q0 7 0 3.5Q0 0 2.6 0Q4.3 0 4.8 1.7"),
        'D' => (4.7, "M0 0L0 7L1.9 7Q4.7 7 4.7 3.5Q4.7 0 1.9 0L0 0"),
        'E' => (4.0, "M4 7L0 7L0 0L4 0M0 3.7L3.4 3.7"),
        'F' => (4.0, "M4 7L0 7L0 0M0 3.7L3.3 3.7"),
        'G' => (4.9, "M4.8 5.4Q4.2 7 2.6 7Q0 7 0 3.5Q0 0 2.6 0Q4.9 0 4.9 2.2L4.9 3.2L2.9 3.2"),
        'H' => (4.8, "M0 0L0 7M4.8 0L4.8 7M0 3.7L4.8 3.7"),
        'I' => (0.4, "M0.2 0L0.2 7"),
        'J' => (3.2, "M3.2 7L3.2 1.8Q3.2 0 1.6 0Q0 0 0 1.6"),
        'K' => (4.6, "M0 0L0 7M4.4 7L0 2.6M1.6 4.2L4.6 0"),
        'L' => (3.8, "M0 7L0 0L3.8 0"),
        'M' => (5.8, "M0 0L0 7L2.9 2L5.8 7L5.8 0"),
        'N' => (4.8, "M0 0L0 7L4.8 0L4.8 7"),
        'O' => (5.4, "M2.7 7Q5.4 7 5.4 3.5Q5.4 0 2.7 0Q0 0 0 3.5Q0 7 2.7 7"),
        'P' => (4.3, "M0 0L0 7L2.3 7Q4.3 7 4.3 5.1Q4.3 3.1 2.3 3.1L0 3.1"),
        'Q' => (5.4, "M2.7 7Q5.4 7 5.4 3.5Q5.4 0 2.7 0Q0 0 0 3.5Q0 7 2.7 7M3.3 1.7L5.4 -0.6"),
        'R' => (4.5, "M0 0L0 7L2.3 7Q4.3 7 4.3 5.1Q4.3 3.1 2.3 3.1L0 3.1M2.2 3.1L4.5 0"),
        'S' => (4.3, "M4 5.7Q3.6 7 2.1 7Q0.2 7 0.2 5.4Q0.2 4.1 2.1 3.7Q4.3 3.3 4.3 1.8Q4.3 0 2.1 0Q0.4 0 0 1.5"),
        'T' => (4.8, "M0 7L4.8 7M2.4 7L2.4 0"),
        'U' => (4.8, "M0 7L0 2.4Q0 0 2.4 0Q4.8 0 4.8 2.4L4.8 7"),
        'V' => (5.0, "M0 7L2.5 0L5 7"),
        'W' => (7.0, "M0 7L1.7 0L3.5 6L5.3 0L7 7"),
        'X' => (4.8, "M0 0L4.8 7M0 7L4.8 0"),
        'Y' => (4.8, "M0 7L2.4 3.4L4.8 7M2.4 3.4L2.4 0"),
        'Z' => (4.6, "M0 7L4.6 7L0 0L4.6 0"),
        'a' => (3.8, "M0.4 4.2Q0.8 5 2 5Q3.8 5 3.8 3.3L3.8 0M3.8 2.9L2 2.9Q0 2.9 0 1.4Q0 0 1.6 0Q3.8 0 3.8 2"),
        'b' => (4.0, "M0 7L0 0M0 2.5Q0 5 2 5Q4 5 4 2.5Q4 0 2 0Q0 0 0 2.5"),
        'c' => (3.7, "M3.7 3.8Q3.3 5 2 5Q0 5 0 2.5Q0 0 2 0Q3.3 0 3.7 1.2"),
        'd' => (4.0, "M4 7L4 0M4 2.5Q4 5 2 5Q0 5 0 2.5Q0 0 2 0Q4 0 4 2.5"),
        'e' => (4.0, "M0 2.7L4 2.7Q4 5 2 5Q0 5 0 2.5Q0 0 2.1 0Q3.4 0 3.8 1.1"),
        'f' => (2.6, "M2.7 7L2.4 7Q1 7 1 5.5L1 0M0 4.8L2.5 4.8"),
        'g' => (4.0, "M4 5L4 -0.4Q4 -2.2 2 -2.2Q0.7 -2.2 0.3 -1.3M4 2.5Q4 5 2 5Q0 5 0 2.5Q0 0 2 0Q4 0 4 2.5"),
        'h' => (3.7, "M0 7L0 0M0 2.8Q0 5 2 5Q3.7 5 3.7 3.2L3.7 0"),
        'i' => (0.4, "M0.2 5L0.2 0M0.2 6.8L0.2 7"),
        'ı' => (0.4, "M0.2 5L0.2 0"),
        'j' => (1.2, "M1.2 5L1.2 -0.8Q1.2 -2.2 0 -2.2M1.2 6.8L1.2 7"),
        'k' => (3.7, "M0 7L0 0M3.5 5L0 1.7M1.3 2.9L3.7 0"),
        'l' => (0.4, "M0.2 7L0.2 0"),
        'm' => (6.2, "M0 5L0 0M0 3Q0 5 1.6 5Q3.1 5 3.1 3.3L3.1 0M3.1 3Q3.1 5 4.7 5Q6.2 5 6.2 3.3L6.2 0"),
        'n' => (3.7, "M0 5L0 0M0 2.8Q0 5 2 5Q3.7 5 3.7 3.2L3.7 0"),
        'o' => (4.0, "M2 5Q4 5 4 2.5Q4 0 2 0Q0 0 0 2.5Q0 5 2 5"),
        'p' | 'ρ' => (4.0, "M0 5L0 -2.2M0 2.5Q0 5 2 5Q4 5 4 2.5Q4 0 2 0Q0 0 0 2.5"),
        'q' => (4.0, "M4 5L4 -2.2M4 2.5Q4 5 2 5Q0 5 0 2.5Q0 0 2 0Q4 0 4 2.5"),
        'r' => (2.3, "M0 5L0 0M0 2.6Q0 5 2 5L2.4 5"),
        's' => (3.4, "M3.2 4.1Q2.9 5 1.7 5Q0.2 5 0.2 3.8Q0.2 2.8 1.7 2.6Q3.4 2.3 3.4 1.3Q3.4 0 1.7 0Q0.3 0 0 1"),
        't' => (2.5, "M1 6.6L1 1.4Q1 0 2.1 0L2.6 0M0 4.8L2.5 4.8"),
        'u' => (3.7, "M0 5L0 1.8Q0 0 1.7 0Q3.7 0 3.7 2.2M3.7 5L3.7 0"),
        'v' | 'ν' => (4.0, "M0 5L2 0L4 5"),
        'w' => (5.6, "M0 5L1.4 0L2.8 4.4L4.2 0L5.6 5"),
        'x' => (3.8, "M0 0L3.8 5M0 5L3.8 0"),
        'y' => (4.0, "M0 5L2 0M4 5L1.6 -1.2Q1.2 -2.2 0.2 -2.2"),
        'z' => (3.5, "M0 5L3.5 5L0 0L3.5 0"),
        '!' => (0.4, "M0.2 7L0.2 2.2M0.2 0.2L0.2 0"),
        '"' => (1.6, "M0 7L0 5.2M1.6 7L1.6 5.2"),
        '#' => (4.8, "M1.2 0L1.9 7M2.9 0L3.6 7M0 2.4L4.6 2.4M0.2 4.7L4.8 4.7"),
        '$' => (4.3, "M4 5.7Q3.6 7 2.1 7Q0.2 7 0.2 5.4Q0.2 4.1 2.1 3.7Q4.3 3.3 4.3 1.8Q4.3 0 2.1 0Q0.4 0 0 1.5M2.1 8L2.1 -1"),
        '%' => (6.0, "M1.2 7Q2.4 7 2.4 5.5Q2.4 4 1.2 4Q0 4 0 5.5Q0 7 1.2 7M4.8 3Q6 3 6 1.5Q6 0 4.8 0Q3.6 0 3.6 1.5Q3.6 3 4.8 3M5 7L1 0"),
        '&' => (5.0, "M5 0L1.1 4.8Q0.7 5.3 0.7 5.8Q0.7 7 2 7Q3.3 7 3.3 5.8Q3.3 4.7 1.6 3.7Q0 2.8 0 1.7Q0 0 2 0Q4 0 4.6 2.8"),
        '\'' => (0.4, "M0.2 7L0.2 5.2"),
        '(' => (1.5, "M1.5 7.8Q0 6 0 2.9Q0 -0.2 1.5 -2"),
        ')' => (1.5, "M0 7.8Q1.5 6 1.5 2.9Q1.5 -0.2 0 -2"),
        '*' => (3.0, "M1.5 7L1.5 3.8M0.1 6.2L2.9 4.6M0.1 4.6L2.9 6.2"),
        '+' => (4.4, "M0 3.2L4.4 3.2M2.2 5.4L2.2 1"),
        ',' => (0.6, "M0.5 0.4L0.5 0L0 -1.2"),
        '-' => (2.4, "M0 2.7L2.4 2.7"),
        '.' => (0.5, "M0.1 0L0.4 0L0.4 0.3L0.1 0.3L0.1 0"),
        '/' => (3.0, "M0 -0.8L3 7.6"),
        ':' => (0.4, "M0.2 0.3L0.2 0M0.2 4.3L0.2 4"),
        ';' => (0.6, "M0.5 0.4L0.5 0L0 -1.2M0.4 4.3L0.4 4"),
        '<' => (4.0, "M4 5.6L0 3.2L4 0.8"),
        '=' => (4.4, "M0 4.2L4.4 4.2M0 2.2L4.4 2.2"),
        '>' => (4.0, "M0 5.6L4 3.2L0 0.8"),
        '?' => (3.6, "M0 5.4Q0 7 1.8 7Q3.6 7 3.6 5.4Q3.6 4.3 2.6 3.5Q1.8 2.9 1.8 2M1.8 0.2L1.8 0"),
        '@' => (6.6, "M4.8 3.1Q4.8 4.8 3.2 4.8Q1.7 4.8 1.7 3Q1.7 1.4 3 1.4Q4.8 1.4 4.8 3.1M4.8 4.8L4.8 2.4Q4.8 1.4 5.6 1.4Q6.6 1.4 6.6 3.4Q6.6 7 3.4 7Q0 7 0 3Q0 -1 3.4 -1Q4.8 -1 5.6 -0.4"),
        '[' => (1.4, "M1.4 7.8L0 7.8L0 -1.6L1.4 -1.6"),
        '\\' => (3.0, "M0 7.6L3 -0.8"),
        ']' => (1.4, "M0 7.8L1.4 7.8L1.4 -1.6L0 -1.6"),
        '^' => (3.2, "M0 4.6L1.6 7L3.2 4.6"),
        '_' => (4.0, "M0 -1L4 -1"),
        '`' => (1.0, "M0 7L1 5.8"),
        '{' => (2.0, "M2 7.8Q0.9 7.8 0.9 6.5L0.9 4.2Q0.9 3.1 0 3.1Q0.9 3.1 0.9 2L0.9 -0.4Q0.9 -1.6 2 -1.6"),
        '|' => (0.4, "M0.2 7.8L0.2 -1.6"),
        '}' => (2.0, "M0 7.8Q1.1 7.8 1.1 6.5L1.1 4.2Q1.1 3.1 2 3.1Q1.1 3.1 1.1 2L1.1 -0.4Q1.1 -1.6 0 -1.6"),
        '~' => (4.4, "M0 2.6Q0 3.8 1.1 3.8Q1.8 3.8 2.2 3.2Q2.6 2.6 3.3 2.6Q4.4 2.6 4.4 3.8"),
        'α' => (4.8, "M4.5 5Q3.6 0 1.8 0Q0 0 0 2.5Q0 5 1.8 5Q3.4 5 4 2Q4.2 0 4.8 0"),
        'β' => (4.0, "M0 -2.2L0 5.2Q0 7 1.8 7Q3.5 7 3.5 5.4Q3.5 3.9 1.6 3.9M1.8 3.9Q4 3.9 4 2Q4 0 2 0Q0 0 0 1.4"),
        'γ' => (4.0, "M0 5L2 0.4L4 5M2 0.4Q1.3 -1 1.4 -2.2"),
        'δ' => (4.0, "M3.6 6.4Q3 7 2 7Q0.6 7 0.6 5.9Q0.6 5 2.2 4.4Q4 3.8 4 2.3Q4 0 2 0Q0 0 0 2.2Q0 4.3 2.2 4.4"),
        'ε' => (3.6, "M3.4 4.3Q3 5 1.8 5Q0.2 5 0.2 3.8Q0.2 2.7 1.8 2.7Q0 2.7 0 1.4Q0 0 1.8 0Q3.2 0 3.6 0.9"),
        'η' => (3.7, "M0 5L0 0M0 2.8Q0 5 2 5Q3.7 5 3.7 3.2L3.7 -2.2"),
        'θ' => (3.8, "M1.9 7Q3.8 7 3.8 3.5Q3.8 0 1.9 0Q0 0 0 3.5Q0 7 1.9 7M0 3.5L3.8 3.5"),
        'κ' => (3.6, "M0 5L0 0M3.4 5L0 2.1M1.2 3.1L3.6 0"),
        'λ' => (4.0, "M0 7L0.5 7Q1.2 7 1.6 5.8L4 0M2.1 4.4L0 0"),
        'μ' | 'µ' => (3.7, "M0 5L0 -2.2M0 1.8Q0 0 1.7 0Q3.7 0 3.7 2.2M3.7 5L3.7 0"),
        'π' => (4.4, "M0 5L4.4 5M1.1 5L1.1 0M3.3 5L3.3 0"),
        'σ' => (4.6, "M4.6 5L2 5Q0 5 0 2.5Q0 0 2 0Q4 0 4 2.5Q4 5 2 5"),
        'τ' => (3.8, "M0 4.2Q0.2 5 1 5L3.8 5M2 5L2 1.3Q2 0 3 0L3.4 0"),
        'φ' => (4.8, "M2.4 7L2.4 -2.2M2.4 5Q4.8 5 4.8 2.5Q4.8 0 2.4 0Q0 0 0 2.5Q0 5 2.4 5"),
        'χ' => (4.0, "M0 5L4 -2.2M4 5L0 -2.2"),
        'ω' => (5.4, "M0.8 5Q0 4 0 2.2Q0 0 1.4 0Q2.7 0 2.7 2L2.7 3M2.7 2Q2.7 0 4 0Q5.4 0 5.4 2.2Q5.4 4 4.6 5"),
        'Δ' => (5.0, "M0 0L2.5 7L5 0L0 0"),
        '∇' => (5.0, "M0 7L5 7L2.5 0L0 7"),
        '∂' => (4.0, "M0.6 6.2Q1.1 7 2 7Q4 7 4 3Q4 0 1.9 0Q0 0 0 2Q0 4.2 2 4.2Q4 4.2 4 2.4"),
        '°' => (2.0, "M1 7.2Q2 7.2 2 6.2Q2 5.2 1 5.2Q0 5.2 0 6.2Q0 7.2 1 7.2"),
        '·' => (0.4, "M0.2 3.1L0.2 3.4"),
        '×' => (3.6, "M0 1.4L3.6 5M0 5L3.6 1.4"),
        '−' => (3.6, "M0 3.2L3.6 3.2"),
        '–' | '—' => (4.4, "M0 2.7L4.4 2.7"),
        '±' => (4.4, "M0 3.8L4.4 3.8M2.2 5.8L2.2 1.8M0 0.6L4.4 0.6"),
        '√' => (4.4, "M0 3L1 3.6L2.2 0L4.4 7.6"),
        '∞' => (6.0, "M3 3.2Q2.4 4.8 1.4 4.8Q0 4.8 0 3.2Q0 1.6 1.4 1.6Q2.4 1.6 3 3.2Q3.6 4.8 4.6 4.8Q6 4.8 6 3.2Q6 1.6 4.6 1.6Q3.6 1.6 3 3.2"),
        '≤' => (4.0, "M4 6.2L0 4L4 1.8M0 0.4L4 0.4"),
        '≥' => (4.0, "M0 6.2L4 4L0 1.8M0 0.4L4 0.4"),
        '≈' => (4.4, "M0 3.8Q0 5 1.1 5Q1.8 5 2.2 4.4Q2.6 3.8 3.3 3.8Q4.4 3.8 4.4 5M0 1.2Q0 2.4 1.1 2.4Q1.8 2.4 2.2 1.8Q2.6 1.2 3.3 1.2Q4.4 1.2 4.4 2.4"),
        '→' => (5.4, "M0 3.2L5.4 3.2M3.8 4.8L5.4 3.2L3.8 1.6"),
        '\u{a0}' => (1.8, ""),
        _ => return None,
    })
}

/// Turns pen movements into polylines; what does not parse is left out.
fn parse(pen: &str) -> Vec<Vec<[f64; 2]>> {
    let mut out: Vec<Vec<[f64; 2]>> = vec![];
    for (command, numbers) in movements(pen) {
        match (command, numbers.as_slice()) {
            ('M', &[x, y]) => out.push(vec![[x, y]]),
            ('L', &[x, y]) => {
                if let Some(stroke) = out.last_mut() {
                    stroke.push([x, y]);
                }
            }
            ('Q', &[cx, cy, x, y]) => {
                if let Some(stroke) = out.last_mut() {
                    let from = stroke.last().copied().unwrap_or([cx, cy]);
                    bend(stroke, from, [cx, cy], [x, y]);
                }
            }
            _ => {}
        }
    }
    out
}

fn movements(text: &str) -> Vec<(char, Vec<f64>)> {
    let starts = text.char_indices().filter(|(_, c)| c.is_ascii_alphabetic());
    starts
        .map(|(at, command)| {
            let rest = &text[at + 1..];
            let end = rest.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(rest.len());
            (command, rest[..end].split(' ').filter_map(|n| n.parse().ok()).collect())
        })
        .collect()
}

/// A cubic curve with its handles towards the corner: a quarter ellipse where the corner is square.
fn bend(stroke: &mut Vec<[f64; 2]>, a: [f64; 2], corner: [f64; 2], b: [f64; 2]) {
    const PIECES: usize = 6;
    const HANDLE: f64 = 0.5523;
    for n in 1..=PIECES {
        let t = n as f64 / PIECES as f64;
        let s = 1.0 - t;
        let mut point = [0.0; 2];
        for axis in 0..2 {
            let toward = |p: f64| p + HANDLE * (corner[axis] - p);
            point[axis] = s * s * s * a[axis]
                + 3.0 * s * s * t * toward(a[axis])
                + 3.0 * s * t * t * toward(b[axis])
                + t * t * t * b[axis];
        }
        stroke.push(point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_ascii_character_has_its_own_drawing() {
        let mut seen = std::collections::HashSet::new();
        for c in '!'..='~' {
            let (width, pen) = plain(c).unwrap_or_else(|| panic!("{c} has no drawing"));
            assert!(seen.insert(pen), "{c} looks like another character");
            let points: Vec<[f64; 2]> = parse(pen).concat();
            assert!(points.len() >= 2, "{c}");
            for [x, y] in points {
                assert!(x >= -0.01 && x <= width + 0.25, "{c} is wider than it says: {x}");
                assert!((-2.3..=8.1).contains(&y), "{c} is too tall: {y}");
            }
        }
    }

    #[test]
    fn the_signs_of_the_field_are_there() {
        for c in "²³⁻¹°τφακλημπσθΔ∇∂·×−±√∞≤≥→".chars() {
            assert!(plain(c).is_some() || glyph(c).scale < 1.0, "{c}");
        }
        assert_eq!(strokes("ö", 7.0).len(), strokes("o", 7.0).len() + 2);
        assert!(plain('字').is_none());
        assert!(!strokes("字", 10.0).is_empty());
    }

    #[test]
    fn a_bend_around_a_square_corner_is_a_quarter_circle() {
        let mut arc = vec![[1.0, 0.0]];
        bend(&mut arc, [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]);
        for [x, y] in arc {
            assert!((x.hypot(y) - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn width_is_that_of_the_strokes() {
        assert_eq!(width("", 7.0), 0.0);
        assert_eq!(width("H", 7.0), 4.8);
        assert_eq!(width("HH", 14.0), 2.0 * (4.8 + GAP + 4.8));
    }
}
