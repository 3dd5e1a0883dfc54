//! Our own notation of markers: names, notes, places on triangles, and the meshes that they were made on.
//!
//! ```yaml
//! source: { mesh: horse.obj, vertices: 8431, blake3: "…" }      # optional
//! target: { mesh: camel.obj, vertices: 21887, blake3: "…" }
//! markers:
//!   - { name: left ear, source: 750, target: 3386, note: tip }
//!   - { source: { triangle: 12, barycentric: [0.2, 0.3, 0.5] }, target: { vertex: 4, at: [0.1, 2, 3] } }
//! ```
//!
//! `at` is where the point was when it was made; with it, markers are found again after the mesh was edited.

use std::{fmt, fmt::Write, path::Path};

use nalgebra::Point3;
use serde::{
    Deserialize, Deserializer,
    de::{self, MapAccess, Visitor},
};
use serde_json::Value;

use super::{Entry, MarkerFile, MeshReference};
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    pipeline::{At, Document, Step, parse as pipeline_parse},
};

/// Barycentric coordinates may miss their sum of 1 by this, as they are rounded in files.
const SUM_TOLERANCE: f64 = 1e-6;
/// Barycentric coordinates on an edge may be rounded below zero by this.
const NEGATIVE_TOLERANCE: f64 = -1e-9;

/// Parses the text of `file`.
///
/// # Errors
///
/// All that is wrong, each with its place.
pub fn parse(file: &Path, text: &str) -> Result<MarkerFile> {
    let as_data = |mut diagnostics: Vec<Diagnostic>| {
        diagnostics.iter_mut().for_each(|diagnostic| diagnostic.kind = Kind::BadData);
        Diagnostics { diagnostics }
    };
    let document =
        Document::parse(file, super::text::without_mark(text)).map_err(|failure| as_data(failure.diagnostics))?;
    let mut diagnostics = Vec::new();
    check_keys(&document, &mut diagnostics);
    let source = reference(&document, "source", &mut diagnostics);
    let target = reference(&document, "target", &mut diagnostics);
    let mut entries = Vec::new();
    let list = document.value.get("markers").and_then(Value::as_array);
    let (maps, others): (Vec<_>, Vec<_>) =
        list.into_iter().flatten().enumerate().partition(|(_, item)| item.is_object());
    if let [(i, first), more @ ..] = &others[..] {
        let path = [Step::Key("markers".into()), Step::Index(*i)];
        let also = if more.is_empty() { String::new() } else { format!(", and so with {} more", more.len()) };
        let message = format!("marker {}: expected a map, found {first}{also}", i + 1);
        let hint = "write each as `{ source: 750, target: 3386 }`; lines of `750, 3386` go into a .cons file";
        diagnostics.push(document.diagnostic(&path, At::Value, message).hint(hint));
    }
    for (i, _) in maps {
        entries.extend(entry(&document, i, &mut diagnostics));
    }
    check_names(&entries, &mut diagnostics);
    if diagnostics.is_empty() { Ok(MarkerFile { source, target, entries }) } else { Err(as_data(diagnostics)) }
}

/// The text of a file, which [`parse`] reads back.
pub fn write(file: &MarkerFile) -> String {
    let mut text = String::new();
    for (side, reference) in [("source", &file.source), ("target", &file.target)] {
        if let Some(reference) = reference {
            let fields = [
                reference.mesh.as_ref().map(|mesh| format!("mesh: {}", quote(mesh))),
                reference.vertices.map(|vertices| format!("vertices: {vertices}")),
                reference.blake3.as_ref().map(|hash| format!("blake3: {}", quote(hash))),
            ];
            let fields: Vec<_> = fields.into_iter().flatten().collect();
            let _ = writeln!(text, "{side}: {{ {} }}", fields.join(", "));
        }
    }
    text.push_str(if file.entries.is_empty() { "markers: []\n" } else { "markers:\n" });
    for entry in &file.entries {
        let fields = [
            entry.name.as_ref().map(|name| format!("name: {}", quote(name))),
            Some(format!("source: {}", point_text(entry.source, entry.at[0]))),
            Some(format!(
                "target: {}",
                entry.target.map_or_else(|| "null".into(), |target| point_text(target, entry.at[1]))
            )),
            entry.note.as_ref().map(|note| format!("note: {}", quote(note))),
        ];
        let fields: Vec<_> = fields.into_iter().flatten().collect();
        let _ = writeln!(text, "  - {{ {} }}", fields.join(", "));
    }
    text
}

