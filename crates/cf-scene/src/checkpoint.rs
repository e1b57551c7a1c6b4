//! Checkpoints: the state of a run in one file, whole or not at all, refused when damaged or foreign.
//!
//! ```text
//! "CFCHKPT\0"  version u32  header length u64  header (RON)  crc32 of the header u32
//! then for each part of the header's list: its numbers, little-endian, and their crc32 u32; nothing after the last
//! ```

use crate::ledger::Ledger;
use crate::model::{Model, Values, ValuesMut};
use crate::scene::Scene;
use crc32fast::Hasher;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"CFCHKPT\0";
const VERSION: u32 = 2;
/// A longer header is damage.
const LONGEST_HEADER: u64 = 1 << 28;
/// Numbers per buffer.
const CHUNK: usize = 1 << 13;

/// Why a checkpoint was not used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// It could not be read.
    #[error("could not read the checkpoint {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is not whole.
    #[error("the checkpoint {} is damaged: {reason}; delete it to start the run again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// It belongs to another run, scene or program.
    #[error("the checkpoint {} is of another run: {reason}; use the scene and flags it was made with, or delete it", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What differs.
        reason: String,
    },
}

#[derive(Debug, Serialize, Deserialize)]
struct Header {
    run: String,
    scene: u64,
    reversed: bool,
    parts: Vec<(String, String, usize)>,
    ledger: Ledger,
}

/// The file of a run's checkpoint.
pub(crate) fn path(folder: &Path, run: &str) -> PathBuf {
    folder.join(format!("checkpoint.{run}"))
}

/// Tells scenes apart by everything that changes their numbers.
pub(crate) fn fingerprint(scene: &Scene) -> u64 {
    let schedule = (scene.schedule.until, scene.schedule.frames, scene.schedule.interval);
    let text = format!("{:?}", (&scene.grid, &scene.sides, &scene.model, &scene.numerics, schedule));
    // FNV-1a.
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Writes a checkpoint.
pub(crate) fn write(
    path: &Path,
    scene: &Scene,
    model: &dyn Model,
    ledger: &Ledger,
) -> Result<(), cf_output::OutputError> {
    let parts = model.state();
    let list = parts.iter().map(|(name, values)| match values {
        Values::F32(v) => ((*name).to_owned(), "f32".to_owned(), v.len()),
        Values::F64(v) => ((*name).to_owned(), "f64".to_owned(), v.len()),
    });
    let header = Header {
        run: scene.run.clone(),
        scene: fingerprint(scene),
        reversed: model.reversed(),
        parts: list.collect(),
        ledger: ledger.clone(),
    };
    cf_output::write_atomic(path, |sink| {
        let text = ron::to_string(&header).map_err(io::Error::other)?;
        sink.write_all(MAGIC)?;
        sink.write_all(&VERSION.to_le_bytes())?;
        sink.write_all(&(text.len() as u64).to_le_bytes())?;
        sink.write_all(text.as_bytes())?;
        sink.write_all(&crc32fast::hash(text.as_bytes()).to_le_bytes())?;
        for (_, values) in parts {
            match values {
                Values::F32(values) => put(sink, values, |v, bytes| bytes.extend(v.to_le_bytes()))?,
                Values::F64(values) => put(sink, values, |v, bytes| bytes.extend(v.to_le_bytes()))?,
            }
        }
        Ok(())
    })
}

fn put<T: Copy>(sink: &mut impl Write, values: &[T], encode: impl Fn(T, &mut Vec<u8>)) -> io::Result<()> {
    let (mut hasher, mut bytes) = (Hasher::new(), Vec::new());
    for chunk in values.chunks(CHUNK) {
        bytes.clear();
        chunk.iter().for_each(|value| encode(*value, &mut bytes));
        hasher.update(&bytes);
        sink.write_all(&bytes)?;
    }
    sink.write_all(&hasher.finalize().to_le_bytes())
}

/// Reads a checkpoint into a freshly built model and gives its ledger; `None` where there is no file. After an error the
/// model is not to be used.
pub(crate) fn read(path: &Path, scene: &Scene, model: &mut dyn Model) -> Result<Option<Ledger>, CheckpointError> {
    let unreadable = |source| CheckpointError::Read { path: path.to_owned(), source };
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(unreadable(error)),
    };
    let mut from = Reader { path, file: BufReader::with_capacity(1 << 18, file) };
    if from.bytes::<8>("its first bytes")? != *MAGIC {
        return Err(from.damaged("it does not begin as a checkpoint does"));
    }
    let version = u32::from_le_bytes(from.bytes("its version")?);
    if version != VERSION {
        return Err(from.foreign(format!("its format has version {version}, this program reads {VERSION}")));
    }
    let header = from.header()?;
    if header.run != scene.run {
        return Err(from.foreign(format!("it is of run `{}`, not `{}`", header.run, scene.run)));
    }
    if header.scene != fingerprint(scene) {
        return Err(from.foreign("the scene's numbers have changed since".to_owned()));
    }
    let mut parts = model.state_mut();
    let same = parts.len() == header.parts.len()
        && parts.iter().zip(&header.parts).all(|((name, values), (stored, kind, count))| {
            let own = match values {
                ValuesMut::F32(v) => ("f32", v.len()),
                ValuesMut::F64(v) => ("f64", v.len()),
            };
            name == stored && own == (kind.as_str(), *count)
        });
    if !same {
        return Err(from.foreign("its fields differ from those of this scene".to_owned()));
    }
    for (name, values) in &mut parts {
        match values {
            ValuesMut::F32(values) => from.take(name, values, f32::from_le_bytes)?,
            ValuesMut::F64(values) => from.take(name, values, f64::from_le_bytes)?,
        }
    }
    if from.file.read(&mut [0]).map_err(unreadable)? != 0 {
        return Err(from.damaged("something follows its end"));
    }
    model.set_reversed(header.reversed);
    Ok(Some(header.ledger))
}

