//! `report.html`: what a person looks at after a run. One page that needs nothing but itself.
//!
//! [`html`] is a pure function of a [`Summary`] and the folder the run wrote to: pictures and tables are read back from
//! there, what is missing is left out. Pictures are embedded as long as the page stays small and linked beyond that.
//!
//! ```
//! use cf_scene::{report, summary::Summary};
//!
//! let summary = Summary { scene: "wake".into(), title: "A wake, k < 1".into(), ..Summary::default() };
//! let page = report::html(&summary, std::path::Path::new("out/wake"));
//! assert!(page.starts_with("<!doctype html>") && page.contains("A wake, k &lt; 1"));
//! ```

mod files;
mod markup;
mod plots;
mod runs;

use crate::summary::{ClaimResult, RunSummary, Summary};
use cf_output::OutputError;
use files::Pictures;
use markup::{escape, link, number, seconds};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The name of the page in the output folder.
pub const FILE: &str = "report.html";

const STYLE: &str = include_str!("report/style.css");

/// Writes [`html`] to [`FILE`] in `folder`, whole or not at all, and gives its path.
///
/// # Errors
/// [`OutputError::Io`] where the folder cannot be written to.
pub fn write(summary: &Summary, folder: &Path) -> Result<PathBuf, OutputError> {
    let path = folder.join(FILE);
    cf_output::write_text(&path, &html(summary, folder))?;
    Ok(path)
}

/// The page, with pictures and tables read from `folder`.
pub fn html(summary: &Summary, folder: &Path) -> String {
    let title = if summary.title.is_empty() { &summary.scene } else { &summary.title };
    let mut page = String::new();
    let _ = write!(
        page,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n",
        escape(title)
    );
    head(&mut page, summary, title);
    warnings(&mut page, &summary.runs);
    claims(&mut page, &summary.claims);
    pictures(&mut page, summary, folder);
    plots::section(&mut page, &summary.runs, folder);
    runs::table(&mut page, &summary.runs);
    runs::details(&mut page, &summary.runs);
    foot(&mut page, summary);
    page.push_str("</main>\n</body>\n</html>\n");
    page
}

fn head(page: &mut String, summary: &Summary, title: &str) {
    let figure = summary.figure.as_deref().map_or_else(String::new, |figure| {
        let numbered = figure.starts_with(|c: char| c.is_ascii_digit());
        format!("{} {} · ", if numbered { "Figure" } else { "Appendix" }, escape(figure))
    });
    let preset = summary.preset.as_deref().map_or_else(String::new, |preset| format!(" · {}", escape(preset)));
    let _ = write!(
        page,
        "<header>\n<p class=\"kicker\">{figure}<code>{}</code>{preset}</p>\n<h1>{}</h1>\n",
        escape(&summary.scene),
        escape(title)
    );
    let must = summary.claims.iter().filter(|claim| claim.kind == "Must").count();
    let failed = summary.failures().count();
    let (class, verdict) = match (must, failed) {
        (0, _) => ("plain", "none".to_owned()),
        (_, 0) => ("good", format!("{must} of {must}")),
        _ => ("bad", format!("{} of {must}", must - failed)),
    };
    let memory = summary.runs.iter().map(|run| run.peak_memory).max().unwrap_or(0);
    let steps: u64 = summary.runs.iter().map(|run| run.steps).sum();
    page.push_str("<dl class=\"tiles\">\n");
    let mut tile = |class: &str, name: &str, value: &str| {
        let _ = writeln!(page, "<div class=\"{class}\"><dt>{name}</dt><dd>{value}</dd></div>");
    };
    let name = if must == 0 { "claims that must hold at this size" } else { "claims that must hold, do" };
    tile(class, name, &verdict);
    tile("plain", "runs", &summary.runs.len().to_string());
    tile("plain", "steps", &steps.to_string());
    tile("plain", "wall time", &seconds(summary.seconds));
    if memory > 0 {
        tile("plain", "peak memory", &markup::bytes(memory));
    }
    page.push_str("</dl>\n");
    if !summary.overrides.is_empty() {
        let flags: Vec<String> = summary.overrides.iter().map(|f| format!("<code>{}</code>", escape(f))).collect();
        let _ = writeln!(page, "<p>Changed by <code>--set</code>: {}</p>", flags.join(", "));
    }
    page.push_str("</header>\n");
}