/// A double-quoted YAML text; what may not be printable is escaped, since YAML refuses such characters.
fn quote(text: &str) -> String {
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' | '\\' => format!("\\{c}"),
            _ if c.is_alphanumeric() || matches!(c, ' '..='~') => c.to_string(),
            _ => format!("\\U{:08X}", u32::from(c)),
        })
        .collect();
    format!("\"{escaped}\"")
}

fn point_text(point: SurfacePoint, at: Option<Point3<f64>>) -> String {
    let at = at.map(|p| format!(", at: [{:?}, {:?}, {:?}]", p.x, p.y, p.z));
    match (point, at) {
        (SurfacePoint::Vertex(vertex), None) => vertex.to_string(),
        (SurfacePoint::Vertex(vertex), Some(at)) => format!("{{ vertex: {vertex}{at} }}"),
        (SurfacePoint::Triangle(triangle, [a, b, c]), at) => {
            let at = at.unwrap_or_default();
            format!("{{ triangle: {triangle}, barycentric: [{a:?}, {b:?}, {c:?}]{at} }}")
        }
    }
}

fn check_keys(document: &Document, diagnostics: &mut Vec<Diagnostic>) {
    let Some(map) = document.value.as_object() else {
        let message = "expected a map with the key `markers`";
        diagnostics
            .push(document.diagnostic(&[], At::Value, message).hint("e.g. `markers: [{ source: 750, target: 3386 }]`"));
        return;
    };
    for key in map.keys().filter(|key| !["source", "target", "markers"].contains(&key.as_str())) {
        let path = [Step::Key(key.clone())];
        let hint = "known keys: source, target, markers";
        diagnostics.push(document.diagnostic(&path, At::Key, format!("unknown key `{key}`")).hint(hint));
    }
    match map.get("markers") {
        Some(Value::Array(_)) => {}
        Some(_) => diagnostics.push(document.diagnostic(
            &[Step::Key("markers".into())],
            At::Value,
            "`markers`: expected a list",
        )),
        None => diagnostics.push(document.diagnostic(&[], At::Value, "missing key `markers`")),
    }
}

