//! The files that a glTF consists of: JSON, binary chunk, data URIs, files beside it.

use std::{borrow::Cow, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use mimesh_core::{Error, Result, stage::FileInput};

use super::schema::{Buffer, Root};

/// A glTF with all its bytes.
#[derive(Debug)]
pub struct Asset {
    /// The JSON.
    pub root: Root,
    /// The contents of its buffers.
    pub buffers: Vec<Vec<u8>>,
}

impl Asset {
    /// Reads a `.glb` or `.gltf`, told apart by their first bytes, and the files it refers to.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] for a file that cannot be read, [`Error::File`] for one that is damaged, is not glTF 2.0, or needs an
    /// extension without which its meshes cannot be read.
    pub fn read(input: &dyn FileInput) -> Result<Self> {
        let path = input.path();
        let bytes = input.contents()?;
        let (root, binary) = parse(path, &bytes)?;
        if !root.asset.version.starts_with("2.") {
            let message = format!("glTF version `{}`: expected 2.0", root.asset.version);
            return Err(Error::file(path, message, "convert the file to glTF 2.0, for example through Blender"));
        }
        check_extensions(path, &root.extensions_required)?;
        let load = |(index, buffer)| load(input, index, buffer, binary);
        let buffers = root.buffers.iter().enumerate().map(load).collect::<Result<_>>()?;
        Ok(Self { root, buffers })
    }

    /// The buffers in files of their own; none if the glTF cannot be read.
    pub fn references(input: &dyn FileInput) -> Vec<String> {
        let contents = input.contents().ok();
        let root = contents.and_then(|bytes| parse(input.path(), &bytes).ok().map(|(root, _)| root));
        let uris = root.iter().flat_map(|root| &root.buffers).filter_map(|buffer| buffer.uri.as_deref());
        uris.filter(|uri| is_file(uri)).map(|uri| decoded(uri).into_owned()).collect()
    }
}

/// The JSON and the binary chunk in the bytes of `path`.
fn parse<'b>(path: &Path, bytes: &'b [u8]) -> Result<(Root, Option<&'b [u8]>)> {
    let (json, binary) = if bytes.starts_with(b"glTF") {
        chunks(bytes).map_err(|message| Error::file(path, message, DAMAGED))?
    } else {
        (bytes, None)
    };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let root = serde_json::from_slice(json)
        .map_err(|problem| Error::file(path, format!("not the JSON of a glTF: {problem}"), DAMAGED))?;
    Ok((root, binary))
}

const DAMAGED: &str = "the file is damaged or cut short: export it again";

/// The JSON and binary chunks of a GLB.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let number = |at: usize| -> Result<usize, String> {
        let field = bytes.get(at..at + 4).ok_or_else(|| format!("GLB ends at byte {}", bytes.len()))?;
        Ok(u32::from_le_bytes(field.try_into().expect("the slice has four bytes")) as usize)
    };
    let version = number(4)?;
    if version != 2 {
        return Err(format!("GLB version {version}: expected 2"));
    }
    let length = number(8)?;
    if length > bytes.len() {
        return Err(format!("GLB is cut short: its header says {length} bytes, the file has {}", bytes.len()));
    }
    let mut at = 12;
    let (mut json, mut binary) = (None, None);
    while at + 8 <= length {
        let (size, kind) = (number(at)?, &bytes[at + 4..at + 8]);
        let chunk = bytes.get(at + 8..at + 8 + size).ok_or_else(|| {
            format!("GLB is cut short: a chunk of {size} bytes starts at byte {}, the file has {}", at + 8, bytes.len())
        })?;
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + size;
    }
    Ok((json.ok_or("GLB without a JSON chunk")?, binary))
}