fn warnings(page: &mut String, runs: &[RunSummary]) {
    let all: Vec<_> = runs.iter().flat_map(|run| run.warnings.iter().map(move |words| (run, words))).collect();
    if all.is_empty() {
        return;
    }
    page.push_str("<section class=\"warnings\">\n<h2>Warnings</h2>\n<ul>\n");
    for (run, words) in all {
        let _ = writeln!(page, "<li><b>{}</b>: {}</li>", escape(&run.label), escape(words));
    }
    page.push_str("</ul>\n</section>\n");
}

/// The kinds of claims, apart.
const KINDS: [(&str, &str, &str); 3] = [
    ("Must", "Claims that must hold", "A failure here makes the command fail."),
    ("Report", "Reported", "Measured for the record; nothing depends on them."),
    ("KnownFalse", "Known not to hold", "Statements that this project finds to be wrong, with the reason."),
];

fn claims(page: &mut String, claims: &[ClaimResult]) {
    for (kind, title, words) in KINDS {
        let of_kind: Vec<&ClaimResult> = claims.iter().filter(|claim| claim.kind == kind).collect();
        if of_kind.is_empty() {
            continue;
        }
        let _ = write!(
            page,
            "<section>\n<h2>{title}</h2>\n<p class=\"note\">{words}</p>\n<table class=\"claims\">\n<thead><tr>\
             <th>Claim</th><th>Expected</th><th>Measured here</th><th>Verdict</th></tr></thead>\n<tbody>\n"
        );
        of_kind.into_iter().for_each(|one| claim(page, one));
        page.push_str("</tbody>\n</table>\n</section>\n");
    }
}

fn claim(page: &mut String, claim: &ClaimResult) {
    let (class, verdict) = match (claim.kind.as_str(), claim.pass) {
        ("Must", true) => ("good", "holds"),
        ("Must", false) => ("bad", "fails"),
        ("KnownFalse", false) => ("plain", "does not hold, as known"),
        ("KnownFalse", true) => ("bad", "holds, against what is known"),
        (_, true) if claim.tolerance.is_some() => ("plain", "holds"),
        (_, true) => ("plain", "reported"),
        (_, false) => ("plain", "does not hold"),
    };
    let source = if claim.source == "Paper" { "the paper says" } else { "ours" };
    let reason = claim.reason.as_deref().map_or_else(String::new, |r| format!("<p class=\"note\">{}</p>", escape(r)));
    let _ = writeln!(
        page,
        "<tr><th scope=\"row\">{}<span class=\"source {}\">{source}</span>{reason}</th>\
         <td data-name=\"Expected\">{}</td><td data-name=\"Measured here\">{}</td>\
         <td data-name=\"Verdict\"><span class=\"verdict {class}\">{verdict}</span></td></tr>",
        escape(&claim.name),
        if claim.source == "Paper" { "paper" } else { "ours" },
        escape(&claim.expected),
        escape(&claim.measured),
    );
}

