use std::{fmt::Display, ops::Range, path::Path};

use mimesh_core::{
    Error, Result,
    mesh::{CornerAttribute, Document, MAX_COORDINATE, Mesh, MeshSequence, Part, Polygons},
    stage::{FileInput, check_pose, check_vertices},
};
use nalgebra::Point3;

use super::{
    colors::Colors,
    corner::{Corner, Reference},
    document::{Layout, ObjDocument},
    lexer::{Lexer, number},
    libraries::LibraryLines,
    materials::{self, Libraries},
    unknown::UnknownLines,
};
use crate::names::shown;

/// Reads the mesh in `bytes`, the contents of `input`, which also gives material libraries; with images of materials if `images`.
///
/// # Errors
///
/// [`Error::File`] at the line of the first coordinate or corner that is not one, and for a mesh without polygons.
pub fn read(input: &dyn FileInput, bytes: Vec<u8>, images: bool) -> Result<MeshSequence> {
    let mut reader = Reader::new(input.path(), &bytes);
    let mut attributes = Attributes::default();
    let mut library_lines = Vec::new();
    let mut colors = Colors::default();
    let mut layout = Layout::default();
    let mut normal_lines = Vec::new();
    let mut vertex_lines = Vec::new();
    while let Some(keyword) = reader.lexer.keyword() {
        match keyword {
            b"v" => {
                vertex_lines.push(reader.lexer.at());
                let fields = reader.vertex()?;
                layout.add_vertex(&bytes, fields);
                colors.add(&mut reader.lexer, &bytes);
            }
            b"vt" => attributes.texture(&mut reader),
            b"vn" => {
                normal_lines.push(reader.lexer.at());
                attributes.normal(&mut reader, &mut layout);
            }
            b"f" | b"fo" => {
                attributes.part(&reader, reader.polygons.len())?;
                reader.face(Some(&mut attributes))?;
            }
            b"o" => attributes.open.object = Some(text(reader.lexer.rest())).filter(|name| !name.is_empty()),
            b"g" => {
                let names = reader.lexer.rest().split(u8::is_ascii_whitespace);
                attributes.open.groups = names.filter(|name| !name.is_empty()).map(text).collect();
            }
            b"usemtl" => attributes.open.material = Some(text(reader.lexer.rest())).filter(|name| !name.is_empty()),
            b"mtllib" => library_lines.push(reader.lexer.rest_range()),
            other => reader.unknown.add(other, reader.lexer.line()),
        }
    }
    reader.finish(attributes.texture_values.len(), attributes.normal_values.len())?;

    let mut warnings = attributes.warnings();
    warnings.extend(reader.warning_of_short());
    warnings.extend(reader.unknown.warning());
    warnings.extend(colors.warnings());
    let (positions, polygons) = (reader.positions, reader.polygons);
    let parts = attributes.close_parts(polygons.len());
    let lines: Vec<_> = library_lines.iter().map(|range| text(&bytes[range.clone()])).collect();
    let is_no_text = |range: &&Range<usize>| std::str::from_utf8(&bytes[(*range).clone()]).is_err();
    if let Some(range) = library_lines.iter().find(is_no_text) {
        warnings.push(format!(
            "`mtllib` names files in another encoding than UTF-8, so that they are not found: `{}`; save the file as UTF-8",
            shown(&text(&bytes[range.clone()]))
        ));
    }
    let Libraries { materials, names } = materials::read(input, &lines, &parts, images, &mut warnings);
    let libraries = LibraryLines::new(input.path(), library_lines, names);
    let mut mesh = Mesh { positions, polygons, parts, materials, ..Mesh::default() };
    mesh.vertex_colors = colors.finish();
    mesh.texture_coordinates = attribute(attributes.texture_values, attributes.texture_indices);
    mesh.normals = attribute(attributes.normal_values, attributes.normal_indices);
    mesh.document = Document::new(ObjDocument::new(bytes, vertex_lines, normal_lines, libraries, layout, &mesh));
    Ok(MeshSequence { rest: mesh, warnings, ..MeshSequence::default() })
}

