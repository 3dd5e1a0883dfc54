//! Numbers out of buffers: all component types, normalised integers, strides, sparse entries, every bound checked.

use std::collections::BTreeMap;

use gltf::json::{
    Accessor, Index,
    accessor::{ComponentType, Type},
    validation::Checked,
};

use super::{
    asset::{Asset, follow, size},
    views::run,
};

/// An accessor without data is all zeros; one longer than this is taken for damage rather than filled.
const MAX_ZEROS: usize = 1 << 24;

/// An entry of an accessor, after its number.
pub type Entry<const N: usize> = (usize, [f64; N]);

/// Reads accessor `index` as #entries × `N` numbers; integers that are marked so are scaled to 0…1 or −1…1.
///
/// Matrices are 16 numbers, column by column.
///
/// # Errors
///
/// Names the accessor, and what about it is wrong.
pub fn numbers<const N: usize>(asset: &Asset, index: Index<Accessor>) -> Result<Vec<[f64; N]>, String> {
    let accessor = follow(&asset.root.accessors, index, "accessor")?;
    read(asset, index, accessor, true).map_err(|message| format!("accessor {index} {message}"))
}

/// Reads accessor `index` as #entries × `N` whole numbers from 0, as indices and joints are; some files store these as floats.
///
/// A mark that asks for scaling is ignored.
///
/// # Errors
///
/// The errors of [`numbers`], and one for numbers that are not whole.
pub fn whole<const N: usize>(asset: &Asset, index: Index<Accessor>) -> Result<Vec<[u32; N]>, String> {
    let accessor = follow(&asset.root.accessors, index, "accessor")?;
    let values = read(asset, index, accessor, false).map_err(|message| format!("accessor {index} {message}"))?;
    let is_whole = |x: &f64| x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(x);
    match values.as_flattened().iter().find(|x| !is_whole(x)) {
        Some(x) => Err(format!("accessor {index} has {x}: expected whole numbers from 0")),
        None => Ok(values.into_iter().map(|entry: [f64; N]| entry.map(|x| x as u32)).collect()),
    }
}

/// The number of entries of accessor `index`.
///
/// # Errors
///
/// Names an accessor that does not exist.
pub fn count(asset: &Asset, index: Index<Accessor>) -> Result<usize, String> {
    Ok(size(follow(&asset.root.accessors, index, "accessor")?.count))
}

/// Whether the bytes of accessor `index` lie within its buffer view; true if it has none, or is of no known type.
pub fn check_reach(asset: &Asset, index: usize) -> bool {
    let accessor = &asset.root.accessors[index];
    let (Some(view), Checked::Valid(kind), Checked::Valid(component)) =
        (accessor.buffer_view, accessor.type_, accessor.component_type)
    else {
        return true;
    };
    let entry = kind.multiplicity() * component.0.size();
    let (offset, count) = (accessor.byte_offset.map_or(0, size), size(accessor.count));
    asset.unpacked.contains_key(&index) || run(asset, view, offset, count, entry, true).is_ok()
}

/// Whether accessor `index` has data for all its entries.
pub fn has_data(asset: &Asset, index: Index<Accessor>) -> bool {
    let accessor = asset.root.accessors.get(index.value());
    accessor.is_some_and(|accessor| accessor.buffer_view.is_some()) || asset.unpacked.contains_key(&index.value())
}

fn read<const N: usize>(
    asset: &Asset,
    index: Index<Accessor>,
    accessor: &Accessor,
    scaled: bool,
) -> Result<Vec<[f64; N]>, String> {
    check_type(N, &accessor.type_)?;
    let component = component(accessor, scaled)?;
    let entry_size = N * component.size;
    let count = size(accessor.count);
    let mut values = match (asset.unpacked.get(&index.value()), accessor.buffer_view) {
        (Some(bytes), _) => {
            asset.take(bytes.len() / component.size)?;
            bytes.chunks_exact(entry_size).map(|entry| component.read(entry)).collect()
        }
        (None, Some(view)) => {
            let bytes = run(asset, view, accessor.byte_offset.map_or(0, size), count, entry_size, true)?;
            asset.take(N * count)?;
            bytes.entries().map(|entry| component.read(entry)).collect()
        }
        (None, None) if count > MAX_ZEROS => return Err(format!("has {count} entries but no data")),
        (None, None) => {
            asset.take(N * count)?;
            vec![[0.0; N]; count]
        }
    };
    for (at, entry) in replaced(asset, index, accessor, &component, count)? {
        values[at] = entry;
    }
    Ok(values)
}

