//! Opening a glTF: its JSON, its buffers, and what is compressed in them.

use std::{collections::HashSet, sync::Arc};

use gltf::json::Root;
use mimesh_core::{Error, Result, stage::FileInput};
use serde_json::Value;

use super::{
    asset::{Asset, DAMAGED},
    container::{Binary, MAX_PADDING, chunks},
    draco, extensions, meshopt, tolerant, uri,
};
use crate::{
    beside::FilesBeside,
    gltf::document::Buffer,
    names::{quoted, shown},
};

/// Files with more buffers than this have no more bytes in them than [`MAX_REFERRED`].
const MAX_BUFFERS: usize = 256;

/// No path from a glTF to a file beside it is longer, and messages name it whole.
const MAX_PATH: usize = 1024;

/// See [`MAX_BUFFERS`].
const MAX_REFERRED: usize = 1 << 28;

impl Asset {
    /// Reads a `.glb` or `.gltf`, told apart by their first bytes, and the buffers it refers to.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] for a file that cannot be read, [`Error::File`] for one that is damaged or not glTF 2.0.
    pub fn read(input: &dyn FileInput) -> Result<Self> {
        let path = input.path();
        let damaged = |message: String| Error::file(path, message, DAMAGED);
        let bytes = input.contents()?;
        let chunks = chunks(&bytes).map_err(damaged)?;
        let (json, doubles) =
            tolerant::parse(chunks.json).map_err(|problem| damaged(format!("not the JSON of a glTF: {problem}")))?;
        let tolerant::Reduced { json: reduced, pointing } = tolerant::reduce(&json);
        check_version(&json, reduced["asset"]["version"].as_str().unwrap_or_default())
            .map_err(|(message, hint)| Error::file(path, message, hint))?;
        let root: Root = serde_path_to_error::deserialize(reduced).map_err(|problem| damaged(wrong_value(&problem)))?;
        let mut asset = Self { root, json, warnings: chunks.warnings, ..Self::default() };
        if !doubles.is_empty() {
            let names = quoted(&doubles);
            asset.warnings.push(format!("keys stand twice in one object of the JSON, and the last counts: {names}"));
        }
        asset.warn_of_pointers(&pointing);
        if chunks.others > 0 {
            asset
                .warnings
                .push(format!("chunks of the GLB that are neither JSON nor BIN are left out: {}", chunks.others));
        }
        let fallbacks = meshopt::fallbacks(&asset.root);
        let mut referred: usize = 0;
        let mut beside = FilesBeside::new(input);
        for index in 0..asset.root.buffers.len() {
            let before = beside.len();
            let buffer = asset.load(&mut beside, index, chunks.binary, &fallbacks)?;
            // A file that several buffers name takes room once.
            if before < beside.len() || asset.root.buffers[index].uri.as_deref().is_none_or(|uri| !uri::is_file(uri)) {
                referred = referred.saturating_add(buffer.file.len());
            }
            if index >= MAX_BUFFERS && referred > MAX_REFERRED {
                let message = format!("{} buffers of more than {MAX_REFERRED} bytes in all", asset.root.buffers.len());
                return Err(Error::file(path, message, "export the file with one buffer, e.g. as .glb"));
            }
            asset.buffers.push(buffer);
        }
        let is_longer = |(index, buffer): (usize, &Buffer)| {
            let length = asset.root.buffers[index].byte_length.0;
            (length > 0 && buffer.file.len() as u64 > length.saturating_add(MAX_PADDING as u64))
                .then(|| index.to_string())
        };
        let longer: Vec<_> = asset.buffers.iter().enumerate().filter_map(is_longer).collect();
        if !longer.is_empty() {
            asset
                .warnings
                .push(format!("buffers of more bytes than the file says, which are left out: {}", quoted(&longer)));
        }
        asset.decompressed = meshopt::decompress(&asset).map_err(damaged)?;
        asset.count_bytes();
        Ok(asset)
    }

    /// The buffers in files of their own; none if the glTF cannot be read.
    pub fn references(input: &dyn FileInput) -> Vec<String> {
        let Ok(bytes) = input.contents() else { return Vec::new() };
        let json = chunks(&bytes).and_then(|chunks| tolerant::parse(chunks.json)).unwrap_or_default().0;
        let buffers = json["buffers"].as_array();
        let uris = buffers.into_iter().flatten().filter_map(|buffer| buffer["uri"].as_str());
        uris.filter(|uri| uri::is_file(uri)).map(|uri| uri::decoded(uri).into_owned()).collect()
    }

    /// The contents of the images in files of their own, by number; one that may not be read stays a reference.
    pub fn read_images(&mut self, input: &dyn FileInput) -> Vec<(usize, Arc<Vec<u8>>)> {
        let images = self.json["images"].as_array();
        let uris = images.into_iter().flatten().map(|image| image["uri"].as_str().filter(|uri| uri::is_file(uri)));
        let (mut contents, mut unread) = (Vec::new(), Vec::new());
        let mut beside = FilesBeside::new(input);
        let mut refusal = String::new();
        for (index, uri) in uris.enumerate() {
            let Some(uri) = uri else { continue };
            match beside.read(&uri::decoded(uri)) {
                Ok(bytes) => contents.push((index, bytes)),
                Err(error) => {
                    // That there is too little memory is for the user to change.
                    if matches!(error, Error::Memory { .. }) {
                        refusal = format!(" ({error})");
                    }
                    unread.push(uri.to_owned());
                }
            }
        }
        if !unread.is_empty() {
            self.warnings.push(format!("images that cannot be read stay references: {}{refusal}", quoted(&unread)));
        }
        contents
    }

