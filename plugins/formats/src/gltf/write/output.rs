//! The two forms of a glTF: JSON with a binary chunk, and JSON with its numbers inside.

use std::io::{self, Write};

use base64::{engine::general_purpose::STANDARD, write::EncoderWriter};
use mimesh_core::{Error, stage::WriteError};
use serde_json::Value;

use super::binary::Binary;

/// Writes `json` with the contents of its first buffer, which is `binary`; as GLB or as text.
///
/// # Errors
///
/// Those of `out` and of the temporary file, and [`Error::Data`] if a GLB cannot be as large.
pub fn write(mut json: Value, mut binary: Binary, glb: bool, out: &mut dyn Write) -> Result<(), WriteError> {
    if glb {
        return write_glb(&json, binary, out);
    }
    // The data take the place of this name once the JSON around them is known.
    let mut marker = String::from("buffer-0");
    let around = serde_json::to_string(&json).map_err(io::Error::from)?;
    while around.contains(&marker) {
        marker.push('-');
    }
    drop(around);
    if binary.length > 0 {
        json["buffers"][0]["uri"] = marker.clone().into();
    }
    let json = serde_json::to_string(&json).map_err(io::Error::from)?;
    let Some((before, after)) = json.split_once(&marker) else { return Ok(out.write_all(json.as_bytes())?) };
    out.write_all(before.as_bytes())?;
    out.write_all(b"data:application/octet-stream;base64,")?;
    let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
    io::copy(&mut binary.contents()?, &mut encoder)?;
    encoder.finish()?;
    drop(encoder);
    Ok(out.write_all(after.as_bytes())?)
}

fn write_glb(json: &Value, mut binary: Binary, out: &mut dyn Write) -> Result<(), WriteError> {
    let mut json = serde_json::to_vec(json).map_err(io::Error::from)?;
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk = if binary.length > 0 { 8 + binary.length } else { 0 };
    let length = check_length(12 + 8 + json.len() as u64 + chunk)?;
    out.write_all(b"glTF\x02\0\0\0")?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&(json.len() as u32).to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(&json)?;
    if chunk == 0 {
        return Ok(());
    }
    out.write_all(&(binary.length as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    io::copy(&mut binary.contents()?, out)?;
    Ok(())
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
    use serde_json::json;

    use super::*;

    #[test]
    fn the_data_stand_at_the_uri_of_the_buffer_whatever_else_the_json_says() {
        let mut binary = Binary::new().unwrap();
        binary.append(&[1, 2, 3]).unwrap();
        let json = json!({ "images": [{ "uri": "buffer-0" }], "buffers": [{ "byteLength": 4 }] });
        let mut out = Vec::new();
        write(json, binary, false, &mut out).unwrap();
        let read: Value = serde_json::from_slice(&out).unwrap();
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
