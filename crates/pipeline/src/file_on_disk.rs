//! Mesh files on the disk, and the files beside them that they may open.

use std::{
    borrow::Cow,
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
};

use mimesh_core::{
    Error, Result, memory,
    stage::{FileInput, ReadAt},
};
use mimesh_document::{files::open_regular, limits::shortened};

/// The folders whose regular files a mesh file may open; links are resolved first.
///
/// The folder of the mesh itself is always one of them.
#[derive(Clone, Debug, Default)]
pub struct Reach(Vec<PathBuf>);

impl Reach {
    /// The folders `folders`, and those below them; a folder that does not exist counts for nothing.
    pub fn new<P: AsRef<Path>>(folders: impl IntoIterator<Item = P>) -> Self {
        Self(folders.into_iter().filter_map(|folder| fs::canonicalize(existing(folder.as_ref())).ok()).collect())
    }

    /// The file at `path` without links, which `mesh` refers to.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if there is none, [`Error::OutOfReach`] if it lies elsewhere or is no regular file.
    fn resolve(&self, mesh: &Path, path: &Path) -> Result<PathBuf> {
        let found = fs::canonicalize(path).map_err(|error| Error::read(path, error))?;
        let own = fs::canonicalize(existing(mesh.parent().unwrap_or(Path::new("")))).ok();
        let refused = |reason| Err(Error::OutOfReach { path: mesh.into(), referenced: path.into(), reason });
        if !own.iter().chain(&self.0).any(|folder| found.starts_with(folder)) {
            return refused("which lies neither under its own folder nor under that of the pipeline");
        }
        let metadata = fs::metadata(&found).map_err(|error| Error::read(path, error))?;
        if metadata.is_file() {
            Ok(found)
        } else {
            refused("which is no regular file but a folder, a pipe or a device")
        }
    }
}

/// The current folder has an empty path in places.
fn existing(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// What a byte of a file takes with the mesh that is read from it, in bytes.
const BYTES_OF_A_BYTE: u64 = 3;

/// A mesh file on the disk.
#[derive(Debug)]
pub(crate) struct FileOnDisk<'a> {
    /// The file, which may lie anywhere: whoever wrote the pipeline named it.
    pub path: PathBuf,
    /// Where files may lie that it refers to.
    pub reach: &'a Reach,
}

impl FileOnDisk<'_> {
    /// Whether the policy lets the mesh open `file`, whether it exists or not.
    pub fn may_open(&self, file: &Path) -> bool {
        !matches!(self.reach.resolve(&self.path, file), Err(Error::OutOfReach { .. }))
    }
}

impl FileInput for FileOnDisk<'_> {
    fn path(&self) -> &Path {
        &self.path
    }

    fn contents(&self) -> Result<Cow<'_, [u8]>> {
        let failed = |error| Error::read(&self.path, error);
        let mut file = open_regular(&self.path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        memory::need("the file with its mesh", length.saturating_mul(BYTES_OF_A_BYTE))?;
        let mut contents = Vec::new();
        file.read_to_end(&mut contents).map_err(failed)?;
        Ok(contents.into())
    }

    fn open(&self) -> Result<Box<dyn ReadAt>> {
        let failed = |error| Error::read(&self.path, error);
        let file = open_regular(&self.path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        Ok(Box::new(OpenFile { path: self.path.clone(), file, length }))
    }

    fn referenced(&self, reference: &str) -> Result<Vec<u8>> {
        let path = self.path_of(reference);
        let failed = |error| Error::read(&path, error);
        let found = self.reach.resolve(&self.path, &path)?;
        let mut file = fs::File::open(&found).map_err(failed)?;
        // What was opened is what may be read, even if links were changed in between.
        let now = self.reach.resolve(&self.path, &found)?;
        let metadata = file.metadata().map_err(failed)?;
        if now != found || !metadata.is_file() || !is_same(&metadata, &fs::metadata(&found).map_err(failed)?) {
            return Err(failed(io::Error::other("the file was exchanged while it was opened")));
        }
        // Images stay as they are, buffers become numbers: what of them is read is told by none, so that the more counts.
        let what = format!("the file {} beside the mesh", shortened(&found.display().to_string()));
        memory::need(what, metadata.len().saturating_mul(BYTES_OF_A_BYTE))?;
        let mut contents = Vec::new();
        file.read_to_end(&mut contents).map_err(failed)?;
        Ok(contents)
    }
}

/// A regular file that is read by parts.
#[derive(Debug)]
struct OpenFile {
    path: PathBuf,
    file: fs::File,
    length: u64,
}

impl ReadAt for OpenFile {
    fn length(&self) -> u64 {
        self.length
    }

