//! Layers of `phi` kept on disk until the colour range of all frames is known.

use cf_output::OutputError;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file of equally long records of `f32`.
#[derive(Debug)]
pub(crate) struct Spool {
    path: PathBuf,
    file: File,
    length: usize,
    records: usize,
}

impl Spool {
    /// Opens or makes a spool with `length` numbers a record, of which the first `keep` records stay.
    pub fn open(path: PathBuf, length: usize, keep: usize) -> Result<Self, OutputError> {
        let open = || {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)?;
            }
            let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path)?;
            let record = 4 * length.max(1) as u64;
            let records = (file.metadata()?.len() / record).min(keep as u64);
            file.set_len(records * record)?;
            Ok((file, records as usize))
        };
        let (file, records) = open().map_err(|error| failed(&path, "open", error))?;
        Ok(Spool { path, file, length, records })
    }

    /// How many records there are.
    pub fn records(&self) -> usize {
        self.records
    }

    /// Adds a record.
    pub fn push(&mut self, values: &[f64]) -> Result<(), OutputError> {
        let mut bytes = Vec::with_capacity(4 * self.length);
        bytes.extend(values.iter().take(self.length).flat_map(|value| (*value as f32).to_le_bytes()));
        bytes.resize(4 * self.length, 0);
        let at = self.offset(self.records);
        self.file
            .seek(SeekFrom::Start(at))
            .and_then(|_| self.file.write_all(&bytes))
            .map_err(|error| failed(&self.path, "write", error))?;
        self.records += 1;
        Ok(())
    }

    /// Reads a record.
    pub fn get(&mut self, record: usize) -> Result<Vec<f64>, OutputError> {
        let mut bytes = vec![0; 4 * self.length];
        let at = self.offset(record);
        self.file
            .seek(SeekFrom::Start(at))
            .and_then(|_| self.file.read_exact(&mut bytes))
            .map_err(|error| failed(&self.path, "read", error))?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|number| f64::from(f32::from_le_bytes(*number))).collect())
    }

    /// Removes the file.
    pub fn remove(self) -> Result<(), OutputError> {
        drop(self.file);
        std::fs::remove_file(&self.path).map_err(|error| failed(&self.path, "remove", error))
    }

    fn offset(&self, record: usize) -> u64 {
        4 * self.length as u64 * record as u64
    }
}

fn failed(path: &Path, action: &'static str, source: io::Error) -> OutputError {
    OutputError::Io { path: path.to_owned(), action, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_come_back_and_later_ones_are_forgotten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sub/a.spool");
        let mut spool = Spool::open(path.clone(), 3, 0).unwrap();
        spool.push(&[1.0, 2.0, 3.0]).unwrap();
        spool.push(&[4.0, 5.0, 6.0]).unwrap();
        assert_eq!((spool.get(1).unwrap(), spool.get(0).unwrap()), (vec![4.0, 5.0, 6.0], vec![1.0, 2.0, 3.0]));
        drop(spool);
        let mut spool = Spool::open(path.clone(), 3, 1).unwrap();
        assert_eq!(spool.records(), 1);
        spool.push(&[7.0; 3]).unwrap();
        assert_eq!(spool.get(1).unwrap(), [7.0; 3]);
        assert!(spool.get(2).is_err());
        spool.remove().unwrap();
        assert!(!path.exists());
    }
}