/// Refuses what cannot be read without the extension; extensions of looks do not matter here.
fn check_extensions(path: &Path, required: &[String]) -> Result<()> {
    for name in required {
        let harmless = name == "KHR_mesh_quantization"
            || [
                "KHR_materials_",
                "KHR_texture_",
                "EXT_texture_",
                "MSFT_texture_",
                "KHR_lights_",
                "EXT_lights_",
                "KHR_animation_",
            ]
            .iter()
            .any(|prefix| name.starts_with(prefix));
        if harmless {
            continue;
        }
        let compressed = name.contains("draco") || name.contains("meshopt");
        let (message, hint) = if compressed {
            (
                format!("the mesh is compressed with {name}, which is not supported"),
                "export it without compression, or undo it: `npx @gltf-transform/cli copy in.glb out.glb`",
            )
        } else {
            (
                format!("the file requires the extension {name}, which is not supported"),
                "export it without the extension",
            )
        };
        return Err(Error::file(path, message, hint));
    }
    Ok(())
}

/// The bytes of buffer `index`.
fn load(input: &dyn FileInput, index: usize, buffer: &Buffer, binary: Option<&[u8]>) -> Result<Vec<u8>> {
    let path = input.path();
    let fail = |message: String| Error::file(path, format!("buffer {index} {message}"), DAMAGED);
    let mut bytes = match &buffer.uri {
        None if index == 0 && binary.is_some() => binary.unwrap_or_default().to_vec(),
        None if buffer.byte_length == 0 => Vec::new(),
        None => return Err(fail("has no data".into())),
        Some(uri) if uri.starts_with("data:") => {
            let Some((_, text)) = uri.split_once(";base64,") else { return Err(fail("is not base64".into())) };
            STANDARD.decode(text).map_err(|problem| fail(format!("is not base64: {problem}")))?
        }
        Some(uri) if uri.contains("://") => {
            let hint = "download it, and name the file beside the glTF instead";
            return Err(Error::file(path, format!("buffer {index} lies at {uri}"), hint));
        }
        Some(uri) => input.referenced(&decoded(uri))?,
    };
    if bytes.len() < buffer.byte_length {
        return Err(fail(format!("is cut short: expected {} bytes, found {}", buffer.byte_length, bytes.len())));
    }
    bytes.truncate(buffer.byte_length);
    Ok(bytes)
}

/// Whether `uri` names a file beside the glTF: it neither holds the data itself nor leads elsewhere.
fn is_file(uri: &str) -> bool {
    !uri.starts_with("data:") && !uri.contains("://")
}

/// A relative URI as a path: `%20` is a space.
fn decoded(uri: &str) -> Cow<'_, str> {
    if !uri.contains('%') {
        return uri.into();
    }
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped = tail.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        match escaped.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) if *first == b'%' => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            _ => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
mod tests {
    use mimesh_core::stage::BytesInput;

    use super::*;

    #[test]
    fn percent_signs_stand_for_bytes() {
        assert_eq!(decoded("a b.bin"), "a b.bin");
        assert_eq!(decoded("a%20b%C3%A9.bin"), "a bé.bin");
        assert_eq!(decoded("100%.bin%4"), "100%.bin%4");
    }

    #[test]
    fn a_gltf_refers_to_its_buffers_in_other_files() {
        let uris = ["a%20b.bin", "data:application/octet-stream;base64,AAAA", "https://example.org/c.bin", "d.bin"];
        let buffers = uris.map(|uri| format!(r#"{{ "uri": "{uri}", "byteLength": 3 }}"#)).join(", ");
        let json = format!(r#"{{ "asset": {{ "version": "2.0" }}, "buffers": [{buffers}] }}"#);
        assert_eq!(Asset::references(&BytesInput::new("m.gltf", json)), ["a b.bin", "d.bin"]);
        assert_eq!(Asset::references(&BytesInput::new("damaged.gltf", "{")), [""; 0]);
    }

    #[test]
    fn a_truncated_glb_says_what_is_missing() {
        assert_eq!(chunks(b"glTF\x02\0\0\0").unwrap_err(), "GLB ends at byte 8");
        assert_eq!(chunks(b"glTF\x01\0\0\0\x0c\0\0\0").unwrap_err(), "GLB version 1: expected 2");
        assert_eq!(chunks(b"glTF\x02\0\0\0\x0c\0\0\0").unwrap_err(), "GLB without a JSON chunk");
        let short = b"glTF\x02\0\0\0\x14\0\0\0\x09\0\0\0JSON";
        assert_eq!(
            chunks(short).unwrap_err(),
            "GLB is cut short: a chunk of 9 bytes starts at byte 20, the file has 20"
        );
    }
}
