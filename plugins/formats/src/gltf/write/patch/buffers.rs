//! All bytes of a document in one buffer: its buffers, what was compressed, and images that lay beside it.

use std::{collections::HashMap, io, sync::Arc};

use serde_json::{Value, json};

use super::{
    draco,
    extension::{forget_extension, remove_extension},
    stored::{list, number},
};
use crate::gltf::{
    document::{Buffer, GltfDocument},
    write::binary::Binary,
};

/// The extensions by which buffer views are compressed, for which `decompressed` of a document stands in.
const COMPRESSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Puts all bytes of `document` into `binary`, which is empty, as one buffer, and makes `json`, which is its JSON, refer to that.
///
/// Views and accessors move from `json` into the result. The first buffer is unchanged and others follow it, so that the
/// views of the first stay as they are. Sentences about what changes for the user are added to `warnings`.
///
/// # Errors
///
/// Those of the file.
pub fn gather(
    document: &GltfDocument,
    json: &mut Value,
    binary: &mut Binary,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    let starts = append(&document.buffers, binary)?;
    binary.views = take(json, "bufferViews");
    binary.accessors = take(json, "accessors");
    decompress(document, json, binary, warnings)?;
    let unread = unread_buffers(document, &binary.views);
    for view in &mut binary.views {
        retarget(view, &starts, &unread);
        for name in COMPRESSIONS {
            if let Some(packed) = view.pointer_mut(&format!("/extensions/{name}")) {
                retarget(packed, &starts, &unread);
            }
        }
    }
    embed_images(document, json, binary, warnings)?;
    let buffers = list(json, "buffers");
    // Readers forgive a first buffer that is no object, since the bytes are in the file.
    let mut first = buffers.first().filter(|first| first.is_object()).cloned().unwrap_or_else(|| json!({}));
    if let Some(first) = first.as_object_mut() {
        first.shift_remove("uri");
        COMPRESSIONS.iter().for_each(|name| remove_extension(first, name));
    }
    let others = unread.iter().map(|&buffer| buffers[buffer].clone());
    let all: Vec<Value> = std::iter::once(first).chain(others).collect();
    json["buffers"] = all.into();
    Ok(())
}

/// Appends `buffers`, of those that share a file the longest in place of all; where each of them starts.
fn append(buffers: &[Buffer], binary: &mut Binary) -> io::Result<Vec<u64>> {
    let mut longest: HashMap<*const Vec<u8>, &Buffer> = HashMap::new();
    for buffer in buffers {
        let known = longest.entry(Arc::as_ptr(&buffer.file)).or_insert(buffer);
        if buffer.length + buffer.padding > known.length + known.padding {
            *known = buffer;
        }
    }
    let mut known: HashMap<*const Vec<u8>, u64> = HashMap::new();
    let mut starts = Vec::new();
    for buffer in buffers {
        let file = Arc::as_ptr(&buffer.file);
        let start = match known.get(&file) {
            Some(&start) => start,
            None if longest[&file].padding == 0 => binary.append(longest[&file])?,
            None => binary.append(&[longest[&file], &vec![0; longest[&file].padding][..]].concat())?,
        };
        known.insert(file, start);
        starts.push(start);
    }
    Ok(starts)
}

/// Puts views, accessors and the length of `binary` into `json`; parts that would be empty are left out.
pub fn settle(json: &mut Value, binary: &mut Binary) {
    for (key, values) in [("bufferViews", &mut binary.views), ("accessors", &mut binary.accessors)] {
        if !values.is_empty() || json.get(key).is_some() {
            json[key] = std::mem::take(values).into();
        }
    }
    if binary.length() > 0 {
        json["buffers"][0]["byteLength"] = binary.length().into();
    } else if let Some(root) = json.as_object_mut() {
        root.shift_remove("buffers");
    }
}

fn take(json: &mut Value, key: &str) -> Vec<Value> {
    match json.get_mut(key) {
        Some(Value::Array(values)) => std::mem::take(values),
        _ => Vec::new(),
    }
}

