//! Entries of a document's accessors, as they are stored.
//!
//! The reader turns all numbers to f64; here bytes are needed, so that what is only moved stays to the last bit.

use serde_json::Value;

use crate::gltf::document::{GltfDocument, bytes_of};

/// The entries of an accessor without gaps between them.
#[derive(Debug)]
pub struct Entries {
    /// All bytes, in order.
    pub bytes: Vec<u8>,
    /// Bytes an entry.
    pub size: usize,
}

/// A whole number of the JSON, also if it is written with a fraction of zero.
pub fn whole(value: &Value) -> Option<usize> {
    value
        .as_u64()
        .map(|x| x as usize)
        .or_else(|| value.as_f64().filter(|x| *x >= 0.0 && x.fract() == 0.0).map(|x| x as usize))
}

/// The whole number `key` of `object`, if there is one.
pub fn number(object: &Value, key: &str) -> Option<usize> {
    whole(object.get(key)?)
}

/// The entries of the JSON list `key` of the root; none if there is no list.
pub fn list<'a>(json: &'a Value, key: &str) -> &'a [Value] {
    json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// The entries of accessor `index`; `None` if it is damaged.
pub fn entries(document: &GltfDocument, index: usize) -> Option<Entries> {
    let accessor = list(&document.json, "accessors").get(index)?;
    let count = number(accessor, "count")?;
    let size = entry_size(accessor)?;
    if let Some(bytes) = document.unpacked.get(&index) {
        return Some(Entries { bytes: bytes.clone(), size })
            .filter(|entries| Some(entries.bytes.len()) == count.checked_mul(size));
    }
    let mut bytes = match number(accessor, "bufferView") {
        Some(view) => run(document, view, number(accessor, "byteOffset").unwrap_or(0), count, size, true)?,
        None => vec![0; count.checked_mul(size).filter(|&length| length <= most_zeros(document))?],
    };
    if let Some(sparse) = accessor.get("sparse").filter(|sparse| sparse.is_object()) {
        let (indices, values) = (sparse.get("indices")?, sparse.get("values")?);
        let replaced = number(sparse, "count")?;
        let index_size = component_size(number(indices, "componentType")?)?;
        let part = |part: &Value, size| {
            run(document, number(part, "bufferView")?, number(part, "byteOffset").unwrap_or(0), replaced, size, false)
        };
        let (indices, values) = (part(indices, index_size)?, part(values, size)?);
        for (index, value) in indices.chunks_exact(index_size).zip(values.chunks_exact(size)) {
            let at = index.iter().rev().fold(0_usize, |at, &byte| at << 8 | usize::from(byte));
            bytes.get_mut(at.checked_mul(size)?..)?.get_mut(..size)?.copy_from_slice(value);
        }
    }
    Some(Entries { bytes, size })
}

/// The `count` entries of accessor `index` as three numbers each, normalised integers scaled to −1…1; `None` if it has others.
pub fn vectors(document: &GltfDocument, index: usize, count: usize) -> Option<Vec<[f64; 3]>> {
    let accessor = list(&document.json, "accessors").get(index)?;
    if components(accessor)? != 3 || number(accessor, "count")? != count {
        return None;
    }
    let Entries { bytes, size } = entries(document, index)?;
    let normalized = accessor.get("normalized").and_then(Value::as_bool).unwrap_or(false);
    let code = number(accessor, "componentType")?;
    let largest = largest(code).filter(|_| normalized);
    let scaled = |x: f64| largest.map_or(x, |largest| (x / largest).max(-1.0));
    let entry = |entry: &[u8]| std::array::from_fn(|i| scaled(component(&entry[i * size / 3..], code)));
    Some(bytes.chunks_exact(size).map(entry).collect())
}

/// Bytes an entry of an accessor.
pub fn entry_size(accessor: &Value) -> Option<usize> {
    Some(component_size(number(accessor, "componentType")?)? * components(accessor)?)
}

