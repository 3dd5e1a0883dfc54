//! The two forms of a glTF: JSON with a binary chunk, and JSON with its numbers inside.

use std::io::{self, Write};

use base64::{engine::general_purpose::STANDARD, write::EncoderWriter};
use mimesh_core::{
    Error,
    stage::{SequenceFile, WriteError},
};
use serde_json::Value;

use super::binary::Binary;
use crate::tail::Tail;

/// Where a glTF goes.
pub enum Output {
    /// A GLB, whose numbers are in the file already.
    Glb,
    /// Text, with numbers in a temporary file.
    Text(Box<dyn SequenceFile>),
}

/// Bytes before the JSON of a GLB.
const BEFORE_JSON: u64 = 20;

/// Bytes before the numbers of a GLB, behind the JSON.
const BEFORE_NUMBERS: u64 = 8;

impl Output {
    /// A GLB or text in `file`, with an empty buffer.
    ///
    /// # Errors
    ///
    /// If text has no room for a temporary file.
    pub fn new(file: Box<dyn SequenceFile>, is_glb: bool) -> io::Result<(Self, Binary)> {
        if is_glb {
            return Ok((Self::Glb, Binary::new(Tail::new(file))));
        }
        let mut numbers = Tail::new(Box::new(tempfile::tempfile()?));
        numbers.leave_room(0)?;
        Ok((Self::Text(file), Binary::new(numbers)))
    }

    /// Writes `json` with the contents of its first buffer, which is `binary`.
    ///
    /// # Errors
    ///
    /// Those of the file, and [`Error::Data`] if a GLB cannot be as large.
    pub fn finish(self, json: Value, binary: Binary) -> Result<(), WriteError> {
        match self {
            Self::Glb => finish_glb(&json, binary),
            Self::Text(file) => finish_text(json, binary, file),
        }
    }
}

/// The bytes of a GLB before its numbers, if its JSON is that long.
pub fn glb_head(json: u64) -> u64 {
    (BEFORE_JSON + json).next_multiple_of(4) + BEFORE_NUMBERS
}

fn finish_glb(json: &Value, binary: Binary) -> Result<(), WriteError> {
    let mut json = serde_json::to_vec(json).map_err(io::Error::from)?;
    let numbers = binary.length();
    let chunk = if numbers > 0 { BEFORE_NUMBERS + numbers } else { 0 };
    // Spaces fill the room that was left for it.
    let room = binary.tail.room().saturating_sub(BEFORE_JSON + BEFORE_NUMBERS);
    json.resize((json.len().next_multiple_of(4)).max(room as usize), b' ');
    let length = check_length(BEFORE_JSON + json.len() as u64 + chunk)?;
    let mut head = Vec::with_capacity(json.len() + 28);
    head.extend_from_slice(b"glTF\x02\0\0\0");
    head.extend_from_slice(&length.to_le_bytes());
    head.extend_from_slice(&(json.len() as u32).to_le_bytes());
    head.extend_from_slice(b"JSON");
    head.extend_from_slice(&json);
    if numbers > 0 {
        head.extend_from_slice(&(numbers as u32).to_le_bytes());
        head.extend_from_slice(b"BIN\0");
    }
    Ok(binary.tail.finish(&head)?)
}

fn finish_text(mut json: Value, binary: Binary, mut out: Box<dyn SequenceFile>) -> Result<(), WriteError> {
    // The data take the place of this name once the JSON around them is known.
    let mut marker = String::from("buffer-0");
    let around = serde_json::to_string(&json).map_err(io::Error::from)?;
    while around.contains(&marker) {
        marker.push('-');
    }
    drop(around);
    if binary.length() > 0 {
        json["buffers"][0]["uri"] = marker.clone().into();
    }
    let json = serde_json::to_string(&json).map_err(io::Error::from)?;
    let Some((before, after)) = json.split_once(&marker) else { return Ok(out.write_all(json.as_bytes())?) };
    out.write_all(before.as_bytes())?;
    out.write_all(b"data:application/octet-stream;base64,")?;
    let mut encoder = EncoderWriter::new(&mut out, &STANDARD);
    io::copy(&mut binary.tail.into_file()?, &mut encoder)?;
    encoder.finish()?;
    drop(encoder);
    Ok(out.write_all(after.as_bytes())?)
}

/// The length of a GLB as its header holds it.
///
/// # Errors
///
/// [`Error::Data`] if it does not go into 32 bits.
pub fn check_length(length: u64) -> Result<u32, Error> {
    u32::try_from(length).map_err(|_| {
        Error::data(
            format!("the poses make a GLB of {length} bytes, but one cannot have more than {}", u32::MAX),
            "write fewer poses to a file, turn off `pose_normals`, or write `gltf`, or one OBJ or PLY a pose",
        )
    })
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::memory_file::MemoryFile;
    use serde_json::json;

    use super::*;

    #[test]
    fn the_data_stand_at_the_uri_of_the_buffer_whatever_else_the_json_says() {
        let file = MemoryFile::default();
        let (output, mut binary) = Output::new(Box::new(file.clone()), false).unwrap();
        binary.append(&[1, 2, 3]).unwrap();
        let json = json!({ "images": [{ "uri": "buffer-0" }], "buffers": [{ "byteLength": 4 }] });
        output.finish(json, binary).unwrap();
        let read: Value = serde_json::from_slice(&file.bytes()).unwrap();
        assert_eq!(read["images"][0]["uri"], "buffer-0");
        assert_eq!(read["buffers"][0]["uri"], "data:application/octet-stream;base64,AQIDAA==");
    }

    #[test]
    fn a_glb_has_no_more_than_four_gigabytes() {
        assert_eq!(check_length(u64::from(u32::MAX)).unwrap(), u32::MAX);
        let error = check_length(1 << 32).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the poses make a GLB of 4294967296 bytes, but one cannot have more than 4294967295"
        );
    }
}
