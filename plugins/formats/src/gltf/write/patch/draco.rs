//! Primitives that Draco holds, with data of their own instead: new targets are in the order of these.

use std::io;

use serde_json::Value;

use super::{
    extension::remove_extension,
    layout::position,
    stored::{bounds, entry_size, list, number},
};
use crate::gltf::{document::GltfDocument, write::binary::Binary};

/// The extension by which primitives are compressed, for which `unpacked` of a document stands in.
pub const NAME: &str = "KHR_draco_mesh_compression";

/// Writes out the accessors that only Draco's data hold, and takes the extension from the primitives that need it no more.
///
/// A primitive that gets targets and has data beside Draco's loses the extension too: its vertices may have another order there.
///
/// # Errors
///
/// Those of the file.
pub fn unpack(document: &GltfDocument, json: &mut Value, binary: &mut Binary) -> io::Result<()> {
    for (index, bytes) in &document.unpacked {
        let Some(accessor) = binary.accessors.get(*index) else { continue };
        let Some(size) = entry_size(accessor) else { continue };
        let bounds = bounds(accessor, bytes).filter(|_| accessor.get("min").or(accessor.get("max")).is_some());
        let (padded, stride) = if is_indices(json, *index) { (bytes.clone(), None) } else { aligned(bytes, size) };
        let view = binary.plain_view(&padded)?;
        if let Some(stride) = stride {
            binary.views[view]["byteStride"] = stride.into();
        }
        let accessor = &mut binary.accessors[*index];
        if let Some(object) = accessor.as_object_mut() {
            object.shift_remove("byteOffset");
        }
        accessor["bufferView"] = view.into();
        // Draco rounds, so that bounds of what it was given need not be true.
        if let Some((low, high)) = bounds {
            (accessor["min"], accessor["max"]) = (low.into(), high.into());
        }
    }
    let has_data = |accessor: usize| binary.accessors.get(accessor).is_some_and(|a| a.get("bufferView").is_some());
    let is_unpacked = |accessor: usize| document.unpacked.contains_key(&accessor);
    for (index, mesh) in json.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
        let gets_targets = document.placements.iter().any(|placement| placement.mesh == index);
        for primitive in mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten() {
            let Some(position) = position(primitive) else { continue };
            if is_unpacked(position) || (gets_targets && has_data(position)) {
                primitive.as_object_mut().into_iter().for_each(|primitive| remove_extension(primitive, NAME));
            }
        }
    }
    Ok(())
}

/// Whether any primitive is compressed.
pub fn is_used(json: &Value) -> bool {
    let primitives = list(json, "meshes").iter().flat_map(|mesh| list(mesh, "primitives"));
    primitives.into_iter().any(|primitive| primitive.get("extensions").is_some_and(|all| all.get(NAME).is_some()))
}

fn is_indices(json: &Value, accessor: usize) -> bool {
    let mut primitives = list(json, "meshes").iter().flat_map(|mesh| list(mesh, "primitives"));
    primitives.any(|primitive| number(primitive, "indices") == Some(accessor))
}

/// Entries at multiples of four bytes, as attributes of vertices must lie, and their distance if there are gaps.
fn aligned(bytes: &[u8], size: usize) -> (Vec<u8>, Option<usize>) {
    let stride = size.next_multiple_of(4);
    if stride == size {
        return (bytes.to_vec(), None);
    }
    let mut padded = Vec::with_capacity(bytes.len() / size * stride);
    for entry in bytes.chunks_exact(size) {
        padded.extend_from_slice(entry);
        padded.resize(padded.len().next_multiple_of(stride), 0);
    }
    (padded, Some(stride))
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::memory_file::MemoryFile;
    use serde_json::json;

    use super::*;
    use crate::tail::Tail;

    #[test]
    fn attributes_lie_at_multiples_of_four_bytes() {
        assert_eq!(aligned(&[1, 2, 3, 4, 5, 6], 3), (vec![1, 2, 3, 0, 4, 5, 6, 0], Some(4)));
        assert_eq!(aligned(&[1, 2, 3, 4], 4), (vec![1, 2, 3, 4], None));
    }

    #[test]
    fn accessors_get_data_and_true_bounds_and_primitives_lose_the_extension() {
        let packed = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "extensions": { NAME: {} } });
        let other = json!({ "attributes": { "POSITION": 2 }, "extensions": { NAME: {}, "X": {} } });
        let mut json = json!({ "meshes": [{ "primitives": [packed, other] }] });
        let mut binary = Binary::new(Tail::new(Box::new(MemoryFile::default())));
        binary.accessors = vec![
            json!({ "componentType": 5121, "count": 2, "type": "VEC3", "min": [0, 0, 0], "max": [9, 9, 9] }),
            json!({ "componentType": 5121, "count": 3, "type": "SCALAR" }),
            json!({ "componentType": 5121, "count": 2, "type": "VEC3" }),
        ];
        let unpacked = [(0, vec![1, 5, 3, 4, 2, 6]), (1, vec![0, 1, 0])].into();
        let document = GltfDocument { unpacked, ..GltfDocument::default() };
        unpack(&document, &mut json, &mut binary).unwrap();
        assert_eq!(json["meshes"][0]["primitives"][0], json!({ "attributes": { "POSITION": 0 }, "indices": 1 }));
        assert!(is_used(&json));
        assert_eq!(binary.accessors[0]["bufferView"], 0);
        assert_eq!(
            (&binary.accessors[0]["min"], &binary.accessors[0]["max"]),
            (&json!([1., 2., 3.]), &json!([4., 5., 6.]))
        );
        assert_eq!(binary.views[0]["byteStride"], 4);
        assert_eq!(binary.views[1].get("byteStride"), None);
    }
}
