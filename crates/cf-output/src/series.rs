//! `.pvd`: the files of a run in time order, complete after every frame.

use std::path::{Component, Path, PathBuf};

use crate::OutputError;
use crate::atomic::{folder_of, write_text};
use crate::reader::read_series;
use crate::text::{escape, number};

/// One file of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesEntry {
    /// Simulated time.
    pub time: f64,
    /// Files of one instant differ by part: 0 for the grid, 1 for particles, for example.
    pub part: u32,
    /// Path relative to the `.pvd`, with forward slashes.
    pub file: String,
}

/// A `.pvd` collection that is rewritten, whole, after each frame: ParaView can open it while the run goes on.
#[derive(Debug)]
pub struct Series {
    path: PathBuf,
    entries: Vec<SeriesEntry>,
}

impl Series {
    /// A new, empty series; nothing is written before the first [`push`](Self::push).
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), entries: vec![] }
    }

    /// Takes up the series in `path` to continue a run from time `from`: entries after it are forgotten, those
    /// at or before it stay. A missing file is an empty series.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] if the file is not a series, [`OutputError::Io`] if it cannot be read.
    pub fn resume(path: impl Into<PathBuf>, from: f64) -> Result<Self, OutputError> {
        let path = path.into();
        let mut entries = if path.exists() { read_series(&path)? } else { vec![] };
        entries.retain(|e| e.time <= from);
        Ok(Self { path, entries })
    }

    /// Adds a file and rewrites the collection. `file` lies in the folder of the `.pvd` or below it.
    ///
    /// # Errors
    /// [`OutputError::Request`] if time runs backwards, an instant already has this part or `file` lies elsewhere;
    /// [`OutputError::Io`] while writing. After an error the series is as before.
    pub fn push(&mut self, time: f64, part: u32, file: &Path) -> Result<(), OutputError> {
        let what = || format!("series {}", self.path.display());
        if !time.is_finite() || self.entries.last().is_some_and(|last| time < last.time) {
            let last = self.entries.last().map_or(f64::NEG_INFINITY, |e| e.time);
            return Err(OutputError::request(what(), format!("time {time} does not follow {last}")));
        }
        if self.entries.iter().rev().take_while(|e| e.time == time).any(|e| e.part == part) {
            return Err(OutputError::request(what(), format!("time {time} already has a part {part}")));
        }
        let file = self.relative(file).ok_or_else(|| {
            let reason = format!("{} is not below the folder of the series", file.display());
            OutputError::request(what(), reason)
        })?;
        self.entries.push(SeriesEntry { time, part, file });
        let written = write_text(&self.path, &self.xml());
        if written.is_err() {
            self.entries.pop();
        }
        written
    }

    /// The files so far.
    pub fn entries(&self) -> &[SeriesEntry] {
        &self.entries
    }

    fn relative(&self, file: &Path) -> Option<String> {
        let folder = folder_of(&self.path);
        let below = match file.strip_prefix(folder) {
            Ok(below) => below,
            Err(_) if folder == Path::new(".") => file,
            Err(_) => return None,
        };
        let mut names = vec![];
        for part in below.components() {
            match part {
                Component::Normal(name) => names.push(name.to_str()?),
                Component::CurDir => {}
                _ => return None,
            }
        }
        (!names.is_empty()).then(|| names.join("/"))
    }

    fn xml(&self) -> String {
        let mut out = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
             byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for e in &self.entries {
            out += &format!(
                "<DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n",
                number(e.time),
                e.part,
                escape(&e.file)
            );
        }
        out + "</Collection>\n</VTKFile>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_collection_is_complete_after_every_frame() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a & b.pvd");
        let mut series = Series::new(&path);
        for n in 0..3 {
            let time = 0.1 * f64::from(n);
            series.push(time, 0, &dir.path().join(format!("a & b_{n:04}.vti"))).unwrap();
            series.push(time, 1, &dir.path().join(format!("parts/b_{n:04}.vtp"))).unwrap();
            assert_eq!(read_series(&path).unwrap(), series.entries());
        }
        assert_eq!(series.entries()[4].file, "a & b_0002.vti");
        assert_eq!(series.entries()[5].file, "parts/b_0002.vtp");
        assert_eq!(series.entries()[4].time, 0.1 * 2.0);
    }

    #[test]
    fn a_refused_frame_changes_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.pvd");
        let file = dir.path().join("a.vti");
        let mut series = Series::new(&path);
        series.push(1.0, 0, &file).unwrap();
        assert!(series.push(0.5, 0, &file).is_err());
        assert!(series.push(f64::NAN, 0, &file).is_err());
        assert!(series.push(1.0, 0, &file).is_err());
        assert!(series.push(2.0, 0, Path::new("/elsewhere/a.vti")).is_err());
        assert!(series.push(2.0, 0, &dir.path().join("../a.vti")).is_err());
        assert_eq!(series.entries().len(), 1);
        assert_eq!(read_series(&path).unwrap().len(), 1);
    }

    #[test]
    fn resuming_forgets_what_comes_after_the_checkpoint() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.pvd");
        assert!(Series::resume(&path, 1.0).unwrap().entries().is_empty());
        let mut series = Series::new(&path);
        for time in [0.0, 0.5, 1.0] {
            series.push(time, 0, &dir.path().join(format!("{time}.vti"))).unwrap();
        }
        let mut again = Series::resume(&path, 0.5).unwrap();
        assert_eq!(again.entries().len(), 2);
        again.push(0.75, 0, &dir.path().join("x.vti")).unwrap();
        std::fs::write(&path, "not xml").unwrap();
        assert!(Series::resume(&path, 0.5).is_err());
    }

    #[test]
    fn bare_names_mean_the_current_folder() {
        let series = Series::new("a.pvd");
        assert_eq!(series.relative(Path::new("a_0000.vti")).as_deref(), Some("a_0000.vti"));
        assert_eq!(series.relative(Path::new("./a_0000.vti")).as_deref(), Some("a_0000.vti"));
        assert_eq!(series.relative(Path::new("/a_0000.vti")), None);
    }
}