struct Reader<'a> {
    path: &'a Path,
    file: BufReader<File>,
}

impl Reader<'_> {
    fn damaged(&self, reason: impl Into<String>) -> CheckpointError {
        CheckpointError::Damaged { path: self.path.to_owned(), reason: reason.into() }
    }

    fn foreign(&self, reason: String) -> CheckpointError {
        CheckpointError::Foreign { path: self.path.to_owned(), reason }
    }

    fn fill(&mut self, bytes: &mut [u8], what: &str) -> Result<(), CheckpointError> {
        self.file.read_exact(bytes).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => self.damaged(format!("it ends within {what}")),
            _ => CheckpointError::Read { path: self.path.to_owned(), source: error },
        })
    }

    fn bytes<const N: usize>(&mut self, what: &str) -> Result<[u8; N], CheckpointError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, what)?;
        Ok(bytes)
    }

    fn header(&mut self) -> Result<Header, CheckpointError> {
        let length = u64::from_le_bytes(self.bytes("the length of its header")?);
        if length > LONGEST_HEADER {
            return Err(self.damaged("its header is too long"));
        }
        let mut text = vec![0; length as usize];
        self.fill(&mut text, "its header")?;
        let sum = u32::from_le_bytes(self.bytes("the sum of its header")?);
        if sum != crc32fast::hash(&text) {
            return Err(self.damaged("the sum of its header is wrong"));
        }
        ron::de::from_bytes(&text).map_err(|error| self.damaged(format!("its header does not read: {error}")))
    }

    fn take<T: Copy, const N: usize>(
        &mut self,
        name: &str,
        values: &mut [T],
        decode: impl Fn([u8; N]) -> T,
    ) -> Result<(), CheckpointError> {
        let (mut hasher, mut bytes) = (Hasher::new(), vec![0; CHUNK * N]);
        for chunk in values.chunks_mut(CHUNK) {
            let bytes = &mut bytes[..chunk.len() * N];
            self.fill(bytes, name)?;
            hasher.update(bytes);
            for (value, number) in chunk.iter_mut().zip(bytes.as_chunks::<N>().0) {
                *value = decode(*number);
            }
        }
        let sum = u32::from_le_bytes(self.bytes(name)?);
        if sum == hasher.finalize() { Ok(()) } else { Err(self.damaged(format!("the sum of {name} is wrong"))) }
    }
}
