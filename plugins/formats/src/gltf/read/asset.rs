//! A glTF with all its bytes.

use std::{
    cell::{Cell, RefCell},
    collections::{BTreeMap, BTreeSet},
};

use gltf::json::{Index, Root, validation::USize64};
use serde_json::Value;

use crate::gltf::document::{Buffer, bytes_of};

/// A glTF with all its bytes.
#[derive(Debug, Default)]
pub struct Asset {
    /// What meshes, skins, morph targets and clips need of the JSON.
    pub root: Root,
    /// The JSON, with nothing taken out; it has f64 where [`Root`] has f32.
    pub json: Value,
    /// The contents of its buffers.
    pub buffers: Vec<Buffer>,
    /// The contents of compressed buffer views, by number.
    pub decompressed: BTreeMap<usize, Vec<u8>>,
    /// The contents of accessors whose primitives are compressed, without gaps, by number.
    pub unpacked: BTreeMap<usize, Vec<u8>>,
    /// Sentences about what was left out.
    pub warnings: Vec<String>,
    /// The bytes of all data: of buffers, and of what was compressed in them.
    pub bytes: usize,
    /// The numbers that were read, vertices and corners included.
    pub taken: Cell<usize>,
    /// The accessors whose sparse entries are not in order, by number, as far as they were read.
    pub unordered: RefCell<BTreeSet<usize>>,
}

/// Files that are small in their compressed form may still grow to this many bytes.
const SMALL: usize = 1 << 26;

/// From small files, too, so many numbers may be read.
const FEW_NUMBERS: usize = 1 << 23;

/// For each byte of data so many numbers may be read; a file in which nothing is used twice has less than one.
const NUMBERS_A_BYTE: usize = 8;

/// What is compressed grows by less than this in files that hold anything: constant attributes by 16 to 60.
const MAX_GROWTH: usize = 64;

impl Asset {
    /// The bytes that all compressed data may have together: a small file must not ask for all memory.
    pub fn room(&self) -> usize {
        bytes_of(&self.buffers).saturating_mul(MAX_GROWTH).max(SMALL)
    }

    /// Counts [`bytes`](Self::bytes).
    pub fn count_bytes(&mut self) {
        let compressed = self.decompressed.values().chain(self.unpacked.values());
        self.bytes = bytes_of(&self.buffers) + compressed.map(Vec::len).sum::<usize>();
    }

    /// Counts `numbers` that are about to be read or made.
    ///
    /// # Errors
    ///
    /// If a file reads its data so often, as meshes under very many nodes, that memory would not grow with the file but with its square.
    pub fn take(&self, numbers: usize) -> Result<(), String> {
        let bytes = self.bytes;
        let most = bytes.saturating_mul(NUMBERS_A_BYTE).max(FEW_NUMBERS);
        let taken = self.taken.get().saturating_add(numbers);
        if taken > most {
            return Err(format!(
                "is used so often that more than {most} numbers come of the {bytes} bytes of data: choose some meshes with `meshes`, or export fewer copies"
            ));
        }
        self.taken.set(taken);
        Ok(())
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
