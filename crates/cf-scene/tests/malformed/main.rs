//! Scenes and flags that are wrong, and what the user is told. Every message must say where, what and what instead.

mod flags;
mod scenes;

use cf_scene::{Limits, SceneFile, Set};
use flags::FLAGS;
use scenes::SCENES;

const BASE: &str = r#"(
    about: (title: "test", presets: {"draft": {"grid.cells": (8, 16)}}),
    grid: (cells: (16, 32), extent: (1.0, 2.0)),
    sides: (x: Walls(low: Closed, high: Closed), y: Walls(low: Open, high: Absorbing)),
    model: Diffusion(
        law: (k: 1.0, tau: 4.0),
        medium: Uniform((0.0, 0.8)),
        initial: [(shape: Everywhere, value: 0.0)],
        sources: [(shape: Ball(center: (0.5, 0.5), radius: 0.1), rate: 50.0)],
    ),
    accuracy: (level: Standard, precision: f64),
    run: (until: 1.0, frames: 4, variants: [
        (name: "slow", set: {"model.law.k": 0.25}),
        (name: "fast"),
    ]),
    output: (fields: [phi]),
    claims: [
        (name: "mass", source: Ours, kind: Must, statement: MassBudget(tolerance: 1e-12)),
        (name: "cone", source: Paper, kind: Must,
         statement: ConeAngle(run: "slow", expected: 18.2, tolerance: 1.0, source: (0.5, 0.5), rows: (0.1, 0.5))),
    ],
)"#;

const LIMITS: Limits = Limits { memory: 8 << 30 };

/// Everything the user is told about a scene, or `""`.
fn told(bytes: &[u8], preset: Option<&str>, flags: &[&str]) -> String {
    let unfold = || {
        let file = SceneFile::from_bytes("s.ron", bytes)?;
        let sets: Result<Vec<Set>, _> = flags.iter().map(|flag| Set::parse(flag)).collect();
        file.experiment(preset, &sets?, &LIMITS)
    };
    unfold().err().map(|problems| problems.to_string()).unwrap_or_default()
}

/// A scene whose text `from` is replaced by `to` is refused with a message that has all of `parts`.
fn check(kind: &str, message: &str, parts: &[&str], wrong: &mut Vec<String>) {
    if std::env::var_os("SHOW").is_some() {
        println!("{kind:24} {message}");
    }
    let missing: Vec<_> = parts.iter().filter(|part| !message.contains(**part)).collect();
    if !missing.is_empty() || parts.is_empty() {
        wrong.push(format!("{kind}: {missing:?} not in:\n    {message}"));
    }
}

#[test]
fn the_base_is_right() {
    assert_eq!(told(BASE.as_bytes(), None, &[]), "");
    assert_eq!(told(BASE.as_bytes(), Some("draft"), &["fast:model.law.k=2.0"]), "");
}

#[test]
fn malformed_scenes() {
    let mut wrong = Vec::new();
    for (kind, from, to, parts) in SCENES {
        assert_eq!(BASE.matches(from).count(), 1, "{kind}: {from:?}");
        check(kind, &told(BASE.replace(from, to).as_bytes(), None, &[]), parts, &mut wrong);
    }
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), SCENES.len(), wrong.join("\n"));
    assert!(SCENES.len() >= 60);
}

#[test]
fn malformed_flags() {
    let mut wrong = Vec::new();
    for (flag, parts) in FLAGS {
        let message = told(BASE.as_bytes(), None, &[flag]);
        check(flag, &message, parts, &mut wrong);
        check(
            flag,
            &message,
            &[&format!("--set {}", flag.chars().take(40).take_while(|c| !c.is_control()).collect::<String>())],
            &mut wrong,
        );
    }
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), FLAGS.len(), wrong.join("\n"));
}

