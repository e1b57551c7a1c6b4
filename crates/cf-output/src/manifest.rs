//! What was written, in numbers another program can check: one JSON file beside the series.

use std::fmt::Write;
use std::path::Path;

use crate::OutputError;
use crate::array::Precision;
use crate::atomic::write_text;
use crate::text::{json, json_number};

/// Smallest, largest and summed value of an array over all its components; only finite values count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stats {
    /// Smallest finite value, +∞ if there is none.
    pub min: f64,
    /// Largest finite value, −∞ if there is none.
    pub max: f64,
    /// Compensated sum of the finite values, in the array's own unit.
    pub sum: f64,
    /// How many values are NaN or infinite.
    pub nonfinite: u64,
    lost: f64,
}

impl Default for Stats {
    fn default() -> Self {
        Self { min: f64::INFINITY, max: f64::NEG_INFINITY, sum: 0.0, nonfinite: 0, lost: 0.0 }
    }
}

impl Stats {
    /// Adds little-endian values. Eight lanes, so that statistics cost less than the disk does.
    pub(crate) fn take(&mut self, precision: Precision, bytes: &[u8]) {
        match precision {
            Precision::F32 => self.lanes(bytes.as_chunks::<4>().0, |b| f32::from_le_bytes(*b).into()),
            Precision::F64 => self.lanes(bytes.as_chunks::<8>().0, |b| f64::from_le_bytes(*b)),
        }
    }

    fn lanes<const N: usize>(&mut self, values: &[[u8; N]], decode: impl Fn(&[u8; N]) -> f64) {
        let (mut min, mut max) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8]);
        let (mut sum, mut finite) = ([0.0; 8], [0_u32; 8]);
        for eight in values.chunks(8) {
            for (lane, bytes) in eight.iter().enumerate() {
                let v = decode(bytes);
                let ok = v.is_finite();
                min[lane] = if ok && v < min[lane] { v } else { min[lane] };
                max[lane] = if ok && v > max[lane] { v } else { max[lane] };
                sum[lane] += if ok { v } else { 0.0 };
                finite[lane] += u32::from(ok);
            }
        }
        let finite: u64 = finite.iter().map(|&n| u64::from(n)).sum();
        self.nonfinite += values.len() as u64 - finite;
        self.min = min.iter().fold(self.min, |a, &b| a.min(b));
        self.max = max.iter().fold(self.max, |a, &b| a.max(b));
        let part: f64 = sum.iter().sum();
        let total = self.sum + part;
        self.lost += if self.sum.abs() >= part.abs() { (self.sum - total) + part } else { (part - total) + self.sum };
        self.sum = total;
    }

    pub(crate) fn finished(mut self) -> Self {
        if self.lost.is_finite() {
            self.sum += self.lost;
        }
        self.lost = 0.0;
        self
    }

    fn json(&self) -> String {
        format!(
            "{{\"min\": {}, \"max\": {}, \"sum\": {}, \"nonfinite\": {}}}",
            json_number(self.min),
            json_number(self.max),
            json_number(self.sum),
            self.nonfinite
        )
    }
}

/// The part of a record that depends on the kind of file.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A `.vti`.
    Image {
        /// Point ranges `0 nx 0 ny 0 nz`.
        extent: [usize; 6],
        /// Low corner of the box.
        origin: [f64; 3],
        /// Cell size.
        spacing: [f64; 3],
    },
    /// A `.vtp`.
    Points {
        /// Number of points.
        count: usize,
        /// Over all coordinates.
        positions: Stats,
    },
}

/// One written file: what [`write_image`](crate::write_image) and [`write_points`](crate::write_points) return.
#[derive(Debug, Clone, PartialEq)]
pub struct FileRecord {
    /// File name without folder.
    pub file: String,
    /// Simulated time.
    pub time: f64,
    /// Grid or point count.
    pub shape: Shape,
    /// Statistics by array name, in file order.
    pub arrays: Vec<(String, Stats)>,
}

impl FileRecord {
    fn json(&self) -> String {
        let mut out = format!("{{\"file\": {}, \"time\": {}", json(&self.file), json_number(self.time));
        match &self.shape {
            Shape::Image { extent, origin, spacing } => {
                let list = |v: &[f64]| v.iter().map(|&x| json_number(x)).collect::<Vec<_>>().join(", ");
                let _ = write!(
                    out,
                    ", \"extent\": {extent:?}, \"origin\": [{}], \"spacing\": [{}]",
                    list(origin),
                    list(spacing)
                );
            }
            Shape::Points { count, positions } => {
                let _ = write!(out, ", \"points\": {count}, \"positions\": {}", positions.json());
            }
        }
        let arrays: Vec<String> =
            self.arrays.iter().map(|(name, stats)| format!("{}: {}", json(name), stats.json())).collect();
        let _ = write!(out, ", \"arrays\": {{{}}}}}", arrays.join(", "));
        out
    }
}

/// The records of a run; written as `<run>.manifest.json` beside `<run>.pvd`.
#[derive(Debug, Clone, Default)]
pub struct Manifest {
    /// In the order written.
    pub files: Vec<FileRecord>,
}

impl Manifest {
    /// The manifest as JSON text.
    pub fn json(&self) -> String {
        let files: Vec<String> = self.files.iter().map(|f| format!("  {}", f.json())).collect();
        format!("{{\"files\": [\n{}\n]}}\n", files.join(",\n"))
    }

    /// Writes the JSON text, whole or not at all.
    ///
    /// # Errors
    /// As [`write_atomic`](crate::write_atomic).
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_text(path, &self.json())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::Scalar;

    fn stats(values: &[f64]) -> Stats {
        let (mut bytes, mut stats) = (vec![], Stats::default());
        f64::put(values, &mut bytes);
        for part in bytes.chunks(8 * 5) {
            stats.take(Precision::F64, part);
        }
        stats.finished()
    }

    #[test]
    fn statistics_skip_and_count_what_is_not_finite() {
        let s = stats(&[1.0, f64::NAN, -3.0, f64::INFINITY, 0.5]);
        assert_eq!((s.min, s.max, s.sum, s.nonfinite), (-3.0, 1.0, -1.5, 2));
    }

    #[test]
    fn large_cancelling_parts_do_not_lose_the_small_one() {
        let mut values = vec![1e16, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        values.extend([-1e16, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(stats(&values).sum, 1.0);
    }

    #[test]
    fn the_text_is_json_with_the_promised_keys() {
        let shape = Shape::Image { extent: [0, 4, 0, 3, 0, 1], origin: [0.0; 3], spacing: [0.1, 0.1, f64::NAN] };
        let record =
            FileRecord { file: "a\"b.vti".into(), time: 0.5, shape, arrays: vec![("phi".into(), stats(&[2.0]))] };
        let text = Manifest { files: vec![record] }.json();
        assert!(text.contains(r#""file": "a\"b.vti", "time": 0.5, "extent": [0, 4, 0, 3, 0, 1]"#), "{text}");
        assert!(text.contains(r#""spacing": [0.1, 0.1, null]"#), "{text}");
        assert!(text.contains(r#""phi": {"min": 2.0, "max": 2.0, "sum": 2.0, "nonfinite": 0}"#), "{text}");
    }
}