    /// Decodes the compressed primitives of the meshes that `is_needed` chooses by number of mesh and of primitive.
    ///
    /// # Errors
    ///
    /// [`Error::File`] that names the primitive and the extension without which it cannot be read.
    pub fn unpack(&mut self, input: &dyn FileInput, is_needed: &dyn Fn(usize, usize) -> bool) -> Result<()> {
        self.unpacked = draco::unpack(self, is_needed)
            .map_err(|message| Error::file(input.path(), message, extensions::UNCOMPRESS))?;
        self.count_bytes();
        extensions::check(self, is_needed).map_err(|(message, hint)| Error::file(input.path(), message, hint))
    }

    /// The bytes of buffer `index`.
    fn load(
        &self,
        beside: &mut FilesBeside<'_>,
        index: usize,
        binary: Option<Binary>,
        fallbacks: &HashSet<usize>,
    ) -> Result<Buffer> {
        let path = beside.path();
        let buffer = &self.root.buffers[index];
        let fail = |message: String| Error::file(path, format!("buffer {index} {message}"), DAMAGED);
        let length = usize::try_from(buffer.byte_length.0).unwrap_or(usize::MAX);
        let mut is_cut = false;
        let bytes = match &buffer.uri {
            None if index == 0 && binary.is_some() => {
                let Binary { bytes, is_cut: cut } = binary.expect("the guard saw it");
                is_cut = cut;
                Arc::new(bytes.to_vec())
            }
            None if length == 0 || fallbacks.contains(&index) => return Ok(Buffer::default()),
            None => return Err(fail("has no data".into())),
            Some(uri) if uri.is_empty() => return Err(fail("has an empty URI".into())),
            Some(uri) if uri.contains("://") && !uri.starts_with("data:") => {
                let hint = match uri.starts_with("file:") {
                    true => "name the file by its path from the glTF instead",
                    false => "download it, and name the file beside the glTF instead",
                };
                return Err(Error::file(path, format!("buffer {index} lies at `{}`", shown(uri)), hint));
            }
            Some(uri) => match uri::data(uri) {
                Some(data) => Arc::new(data.map_err(fail)?),
                None => {
                    let name = uri::decoded(uri);
                    if name.len() > MAX_PATH || name.contains(char::is_control) {
                        return Err(fail(format!("lies in `{}`: expected the path of a file", shown(uri))));
                    }
                    beside.read(&name)?
                }
            },
        };
        // Whether all numbers are there is checked where they are read.
        let lacks_padding = !is_cut && length - length.min(bytes.len()) <= MAX_PADDING;
        if bytes.len() < length && !lacks_padding {
            return Err(fail(format!("is cut short: expected {length} bytes, found {}", bytes.len())));
        }
        // A length that is left out in the JSON is 0 in the model.
        let length = if length > 0 { length.min(bytes.len()) } else { bytes.len() };
        Ok(Buffer { file: bytes, length, padding: 0 })
    }

    fn warn_of_pointers(&mut self, pointing: &[usize]) {
        if pointing.is_empty() {
            return;
        }
        let name = |&index: &usize| self.root.animations[index].name.clone().unwrap_or_else(|| index.to_string());
        let names: Vec<_> = pointing.iter().map(name).collect();
        self.warnings.push(format!("animation channels that move no node were left out: {}", quoted(&names)));
    }
}

/// The message about a value that is of another kind than expected; neither keys nor values of the file make it long.
fn wrong_value(problem: &serde_path_to_error::Error<serde_json::Error>) -> String {
    let (path, kind) = (problem.path().to_string(), problem.inner().to_string());
    // The expected kind stands at the end.
    let kind = match kind.rsplit_once(", expected ") {
        Some((found, expected)) => format!("{}, expected {}", shown(found), shown(expected)),
        None => shown(&kind),
    };
    format!("not the JSON of a glTF: `{}`: {kind}", shown(&path))
}

