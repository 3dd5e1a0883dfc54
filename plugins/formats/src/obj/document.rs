use std::{borrow::Cow, fmt, ops::Range, path::Path, sync::OnceLock};

use mimesh_core::mesh::Mesh;
use nalgebra::Point3;

use super::{lexer::Lexer, libraries::LibraryLines};
use crate::{normals::PosedNormals, number::Decimals};

/// An OBJ as it was read, so that it can be written with other coordinates.
pub struct ObjDocument {
    bytes: Vec<u8>,
    /// Where the fields of each `v` line start.
    vertex_lines: Vec<usize>,
    /// Where the fields of each `vn` line start.
    normal_lines: Vec<usize>,
    /// The `mtllib` lines.
    pub libraries: LibraryLines,
    layout: Layout,
    /// The numbers on the `v` lines.
    positions: Vec<Point3<f64>>,
    /// The numbers on the `vn` lines, if faces use them.
    normals: Vec<[f64; 3]>,
    corners: usize,
    posed_normals: OnceLock<PosedNormals>,
}

impl ObjDocument {
    /// Keeps `bytes`, of which `mesh` was read.
    pub fn new(
        bytes: Vec<u8>,
        vertex_lines: Vec<usize>,
        normal_lines: Vec<usize>,
        libraries: LibraryLines,
        layout: Layout,
        mesh: &Mesh,
    ) -> Self {
        Self {
            bytes,
            vertex_lines,
            normal_lines,
            libraries,
            layout,
            positions: mesh.positions.clone(),
            normals: mesh.normals.as_ref().map(|normals| normals.values.clone()).unwrap_or_default(),
            corners: mesh.polygons.corner_count(),
            posed_normals: OnceLock::new(),
        }
    }

    /// Whether `mesh` has the vertices and corners of the file still.
    pub fn describes(&self, mesh: &Mesh) -> bool {
        mesh.positions.len() == self.positions.len() && mesh.polygons.corner_count() == self.corners
    }

    /// The file with `positions` (#V × 3) on its `v` lines, and with normals turned along if `turn_normals`.
    ///
    /// `mesh` may be the mesh of the file in another unit and axes, as `positions` are then. Numbers that have not changed stay byte for
    /// byte. Material libraries are named as from `folder`, if that is given.
    pub fn with_positions(
        &self,
        folder: Option<&Path>,
        mesh: &Mesh,
        positions: &[Point3<f64>],
        turn_normals: bool,
    ) -> Vec<u8> {
        let normals = if turn_normals && !self.normals.is_empty() && positions != self.positions {
            let posed = self.posed_normals.get_or_init(|| PosedNormals::new(&self.as_read(mesh), &self.positions));
            posed.of_values(mesh, positions)
        } else {
            let of_mesh = mesh.normals.as_ref().map(|normals| &normals.values);
            of_mesh.filter(|values| values.len() == self.normals.len()).unwrap_or(&self.normals).clone()
        };
        let extent = mesh.diagonal_of(positions).max(mesh.diagonal());
        let position_decimals = Decimals::for_positions(extent, self.layout.position_decimals);
        let normal_decimals = Decimals::fixed(self.layout.normal_decimals.max(4));

        let mut patch = Patch::new(&self.bytes, self.layout.columns.is_some());
        let mut normal_lines = self.normal_lines.iter().zip(self.normals.iter().zip(&normals)).peekable();
        let libraries = folder.map(|folder| self.libraries.moved_to(folder)).unwrap_or_default();
        let mut libraries = libraries.into_iter().peekable();
        let mut write_others = |patch: &mut Patch, before: usize| {
            while let Some((&line, (old, new))) = normal_lines.next_if(|(line, _)| **line < before) {
                while let Some((place, names)) = libraries.next_if(|(place, _)| place.start < line) {
                    patch.text(place, names.as_bytes());
                }
                patch.line(line, *old, *new, normal_decimals);
            }
            while let Some((place, names)) = libraries.next_if(|(place, _)| place.start < before) {
                patch.text(place, names.as_bytes());
            }
        };
        for (&line, (old, new)) in self.vertex_lines.iter().zip(self.positions.iter().zip(positions)) {
            write_others(&mut patch, line);
            patch.line(line, (*old).into(), (*new).into(), position_decimals);
        }
        write_others(&mut patch, usize::MAX);
        patch.finish()
    }

