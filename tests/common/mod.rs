//! A project in a folder of its own, and the `mimesh` binary run in it.

// Each test file uses a part of it.
#![allow(dead_code)]

pub mod animals;
pub mod arm;
pub mod ellipsoid;

use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
    thread,
    time::{Duration, Instant},
};

use serde_json::Value;
use tempfile::TempDir;

/// A folder with meshes and pipelines, and a cache of its own.
pub struct Project {
    folder: TempDir,
    cache: TempDir,
}

/// The exit status of a command and what it printed.
pub struct Output {
    /// The exit status; -1 after a signal.
    pub status: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Output {
    /// Standard output as JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        json(&self.stdout)
    }
}

/// Parses JSON.
#[track_caller]
pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// An OBJ of a box with eight vertices and six quads, its corners moved by `place`.
pub fn cube(place: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let bit = |k: i32| f64::from((corner >> k) & 1);
        let [x, y, z] = place([bit(0), 2.0 * bit(1), 3.0 * bit(2)]);
        text += &format!("v {x} {y} {z}\n");
    }
    text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// The box sheared along x by `amount` a unit of height.
pub fn leaning(amount: f64) -> String {
    cube(|[x, y, z]| [x + amount * z, y, z])
}

/// A pipeline that works in a [`Project`].
pub const PIPELINE: &str = "\
source: { rest: rest.obj, poses: pose-*.obj }
target: { rest: target.obj }
correspondence: { type: identity }
transfer: { type: copy_displacement }
output: out/{pose}.obj
";

/// [`PIPELINE`] with `targets`, a whole line, in place of its one target.
pub fn with_targets(targets: &str) -> String {
    PIPELINE.replace("target: { rest: target.obj }", targets).replace("out/{pose}.obj", "out/{target}/{pose}.obj")
}

/// The first line of each error of `mimesh check p.yaml` with these values of `--set`.
#[track_caller]
pub fn diagnostics(project: &Project, settings: &[&str]) -> Vec<String> {
    let mut arguments = vec!["check", "p.yaml"];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    let output = project.mimesh(&arguments);
    let lines = output.stderr.lines().filter_map(|line| line.strip_prefix("error: "));
    let found: Vec<_> = lines.map(str::to_owned).collect();
    assert_eq!(output.status == 0, found.is_empty(), "{}", output.stderr);
    found
}

/// Checks what `mimesh COMMAND p.yaml` prints on stderr, and its exit status.
#[track_caller]
pub fn assert_stderr(project: &Project, command: &str, status: i32, expected: &str) {
    let output = project.mimesh(&[command, "p.yaml"]);
    assert_eq!(output.stderr.trim_end(), expected.trim(), "\n{}", output.stderr);
    assert_eq!(output.status, status);
}

/// Checks an error against two bounds: what is required, and 1.1 times what was measured when the bound was set.
#[track_caller]
pub fn assert_at_most(what: &str, found: f64, required: f64, measured: f64) {
    println!("{what}: {found}, required {required}, measured before {measured}");
    assert!(found <= required, "{what}: {found}, required {required}");
    assert!(found <= 1.1 * measured, "{what}: {found} is more than 1.1 times {measured}, which was measured before");
}

/// Waits until `condition` holds.
///
/// # Panics
/// If that takes more than two minutes.
#[track_caller]
pub fn wait_for(what: &str, mut condition: impl FnMut() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(started.elapsed() < Duration::from_secs(120), "there was never {what}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// The files of all entries of a cache, or of a kind of them, but for temporary ones; sorted.
pub fn cache_entries(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let is_temporary = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() {
            found.extend(cache_entries(&path));
        } else if !is_temporary {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The files in `pipelines/`, sorted.
pub fn pipelines() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let mut files: Vec<_> = fs::read_dir(folder).expect("pipelines").map(|e| e.expect("an entry").path()).collect();
    // Markers lie beside the pipelines that name them.
    let is_pipeline = |name: &str| name.ends_with(".yaml") && !name.ends_with(".markers.yaml");
    files.retain(|file| is_pipeline(&file.to_string_lossy()));
    assert!(!files.is_empty());
    files.sort();
    files
}

impl Project {
    /// A source with the poses 1, 2 and 10, a target, and `p.yaml` with [`PIPELINE`].
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let cache = tempfile::tempdir().expect("a temporary folder");
        let project = Self { folder, cache };
        project.write("rest.obj", &leaning(0.0));
        for pose in [10, 2, 1] {
            project.write(&format!("pose-{pose}.obj"), &leaning(0.1 * f64::from(pose)));
        }
        project.write("target.obj", &cube(|[x, y, z]| [2.0 * x, 2.0 * y, 2.0 * z]));
        project.write("p.yaml", PIPELINE);
        project
    }

    /// Writes a file and the folders above it.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("folders");
        fs::write(path, text).expect("a file");
    }

    /// Replaces `from` in `p.yaml`.
    #[track_caller]
    pub fn edit(&self, from: &str, to: &str) {
        let text = self.read("p.yaml");
        assert!(text.contains(from), "{from} is not in {text}");
        self.write("p.yaml", &text.replace(from, to));
    }

    /// The text of a file.
    #[track_caller]
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The bytes of a file.
    #[track_caller]
    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The folder where results are cached from run to run.
    pub fn cache(&self) -> &Path {
        self.cache.path()
    }

    /// Whether there is a file or folder.
    pub fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    /// The names in a folder, sorted, hidden ones too; none if there is no folder.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).into_iter().flatten();
        let mut names: Vec<_> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// `mimesh` with these arguments, in the folder, with the cache of the project. Every test starts the binary with this.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mimesh"));
        command.current_dir(self.folder.path()).env("MIMESH_CACHE", self.cache()).args(arguments);
        command
    }

    /// Runs `mimesh` with these arguments.
    pub fn mimesh(&self, arguments: &[&str]) -> Output {
        let output = self.command(arguments).output().expect("the command runs");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
        Output { status: output.status.code().unwrap_or(-1), stdout: text(output.stdout), stderr: text(output.stderr) }
    }
}
