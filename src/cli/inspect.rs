//! `mimesh inspect`: the content and the defects of a mesh.

use crate::cli::roots::Roots;
use mimesh_core::stage::Selection;
use std::path::{Path, PathBuf};

use mimesh_core::mesh::{Animation, MeshSequence, Part, Statistics};
use mimesh_pipeline::{
    check::in_file,
    text::{bytes, count, number, pairs, seconds, thousands},
};
use serde_json::{Value, json};

use crate::cli::{CommandResult, components::ComponentGraph, status::Status, terminal};

/// Shows the content of a mesh: counts, components, defects, size, parts, morph targets and animations.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    /// The mesh's file
    mesh: PathBuf,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
    /// List the components: number, name, vertices and neighbours
    #[arg(long)]
    components: bool,
    /// Print the graph of components for Graphviz: `mimesh inspect MESH --graphviz | dot -Tsvg > graph.svg`
    #[arg(long, conflicts_with_all = ["json", "components"])]
    graphviz: bool,
    #[command(flatten)]
    roots: Roots,
}

impl Inspect {
    /// Runs the command.
    pub fn run(&self) -> CommandResult {
        let file = &self.mesh;
        let formats = self.roots.formats();
        let format = formats.reader_of(file)?;
        let with_file = |error| in_file(file, error);
        let sequence = formats.read(file, &Selection::default()).map_err(with_file)?;
        let size = std::fs::metadata(file).map(|metadata| metadata.len()).unwrap_or_default();
        let title = format!("{} ({}, {})\n", file.display(), format.typetag_name(), bytes(size));
        if !format.holds_faces() {
            if self.json {
                terminal::print_json(&cache_as_json(file, size, &sequence));
            } else {
                terminal::print(&cache_page(title, &sequence));
            }
            return Ok(Status::Done);
        }
        let statistics = Statistics::new(&sequence.rest).map_err(with_file)?;
        let graph = match self.components || self.graphviz {
            true => Some(ComponentGraph::new(&sequence.rest).map_err(with_file)?),
            false => None,
        };
        if self.json {
            let mut all = as_json(file, size, &sequence, &statistics);
            if let Some(graph) = &graph {
                all["proximity"] = graph.json();
            }
            terminal::print_json(&all);
        } else if let Some(graph) = graph {
            terminal::print(&if self.graphviz { graph.graphviz() } else { graph.table() });
        } else {
            terminal::print(&page(&title, &sequence, &statistics));
        }
        Ok(Status::Done)
    }
}

fn as_json(file: &Path, bytes: u64, sequence: &MeshSequence, statistics: &Statistics) -> Value {
    let mesh = &sequence.rest;
    let animation = |a: &Animation| json!({ "name": a.name, "seconds": a.seconds, "moves": a.channels });
    let part = |part: &Part| {
        let polygons = part.polygons.len();
        json!({ "object": part.object, "groups": part.groups, "material": part.material, "polygons": polygons })
    };
    json!({
        "file": terminal::shown(file), "bytes": bytes, "statistics": statistics, "unit_guess": unit(statistics.diagonal),
        "texture_coordinates": mesh.texture_coordinates.is_some(), "normals": mesh.normals.is_some(),
        "parts": mesh.parts.iter().map(part).collect::<Vec<_>>(),
        "materials": mesh.materials.iter().map(|material| &material.name).collect::<Vec<_>>(),
        "poses": sequence.poses.iter().map(|pose| &pose.name).collect::<Vec<_>>(),
        "animations": sequence.animations.iter().map(animation).collect::<Vec<_>>(),
        "landmarks": sequence.landmarks.iter().map(|landmark| &landmark.name).collect::<Vec<_>>(),
        "warnings": sequence.warnings,
    })
}

/// The content of a file of poses without polygons.
fn cache_as_json(file: &Path, bytes: u64, sequence: &MeshSequence) -> Value {
    let animation = |a: &Animation| json!({ "name": a.name, "seconds": a.seconds });
    json!({
        "file": terminal::shown(file), "bytes": bytes, "vertices": sequence.rest.positions.len(),
        "poses": sequence.poses.iter().map(|pose| &pose.name).collect::<Vec<_>>(),
        "animations": sequence.animations.iter().map(animation).collect::<Vec<_>>(),
        "warnings": sequence.warnings,
    })
}

/// The same as text, below `title`.
fn cache_page(title: String, sequence: &MeshSequence) -> String {
    let names = shortened(sequence.poses.iter().map(|pose| pose.name.clone()).collect());
    let mut rows = vec![
        ("vertices".to_owned(), thousands(sequence.rest.positions.len())),
        ("polygons".to_owned(), "none: these are poses of the mesh in another file".to_owned()),
        ("poses".to_owned(), format!("{}: {names}", sequence.poses.len())),
    ];
    if !sequence.animations.is_empty() {
        rows.push(("animations".to_owned(), shortened(sequence.animations.iter().map(animation).collect())));
    }
    title + &pairs(&rows)
}

