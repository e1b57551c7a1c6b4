//! A scene file and what it unfolds to: for a preset and a set of flags, one validated [`Scene`] per run.
//!
//! Overrides apply in the order base, preset, variant, `--set`.

use crate::check::{self, Limits, Use};
use crate::error::{Detail, Place, Problems, SceneError, shorten};
use crate::scene::Scene;
use crate::spec::{About, Claim, SECTIONS, SceneSpec};
use crate::suggest::{nearest, one_of};
use crate::text::decode::decode;
use crate::text::line_column;
use crate::text::merged::{Merged, Origin};
use crate::text::path::{Path, Step};
use crate::text::shorthand;
use crate::text::splice::{Override, Set};
use crate::text::tree::{Node, Shape};
use std::sync::Arc;

/// The sizes every scene may be asked for. A scene without a table of its own runs as written.
pub const PRESETS: [&str; 3] = ["draft", "standard", "paper"];

/// The most overrides of one preset or variant.
const MAX_OVERRIDES: usize = 1000;

/// A scene file whose text is sound and whose sections stand in order.
#[derive(Clone, Debug)]
pub struct SceneFile {
    name: String,
    text: String,
    base: Merged,
    spec: SceneSpec,
}

/// What a scene file asks for at one preset.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// What the scene shows.
    pub about: About,
    /// The preset, if one was asked for.
    pub preset: Option<String>,
    /// The runs, in the order of the file.
    pub runs: Vec<Scene>,
    /// The claims that apply at this preset.
    pub claims: Vec<Claim>,
}

impl Experiment {
    /// The run of this name.
    pub fn run(&self, name: &str) -> Option<&Scene> {
        self.runs.iter().find(|scene| scene.run == name)
    }
}

