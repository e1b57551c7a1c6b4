//! Plots of the runs' tables over time, as SVG: one for light and one for dark surroundings.

use super::files::{base64, read};
use crate::summary::RunSummary;
use cf_output::{Curve, Plot, PlotAxis, Theme};
use std::fmt::Write;
use std::path::Path;

/// Columns worth a plot: how their names begin, and what the plot is called.
const PLOTS: [(&[&str], &str); 3] =
    [(&["mass"], "Mass in the box"), (&["outflow"], "Mass that has left"), (&["max"], "Largest value")];

/// More runs than this in one plot cannot be told apart.
const MOST_CURVES: usize = 8;

/// A table over time: column names and rows.
struct Series {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Series {
    fn parse(text: &str) -> Option<Series> {
        let mut lines = text.lines();
        let names: Vec<String> = lines.next()?.split(',').map(|name| name.trim_matches('"').to_owned()).collect();
        let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        Some(Series { names, rows: lines.map(row).collect() })
    }

    fn column(&self, starts: &[&str]) -> Option<usize> {
        self.names.iter().position(|name| starts.iter().any(|start| name.to_lowercase().starts_with(start)))
    }

    fn points(&self, y: usize) -> Option<Vec<[f64; 2]>> {
        let x = self.column(&["time", "t "])?;
        Some(self.rows.iter().filter_map(|row| Some([*row.get(x)?, *row.get(y)?])).collect())
    }
}

/// The plots of all runs, runs together.
pub(super) fn section(page: &mut String, runs: &[RunSummary], folder: &Path) {
    let series: Vec<(&RunSummary, Series)> = runs
        .iter()
        .filter_map(|run| {
            let file = run.files.iter().find(|file| file.ends_with(".csv"))?;
            Some((run, Series::parse(&String::from_utf8(read(folder, file)?).ok()?)?))
        })
        .take(MOST_CURVES)
        .collect();
    let plots: Vec<(&str, Plot)> =
        PLOTS.iter().filter_map(|(starts, title)| Some((*title, plot(&series, starts)?))).collect();
    if plots.is_empty() {
        return;
    }
    page.push_str("<section>\n<h2>Over time</h2>\n<div class=\"plots\">\n");
    for (title, plot) in plots {
        let dark = Plot { theme: Theme::Dark, ..plot.clone() };
        let _ = writeln!(
            page,
            "<figure><picture><source media=\"(prefers-color-scheme: dark)\" srcset=\"{}\"><img alt=\"{title}\" src=\"{}\">\
             </picture><figcaption>{title}</figcaption></figure>",
            source(&dark),
            source(&plot),
        );
    }
    page.push_str("</div>\n</section>\n");
}

/// The curves of one column; `None` if no run has it.
fn plot(series: &[(&RunSummary, Series)], starts: &[&str]) -> Option<Plot> {
    let mut name = None;
    let mut curves = Vec::new();
    for (run, series) in series {
        let Some(column) = series.column(starts) else { continue };
        let points = series.points(column)?;
        let measured = points.iter().filter(|p| p.iter().all(|v| v.is_finite())).count();
        if measured > 1 {
            name.get_or_insert_with(|| series.names[column].clone());
            curves.push(Curve::new(run.label.clone(), points));
        }
    }
    let axis = |name: String| PlotAxis { name, ..PlotAxis::default() };
    Some(Plot { x: axis("t [s]".into()), y: axis(name?), curves, size: [620, 420], ..Plot::default() })
}

/// A plot as an address. An image of its own keeps the names inside one SVG apart from those of the others.
fn source(plot: &Plot) -> String {
    format!("data:image/svg+xml;base64,{}", base64(plot.svg().as_bytes()))
}
