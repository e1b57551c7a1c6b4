//! The appended block of a VTK XML file: byte counts known beforehand, values streamed.

use std::io::{self, Write};

use crate::OutputError;
use crate::array::Array;
use crate::manifest::Stats;
use crate::text::escape;

/// The longest stretch of cells or points held in memory at once.
const STRETCH: usize = 1 << 14;

/// One array of the appended block.
enum Block<'a> {
    Time(f64),
    Values(&'a Array<'a>),
    /// `first, first + 1, …`: connectivity and offsets of one vertex per point.
    Counting {
        first: i64,
        count: usize,
    },
}

/// Collects arrays while the header is composed, then streams them in the same order.
#[derive(Default)]
pub(crate) struct Appended<'a> {
    blocks: Vec<Block<'a>>,
    offset: u64,
}

impl<'a> Appended<'a> {
    /// The field data of a file: its time, where ParaView looks for it.
    pub fn time(&mut self, time: f64) -> Result<String, OutputError> {
        let offset = self.push(Block::Time(time), 8)?;
        Ok(format!(
            "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfComponents=\"1\" \
             NumberOfTuples=\"1\" format=\"appended\" offset=\"{offset}\"/>\n</FieldData>\n"
        ))
    }

    /// The header element of an array.
    pub fn values(&mut self, array: &'a Array<'a>) -> Result<String, OutputError> {
        array.check_name()?;
        let source = &array.source;
        let bytes = source
            .shape()
            .iter()
            .chain([&source.components(), &source.precision().bytes()])
            .try_fold(1_usize, |a, &b| a.checked_mul(b))
            .ok_or_else(|| OutputError::array(&array.name, "has more bytes than can be addressed"))?;
        let offset = self.push(Block::Values(array), bytes as u64)?;
        Ok(format!(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" \
             offset=\"{offset}\"/>\n",
            source.precision().vtk_name(),
            escape(&array.name),
            source.components(),
        ))
    }

    /// The header element of `count` integers `first, first + 1, …`.
    pub fn counting(&mut self, name: &str, first: i64, count: usize) -> Result<String, OutputError> {
        let offset = self.push(Block::Counting { first, count }, 8 * count as u64)?;
        Ok(format!(
            "<DataArray type=\"Int64\" Name=\"{name}\" NumberOfComponents=\"1\" format=\"appended\" \
             offset=\"{offset}\"/>\n"
        ))
    }

    fn push(&mut self, block: Block<'a>, bytes: u64) -> Result<u64, OutputError> {
        let offset = self.offset;
        self.offset = bytes
            .checked_add(8)
            .and_then(|b| offset.checked_add(b))
            .ok_or_else(|| OutputError::request("file", "is larger than can be addressed"))?;
        self.blocks.push(block);
        Ok(offset)
    }

    /// Streams header and arrays; returns the statistics of the value arrays in order.
    pub fn write(&self, header: &str, sink: &mut impl Write) -> io::Result<Vec<Stats>> {
        sink.write_all(header.as_bytes())?;
        sink.write_all(b"<AppendedData encoding=\"raw\">\n_")?;
        let (mut stats, mut buffer) = (vec![], vec![]);
        for block in &self.blocks {
            match block {
                Block::Time(time) => {
                    sink.write_all(&8_u64.to_le_bytes())?;
                    sink.write_all(&time.to_le_bytes())?;
                }
                Block::Values(array) => stats.push(write_values(array, sink, &mut buffer)?),
                Block::Counting { first, count } => {
                    sink.write_all(&(8 * *count as u64).to_le_bytes())?;
                    for number in *first..*first + *count as i64 {
                        sink.write_all(&number.to_le_bytes())?;
                    }
                }
            }
        }
        sink.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
        Ok(stats)
    }
}

fn write_values(array: &Array, sink: &mut impl Write, buffer: &mut Vec<u8>) -> io::Result<Stats> {
    let source = &array.source;
    let [nx, ny, nz] = source.shape();
    let cell = source.components() * source.precision().bytes();
    sink.write_all(&((nx * ny * nz * cell) as u64).to_le_bytes())?;
    let mut stats = Stats::default();
    for z in 0..nz {
        for y in 0..ny {
            for start in (0..nx).step_by(STRETCH) {
                let stretch = start..nx.min(start.saturating_add(STRETCH));
                let expected = stretch.len() * cell;
                buffer.clear();
                source.row(stretch, y, z, buffer);
                // A source of the wrong length would shift every array after it.
                if buffer.len() != expected {
                    let text = format!("array '{}' gave {} bytes for {expected}", array.name, buffer.len());
                    return Err(io::Error::new(io::ErrorKind::InvalidData, text));
                }
                stats.take(source.precision(), buffer);
                sink.write_all(buffer)?;
            }
        }
    }
    Ok(stats.finished())
}

/// Refuses two arrays of one name (a reader would drop one) and arrays of a foreign shape.
pub(crate) fn check_arrays(arrays: &[Array], shape: [usize; 3]) -> Result<(), OutputError> {
    for (n, array) in arrays.iter().enumerate() {
        if arrays[..n].iter().any(|other| other.name == array.name) {
            return Err(OutputError::array(&array.name, "is given twice; names must differ"));
        }
        if array.source.shape() != shape {
            let found = array.source.shape();
            return Err(OutputError::array(&array.name, format!("has shape {found:?}, the file {shape:?}")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::{Precision, Source};

    struct Liar;
    impl Source for Liar {
        fn precision(&self) -> Precision {
            Precision::F32
        }
        fn components(&self) -> usize {
            1
        }
        fn shape(&self) -> [usize; 3] {
            [3, 1, 1]
        }
        fn row(&self, _: std::ops::Range<usize>, _: usize, _: usize, out: &mut Vec<u8>) {
            out.push(0);
        }
    }

    #[test]
    fn offsets_count_every_length_word() {
        let array = Array::per_point("v", 3, |p| [p as f32; 2]);
        let mut appended = Appended::default();
        assert!(appended.time(1.0).unwrap().contains("offset=\"0\""));
        assert!(appended.values(&array).unwrap().contains("offset=\"16\""));
        assert!(appended.counting("offsets", 1, 3).unwrap().contains("offset=\"48\""));
        let mut out = vec![];
        let stats = appended.write("", &mut out).unwrap();
        let frame = "<AppendedData encoding=\"raw\">\n_\n</AppendedData>\n</VTKFile>\n".len();
        assert_eq!(out.len(), frame + 16 + (8 + 24) + (8 + 24));
        assert_eq!((stats.len(), stats[0].sum), (1, 6.0));
    }

    #[test]
    fn a_source_that_gives_too_little_is_an_error() {
        let array = Array::new("liar", Liar);
        let mut appended = Appended::default();
        appended.values(&array).unwrap();
        let error = appended.write("", &mut vec![]).unwrap_err().to_string();
        assert!(error.contains("liar") && error.contains("12"), "{error}");
    }

    #[test]
    fn absurd_sizes_are_refused_before_anything_is_written() {
        let array = Array::per_cell("big", [usize::MAX, 2, 1], |_| [0.0_f64]);
        assert!(Appended::default().values(&array).is_err());
    }

    #[test]
    fn long_rows_are_written_in_stretches() {
        let count = 2 * STRETCH + 7;
        let array = Array::per_point("n", count, |p| [p as f64]);
        let mut appended = Appended::default();
        appended.values(&array).unwrap();
        let mut out = vec![];
        let stats = appended.write("", &mut out).unwrap();
        assert_eq!(stats[0].sum, (count * (count - 1) / 2) as f64);
    }
}
