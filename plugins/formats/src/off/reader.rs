use std::path::Path;

use mimesh_core::{
    Error, Result,
    mesh::{CornerAttribute, Document, Mesh},
};
use nalgebra::Point3;

use crate::{extras::Extras, names::shown};

const DAMAGED: &str = "the file is damaged or cut short: export it again";

/// Whether a file that begins with `start` is an OFF.
pub fn is_off(start: &[u8]) -> bool {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let line = start.split(|b| matches!(b, b'\n' | b'\r')).next().unwrap_or_default();
    let text = String::from_utf8_lossy(line);
    text.split_ascii_whitespace().next().is_some_and(|word| Kind::new(word).is_some())
}

/// The kind of a file: what vertices have beside their coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Kind {
    textured: bool,
    colored: bool,
    normals: bool,
    /// Vertices have four coordinates, or as many as the file says.
    other_dimension: bool,
}

impl Kind {
    /// The kind that a first word names: `[ST][C][N][4][n]OFF`.
    fn new(word: &str) -> Option<Self> {
        let rest = word.strip_suffix("OFF")?;
        let (textured, rest) = rest.strip_prefix("ST").map_or((false, rest), |rest| (true, rest));
        let (colored, rest) = rest.strip_prefix('C').map_or((false, rest), |rest| (true, rest));
        let (normals, rest) = rest.strip_prefix('N').map_or((false, rest), |rest| (true, rest));
        matches!(rest, "" | "4" | "n" | "4n").then_some(Self {
            textured,
            colored,
            normals,
            other_dimension: !rest.is_empty(),
        })
    }
}

/// Reads the mesh in `bytes`; `path` is for messages.
///
/// # Errors
///
/// [`Error::File`] at the line that is not understood, and for a mesh without polygons.
pub fn read(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Mesh> {
    let mut reader = Reader::new(path, bytes)?;
    let mut mesh = reader.vertices()?;
    let (mut colors, mut short, mut indexed) = (Vec::new(), 0, 0);
    let mut corners = Vec::new();
    for face in 0..reader.faces {
        let count = reader.word("face", face)?;
        let count =
            count.parse::<usize>().map_err(|_| reader.wrong(format!("`{}` is no count of corners", shown(count))))?;
        corners.clear();
        for _ in 0..count {
            let word = reader.word("face", face)?;
            let vertex = word.parse::<u32>().ok().filter(|&v| (v as usize) < mesh.positions.len());
            corners.push(vertex.ok_or_else(|| {
                let vertices = mesh.positions.len();
                reader.wrong(format!(
                    "face {face} (from 0) refers to vertex {}: there are {vertices} (from 0)",
                    shown(word)
                ))
            })?);
        }
        let extra = reader.rest_of_line();
        if corners.len() < 3 {
            short += 1;
            continue;
        }
        mesh.polygons.push(&corners);
        indexed += usize::from(extra.len() == 1);
        reader.unknown += usize::from(extra.len() == 2 || extra.len() > 4);
        colors.push(if extra.len() < 3 { None } else { Some(reader.color(&extra)) });
    }
    if let Some(word) = reader.next_word()? {
        let (line, faces) = (reader.line, reader.faces);
        warnings.push(format!(
            "the file goes on after the {faces} faces that its header counts (line {line}: `{}`): if the counts are too low, faces are missing",
            shown(word)
        ));
    }
    if short > 0 {
        warnings.push(format!("{short} faces of fewer than three corners are left out"));
    }
    warnings.extend(reader.untidy());
    if mesh.polygons.is_empty() {
        let message = format!("empty mesh: {} vertices, 0 faces", mesh.positions.len());
        let hint = "give a mesh with at least one face of three corners; point clouds are not read";
        return Err(Error::file(path, message, hint));
    }
    match mesh.validate() {
        Err(Error::Data { message, hint }) => return Err(Error::file(path, message, hint)),
        other => other?,
    }
    let by_vertex: Vec<_> = mesh.polygons.corners().iter().map(|&v| Some(v)).collect();
    let of = |values: Vec<[f64; 3]>| CornerAttribute { values, indices: by_vertex.clone() };
    mesh.normals = reader.kind.normals.then(|| of(std::mem::take(&mut reader.normals)));
    mesh.texture_coordinates = reader
        .kind
        .textured
        .then(|| CornerAttribute { values: std::mem::take(&mut reader.textures), indices: by_vertex.clone() });
    if reader.colors.iter().any(Option::is_some) {
        mesh.vertex_colors = Some(reader.units(&reader.colors));
    }
    let face_colors = colors.iter().any(Option::is_some).then(|| reader.units(&colors));
    let left_out = if indexed > 0 { vec!["the face colours by number of a colour map".into()] } else { vec![] };
    let colors_are_bytes = reader.bytes;
    mesh.document = Document::new(Extras { double: true, colors_are_bytes, face_colors, left_out });
    Ok(mesh)
}

/// Reads only the positions of vertices, #V × 3; the file may have no faces.
///
/// # Errors
///
/// As [`read`].
pub fn read_positions(path: &Path, bytes: &[u8]) -> Result<Vec<Point3<f64>>> {
    Ok(Reader::new(path, bytes)?.vertices()?.positions)
}

/// The words of a file line by line, without comments.
struct Reader<'a> {
    path: &'a Path,
    /// What comes after the line at hand.
    rest: &'a [u8],
    /// The number of the line at hand, from 1.
    line: usize,
    /// Its words.
    words: Vec<&'a str>,
    /// How many of them are read.
    word: usize,
    kind: Kind,
    vertices: usize,
    faces: usize,
    normals: Vec<[f64; 3]>,
    textures: Vec<[f64; 2]>,
    colors: Vec<Option<[f64; 4]>>,
    /// Whether all colours are whole numbers.
    bytes: bool,
    /// Colours and texture coordinates that are no finite numbers, or not there.
    unreadable: usize,
    /// Lines with so many numbers behind their own that they are no colour.
    unknown: usize,
}