    /// `mesh` with the numbers of the file.
    fn as_read<'a>(&self, mesh: &'a Mesh) -> Cow<'a, Mesh> {
        if mesh.positions == self.positions {
            return Cow::Borrowed(mesh);
        }
        let mut read = Mesh { positions: self.positions.clone(), ..mesh.clone() };
        if let Some(normals) = read.normals.as_mut().filter(|normals| normals.values.len() == self.normals.len()) {
            normals.values.clone_from(&self.normals);
        }
        Cow::Owned(read)
    }
}

impl fmt::Debug for ObjDocument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ObjDocument").field("bytes", &self.bytes.len()).field("layout", &self.layout).finish()
    }
}

/// How a file writes its numbers.
#[derive(Debug)]
pub struct Layout {
    /// The most decimals on a `v` line.
    position_decimals: u32,
    /// The most decimals on a `vn` line.
    normal_decimals: u32,
    /// Where the coordinates of every `v` line end, counted from the keyword, as long as they end at one place.
    columns: Option<[usize; 3]>,
    first: bool,
}

impl Default for Layout {
    fn default() -> Self {
        Self { position_decimals: 0, normal_decimals: 0, columns: None, first: true }
    }
}

impl Layout {
    /// Learns from a `v` line with coordinates at `fields`.
    pub fn add_vertex(&mut self, bytes: &[u8], fields: [Range<usize>; 3]) {
        let start = bytes[..fields[0].start].iter().rposition(|&b| b == b'v').unwrap_or(0);
        let ends = [0, 1, 2].map(|axis| fields[axis].end - start);
        self.columns = if self.first || self.columns == Some(ends) { Some(ends) } else { None };
        self.first = false;
        for field in fields {
            self.position_decimals = self.position_decimals.max(decimals(&bytes[field]));
        }
    }

    /// Learns from a number on a `vn` line.
    pub fn add_normal(&mut self, token: &[u8]) {
        self.normal_decimals = self.normal_decimals.max(decimals(token));
    }
}

/// Digits after the point; 0 for a number with an exponent, whose digits tell nothing.
fn decimals(token: &[u8]) -> u32 {
    match token.iter().position(|&b| b == b'.') {
        Some(point) if token[point + 1..].iter().all(u8::is_ascii_digit) => (token.len() - point - 1) as u32,
        _ => 0,
    }
}

/// A copy of a file in the making, with other numbers at some places.
struct Patch<'a> {
    source: &'a [u8],
    copied: usize,
    out: Vec<u8>,
    number: Vec<u8>,
    aligned: bool,
}

impl<'a> Patch<'a> {
    fn new(source: &'a [u8], aligned: bool) -> Self {
        let out = Vec::with_capacity(source.len() + source.len() / 4);
        Self { source, copied: 0, out, number: Vec::new(), aligned }
    }

    /// Replaces the three numbers after byte `at` where they have changed.
    fn line(&mut self, at: usize, old: [f64; 3], new: [f64; 3], decimals: Decimals) {
        if old == new {
            return;
        }
        let mut lexer = Lexer::resume(self.source, at);
        for (old, new) in old.into_iter().zip(new) {
            let Some(field) = lexer.token() else { return };
            if old != new {
                self.number.clear();
                decimals.push(&mut self.number, new);
                self.replace(field);
            }
        }
    }

    /// Puts `text` in the place of `range`.
    fn text(&mut self, range: Range<usize>, text: &[u8]) {
        self.out.extend_from_slice(&self.source[self.copied..range.start]);
        self.out.extend_from_slice(text);
        self.copied = range.end;
    }

    /// Puts `number` in the place of `field`; in aligned columns it ends where the old one did, if there is room.
    fn replace(&mut self, field: Range<usize>) {
        let gap = self.source[self.copied..field.start].iter().rev().take_while(|&&b| b == b' ').count();
        self.out.extend_from_slice(&self.source[self.copied..field.start - gap]);
        let wanted = if self.aligned { (gap + field.len()).saturating_sub(self.number.len()) } else { gap };
        let blanks = if gap > 0 { wanted.max(1) } else { 0 };
        self.out.resize(self.out.len() + blanks, b' ');
        self.out.append(&mut self.number);
        self.copied = field.end;
    }

    fn finish(mut self) -> Vec<u8> {
        self.out.extend_from_slice(&self.source[self.copied..]);
        self.out
    }
}
