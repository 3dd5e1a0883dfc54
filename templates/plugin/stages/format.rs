//! OFF: a text file with the line `OFF`, the counts of vertices, polygons and edges, then a line for each vertex and polygon.
//!
//! Empty lines and what follows a `#` are skipped; so are colours behind a polygon. Numbers are written so that they come back
//! to the last bit.

use std::{fmt::Display, io::Write, path::Path, str::FromStr};

use mimesh_core::{
    Error, Result,
    mesh::{Mesh, MeshSequence},
    register,
    stage::{FileInput, Format, MeshWriter, PoseWriter, Selection, WriteError},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Format: MyStage);

/// OFF, a text file of vertices and polygons.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {}

#[typetag::serde(name = "my_stage")]
impl Format for MyStage {
    fn extensions(&self) -> &'static [&'static str] {
        &["off"]
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        let path = input.path();
        let bytes = input.contents()?;
        let text = String::from_utf8_lossy(&bytes);
        let mut lines = Lines { path, lines: text.lines().enumerate().collect::<Vec<_>>().into_iter(), last: 0 };
        let mut header = lines.words("the line OFF")?;
        match header.first() {
            Some(&"OFF") => header.remove(0),
            _ => return Err(lines.error("expected the line OFF", "is it an OFF file?")),
        };
        let counts = if header.is_empty() { lines.words("the counts")? } else { header };
        let (vertices, polygons): (usize, usize) = (lines.number(&counts, 0)?, lines.number(&counts, 1)?);
        let mut mesh = Mesh::default();
        for _ in 0..vertices {
            let words = lines.words("a vertex")?;
            let at = |k: usize| lines.number(&words, k);
            mesh.positions.push(Point3::new(at(0)?, at(1)?, at(2)?));
        }
        for _ in 0..polygons {
            let words = lines.words("a polygon")?;
            let count: usize = lines.number(&words, 0)?;
            let corners = (1..=count.min(words.len())).map(|k| lines.number::<u32>(&words, k));
            let corners = corners.collect::<Result<Vec<u32>>>()?;
            if let Some(missing) = corners.iter().find(|&&c| c as usize >= vertices) {
                let message = format!("there is no vertex {missing}: expected 0 to {}", vertices.saturating_sub(1));
                return Err(lines.error(&message, "export the mesh again; the file is damaged"));
            }
            mesh.polygons.push(&corners);
        }
        Ok(MeshSequence { rest: mesh, ..MeshSequence::default() })
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        Some(MeshWriter::Pose(self))
    }
}

impl PoseWriter for MyStage {
    fn write(&self, mesh: &Mesh, positions: &[Point3<f64>], out: &mut dyn Write) -> Result<(), WriteError> {
        Error::check_shape("vertices (#V)", mesh.positions.len(), positions.len())?;
        writeln!(out, "OFF\n{} {} 0", positions.len(), mesh.polygons.len())?;
        for p in positions {
            writeln!(out, "{} {} {}", p.x, p.y, p.z)?;
        }
        for corners in mesh.polygons.iter() {
            write!(out, "{}", corners.len())?;
            corners.iter().try_for_each(|corner| write!(out, " {corner}"))?;
            writeln!(out)?;
        }
        Ok(())
    }
}

/// The lines of a file that say something.
struct Lines<'a> {
    path: &'a Path,
    lines: std::vec::IntoIter<(usize, &'a str)>,
    /// The number of the last line taken, from 1.
    last: usize,
}

impl<'a> Lines<'a> {
    /// The words of the next line, one at least.
    fn words(&mut self, what: &str) -> Result<Vec<&'a str>> {
        for (number, line) in self.lines.by_ref() {
            self.last = number + 1;
            let words: Vec<_> = line.split('#').next().unwrap_or_default().split_whitespace().collect();
            if !words.is_empty() {
                return Ok(words);
            }
        }
        Err(self.error(
            &format!("expected {what}, found the end of the file"),
            "export the mesh again; the file is cut short",
        ))
    }

    /// Word `k` as a number.
    fn number<T: FromStr<Err: Display>>(&self, words: &[&str], k: usize) -> Result<T> {
        let hint = "export the mesh again; the file is damaged";
        let word = words.get(k).ok_or_else(|| self.error(&format!("expected {} numbers or more", k + 1), hint))?;
        word.parse().map_err(|error| self.error(&format!("`{word}` is not such a number: {error}"), hint))
    }

    fn error(&self, message: &str, hint: &str) -> Error {
        Error::line(self.path, self.last.max(1), message, hint)
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::stage::BytesInput;

    use super::*;

    #[test]
    fn comments_and_colours_are_skipped() {
        let text = "OFF # made by hand\n\n3 1 0\n0 0 0\n1 0 0\n0 1 0 # the last\n3 0 1 2 255 0 0\n";
        let mesh = MyStage::default().read(&BytesInput::new("mesh.off", text), &Selection::default()).unwrap().rest;
        assert_eq!((mesh.positions.len(), mesh.polygons.get(0)), (3, &[0, 1, 2][..]));
    }
}