/// The content of a mesh as text, below `title`.
fn page(title: &str, sequence: &MeshSequence, s: &Statistics) -> String {
    let mesh = &sequence.rest;
    let mut rows: Vec<(String, String)> = Vec::new();
    let mut row = |name: &str, text: String| rows.push((name.into(), text));
    let welded = if s.welded_vertices == s.vertices {
        String::new()
    } else {
        format!(", {} after welding seams", thousands(s.welded_vertices))
    };
    row("vertices", thousands(s.vertices) + &welded);
    row("polygons", polygons(s));
    row("components", components(&s.component_sizes));
    row(
        "boundary edges",
        if s.boundary_edges == 0 { "none: the surface is closed".into() } else { thousands(s.boundary_edges) },
    );
    row("diagonal", format!("{} ({})", number(s.diagonal), unit(s.diagonal)));
    let [low, high] = s.bounding_box;
    let axis = |i: usize| format!("{} {} to {}", ["x", "y", "z"][i], number(low[i]), number(high[i]));
    row("bounding box", [0, 1, 2].map(axis).join(", "));
    row("area", number(s.area));
    if let Some(volume) = s.volume {
        let inside_out = if volume < 0.0 { " (negative: faces point inwards)" } else { "" };
        row("volume", number(volume) + inside_out);
    }
    row("texture coords", yes_or_no(mesh.texture_coordinates.is_some()));
    row("normals", yes_or_no(mesh.normals.is_some()));
    if mesh.parts.len() > 1 {
        row("parts", parts(sequence));
    }
    if !mesh.materials.is_empty() {
        row("materials", shortened(mesh.materials.iter().map(|material| material.name.clone()).collect()));
    }
    if !sequence.poses.is_empty() {
        let names = shortened(sequence.poses.iter().map(|pose| pose.name.clone()).collect());
        row("poses", format!("{}: {names}", sequence.poses.len()));
    }
    if !sequence.animations.is_empty() {
        row("animations", shortened(sequence.animations.iter().map(animation).collect()));
    }
    let defects = defects(s);
    row("defects", if defects.is_empty() { "none found".into() } else { defects.join("\n") });
    let mut text = title.to_owned() + &pairs(&rows);
    for warning in &sequence.warnings {
        text += &format!("warning: {warning}\n");
    }
    text
}

fn yes_or_no(value: bool) -> String {
    if value { "yes" } else { "no" }.into()
}

/// An animation in words: its name, its duration, and what it moves.
fn animation(animation: &Animation) -> String {
    format!("{} ({}, {})", animation.name, seconds(animation.seconds), animation.channels.join(", "))
}

/// The number of polygons, by their corners, and of the triangles that they are cut into.
fn polygons(s: &Statistics) -> String {
    let kinds = ["triangles", "quads", "with more corners"];
    let by_kind: Vec<_> = s
        .triangles_quads_ngons
        .iter()
        .zip(kinds)
        .filter(|(count, _)| **count > 0)
        .map(|(count, kind)| format!("{} {kind}", thousands(*count)))
        .collect();
    let cut = if s.triangles == s.polygons {
        String::new()
    } else {
        format!("; {} triangles when cut", thousands(s.triangles))
    };
    format!("{}: {}{cut}", thousands(s.polygons), by_kind.join(", "))
}

/// The number of components and their sizes in vertices, the largest first.
fn components(sizes: &[usize]) -> String {
    let mut sorted = sizes.to_vec();
    sorted.sort_unstable_by(|a, b| b.cmp(a));
    match &sorted[..] {
        [] => "none".into(),
        [_] => "1".into(),
        _ => {
            let sizes: Vec<_> = sorted.iter().map(|size| thousands(*size)).collect();
            format!("{}, of {} vertices", sizes.len(), shortened(sizes))
        }
    }
}

/// The number of parts, and their names with their polygons.
fn parts(sequence: &MeshSequence) -> String {
    let name = |part: &Part| {
        let names: Vec<_> = part.object.iter().chain(&part.groups).chain(&part.material).cloned().collect();
        format!(
            "{} ({})",
            if names.is_empty() { "unnamed".into() } else { names.join("/") },
            thousands(part.polygons.len())
        )
    };
    let parts = &sequence.rest.parts;
    format!("{}: {}", parts.len(), shortened(parts.iter().map(name).collect()))
}

/// The defects of a mesh, a line each.
fn defects(s: &Statistics) -> Vec<String> {
    let non_manifold = "edge of more than two triangles";
    [
        (s.inward_components.len(), "component inside out", "components inside out"),
        (s.non_manifold_edges, non_manifold, "edges of more than two triangles (non-manifold)"),
        (s.degenerate_triangles, "triangle without area", "triangles without area"),
        (s.duplicate_polygons, "duplicate polygon", "duplicate polygons"),
        (s.unreferenced_vertices, "vertex that no polygon uses", "vertices that no polygon uses"),
        (s.coincident_vertices, "vertex at the place of another", "vertices at the place of another"),
    ]
    .into_iter()
    .filter(|(found, ..)| *found > 0)
    .map(|(found, one, many)| count(found, one, many))
    .collect()
}

/// The first names, and the number of the others.
fn shortened(names: Vec<String>) -> String {
    const MAX_SHOWN: usize = 12;
    let more = names.len().saturating_sub(MAX_SHOWN);
    let shown = names[..names.len() - more].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// The probable unit of a mesh with this diagonal, if it is a person, a face or an animal.
fn unit(diagonal: f64) -> &'static str {
    match diagonal {
        d if d.is_nan() || d <= 0.0 => "no size",
        d if d < 0.05 => "the unit is unlike any usual one for a body or face",
        d if d < 6.0 => "metres, if it is a body",
        d if d < 50.0 => "decimetres if it is a body, centimetres if a face",
        d if d < 600.0 => "centimetres, if it is a body",
        d if d < 6000.0 => "millimetres, if it is a body",
        _ => "the unit is unlike any usual one for a body or face",
    }
}
