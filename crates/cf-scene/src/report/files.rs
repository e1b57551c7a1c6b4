//! Which of a run's files the page shows, and how they get into it.

use super::markup::address;
use std::path::{Component, Path};

/// The pictures of one run that the page shows.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Chosen<'a> {
    /// The last single frame.
    pub(super) last: Option<&'a str>,
    /// Frames one after the other.
    pub(super) animation: Option<&'a str>,
}

/// Picks by name: `<run>_NNNN.png`, `<run>_animation.png`; of a run in space `<run>_cloud_…`, if there are such.
pub(super) fn chosen(files: &[String]) -> Chosen<'_> {
    let clouds = files.iter().any(|file| file.ends_with("_cloud_animation.png"));
    let wanted = move |file: &&str| file.ends_with(".png") && file.contains("_cloud_") == clouds;
    let pictures = || files.iter().map(String::as_str).filter(wanted);
    let frames = pictures().filter_map(|file| Some((frame(file)?, file)));
    Chosen {
        last: frames.max_by_key(|(number, _)| *number).map(|(_, file)| file),
        animation: pictures().find(|file| file.ends_with("_animation.png")),
    }
}

/// The pictures of a list of files.
pub(super) fn pictures_of(files: &[String]) -> impl Iterator<Item = &str> {
    files.iter().map(String::as_str).filter(|file| file.ends_with(".png"))
}

fn frame(file: &str) -> Option<u64> {
    file.rsplit_once('.')?.0.rsplit_once('_')?.1.parse().ok()
}

/// A file of the run by its name relative to the folder; `None` where it would lie elsewhere or cannot be read.
pub(super) fn read(folder: &Path, file: &str) -> Option<Vec<u8>> {
    let inside = Path::new(file).components().all(|part| matches!(part, Component::Normal(_)));
    if inside { std::fs::read(folder.join(file)).ok() } else { None }
}

/// Puts pictures into the page while it stays small, and links them beyond that.
pub(super) struct Pictures<'a> {
    folder: &'a Path,
    left: usize,
}

/// All embedded pictures together, and each alone \[bytes\].
const ALL: usize = 16 << 20;
const EACH: usize = 3 << 20;

impl<'a> Pictures<'a> {
    pub(super) fn new(folder: &'a Path) -> Self {
        Pictures { folder, left: ALL }
    }

    /// The `src` of a picture; `None` if it is not there.
    pub(super) fn source(&mut self, file: &str) -> Option<String> {
        let bytes = read(self.folder, file)?;
        if bytes.len() > EACH.min(self.left) {
            return Some(address(file));
        }
        self.left -= bytes.len();
        Some(format!("data:image/png;base64,{}", base64(&bytes)))
    }
}

/// RFC 4648 with padding.
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let at = |n: usize| group.get(n).copied().map_or(0, u32::from);
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for n in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * n) & 63) as usize];
            out.push(if n <= group.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        let pairs =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in pairs {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }

    #[test]
    fn the_last_frame_is_the_one_of_the_largest_number() {
        let files = ["a_0009.png", "a_0010.png", "a_animation.png", "a.csv"].map(String::from);
        let expected = Chosen { last: Some("a_0010.png"), animation: Some("a_animation.png") };
        assert_eq!(chosen(&files), expected);
    }

    #[test]
    fn clouds_come_first() {
        let files = ["a_0010.png", "a_animation.png", "a_cloud_0010.png", "a_cloud_animation.png"].map(String::from);
        let expected = Chosen { last: Some("a_cloud_0010.png"), animation: Some("a_cloud_animation.png") };
        assert_eq!(chosen(&files), expected);
    }

    #[test]
    fn files_outside_the_folder_are_not_read() {
        for file in ["../Cargo.toml", "/etc/hostname", "a/../../b"] {
            assert_eq!(read(Path::new("."), file), None);
        }
    }
}
