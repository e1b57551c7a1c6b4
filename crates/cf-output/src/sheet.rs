//! Several pictures in one file: a contact sheet, or an animation.

use std::path::Path;

use crate::OutputError;
use crate::atomic::write_atomic;
use crate::canvas::Canvas;
use crate::color::Theme;
use crate::surface::{Anchor, Surface};

const GAP: usize = 12;
const CAPTION: f64 = 11.0;

/// Lays pictures out in rows from the top left, each with a caption below, and one colour bar at the right if given
/// (see [`color_bar`](crate::color_bar)).
pub fn contact_sheet(pictures: &[(Canvas, String)], columns: usize, bar: Option<&Canvas>, theme: Theme) -> Canvas {
    let columns = columns.clamp(1, pictures.len().max(1));
    let rows = pictures.len().div_ceil(columns);
    let largest = |f: fn(&Canvas) -> usize| pictures.iter().map(|(c, _)| f(c)).max().unwrap_or(1);
    let (wide, tall) = (largest(Canvas::width), largest(Canvas::height));
    let captioned = pictures.iter().any(|(_, caption)| !caption.is_empty());
    let step = [wide + GAP, tall + GAP + if captioned { CAPTION as usize + 12 } else { 0 }];
    let bar_size = bar.map_or([0, 0], |b| [b.width() + GAP, b.height() + 2 * GAP]);
    let width = GAP + columns * step[0] + bar_size[0];
    let height = (GAP + rows * step[1]).max(bar_size[1]);
    let mut sheet = Canvas::new(width, height, theme.background());
    for (n, (picture, caption)) in pictures.iter().enumerate() {
        let (x, y) = (GAP + (n % columns) * step[0], GAP + (n / columns) * step[1]);
        sheet.paste(picture, x + (wide - picture.width()) / 2, y);
        let at = [(x + wide / 2) as f64, (y + tall) as f64 + 4.0 + CAPTION];
        sheet.text(at, caption, CAPTION, theme.ink(), Anchor::Middle, false);
    }
    if let Some(bar) = bar {
        sheet.paste(bar, GAP + columns * step[0], height.saturating_sub(bar.height()) / 2);
    }
    sheet
}

/// Writes an animated PNG that loops, one frame in memory at a time. Programs that do not animate show the first frame.
///
/// `draw` is called with 0, 1, … `frames - 1`; where it fails, there is no file. All frames take the size of the first: fix the colour range
/// ([`ColorRange::Fixed`](crate::ColorRange)) so that labels, and with them sizes, stay the same.
///
/// # Errors
/// [`OutputError::Request`] for no frames or a rate outside 0.1 to 1000 per second, what `draw` returns, else as
/// [`write_atomic`].
pub fn write_animation(
    path: &Path,
    frames: u32,
    per_second: f64,
    theme: Theme,
    mut draw: impl FnMut(u32) -> Result<Canvas, OutputError>,
) -> Result<(), OutputError> {
    if frames == 0 || !(0.1..=1000.0).contains(&per_second) {
        let reason = format!("{frames} frames at {per_second} per second; give at least one, at 0.1 to 1000");
        return Err(OutputError::request("animation", reason));
    }
    let first = draw(0)?;
    let mut failure = None;
    let written = write_atomic(path, |sink| {
        let mut encoder = png::Encoder::new(sink, first.width() as u32, first.height() as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_animated(frames, 0)?;
        encoder.set_frame_delay((1000.0 / per_second).round() as u16, 1000)?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(first.pixels())?;
        for n in 1..frames {
            let mut frame = Canvas::new(first.width(), first.height(), theme.background());
            let drawn = draw(n).map_err(|error| {
                failure = Some(error);
                std::io::Error::other("a frame cannot be drawn")
            })?;
            frame.paste(&drawn, 0, 0);
            writer.write_image_data(frame.pixels())?;
        }
        Ok(writer.finish()?)
    });
    // Why a frame failed says more than that the file did.
    failure.map_or(written, Err)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(size: [usize; 2], shade: u8) -> Canvas {
        Canvas::new(size[0], size[1], [shade; 3])
    }

    #[test]
    fn pictures_fill_rows_and_the_bar_stands_right() {
        let pictures: Vec<(Canvas, String)> = (0..5).map(|n| (flat([40, 30], 10 * n), String::new())).collect();
        let bar = flat([15, 50], 200);
        let sheet = contact_sheet(&pictures, 3, Some(&bar), Theme::Light);
        assert_eq!((sheet.width(), sheet.height()), (12 + 3 * 52 + 27, 12 + 2 * 42));
        assert_eq!(sheet.get(12 + 52 + 1, 12 + 42 + 1), Some([40; 3]));
        assert_eq!(sheet.get(12 + 3 * 52 + 3, 48), Some([200; 3]));
        assert_eq!(contact_sheet(&[], 0, None, Theme::Dark).width(), 25);
    }

    #[test]
    fn an_animation_has_all_its_frames() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        write_animation(&path, 3, 10.0, Theme::Light, |n| Ok(flat([20 + n as usize, 10], 50 * n as u8))).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        for n in 0..3 {
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels[0], 50 * n);
        }
        assert!(write_animation(&path, 0, 10.0, Theme::Light, |_| Ok(flat([1, 1], 0))).is_err());
        assert!(write_animation(&path, 1, f64::NAN, Theme::Light, |_| Ok(flat([1, 1], 0))).is_err());
        let broken = dir.path().join("broken.png");
        let lost = |n| if n < 2 { Ok(flat([1, 1], 0)) } else { Err(OutputError::request("frame", "lost")) };
        let error = write_animation(&broken, 3, 10.0, Theme::Light, lost).unwrap_err();
        assert!(error.to_string().contains("lost") && !broken.exists(), "{error}");
    }
}