/// Checks that a file is a glTF 2.x that readers of 2.0 may read; `version` is what its JSON says.
///
/// # Errors
///
/// A message and a way out.
fn check_version(json: &Value, version: &str) -> Result<(), (String, &'static str)> {
    const CONVERT: &str = "convert the file to glTF 2.0, for example through Blender";
    if version.is_empty() {
        let keys: Vec<&String> = json.as_object().into_iter().flat_map(|object| object.keys()).collect();
        let found = if keys.is_empty() { "no keys".into() } else { format!("the keys {}", quoted(&keys)) };
        let message = format!("not a glTF: expected JSON with `\"asset\": {{ \"version\": \"2.0\" }}`, found {found}");
        return Err((message, "is it the file that is meant? markers as JSON are given as markers, not as a mesh"));
    }
    if version != "2" && !version.starts_with("2.") {
        return Err((format!("glTF version `{}`: expected 2.0", shown(version)), CONVERT));
    }
    let least = match &json["asset"]["minVersion"] {
        Value::String(least) => least.clone(),
        Value::Null => return Ok(()),
        other => other.to_string(),
    };
    let number: Vec<Option<u32>> = least.split('.').map(|part| part.parse().ok()).collect();
    match number[..] {
        [Some(major), Some(minor)] if (major, minor) <= (2, 0) => Ok(()),
        _ => Err((format!("the file needs glTF version `{}` (`minVersion`): 2.0 is read", shown(&least)), CONVERT)),
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::stage::BytesInput;

    use super::*;

    #[test]
    fn a_gltf_refers_to_its_buffers_in_other_files() {
        let uris = ["a%20b.bin", "data:application/octet-stream;base64,AAAA", "https://example.org/c.bin", "d.bin"];
        let buffers = uris.map(|uri| format!(r#"{{ "uri": "{uri}", "byteLength": 3 }}"#)).join(", ");
        let json = format!(r#"{{ "asset": {{ "version": "2.0" }}, "buffers": [{buffers}] }}"#);
        assert_eq!(Asset::references(&BytesInput::new("m.gltf", json)), ["a b.bin", "d.bin"]);
        assert_eq!(Asset::references(&BytesInput::new("damaged.gltf", "{")), [""; 0]);
    }

    #[test]
    fn a_buffer_may_lack_its_padding_and_nothing_else() {
        let read = |length: usize| {
            let json = format!(
                r#"{{ "asset": {{ "version": "2" }}, "buffers": [{{ "byteLength": {length}, "uri": "data:;base64,AAEC" }}] }}"#
            );
            Asset::read(&BytesInput::new("m.gltf", json)).map(|asset| asset.buffers[0].to_vec())
        };
        assert_eq!(read(2).unwrap(), [0, 1]);
        assert_eq!(read(6).unwrap(), [0, 1, 2]);
        assert_eq!(read(7).unwrap_err().to_string(), "m.gltf: buffer 0 is cut short: expected 7 bytes, found 3");
    }

    #[test]
    fn a_wrong_kind_of_value_is_named_with_its_path() {
        let json = r#"{ "asset": { "version": "2.0" }, "meshes": [{ "primitives": [{ "indices": "first" }] }] }"#;
        let error = Asset::read(&BytesInput::new("m.gltf", json)).unwrap_err().to_string();
        let expected = "m.gltf: not the JSON of a glTF: `meshes[0].primitives[0].indices`: ";
        assert!(error.starts_with(expected), "{error}");
    }

    #[test]
    fn what_is_no_gltf_2_says_what_it_is() {
        let error = |json: &str| Asset::read(&BytesInput::new("m.gltf", json)).unwrap_err().to_string();
        let expected = "m.gltf: not a glTF: expected JSON with `\"asset\": { \"version\": \"2.0\" }`, found the keys `nose`, `ear`";
        assert_eq!(error(r#"{ "nose": 1, "ear": 2 }"#), expected);
        assert_eq!(error(r#"{ "asset": { "version": "1.0" } }"#), "m.gltf: glTF version `1.0`: expected 2.0");
        assert_eq!(error(r#"{ "asset": { "version": "20" } }"#), "m.gltf: glTF version `20`: expected 2.0");
        let newer = r#"{ "asset": { "version": "2.1", "minVersion": "2.1" } }"#;
        assert_eq!(error(newer), "m.gltf: the file needs glTF version `2.1` (`minVersion`): 2.0 is read");
        let older = r#"{ "asset": { "version": "2.1", "minVersion": "2.0" } }"#;
        assert!(Asset::read(&BytesInput::new("m.gltf", older)).is_ok());
    }

    #[test]
    fn keys_that_stand_twice_are_told() {
        let json = r#"{ "asset": { "version": "2.0" }, "nodes": [{ "name": "a", "name": "b" }], "nodes": [] }"#;
        let asset = Asset::read(&BytesInput::new("m.gltf", json)).unwrap();
        let told = "keys stand twice in one object of the JSON, and the last counts: `name`, `nodes`";
        assert_eq!(asset.warnings, [told]);
    }

    #[test]
    fn chunks_of_other_kinds_are_left_out_and_told() {
        let json = br#"{ "asset": { "version": "2.0" } }   "#;
        let chunk = |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
        let chunks = [chunk(b"JSON", json), chunk(b"KEPT", &[1, 2, 3, 4])].concat();
        let length = (12 + chunks.len()) as u32;
        let glb = [&b"glTF\x02\0\0\0"[..], &length.to_le_bytes(), &chunks].concat();
        let asset = Asset::read(&BytesInput::new("m.glb", glb)).unwrap();
        assert_eq!(asset.warnings, ["chunks of the GLB that are neither JSON nor BIN are left out: 1"]);
    }
}
