//! Painted masks: weights of vertices, and components, in files beside the pipeline.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

use mimesh_markers::MeshRole;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::{
    container::{self, Numbers},
    durable,
    error::{ApiError, Code, Result},
    markers::Side,
    project::Project,
    regular,
};

/// The most characters of a mask's name.
const MAX_NAME: usize = 60;

/// A painted mask.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mask {
    name: String,
    side: Side,
    file: PathBuf,
    kind: MaskKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum MaskKind {
    Weights,
    Components,
}

/// What the file of a mask holds.
#[derive(Debug, Deserialize)]
struct MaskFile {
    #[serde(default)]
    weights: Option<Vec<f32>>,
    #[serde(default)]
    components: Option<Vec<String>>,
}

impl Project {
    /// All masks beside the pipeline.
    pub fn masks(&self) -> Vec<Mask> {
        let files = fs::read_dir(self.folder()).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut masks: Vec<Mask> = files.filter_map(|file| mask_of(&file)).collect();
        masks.sort_by(|a, b| (a.side.index(), &a.name).cmp(&(b.side.index(), &b.name)));
        masks
    }

    /// Saves weights of the vertices of a side, each 0 to 1.
    ///
    /// # Errors
    ///
    /// For another number of vertices, weights out of range, and a mask of the name that is there, unless it may be `replaced`.
    pub fn put_weights(&self, side: Side, name: &str, weights: &[f32], replaced: bool) -> Result<Mask> {
        let count = self.meshes.sides[side.index()].sequence.rest.positions.len();
        if weights.len() != count {
            let message = format!("{} weights, the {} has {count} vertices", weights.len(), side.role());
            return Err(ApiError::bad(message));
        }
        if let Some(i) = weights.iter().position(|weight| !(0.0..=1.0).contains(weight)) {
            return Err(ApiError::bad(format!("the weight of vertex {i}: expected 0 to 1, found {}", weights[i])));
        }
        self.put_mask(side, name, json!({ "weights": weights }), replaced)
    }

    /// Saves names of components of a side.
    ///
    /// # Errors
    ///
    /// For a component that the side does not have, and a mask of the name that is there, unless it may be `replaced`.
    pub fn put_components(&self, side: Side, name: &str, components: &[String], replaced: bool) -> Result<Mask> {
        let known = self.meshes.component_names(side.index());
        if let Some(unknown) = components.iter().find(|name| !known.contains(name)) {
            return Err(ApiError::bad(format!("the {} has no component `{unknown}`", side.role())));
        }
        // Pipelines read weights, which stay right when components are named anew.
        let weights = self.meshes.weights_of_components(side.index(), components);
        self.put_mask(side, name, json!({ "components": components, "weights": weights }), replaced)
    }

    /// The mask as weights of vertices, in a container.
    ///
    /// # Errors
    ///
    /// If there is none, or its file is not of this mesh.
    pub fn mask(&self, side: Side, name: &str) -> Result<Vec<u8>> {
        let file = self.mask_file(side, name)?;
        let missing = || ApiError::not_found(format!("there is no mask `{name}` of the {}", side.role()));
        let text = regular::read_text(&file).map_err(|_| missing())?;
        let wrong = |what: String| ApiError::new(Code::Unprocessable, format!("{}: {what}", file.display()));
        let MaskFile { weights, components } = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let count = self.meshes.sides[side.index()].sequence.rest.positions.len();
        let weights = match (weights, components) {
            (Some(weights), _) => weights,
            (None, Some(components)) => self.meshes.weights_of_components(side.index(), &components),
            (None, None) => return Err(wrong("neither `weights` nor `components`".into())),
        };
        if weights.len() != count {
            return Err(wrong(format!("{} weights, the {} has {count} vertices", weights.len(), side.role())));
        }
        Ok(container::write(json!({ "name": name, "side": side }), &[("weights", Numbers::F32(&weights))]))
    }

    /// Removes a mask.
    ///
    /// # Errors
    ///
    /// If there is none.
    pub fn delete_mask(&self, side: Side, name: &str) -> Result<()> {
        let file = self.mask_file(side, name)?;
        fs::remove_file(file)
            .map_err(|_| ApiError::not_found(format!("there is no mask `{name}` of the {}", side.role())))?;
        self.masks_saved.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    fn put_mask(&self, side: Side, name: &str, contents: Value, replaced: bool) -> Result<Mask> {
        let file = self.mask_file(side, name)?;
        if !replaced && file.exists() {
            let of = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let message = format!("`{of}` is there already");
            return Err(ApiError::new(Code::Conflict, message).hint("choose another name, or replace it"));
        }
        let mesh = &self.meshes.sides[side.index()];
        let of = mesh.path.as_ref().and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
        let mut whole = json!({ "mesh": of, "vertices": mesh.sequence.rest.positions.len() });
        if let (Some(whole), Value::Object(contents)) = (whole.as_object_mut(), contents) {
            whole.extend(contents);
        }
        durable::write(&file, format!("{whole}\n").as_bytes())?;
        self.masks_saved.fetch_add(1, Ordering::Relaxed);
        mask_of(&file).ok_or_else(|| ApiError::bad("the name of the mask cannot be read back"))
    }

    fn folder(&self) -> &Path {
        self.pipeline.file().parent().unwrap_or(Path::new("."))
    }

    fn mask_file(&self, side: Side, name: &str) -> Result<PathBuf> {
        let is_plain = |c: char| c.is_alphanumeric() || "_- ".contains(c);
        if name.is_empty() || name.trim() != name || name.chars().count() > MAX_NAME || !name.chars().all(is_plain) {
            let message = format!("the name of a mask has 1 to {MAX_NAME} letters, digits, `_`, `-` and blanks");
            return Err(ApiError::bad(message));
        }
        Ok(self.folder().join(format!("{name}.{}.mask.json", side.role())))
    }
}

fn mask_of(file: &Path) -> Option<Mask> {
    let name = file.file_name()?.to_str()?.strip_suffix(".mask.json")?;
    let (name, side) = name.rsplit_once('.')?;
    let side = [Side::Source, Side::Target].into_iter().find(|s| MeshRole::BOTH[s.index()].name() == side)?;
    let text = regular::read_text(file).ok()?;
    let kind = if text.contains("\"components\"") { MaskKind::Components } else { MaskKind::Weights };
    Some(Mask { name: name.into(), side, file: file.into(), kind })
}
