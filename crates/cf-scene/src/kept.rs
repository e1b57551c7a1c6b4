//! Fields at the end of a run, kept until all runs are done and their claims are judged: small ones in memory, large ones on disk,
//! so that the runs of a figure need no more memory together than one of them alone.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// The most numbers of a field that stay in memory.
const MOST: usize = 1 << 20;

/// Numbers that can be had again.
#[derive(Debug)]
pub(crate) enum Kept {
    /// In memory.
    Here(Vec<f64>),
    /// That many in a file that nobody else sees; it goes when this does.
    There(Mutex<File>, usize),
}

impl Kept {
    /// Keeps `numbers`, on disk in `folder` if they are many and there is a folder.
    pub fn new(numbers: Vec<f64>, folder: Option<&Path>) -> io::Result<Self> {
        match folder {
            Some(folder) if numbers.len() > MOST => Self::on_disk(&numbers, folder),
            _ => Ok(Self::Here(numbers)),
        }
    }

    fn on_disk(numbers: &[f64], folder: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let mut file = tempfile::tempfile_in(folder)?;
        let mut bytes = Vec::new();
        for chunk in numbers.chunks(1 << 16) {
            bytes.clear();
            bytes.extend(chunk.iter().flat_map(|number| number.to_le_bytes()));
            file.write_all(&bytes)?;
        }
        Ok(Self::There(Mutex::new(file), numbers.len()))
    }

    /// The numbers, bit for bit.
    pub fn get(&self) -> io::Result<Vec<f64>> {
        match self {
            Self::Here(numbers) => Ok(numbers.clone()),
            Self::There(file, count) => {
                let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                file.seek(SeekFrom::Start(0))?;
                let (mut numbers, mut bytes) = (Vec::with_capacity(*count), vec![0; 8 << 16]);
                while numbers.len() < *count {
                    let part = &mut bytes[..8 * (count - numbers.len()).min(1 << 16)];
                    file.read_exact(part)?;
                    numbers.extend(part.as_chunks::<8>().0.iter().map(|number| f64::from_le_bytes(*number)));
                }
                Ok(numbers)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_and_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let numbers: Vec<f64> = (0..MOST + 70_001).map(|i| (i as f64).sin() / 3.0).chain([f64::NAN, -0.0]).collect();
        let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
        let there = Kept::new(numbers.clone(), Some(folder.path())).unwrap();
        assert!(matches!(there, Kept::There(..)));
        assert!(bits(&there.get().unwrap()) == bits(&numbers) && bits(&there.get().unwrap()) == bits(&numbers));
        let here = Kept::new(numbers.clone(), None).unwrap();
        assert!(matches!(here, Kept::Here(_)) && bits(&here.get().unwrap()) == bits(&numbers));
        assert!(matches!(Kept::new(vec![1.0], Some(folder.path())).unwrap(), Kept::Here(_)));
        drop(there);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(Kept::new(numbers, Some(&folder.path().join("a\0b"))).is_err());
    }
}