/// Reads only vertices and the vertices of faces, and checks that they are a pose of `rest`; only vertices if `same_vertices`.
///
/// # Errors
///
/// The errors of [`read`], [`check_pose`] and [`check_vertices`].
pub fn read_pose(path: &Path, bytes: &[u8], rest: &Mesh, same_vertices: bool) -> Result<Vec<Point3<f64>>> {
    let mut reader = Reader::new(path, bytes);
    while let Some(keyword) = reader.lexer.keyword() {
        match keyword {
            b"v" => {
                reader.vertex()?;
            }
            b"f" | b"fo" if !same_vertices => reader.face(None)?,
            _ => {}
        }
    }
    if same_vertices {
        check_vertices(path, rest, reader.positions.len())?;
    } else {
        // A file of vertices alone differs from the rest in its polygons, which is the error that tells the way out.
        if !reader.polygons.is_empty() {
            reader.finish(usize::MAX, usize::MAX)?;
        }
        check_pose(path, rest, reader.positions.len(), &reader.polygons)?;
    }
    Ok(reader.positions)
}

/// The state that every reading of an OBJ needs: vertices, polygons, and the place in the file.
struct Reader<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    lexer: Lexer<'a>,
    positions: Vec<Point3<f64>>,
    polygons: Polygons,
    corners: Vec<u32>,
    /// References to entries that had not been read when they were made: line, kind, entry from 0.
    forward: Vec<(usize, Kind, u32)>,
    /// The lines of the faces of fewer than three corners.
    short: Vec<usize>,
    /// The lines that begin with no word of an OBJ.
    unknown: UnknownLines,
}

