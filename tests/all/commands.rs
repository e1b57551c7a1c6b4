//! The commands as a user meets them: exit codes, files, interruption and resumption.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use tempfile::TempDir;
use xtask::{Exit, main_with};

/// A small scene with a claim that holds, and one that does not if `wrong`.
fn scene(folder: &Path, wrong: bool) -> String {
    let expected = if wrong { "low: 1e9" } else { "low: 0.0" };
    let text = format!(
        r#"(
    about: (title: "A small wake"),
    grid: (cells: (16, 32), extent: (1.0, 2.0)),
    sides: (x: Walls(low: Absorbing, high: Absorbing), y: Walls(low: Absorbing, high: Absorbing)),
    model: Diffusion(
        law: (k: 0.25, tau: 4.0),
        medium: Uniform((0.0, 0.5)),
        sources: [(shape: Ball(center: (0.5, 0.5), radius: 0.2), rate: 5.0)],
    ),
    accuracy: (precision: f64),
    run: (until: 2.0, frames: 4),
    claims: [(
        name: "there is mass", source: Ours, kind: Must,
        statement: Within(quantity: Mass, run: "main", {expected}),
    )],
)"#
    );
    let path = folder.join("small.ron");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

fn run(arguments: &[&str]) -> Exit {
    main_with(["xtask"].iter().chain(arguments), &AtomicBool::new(false))
}

/// The content of every file below a folder by name.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let read =
        |entry: fs::DirEntry| (entry.file_name().into_string().unwrap(), fs::read(entry.path()).unwrap_or_default());
    fs::read_dir(folder).map_or_else(|_| BTreeMap::new(), |all| all.map(|entry| read(entry.unwrap())).collect())
}

struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        Place { folder: tempfile::tempdir().unwrap() }
    }

    fn out(&self) -> String {
        self.folder.path().join("out").to_str().unwrap().to_owned()
    }

    fn files(&self) -> BTreeMap<String, Vec<u8>> {
        contents(&self.folder.path().join("out"))
    }
}

#[test]
fn a_run_leaves_a_report_a_summary_and_fields() {
    let place = Place::new();
    let scene = scene(place.folder.path(), false);
    assert_eq!(run(&["run", &scene, "--out", &place.out(), "--quiet"]), Exit::Fine);
    let files = place.files();
    for name in ["report.html", "summary.json", "main.pvd", "main_0004.vti", "main.csv"] {
        assert!(files.contains_key(name), "{name} is not among {:?}", files.keys());
    }
    assert!(!files.keys().any(|name| name.ends_with(".tmp")), "{:?}", files.keys());
    let page = String::from_utf8(files["report.html"].clone()).unwrap();
    assert!(page.contains("A small wake") && page.contains("there is mass"));
}

#[test]
fn a_failed_claim_is_exit_1_and_is_written_down() {
    let place = Place::new();
    let scene = scene(place.folder.path(), true);
    assert_eq!(run(&["run", &scene, "--out", &place.out(), "--quiet"]), Exit::Failed);
    let page = String::from_utf8(place.files()["report.html"].clone()).unwrap();
    assert!(page.contains("fails"));
}

#[test]
fn bad_input_is_exit_2_and_writes_nothing() {
    let place = Place::new();
    let (out, path) = (place.out(), place.folder.path());
    let good = scene(path, false);
    let text = fs::read_to_string(&good).unwrap();
    let wrong = [
        ("tau", "tua"),
        ("(16, 32)", "(16, -32)"),
        ("until: 2.0", "until: forever"),
        ("Absorbing,", "Absorbent,"),
        ("(0.0, 0.5)", "(0.0, 0.5, 0.0)"),
        ("k: 0.25", "k: 0.25, c: 7.0"),
        ("run: \"main\"", "run: \"man\""),
        (")", ""),
        ("(16, 32)", "(1000000, 2000000)"),
    ];
    for (old, new) in wrong {
        let bad = path.join("bad.ron");
        fs::write(&bad, text.replacen(old, new, 1)).unwrap();
        for command in ["run", "check"] {
            let mut line = vec![command, bad.to_str().unwrap()];
            if command == "run" {
                line.extend(["--out", &out]);
            }
            assert_eq!(run(&line), Exit::BadInput, "{command} with {new} for {old}");
        }
    }
    let lines: [&[&str]; 9] = [
        &["figure", "7", "--out", &out],
        &["figure", "77", "--out", &out],
        &["figure", "3", "--preset", "huge", "--out", &out],
        &["run", &good, "--set", "model.law.tua=4", "--out", &out],
        &["run", &good, "--set", "model.law.tau", "--out", &out],
        &["run", &good, "--threads", "0", "--out", &out],
        &["run", "no-such-file.ron", "--out", &out],
        &["fly", "--out", &out],
        &["regress", "--only", "nothing of this name"],
    ];
    for line in lines {
        assert_eq!(run(line), Exit::BadInput, "{line:?}");
    }
    assert!(!Path::new(&out).exists(), "exit 2 must write nothing");
}

#[test]
fn a_folder_that_cannot_be_is_exit_4() {
    let place = Place::new();
    let scene = scene(place.folder.path(), false);
    let file = place.folder.path().join("a file");
    fs::write(&file, "not a folder").unwrap();
    let below = file.join("out");
    assert_eq!(run(&["run", &scene, "--out", below.to_str().unwrap(), "--quiet"]), Exit::Io);
}

#[test]
fn verify_takes_the_name_of_any_corner() {
    // The last two are of diffusion; "rr" is in one name.
    for corner in ["courant", "energy", "solids", "jets", "carried", "walls", "budget", "rr"] {
        let line = ["verify", "--extremes", "--cases", "8", "--only", corner];
        assert_eq!(run(&line), Exit::Fine, "{corner}");
    }
    // Corners are drawn with --extremes only.
    assert_eq!(run(&["verify", "--only", "jets"]), Exit::BadInput);
    assert_eq!(run(&["verify", "--extremes", "--only", "jest"]), Exit::BadInput);
}

#[test]
fn questions_are_answered_with_exit_0() {
    let place = Place::new();
    let scene = scene(place.folder.path(), false);
    let lines: [&[&str]; 5] = [
        &["list"],
        &["check", "3", "--brief"],
        &["check", &scene, "--preset", "draft"],
        &["--help"],
        &["figure", "--help"],
    ];
    for line in lines {
        assert_eq!(run(line), Exit::Fine, "{line:?}");
    }
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_bits() {
    let (whole, parts) = (Place::new(), Place::new());
    let scene = scene(whole.folder.path(), false);
    assert_eq!(run(&["run", &scene, "--out", &whole.out(), "--quiet"]), Exit::Fine);
    let (stop, mut stops) = (AtomicBool::new(true), 0);
    let out = parts.out();
    let line = ["xtask", "run", &scene, "--out", &out, "--quiet", "--resume"];
    // The flag is up all the time: each start makes one step and stops. Then it is taken down.
    while stops < 5 {
        match main_with(&line[..], &stop) {
            Exit::Interrupted => stops += 1,
            other => panic!("{other:?} after {stops} stops"),
        }
    }
    assert_eq!(main_with(&line[..], &AtomicBool::new(false)), Exit::Fine);
    let (whole, parts) = (whole.files(), parts.files());
    let fields = |name: &&String| [".vti", ".pvd", ".csv"].iter().any(|end| name.ends_with(end));
    let names: Vec<&String> = whole.keys().filter(fields).collect();
    assert!(names.len() > 6, "{names:?}");
    for name in names {
        assert!(parts.get(name) == whole.get(name), "{name} differs after resuming");
    }
}
