use std::{collections::HashMap, path::Path};

use mimesh_core::{Error, Result, mesh::Mesh};
use nalgebra::Point3;

const DAMAGED: &str = "the file is damaged or cut short: export it again";

/// The bytes before the triangles of a binary file, and those of a triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Whether a file of `length` bytes that begins with `start` is an STL.
pub fn is_stl(start: &[u8], length: u64) -> bool {
    let has_facets = || start.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet"));
    (is_text(start) && has_facets())
        || triangles(start).is_some_and(|n| n > 0 && length == HEADER as u64 + TRIANGLE as u64 * u64::from(n))
}

/// Reads the triangles in `bytes`; `path` is for messages.
///
/// Normals are not read: they follow from the corners. A text may hold several solids, names with blanks and words in capitals.
///
/// # Errors
///
/// [`Error::File`] if the file is cut short, a corner is no number, or there is no triangle.
pub fn read(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh> {
    let mesh = if is_text(bytes) { read_text(path, bytes)? } else { read_binary(path, bytes, warnings)? };
    match mesh.validate() {
        Err(Error::Data { message, hint }) => Err(Error::file(path, message, hint)),
        other => other.map(|()| mesh),
    }
}

/// The count of triangles of a binary file.
fn triangles(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..HEADER).map(|n| u32::from_le_bytes(n.try_into().expect("the slice has four bytes")))
}

/// Whether a file is text: binary headers may begin with `solid` too, but go on with bytes that no text has.
fn is_text(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let starts = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let exact = triangles(bytes).is_some_and(|n| bytes.len() as u64 == HEADER as u64 + TRIANGLE as u64 * u64::from(n));
    starts && !exact && !bytes[..bytes.len().min(HEADER + TRIANGLE)].contains(&0)
}

fn read_binary(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh> {
    let Some(count) = triangles(bytes) else {
        let message = format!("not an STL: {} bytes, expected `solid` or {HEADER} bytes of header", bytes.len());
        return Err(Error::file(path, message, DAMAGED));
    };
    let body = &bytes[HEADER..];
    let needed = count as usize * TRIANGLE;
    if body.len() < needed {
        let message =
            format!("not an STL: {count} triangles take {needed} bytes after the header, found {}", body.len());
        return Err(Error::file(path, message, DAMAGED));
    }
    if body.len() > needed {
        let more = body.len() - needed;
        warnings.push(format!("{more} bytes after the {count} triangles that the header counts are not read"));
    }
    let mut joined = Joined::default();
    for triangle in body[..needed].chunks_exact(TRIANGLE) {
        let number = |k: usize| {
            let bytes = &triangle[12 + 4 * k..16 + 4 * k];
            f32::from_le_bytes(bytes.try_into().expect("the slice has four bytes"))
        };
        let corners = [0, 1, 2].map(|corner| joined.vertex([0, 1, 2].map(|axis| number(3 * corner + axis))));
        joined.mesh.polygons.push(&corners);
    }
    Ok(joined.mesh)
}

fn read_text(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut joined = Joined::default();
    let mut loop_of: Option<Vec<u32>> = None;
    let mut is_open = true;
    let mut line = 0;
    // Some old programs end lines in CR alone.
    for content in text.split('\n').flat_map(|line| line.trim_end_matches('\r').split('\r')) {
        line += 1;
        let wrong = |message: String| Error::line(path, line, format!("not an STL: {message}"), DAMAGED);
        let mut words = content.split_ascii_whitespace().map(str::to_ascii_lowercase);
        while let Some(word) = words.next() {
            // `end solid` is written for `endsolid`, and so on.
            let word = if word == "end" { word + &words.next().unwrap_or_default() } else { word };
            match word.as_str() {
                // A name may hold any word.
                "solid" | "endsolid" => {
                    is_open = word == "solid";
                    break;
                }
                "outer" => loop_of = Some(Vec::new()),
                "vertex" => {
                    let corners = loop_of.as_mut().ok_or_else(|| wrong("a `vertex` outside of a loop".into()))?;
                    let mut position = [0.0; 3];
                    for coordinate in &mut position {
                        let number = words.next().unwrap_or_default();
                        *coordinate =
                            number.parse().map_err(|_| wrong(format!("`{number}` is no coordinate of a vertex")))?;
                    }
                    corners.push(joined.vertex(position));
                }
                "endloop" => {
                    let corners = loop_of.take().unwrap_or_default();
                    if corners.len() != 3 {
                        return Err(wrong(format!("a triangle has {} corners, expected 3", corners.len())));
                    }
                    joined.mesh.polygons.push(&corners);
                }
                _ => {}
            }
        }
    }
    if is_open {
        return Err(Error::line(path, line, "not an STL: the file ends without `endsolid`", DAMAGED));
    }
    Ok(joined.mesh)
}

/// Triangles whose equal corners are one vertex, by first use.
#[derive(Default)]
struct Joined {
    mesh: Mesh,
    numbers: HashMap<[u32; 3], u32>,
}

impl Joined {
    fn vertex(&mut self, position: [f32; 3]) -> u32 {
        // The two zeros are one number.
        let position = position.map(|x| x + 0.0);
        let new = self.mesh.positions.len() as u32;
        let number = *self.numbers.entry(position.map(f32::to_bits)).or_insert(new);
        if number == new {
            self.mesh.positions.push(Point3::from(position.map(f64::from)));
        }
        number
    }
}
