//! Whatever the bytes: an answer or an error with a place inside the text, never a panic; and overrides that change nothing
//! change nothing.

use cf_scene::{Limits, Place, Problems, SceneFile, Set, catalog};
use proptest::prelude::*;

const LIMITS: Limits = Limits { memory: 8 << 30 };

fn unfold(bytes: &[u8], preset: Option<&str>, flag: Option<&str>) -> Result<usize, Problems> {
    let file = SceneFile::from_bytes("s.ron", bytes)?;
    let sets = flag.map(Set::parse).transpose()?;
    Ok(file.experiment(preset, sets.as_slice(), &LIMITS)?.runs.len())
}

/// Every error points into the text it is about, and reads as one line.
fn points_inside(result: &Result<usize, Problems>, bytes: &[u8]) -> Result<(), TestCaseError> {
    for error in result.iter().flat_map(|_| None).chain(result.as_ref().err().into_iter().flat_map(Problems::iter)) {
        let end = error.place.span().end;
        match &*error.place {
            Place::File { .. } => prop_assert!(end <= bytes.len(), "{error}"),
            Place::Flag { flag, .. } => prop_assert!(end <= flag.len(), "{error}"),
            Place::Preset { .. } | Place::Whole { .. } => prop_assert_eq!(end, 0),
        }
        prop_assert!(!error.to_string().contains('\n'), "{:?}", error);
    }
    Ok(())
}

fn scene_text() -> impl Strategy<Value = String> {
    prop::sample::select(catalog::SCENES).prop_map(|scene| scene.text.to_owned())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        points_inside(&unfold(&bytes, Some("draft"), None), &bytes)?;
    }

    #[test]
    fn random_punctuation(text in "[()\\[\\]{}:,.\"'#/*a-z0-9 \n\\\\+-]{0,300}") {
        points_inside(&unfold(text.as_bytes(), None, None), text.as_bytes())?;
    }

    #[test]
    fn mutated_scenes(
        text in scene_text(), at in any::<prop::sample::Index>(), length in 0usize..12,
        insert in "([()\\[\\]{}:,.\"'#/*\\\\]|[a-z]{1,4}|-?[0-9]{1,4}|NaN|Some\\(|None|\n|é|∇){0,3}",
    ) {
        let mut bytes = text.into_bytes();
        let start = at.index(bytes.len());
        let end = (start + length).min(bytes.len());
        bytes.splice(start..end, insert.into_bytes());
        points_inside(&unfold(&bytes, Some("draft"), None), &bytes)?;
    }

    #[test]
    fn moved_pieces(text in scene_text(), from in any::<prop::sample::Index>(), to in any::<prop::sample::Index>(), length in 1usize..60) {
        let mut bytes = text.into_bytes();
        let start = from.index(bytes.len());
        let piece: Vec<u8> = bytes.drain(start..(start + length).min(bytes.len())).collect();
        let place = to.index(bytes.len());
        bytes.splice(place..place, piece);
        points_inside(&unfold(&bytes, Some("draft"), None), &bytes)?;
    }

    #[test]
    fn random_flags(
        path in "(grid|sides|model|accuracy|run|output|hc_2:model)(\\.(law|k|tau|cells|low|x|medium|level|sources|until|é)|\\[[0-9]\\]){0,4}",
        value in "(-?[0-9]{1,6}(\\.[0-9]+)?(e[0-9]{1,3})?|[A-Z][a-z]{1,6}|\\(([a-z]+: )?[0-9]+\\)|[()\\[\\]{}\",:∇]{0,6}|// x|/\\* x \\*/ 1)",
    ) {
        let text = catalog::SCENES[0].text.as_bytes();
        points_inside(&unfold(text, Some("draft"), Some(&format!("{path}={value}"))), text)?;
    }

    #[test]
    fn an_override_with_the_written_value_changes_nothing(run in prop::sample::select(vec!["", "hc_2:", "hc_1:"])) {
        let scene = catalog::SCENES[0];
        let file = SceneFile::parse("s.ron", scene.text).unwrap();
        let plain = file.experiment(None, &[], &LIMITS).unwrap().runs;
        for flag in ["run.until=12.5", "model.sources[0].rate=50.0", "accuracy.precision=f64", "accuracy.level=Standard", "output.vtk=true",
                     "grid.origin=(0.0, 0.0)", "sides.x.low.far=0.0", "sides.y.high=Absorbing", "model.law.c=None"] {
            let set = Set::parse(&format!("{run}{flag}")).unwrap();
            prop_assert_eq!(&file.experiment(None, &[set], &LIMITS).unwrap().runs, &plain, "{}", flag);
        }
    }
}

/// The scanner and the RON crate must agree on what a text is: whatever the crate reads, the scanner reads.
#[test]
fn what_ron_reads_the_scanner_reads() {
    let values = [
        "1",
        "-1.5e-3",
        "0xff",
        "1_000",
        ".5",
        "+2.",
        "'x'",
        r"'\n'",
        r"'\u{1F600}'",
        r#""a\"b""#,
        r##"r#"a"b"#"##,
        "true",
        "()",
        "( )",
        "(1,)",
        "Some(1)",
        "Some ( 1 )",
        "{}",
        "{\"a\": 1,}",
        "[1, 2, ]",
        "(a: 1, b: /* c */ 2) // end",
        "A(b: C, d: [E(1, 2)])",
        "/* /* */ */ 1",
        "inf",
        "-inf",
        "NaN",
    ];
    for value in values {
        assert!(ron::from_str::<ron::Value>(value).is_ok(), "{value}");
        let message = SceneFile::parse("s.ron", value).map(drop).unwrap_err().to_string();
        let understood =
            ["a scene is a struct", "unknown key", "is not what stands here"].iter().any(|part| message.contains(part));
        assert!(understood, "{value}: {message}");
    }
}

/// Hostile sizes take no longer than honest ones.
#[test]
fn large_inputs_are_quick() {
    let start = std::time::Instant::now();
    let scene = |initial: &str, variants: &str, claims: &str| {
        format!(
            "(grid: (cells: (4, 4), extent: (1.0, 1.0)), model: Diffusion(law: (k: 1.0, tau: 1.0), initial: [{initial}]), \
             run: (until: 1.0, variants: [{variants}]), claims: [{claims}])"
        )
    };
    let deposits = "(shape: Everywhere, value: NaN),".repeat(20_000);
    let variants: String = (0..20_000).map(|i| format!("(name: \"v{i}\"),")).collect();
    let names = "\"x\",".repeat(100_000);
    let claim = format!(
        "(name: \"a\", source: Ours, kind: Must, statement: Monotone(quantity: Mass, runs: [{names}], direction: Rising))"
    );
    let overrides: String = (0..20_000).map(|i| format!("\"model.law.k{i}\": 1,")).collect();
    let many = format!("(name: \"v\", set: {{{overrides}}})");
    for text in [scene(&deposits, "", ""), scene("", &variants, ""), scene("", "", &claim), scene("", &many, "")] {
        let problems = unfold(text.as_bytes(), None, None).unwrap_err();
        assert!(problems.iter().count() <= 101);
    }
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}