/// The lists that corners refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Vertex,
    Texture,
    Normal,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Texture => "texture coordinate",
            Self::Normal => "normal",
        }
    }

    fn plural(self) -> &'static str {
        match self {
            Self::Vertex => "vertices",
            Self::Texture => "texture coordinates",
            Self::Normal => "normals",
        }
    }
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let lexer = Lexer::new(bytes);
        let (positions, polygons) = Default::default();
        Self {
            path,
            bytes,
            lexer,
            positions,
            polygons,
            corners: Vec::new(),
            forward: Vec::new(),
            short: Vec::new(),
            unknown: UnknownLines::default(),
        }
    }

    fn error(&self, line: usize, message: impl Display, hint: &str) -> Error {
        Error::line(self.path, line, message.to_string(), hint)
    }

    /// A `v` line: the places of its three coordinates.
    fn vertex(&mut self) -> Result<[Range<usize>; 3]> {
        let line = self.lexer.line();
        let mut position = Point3::origin();
        let mut fields = [const { 0..0 }; 3];
        for axis in 0..3 {
            let Some(field) = self.lexer.token() else {
                let message = format!("vertex {} has {axis} coordinates, expected 3", self.positions.len() + 1);
                return Err(self.error(line, message, "the file is damaged or cut short: export it again"));
            };
            let token = &self.bytes[field.clone()];
            position[axis] = number(token).filter(|x| x.abs() < MAX_COORDINATE).ok_or_else(|| {
                let (expected, hint) = match number(token) {
                    Some(_) => {
                        ("a number below 1e50", "scale the mesh down: its squares are beyond what can be computed")
                    }
                    None => ("a finite number", "repair the file or export it again without NaN and infinity"),
                };
                let (vertex, found) = (self.positions.len() + 1, shown(&text(token)));
                self.error(line, format!("vertex {vertex} has coordinate `{found}`: expected {expected}"), hint)
            })?;
            fields[axis] = field;
        }
        self.positions.push(position);
        Ok(fields)
    }

    /// An `f` line; references to texture coordinates and normals go to `attributes`.
    fn face(&mut self, mut attributes: Option<&mut Attributes>) -> Result<()> {
        let line = self.lexer.line();
        self.corners.clear();
        let known = attributes.as_ref().map_or(0, |attributes| attributes.texture_indices.len());
        while let Some(token) = self.lexer.token() {
            let token = &self.bytes[token];
            let corner = Corner::parse(token).ok_or_else(|| {
                let message = format!("`{}` is not a corner of a face", shown(&text(token)));
                self.error(line, message, "expected vertex, vertex/texture, vertex//normal or vertex/texture/normal")
            })?;
            let vertex = self.entry(line, Kind::Vertex, corner.vertex, self.positions.len())?;
            self.corners.push(vertex);
            if let Some(attributes) = &mut attributes {
                attributes.corner(self, line, corner)?;
            }
        }
        if self.corners.len() < 3 {
            self.short.push(line);
            if let Some(attributes) = attributes {
                attributes.texture_indices.truncate(known);
                attributes.normal_indices.truncate(known);
            }
            return Ok(());
        }
        self.polygons.push(&self.corners);
        Ok(())
    }

    /// The entry, from 0, that `index` of the file means; whether it exists is known at the end.
    fn entry(&mut self, line: usize, kind: Kind, index: i64, count: usize) -> Result<u32> {
        match Reference::new(index, count) {
            Reference::Entry(entry) => {
                if entry as usize >= count {
                    self.forward.push((line, kind, entry));
                }
                Ok(entry)
            }
            Reference::Nothing if index < 0 => {
                let message = format!(
                    "{} index {index} is out of range: {count} {} stand before this line",
                    kind.name(),
                    kind.plural()
                );
                Err(self.error(line, message, DAMAGED))
            }
            Reference::Nothing => {
                let message = format!("{} index {index} is out of range: indices start at 1", kind.name());
                Err(self.error(line, message, DAMAGED))
            }
        }
    }

    /// The sentence about faces of fewer than three corners, which have no surface.
    fn warning_of_short(&self) -> Option<String> {
        let (first, count) = (self.short.first()?, self.short.len());
        let faces = if count == 1 { "1 face has".into() } else { format!("{count} faces have") };
        Some(format!("{faces} fewer than three corners (line {first}): kept in the file and left out of the solve"))
    }

    /// Checks what can only be checked when all is read.
    fn finish(&self, textures: usize, normals: usize) -> Result<()> {
        for &(line, kind, entry) in &self.forward {
            let count = match kind {
                Kind::Vertex => self.positions.len(),
                Kind::Texture => textures,
                Kind::Normal => normals,
            };
            if entry as usize >= count {
                let (index, name, plural) = (u64::from(entry) + 1, kind.name(), kind.plural());
                let message = format!("{name} index {index} is out of range: the file has {count} {plural}");
                return Err(self.error(line, message, DAMAGED));
            }
        }
        if self.positions.is_empty() || self.polygons.is_empty() {
            let (vertices, faces) = (self.positions.len(), self.polygons.len());
            let hint = "give a mesh with at least one face; point clouds and curves cannot take a deformation";
            return Err(Error::file(self.path, format!("empty mesh: {vertices} vertices, {faces} faces"), hint));
        }
        Ok(())
    }
}

/// Parts have so many names of groups together, or as many as the file has room for.
const MAX_GROUPED: usize = 1 << 18;

const DAMAGED: &str = "the file is damaged or cut short: export it again";

/// The data that faces refer to beside vertices, and the names they stand under.
#[derive(Default)]
struct Attributes {
    texture_values: Vec<[f64; 2]>,
    texture_indices: Vec<Option<u32>>,
    normal_values: Vec<[f64; 3]>,
    normal_indices: Vec<Option<u32>>,
    /// Texture coordinates and normals that are not numbers.
    unreadable: usize,
    /// Numbers that texture coordinates and normals lack.
    missing: usize,
    /// Corners that refer to texture coordinate or normal 0.
    zeros: usize,
    /// The names of groups that parts have together.
    grouped: usize,
    parts: Vec<Part>,
    /// The names that hold for the next face.
    open: Part,
}

