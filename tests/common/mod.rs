//! A project in a folder of its own, and the `mimesh` binary run in it.

// Each test file uses a part of it.
#![allow(dead_code)]

use std::{
    fs,
    path::{Path, PathBuf},
    process::Output,
};

use assert_cmd::Command;
use tempfile::TempDir;

/// A folder with meshes and pipelines.
pub struct Project {
    folder: TempDir,
    /// Where results are kept, which is not to be the user's own.
    cache: TempDir,
}

/// What a command said.
pub struct Said {
    /// The exit status.
    pub status: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

/// The folder of real meshes, which are not part of this repository. Without it the caller skips, and says so; with CI=true its
/// absence is a failure.
pub fn data() -> Option<PathBuf> {
    if let Ok(folder) = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").canonicalize() {
        return Some(folder);
    }
    assert!(std::env::var("CI").as_deref() != Ok("true"), "../shared/data is missing");
    eprintln!("skipped: ../shared/data is missing");
    None
}

/// A box of eight vertices and six quads, its corners moved by `moved`.
pub fn cube(moved: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let at = |bit: i32| f64::from((corner >> bit) & 1);
        let [x, y, z] = moved([at(0), 2.0 * at(1), 3.0 * at(2)]);
        text += &format!("v {x} {y} {z}\n");
    }
    text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// A pose that leans over.
pub fn leaning(by: f64) -> String {
    cube(|[x, y, z]| [x + by * z, y, z])
}

/// A pipeline that works in a [`Project`].
pub const PIPELINE: &str = "\
source: { rest: rest.obj, poses: pose-*.obj }
target: { rest: target.obj }
correspondence: { type: identity }
transfer: { type: copy_displacement }
output: out/{pose}.obj
";

impl Project {
    /// A source with the poses 1, 2 and 10, a target, and `p.yaml` with [`PIPELINE`].
    pub fn new() -> Self {
        let folder = || tempfile::tempdir().expect("a temporary folder");
        let project = Self { folder: folder(), cache: folder() };
        project.write("rest.obj", &leaning(0.0));
        for pose in [10, 2, 1] {
            project.write(&format!("pose-{pose}.obj"), &leaning(0.1 * f64::from(pose)));
        }
        project.write("target.obj", &cube(|[x, y, z]| [2.0 * x, 2.0 * y, 2.0 * z]));
        project.write("p.yaml", PIPELINE);
        project
    }

    /// Writes a file; folders are made.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("folders");
        fs::write(path, text).expect("a file");
    }

    /// Replaces `from` in `p.yaml`.
    pub fn edit(&self, from: &str, to: &str) {
        let text = self.read("p.yaml");
        assert!(text.contains(from), "{from} is not in {text}");
        self.write("p.yaml", &text.replace(from, to));
    }

    /// The text of a file.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The folder where results are kept from run to run.
    pub fn cache(&self) -> &Path {
        self.cache.path()
    }

    /// Whether there is a file.
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

    /// `mimesh` with these arguments, in the folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("mimesh"));
        command.current_dir(self.folder.path()).env("MIMESH_CACHE", self.cache()).args(arguments);
        command
    }

    /// Runs `mimesh` with these arguments.
    pub fn mimesh(&self, arguments: &[&str]) -> Said {
        let Output { status, stdout, stderr } = self.command(arguments).output().expect("the command runs");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
        Said { status: status.code().unwrap_or(-1), out: text(stdout), err: text(stderr) }
    }
}