    fn read_at(&self, offset: u64, part: &mut [u8]) -> Result<()> {
        read_exact_at(&self.file, offset, part).map_err(|error| Error::read(&self.path, error))
    }
}

/// Fills `part` from `offset` on; several threads may read one file at a time.
#[cfg(unix)]
fn read_exact_at(file: &fs::File, offset: u64, part: &mut [u8]) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, part, offset)
}

/// Fills `part` from `offset` on; several threads may read one file at a time.
#[cfg(windows)]
fn read_exact_at(file: &fs::File, mut offset: u64, mut part: &mut [u8]) -> io::Result<()> {
    while !part.is_empty() {
        let count = std::os::windows::fs::FileExt::seek_read(file, part, offset)?;
        if count == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        part = &mut part[count..];
        offset += count as u64;
    }
    Ok(())
}

/// Whether both are of one file, as far as the system tells.
fn is_same(a: &fs::Metadata, b: &fs::Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        (a.dev(), a.ino()) == (b.dev(), b.ino())
    }
    #[cfg(not(unix))]
    {
        a.len() == b.len()
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::stage::BytesInput;

    use super::*;

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_before_they_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.obj");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reach = Reach::default();
        for (path, kind) in [(pipe, "a pipe"), ("/dev/zero".into(), "a device")] {
            let file = FileOnDisk { path, reach: &reach };
            for error in [file.contents().map(|_| ()).unwrap_err(), file.open().map(|_| ()).unwrap_err()] {
                assert!(error.to_string().contains(kind), "{error}");
            }
        }
    }

    #[test]
    fn a_file_that_is_read_by_parts_gives_its_bytes_and_an_error_beyond_its_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        fs::write(&path, b"0123456789").unwrap();
        let reach = Reach::default();
        let on_disk = FileOnDisk { path: path.clone(), reach: &reach }.open().unwrap();
        let in_memory = BytesInput::new(&path, "0123456789");
        for file in [&*on_disk, &in_memory] {
            assert_eq!(file.length(), 10);
            let mut part = [0; 4];
            file.read_at(3, &mut part).unwrap();
            assert_eq!(&part, b"3456");
            for offset in [7, 10, 11, u64::MAX] {
                let message = file.read_at(offset, &mut part).unwrap_err().to_string();
                assert!(message.contains("a.bin"), "{message}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_not_read() {
        let reach = Reach::default();
        let device = FileOnDisk { path: "/dev/zero".into(), reach: &reach };
        for error in [device.contents().map(drop).unwrap_err(), device.open().map(drop).unwrap_err()] {
            assert!(error.to_string().contains("it is a device, expected a file"), "{error}");
        }
    }

    #[test]
    fn a_mesh_opens_regular_files_below_its_folder_and_the_given_ones_only() {
        let top = tempfile::tempdir().unwrap();
        let at = |name: &str| top.path().join(name);
        for folder in ["mesh/deep", "pipeline", "other"] {
            fs::create_dir_all(at(folder)).unwrap();
        }
        for file in ["mesh/a.bin", "mesh/deep/a.bin", "pipeline/a.bin", "other/a.bin"] {
            fs::write(at(file), file).unwrap();
        }
        let reach = Reach::new([at("pipeline"), at("missing")]);
        let mesh = FileOnDisk { path: at("mesh/m.gltf"), reach: &reach };
        let read = |reference: &str| mesh.referenced(reference);
        for (reference, file) in
            [("a.bin", "mesh/a.bin"), ("deep/a.bin", "mesh/deep/a.bin"), ("../pipeline/a.bin", "pipeline/a.bin")]
        {
            assert_eq!(read(reference).unwrap(), file.as_bytes());
        }
        let message = |reference: &str| read(reference).unwrap_err().to_string();
        assert!(message("../other/a.bin").contains("lies neither under"), "{}", message("../other/a.bin"));
        assert!(message("/etc/passwd").contains("lies neither under"), "{}", message("/etc/passwd"));
        assert!(message("deep").contains("no regular file"), "{}", message("deep"));
        assert!(message("none.bin").contains("cannot read"), "{}", message("none.bin"));
        let may_open = |name: &str| mesh.may_open(&mesh.path_of(name));
        assert!(may_open("a.bin") && may_open("none.bin"));
        assert!(!may_open("../other/a.bin") && !may_open("/etc/passwd") && !may_open("deep"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("other/a.bin"), at("mesh/link.bin")).unwrap();
            assert!(message("link.bin").contains("lies neither under"), "{}", message("link.bin"));
            let wide = Reach::new([at("other")]);
            let mesh = FileOnDisk { path: at("mesh/m.gltf"), reach: &wide };
            assert_eq!(mesh.referenced("link.bin").unwrap(), b"other/a.bin");
        }
    }
}
