//! The chunks of a binary glTF.

use crate::names::quoted;

/// The chunks that matter.
#[derive(Debug)]
pub struct Chunks<'b> {
    /// The JSON.
    pub json: &'b [u8],
    /// The first buffer.
    pub binary: Option<Binary<'b>>,
    /// The number of chunks of other kinds.
    pub others: usize,
    /// Sentences about chunks that stand or count otherwise than they should.
    pub warnings: Vec<String>,
}

/// A chunk of bytes.
#[derive(Clone, Copy, Debug)]
pub struct Binary<'b> {
    /// The bytes that are there.
    pub bytes: &'b [u8],
    /// Whether the file ends before the chunk does.
    pub is_cut: bool,
}

/// Padding is at most so long: some writers count it in lengths without writing it.
pub const MAX_PADDING: usize = 3;

/// The chunks of a GLB, or the JSON of a glTF as text, told apart by their first bytes.
///
/// The header's length is not relied on: some writers leave it as it was before they changed the chunks, which is told.
///
/// # Errors
///
/// Names the byte at which the file ends, or what it lacks.
pub fn chunks(bytes: &[u8]) -> Result<Chunks<'_>, String> {
    if !bytes.starts_with(b"glTF") {
        return Ok(Chunks { json: bytes, binary: None, others: 0, warnings: Vec::new() });
    }
    let number = |at: usize| -> Result<usize, String> {
        let field = bytes.get(at..at + 4).ok_or_else(|| format!("GLB ends at byte {}", bytes.len()))?;
        Ok(u32::from_le_bytes(field.try_into().expect("the slice has four bytes")) as usize)
    };
    let version = number(4)?;
    if version != 2 {
        return Err(format!("GLB version {version}: expected 2"));
    }
    let length = number(8)?;
    let mut at = 12;
    let (mut json, mut binary, mut others, mut warnings) = (None, None, 0, Vec::new());
    let found = bytes.len();
    let mut kinds = Vec::new();
    // A length that counts padding that is not there is usual.
    if found < length.saturating_sub(MAX_PADDING) || found > length + MAX_PADDING {
        warnings.push(format!("the header of the GLB says {length} bytes, the file has {found}"));
    }
    while at + 8 <= bytes.len() {
        let (size, kind) = (number(at)?, &bytes[at + 4..at + 8]);
        let rest = &bytes[at + 8..];
        kinds.push(kind);
        let is_cut = size > rest.len();
        let is_binary = kind == b"BIN\0";
        if is_cut && (!is_binary || size - rest.len() > MAX_PADDING) {
            return Err(format!(
                "GLB is cut short: a chunk of {size} bytes starts at byte {}, the file has {}",
                at + 8,
                bytes.len()
            ));
        }
        let chunk = &rest[..size.min(rest.len())];
        match kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            _ if is_binary && binary.is_none() => {
                if json.is_none() {
                    warnings.push("the chunks of the GLB are out of order: BIN before JSON".into());
                }
                binary = Some(Binary { bytes: chunk, is_cut });
            }
            _ => others += 1,
        }
        at += 8 + size;
        // What follows the length of the header belongs to no chunk.
        if at >= length && json.is_some() {
            break;
        }
    }
    let json = json.ok_or_else(|| {
        if length > bytes.len() {
            format!("GLB is cut short: its header says {length} bytes, the file has {}", bytes.len())
        } else {
            let kinds: Vec<String> = kinds.iter().map(|kind: &&[u8]| kind.escape_ascii().to_string()).collect();
            let found = if kinds.is_empty() { String::new() } else { format!(", with chunks {}", quoted(&kinds)) };
            format!("GLB without a JSON chunk{found}")
        }
    })?;
    Ok(Chunks { json, binary, others, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_truncated_glb_says_what_is_missing() {
        assert_eq!(chunks(b"glTF\x02\0\0\0").unwrap_err(), "GLB ends at byte 8");
        assert_eq!(chunks(b"glTF\x01\0\0\0\x0c\0\0\0").unwrap_err(), "GLB version 1: expected 2");
        assert_eq!(chunks(b"glTF\x02\0\0\0\x0c\0\0\0").unwrap_err(), "GLB without a JSON chunk");
        assert_eq!(
            chunks(b"glTF\x02\0\0\0\x20\0\0\0").unwrap_err(),
            "GLB is cut short: its header says 32 bytes, the file has 12"
        );
        let short = b"glTF\x02\0\0\0\x14\0\0\0\x09\0\0\0JSON";
        assert_eq!(
            chunks(short).unwrap_err(),
            "GLB is cut short: a chunk of 9 bytes starts at byte 20, the file has 20"
        );
    }

    #[test]
    fn lengths_may_count_padding_that_is_not_there() {
        let glb = b"glTF\x02\0\0\0\xff\0\0\0\x02\0\0\0JSON{}\x04\0\0\0BIN\0\x07";
        let Chunks { json, binary, .. } = chunks(glb).unwrap();
        let binary = binary.unwrap();
        assert_eq!((json, binary.bytes, binary.is_cut), (&b"{}"[..], &[7][..], true));
        let cut = b"glTF\x02\0\0\0\xff\0\0\0\x02\0\0\0JSON{}\x05\0\0\0BIN\0\x07";
        assert_eq!(chunks(cut).unwrap_err(), "GLB is cut short: a chunk of 5 bytes starts at byte 30, the file has 31");
    }
}