fn check_names(entries: &[Entry], diagnostics: &mut Vec<Diagnostic>) {
    let mut seen = std::collections::HashMap::new();
    for entry in entries {
        let (Some(name), Some(Location::Span { line, .. })) = (&entry.name, &entry.location) else { continue };
        if let Some(first) = seen.insert(name, line) {
            let message = format!("another marker is called {name} (line {first})");
            diagnostics.push(entry.diagnostic(message).hint("give each its own name"));
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawReference {
    mesh: Option<String>,
    vertices: Option<usize>,
    blake3: Option<String>,
}

fn reference(document: &Document, side: &str, diagnostics: &mut Vec<Diagnostic>) -> Option<MeshReference> {
    let raw: RawReference = pipeline_parse::value(document, &[Step::Key(side.into())], diagnostics)?;
    Some(MeshReference { mesh: raw.mesh, vertices: raw.vertices, blake3: raw.blake3 })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEntry {
    name: Option<String>,
    source: Option<RawPoint>,
    target: Option<RawPoint>,
    note: Option<String>,
}

fn entry(document: &Document, i: usize, diagnostics: &mut Vec<Diagnostic>) -> Option<Entry> {
    let path = [Step::Key("markers".into()), Step::Index(i)];
    let before = diagnostics.len();
    let raw: RawEntry = pipeline_parse::value(document, &path, diagnostics)?;
    if diagnostics.len() > before {
        return None;
    }
    let Some(source) = raw.source else {
        let name = raw.name.unwrap_or_else(|| (i + 1).to_string());
        let also = if raw.target.is_some() { "" } else { " and no target" };
        let message = format!("marker {name} has no source{also}");
        let hint = "a marker needs a point on both meshes, e.g. `{ source: 750, target: 3386 }`";
        diagnostics.push(document.diagnostic(&path, At::Value, message).hint(hint));
        return None;
    };
    let location = Some(document.location(&path, At::Value));
    let at = [source.1, raw.target.as_ref().and_then(|target| target.1)];
    Some(Entry {
        name: raw.name,
        source: source.0,
        target: raw.target.map(|point| point.0),
        note: raw.note,
        at,
        location,
    })
}

/// A vertex as a number or as `{ vertex: 4 }`, or `{ triangle: 12, barycentric: [0.2, 0.3, 0.5] }`; the maps also with
/// `at: [x, y, z]`.
struct RawPoint(SurfacePoint, Option<Point3<f64>>);

impl<'de> Deserialize<'de> for RawPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_any(PointVisitor)
    }
}

struct PointVisitor;

impl<'de> Visitor<'de> for PointVisitor {
    type Value = RawPoint;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a vertex (a whole number from 0) or `{ triangle: …, barycentric: [a, b, c] }`")
    }

    fn visit_u64<E: de::Error>(self, vertex: u64) -> std::result::Result<RawPoint, E> {
        let wrong = || E::invalid_value(de::Unexpected::Unsigned(vertex), &self);
        u32::try_from(vertex).map(|v| RawPoint(SurfacePoint::Vertex(v), None)).map_err(|_| wrong())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<RawPoint, A::Error> {
        const KEYS: &[&str] = &["vertex", "triangle", "barycentric", "at"];
        let (mut vertex, mut triangle, mut barycentric, mut at) = (None, None, None, None);
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "vertex" => vertex = Some(map.next_value::<u32>()?),
                "triangle" => triangle = Some(map.next_value::<u32>()?),
                "barycentric" => barycentric = Some(map.next_value::<Vec<f64>>()?),
                "at" => at = Some(check_at(&map.next_value::<Vec<f64>>()?).map_err(de::Error::custom)?),
                other => return Err(de::Error::unknown_field(other, KEYS)),
            }
        }
        let point = match (vertex, triangle, barycentric) {
            (Some(vertex), None, None) => Ok(SurfacePoint::Vertex(vertex)),
            (None, Some(triangle), Some(barycentric)) => {
                Ok(SurfacePoint::Triangle(triangle, check_barycentric(&barycentric).map_err(de::Error::custom)?))
            }
            (None, Some(_), None) => Err(de::Error::missing_field("barycentric")),
            (None, None, Some(_)) => Err(de::Error::missing_field("triangle")),
            (None, None, None) => Err(de::Error::missing_field("vertex")),
            _ => Err(de::Error::custom("expected either a vertex or a triangle, found both")),
        };
        Ok(RawPoint(point?, at))
    }
}

fn check_at(values: &[f64]) -> std::result::Result<Point3<f64>, String> {
    match <[f64; 3]>::try_from(values) {
        Ok(values) if values.iter().all(|value| value.is_finite()) => Ok(Point3::from(values)),
        Ok(_) => Err("expected finite coordinates".into()),
        Err(_) => Err(format!("expected three coordinates, found {}", values.len())),
    }
}

