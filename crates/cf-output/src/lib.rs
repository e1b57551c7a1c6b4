//! Files that a run leaves behind: fields for ParaView, tables, pictures and plots.
//!
//! A field stays where it is. An [`Array`] borrows it, in the padded storage the solvers use, and a writer asks for
//! it a stretch of a row at a time; nothing is copied whole. From there:
//!
//! * [`write_image`] and [`write_points`] write `.vti` and `.vtp`: XML with raw appended data, exact origin, spacing
//!   and time. [`Series`] collects them in a `.pvd` after each frame, [`Manifest`] records their extent and
//!   statistics, and [`read_image`], [`read_points`], [`read_series`] read them back.
//! * [`Plane::cut`] takes a 2D field or a layer of a 3D one, [`draw`] makes a picture of it,
//!   [`contact_sheet`] and [`write_animation`] put several into one file.
//! * [`Volume`] and [`render`] show a 3D field as a lit cloud of ink or smoke.
//! * [`Plot`] draws curves as PNG and SVG; [`Table`] writes CSV.
//!
//! Every file appears whole or not at all ([`write_atomic`]), every refusal is an [`OutputError`] that says what to
//! do, and no input panics. This crate knows nothing of models, scenes or clocks.
//!
//! ```
//! use cf_output::{Array, Image, Manifest, Part, Plane, Series, Slice, Style, draw, write_image};
//!
//! # fn main() -> Result<(), cf_output::OutputError> {
//! # let folder = tempfile::tempdir().unwrap();
//! # let folder = folder.path();
//! let cells = [4, 3];
//! let phi = vec![0.5_f64; 6 * 5]; // one slot of rim on every side
//! let image = Image {
//!     cells: [4, 3, 1],
//!     origin: [0.0; 3],
//!     spacing: [0.25; 3],
//!     time: 0.0,
//!     arrays: vec![Array::padded("phi", &phi, cells)?],
//! };
//! let mut series = Series::new(folder.join("run.pvd"));
//! let mut manifest = Manifest::default();
//!
//! let file = folder.join("run_0000.vti");
//! manifest.files.push(write_image(&file, &image)?);
//! manifest.write(&folder.join("run.manifest.json"))?;
//! series.push(image.time, 0, &file)?;
//!
//! let layer = Slice { axis: 2, index: 0 };
//! let plane = Plane::cut(&image.arrays[0], layer, Part::Magnitude, image.origin, 0.25)?;
//! let style = Style { title: "Concentration".into(), quantity: "φ".into(), ..Style::default() };
//! draw(&plane, &style).write_png(&folder.join("run_0000.png"))?;
//! assert_eq!(cf_output::read_image(&file)?.arrays[0].values, vec![0.5; 12]);
//! # Ok(())
//! # }
//! ```

mod appended;
mod array;
mod atomic;
mod axes;
mod bar;
mod canvas;
mod color;
mod curve;
mod error;
mod font;
mod header;
mod image;
mod inline;
mod manifest;
mod overlay;
mod padded;
mod picture;
mod plane;
mod plot;
mod points;
mod reader;
mod series;
mod sheet;
mod surface;
mod table;
mod text;
mod volume;

pub use array::{Array, Precision, Scalar, Source};
pub use atomic::{Sink, write_atomic, write_text};
pub use axes::AxisScale;
pub use bar::color_bar;
pub use canvas::{Canvas, MAX_SIDE};
pub use color::{ColorMap, ColorRange, Display, Rgb, Theme, clipped};
pub use curve::{Curve, Join, Marker};
pub use error::OutputError;
pub use image::{Image, write_image};
pub use inline::{INLINE_LIMIT, inline_points};
pub use manifest::{FileRecord, Manifest, Shape, Stats};
pub use overlay::Overlay;
pub use padded::{Faces, Padded, PaddedCells};
pub use picture::{Style, draw};
pub use plane::{Part, Plane, Slice, common_range};
pub use plot::{Plot, PlotAxis};
pub use points::{Points, write_points};
pub use reader::{ImageFile, PointsFile, ReadArray, read_image, read_points, read_series};
pub use series::{Series, SeriesEntry};
pub use sheet::{contact_sheet, write_animation};
pub use table::{Cell, Table};
pub use text::escape;
pub use volume::{Look, Material, Volume, render, smooth_mask};