impl Attributes {
    fn texture(&mut self, reader: &mut Reader) {
        let missing = self.missing;
        let value = [(); 2].map(|()| self.component(reader, &mut None));
        // Textures of one dimension have one coordinate.
        self.missing -= usize::from(self.missing == missing + 1);
        self.texture_values.push(value);
    }

    fn normal(&mut self, reader: &mut Reader, layout: &mut Layout) {
        let mut decimals = Some(&mut *layout);
        let value = [(); 3].map(|()| self.component(reader, &mut decimals));
        self.normal_values.push(value);
    }

    /// The next number, 0 if there is none. Exporters do write NaN here, so it is no error: no stage depends on it.
    fn component(&mut self, reader: &mut Reader, layout: &mut Option<&mut Layout>) -> f64 {
        let Some(token) = reader.lexer.token() else {
            self.missing += 1;
            return 0.0;
        };
        let token = &reader.bytes[token];
        if let Some(layout) = layout {
            layout.add_normal(token);
        }
        number(token).unwrap_or_else(|| {
            self.unreadable += 1;
            0.0
        })
    }

    fn corner(&mut self, reader: &mut Reader, line: usize, corner: Corner) -> Result<()> {
        self.zeros += usize::from(corner.has_zero);
        let mut entry = |kind, index, count| -> Result<_> {
            if index == 0 { Ok(None) } else { reader.entry(line, kind, index, count).map(Some) }
        };
        self.texture_indices.push(entry(Kind::Texture, corner.texture, self.texture_values.len())?);
        self.normal_indices.push(entry(Kind::Normal, corner.normal, self.normal_values.len())?);
        Ok(())
    }

    /// Starts a part at `polygon` if the names have changed.
    ///
    /// # Errors
    ///
    /// If parts have so many names that the file must be made to use up memory.
    fn part(&mut self, reader: &Reader, polygon: usize) -> Result<()> {
        let same = |part: &Part| {
            (&part.object, &part.groups, &part.material) == (&self.open.object, &self.open.groups, &self.open.material)
        };
        if self.parts.last().is_some_and(same) {
            return Ok(());
        }
        self.grouped += self.open.groups.len();
        // A file that names groups for each part anew has two bytes for each name.
        if self.grouped > MAX_GROUPED.max(reader.bytes.len() / 2) {
            let (groups, parts) = (self.open.groups.len(), self.parts.len() + 1);
            let message = format!(
                "{groups} groups at once, and {parts} changes of object, group and material: more than {} names in all",
                self.grouped - 1
            );
            let hint = "give faces fewer groups, or sort them by their materials";
            return Err(reader.error(reader.lexer.line(), message, hint));
        }
        if let Some(last) = self.parts.last_mut() {
            last.polygons.end = polygon;
        }
        self.parts.push(Part { polygons: polygon..polygon, ..self.open.clone() });
        Ok(())
    }

    fn close_parts(&mut self, polygons: usize) -> Vec<Part> {
        if let Some(last) = self.parts.last_mut() {
            last.polygons.end = polygons;
        }
        std::mem::take(&mut self.parts)
    }

    fn warnings(&self) -> Vec<String> {
        let unreadable =
            format!("{} texture coordinates or normals are not finite numbers and were read as 0", self.unreadable);
        let missing = format!("`vt` and `vn` lines lack {} numbers, which were read as 0", self.missing);
        let zeros = format!(
            "{} corners refer to texture coordinate or normal 0, where numbers start at 1: they have none",
            self.zeros
        );
        let told = [(self.unreadable, unreadable), (self.missing, missing), (self.zeros, zeros)];
        told.into_iter().filter(|(count, _)| *count > 0).map(|(_, warning)| warning).collect()
    }
}

/// An attribute, if any corner has it.
fn attribute<T>(values: Vec<T>, indices: Vec<Option<u32>>) -> Option<CornerAttribute<T>> {
    indices.iter().any(Option::is_some).then_some(CornerAttribute { values, indices })
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
