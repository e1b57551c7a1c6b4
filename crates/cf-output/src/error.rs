//! What can go wrong while writing or reading files, said so that a person can act on it.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A failed output or a refused input; every variant says where, what, and what to do about it.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The file system refused: full disk, missing permission, a folder in the way.
    #[error("could not {action} {}: {source}; {}", path.display(), advice(source))]
    Io {
        /// The file or folder concerned.
        path: PathBuf,
        /// What was attempted, as a verb.
        action: &'static str,
        /// The operating system's reason.
        source: io::Error,
    },
    /// An array does not fit the storage or the grid it was given for.
    #[error("array '{array}': {reason}")]
    Array {
        /// Name of the array.
        array: String,
        /// What does not fit, with both numbers, and what to pass instead.
        reason: String,
    },
    /// A request that has no meaning, for example a time that is not a number.
    #[error("{what}: {reason}")]
    Request {
        /// The thing asked for.
        what: String,
        /// Why it was refused and what would be accepted.
        reason: String,
    },
    /// A file is damaged or is not of the kind this crate writes.
    #[error(
        "{}: {reason}; this reader takes only the files this crate writes (XML, appended raw, little endian)",
        path.display()
    )]
    Damaged {
        /// The file that was read.
        path: PathBuf,
        /// The first thing found wrong.
        reason: String,
    },
}

impl OutputError {
    pub(crate) fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        Self::Io { path: path.to_path_buf(), action, source }
    }

    pub(crate) fn array(array: &str, reason: impl Into<String>) -> Self {
        Self::Array { array: array.to_string(), reason: reason.into() }
    }

    pub(crate) fn request(what: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Request { what: what.into(), reason: reason.into() }
    }

    pub(crate) fn damaged(path: &Path, reason: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_path_buf(), reason: reason.into() }
    }

    /// True where the file system is at fault, not the data (a command may map this to its own exit code).
    pub fn is_io(&self) -> bool {
        matches!(self, Self::Io { .. })
    }
}

fn advice(source: &io::Error) -> &'static str {
    match source.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free some space or choose another output folder",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "choose an output folder you may write to"
        }
        io::ErrorKind::NotFound => "check the path",
        io::ErrorKind::AlreadyExists | io::ErrorKind::IsADirectory | io::ErrorKind::NotADirectory => {
            "a file and a folder share this name: rename one, or choose another output folder"
        }
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => "the data is at fault, not the disk",
        _ => "nothing was replaced; try again or choose another output folder",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_io_error_names_path_action_and_remedy() {
        let full = io::Error::from(io::ErrorKind::StorageFull);
        let text = OutputError::io(Path::new("out/a.vti"), "write", full).to_string();
        for part in ["out/a.vti", "write", "another output folder"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn only_file_system_errors_count_as_io() {
        assert!(OutputError::io(Path::new("a"), "open", io::ErrorKind::NotFound.into()).is_io());
        assert!(!OutputError::request("time", "not a number").is_io());
    }
}