impl SceneFile {
    /// Reads a scene from bytes; `name` is what errors call it.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, Problems> {
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let (sound, rest) = bytes.split_at(error.valid_up_to());
            let found = format!("byte {:#04x}", rest.first().copied().unwrap_or(0));
            let (line, column) = line_column(&String::from_utf8_lossy(sound), sound.len());
            let span = sound.len()..(sound.len() + 1).min(bytes.len());
            let place = Place::File { file: name.to_owned(), span, line, column, via: None };
            SceneError::new(place, Detail::new("this is not text").expected("UTF-8").found(found))
        })?;
        Self::parse(name, text)
    }

    /// Reads a scene from text; `name` is what errors call it.
    pub fn parse(name: &str, text: &str) -> Result<Self, Problems> {
        let mut base = Merged::from_file(name, text)?;
        check_order(&base)?;
        shorthand::write_out(&mut base)?;
        let spec = decode(&base)?;
        if let Some(problems) = Problems::from_list(check::names(&spec, &base)) {
            return Err(problems);
        }
        let file = SceneFile { name: name.to_owned(), text: text.to_owned(), base, spec };
        file.check_presets()?;
        Ok(file)
    }

    /// Every preset is decoded, and its sizes are checked, not only the one that will be asked for.
    fn check_presets(&self) -> Result<(), Problems> {
        let sized = |preset, run| -> Result<(), Problems> {
            let mut merged = self.base.clone();
            self.preset_overrides(preset)?.iter().try_for_each(|change| change.apply(&mut merged))?;
            decode::<SceneSpec>(&merged)?;
            self.variant_overrides(run)?.iter().try_for_each(|change| change.apply(&mut merged))?;
            check::size(&decode(&merged)?, &merged)
        };
        let mut problems: Vec<SceneError> = Vec::new();
        for preset in self.presets() {
            // What is wrong as written is told when the runs are unfolded; one run speaks for all.
            let wrong = |run| {
                let found = sized(Some(preset), run).err()?;
                (found.iter().any(via_preset) || sized(None, run).is_ok()).then_some(found)
            };
            let found = (0..self.runs().count()).find_map(wrong);
            problems.extend(found.iter().flat_map(Problems::iter).cloned());
        }
        Problems::from_list(problems).map_or(Ok(()), Err)
    }

    /// What errors call the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text as it was read, for carets.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What the scene shows.
    pub fn about(&self) -> &About {
        &self.spec.about
    }

    /// The presets of the scene's own table.
    pub fn presets(&self) -> impl Iterator<Item = &str> + Clone {
        self.spec.about.presets.keys().map(String::as_str)
    }

    /// The names of the runs; one, `main`, where there are no variants.
    pub fn runs(&self) -> impl Iterator<Item = &str> + Clone {
        let alone = self.spec.run.variants.is_empty().then_some("main");
        alone.into_iter().chain(self.spec.run.variants.iter().map(|variant| variant.name.as_str()))
    }

    /// Unfolds the scene at a preset, or as written, with flags. All runs are validated; nothing is allocated for them.
    pub fn experiment(&self, preset: Option<&str>, sets: &[Set], limits: &Limits) -> Result<Experiment, Problems> {
        let mut base = self.base.clone();
        for change in self.preset_overrides(preset)? {
            change.apply(&mut base)?;
        }
        for set in sets {
            if let Some(run) = set.run.as_deref().filter(|run| !self.runs().any(|name| name == *run)) {
                return Err(set.unknown_run(run, self.runs()).into());
            }
        }
        let mut problems = Vec::new();
        let (mut runs, mut uses): (Vec<Scene>, Vec<Vec<Use>>) = (Vec::new(), Vec::new());
        for (index, name) in self.runs().enumerate() {
            match self.scene(&base, index, name, preset, sets, limits) {
                Ok((scene, given)) => {
                    runs.push(scene);
                    uses.push(given);
                }
                Err(found) => problems.extend(found.iter().cloned()),
            }
        }
        if problems.is_empty() {
            let (refused, warned) = check::idle(&uses);
            problems = refused;
            problems.extend(check::claims(&self.spec, &self.base, &runs, preset));
            warned.into_iter().for_each(|(run, warning)| runs[run].warnings.push(warning));
        }
        if let Some(problems) = Problems::from_list(problems) {
            return Err(problems);
        }
        let claims = self.spec.claims.iter().filter(|claim| claim.applies(preset)).cloned().collect();
        Ok(Experiment { about: self.spec.about.clone(), preset: preset.map(str::to_owned), runs, claims })
    }

    fn scene(
        &self,
        base: &Merged,
        index: usize,
        name: &str,
        preset: Option<&str>,
        sets: &[Set],
        limits: &Limits,
    ) -> Result<(Scene, Vec<Use>), Problems> {
        let mut merged = base.clone();
        for change in self.variant_overrides(index)? {
            change.apply(&mut merged)?;
        }
        for set in sets.iter().filter(|set| set.run.as_deref().is_none_or(|run| run == name)) {
            set.change.apply(&mut merged)?;
        }
        let spec: SceneSpec = decode(&merged)?;
        let label = spec.run.variants.get(index).and_then(|variant| variant.label.clone());
        let (mut scene, uses) = check::scene(&spec, &merged, preset, limits)?;
        scene.run = name.to_owned();
        scene.label = label.unwrap_or_else(|| name.to_owned());
        Ok((scene, uses))
    }

    fn variant_overrides(&self, index: usize) -> Result<Vec<Override>, SceneError> {
        let name = self.runs().nth(index).unwrap_or_default();
        let variant = Path(vec![Step::Key("run".into()), Step::Key("variants".into()), Step::Index(index)]);
        self.overrides_at(&variant, "set", &format!("variant {:?}", shorten(name)))
    }

    fn preset_overrides(&self, preset: Option<&str>) -> Result<Vec<Override>, SceneError> {
        let Some(preset) = preset else { return Ok(Vec::new()) };
        if !self.spec.about.presets.contains_key(preset) {
            let as_written = if self.spec.about.presets.is_empty() { &PRESETS[..] } else { &["standard"][..] };
            if as_written.contains(&preset) {
                return Ok(Vec::new());
            }
            let names = self.presets().chain(as_written.iter().copied());
            let detail = Detail::new(format!("there is no preset `{}`", shorten(preset)))
                .expected(one_of(names.clone()))
                .nearest(nearest(preset, names));
            return Err(SceneError::new(Place::Preset { name: preset.to_owned() }, detail));
        }
        let table = Path(vec![Step::Key("about".into()), Step::Key("presets".into())]);
        self.overrides_at(&table, preset, &format!("preset {:?}", shorten(preset)))
    }

    /// The overrides of a map `{path: value}` in the file, under a key of the value at `parent`.
    fn overrides_at(&self, parent: &Path, key: &str, via: &str) -> Result<Vec<Override>, SceneError> {
        let mut path = parent.clone();
        path.0.push(Step::Key(key.to_owned()));
        let via: Arc<str> = via.into();
        let entries = match self.base.tree.get(&path) {
            Some(Node { shape: Shape::Map(entries), .. }) => entries.as_slice(),
            _ => &[],
        };
        if entries.len() > MAX_OVERRIDES {
            let detail = Detail::new("too many overrides").expected(format!("at most {MAX_OVERRIDES}"));
            return Err(self.base.error(entries[0].0.span.clone(), detail.at(path.to_string())));
        }
        let one = |(key, value): &(Node, Node)| {
            let origin = |node: &Node| Origin { via: Some(via.clone()), ..self.base.origin(node.span.clone()) };
            let path_origin = origin(key);
            let Shape::Text(text) = &key.shape else {
                return Err(path_origin.error(Detail::new("no path").expected("a path in double quotes")));
            };
            let target = Path::parse(text).map_err(|detail| path_origin.error(detail.at(path.to_string())))?;
            let value_text = self.base.text[value.span.clone()].to_owned();
            Ok(Override { path: target, path_origin, value: value_text, value_origin: origin(value) })
        };
        entries.iter().map(one).collect()
    }
}

fn via_preset(error: &SceneError) -> bool {
    matches!(&*error.place, Place::File { via: Some(via), .. } if via.starts_with("preset"))
}

/// Refuses sections in another order than [`SECTIONS`].
fn check_order(base: &Merged) -> Result<(), SceneError> {
    let Shape::Fields(fields) = &base.tree.shape else {
        let detail = Detail::new("a scene is a struct").expected("(grid: …, model: …, run: …)");
        return Err(base.error(base.tree.span.clone(), detail.found(base.tree.describe(&base.text))));
    };
    let rank = |key: &str| SECTIONS.iter().position(|section| *section == key);
    let known: Vec<_> = fields.iter().filter(|field| rank(&field.key).is_some()).collect();
    for pair in known.windows(2) {
        let [earlier, later] = pair else { continue };
        if rank(&later.key) < rank(&earlier.key) {
            let detail = Detail::new(format!("section `{}` stands after `{}`", later.key, earlier.key))
                .expected(format!("the order {}", SECTIONS.join(", ")))
                .advice(format!("move `{}` up", later.key));
            return Err(base.error(later.key_span.clone(), detail));
        }
    }
    Ok(())
}
