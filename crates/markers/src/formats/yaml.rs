//! mimesh's own notation of markers: names, notes, places on triangles, and the meshes that the markers were made on.
//!
//! ```yaml
//! source: { mesh: horse.obj, vertices: 8431, blake3: "…" }      # optional
//! target: { mesh: camel.obj, vertices: 21887, blake3: "…" }
//! markers:
//!   - { name: left ear, source: 750, target: 3386, note: tip }
//!   - { name: nose, source: 17, target: 99, status: proposed, confidence: 0.82 }
//!   - { source: { triangle: 12, barycentric: [0.2, 0.3, 0.5] }, target: { vertex: 4, at: [0.1, 2, 3] } }
//! ```
//!
//! `at` is the position of the point when it was made; by it, markers are found again after the mesh was edited. `status` is
//! `confirmed` where it is left out: a person stands for the pair. A stage that finds markers anew keeps those, and no `proposed` ones.
//! No stage sees a pair that is `skipped`. One side may be `null` while its point is still to be found.

use std::{collections::HashMap, fmt::Write, path::Path};

use nalgebra::Point3;
use serde::Deserialize;
use serde_json::Value;

use mimesh_core::mesh::MeshPoint;
use mimesh_document::{At, Diagnostics, Document, Kind, NoShapes, Result, Step, describe, deserialize};

use super::yaml_point::YamlPoint;
use crate::{
    model::{MarkerFile, MarkerPair, MarkerStatus, MeshReference},
    text::{in_line, strip_bom},
};

/// Parses the text of `file`.
///
/// # Errors
///
/// A text that is no YAML, at its first fault; otherwise all that is wrong, each at its place.
pub fn parse(file: &Path, text: &str) -> Result<MarkerFile> {
    parse_document(file, text).map_err(|mut diagnostics| {
        diagnostics.list.iter_mut().for_each(|diagnostic| diagnostic.kind = Kind::BadData);
        diagnostics
    })
}

fn parse_document(file: &Path, text: &str) -> Result<MarkerFile> {
    let document = Document::parse(file, strip_bom(text))?;
    let mut diagnostics = Diagnostics::default();
    check_keys(&document, &mut diagnostics);
    let source = reference(&document, "source", &mut diagnostics);
    let target = reference(&document, "target", &mut diagnostics);
    let items = document.value.get("markers").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    check_items(&document, items, &mut diagnostics);
    let mut pairs = Vec::new();
    for (i, _) in items.iter().enumerate().filter(|(_, item)| item.is_object()) {
        pairs.extend(pair(&document, i, &mut diagnostics));
    }
    check_names(&pairs, &mut diagnostics);
    diagnostics.into_result().map(|()| MarkerFile { source, target, pairs })
}

/// The text of a file, which [`parse`] reads back.
pub fn write(file: &MarkerFile) -> String {
    let mut text = String::new();
    for (side, reference) in [("source", &file.source), ("target", &file.target)] {
        let Some(reference) = reference else { continue };
        let fields = [
            reference.mesh.as_ref().map(|mesh| format!("mesh: {}", quote(mesh))),
            reference.vertices.map(|vertices| format!("vertices: {vertices}")),
            reference.blake3.as_ref().map(|hash| format!("blake3: {}", quote(hash))),
        ];
        let _ = writeln!(text, "{side}: {}", mapping(fields));
    }
    text.push_str(if file.pairs.is_empty() { "markers: []\n" } else { "markers:\n" });
    for pair in &file.pairs {
        let text_of = |point: Option<MeshPoint>, at| point.map_or_else(|| "null".into(), |point| point_text(point, at));
        let status = match pair.status {
            MarkerStatus::Confirmed => None,
            MarkerStatus::Proposed => Some("status: proposed".into()),
            MarkerStatus::Skipped => Some("status: skipped".into()),
        };
        let fields = [
            pair.name.as_ref().map(|name| format!("name: {}", quote(name))),
            Some(format!("source: {}", text_of(pair.source, pair.at[0]))),
            Some(format!("target: {}", text_of(pair.target, pair.at[1]))),
            status,
            pair.confidence.map(|confidence| format!("confidence: {confidence:?}")),
            pair.note.as_ref().map(|note| format!("note: {}", quote(note))),
        ];
        let _ = writeln!(text, "  - {}", mapping(fields));
    }
    text
}

/// A mapping on one line with those of `fields` that there are.
fn mapping<const N: usize>(fields: [Option<String>; N]) -> String {
    let fields: Vec<_> = fields.into_iter().flatten().collect();
    format!("{{ {} }}", fields.join(", "))
}

/// A double-quoted YAML string; characters that may not be printable are escaped, since YAML refuses them.
fn quote(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            _ if c.is_alphanumeric() || matches!(c, ' '..='~') => quoted.push(c),
            _ => {
                let _ = write!(quoted, "\\U{:08X}", u32::from(c));
            }
        }
    }
    quoted + "\""
}