fn pictures(page: &mut String, summary: &Summary, folder: &Path) {
    let mut pictures = Pictures::new(folder);
    let together: Vec<String> = files::pictures_of(&summary.files).filter_map(|file| pictures.source(file)).collect();
    let mut each = String::new();
    for run in &summary.runs {
        let chosen = files::chosen(&run.files);
        let Some(source) = chosen.last.and_then(|file| pictures.source(file)) else { continue };
        let animation = chosen.animation.map_or_else(String::new, |file| format!(" · {}", link(file, "animation")));
        let _ = writeln!(
            each,
            "<figure><img alt=\"{0} at the end\" src=\"{source}\"><figcaption>{0}, t = {1} s{animation}</figcaption></figure>",
            escape(&run.label),
            number(run.time),
        );
    }
    if together.is_empty() && each.is_empty() {
        return;
    }
    page.push_str("<section>\n<h2>Pictures</h2>\n");
    for source in &together {
        let _ = writeln!(page, "<figure><img alt=\"all runs at the end\" src=\"{source}\"></figure>");
    }
    let gallery = format!("<div class=\"gallery\">\n{each}</div>\n");
    match (!together.is_empty(), each.is_empty()) {
        (_, true) => {}
        (true, false) => {
            let _ = writeln!(page, "<details><summary>Each run, and how it went</summary>\n{gallery}</details>");
        }
        (false, false) => page.push_str(&gallery),
    }
    page.push_str("</section>\n");
}

fn foot(page: &mut String, summary: &Summary) {
    let _ = write!(
        page,
        "<footer>\n<p>Numbers for machines are in {}. Fields open in ParaView from the <code>.pvd</code> files.</p>\n\
         <p>φ_t + ∇·(u φ) = −∇·q_C + ∇·(k_F ∇φ) + W, τ (q_C,t + ∇·(q_C ⊗ u)) + q_C = −k_C ∇φ</p>\n\
         <p>version {}</p>\n</footer>\n",
        link("summary.json", "summary.json"),
        escape(&summary.version),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(kind: &str, pass: bool) -> ClaimResult {
        ClaimResult {
            name: format!("{kind} & <so>"),
            kind: kind.into(),
            source: "Paper".into(),
            expected: "1 ± 0.1".into(),
            measured: "1.05".into(),
            pass,
            ..ClaimResult::default()
        }
    }

    fn summary() -> Summary {
        let run = RunSummary {
            name: "main".into(),
            label: "<main>".into(),
            files: vec!["main_0000.png".into(), "main_0002.png".into(), "main.csv".into()],
            warnings: vec!["k & tau".into()],
            ..RunSummary::default()
        };
        let claims = vec![claim("Must", true), claim("Report", false), claim("KnownFalse", false)];
        Summary { title: "T \"x\"".into(), runs: vec![run], claims, ..Summary::default() }
    }

    #[test]
    fn everything_from_outside_is_escaped() {
        let page = html(&summary(), Path::new("nowhere"));
        assert!(
            page.contains("&lt;main&gt;") && page.contains("Must &amp; &lt;so&gt;") && page.contains("k &amp; tau")
        );
        assert!(!page.contains("<main>:") && !page.contains("<so>"));
        assert_eq!((page.matches("<table").count(), page.matches("</table>").count()), (5, 5));
    }

    #[test]
    fn the_three_kinds_of_claims_stand_apart() {
        let page = html(&summary(), Path::new("nowhere"));
        let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("{text}"));
        assert!(at("Claims that must hold") < at("<h2>Reported"));
        assert!(at("<h2>Reported") < at("Known not to hold"));
        assert!(page.contains("does not hold, as known"));
    }

    #[test]
    fn pictures_are_embedded_and_missing_ones_left_out() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        std::fs::write(folder.path().join("main_0002.png"), b"\x89PNG")?;
        let page = html(&summary(), folder.path());
        assert!(page.contains("src=\"data:image/png;base64,iVBORw==\""));
        assert_eq!(page.matches("<img").count(), 1);
        assert!(!page.contains("http"), "the page must need nothing but itself");
        Ok(())
    }

    #[test]
    fn a_table_over_time_becomes_a_plot() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let csv = "frame,time [s],mass [P m^2],maximum [P]\n0,0,0,0\n1,0.5,1,2\n2,1,2,3\n";
        std::fs::write(folder.path().join("main.csv"), csv)?;
        let page = html(&summary(), folder.path());
        assert_eq!(page.matches("data:image/svg+xml").count(), 4, "two plots, light and dark");
        Ok(())
    }
}