impl<'a> Reader<'a> {
    /// Reads the header.
    fn new(path: &'a Path, bytes: &'a [u8]) -> Result<Self> {
        let rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let (words, normals, textures, colors) = Default::default();
        let mut reader = Self {
            path,
            rest,
            line: 0,
            words,
            word: 0,
            kind: Kind::default(),
            vertices: 0,
            faces: 0,
            normals,
            textures,
            colors,
            bytes: true,
            unreadable: 0,
            unknown: 0,
        };
        // The first word may be missing in a plain file.
        if let Some(kind) = reader.next_word()?.and_then(Kind::new) {
            reader.kind = kind;
            reader.word("header", 0)?;
        }
        if reader.kind.other_dimension {
            let hint = "give a mesh in three dimensions";
            let message = "the kinds `4OFF` and `nOFF` have vertices with other than three coordinates";
            return Err(Error::line(path, reader.line, message, hint));
        }
        if reader.next_word()?.is_some_and(|word| word.eq_ignore_ascii_case("binary")) {
            let hint = "convert it to PLY or text, e.g. in MeshLab";
            return Err(Error::line(path, reader.line, "binary OFF is not read: expected text", hint));
        }
        let count = |reader: &mut Self| {
            let word = reader.word("header", 0)?;
            word.parse::<usize>()
                .map_err(|_| reader.wrong(format!("`{}` is no count of vertices or faces", shown(word))))
        };
        reader.vertices = count(&mut reader)?;
        reader.faces = count(&mut reader)?;
        // The count of edges is of no use, and some programs leave it out.
        reader.unknown += usize::from(reader.rest_of_line().len() > 1);
        Ok(reader)
    }

    fn vertices(&mut self) -> Result<Mesh> {
        let mut mesh = Mesh::default();
        for vertex in 0..self.vertices {
            let position = self.numbers::<3>(vertex)?;
            mesh.positions.push(Point3::from(position));
            if self.kind.normals {
                let normal = self.numbers::<3>(vertex)?;
                self.normals.push(normal.map(|x| if x.is_finite() { x } else { 0.0 }));
            }
            let mut extra = self.rest_of_line();
            if self.kind.textured {
                let from = extra.len().saturating_sub(2);
                let numbers: Vec<f64> = extra.split_off(from).iter().filter_map(|word| word.parse().ok()).collect();
                let finite = |k: usize| numbers.get(k).copied().filter(|x| x.is_finite()).unwrap_or_default();
                self.unreadable += usize::from(numbers.iter().filter(|x| x.is_finite()).count() < 2);
                self.textures.push([finite(0), finite(1)]);
            }
            // Many programs write colours without a C in the first word.
            let is_color = matches!(extra.len(), 3 | 4);
            if !is_color && !extra.is_empty() {
                let message = format!("vertex {vertex} (from 0) has {} numbers too many", extra.len());
                return Err(self.wrong(message));
            }
            let color = is_color.then(|| self.color(&extra));
            self.colors.push(color);
        }
        Ok(mesh)
    }