fn point_text(point: MeshPoint, at: Option<Point3<f64>>) -> String {
    let at = at.map(|p| format!(", at: [{:?}, {:?}, {:?}]", p.x, p.y, p.z));
    match (point, at) {
        (MeshPoint::Vertex(vertex), None) => vertex.to_string(),
        (MeshPoint::Vertex(vertex), Some(at)) => format!("{{ vertex: {vertex}{at} }}"),
        (MeshPoint::Triangle(triangle, [a, b, c]), at) => {
            let at = at.unwrap_or_default();
            format!("{{ triangle: {triangle}, barycentric: [{a:?}, {b:?}, {c:?}]{at} }}")
        }
    }
}

fn check_keys(document: &Document, diagnostics: &mut Diagnostics) {
    let Some(mapping) = document.value.as_object() else {
        let diagnostic = document.diagnostic(&[], At::Value, "expected a mapping with the key `markers`");
        diagnostics.push(diagnostic.hint("e.g. `markers: [{ source: 750, target: 3386 }]`"));
        return;
    };
    for key in mapping.keys().filter(|key| !["source", "target", "markers"].contains(&key.as_str())) {
        let diagnostic = document.diagnostic(&[Step::Key(key.clone())], At::Key, format!("unknown key `{key}`"));
        diagnostics.push(diagnostic.hint("known keys: source, target, markers"));
    }
    match mapping.get("markers") {
        Some(Value::Array(_)) => {}
        Some(other) => {
            let path = [Step::Key("markers".into())];
            let message = format!("`markers`: expected a sequence, found {}", describe(other));
            let diagnostic = document.diagnostic(&path, At::Value, message);
            diagnostics.push(diagnostic.hint("e.g. `markers: [{ source: 750, target: 3386 }]`"));
        }
        None => diagnostics.push(document.diagnostic(&[], At::Value, "missing key `markers`")),
    }
}

/// Checks that the markers are mappings: one diagnostic for all that are not.
fn check_items(document: &Document, items: &[Value], diagnostics: &mut Diagnostics) {
    let mut others = items.iter().enumerate().filter(|(_, item)| !item.is_object());
    let Some((i, first)) = others.next() else { return };
    let also = match others.count() {
        0 => String::new(),
        more => format!(", and so with {more} more"),
    };
    let message = format!("marker {}: expected a mapping, found {}{also}", i + 1, describe(first));
    let hint = "write each as `{ source: 750, target: 3386 }`; lines of `750, 3386` go into a .cons file";
    diagnostics.push(document.diagnostic(&path_of(i), At::Value, message).hint(hint));
}

fn check_names(pairs: &[MarkerPair], diagnostics: &mut Diagnostics) {
    let mut seen = HashMap::new();
    for pair in pairs {
        let Some(name) = &pair.name else { continue };
        if let Some(first) = seen.insert(name, pair.location.as_ref()) {
            let message = format!("another marker is called {name}{}", in_line(first));
            diagnostics.push(pair.diagnostic(message).hint("give each its own name"));
        }
    }
}