pub(super) fn check_barycentric(values: &[f64]) -> std::result::Result<[f64; 3], String> {
    let Ok(values) = <[f64; 3]>::try_from(values) else {
        return Err(format!("expected three barycentric coordinates, found {}", values.len()));
    };
    let sum: f64 = values.iter().sum();
    if sum.is_nan() || (sum - 1.0).abs() > SUM_TOLERANCE {
        return Err(format!("barycentric coordinates sum to {sum}, expected 1"));
    }
    match values.iter().find(|value| **value < NEGATIVE_TOLERANCE) {
        Some(value) => Err(format!("barycentric coordinate {value} is negative: the point lies outside the triangle")),
        None => Ok(values),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<MarkerFile> {
        parse(Path::new("m.yaml"), text)
    }

    fn first_lines(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().filter_map(|line| line.strip_prefix("error: m.yaml:")).map(str::to_owned).collect()
    }

    #[test]
    fn every_notation_of_a_point_is_read() {
        let text = "source: { mesh: a.obj, vertices: 9 }\nmarkers:\n  - { name: ear, source: 750, target: 3386, note: tip }\n  \
            - { source: { triangle: 12, barycentric: [0.2, 0.3, 0.5] }, target: { vertex: 4 } }\n";
        let file = read(text).unwrap();
        assert_eq!(file.source.unwrap().vertices, Some(9));
        assert_eq!(file.entries[0].name.as_deref(), Some("ear"));
        assert_eq!(file.entries[1].source, SurfacePoint::Triangle(12, [0.2, 0.3, 0.5]));
        assert_eq!(file.entries[1].target, Some(SurfacePoint::Vertex(4)));
    }

    #[test]
    fn every_wrong_marker_is_told_at_its_place() {
        let text = "markers:\n  - { source: 1 }\n  - { source: -1, target: x }\n  - { source: 1, targt: 2 }\n  \
            - { source: { triangle: 1, barycentric: [0.5, 0.6, 0.5] }, target: 1 }\n  \
            - { source: { triangle: 1, barycentric: [1, 0] }, target: 1 }\n  \
            - { source: { triangle: 1, barycentric: [-0.5, 0.5, 1] }, target: 1 }\n  - {}\n  \
            - { name: a, source: 1, target: 1 }\n  - { name: a, source: 2, target: 2 }\n";
        assert_eq!(
            first_lines(text),
            [
                "3:15: `source`: expected a vertex (a whole number from 0) or `{ triangle: …, barycentric: [a, b, c] }`, found -1",
                "3:27: `target`: expected a vertex (a whole number from 0) or `{ triangle: …, barycentric: [a, b, c] }`, found the text \"x\"",
                "4:18: unknown key `targt`",
                "5:15: `source`: barycentric coordinates sum to 1.6, expected 1",
                "6:15: `source`: expected three barycentric coordinates, found 2",
                "7:15: `source`: barycentric coordinate -0.5 is negative: the point lies outside the triangle",
                "8:5: marker 7 has no source and no target",
                "10:5: another marker is called a (line 9)",
            ]
        );
    }

    #[test]
    fn other_keys_and_kinds_are_told() {
        assert_eq!(
            first_lines("markers: [\"1:2\", { source: 1, target: 2 }, 7, \"3:4\"]\n"),
            ["1:11: marker 1: expected a map, found \"1:2\", and so with 2 more"]
        );
        assert_eq!(first_lines("marker: []\n"), ["1:1: unknown key `marker`", "1:1: missing key `markers`"]);
        assert_eq!(first_lines("markers: 3\n"), ["1:10: `markers`: expected a list"]);
        assert_eq!(first_lines("- 1\n"), ["1:1: expected a map with the key `markers`"]);
    }

    fn point() -> impl Strategy<Value = SurfacePoint> {
        prop_oneof![
            any::<u32>().prop_map(SurfacePoint::Vertex),
            (any::<u32>(), 0.0..1.0f64, 0.0..1.0f64).prop_map(|(t, a, b)| {
                let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
                SurfacePoint::Triangle(t, [a, b, 1.0 - a - b])
            }),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(
            entries in prop::collection::vec((point(), prop::option::of(point()), prop::option::of(".{0,8}"), any::<bool>()), 0..6),
            mesh in prop::option::of(".{0,8}"), vertices in prop::option::of(0usize..1000),
        ) {
            let entries = entries.into_iter().enumerate().map(|(i, (source, target, note, kept))| {
                let at = kept.then(|| Point3::new(i as f64, 0.1 * i as f64, -1e-7));
                let at = [at, at.filter(|_| target.is_some())];
                Entry { name: (i % 2 == 0).then(|| format!("n{i}: #")), source, target, note, at, location: None }
            });
            let source = Some(MeshReference { mesh, vertices, blake3: Some("0123".into()) });
            let file = MarkerFile { source, target: None, entries: entries.collect() };
            let text = write(&file);
            let mut back = read(&text).unwrap_or_else(|failure| panic!("{failure}\n{text}"));
            back.entries.iter_mut().for_each(|entry| entry.location = None);
            prop_assert_eq!(back, file);
        }

        #[test]
        fn no_text_makes_the_reader_panic(text in "[ -~\n]{0,80}") {
            let _ = read(&text);
        }

        #[test]
        fn no_marker_makes_the_reader_panic(text in "[a-z0-9{}\\[\\],:.\" -]{0,60}") {
            let _ = read(&format!("markers:\n  - {text}\n"));
        }
    }
}
