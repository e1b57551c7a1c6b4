//! How a command fails: the exit code, and words that say what to do.

use cf_scene::{Place, Problems, SceneError};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};
use std::io::IsTerminal;
use std::process::ExitCode;

/// What the program tells the shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// All is well.
    Fine = 0,
    /// A claim, a check or a golden failed.
    Failed = 1,
    /// The command line or the scene is wrong; nothing was written.
    BadInput = 2,
    /// The numbers went wrong: no convergence, not a number, instability.
    Numerical = 3,
    /// A file could not be read or written.
    Io = 4,
    /// Stopped on request; a checkpoint was left where one could be.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Why a command did not end well.
#[derive(Debug)]
pub enum Failure {
    /// A scene or a flag is wrong; with the scene's text, for carets.
    Scene(Box<Problems>, Option<String>),
    /// Anything else that is said in words.
    Words(Exit, String),
}

impl Failure {
    /// A claim, check or golden failed.
    pub fn failed(words: impl Into<String>) -> Self {
        Failure::Words(Exit::Failed, words.into())
    }

    /// The request makes no sense.
    pub fn usage(words: impl Into<String>) -> Self {
        Failure::Words(Exit::BadInput, words.into())
    }

    /// A file could not be read or written.
    pub fn io(words: impl Into<String>) -> Self {
        Failure::Words(Exit::Io, words.into())
    }

    /// Prints what went wrong and gives the exit code.
    pub fn report(&self) -> Exit {
        match self {
            Failure::Scene(problems, text) => {
                complain_part!("{}", describe(problems, text.as_deref(), std::io::stderr().is_terminal()));
                Exit::BadInput
            }
            Failure::Words(Exit::Interrupted, words) => {
                complain!("{words}");
                Exit::Interrupted
            }
            Failure::Words(exit, words) => {
                complain!("error: {words}");
                *exit
            }
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Failure::Scene(Box::new(error.into()), None)
    }
}

impl From<cf_output::OutputError> for Failure {
    fn from(error: cf_output::OutputError) -> Self {
        Failure::io(error.to_string())
    }
}

/// Every problem as one line that a program can read and a snippet with a caret for a person.
fn describe(problems: &Problems, text: Option<&str>, colour: bool) -> String {
    problems.iter().map(|problem| format!("error: {problem}\n{}", snippet(problem, text, colour))).collect()
}

/// The offending text with a line under it; empty where no particular text is at fault.
fn snippet(problem: &SceneError, text: Option<&str>, colour: bool) -> String {
    let (name, source) = match (&*problem.place, text) {
        (Place::File { file, .. }, Some(text)) => (file.as_str(), text),
        (Place::Flag { flag, .. }, _) => ("--set", flag.as_str()),
        _ => return String::new(),
    };
    let mut span = problem.place.span();
    if span.end > source.len() || source.len() > LARGEST_SOURCE {
        return String::new();
    }
    // Bytes that are no text stand in the source as a character of several.
    while !source.is_char_boundary(span.end) {
        span.end += 1;
    }
    let detail = &problem.detail;
    let label = match (&detail.nearest, &detail.expected) {
        (Some(name), _) => format!("did you mean `{name}`?"),
        (None, Some(expected)) => format!("expected {expected}"),
        (None, None) => detail.problem.clone(),
    };
    let diagnostic = MietteDiagnostic::new("").with_label(LabeledSpan::at(span, label));
    let report = Report::new(diagnostic).with_source_code(NamedSource::new(name, source.to_owned()));
    let theme = if colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let mut drawn = String::new();
    if GraphicalReportHandler::new_themed(theme).with_width(120).render_report(&mut drawn, report.as_ref()).is_err() {
        return String::new();
    }
    // The heading says again what the line above has said.
    let frame = drawn.lines().position(|line| line.contains('╭')).unwrap_or(0);
    drawn.lines().skip(frame).flat_map(|line| [line, "\n"]).collect()
}

/// Larger texts get no snippet.
const LARGEST_SOURCE: usize = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;
    use cf_scene::{Limits, SceneFile, Set};

    const SCENE: &str = "(\n    grid: (cells: (8, 8), extent: (1.0, 1.0)),\n    \
        model: Diffusion(law: (k: 1.0, tua: 4.0)),\n    run: (until: 1.0),\n)";

    fn caret_column(drawn: &str, row: &str) -> Option<usize> {
        let lines: Vec<&str> = drawn.lines().collect();
        let at = lines.iter().position(|line| line.contains(row))?;
        lines[at + 1].chars().position(|c| matches!(c, '─' | '┬'))
    }

    #[test]
    fn the_caret_stands_under_the_wrong_key() {
        let problems = SceneFile::parse("my.ron", SCENE).unwrap_err();
        let drawn = describe(&problems, Some(SCENE), false);
        assert!(drawn.starts_with("error: my.ron:3:36: model.law: unknown key `tua`"), "{drawn}");
        let row = drawn.lines().find(|line| line.contains("tua: 4.0") && !line.starts_with("error")).unwrap();
        let column = row.find("tua").map(|byte| row[..byte].chars().count());
        assert_eq!(caret_column(&drawn, "(k: 1.0, tua"), column, "{drawn}");
        assert!(drawn.contains("did you mean `tau`?"), "{drawn}");
    }

    #[test]
    fn an_error_from_a_flag_points_at_the_flag() {
        let sound = SCENE.replace("tua", "tau");
        let flag = "model.law.tau=-4";
        let sets = [Set::parse(flag).unwrap()];
        let problems = SceneFile::parse("my.ron", &sound).unwrap().experiment(None, &sets, &Limits { memory: 1 << 30 });
        let drawn = describe(&problems.unwrap_err(), Some(&sound), false);
        assert!(drawn.starts_with("error: --set model.law.tau=-4: "), "{drawn}");
        let row = drawn.lines().find(|line| line.contains(" 1 │ ")).unwrap();
        let column = row.find("-4").map(|byte| row[..byte].chars().count());
        assert_eq!(caret_column(&drawn, " 1 │ model.law.tau"), column, "{drawn}");
    }
}
