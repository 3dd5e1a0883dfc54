//! The meshes and clicks as the program reads them.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
    stage::TransferPair,
};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Files in a private folder, which is removed with them.
#[derive(Debug)]
pub struct Files {
    folder: TempDir,
}

/// The placeholders of arguments, with the files that they stand for.
const PLACEHOLDERS: [(&str, &str); 3] =
    [("{source}", "source.obj"), ("{target}", "target.obj"), ("{clicks}", "clicks.json")];

impl Files {
    /// Writes both surfaces as OBJ, with the vertices that answers count, and the clicks as JSON in the form of an answer.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the temporary folder cannot be written.
    pub fn write(pair: TransferPair<'_>) -> Result<Self> {
        let folder = tempfile::Builder::new().prefix("mimesh-").tempdir();
        let folder = folder.map_err(|error| Error::write(&std::env::temp_dir(), error))?;
        let files = Self { folder };
        files.put("source.obj", &obj(pair.source))?;
        files.put("target.obj", &obj(pair.target))?;
        let click = |marker: &mimesh_core::stage::Marker| {
            json!({
                "name": marker.name, "source": point(marker.source), "target": point(marker.target), "confidence": 1.0,
            })
        };
        let clicks: Vec<Value> = pair.markers.iter().map(click).collect();
        files.put("clicks.json", &json!({ "pairs": clicks }).to_string())?;
        Ok(files)
    }

    /// The arguments with files in place of placeholders; source and target behind them where there are none.
    pub fn arguments(&self, given: &[String]) -> Vec<String> {
        let path = |name: &str| self.path(name).to_string_lossy().into_owned();
        let fill = |argument: &String| {
            let with = |text: String, (mark, name): (&str, &str)| text.replace(mark, &path(name));
            PLACEHOLDERS.into_iter().fold(argument.clone(), with)
        };
        let mut arguments: Vec<String> = given.iter().map(fill).collect();
        if arguments == given {
            arguments.extend([path("source.obj"), path("target.obj")]);
        }
        arguments
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn put(&self, name: &str, text: &str) -> Result<()> {
        let path: &Path = &self.path(name);
        fs::write(path, text).map_err(|error| Error::write(path, error))
    }
}

/// The surface as OBJ, with the shortest numbers that are read back as the same.
fn obj(surface: &Surface) -> String {
    let mut text = String::new();
    for p in &surface.positions {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for [a, b, c] in surface.triangles.iter().map(|triangle| triangle.map(|v| v + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

fn point(point: SurfacePoint) -> Value {
    match point {
        SurfacePoint::Vertex(vertex) => vertex.into(),
        SurfacePoint::Triangle(triangle, barycentric) => json!({ "triangle": triangle, "barycentric": barycentric }),
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn arguments_name_the_files() {
        let mesh = meshes::tetrahedron();
        let pair = TransferPair { source: &mesh, target: &mesh, markers: &[], proximity: None };
        let files = Files::write(pair).unwrap();
        let path = |name: &str| files.path(name).to_string_lossy().into_owned();
        let given = |list: &[&str]| list.iter().map(|argument| (*argument).to_owned()).collect::<Vec<_>>();
        assert_eq!(files.arguments(&given(&["-x"])), given(&["-x", &path("source.obj"), &path("target.obj")]));
        assert_eq!(
            files.arguments(&given(&["--to={target}", "$(rm)"])),
            given(&[&format!("--to={}", path("target.obj")), "$(rm)"])
        );
        let text = fs::read_to_string(files.path("source.obj")).unwrap();
        assert_eq!(text.lines().filter(|line| line.starts_with("v ")).count(), 4);
        let folder = files.folder.path().to_path_buf();
        drop(files);
        assert!(!folder.exists());
    }
}
