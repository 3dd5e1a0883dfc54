//! Bytes of buffer views, every bound checked.

use gltf::json::{Index, buffer};

use super::{
    asset::{Asset, follow, get, size},
    container::MAX_PADDING,
};

/// Entries at equal distances in a buffer.
pub struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Run<'a> {
    /// The entries.
    pub fn entries(&self) -> impl Iterator<Item = &'a [u8]> {
        let &Self { bytes, stride, size, count } = self;
        (0..count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

/// `count` entries of `entry_size` bytes from byte `offset` of a view, checked against view and buffer.
///
/// # Errors
///
/// Says what the entries are too many for.
pub fn run(
    asset: &Asset,
    view_index: Index<buffer::View>,
    offset: usize,
    count: usize,
    entry_size: usize,
    strided: bool,
) -> Result<Run<'_>, String> {
    let view = follow(&asset.root.buffer_views, view_index, "buffer view")?;
    let stride = view.byte_stride.map_or(0, |stride| stride.0);
    let stride = if strided && stride > 0 { stride } else { entry_size };
    if stride < entry_size {
        return Err(format!("has entries of {entry_size} bytes, {stride} bytes apart"));
    }
    let bytes = view_bytes(asset, view_index.value())?;
    let needed = match count {
        0 => Some(offset.min(bytes.len())),
        _ => stride.checked_mul(count - 1).and_then(|n| n.checked_add(entry_size)).and_then(|n| n.checked_add(offset)),
    };
    match needed.filter(|&needed| needed <= bytes.len()) {
        Some(needed) => Ok(Run { bytes: &bytes[offset.min(needed)..], stride, size: entry_size, count }),
        None => Err(format!(
            "has {count} entries of {entry_size} bytes, more than the {} bytes of buffer view {view_index}",
            bytes.len()
        )),
    }
}

/// The bytes of buffer view `index`, decompressed; its length may count padding that the buffer lacks.
///
/// # Errors
///
/// Names the view if it reaches beyond its buffer.
pub fn view_bytes(asset: &Asset, index: usize) -> Result<&[u8], String> {
    if let Some(bytes) = asset.decompressed.get(&index) {
        return Ok(bytes);
    }
    let view = get(&asset.root.buffer_views, index, "buffer view")?;
    let buffer = get(&asset.buffers, view.buffer.value(), "buffer")?;
    let start = view.byte_offset.map_or(0, size);
    let end = start.checked_add(size(view.byte_length)).filter(|&end| end - end.min(buffer.len()) <= MAX_PADDING);
    end.and_then(|end| buffer.get(start..end.min(buffer.len())))
        .ok_or_else(|| format!("needs buffer view {index}, which reaches beyond its buffer of {} bytes", buffer.len()))
}
