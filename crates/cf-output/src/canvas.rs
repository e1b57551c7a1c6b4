//! A picture in memory: rectangles, smooth lines, convex shapes and text; pixels outside are ignored.

use std::path::Path;

use crate::OutputError;
use crate::atomic::write_atomic;
use crate::color::Rgb;
use crate::font;
use crate::surface::{Anchor, Pen, Surface};

/// An RGB picture, 8 bits per channel, y down.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

/// The longest side of a canvas; larger requests are cut to it.
pub const MAX_SIDE: usize = 1 << 14;

impl Canvas {
    /// A canvas of one colour, each side at least 1 and at most [`MAX_SIDE`] pixels.
    pub fn new(width: usize, height: usize, background: Rgb) -> Self {
        let (width, height) = (width.clamp(1, MAX_SIDE), height.clamp(1, MAX_SIDE));
        Self { width, height, pixels: background.repeat(width * height) }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Rows of RGB bytes from the top.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// The colour of a pixel, if it is inside.
    pub fn get(&self, x: usize, y: usize) -> Option<Rgb> {
        let at = 3 * (x + self.width * y);
        (x < self.width && y < self.height).then(|| [self.pixels[at], self.pixels[at + 1], self.pixels[at + 2]])
    }

    /// Sets a pixel, if it is inside.
    pub fn set(&mut self, x: usize, y: usize, color: Rgb) {
        if x < self.width && y < self.height {
            let at = 3 * (x + self.width * y);
            self.pixels[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Copies another canvas with its top left corner at (x, y).
    pub fn paste(&mut self, other: &Canvas, x: usize, y: usize) {
        for row in 0..other.height {
            for column in 0..other.width {
                if let Some(color) = other.get(column, row) {
                    self.set(x + column, y + row, color);
                }
            }
        }
    }

    /// Writes a PNG, whole or not at all.
    ///
    /// # Errors
    /// As [`write_atomic`].
    pub fn write_png(&self, path: &Path) -> Result<(), OutputError> {
        write_atomic(path, |sink| {
            let mut encoder = png::Encoder::new(sink, self.width as u32, self.height as u32);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&self.pixels)?;
            Ok(writer.finish()?)
        })
    }

    /// Reads a PNG that [`write_png`](Self::write_png) wrote.
    ///
    /// # Errors
    /// [`OutputError::Io`] if it cannot be read, [`OutputError::Damaged`] if it is no such picture.
    pub fn read_png(path: &Path) -> Result<Self, OutputError> {
        let io = |source| OutputError::Io { path: path.to_owned(), action: "read", source };
        let damaged = |reason: String| OutputError::damaged(path, reason);
        let file = std::io::BufReader::new(std::fs::File::open(path).map_err(io)?);
        let mut reader = png::Decoder::new(file).read_info().map_err(|error| damaged(error.to_string()))?;
        let (width, height) = (reader.info().width as usize, reader.info().height as usize);
        let rgb = reader.output_color_type() == (png::ColorType::Rgb, png::BitDepth::Eight);
        if !rgb || width.max(height) > MAX_SIDE {
            return Err(damaged(format!("{width} x {height} pixels; red, green and blue of 8 bits are read")));
        }
        let mut pixels = vec![0; 3 * width * height];
        reader.next_frame(&mut pixels).map_err(|error| damaged(error.to_string()))?;
        Ok(Self { width, height, pixels })
    }

    /// Half as wide and high, by means of two pixels by two; an odd last row or column is dropped.
    pub fn halved(&self) -> Self {
        let mut half = Self::new(self.width / 2, self.height / 2, [0; 3]);
        for y in 0..self.height / 2 {
            for x in 0..self.width / 2 {
                let four =
                    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.get(2 * x + i, 2 * y + j).unwrap_or_default());
                let mean = |c: usize| (four.iter().map(|pixel| u32::from(pixel[c])).sum::<u32>() + 2) / 4;
                half.set(x, y, std::array::from_fn(|c| mean(c) as u8));
            }
        }
        half
    }

    fn blend(&mut self, x: usize, y: usize, color: Rgb, alpha: f64) {
        let at = 3 * (x + self.width * y);
        for (old, new) in self.pixels[at..at + 3].iter_mut().zip(color) {
            let mixed = f64::from(*old) + alpha * (f64::from(new) - f64::from(*old));
            *old = mixed.round() as u8;
        }
    }

    /// Pixels of the canvas that meet a box, as ranges.
    fn inside(&self, [x0, y0, x1, y1]: [f64; 4]) -> (std::ops::Range<usize>, std::ops::Range<usize>) {
        // Casts saturate, so far-away and infinite boxes are cut to the canvas.
        let range =
            |a: f64, b: f64, n: usize| (a.floor().max(0.0) as usize).min(n)..(b.ceil().max(0.0) as usize).min(n);
        (range(x0, x1, self.width), range(y0, y1, self.height))
    }

    /// Draws polylines as one shape, so that crossing strokes do not darken each other.
    fn strokes(&mut self, lines: &[Vec<[f64; 2]>], pen: Pen, clip: [f64; 4]) {
        let reach = 0.5 * pen.width + 1.0;
        let points = || lines.iter().flatten().filter(|p| p[0].is_finite() && p[1].is_finite());
        let low = |axis: usize| points().map(|p| p[axis]).fold(f64::INFINITY, f64::min) - reach;
        let high = |axis: usize| points().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max) + reach;
        let bounds = [low(0).max(clip[0]), low(1).max(clip[1]), high(0).min(clip[2]), high(1).min(clip[3])];
        let (columns, rows) = self.inside(bounds);
        let mut cover = vec![0.0_f32; columns.len() * rows.len()];
        for pair in lines.iter().flat_map(|l| l.windows(2)) {
            let (a, b) = (pair[0], pair[1]);
            if ![a[0], a[1], b[0], b[1]].iter().all(|v| v.is_finite()) {
                continue;
            }
            let near = [
                (a[0].min(b[0]) - reach).max(bounds[0]),
                (a[1].min(b[1]) - reach).max(bounds[1]),
                (a[0].max(b[0]) + reach).min(bounds[2]),
                (a[1].max(b[1]) + reach).min(bounds[3]),
            ];
            let (xs, ys) = self.inside(near);
            for y in ys {
                for x in xs.clone() {
                    let d = distance([x as f64 + 0.5, y as f64 + 0.5], a, b);
                    let c = (0.5 * pen.width + 0.5 - d).clamp(0.0, 1.0) as f32;
                    let at = (x - columns.start) + columns.len() * (y - rows.start);
                    cover[at] = cover[at].max(c);
                }
            }
        }
        for y in rows.clone() {
            for x in columns.clone() {
                let c = cover[(x - columns.start) + columns.len() * (y - rows.start)];
                if c > 0.0 {
                    self.blend(x, y, pen.color, f64::from(c) * pen.alpha);
                }
            }
        }
    }
}

fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (d, q) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = d[0] * d[0] + d[1] * d[1];
    let t = if length > 0.0 { ((q[0] * d[0] + q[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    (q[0] - t * d[0]).hypot(q[1] - t * d[1])
}

impl Surface for Canvas {
    fn rectangle(&mut self, area: [f64; 4], color: Rgb, alpha: f64) {
        let (xs, ys) = self.inside(area.map(f64::round));
        for y in ys {
            for x in xs.clone() {
                self.blend(x, y, color, alpha);
            }
        }
    }

    fn line(&mut self, points: &[[f64; 2]], pen: Pen, clip: [f64; 4]) {
        let lines = if pen.dashed { dashes(points, clip) } else { vec![points.to_vec()] };
        self.strokes(&lines, pen, clip);
    }

    fn convex(&mut self, corners: &[[f64; 2]], color: Rgb) {
        let fold = |axis: usize, start: f64, f: fn(f64, f64) -> f64| corners.iter().map(|p| p[axis]).fold(start, f);
        let bounds = [
            fold(0, f64::INFINITY, f64::min) - 1.0,
            fold(1, f64::INFINITY, f64::min) - 1.0,
            fold(0, f64::NEG_INFINITY, f64::max) + 1.0,
            fold(1, f64::NEG_INFINITY, f64::max) + 1.0,
        ];
        let (xs, ys) = self.inside(bounds);
        for y in ys {
            for x in xs.clone() {
                let outside = (0..corners.len()).map(|n| {
                    let (a, b) = (corners[n], corners[(n + 1) % corners.len()]);
                    let d = [b[0] - a[0], b[1] - a[1]];
                    let cross = d[1] * (x as f64 + 0.5 - a[0]) - d[0] * (y as f64 + 0.5 - a[1]);
                    cross / d[0].hypot(d[1]).max(1e-12)
                });
                let alpha = (0.5 - outside.fold(f64::NEG_INFINITY, f64::max)).clamp(0.0, 1.0);
                if alpha > 0.0 {
                    self.blend(x, y, color, alpha);
                }
            }
        }
    }

    fn text(&mut self, at: [f64; 2], text: &str, cap: f64, color: Rgb, anchor: Anchor, upward: bool) {
        // More than fits on any canvas is not drawn.
        let text: String = text.chars().take(1000).collect();
        let shift = font::width(&text, cap) * anchor.fraction();
        let place = |[x, y]: [f64; 2]| {
            if upward { [at[0] - y, at[1] - (x - shift)] } else { [at[0] + x - shift, at[1] - y] }
        };
        let lines: Vec<Vec<[f64; 2]>> =
            font::strokes(&text, cap).into_iter().map(|s| s.into_iter().map(place).collect()).collect();
        let everywhere = [0.0, 0.0, self.width as f64, self.height as f64];
        self.strokes(&lines, Pen::new(cap * 0.13, color), everywhere);
    }
}

/// Cuts a polyline into dashes of 7 pixels and gaps of 5, inside the clip box only.
fn dashes(points: &[[f64; 2]], clip: [f64; 4]) -> Vec<Vec<[f64; 2]>> {
    let (mut out, mut travelled) = (vec![], 0.0_f64);
    for w in points.windows(2) {
        let Some([a, b]) = cut([w[0], w[1]], clip) else { continue };
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let mut s = 0.0;
        while s < length {
            let phase = travelled % 12.0;
            let step = if phase < 7.0 { 7.0 - phase } else { 12.0 - phase }.max(1e-3);
            let end = (s + step).min(length);
            if phase < 7.0 {
                let point = |s: f64| [a[0] + (b[0] - a[0]) * s / length, a[1] + (b[1] - a[1]) * s / length];
                out.push(vec![point(s), point(end)]);
            }
            travelled += end - s;
            s = end;
        }
    }
    out
}

/// The part of a segment inside a box (Liang-Barsky).
fn cut([a, b]: [[f64; 2]; 2], clip: [f64; 4]) -> Option<[[f64; 2]; 2]> {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let d = b[axis] - a[axis];
        if !d.is_finite() {
            return None;
        }
        let (low, high) = (clip[axis] - a[axis], clip[axis + 2] - a[axis]);
        if d == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
        } else {
            from = from.max((low / d).min(high / d));
            to = to.min((low / d).max(high / d));
        }
    }
    let point = |t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    (from < to).then(|| [point(from), point(to)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Rgb = [255; 3];
    const BLACK: Rgb = [0; 3];

    #[test]
    fn a_png_reads_back_to_the_same_pixels() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let mut canvas = Canvas::new(20, 10, WHITE);
        canvas.rectangle([2.0, 3.0, 5.0, 6.0], [10, 20, 30], 1.0);
        canvas.write_png(&path).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert_eq!(pixels, canvas.pixels());
        assert_eq!(Canvas::read_png(&path).unwrap(), canvas);
        assert!(Canvas::read_png(&dir.path().join("none.png")).is_err());
        std::fs::write(dir.path().join("b.png"), b"not a picture").unwrap();
        assert!(Canvas::read_png(&dir.path().join("b.png")).is_err());
        let half = canvas.halved();
        assert_eq!((half.width(), half.height(), half.get(2, 2)), (10, 5, Some([133, 138, 143])));
        assert_eq!(canvas.get(2, 3), Some([10, 20, 30]));
        assert_eq!(canvas.get(5, 3), Some(WHITE));
    }

    #[test]
    fn nothing_drawn_outside_or_from_nonsense_panics() {
        let mut canvas = Canvas::new(30, 30, WHITE);
        let far = [[-1e300, 5.0], [1e300, 6.0], [f64::NAN, 0.0], [f64::INFINITY, 2.0]];
        let clip = [0.0, 0.0, 30.0, 30.0];
        canvas.line(&far, Pen::new(2.0, BLACK), clip);
        canvas.line(&far, Pen { dashed: true, ..Pen::new(2.0, BLACK) }, clip);
        canvas.rectangle([f64::NAN, -5.0, 1e9, 1e9], BLACK, 0.5);
        canvas.convex(&[], BLACK);
        canvas.convex(&[[f64::NAN, 1.0], [2.0, 2.0], [1.0, 1e300]], BLACK);
        canvas.text([-50.0, 1e12], &"long ".repeat(10_000), 12.0, BLACK, Anchor::Middle, true);
        assert_eq!(Canvas::new(0, usize::MAX, WHITE).height(), MAX_SIDE);
    }

    #[test]
    fn lines_respect_the_clip_and_dashes_have_gaps() {
        let mut canvas = Canvas::new(60, 9, WHITE);
        let pen = Pen { dashed: true, ..Pen::new(1.0, BLACK) };
        canvas.line(&[[-1e6, 4.5], [1e6, 4.5]], pen, [5.0, 0.0, 40.0, 9.0]);
        let row: Vec<bool> = (0..60).map(|x| canvas.get(x, 4) != Some(WHITE)).collect();
        assert!(row[..4].iter().all(|d| !d) && row[41..].iter().all(|d| !d));
        assert!(row[6..40].iter().any(|&d| d) && row[6..40].iter().any(|&d| !d));
    }

    #[test]
    fn shapes_cover_their_inside_whatever_way_round() {
        let mut canvas = Canvas::new(20, 20, WHITE);
        canvas.convex(&[[5.0, 5.0], [15.0, 5.0], [15.0, 15.0], [5.0, 15.0]], BLACK);
        assert_eq!((canvas.get(10, 10), canvas.get(2, 10)), (Some(BLACK), Some(WHITE)));
    }
}