/// The entries that accessor `index` has in place of zeros, by their number; `None` if it has data for all entries.
///
/// So a morph target that moves few vertices takes room for these alone.
///
/// # Errors
///
/// The errors of [`numbers`].
pub fn few<const N: usize>(asset: &Asset, index: Index<Accessor>) -> Result<Option<Vec<Entry<N>>>, String> {
    let accessor = follow(&asset.root.accessors, index, "accessor")?;
    if has_data(asset, index) {
        return Ok(None);
    }
    let read = || {
        check_type(N, &accessor.type_)?;
        replaced(asset, index, accessor, &component(accessor, true)?, size(accessor.count))
    };
    read().map(Some).map_err(|message| format!("accessor {index} {message}"))
}

/// The sparse entries of an accessor of `count` entries, by their number; where two have one, the later.
fn replaced<const N: usize>(
    asset: &Asset,
    number: Index<Accessor>,
    accessor: &Accessor,
    component: &Component,
    count: usize,
) -> Result<Vec<Entry<N>>, String> {
    let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
    let Checked::Valid(kind) = sparse.indices.component_type else {
        return Err("replaces entries by an unknown component type".into());
    };
    if kind.0 == ComponentType::F32 {
        return Err("replaces entries by indices that are floats: expected whole numbers".into());
    }
    let index = Component::new(kind.0, false);
    let entries = size(sparse.count);
    let (at, with) = (&sparse.indices, &sparse.values);
    let indices = run(asset, at.buffer_view, size(at.byte_offset), entries, index.size, false)?;
    let values = run(asset, with.buffer_view, size(with.byte_offset), entries, N * component.size, false)?;
    asset.take((N + 1) * entries)?;
    let mut replaced = BTreeMap::new();
    let mut last = -1.0;
    for (at, entry) in indices.entries().zip(values.entries()) {
        let [at] = index.read::<1>(at);
        if !(at >= 0.0 && at < count as f64) {
            return Err(format!("replaces entry {at} of {count}"));
        }
        if at <= last {
            asset.unordered.borrow_mut().insert(number.value());
        }
        last = at;
        replaced.insert(at as usize, component.read(entry));
    }
    Ok(replaced.into_iter().collect())
}

fn component(accessor: &Accessor, scaled: bool) -> Result<Component, String> {
    match accessor.component_type {
        Checked::Valid(kind) => Ok(Component::new(kind.0, scaled && accessor.normalized)),
        Checked::Invalid => Err("has an unknown component type".into()),
    }
}

fn check_type(components: usize, found: &Checked<Type>) -> Result<(), String> {
    let (expected, name) = match components {
        1 => (Type::Scalar, "SCALAR"),
        2 => (Type::Vec2, "VEC2"),
        3 => (Type::Vec3, "VEC3"),
        4 => (Type::Vec4, "VEC4"),
        _ => (Type::Mat4, "MAT4"),
    };
    match found {
        Checked::Valid(found) if *found == expected => Ok(()),
        Checked::Valid(found) => {
            let found = serde_json::to_value(found).unwrap_or_default();
            Err(format!("has type {}: expected {name}", found.as_str().unwrap_or_default()))
        }
        Checked::Invalid => Err(format!("has an unknown type: expected {name}")),
    }
}

/// How one number is stored.
struct Component {
    size: usize,
    read: fn(&[u8]) -> f64,
    /// The divisor of a stored number.
    scale: f64,
}