/// Buffers after the first that hold no bytes but that views stand for which are compressed elsewhere.
fn unread_buffers(document: &GltfDocument, views: &[Value]) -> Vec<usize> {
    let is_used = |buffer: usize| views.iter().any(|view| number(view, "buffer") == Some(buffer));
    let is_empty = |buffer: usize| document.buffers.get(buffer).is_none_or(|bytes| bytes.is_empty());
    (1..list(&document.json, "buffers").len()).filter(|&buffer| is_empty(buffer) && is_used(buffer)).collect()
}

/// Makes a view, or the description of a compressed one, refer to the one buffer, or to an empty one after it.
fn retarget(view: &mut Value, starts: &[u64], unread: &[usize]) {
    let Some(buffer) = number(view, "buffer") else { return };
    if let Some(place) = unread.iter().position(|&other| other == buffer) {
        view["buffer"] = (place + 1).into();
    } else if let Some(&start) = starts.get(buffer).filter(|_| buffer > 0) {
        let offset = number(view, "byteOffset").unwrap_or(0) as u64;
        view["buffer"] = 0.into();
        view["byteOffset"] = (start + offset).into();
    }
}

/// Writes out what was compressed: views, and primitives.
fn decompress(
    document: &GltfDocument,
    json: &mut Value,
    binary: &mut Binary,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    for (index, bytes) in &document.decompressed {
        let offset = binary.append(bytes)?;
        let Some(view) = binary.views.get_mut(*index).and_then(Value::as_object_mut) else { continue };
        view.insert("buffer".into(), 0.into());
        view.insert("byteOffset".into(), offset.into());
        view.insert("byteLength".into(), bytes.len().into());
        COMPRESSIONS.iter().for_each(|name| remove_extension(view, name));
    }
    let was_draco = draco::is_used(json);
    draco::unpack(document, json, binary)?;
    let mut unused = Vec::new();
    for name in COMPRESSIONS.into_iter().filter(|_| !document.decompressed.is_empty()) {
        let pointer = format!("/extensions/{name}");
        if !binary.views.iter().any(|view| view.pointer(&pointer).is_some()) {
            unused.push(name);
        }
    }
    if was_draco && !draco::is_used(json) {
        unused.push(draco::NAME);
    }
    if let Some(root) = json.as_object_mut() {
        unused.iter().for_each(|name| forget_extension(root, name));
    }
    if !document.decompressed.is_empty() || !document.unpacked.is_empty() {
        warnings.push("compressed parts of the file are written uncompressed".into());
    }
    Ok(())
}

/// Takes images that lay in files of their own into the buffer, so that the output works in any folder.
fn embed_images(
    document: &GltfDocument,
    json: &mut Value,
    binary: &mut Binary,
    warnings: &mut Vec<String>,
) -> io::Result<()> {
    // One file may be several images.
    let mut views: HashMap<*const Vec<u8>, usize> = HashMap::new();
    for (index, bytes) in &document.images {
        let Some(image) = json.pointer_mut(&format!("/images/{index}")).and_then(Value::as_object_mut) else {
            continue;
        };
        let stated = image.get("mimeType").and_then(Value::as_str).map(str::to_owned);
        let Some(kind) = mime_type(bytes).map(str::to_owned).or(stated) else {
            warnings.push(format!("image {index} is of an unknown kind and stays a file of its own"));
            continue;
        };
        image.shift_remove("uri");
        image.insert("mimeType".into(), kind.into());
        let view = match views.get(&Arc::as_ptr(bytes)) {
            Some(&view) => view,
            None => binary.plain_view(bytes)?,
        };
        views.insert(Arc::as_ptr(bytes), view);
        image.insert("bufferView".into(), view.into());
    }
    Ok(())
}

/// The kind of an image by its first bytes.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some("image/png")
    } else if bytes.starts_with(b"\xff\xd8\xff") {
        Some("image/jpeg")
    } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        Some("image/webp")
    } else if bytes.starts_with(b"\xabKTX 20\xbb\r\n\x1a\n") {
        Some("image/ktx2")
    } else {
        None
    }
}
