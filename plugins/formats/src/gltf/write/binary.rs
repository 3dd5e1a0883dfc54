//! The numbers of a glTF in the making, written as they come so that memory does not grow with the poses.

use std::io::{self, Write};

use serde_json::{Value, json};

use crate::tail::Tail;

const U8: u32 = 5121;
const U16: u32 = 5123;
const U32: u32 = 5125;
const F32: u32 = 5126;

/// More weights than this are written as sparse entries, since nearly all are 0.
const MAX_DENSE_WEIGHTS: usize = 64 * 64;

/// The use of a buffer view, as glTF numbers it.
#[derive(Clone, Copy)]
enum Use {
    Attribute = 34962,
    Indices = 34963,
}

/// A buffer and the views and accessors into it.
pub struct Binary {
    /// The bytes.
    pub tail: Tail,
    /// The JSON of buffer views.
    pub views: Vec<Value>,
    /// The JSON of accessors.
    pub accessors: Vec<Value>,
}

impl Binary {
    /// An empty buffer, whose bytes go to `tail`.
    pub fn new(tail: Tail) -> Self {
        Self { tail, views: Vec::new(), accessors: Vec::new() }
    }

    /// Bytes written.
    pub fn length(&self) -> u64 {
        self.tail.length()
    }

    /// Adds bytes as they are, padded to a multiple of four. The offset of the first.
    ///
    /// # Errors
    ///
    /// Those of the file, as with all of these.
    pub fn append(&mut self, bytes: &[u8]) -> io::Result<u64> {
        let offset = self.length();
        let padded = bytes.len().next_multiple_of(4);
        self.tail.write_all(bytes)?;
        self.tail.write_all(&[0; 3][..padded - bytes.len()])?;
        Ok(offset)
    }

    /// Adds an attribute of vertices; its bounds go into the accessor if `bounds`. The accessor.
    pub fn attribute<const N: usize>(&mut self, values: &[[f32; N]], bounds: bool) -> io::Result<usize> {
        let view = self.view(&bytes(values), Some(Use::Attribute))?;
        let mut accessor = json!({ "bufferView": view, "componentType": F32, "count": values.len(), "type": kind(N) });
        if bounds {
            add_bounds(&mut accessor, values);
        }
        Ok(self.accessor(accessor))
    }

    /// Adds displacements, as sparse entries where that is smaller. The accessor.
    pub fn displacements(&mut self, values: &[[f32; 3]], bounds: bool) -> io::Result<usize> {
        let moved: Vec<u32> = (0..values.len() as u32).filter(|&i| values[i as usize] != [0.0; 3]).collect();
        let mut accessor = json!({ "componentType": F32, "count": values.len(), "type": "VEC3" });
        let (code, index_size) = index_type(values.len());
        // The second view and its entry in the JSON cost about as much as twenty displacements.
        if !moved.is_empty() && moved.len() * (12 + index_size) + 240 >= 12 * values.len() {
            return self.attribute(values, bounds);
        }
        if !moved.is_empty() {
            let indices = self.view(&index_bytes(&moved, index_size), None)?;
            let entries: Vec<_> = moved.iter().map(|&i| values[i as usize]).collect();
            let entries = self.view(&bytes(&entries), None)?;
            accessor["sparse"] = json!({
                "count": moved.len(),
                "indices": { "bufferView": indices, "componentType": code },
                "values": { "bufferView": entries },
            });
        }
        if bounds {
            add_bounds(&mut accessor, values);
        }
        Ok(self.accessor(accessor))
    }

    /// Adds corners of triangles among `vertices` vertices. The accessor.
    pub fn indices(&mut self, indices: &[u32], vertices: usize) -> io::Result<usize> {
        // Graphics cards draw from 16 or 32 bits.
        let (code, size) = if vertices < 1 << 16 { (U16, 2) } else { (U32, 4) };
        let view = self.view(&index_bytes(indices, size), Some(Use::Indices))?;
        Ok(self
            .accessor(json!({ "bufferView": view, "componentType": code, "count": indices.len(), "type": "SCALAR" })))
    }