impl Component {
    fn new(kind: ComponentType, normalized: bool) -> Self {
        let (read, largest): (fn(&[u8]) -> f64, f64) = match kind {
            ComponentType::I8 => (|b| f64::from(b[0] as i8), 127.0),
            ComponentType::U8 => (|b| f64::from(b[0]), 255.0),
            ComponentType::I16 => (|b| f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            ComponentType::U16 => (|b| f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            ComponentType::U32 => (|b| f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])), 4_294_967_295.0),
            ComponentType::F32 => (|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 1.0),
        };
        Self { size: kind.size(), read, scale: if normalized { largest } else { 1.0 } }
    }

    fn read<const N: usize>(&self, entry: &[u8]) -> [f64; N] {
        std::array::from_fn(|i| {
            let value = (self.read)(&entry[i * self.size..]) / self.scale;
            // The most negative of signed integers would be a little below -1.
            if self.scale > 1.0 { value.max(-1.0) } else { value }
        })
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::{super::tolerant, *};

    const I8: u32 = 5120;
    const U8: u32 = 5121;
    const F32: u32 = 5126;

    fn asset(accessor: Value, views: Value, bytes: &[u8]) -> Asset {
        let root = json!({ "accessors": [accessor], "bufferViews": views, "buffers": [{ "byteLength": bytes.len() }] });
        let mut root = tolerant::reduce(&root).json;
        root["asset"]["version"] = "2.0".into();
        Asset { root: serde_json::from_value(root).unwrap(), buffers: vec![bytes.to_vec().into()], ..Asset::default() }
    }

    #[test]
    fn normalised_integers_are_scaled() {
        let bytes = [0x80, 0x81, 0x7f, 0, 0, 0, 0, 0];
        let scaled = json!({ "bufferView": 0, "componentType": I8, "normalized": true, "count": 1, "type": "VEC3" });
        let views = json!([{ "buffer": 0, "byteLength": 8 }]);
        assert_eq!(numbers::<3>(&asset(scaled, views.clone(), &bytes), Index::new(0)).unwrap(), [[-1.0, -1.0, 1.0]]);
        let plain = json!({ "bufferView": 0, "componentType": I8, "count": 1, "type": "VEC3" });
        assert_eq!(numbers::<3>(&asset(plain, views, &bytes), Index::new(0)).unwrap(), [[-128.0, -127.0, 127.0]]);
    }

    #[test]
    fn entries_lie_a_stride_apart_and_the_last_may_end_the_view() {
        let bytes = [9, 1, 2, 0, 0, 3, 4, 0, 0, 5, 6];
        let accessor = json!({ "bufferView": 0, "byteOffset": 1, "componentType": U8, "count": 3, "type": "VEC2" });
        let views = json!([{ "buffer": 0, "byteLength": 11, "byteStride": 4 }]);
        assert_eq!(
            numbers::<2>(&asset(accessor, views, &bytes), Index::new(0)).unwrap(),
            [[1., 2.], [3., 4.], [5., 6.]]
        );
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
        assert_eq!(
            numbers::<1>(&asset(accessor.clone(), views.clone(), &bytes), Index::new(0)).unwrap(),
            [[0.0], [0.0], [1.5]]
        );
        bytes[0] = 3;
        let error = numbers::<1>(&asset(accessor, views, &bytes), Index::new(0)).unwrap_err();
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
                "accessor 0 has an unknown component type",
            ),
            (
                json!({ "bufferView": 0, "componentType": F32, "count": 1, "type": "VEC2" }),
                "accessor 0 has type VEC2: expected VEC3",
            ),
        ];
        let views = json!([{ "buffer": 0, "byteLength": 12 }, { "buffer": 0, "byteOffset": 8, "byteLength": 12 }]);
        for (accessor, expected) in cases {
            assert_eq!(numbers::<3>(&asset(accessor, views.clone(), &[0; 12]), Index::new(0)).unwrap_err(), expected);
        }
        assert_eq!(
            numbers::<3>(
                &asset(json!({ "componentType": F32, "count": 0, "type": "SCALAR" }), json!([]), &[]),
                Index::new(1)
            )
            .unwrap_err(),
            "accessor 1 does not exist: there are 1 (from 0)"
        );
    }
}
