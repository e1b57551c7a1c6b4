//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::OutputError;

/// The buffered sink that [`write_atomic`] hands to its closure.
pub type Sink = BufWriter<File>;

/// Writes `path` through a temporary file in the same folder: fill, flush, sync, rename.
///
/// The folder is created if missing. Readers see either the former file or the complete new one, also after a
/// crash or on a full disk; a failure removes the temporary file.
///
/// # Errors
/// [`OutputError::Io`] naming `path` or its folder.
pub fn write_atomic<R>(path: &Path, fill: impl FnOnce(&mut Sink) -> io::Result<R>) -> Result<R, OutputError> {
    let folder = folder_of(path);
    fs::create_dir_all(folder).map_err(|e| OutputError::io(folder, "create the folder", e))?;
    if path.file_name().is_none() {
        return Err(OutputError::io(path, "write", io::ErrorKind::IsADirectory.into()));
    }
    let (file, temporary) =
        named_temporary(folder).map_err(|e| OutputError::io(path, "start writing", e))?.into_parts();
    let mut sink = BufWriter::with_capacity(1 << 18, file);
    let filled = fill(&mut sink).map_err(|e| OutputError::io(path, "write", e))?;
    let file = sink.into_inner().map_err(|e| OutputError::io(path, "write", e.into_error()))?;
    file.sync_all().map_err(|e| OutputError::io(path, "write to disk", e))?;
    drop(file);
    temporary.persist(path).map_err(|e| OutputError::io(path, "put in place", e.error))?;
    // The rename itself is durable only once the folder is; some file systems cannot sync a folder, and
    // the file is in place either way, so this one result is not an error.
    let _ = File::open(folder).and_then(|f| f.sync_all());
    Ok(filled)
}

/// [`write_atomic`] for text at hand.
///
/// # Errors
/// As [`write_atomic`].
pub fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    write_atomic(path, |sink| sink.write_all(text.as_bytes()))
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn named_temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".writing-").suffix(".tmp");
    // Temporary files are private by default; a result should have the permissions the user's umask gives.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn creates_the_folder_and_replaces_the_whole_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a/b/c.txt");
        write_text(&path, "a long first version").unwrap();
        write_text(&path, "short").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "short");
    }

    #[test]
    fn a_failed_write_leaves_the_former_file_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("c.txt");
        write_text(&path, "former").unwrap();
        let failed = write_atomic(&path, |sink| {
            sink.write_all(b"half of the ne")?;
            Err::<(), _>(io::ErrorKind::StorageFull.into())
        });
        assert!(failed.unwrap_err().to_string().contains("c.txt"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "former");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_in_place_of_the_folder_is_named() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("out"), "a file").unwrap();
        let error = write_text(&dir.path().join("out/x.txt"), "x").unwrap_err();
        assert!(error.is_io() && error.to_string().contains("out"), "{error}");
    }

    #[test]
    fn a_folder_in_place_of_the_file_is_named() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("x.txt")).unwrap();
        let error = write_text(&dir.path().join("x.txt"), "x").unwrap_err();
        assert!(error.to_string().contains("x.txt"), "{error}");
        assert!(write_text(Path::new("/"), "x").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn others_may_read_the_result() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let (ours, plain) = (dir.path().join("a"), dir.path().join("b"));
        write_text(&ours, "x").unwrap();
        fs::write(&plain, "x").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
