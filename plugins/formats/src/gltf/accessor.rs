//! Numbers out of buffers: all component types, normalised integers, strides, sparse entries, every bound checked.

use super::{
    container::Asset,
    schema::{Accessor, get},
};

/// An accessor without data is all zeros; one longer than this is taken for damage rather than filled.
const MAX_ZEROS: usize = 1 << 24;

/// Reads accessor `index` as #entries × `N` numbers; integers that are marked so are scaled to 0…1 or −1…1.
///
/// # Errors
///
/// Names the accessor, and what about it is wrong.
pub fn numbers<const N: usize>(asset: &Asset, index: usize) -> Result<Vec<[f64; N]>, String> {
    let accessor = get(&asset.root.accessors, index, "accessor")?;
    read(asset, accessor).map_err(|message| format!("accessor {index} {message}"))
}

/// Reads accessor `index` as whole numbers.
///
/// # Errors
///
/// The errors of [`numbers`].
pub fn indices(asset: &Asset, index: usize) -> Result<Vec<u32>, String> {
    let accessor = get(&asset.root.accessors, index, "accessor")?;
    if !matches!(accessor.component_type, U8 | U16 | U32) {
        return Err(format!(
            "accessor {index} has component type {}: expected unsigned integers",
            accessor.component_type
        ));
    }
    Ok(numbers::<1>(asset, index)?.into_iter().map(|[x]| x as u32).collect())
}

const I8: u32 = 5120;
const U8: u32 = 5121;
const I16: u32 = 5122;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

fn read<const N: usize>(asset: &Asset, accessor: &Accessor) -> Result<Vec<[f64; N]>, String> {
    let expected = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
    if accessor.kind != expected {
        return Err(format!("has type {}: expected {expected}", accessor.kind));
    }
    let component = Component::new(accessor.component_type, accessor.normalized)?;
    let mut values = match accessor.buffer_view {
        Some(view) => {
            let size = N * component.size;
            let bytes = run(asset, view, accessor.byte_offset, accessor.count, size, true)?;
            bytes.entries().map(|entry| component.read(entry)).collect()
        }
        None if accessor.count > MAX_ZEROS => return Err(format!("has {} entries but no data", accessor.count)),
        None => vec![[0.0; N]; accessor.count],
    };
    if let Some(sparse) = &accessor.sparse {
        let index = Component::new(sparse.indices.component_type, false)?;
        let (at, with) = (&sparse.indices, &sparse.values);
        let indices = run(asset, at.buffer_view, at.byte_offset, sparse.count, index.size, false)?;
        let replaced = run(asset, with.buffer_view, with.byte_offset, sparse.count, N * component.size, false)?;
        for (at, entry) in indices.entries().zip(replaced.entries()) {
            let [at] = index.read::<1>(at);
            let count = values.len();
            let place = values.get_mut(at as usize).filter(|_| at >= 0.0);
            *place.ok_or_else(|| format!("replaces entry {at} of {count}"))? = component.read(entry);
        }
    }
    Ok(values)
}

/// How one number is stored.
struct Component {
    size: usize,
    read: fn(&[u8]) -> f64,
    /// The divisor of a stored number.
    scale: f64,
}

