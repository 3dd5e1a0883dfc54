//! Real meshes and programs that a test needs and the repository does not hold.

use std::{
    borrow::Cow,
    env, fs,
    io::{Write, stderr},
    path::{Path, PathBuf},
    thread,
};

use crate::{
    Error, Result,
    mesh::MeshSequence,
    plugin,
    stage::{FileInput, Format, Selection},
};

/// The file or folder `name` of the meshes in `../shared/data`, beside the repository; the whole folder if `name` is empty.
///
/// Returns `None` where it is missing, after [`missing`] has reported that: the test then returns.
///
/// # Panics
/// If it is missing and the environment has `CI=true`.
#[track_caller]
pub fn data(name: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = Path::new("../shared/data").join(name);
    let found = fs::canonicalize(root.join(&path)).ok();
    if found.is_none() {
        missing(&path.display().to_string(), "tests/DATA.md lists where it comes from");
    }
    found
}

/// The file at `path` with all files that it refers to, as tests read it.
///
/// # Panics
/// If it is missing.
#[track_caller]
pub fn input(path: impl AsRef<Path>) -> TestFile {
    let path = path.as_ref().to_path_buf();
    assert!(path.is_file(), "{} is missing", path.display());
    TestFile(path)
}

/// The mesh in the file at `path`, read by the registered format of its extension.
///
/// # Panics
/// If there is no such format, or the file cannot be read.
#[track_caller]
pub fn read_mesh(path: impl AsRef<Path>) -> MeshSequence {
    let extension = path.as_ref().extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut formats = plugin::instances::<dyn Format>().into_iter().map(|(_, format)| format);
    let format = formats.find(|format| format.extensions().contains(&extension.as_str()));
    let format = format.unwrap_or_else(|| panic!("no format reads .{extension}"));
    format.read(&input(path), &Selection::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A file on the disk that may refer to any other.
#[derive(Debug)]
pub struct TestFile(PathBuf);

impl FileInput for TestFile {
    fn path(&self) -> &Path {
        &self.0
    }

    fn contents(&self) -> Result<Cow<'_, [u8]>> {
        Ok(fs::read(&self.0).map_err(|error| Error::read(&self.0, error))?.into())
    }

    fn referenced(&self, reference: &str) -> Result<Vec<u8>> {
        let path = self.path_of(reference);
        fs::read(&path).map_err(|error| Error::read(&path, error))
    }
}

/// Reports on standard error that the calling test is skipped, why, and how to get what is missing.
///
/// # Panics
/// If the environment has `CI=true`, where no test may be skipped.
#[track_caller]
pub fn missing(what: &str, remedy: &str) {
    assert!(env::var("CI").as_deref() != Ok("true"), "{what} is missing, and CI=true allows no skipped test: {remedy}");
    let test = thread::current().name().unwrap_or("a test").to_owned();
    // Unlike `eprintln!`, this is shown for tests that pass too.
    let _ = writeln!(stderr(), "skipped {test}: {what} is missing; {remedy}");
}
