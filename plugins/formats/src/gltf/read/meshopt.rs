//! `EXT_meshopt_compression` and `KHR_meshopt_compression`: buffer views that are compressed.

use std::collections::{BTreeMap, HashSet};

use gltf::json::{Root, buffer::View};
use meshopt::{
    decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
    decode_index_sequence, decode_vertex_buffer,
};
use serde_json::{Map, Value};

use super::asset::Asset;
use crate::names::shown;

const NAMES: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The codecs reach no higher ratio: a block of 256 vertices takes two bits for four bytes of each, at least.
const MAX_RATIO: usize = 4096;

/// The contents of the compressed buffer views, by number.
///
/// # Errors
///
/// Names the buffer view that cannot be decoded.
pub fn decompress(asset: &Asset) -> Result<BTreeMap<usize, Vec<u8>>, String> {
    let mut decompressed = BTreeMap::new();
    let mut room = asset.room();
    for (index, view) in asset.root.buffer_views.iter().enumerate() {
        let Some((name, settings)) = compression(view) else { continue };
        let decoded = decode(asset, settings, room);
        let decoded =
            decoded.map_err(|message| format!("buffer view {index} cannot be decoded by {name}: {message}"))?;
        room -= decoded.len();
        decompressed.insert(index, decoded);
    }
    Ok(decompressed)
}

/// The buffers that have no data because all their views are compressed in another one.
pub fn fallbacks(root: &Root) -> HashSet<usize> {
    let of_views = |compressed: bool| {
        let views = root.buffer_views.iter().filter(move |view| compression(view).is_some() == compressed);
        views.map(|view| view.buffer.value()).collect::<HashSet<usize>>()
    };
    let plain = of_views(false);
    of_views(true).into_iter().filter(|buffer| !plain.contains(buffer)).collect()
}

fn compression(view: &View) -> Option<(&'static str, &Map<String, Value>)> {
    let others = &view.extensions.as_ref()?.others;
    NAMES.into_iter().find_map(|name| Some((name, others.get(name)?.as_object()?)))
}

/// The contents of a view, of at most `room` bytes.
fn decode(asset: &Asset, settings: &Map<String, Value>, room: usize) -> Result<Vec<u8>, String> {
    let number = |key: &str, default: Option<usize>| -> Result<usize, String> {
        let found = settings.get(key).filter(|value| !value.is_null());
        let Some(value) = found else { return default.ok_or_else(|| format!("`{key}` is missing")) };
        // Some writers give whole numbers as floats.
        let number = value.as_f64().filter(|x| x.fract() == 0.0 && (0.0..9e15).contains(x));
        Ok(number.ok_or_else(|| format!("`{key}` is {}: expected a whole number", shown(&value.to_string())))? as usize)
    };
    let buffer = number("buffer", None)?;
    let bytes = asset.buffers.get(buffer).ok_or_else(|| format!("buffer {buffer} does not exist"))?;
    let (offset, length) = (number("byteOffset", Some(0))?, number("byteLength", None)?);
    let bytes = offset.checked_add(length).and_then(|end| bytes.get(offset..end));
    let bytes = bytes.ok_or_else(|| format!("its data reach beyond buffer {buffer}"))?;
    let (stride, count) = (number("byteStride", None)?, number("count", None)?);
    let size = stride.checked_mul(count).filter(|&size| size <= (bytes.len() + 64).saturating_mul(MAX_RATIO));
    let size = size.ok_or_else(|| format!("{count} entries of {stride} bytes do not fit in {} bytes", bytes.len()))?;
    if size > room {
        return Err(format!("with its {size} bytes all views together are more than {} bytes", asset.room()));
    }
    let text =
        |key: &str, default: &'static str| settings.get(key).and_then(Value::as_str).unwrap_or(default).to_owned();
    let failed = |problem: meshopt::Error| problem.to_string();
    match text("mode", "").as_str() {
        "ATTRIBUTES" => filtered(vertices(bytes, count, stride)?, stride, &text("filter", "NONE")),
        "TRIANGLES" if !count.is_multiple_of(3) => Err(format!("{count} corners do not make whole triangles")),
        "TRIANGLES" if stride == 2 => {
            Ok(flat(decode_index_buffer::<u16>(bytes, count).map_err(failed)?, u16::to_le_bytes))
        }
        "TRIANGLES" if stride == 4 => {
            Ok(flat(decode_index_buffer::<u32>(bytes, count).map_err(failed)?, u32::to_le_bytes))
        }
        "INDICES" if stride == 2 => {
            Ok(flat(decode_index_sequence::<u16>(bytes, count).map_err(failed)?, u16::to_le_bytes))
        }
        "INDICES" if stride == 4 => {
            Ok(flat(decode_index_sequence::<u32>(bytes, count).map_err(failed)?, u32::to_le_bytes))
        }
        mode => Err(format!("entries of {stride} bytes in mode `{}` are not known", shown(mode))),
    }
}

