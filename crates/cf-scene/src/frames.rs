//! What a run writes: fields for ParaView at every frame; at its end pictures, an animation and a table.

use crate::cloud;
use crate::ledger::Ledger;
use crate::model::Model;
use crate::pictures::{self, Scale};
use crate::scene::Scene;
use crate::spec::{Output, Pictures};
use crate::spool::Spool;
use crate::view::View;
use cf_output::{Image, Manifest, OutputError, Series, Theme, write_animation, write_image, write_text};
use std::path::{Path, PathBuf};

/// Pictures per second of an animation.
const RATE: f64 = 8.0;

/// The files of one run.
pub(crate) struct Frames<'a> {
    scene: &'a Scene,
    folder: &'a Path,
    series: Option<Series>,
    spool: Option<Spool>,
    /// Volumes, for the clouds of all runs.
    clouds: Option<Spool>,
    view: Option<View>,
}

impl<'a> Frames<'a> {
    /// Begins, or goes on where the ledger says.
    pub fn begin(scene: &'a Scene, folder: &'a Path, ledger: &Ledger) -> Result<Self, OutputError> {
        let Output { vtk, pictures, .. } = scene.output;
        let series = folder.join(format!("{}.pvd", scene.run));
        let series = match vtk {
            true if ledger.rows.is_empty() => Some(Series::new(series)),
            true => Some(Series::resume(series, ledger.time)?),
            false => None,
        };
        let view = View::of(scene);
        let cells = view.as_ref().map_or(scene.grid.cells[0], |view| view.cells[0] * view.cells[1]);
        let spool = folder.join(format!(".{}.spool", scene.run));
        let spool = (pictures != Pictures::Off && !ledger.finished)
            .then(|| Spool::open(spool, cells, ledger.rows.len()))
            .transpose()?;
        let clouds = (scene.output.volume.is_some() && !ledger.finished)
            .then(|| cloud::spool(scene, folder, ledger.rows.len()))
            .transpose()?;
        Ok(Frames { scene, folder, series, spool, clouds, view })
    }

    fn name(&self, frame: u32, extension: &str) -> String {
        format!("{}_{frame:04}.{extension}", self.scene.run)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes the fields of a frame, whose row the ledger has as its last.
    pub fn write(&mut self, frame: u32, model: &dyn Model, ledger: &mut Ledger) -> Result<(), OutputError> {
        if self.series.is_some() {
            let name = self.name(frame, "vti");
            let path = self.path(&name);
            let record = write_image(&path, &self.image(model, ledger.time)?)?;
            ledger.records.push(record_text(record));
            if let Some(series) = &mut self.series {
                series.push(ledger.time, 0, &path)?;
            }
            ledger.files.push(name);
        }
        if let Some(spool) = &mut self.spool {
            spool.push(&last(self.view.as_ref(), model))?;
        }
        if let Some(clouds) = &mut self.clouds {
            clouds.push(&cloud::voxels(self.scene, model)?)?;
        }
        Ok(())
    }

    fn image<'m>(&self, model: &'m dyn Model, time: f64) -> Result<Image<'m>, OutputError> {
        let grid = &self.scene.grid;
        let along = |values: &[f64]| std::array::from_fn(|axis| values.get(axis).copied().unwrap_or(0.0));
        Ok(Image {
            cells: std::array::from_fn(|axis| grid.cells.get(axis).copied().unwrap_or(1)),
            origin: along(&grid.origin),
            spacing: [grid.spacing; 3],
            time,
            arrays: model.arrays(&self.scene.output.fields)?,
        })
    }

    /// Writes what needs all frames, and notes the files.
    pub fn finish(mut self, ledger: &mut Ledger) -> Result<(), OutputError> {
        let run = self.scene.run.clone();
        if self.series.is_some() {
            ledger.files.insert(0, format!("{run}.pvd"));
            let manifest = format!("{run}.manifest.json");
            write_text(&self.path(&manifest), &format!("{{\"files\": [\n{}\n]}}\n", ledger.records.join(",\n")))?;
            ledger.files.push(manifest);
        }
        if self.scene.output.table {
            let table = format!("{run}.csv");
            ledger.table()?.write(&self.path(&table))?;
            ledger.files.push(table);
        }
        if let Some(mut spool) = self.spool.take() {
            if spool.records() == ledger.rows.len() {
                self.draw(&mut spool, ledger)?;
            }
            spool.remove()?;
        }
        Ok(())
    }

    fn draw(&self, spool: &mut Spool, ledger: &mut Ledger) -> Result<(), OutputError> {
        let count = ledger.rows.len();
        let newest = spool.get(count.saturating_sub(1))?;
        let scale = Scale::of(self.scene.output.pictures, [&newest[..]].into_iter());
        let low = ledger.rows.iter().map(|row| row.min).fold(0.0, f64::min);
        let high = ledger.rows.iter().map(|row| row.max).fold(0.0, f64::max);
        let span = match self.scene.output.pictures {
            Pictures::Linear { low, high } | Pictures::Log { low, high } => [low, high],
            Pictures::Off | Pictures::Auto => pictures::span(low, high),
        };
        let mut files = Vec::new();
        let animation = format!("{}_animation.png", self.scene.run);
        write_animation(&self.path(&animation), count as u32, RATE, Theme::Light, |n| {
            let row = &ledger.rows[n as usize];
            let values = spool.get(n as usize)?;
            let picture = match &self.view {
                Some(view) => pictures::frame(self.scene, view, scale, row.time, &values)?,
                None => pictures::line(self.scene, span, row.time, &values),
            };
            let name = self.name(row.frame, "png");
            picture.write_png(&self.path(&name))?;
            files.push(name);
            Ok(picture)
        })?;
        ledger.files.append(&mut files);
        ledger.files.push(animation);
        Ok(())
    }
}

/// What pictures show of a model.
pub(crate) fn last(view: Option<&View>, model: &dyn Model) -> Vec<f64> {
    view.map_or_else(|| model.phi(), |view| model.layer(view.slice))
}

/// One record as the manifest writes it.
fn record_text(record: cf_output::FileRecord) -> String {
    let whole = Manifest { files: vec![record] }.json();
    let line = whole.lines().nth(1).unwrap_or_default();
    line.to_owned()
}
