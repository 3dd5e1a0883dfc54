use std::{collections::HashMap, path::Path};

use mimesh_core::{Error, Result, mesh::Mesh};
use nalgebra::Point3;

use crate::names::shown;

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
    let mesh = if is_text(bytes) { read_text(path, bytes, warnings)? } else { read_binary(path, bytes, warnings)? };
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
    let exact = triangles(bytes).is_some_and(|n| bytes.len() as u64 == HEADER as u64 + TRIANGLE as u64 * u64::from(n));
    begins_as_text(bytes) && !exact && !bytes[..bytes.len().min(HEADER + TRIANGLE)].contains(&0)
}

fn begins_as_text(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

fn read_binary(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh> {
    let Some(count) = triangles(bytes) else {
        let message = format!("not an STL: {} bytes, expected `solid` or {HEADER} bytes of header", bytes.len());
        return Err(Error::file(path, message, DAMAGED));
    };
    let body = &bytes[HEADER..];
    let needed = count as usize * TRIANGLE;
    if body.len() < needed {
        let found = body.len();
        let message = match bytes.iter().all(|b| matches!(b, b'\t' | b'\n' | b'\r' | b' '..=b'~')) {
            true => "not an STL: text that does not begin with `solid`".into(),
            false => format!(
                "not an STL: {}the header counts {count} facets, which take {needed} bytes, and {found} bytes follow it",
                if begins_as_text(bytes) {
                    "it begins with `solid` and goes on with bytes that no text has; as binary "
                } else {
                    ""
                }
            ),
        };
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
        let corners = [0, 1, 2].map(|corner| [0, 1, 2].map(|axis| number(3 * corner + axis)));
        if let Some(x) = corners.as_flattened().iter().find(|x| !x.is_finite()) {
            let facet = joined.mesh.polygons.len();
            let message = format!("facet {facet} (from 0) has the coordinate {x}: expected finite numbers");
            return Err(Error::file(path, message, "repair the file or export it again without NaN and infinity"));
        }
        let corners = corners.map(|corner| joined.vertex(corner));
        joined.mesh.polygons.push(&corners);
    }
    Ok(joined.mesh)
}

fn read_text(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh> {
    let text = String::from_utf8_lossy(bytes);
    let mut joined = Joined::default();
    let mut loop_of: Option<Vec<u32>> = None;
    // In a facet, the number of triangles before it.
    let mut facet: Option<usize> = None;
    let mut is_open = false;
    let mut untidy = Untidy::default();
    let mut line = 0;
    // Some old programs end lines in CR alone.
    for content in text.split('\n').flat_map(|line| line.trim_end_matches('\r').split('\r')) {
        line += 1;
        let wrong = |message: String| Error::line(path, line, format!("not an STL: {message}"), DAMAGED);
        let mut words = content.split_ascii_whitespace().map(str::to_ascii_lowercase);
        while let Some(word) = words.next() {
            let number = joined.mesh.polygons.len();
            let open = facet.unwrap_or(number);
            let not_closed = || wrong(format!("facet {open} (from 0) is not closed by `endloop` and `endfacet`"));
            // `end solid` is written for `endsolid`, and so on.
            let word = if word == "end" { word + &words.next().unwrap_or_default() } else { word };
            match word.as_str() {
                // A name may hold any word.
                "solid" | "endsolid" => {
                    if loop_of.is_some() || facet.is_some() {
                        return Err(not_closed());
                    }
                    untidy.solids += usize::from(word == "solid");
                    untidy.unclosed += usize::from(word == "solid" && is_open);
                    is_open = word == "solid";
                    break;
                }
                "facet" | "outer" if loop_of.is_some() => return Err(not_closed()),
                "facet" if facet.is_some() => return Err(not_closed()),
                "facet" => {
                    untidy.outside += usize::from(!is_open);
                    facet = Some(number);
                }
                "outer" if facet.is_none() => return Err(wrong("a loop outside of a facet".into())),
                "outer" if facet != Some(number) => return Err(wrong(format!("facet {open} (from 0) has two loops"))),
                "outer" => loop_of = Some(Vec::new()),
                "endfacet" if loop_of.is_some() => return Err(not_closed()),
                "endfacet" if facet.take() == Some(number) => {
                    return Err(wrong(format!("facet {number} (from 0) has no loop of three vertices")));
                }
                "vertex" => {
                    let corners = loop_of.as_mut().ok_or_else(|| wrong("a `vertex` outside of a loop".into()))?;
                    let mut position = [0.0_f32; 3];
                    for coordinate in &mut position {
                        let text = words.next().unwrap_or_default();
                        *coordinate = text.parse().map_err(|_| {
                            wrong(format!("`{}` is no coordinate of a vertex of facet {number} (from 0)", shown(&text)))
                        })?;
                        if !coordinate.is_finite() {
                            let message = format!(
                                "facet {number} (from 0) has the coordinate `{}`: expected finite 32-bit numbers",
                                shown(&text)
                            );
                            let hint = "repair the file or export it again without NaN and infinity";
                            return Err(Error::line(path, line, message, hint));
                        }
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
                // The normal, which stands in many ways.
                _ if facet == Some(number) && loop_of.is_none() => {}
                "endfacet" | "loop" => {}
                other => untidy.skip(line, other),
            }
        }
    }
    if loop_of.is_some() || facet.is_some() {
        let facet = facet.unwrap_or(joined.mesh.polygons.len());
        let message = format!("not an STL: the file ends in facet {facet} (from 0)");
        return Err(Error::line(path, line, message, DAMAGED));
    }
    if is_open && joined.mesh.polygons.is_empty() {
        let message = "not an STL: it begins with `solid` as text does, and has no facet";
        let hint = "the file is damaged, or a binary STL without its count of facets: export it again";
        return Err(Error::file(path, message, hint));
    }
    if is_open {
        return Err(Error::line(path, line, "not an STL: the file ends without `endsolid`", DAMAGED));
    }
    warnings.extend(untidy.sentences());
    Ok(joined.mesh)
}

/// What of a text is read though it is not as it should be.
#[derive(Default)]
struct Untidy {
    solids: usize,
    /// Solids in which another begins.
    unclosed: usize,
    /// Facets that stand in no solid.
    outside: usize,
    /// Words that have no place where they stand.
    words: usize,
    /// The first of them, with its line.
    first: Option<(usize, String)>,
}

impl Untidy {
    fn skip(&mut self, line: usize, word: &str) {
        self.words += 1;
        self.first.get_or_insert_with(|| (line, shown(word)));
    }

    fn sentences(self) -> Vec<String> {
        let Self { solids, unclosed, outside, words, first } = self;
        let (line, word) = first.unwrap_or_default();
        let all = [
            (solids > 1, format!("the file has {solids} solids: they are read as one mesh")),
            (unclosed > 0, format!("solids without an `endsolid` before the next: {unclosed}")),
            (outside > 0, format!("facets behind `endsolid`, which stand in no solid, are read too: {outside}")),
            (
                words > 0,
                format!("words that have no place in an STL are skipped: {words}, the first `{word}` in line {line}"),
            ),
        ];
        all.into_iter().filter(|(is_so, _)| *is_so).map(|(_, sentence)| sentence).collect()
    }
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
