//! The layout of all binary data: a JSON header, then arrays of 4-byte numbers, little endian.

use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value, json};

/// The first bytes of every container.
pub const MAGIC: [u8; 4] = *b"MSB1";

/// Numbers of an array.
#[derive(Clone, Copy, Debug)]
pub enum Numbers<'a> {
    /// Floats.
    F32(&'a [f32]),
    /// Whole numbers.
    U32(&'a [u32]),
}

impl Numbers<'_> {
    fn len(self) -> usize {
        match self {
            Self::F32(numbers) => numbers.len(),
            Self::U32(numbers) => numbers.len(),
        }
    }

    fn kind(self) -> &'static str {
        match self {
            Self::F32(_) => "f32",
            Self::U32(_) => "u32",
        }
    }

    fn write(self, out: &mut Vec<u8>) {
        match self {
            Self::F32(numbers) => numbers.iter().for_each(|number| out.extend(number.to_le_bytes())),
            Self::U32(numbers) => numbers.iter().for_each(|number| out.extend(number.to_le_bytes())),
        }
    }
}

/// A container with `header`, a mapping to which the list of `arrays` is added.
pub fn write(header: Value, arrays: &[(&str, Numbers<'_>)]) -> Vec<u8> {
    let mut fields = match header {
        Value::Object(fields) => fields,
        _ => Map::new(),
    };
    let list =
        arrays.iter().map(|(name, numbers)| json!({ "name": name, "type": numbers.kind(), "length": numbers.len() }));
    fields.insert("arrays".into(), Value::Array(list.collect()));
    let mut text = Value::Object(fields).to_string();
    text.push_str(&" ".repeat(text.len().next_multiple_of(4) - text.len()));
    let numbers: usize = arrays.iter().map(|(_, numbers)| numbers.len()).sum();
    let mut out = Vec::with_capacity(8 + text.len() + 4 * numbers);
    out.extend(MAGIC);
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
    arrays.iter().for_each(|(_, numbers)| numbers.write(&mut out));
    out
}

/// The array of floats `name` in a container.
///
/// # Errors
///
/// A sentence that names what is wrong with the container.
pub fn read_f32(bytes: &[u8], name: &str) -> Result<Vec<f32>, String> {
    let word = |at: usize| bytes.get(at..at + 4).and_then(|word| <[u8; 4]>::try_from(word).ok());
    if word(0) != Some(MAGIC) {
        return Err("expected a container, which begins with MSB1".into());
    }
    let length = word(4).map_or(0, u32::from_le_bytes) as usize;
    let start = length.checked_add(8).filter(|start| start % 4 == 0 && *start <= bytes.len());
    let start = start.ok_or("the header is longer than the container, or its length is no multiple of 4")?;
    let header: Value = serde_json::from_slice(&bytes[8..start]).map_err(|error| format!("the header: {error}"))?;
    let mut at = start;
    for array in header.get("arrays").and_then(Value::as_array).into_iter().flatten() {
        let count = array.get("length").and_then(Value::as_u64).and_then(|count| usize::try_from(count).ok());
        let end = count.and_then(|count| count.checked_mul(4)?.checked_add(at)).filter(|end| *end <= bytes.len());
        let end = end.ok_or("an array is longer than the container")?;
        if array.get("name").and_then(Value::as_str) == Some(name) {
            if array.get("type").and_then(Value::as_str) != Some("f32") {
                return Err(format!("array `{name}`: expected the type f32"));
            }
            let (words, _) = bytes[at..end].as_chunks::<4>();
            return Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect());
        }
        at = end;
    }
    Err(format!("the container has no array `{name}`"))
}

/// Coordinates relative to `origin`, one after another.
pub fn relative(positions: &[Point3<f64>], origin: Vector3<f64>) -> Vec<f32> {
    positions.iter().flat_map(|p| (p.coords - origin).iter().map(|x| *x as f32).collect::<Vec<_>>()).collect()
}

/// Positions that were relative to `origin`.
pub fn absolute(relative: &[f32], origin: Vector3<f64>) -> Vec<Point3<f64>> {
    let (points, _) = relative.as_chunks::<3>();
    points.iter().map(|p| Point3::from(origin + Vector3::from(p.map(f64::from)))).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn positions_come_back() {
        let points = [Point3::new(1.0, 2.0, 3.0), Point3::new(-4.0, 5.5, 6.0)];
        let origin = Vector3::new(10.0, 0.0, -3.0);
        assert_eq!(absolute(&relative(&points, origin), origin), points);
    }

    #[test]
    fn the_layout_is_that_of_the_protocol() {
        let bytes = write(json!({ "a": 1 }), &[("n", Numbers::U32(&[7])), ("x", Numbers::F32(&[0.5, -1.0]))]);
        assert_eq!(&bytes[..4], b"MSB1");
        let length = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
        assert_eq!(length % 4, 0);
        let header: Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
        assert_eq!(header["arrays"][1], json!({ "name": "x", "type": "f32", "length": 2 }));
        assert_eq!(bytes.len(), 8 + length + 12);
        assert_eq!(read_f32(&bytes, "x").unwrap(), [0.5, -1.0]);
        assert!(read_f32(&bytes, "n").is_err() && read_f32(&bytes, "y").is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), header in ".{0,80}") {
            let _ = read_f32(&bytes, "x");
            let mut framed = MAGIC.to_vec();
            framed.extend((header.len() as u32).to_le_bytes());
            framed.extend(header.as_bytes());
            framed.extend(&bytes);
            let _ = read_f32(&framed, "x");
        }

        #[test]
        fn arrays_come_back(numbers in prop::collection::vec(any::<f32>(), 0..50)) {
            let bytes = write(json!({}), &[("x", Numbers::F32(&numbers))]);
            let back = read_f32(&bytes, "x").unwrap();
            prop_assert!(back.iter().zip(&numbers).all(|(a, b)| a.to_bits() == b.to_bits()));
            prop_assert_eq!(back.len(), numbers.len());
        }
    }
}
