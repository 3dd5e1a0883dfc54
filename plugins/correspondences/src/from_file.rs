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

register!(Correspondence: FromFile);

/// Reads a correspondence written by `keep_correspondence:`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FromFile {
    /// The file, relative to the pipeline's.
    #[schemars(extend("x-file" = true))]
    pub path: PathBuf,
}

/// The contents of the file.
#[derive(Deserialize, Serialize)]
struct Contents {
    format: String,
    version: u32,
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

fn read(path: &Path) -> Result<TriangleMap> {
    let hint = "make it with `keep_correspondence: FILE` in the pipeline that computes it";
    let text = std::fs::read_to_string(path).map_err(|error| Error::read(path, error))?;
    let contents: Contents = serde_json::from_str(&text)
        .map_err(|error| Error::line(path, error.line(), format!("not a kept correspondence: {error}"), hint))?;
    if contents.format != "mimesh-correspondence" || contents.version != 1 {
        let found = format!("{} version {}", contents.format, contents.version);
        return Err(Error::file(path, format!("expected mimesh-correspondence version 1, found {found}"), hint));
    }
    Ok(TriangleMap {
        source_triangle_count: contents.source_triangles,
        triangles: contents.partners,
        points: contents.points,
        figures: Figures::default(),
    })
}