impl Component {
    fn new(code: u32, normalized: bool) -> Result<Self, String> {
        let (size, read, largest): (_, fn(&[u8]) -> f64, f64) = match code {
            I8 => (1, |b| f64::from(b[0] as i8), 127.0),
            U8 => (1, |b| f64::from(b[0]), 255.0),
            I16 => (2, |b| f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            U16 => (2, |b| f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            U32 => (4, |b| f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4_294_967_295.0),
            F32 => (4, |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 1.0),
            _ => return Err(format!("has unknown component type {code}")),
        };
        Ok(Self { size, read, scale: if normalized { largest } else { 1.0 } })
    }

    fn read<const N: usize>(&self, entry: &[u8]) -> [f64; N] {
        std::array::from_fn(|i| {
            let value = (self.read)(&entry[i * self.size..]) / self.scale;
            // The most negative of signed integers would be a little below -1.
            if self.scale > 1.0 { value.max(-1.0) } else { value }
        })
    }
}

/// Entries at equal distances in a buffer.
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Run<'a> {
    fn entries(&self) -> impl Iterator<Item = &'a [u8]> {
        let &Self { bytes, stride, size, count } = self;
        (0..count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

/// `count` entries of `size` bytes from byte `offset` of a view, checked against view and buffer.
fn run(asset: &Asset, view: usize, offset: usize, count: usize, size: usize, strided: bool) -> Result<Run<'_>, String> {
    let view_index = view;
    let view = get(&asset.root.buffer_views, view, "buffer view")?;
    let buffer = get(&asset.buffers, view.buffer, "buffer")?;
    let stride = view.byte_stride.filter(|&stride| strided && stride > 0).unwrap_or(size);
    if stride < size {
        return Err(format!("has entries of {size} bytes, {stride} bytes apart"));
    }
    let end = view.byte_offset.checked_add(view.byte_length);
    let bytes = end.and_then(|end| buffer.get(view.byte_offset..end)).ok_or_else(|| {
        format!("needs buffer view {view_index}, which reaches beyond its buffer of {} bytes", buffer.len())
    })?;
    let needed = match count {
        0 => Some(offset.min(bytes.len())),
        _ => stride.checked_mul(count - 1).and_then(|n| n.checked_add(size)).and_then(|n| n.checked_add(offset)),
    };
    match needed.filter(|&needed| needed <= bytes.len()) {
        Some(needed) => Ok(Run { bytes: &bytes[offset.min(needed)..], stride, size, count }),
        None => Err(format!(
            "has {count} entries of {size} bytes, more than the {} bytes of buffer view {view_index}",
            bytes.len()
        )),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn asset(accessor: Value, views: Value, bytes: &[u8]) -> Asset {
        let root = json!({ "accessors": [accessor], "bufferViews": views, "buffers": [{ "byteLength": bytes.len() }] });
        Asset { root: serde_json::from_value(root).unwrap(), buffers: vec![bytes.to_vec()] }
    }

    #[test]
    fn normalised_integers_are_scaled() {
        let bytes = [0x80, 0x81, 0x7f, 0, 0, 0, 0, 0];
        let scaled = json!({ "bufferView": 0, "componentType": I8, "normalized": true, "count": 1, "type": "VEC3" });
        let views = json!([{ "buffer": 0, "byteLength": 8 }]);
        assert_eq!(numbers::<3>(&asset(scaled, views.clone(), &bytes), 0).unwrap(), [[-1.0, -1.0, 1.0]]);
        let plain = json!({ "bufferView": 0, "componentType": I8, "count": 1, "type": "VEC3" });
        assert_eq!(numbers::<3>(&asset(plain, views, &bytes), 0).unwrap(), [[-128.0, -127.0, 127.0]]);
    }

    #[test]
    fn entries_lie_a_stride_apart_and_the_last_may_end_the_view() {
        let bytes = [9, 1, 2, 0, 0, 3, 4, 0, 0, 5, 6];
        let accessor = json!({ "bufferView": 0, "byteOffset": 1, "componentType": U8, "count": 3, "type": "VEC2" });
        let views = json!([{ "buffer": 0, "byteLength": 11, "byteStride": 4 }]);
        assert_eq!(numbers::<2>(&asset(accessor, views, &bytes), 0).unwrap(), [[1., 2.], [3., 4.], [5., 6.]]);
    }

    #[test]
    fn sparse_entries_replace_zeros() {
        let mut bytes = vec![2, 0, 0, 0];
        bytes.extend_from_slice(&1.5_f32.to_le_bytes());
        let views = json!([{ "buffer": 0, "byteLength": 1 }, { "buffer": 0, "byteOffset": 4, "byteLength": 4 }]);
        let sparse = json!({
            "count": 1, "indices": { "bufferView": 0, "componentType": U8 }, "values": { "bufferView": 1 }
        });
        let accessor = json!({ "componentType": F32, "count": 3, "type": "SCALAR", "sparse": sparse });
        assert_eq!(numbers::<1>(&asset(accessor.clone(), views.clone(), &bytes), 0).unwrap(), [[0.0], [0.0], [1.5]]);
        bytes[0] = 3;
        let error = numbers::<1>(&asset(accessor, views, &bytes), 0).unwrap_err();
        assert_eq!(error, "accessor 0 replaces entry 3 of 3");
    }

    #[test]
    fn accessors_that_reach_too_far_say_so() {
        let cases = [
            (
                json!({ "bufferView": 0, "componentType": F32, "count": 2, "type": "VEC3" }),
                "accessor 0 has 2 entries of 12 bytes, more than the 12 bytes of buffer view 0",
            ),
            (
                json!({ "bufferView": 0, "componentType": F32, "count": u64::MAX, "type": "VEC3" }),
                "accessor 0 has 18446744073709551615 entries of 12 bytes, more than the 12 bytes of buffer view 0",
            ),
            (
                json!({ "bufferView": 1, "componentType": F32, "count": 1, "type": "VEC3" }),
                "accessor 0 needs buffer view 1, which reaches beyond its buffer of 12 bytes",
            ),
            (
                json!({ "bufferView": 2, "componentType": F32, "count": 1, "type": "VEC3" }),
                "accessor 0 buffer view 2 does not exist: there are 2 (from 0)",
            ),
            (
                json!({ "componentType": F32, "count": 1_000_000_000, "type": "VEC3" }),
                "accessor 0 has 1000000000 entries but no data",
            ),
            (
                json!({ "bufferView": 0, "componentType": 7, "count": 1, "type": "VEC3" }),
                "accessor 0 has unknown component type 7",
            ),
            (
                json!({ "bufferView": 0, "componentType": F32, "count": 1, "type": "VEC2" }),
                "accessor 0 has type VEC2: expected VEC3",
            ),
        ];
        let views = json!([{ "buffer": 0, "byteLength": 12 }, { "buffer": 0, "byteOffset": 8, "byteLength": 12 }]);
        for (accessor, expected) in cases {
            assert_eq!(numbers::<3>(&asset(accessor, views.clone(), &[0; 12]), 0).unwrap_err(), expected);
        }
        assert_eq!(
            numbers::<3>(&asset(json!({}), json!([]), &[]), 1).unwrap_err(),
            "accessor 1 does not exist: there are 1 (from 0)"
        );
    }
}