fn flat<T, const N: usize>(values: Vec<T>, bytes: fn(T) -> [u8; N]) -> Vec<u8> {
    values.into_iter().flat_map(bytes).collect()
}

/// A vertex of `N` words; arrays of more than 32 have no default of their own.
#[derive(Clone)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

fn vertices_of<const N: usize>(bytes: &[u8], count: usize) -> Result<Vec<u8>, String> {
    let vertices = decode_vertex_buffer::<Words<N>>(bytes, count).map_err(|problem| problem.to_string())?;
    // The decoder fills memory byte by byte, so that the order of the machine is undone here.
    Ok(vertices.iter().flat_map(|vertex| vertex.0.iter().flat_map(|word| word.to_ne_bytes())).collect())
}

/// Vertices of `stride` bytes, which the decoder knows at compile time.
fn vertices(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    macro_rules! by_words {
        ($($words:literal)*) => {
            match (stride % 4, stride / 4) {
                $((0, $words) => vertices_of::<$words>(bytes, count),)*
                _ => Err(format!("vertices have {stride} bytes: expected a multiple of 4 up to 256")),
            }
        };
    }
    by_words!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64)
}

/// The vertices with the filter undone.
fn filtered(mut bytes: Vec<u8>, stride: usize, filter: &str) -> Result<Vec<u8>, String> {
    let small =
        |bytes: &[u8]| -> Vec<[i8; 4]> { bytes.as_chunks().0.iter().map(|v: &[u8; 4]| v.map(|x| x as i8)).collect() };
    let large = |bytes: &[u8]| -> Vec<[i16; 4]> {
        let vertex = |v: &[u8; 8]| std::array::from_fn(|i| i16::from_le_bytes([v[2 * i], v[2 * i + 1]]));
        bytes.as_chunks().0.iter().map(vertex).collect()
    };
    let from_small = |values: Vec<[i8; 4]>| values.into_iter().flatten().map(|x| x as u8).collect();
    let from_large = |values: Vec<[i16; 4]>| values.into_iter().flatten().flat_map(i16::to_le_bytes).collect();
    bytes = match (filter, stride) {
        ("NONE", _) => bytes,
        ("OCTAHEDRAL", 4) => from_small(edited(small(&bytes), decode_filter_oct)),
        ("OCTAHEDRAL", 8) => from_large(edited(large(&bytes), decode_filter_oct)),
        ("QUATERNION", 8) => from_large(edited(large(&bytes), decode_filter_quat)),
        ("EXPONENTIAL", _) => {
            let words = bytes.as_chunks().0.iter().map(|&word| [u32::from_le_bytes(word)]).collect();
            edited(words, decode_filter_exp).into_iter().flat_map(|[word]| word.to_le_bytes()).collect()
        }
        ("COLOR", 4) => from_small(edited(small(&bytes), decode_filter_color)),
        ("COLOR", 8) => from_large(edited(large(&bytes), decode_filter_color)),
        _ => return Err(format!("the filter `{}` is not known for entries of {stride} bytes", shown(filter))),
    };
    Ok(bytes)
}

fn edited<T>(mut values: Vec<T>, edit: fn(&mut [T])) -> Vec<T> {
    edit(&mut values);
    values
}