    /// Adds the times of keyframes, in seconds. The accessor.
    pub fn times(&mut self, times: &[f32]) -> io::Result<usize> {
        let values: Vec<_> = times.iter().map(|&time| [time]).collect();
        let accessor = self.keys(&values)?;
        add_bounds(&mut self.accessors[accessor], &values);
        Ok(accessor)
    }

    /// Adds the values of keyframes. The accessor.
    pub fn keys<const N: usize>(&mut self, values: &[[f32; N]]) -> io::Result<usize> {
        let view = self.view(&bytes(values), None)?;
        Ok(self.accessor(json!({ "bufferView": view, "componentType": F32, "count": values.len(), "type": kind(N) })))
    }

    /// Adds weights of `width` morph targets at keys: at key i target `targets[i]` has 1 and all others 0. The accessor.
    pub fn weights(&mut self, targets: &[usize], width: usize) -> io::Result<usize> {
        let count = targets.len() * width;
        let mut accessor = json!({ "componentType": F32, "count": count, "type": "SCALAR" });
        let ones: Vec<u32> = targets.iter().enumerate().map(|(key, target)| (key * width + target) as u32).collect();
        if count <= MAX_DENSE_WEIGHTS {
            let mut weights = vec![[0.0_f32]; count];
            ones.iter().for_each(|&one| weights[one as usize] = [1.0]);
            accessor["bufferView"] = self.view(&bytes(&weights), None)?.into();
        } else {
            let (code, size) = index_type(count);
            let indices = self.view(&index_bytes(&ones, size), None)?;
            let values = self.view(&bytes(&vec![[1.0_f32]; ones.len()]), None)?;
            accessor["sparse"] = json!({
                "count": ones.len(),
                "indices": { "bufferView": indices, "componentType": code },
                "values": { "bufferView": values },
            });
        }
        Ok(self.accessor(accessor))
    }

    /// Adds entries of the layout that `like`, the JSON of an accessor, describes. The accessor.
    pub fn like(&mut self, like: &Value, entries: &[u8], count: usize) -> io::Result<usize> {
        let view = self.view(entries, None)?;
        let mut accessor = json!({ "bufferView": view });
        for key in ["componentType", "normalized", "type"] {
            if let Some(value) = like.get(key) {
                accessor[key] = value.clone();
            }
        }
        accessor["count"] = count.into();
        Ok(self.accessor(accessor))
    }

    /// Adds `count` displacements of zero, which need no bytes. The accessor.
    pub fn zeros(&mut self, count: usize) -> usize {
        let zero = [0.0; 3];
        self.accessor(json!({ "componentType": F32, "count": count, "type": "VEC3", "min": zero, "max": zero }))
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds bytes as a view of their own. The view.
    pub fn plain_view(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.view(bytes, None)
    }

    /// Adds bytes, padded to a multiple of four. The view.
    fn view(&mut self, bytes: &[u8], usage: Option<Use>) -> io::Result<usize> {
        let mut view = json!({ "buffer": 0, "byteOffset": self.append(bytes)?, "byteLength": bytes.len() });
        if let Some(usage) = usage {
            view["target"] = (usage as u32).into();
        }
        self.views.push(view);
        Ok(self.views.len() - 1)
    }
}

fn kind(components: usize) -> &'static str {
    ["SCALAR", "VEC2", "VEC3", "VEC4"][components - 1]
}

fn bytes<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect()
}

/// The smallest type that counts to `count`.
fn index_type(count: usize) -> (u32, usize) {
    match count {
        ..=0x100 => (U8, 1),
        0x101..=0x1_0000 => (U16, 2),
        _ => (U32, 4),
    }
}

fn index_bytes(indices: &[u32], size: usize) -> Vec<u8> {
    indices.iter().flat_map(|index| index.to_le_bytes().into_iter().take(size)).collect()
}

/// Smallest and largest components, which must be exactly those of the f32.
fn add_bounds<const N: usize>(accessor: &mut Value, values: &[[f32; N]]) {
    let bound = |choose: fn(f32, f32) -> f32| -> Vec<f64> {
        let of = |i: usize| values.iter().map(|value| value[i]).reduce(choose).unwrap_or_default();
        (0..N).map(|i| f64::from(of(i))).collect()
    };
    accessor["min"] = bound(f32::min).into();
    accessor["max"] = bound(f32::max).into();
}
