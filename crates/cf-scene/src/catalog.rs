//! The scenes that come with the program, found by figure or by name.

use crate::error::{Detail, Place, SceneError, shorten};
use crate::suggest::{nearest, one_of};

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CatalogScene {
    /// The file's name without its extension.
    pub name: &'static str,
    /// The figure it belongs to, as in the paper: `3`, `A`.
    pub figure: &'static str,
    /// The RON text.
    pub text: &'static str,
}

macro_rules! catalog {
    ($($figure:literal: $name:literal),* $(,)?) => {
        /// All scenes, in the order of the figures.
        pub const SCENES: &[CatalogScene] = &[$(CatalogScene {
            name: $name,
            figure: $figure,
            text: include_str!(concat!("../../../scenes/", $name, ".ron")),
        }),*];
    };
}

catalog! {
    "3": "fig03_cones",
    "4": "fig04_fourier_share",
    "5": "fig05_ink",
    "6": "fig06_spray",
    "T2": "table2_ink",
    "A": "appendix_a_pitfall",
    "S1": "smoke_sphere",
    "S2": "ink_sinking",
}

impl CatalogScene {
    /// The file's name, for error messages.
    pub fn file(&self) -> String {
        format!("scenes/{}.ron", self.name)
    }
}

/// All scenes of a figure (`3`, `03`, `fig3`, `fig03`, `a`, `appendix a`), or the one of a name (`fig03_cones`).
pub fn find(request: &str) -> Result<Vec<&'static CatalogScene>, SceneError> {
    let wanted = request.trim().to_lowercase();
    let wanted = wanted.strip_suffix(".ron").unwrap_or(&wanted);
    let by_name: Vec<_> = SCENES.iter().filter(|scene| scene.name == wanted).collect();
    if !by_name.is_empty() {
        return Ok(by_name);
    }
    let figure = ["figure", "fig", "appendix", "app", "scene"]
        .iter()
        .find_map(|word| wanted.strip_prefix(word))
        .unwrap_or(wanted);
    // "Table 2" is T2.
    let table = wanted.strip_prefix("table").map(|number| format!("t{}", number.trim_start_matches([' ', '_', '-'])));
    let figure = table.as_deref().unwrap_or(figure).trim_start_matches(['.', '_', '-', ' ']).trim_start_matches('0');
    let found: Vec<_> = SCENES.iter().filter(|scene| scene.figure.to_lowercase() == figure).collect();
    if !found.is_empty() {
        return Ok(found);
    }
    let names = || SCENES.iter().flat_map(|scene| [scene.figure, scene.name]);
    let detail = Detail::new(format!("there is no figure or scene called `{}`", shorten(request)))
        .expected(one_of(names()))
        .nearest(nearest(wanted, names()).or_else(|| by_word(wanted)));
    Err(SceneError::new(Place::Whole { file: "scenes".to_owned() }, detail))
}

/// The scene that has a word like this in its name.
fn by_word(wanted: &str) -> Option<String> {
    let words = |scene: &'static CatalogScene| scene.name.split('_').skip(1);
    let word = nearest(wanted, SCENES.iter().flat_map(words))?;
    SCENES.iter().find(|scene| words(scene).any(|other| other == word)).map(|scene| scene.name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_goes_by_many_names() {
        for request in ["3", "03", "fig3", "Fig. 3", "fig03", "figure 3", "fig03_cones", "fig03_cones.ron"] {
            let names: Vec<_> =
                find(request).map(|found| found.iter().map(|scene| scene.name).collect()).unwrap_or_default();
            assert_eq!(names, ["fig03_cones"], "{request}");
        }
        for request in ["a", "A", "appendix a", "App. A", "appendix_a_pitfall"] {
            assert!(find(request).is_ok_and(|found| found[0].figure == "A"), "{request}");
        }
    }

    #[test]
    fn an_unknown_figure_is_refused_with_the_nearest_name() {
        let message = |request: &str| find(request).map_err(|error| error.to_string()).unwrap_err();
        assert!(message("fig03_cone").contains("did you mean `fig03_cones`?"));
        assert!(message("cnes").contains("did you mean `fig03_cones`?"));
        assert!(message("99").contains("there is no figure or scene called `99`"));
        assert!(message("").contains("expected `3`, `fig03_cones`"));
    }
}