/// The path of marker `i`.
fn path_of(i: usize) -> [Step; 2] {
    [Step::Key("markers".into()), Step::Index(i)]
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct YamlReference {
    mesh: Option<String>,
    vertices: Option<usize>,
    blake3: Option<String>,
}

fn reference(document: &Document, side: &str, diagnostics: &mut Diagnostics) -> Option<MeshReference> {
    let YamlReference { mesh, vertices, blake3 } =
        deserialize(document, &[Step::Key(side.into())], &NoShapes, diagnostics)?;
    Some(MeshReference { mesh, vertices, blake3 })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct YamlPair {
    name: Option<String>,
    source: Option<YamlPoint>,
    target: Option<YamlPoint>,
    #[serde(default)]
    status: MarkerStatus,
    confidence: Option<f64>,
    note: Option<String>,
}

fn pair(document: &Document, i: usize, diagnostics: &mut Diagnostics) -> Option<MarkerPair> {
    let path = path_of(i);
    let before = diagnostics.len();
    let YamlPair { name, source, target, status, confidence, note } =
        deserialize(document, &path, &NoShapes, diagnostics)?;
    if diagnostics.len() > before {
        return None;
    }
    if source.is_none() && target.is_none() {
        let name = name.unwrap_or_else(|| (i + 1).to_string());
        let diagnostic = document.diagnostic(&path, At::Value, format!("marker {name} has no source and no target"));
        diagnostics
            .push(diagnostic.hint("a marker needs a point on both meshes, e.g. `{ source: 750, target: 3386 }`"));
        return None;
    }
    if let Some(number) = confidence.filter(|number| !(0.0..=1.0).contains(number)) {
        let at = [&path[..], &[Step::Key("confidence".into())]].concat();
        let message = format!("`confidence`: expected a number from 0 to 1, found {number}");
        diagnostics.push(document.diagnostic(&at, At::Value, message));
        return None;
    }
    let at = [&source, &target].map(|point| point.as_ref().and_then(|point| point.at));
    let location = Some(document.location(&path, At::Value));
    Some(MarkerPair {
        name,
        source: source.map(|source| source.point),
        target: target.map(|target| target.point),
        note,
        status,
        confidence,
        at,
        location,
    })
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
        assert_eq!(file.pairs[0].name.as_deref(), Some("ear"));
        assert_eq!(file.pairs[1].source, Some(MeshPoint::Triangle(12, [0.2, 0.3, 0.5])));
        assert_eq!(file.pairs[1].target, Some(MeshPoint::Vertex(4)));
    }

    #[test]
    fn pairs_are_confirmed_unless_they_say_otherwise() {
        let text = "markers: [{ source: 1, target: 2 }, { source: 3, target: 4, status: proposed, confidence: 0.5 }]\n";
        let pairs = read(text).unwrap().pairs;
        assert_eq!((pairs[0].status, pairs[0].confidence), (MarkerStatus::Confirmed, None));
        assert_eq!((pairs[1].status, pairs[1].confidence), (MarkerStatus::Proposed, Some(0.5)));
        let wrong = first_lines(
            "markers: [{ source: 1, target: 2, confidence: 1.5 }, { source: 1, target: 2, status: sure }]\n",
        );
        assert_eq!(wrong[0], "1:47: `confidence`: expected a number from 0 to 1, found 1.5");
        assert!(wrong[1].contains("`status`") && wrong[1].contains("sure"), "{wrong:?}");
    }

    #[test]
    fn every_wrong_marker_is_reported_at_its_place() {
        let text = "markers:\n  - { source: 1 }\n  - { source: -1, target: x }\n  - { source: 1, targt: 2 }\n  \
            - { source: { triangle: 1, barycentric: [0.5, 0.6, 0.5] }, target: 1 }\n  \
            - { source: { triangle: 1, barycentric: [1, 0] }, target: 1 }\n  \
            - { source: { triangle: 1, barycentric: [-0.5, 0.5, 1] }, target: 1 }\n  - {}\n  \
            - { name: a, source: 1, target: 1 }\n  - { name: a, source: 2, target: 2 }\n";
        assert_eq!(
            first_lines(text),
            [
                "3:15: `source`: expected a vertex (a whole number from 0) or `{ triangle: …, barycentric: [a, b, c] }`, found -1",
                "3:27: `target`: expected a vertex (a whole number from 0) or `{ triangle: …, barycentric: [a, b, c] }`, found the string \"x\"",
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
    fn other_keys_and_kinds_are_reported() {
        assert_eq!(
            first_lines("markers: [\"1:2\", { source: 1, target: 2 }, 7, \"3:4\"]\n"),
            ["1:11: marker 1: expected a mapping, found the string \"1:2\", and so with 2 more"]
        );
        assert_eq!(first_lines("marker: []\n"), ["1:1: unknown key `marker`", "1:1: missing key `markers`"]);
        assert_eq!(first_lines("markers: 3\n"), ["1:10: `markers`: expected a sequence, found 3"]);
        assert_eq!(first_lines("- 1\n"), ["1:1: expected a mapping with the key `markers`"]);
    }

    /// Any text without the two characters that `mimesh_document` uses for the braces of placeholders.
    const TEXT: &str = "[^\u{e000}\u{e001}]{0,8}";

    fn point() -> impl Strategy<Value = MeshPoint> {
        prop_oneof![
            any::<u32>().prop_map(MeshPoint::Vertex),
            (any::<u32>(), 0.0..1.0f64, 0.0..1.0f64).prop_map(|(t, a, b)| {
                let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
                MeshPoint::Triangle(t, [a, b, 1.0 - a - b])
            }),
        ]
    }

    proptest! {
        #[test]
        fn markers_come_back_as_written(
            pairs in prop::collection::vec((prop::option::of(point()), point(), prop::option::of(TEXT), 0usize..4), 0..6),
            mesh in prop::option::of(TEXT), vertices in prop::option::of(0usize..1000),
        ) {
            let pairs = pairs.into_iter().enumerate().map(|(i, (one, other, note, kind))| {
                let kept = kind % 2 == 0;
                // Either side may be missing, not both.
                let (source, target) = if kind < 2 { (one, Some(other)) } else { (Some(other), one) };
                let at = kept.then(|| Point3::new(i as f64, 0.1 * i as f64, -1e-7));
                let at = [at.filter(|_| source.is_some()), at.filter(|_| target.is_some())];
                let status = [MarkerStatus::Proposed, MarkerStatus::Confirmed, MarkerStatus::Skipped][kind.min(2)];
                let confidence = kept.then(|| 1.0 / (i as f64 + 1.0));
                let name = (i % 2 == 0).then(|| format!("n{i}: #"));
                MarkerPair { name, source, target, note, status, confidence, at, location: None }
            });
            let source = Some(MeshReference { mesh, vertices, blake3: Some("0123".into()) });
            let file = MarkerFile { source, target: None, pairs: pairs.collect() };
            let text = write(&file);
            let mut back = read(&text).unwrap_or_else(|failure| panic!("{failure}\n{text}"));
            back.pairs.iter_mut().for_each(|pair| pair.location = None);
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