    fn numbers<const N: usize>(&mut self, vertex: usize) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            let word = self.word("vertex", vertex)?;
            *number = match word.parse() {
                Ok(x) if f64::is_finite(x) => x,
                found => {
                    let kind = if found.is_ok() { "finite number" } else { "number" };
                    return Err(self.wrong(format!("`{}` of vertex {vertex} (from 0) is no {kind}", shown(word))));
                }
            };
        }
        Ok(numbers)
    }

    /// The word that comes next, on this line or a later one.
    fn next_word(&mut self) -> Result<Option<&'a str>> {
        while self.word == self.words.len() && !self.rest.is_empty() {
            self.read_line()?;
        }
        Ok(self.words.get(self.word).copied())
    }

    fn read_line(&mut self) -> Result<()> {
        let length = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(length);
        let ends_in_two = rest.starts_with(b"\r\n");
        self.rest = &rest[rest.len().min(if ends_in_two { 2 } else { 1 })..];
        self.line += 1;
        // The numbers are ASCII; comments may be in any encoding.
        let text = line.split(|&b| b == b'#').next().unwrap_or_default();
        let text = std::str::from_utf8(text).map_err(|_| {
            let hint = "binary OFF is not read: convert it to PLY or text, e.g. in MeshLab";
            Error::line(self.path, self.line, "not an OFF: bytes that are no text", hint)
        })?;
        self.words.clear();
        self.words.extend(text.split_ascii_whitespace());
        self.word = 0;
        Ok(())
    }

    /// The next word, which is taken.
    fn word(&mut self, element: &str, entry: usize) -> Result<&'a str> {
        let word = self.next_word()?;
        let word = word.ok_or_else(|| self.wrong(format!("the file ends in {element} {entry} (from 0)")))?;
        self.word += 1;
        Ok(word)
    }

    /// The words that are left on the line of the last one.
    fn rest_of_line(&mut self) -> Vec<&'a str> {
        let rest = self.words[self.word..].to_vec();
        self.word = self.words.len();
        rest
    }

    /// Sentences about what is not understood.
    fn untidy(&self) -> Vec<String> {
        let all = [
            (self.unreadable, "colours or texture coordinates are not finite numbers and were read as 0"),
            (self.unknown, "lines have numbers at their end that are no colour, and are not read"),
        ];
        all.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect()
    }

    fn wrong(&self, message: String) -> Error {
        Error::line(self.path, self.line.max(1), format!("not an OFF: {message}"), DAMAGED)
    }

    /// A colour as it stands in the file; its opacity is NaN if it has none.
    fn color(&mut self, words: &[&str]) -> [f64; 4] {
        self.bytes &= !words.iter().any(|word| word.contains('.'));
        let mut color = [0.0, 0.0, 0.0, f64::NAN];
        for (part, word) in color.iter_mut().zip(words) {
            *part = word.parse().ok().filter(|x: &f64| x.is_finite()).unwrap_or_default();
        }
        let is_number = |word: &&str| word.parse::<f64>().is_ok_and(f64::is_finite);
        self.unreadable += usize::from(!words.iter().take(4).all(is_number));
        color
    }

    /// Colours of 0 to 1, white where there is none: whole numbers are of 255, and of 1 where any colour of the file has a point.
    fn units(&self, colors: &[Option<[f64; 4]>]) -> Vec<[f64; 4]> {
        let full = if self.bytes { 255.0 } else { 1.0 };
        let unit = |x: f64| if x.is_nan() { 1.0 } else { (x / full).clamp(0.0, 1.0) };
        colors.iter().map(|color| color.map_or([1.0; 4], |color| color.map(unit))).collect()
    }
}
