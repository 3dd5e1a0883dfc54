//! A glTF with all its bytes.

use std::collections::BTreeMap;

use gltf::json::{Index, Root, validation::USize64};
use serde_json::Value;

/// A glTF with all its bytes.
#[derive(Debug, Default)]
pub struct Asset {
    /// What meshes, skins, morph targets and clips need of the JSON.
    pub root: Root,
    /// The JSON, with nothing taken out; it has f64 where [`Root`] has f32.
    pub json: Value,
    /// The contents of its buffers.
    pub buffers: Vec<Vec<u8>>,
    /// The contents of compressed buffer views, by number.
    pub decompressed: BTreeMap<usize, Vec<u8>>,
    /// The contents of accessors whose primitives are compressed, without gaps, by number.
    pub unpacked: BTreeMap<usize, Vec<u8>>,
    /// Sentences about what was left out.
    pub warnings: Vec<String>,
}

/// Files that are small in their compressed form may still grow to this many bytes.
const SMALL: usize = 1 << 28;

/// What is compressed grows by less than this in files that hold anything: constant attributes by 16 to 60.
const MAX_GROWTH: usize = 64;

impl Asset {
    /// The bytes that all compressed data may have together: a small file must not ask for all memory.
    pub fn room(&self) -> usize {
        let bytes: usize = self.buffers.iter().map(Vec::len).sum();
        bytes.saturating_mul(MAX_GROWTH).max(SMALL)
    }
}

/// The way out of most errors.
pub const DAMAGED: &str = "the file is damaged or cut short: export it again";

/// The entry `index` of `list`, called `what` in messages.
///
/// # Errors
///
/// Names the entry that does not exist.
pub fn get<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T, String> {
    list.get(index).ok_or_else(|| format!("{what} {index} does not exist: there are {} (from 0)", list.len()))
}

/// The entry of `list` that `index` refers to, called `what` in messages.
///
/// # Errors
///
/// The error of [`get`].
pub fn follow<'a, T>(list: &'a [T], index: Index<T>, what: &str) -> Result<&'a T, String> {
    get(list, index.value(), what)
}

/// A length or an offset; what does not fit in memory is larger than any file.
pub fn size(number: USize64) -> usize {
    usize::try_from(number.0).unwrap_or(usize::MAX)
}