#[test]
fn malformed_files() {
    let nested = |open: &str, close: &str| format!("{}1{}", open.repeat(100_000), close.repeat(100_000)).into_bytes();
    let files: [(&str, Vec<u8>, &[&str]); 25] = [
        ("empty", Vec::new(), &["s.ron:1:1: there is nothing here: expected a value, such as (grid:"]),
        ("blank", b" \n\t ".to_vec(), &["there is nothing here"]),
        ("comment only", b"// nothing\n/* at /* all */ */".to_vec(), &["there is nothing here"]),
        (
            "binary",
            vec![0x7f, b'E', b'L', b'F', 0, 1, 2, 0xff],
            &["s.ron:1:8: this is not text: expected UTF-8, found byte 0xff"],
        ),
        ("truncated UTF-8", b"(\n  a: \"\xe2\x82".to_vec(), &["s.ron:2:7: this is not text", "byte 0xe2"]),
        (
            "Latin-1",
            b"(\n// \xc3\xa9 \xe9\n)".to_vec(),
            &["s.ron:2:6: this is not text: expected UTF-8, found byte 0xe9"],
        ),
        ("Latin-1 after a mark", b"\xef\xbb\xbf(\xe9".to_vec(), &["s.ron:1:2: this is not text", "byte 0xe9"]),
        ("NUL", b"(\0)".to_vec(), &["s.ron:1:2: no value starts here", "\\u{0}"]),
        ("byte order mark alone", "\u{feff}".into(), &["s.ron:1:1: there is nothing here"]),
        ("two byte order marks", "\u{feff}\u{feff}()".into(), &["s.ron:1:1: no value starts here"]),
        ("byte order mark within", "(\u{feff})".into(), &["s.ron:1:2: no value starts here"]),
        ("key after a byte order mark", "\u{feff}(gird: 1)".into(), &["s.ron:1:2: unknown key `gird`", "`grid`?"]),
        ("huge", vec![b' '; 2 << 20], &["s.ron:1:1: the text has 2097152 bytes: expected at most 1048576"]),
        ("deep brackets", nested("(", ")"), &["s.ron:1:66: brackets are nested more than 64 deep"]),
        ("deep lists", nested("[", "]"), &["nested more than 64 deep"]),
        ("deep names", nested("Some(", ")"), &["nested more than 64 deep"]),
        ("deep maps", nested("{1:", "}"), &["nested more than 64 deep"]),
        ("deep, never closed", b"(".repeat(100_000), &["nested more than 64 deep"]),
        ("deep comment", [b"/*".repeat(100_000), b"()".to_vec()].concat(), &["this comment is never closed"]),
        ("many keys", many_keys(), &["s.ron:1:2: unknown key `k0`"]),
        ("list", b"[1, 2]".to_vec(), &["s.ron:1:1: a scene is a struct", "found a list"]),
        ("number", b"42".to_vec(), &["a scene is a struct", "found the number 42"]),
        ("nothing in it", b"()".to_vec(), &["s.ron:1:1: a scene is a struct", "found empty round brackets"]),
        ("another struct", BASE.replacen('(', "Fluid(", 1).into_bytes(), &["s.ron:1:1:", "Fluid"]),
        ("only closing", b")".to_vec(), &["s.ron:1:1: no value starts here: expected a value, found `)`"]),
    ];
    let mut wrong = Vec::new();
    for (kind, bytes, parts) in files {
        check(kind, &told(&bytes, None, &[]), parts, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_byte_order_mark_says_nothing() {
    assert_eq!(told(format!("\u{feff}{BASE}").as_bytes(), Some("draft"), &["fast:model.law.k=2.0"]), "");
    let wrong = told(format!("\u{feff}{}", BASE.replace("tau", "tua")).as_bytes(), None, &[]);
    assert!(wrong.starts_with("s.ron:6:23: model.law: unknown key `tua`"), "{wrong}");
}

fn many_keys() -> Vec<u8> {
    let keys: String = (0..80_000).map(|i| format!("k{i}: 1, ")).collect();
    format!("({keys})").into_bytes()
}

#[test]
fn malformed_presets() {
    let mut wrong = Vec::new();
    for (kind, table, preset, parts) in PRESETS {
        let scene = BASE.replace("{\"grid.cells\": (8, 16)}", table);
        check(kind, &told(scene.as_bytes(), Some(preset), &[]), parts, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

const PRESETS: &[(&str, &str, &str, &[&str])] = &[
    ("unknown preset", "{}", "daft", &["--preset daft: there is no preset `daft`", "did you mean `draft`?"]),
    ("preset with a line break", "{}", "a\nb", &["--preset a\\nb: there is no preset `a\\nb`"]),
    ("no preset", "{}", "", &["--preset : there is no preset ``: expected `draft` or `standard`"]),
    (
        "preset not in the table",
        "{}",
        "paper",
        &["--preset paper: there is no preset `paper`: expected `draft` or `standard`"],
    ),
    (
        "typo in a preset that is not chosen",
        "{}, \"paper\": {\"grid.cels\": (8, 16)}",
        "draft",
        &["s.ron:2:61 (preset \"paper\"): grid: unknown key `cels`", "did you mean `cells`?"],
    ),
    (
        "wrong type in a preset that is not chosen",
        "{}, \"paper\": {\"run.until\": Never}",
        "standard",
        &["s.ron:2:74 (preset \"paper\"): run.until: wrong kind of value: expected a number, found the word `Never`"],
    ),
    (
        "axis missing in a preset that is not chosen",
        "{}, \"paper\": {\"grid.cells\": (16,)}",
        "standard",
        &["s.ron:2:75 (preset \"paper\"): grid.cells: Diffusion has two or three dimensions"],
    ),
    (
        "no item in a preset that is not chosen",
        "{\"model.sources[4].rate\": 1}",
        "standard",
        &["s.ron:2:48 (preset \"draft\"): model.sources[4].rate: there is no item [4]"],
    ),
    (
        "preset of another name",
        "{}, \"drafty\": {}",
        "draft",
        &[
            "s.ron:2:51: about.presets: `drafty` is no preset: expected `draft`, `standard` or `paper`; did you mean `draft`?",
        ],
    ),
    ("preset with a path for a name", "{}, \"../x\": {}", "draft", &["s.ron:2:51: about.presets: `../x` is no preset"]),
    (
        "preset within a preset",
        "{\"about.presets\": {\"draft\": {}}}",
        "draft",
        &["s.ron:2:48 (preset \"draft\"): about.presets: an override may not"],
    ),
    ("preset twice", "{}, \"draft\": {}", "draft", &["s.ron:2:51: duplicate key `draft`"]),
    (
        "preset of a wrong type",
        "{\"grid.cells\": 3}",
        "draft",
        &["s.ron:2:62 (preset \"draft\"): grid.cells", "found the number 3"],
    ),
    (
        "preset of cells that are not cubes",
        "{\"grid.cells\": (8, 8)}",
        "draft",
        &["s.ron:2:62 (preset \"draft\"): grid.cells: the cells are not cubes"],
    ),
    (
        "preset of no section",
        "{\"gird.cells\": (8, 8)}",
        "draft",
        &["s.ron:2:48 (preset \"draft\"): gird.cells: there is no section `gird`", "did you mean `grid`?"],
    ),
    ("preset without quotes", "{grid: (8, 8)}", "draft", &["s.ron:2:48", "a string in double quotes"]),
];
