//! hypre's conjugate gradients with a PFMG cycle: a C program that is compiled here and run as processes.

use super::problem::Problem;
use super::solver::{self, Turn};
use crate::failure::{Exit, Failure};
use serde_json::Value;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What our tables call it.
pub const METHOD: &str = "hypre PCG+PFMG";
const SOURCE: &str = include_str!("../../../benches/peers/hypre_pfmg.c");
const PACKAGES: &str = "apt-get install libhypre-dev libopenmpi-dev openmpi-bin";
/// Where Debian has the headers; other places can be told to the compiler by CPATH and LIBRARY_PATH.
const HEADERS: &str = "-I/usr/include/hypre";
/// As many processes as asked for, whoever asks and on however few cores.
const OPEN_MPI: [(&str, &str); 5] = [
    ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
    ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
    ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
    ("PRTE_ALLOW_RUN_AS_ROOT", "1"),
    ("PRTE_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
];

/// The compiled program.
pub struct Hypre {
    program: PathBuf,
}

/// Why there is none: a reason, and what to install.
#[derive(Debug)]
pub struct Missing(pub String);

impl Hypre {
    /// Compiles it into `folder`. Where compiler, library or `mpirun` are missing, says what to install.
    pub fn build(compiler: &Path, folder: &Path) -> Result<Result<Self, Missing>, Failure> {
        std::fs::create_dir_all(folder).map_err(|error| Failure::io(format!("{}: {error}", folder.display())))?;
        let (source, program) = (folder.join("hypre_pfmg.c"), folder.join("hypre_pfmg"));
        cf_output::write_text(&source, SOURCE)?;
        let missing = |why: String| Ok(Err(Missing(format!("hypre: {why}; {PACKAGES}"))));
        // A compiler that makes nothing must not leave that of another day.
        match std::fs::remove_file(&program) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(Failure::io(format!("{}: {error}", program.display())));
            }
            _ => {}
        }
        let mut compile = Command::new(compiler);
        compile.args(["-O2", HEADERS]).arg(&source).arg("-o").arg(&program).args(["-lHYPRE", "-lm"]);
        match compile.output() {
            Err(error) => return missing(format!("{} does not start ({error})", compiler.display())),
            Ok(done) if !done.status.success() => return missing(format!("does not compile ({})", complaint(&done))),
            Ok(_) if !program.is_file() => return missing(format!("{} made no program", compiler.display())),
            Ok(_) => {}
        }
        match Command::new("mpirun").arg("--version").output() {
            Ok(done) if done.status.success() => Ok(Ok(Hypre { program })),
            _ => missing("mpirun does not start".into()),
        }
    }

    /// Starts as many processes as the problem has threads, and reads what they say.
    pub fn turn(&self, problem: &Problem) -> Result<Turn, Failure> {
        let (alpha, kappa) = problem.coefficients();
        let mut run = Command::new("mpirun");
        run.args(["-n", &problem.threads.to_string()]).arg(&self.program);
        run.args([problem.cells.to_string(), problem.walls.to_string()]);
        run.args([alpha.to_string(), kappa.to_string(), problem.tolerance.to_string()]);
        let done = run.envs(OPEN_MPI).output().map_err(|error| Failure::io(format!("mpirun: {error}")))?;
        let said = String::from_utf8_lossy(&done.stdout);
        match said.lines().find_map(read) {
            Some(turn) if done.status.success() => Ok(turn),
            _ => Err(Failure::Words(Exit::Failed, format!("{METHOD}: {problem}: {}", complaint(&done)))),
        }
    }
}

/// The line that matters of what a program complained about.
fn complaint(done: &Output) -> String {
    let said = String::from_utf8_lossy(&done.stderr);
    let line = said.lines().find(|line| line.contains("error") || line.contains("hypre_pfmg: "));
    line.or_else(|| said.lines().next()).map_or_else(|| done.status.to_string(), |line| line.trim().to_owned())
}

/// A turn from a line of JSON.
fn read(line: &str) -> Option<Turn> {
    let said: Value = serde_json::from_str(line).ok()?;
    let number = |key: &str| said.get(key).and_then(Value::as_f64);
    let iterations = said.get("iterations").and_then(Value::as_u64)?.try_into().ok()?;
    let seconds = number("seconds")?;
    Some(Turn {
        iterations,
        seconds,
        new_seconds: solver::newness([1, iterations], [number("first_seconds")?, seconds]),
        setup_seconds: number("setup_seconds")?,
        bytes: number("bytes")?,
        residual: number("residual")?,
        rounding: 0.0,
        norm: number("norm")?,
        plan: None,
        kernels: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::problem::{Cells, Numbers, Solids, Strength, Tolerance, Walls};

    fn folder(name: &str) -> PathBuf {
        crate::bench::peers::folder().join(name)
    }

    #[test]
    fn without_a_compiler_it_says_what_to_install() {
        let missing = Hypre::build(Path::new("no-such-compiler"), &folder("missing")).unwrap().err().unwrap();
        assert!(missing.0.starts_with("hypre: no-such-compiler does not start"), "{}", missing.0);
        assert!(missing.0.ends_with(PACKAGES), "{}", missing.0);
        let lazy = Hypre::build(Path::new("true"), &folder("missing")).unwrap().err().unwrap();
        assert!(lazy.0.starts_with("hypre: true made no program"), "{}", lazy.0);
    }

    #[test]
    fn what_it_says_is_read() {
        let line = r#"{"iterations": 5, "seconds": 2.5, "setup_seconds": 0.5, "first_seconds": 0.75, "bytes": 8,
            "residual": 1e-7, "norm": 4.0}"#;
        let turn = read(line).unwrap();
        assert_eq!((turn.iterations, turn.seconds, turn.new_seconds, turn.bytes), (5, 2.5, 0.25, 8.0));
        assert_eq!(read("mpirun was here"), None);
        assert_eq!(read(r#"{"iterations": 3}"#), None);
    }

    /// Where hypre is installed; elsewhere there is nothing to compare.
    #[test]
    fn both_solve_the_same_system_between_any_walls() {
        let Ok(hypre) = Hypre::build(Path::new("mpicc"), &folder("tests")).unwrap() else { return };
        for walls in [Walls::Closed, Walls::Valued, Walls::Periodic] {
            for (cells, strength) in [(vec![16, 16, 16], Strength::Poisson), (vec![16, 8], Strength::Kappa(10.0))] {
                let (tolerance, numbers) = (Tolerance(1e-10), Numbers::F64);
                let solids = Solids::Open;
                let problem = Problem { cells: Cells(cells), walls, solids, strength, tolerance, numbers, threads: 2 };
                let [ours, theirs] = [solver::turn(&problem, 0).unwrap(), hypre.turn(&problem).unwrap()];
                assert!((ours.norm - theirs.norm).abs() < 1e-8 * theirs.norm, "{problem}: {ours:?} {theirs:?}");
                assert!(ours.residual.max(theirs.residual) < 2e-10, "{problem}: {ours:?} {theirs:?}");
            }
        }
    }
}
