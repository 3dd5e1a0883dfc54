//! Takes a correspondence that an earlier run kept.

use std::path::{Path, PathBuf};

use mimesh_core::{
    Error, Figures, Result,
    mesh::SurfacePoint,
    register,
    stage::{Correspondence, TransferPair, TriangleMap},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

register!(Correspondence: FromFile);

/// Reads a correspondence written by `keep_correspondence:`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FromFile {
    /// The file, relative to the pipeline's.
    #[schemars(extend("x-file" = true))]
    pub path: PathBuf,
}

/// What tells the file from others.
#[derive(Deserialize)]
struct Header {
    #[serde(default)]
    format: Option<Value>,
    #[serde(default)]
    version: Option<Value>,
}

/// The contents of the file.
#[derive(Deserialize)]
struct Contents {
    source_triangles: usize,
    partners: Vec<Option<u32>>,
    #[serde(default)]
    points: Vec<Option<SurfacePoint>>,
}

#[typetag::serde(name = "from_file")]
impl Correspondence for FromFile {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        let map = read(&self.path)?;
        map.check(pair).map_err(|error| {
            let hint = "keep the correspondence of these meshes anew, with `keep_correspondence: FILE`";
            Error::file(&self.path, format!("not of these meshes: {error}"), hint)
        })?;
        Ok(map)
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        self.correspond(pair).map(drop)
    }
}

/// The way out where a file is no kept correspondence.
const MAKE_ONE: &str = "make it with `keep_correspondence: FILE` in the pipeline that computes it";

/// What is wrong with a file whose text is no JSON, or whose JSON has other values than a kept correspondence.
fn not_kept(path: &Path, error: &serde_json::Error) -> Error {
    let what = if error.is_data() { "its values are others than those of one" } else { "it is no JSON" };
    let (line, column) = (error.line().max(1), error.column());
    Error::line(path, line, format!("not a kept correspondence: {what}, at column {column}"), MAKE_ONE)
}

fn read(path: &Path) -> Result<TriangleMap> {
    let hint = MAKE_ONE;
    let metadata = std::fs::metadata(path).map_err(|error| Error::read(path, error))?;
    // A pipe may never end.
    if !metadata.is_file() && !metadata.is_dir() {
        return Err(Error::file(path, "expected a kept correspondence, found no regular file", hint));
    }
    let bytes = std::fs::read(path).map_err(|error| Error::read(path, error))?;
    // What it is counts first: another file's mistakes are its own.
    let Header { format, version } = serde_json::from_slice(&bytes).map_err(|error| not_kept(path, &error))?;
    let found = match (format.as_ref().and_then(Value::as_str), version.as_ref().and_then(Value::as_u64)) {
        (Some("mimesh-correspondence"), Some(1)) => None,
        (Some("mimesh-correspondence"), _) => {
            Some(version.map_or("no version".into(), |found| format!("version {found}")))
        }
        (Some(other), _) => Some(format!("the format `{}`", other.chars().take(40).collect::<String>())),
        (None, _) => Some("other JSON: there is no `format`".into()),
    };
    if let Some(found) = found {
        return Err(Error::file(path, format!("expected mimesh-correspondence version 1, found {found}"), hint));
    }
    let contents: Contents = serde_json::from_slice(&bytes).map_err(|error| not_kept(path, &error))?;
    Ok(TriangleMap {
        source_triangle_count: contents.source_triangles,
        triangles: contents.partners,
        points: contents.points,
        figures: Figures::default(),
    })
}
