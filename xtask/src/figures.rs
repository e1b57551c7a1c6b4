//! The figures and tables of the paper, built or not.

use cf_scene::catalog::{self, CatalogScene};

/// One figure or table.
pub struct Figure {
    /// As in the paper: `3`, `A`, `T2`.
    pub number: &'static str,
    /// What it shows.
    pub shows: &'static str,
}

/// All of them, in the paper's order.
pub const FIGURES: &[Figure] = &[
    Figure { number: "1", shows: "snowfall" },
    Figure { number: "2", shows: "a hydrogel plate" },
    Figure { number: "3", shows: "cones of a point source" },
    Figure { number: "4", shows: "from cone to Fourier" },
    Figure { number: "5", shows: "ink in water" },
    Figure { number: "6", shows: "a spray of smoke" },
    Figure { number: "7", shows: "coral" },
    Figure { number: "8", shows: "snowflakes, Fourier and not" },
    Figure { number: "9", shows: "the phases of a material point step" },
    Figure { number: "10", shows: "a folding hydrogel" },
    Figure { number: "11", shows: "two equal relaxation times" },
    Figure { number: "12", shows: "a single flake" },
    Figure { number: "13", shows: "the first relaxation time" },
    Figure { number: "T2", shows: "timings" },
    Figure { number: "A", shows: "the single-field pitfall" },
    Figure { number: "S1", shows: "smoke around a ball" },
    Figure { number: "S2", shows: "a drop of heavy ink" },
];

impl Figure {
    /// Its scenes; none where it is not built yet.
    pub fn scenes(&self) -> impl Iterator<Item = &'static CatalogScene> {
        catalog::SCENES.iter().filter(|scene| scene.figure == self.number)
    }

    /// What people call it.
    pub fn title(&self) -> String {
        if let Some(number) = self.number.strip_prefix('S') {
            return format!("Scene {number}");
        }
        match self.number.strip_prefix('T') {
            Some(number) => format!("Table {number}"),
            None if self.number.chars().all(|c| c.is_ascii_digit()) => format!("Figure {}", self.number),
            None => format!("Appendix {}", self.number),
        }
    }
}

/// The figure that a request names but that has no scene yet.
pub fn unbuilt(request: &str) -> Option<&'static Figure> {
    let wanted: String = request.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
    let wanted = wanted.replace("figure", "").replace("fig", "").replace("table", "t");
    let wanted = wanted.trim_start_matches('0');
    FIGURES.iter().find(|figure| figure.number.to_lowercase() == wanted && figure.scenes().next().is_none())
}

/// The numbers that can be run.
pub fn built() -> String {
    let numbers: Vec<&str> = FIGURES.iter().filter(|f| f.scenes().next().is_some()).map(|f| f.number).collect();
    numbers.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_belongs_to_a_listed_figure() {
        for scene in catalog::SCENES {
            assert!(FIGURES.iter().any(|figure| figure.number == scene.figure), "{}", scene.name);
        }
    }

    #[test]
    fn figures_without_scenes_are_known_by_their_usual_names() {
        for request in ["7", "07", "fig7", "Figure 7", "fig. 7"] {
            assert_eq!(unbuilt(request).map(|figure| figure.number), Some("7"), "{request}");
        }
        assert!(unbuilt("table 2").is_none());
        assert!(unbuilt("3").is_none() && unbuilt("99").is_none() && unbuilt("").is_none());
    }
}