/// The number at the start of `bytes`, of component type `code`.
fn component(bytes: &[u8], code: usize) -> f64 {
    match code {
        5120 => f64::from(bytes[0] as i8),
        5121 => f64::from(bytes[0]),
        5122 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        5123 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        5125 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        _ => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}

/// The number of a component type that stands for 1.
fn largest(code: usize) -> Option<f64> {
    match code {
        5120 => Some(127.0),
        5121 => Some(255.0),
        5122 => Some(32767.0),
        5123 => Some(65535.0),
        _ => None,
    }
}

/// The smallest and largest components of entries that `accessor` describes, as its bounds state them.
pub fn bounds(accessor: &Value, bytes: &[u8]) -> Option<(Vec<f64>, Vec<f64>)> {
    let (size, code) = (entry_size(accessor)?, number(accessor, "componentType")?);
    let width = component_size(code)?;
    let mut bounds: Option<(Vec<f64>, Vec<f64>)> = None;
    for entry in bytes.chunks_exact(size) {
        let numbers: Vec<f64> = entry.chunks_exact(width).map(|bytes| component(bytes, code)).collect();
        let (low, high) = bounds.get_or_insert_with(|| (numbers.clone(), numbers.clone()));
        low.iter_mut().zip(&numbers).for_each(|(low, x)| *low = low.min(*x));
        high.iter_mut().zip(&numbers).for_each(|(high, x)| *high = high.max(*x));
    }
    bounds
}

/// An accessor without data is all zeros. More bytes of them than this are taken for damage: memory grows with the file.
fn most_zeros(document: &GltfDocument) -> usize {
    const FEW: usize = 1 << 20;
    const TIMES: usize = 8;
    let bytes = bytes_of(&document.buffers) + document.decompressed.values().map(Vec::len).sum::<usize>();
    bytes.saturating_mul(TIMES).max(FEW)
}

/// The bytes of a view: unpacked if it is compressed.
fn view(document: &GltfDocument, index: usize) -> Option<&[u8]> {
    if let Some(bytes) = document.decompressed.get(&index) {
        return Some(bytes);
    }
    let view = list(&document.json, "bufferViews").get(index)?;
    let start = number(view, "byteOffset").unwrap_or(0);
    let end = start.checked_add(number(view, "byteLength")?)?;
    let buffer = document.buffers.get(number(view, "buffer")?)?;
    // Of padding that the file lacks no entry is made.
    let lacking = end.saturating_sub(buffer.length);
    buffer.get(start..end - lacking).filter(|_| lacking <= buffer.padding)
}

/// `count` entries of `size` bytes from byte `offset` of a view, without the gaps that its stride makes.
fn run(
    document: &GltfDocument,
    index: usize,
    offset: usize,
    count: usize,
    size: usize,
    strided: bool,
) -> Option<Vec<u8>> {
    let json = list(&document.json, "bufferViews").get(index)?;
    let stride = number(json, "byteStride").filter(|&stride| strided && stride >= size).unwrap_or(size);
    let bytes = view(document, index)?.get(offset..)?;
    if count == 0 {
        return Some(Vec::new());
    }
    let needed = stride.checked_mul(count - 1)?.checked_add(size)?;
    let bytes = bytes.get(..needed)?;
    Some(bytes.chunks(stride).flat_map(|entry| &entry[..size]).copied().collect())
}

fn components(accessor: &Value) -> Option<usize> {
    let kinds = [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4)];
    let kind = accessor.get("type")?.as_str()?;
    kinds.into_iter().find(|(name, _)| *name == kind).map(|(_, components)| components)
}

fn component_size(code: usize) -> Option<usize> {
    match code {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn document(accessor: Value, views: Value, bytes: &[u8]) -> GltfDocument {
        let json = json!({ "accessors": [accessor], "bufferViews": views });
        GltfDocument { json, buffers: vec![bytes.to_vec().into()], ..GltfDocument::default() }
    }

    #[test]
    fn gaps_are_left_out_and_sparse_entries_put_in() {
        let views = json!([
            { "buffer": 0, "byteLength": 7, "byteStride": 3.0 },
            { "buffer": 0, "byteOffset": 7, "byteLength": 1 },
            { "buffer": 0, "byteOffset": 8, "byteLength": 2 },
        ]);
        let sparse =
            json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5121 }, "values": { "bufferView": 2 } });
        let accessor = json!({ "bufferView": 0, "byteOffset": 1, "componentType": 5121, "count": 2, "type": "VEC2", "sparse": sparse });
        let found = entries(&document(accessor, views, &[0, 1, 2, 0, 3, 4, 0, 1, 8, 9]), 0).unwrap();
        assert_eq!((&found.bytes[..], found.size), (&[1, 2, 8, 9][..], 2));
    }

    #[test]
    fn normalised_vectors_are_scaled() {
        let accessor =
            json!({ "bufferView": 0, "componentType": 5120, "normalized": true, "count": 1, "type": "VEC3" });
        let document = document(accessor, json!([{ "buffer": 0, "byteLength": 3 }]), &[0x80, 0, 127]);
        assert_eq!(vectors(&document, 0, 1).unwrap(), [[-1.0, 0.0, 1.0]]);
        assert_eq!(vectors(&document, 0, 2), None);
    }

    #[test]
    fn unpacked_views_take_the_place_of_stored_ones() {
        let accessor = json!({ "bufferView": 0, "componentType": 5121, "count": 2, "type": "SCALAR" });
        let mut document = document(accessor, json!([{ "buffer": 5, "byteLength": 1 }]), &[]);
        assert!(entries(&document, 0).is_none());
        document.decompressed = [(0, vec![3, 4])].into();
        assert_eq!(entries(&document, 0).unwrap().bytes, [3, 4]);
    }

    #[test]
    fn damage_is_none() {
        let views = json!([{ "buffer": 0, "byteLength": 4 }]);
        for accessor in [
            json!({ "bufferView": 0, "componentType": 5126, "count": u64::MAX, "type": "VEC3" }),
            json!({ "bufferView": 0, "componentType": 7, "count": 1, "type": "VEC3" }),
            json!({ "bufferView": 1, "componentType": 5126, "count": 1, "type": "SCALAR" }),
            json!({ "componentType": 5126, "count": u64::MAX / 2, "type": "SCALAR" }),
            // A small file asks for 200 MB of zeros.
            json!({ "componentType": 5126, "count": 1 << 24, "type": "VEC3" }),
        ] {
            assert!(entries(&document(accessor, views.clone(), &[0; 4]), 0).is_none());
        }
    }
}
