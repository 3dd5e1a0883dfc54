//! New morph targets in the JSON of meshes and nodes.

use std::collections::{BTreeSet, HashMap};

use serde_json::{Value, json};

use super::{
    layout::{Shown, mesh_name, position, target_count, vertex_count},
    names,
    stored::{list, number},
};
use crate::{
    gltf::{document::GltfDocument, write::binary::Binary},
    names::quoted,
};

/// The accessors of a new morph target for the vertices of a placement.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Displacements.
    pub position: usize,
    /// Differences of normals, one a primitive of the placement that has normals.
    pub normals: Vec<Option<usize>>,
}

/// Accessors of zeros, by their length.
#[derive(Debug, Default)]
pub struct Zeros(HashMap<usize, usize>);

impl Zeros {
    /// An accessor of `count` zero displacements.
    pub fn get(&mut self, binary: &mut Binary, count: usize) -> usize {
        *self.0.entry(count).or_insert_with(|| binary.zeros(count))
    }
}

/// The new morph targets of a file.
#[derive(Debug)]
pub struct NewTargets<'a> {
    /// The file as it was read.
    pub document: &'a GltfDocument,
    /// One a placement, one a pose.
    pub targets: &'a [Vec<Target>],
    /// One a pose.
    pub names: &'a [String],
}

impl NewTargets<'_> {
    /// Adds the targets to the meshes of `nodes` in `json`.
    ///
    /// A mesh that several nodes show with different targets is copied for all nodes but the first of these.
    pub fn apply(&self, nodes: &[Shown], json: &mut Value, binary: &mut Binary, zeros: &mut Zeros) {
        let originals = list(json, "meshes").to_vec();
        for (shown, first) in nodes.iter().zip(firsts(nodes)) {
            let original = &originals[shown.mesh];
            let mesh = match first {
                Some(first) if self.same(first, shown) => continue,
                Some(_) => {
                    let meshes = json["meshes"].as_array_mut().expect("the placements are of meshes of this list");
                    meshes.push(self.patched(shown, original, binary, zeros));
                    let copy = meshes.len() - 1;
                    json["nodes"][shown.node]["mesh"] = copy.into();
                    continue;
                }
                None => self.patched(shown, original, binary, zeros),
            };
            json["meshes"][shown.mesh] = mesh;
        }
        let totals: HashMap<usize, usize> = self.meshes(nodes, json).collect();
        for node in json["nodes"].as_array_mut().into_iter().flatten() {
            if let Some(total) = number(node, "mesh").and_then(|mesh| totals.get(&mesh)) {
                lengthen(node, *total);
            }
        }
    }

    /// The meshes that have the new targets in `json`, and the number of all targets of each.
    pub fn meshes(&self, nodes: &[Shown], json: &Value) -> impl Iterator<Item = (usize, usize)> {
        let total = |shown: &Shown| {
            let existing = target_count(&list(&self.document.json, "meshes")[shown.mesh]);
            let node = &list(json, "nodes")[shown.node];
            (number(node, "mesh").unwrap_or(shown.mesh), existing + self.names.len())
        };
        nodes.iter().map(total).collect::<Vec<_>>().into_iter()
    }

    /// Sentences about meshes that are copied, and about those that have no room for names.
    pub fn warnings(&self, nodes: &[Shown]) -> Vec<String> {
        let json = &self.document.json;
        let name = |shown: &Shown| mesh_name(json, shown.mesh);
        let copied = nodes.iter().zip(firsts(nodes));
        let copied = copied.filter(|(shown, first)| first.is_some_and(|first| !self.same(first, shown)));
        let copied: BTreeSet<_> = copied.map(|(shown, _)| name(shown)).collect();
        let copied: Vec<_> = copied.into_iter().collect();
        let extras = |shown: &Shown| list(json, "meshes")[shown.mesh].get("extras");
        let taken = nodes.iter().filter(|shown| extras(shown).is_some_and(|e| !e.is_null() && !e.is_object()));
        let taken: Vec<_> = taken.map(name).collect();
        let mut warnings = Vec::new();
        if !copied.is_empty() {
            let why = "meshes that several nodes show are copied, since they move differently";
            warnings.push(format!("{why}: {}", quoted(&copied)));
        }
        if !taken.is_empty() {
            let why = "morph targets have no names, since the extras of their meshes are no object";
            warnings.push(format!("{why}: {}", quoted(&taken)));
        }
        warnings
    }

    /// Whether the mesh of two nodes moves alike.
    fn same(&self, a: &Shown, b: &Shown) -> bool {
        a.placements.len() == b.placements.len()
            && a.placements.iter().zip(&b.placements).all(|(&a, &b)| {
                self.document.placements[a].primitives == self.document.placements[b].primitives
                    && self.targets[a] == self.targets[b]
            })
    }

    /// The mesh of a node, `original`, with its new targets.
    fn patched(&self, shown: &Shown, original: &Value, binary: &mut Binary, zeros: &mut Zeros) -> Value {
        let mut mesh = original.clone();
        let existing = target_count(&mesh);
        let mut all = names::existing(&self.document.json, shown.mesh);
        for index in 0..list(&mesh, "primitives").len() {
            let primitive = &list(&mesh, "primitives")[index];
            let Some(count) = vertex_count(&self.document.json, primitive) else { continue };
            let mut targets = list(primitive, "targets").to_vec();
            targets.resize_with(existing, || json!({ "POSITION": zeros.get(binary, count) }));
            for pose in 0..self.names.len() {
                let target = self.target(shown, index, primitive, pose);
                targets.push(target.unwrap_or_else(|| json!({ "POSITION": zeros.get(binary, count) })));
            }
            mesh["primitives"][index]["targets"] = targets.into();
        }
        all.extend(self.names.iter().cloned());
        names::put(&mut mesh, &all);
        lengthen(&mut mesh, all.len());
        mesh
    }

    /// The new target of a primitive; `None` if it stays.
    fn target(&self, shown: &Shown, index: usize, primitive: &Value, pose: usize) -> Option<Value> {
        for &place in &shown.placements {
            let placement = &self.document.placements[place];
            let target = &self.targets[place][pose];
            if let Some(at) = placement.primitives.iter().position(|&other| other == index) {
                let mut json = json!({ "POSITION": target.position });
                if let Some(normal) = target.normals.get(at).copied().flatten() {
                    json["NORMAL"] = normal.into();
                }
                return Some(json);
            }
            // Points and lines are not read, but those on the vertices of triangles go with them.
            let is_drawn_on = |other: &usize| {
                let mesh = &list(&self.document.json, "meshes")[shown.mesh];
                position(&list(mesh, "primitives")[*other]) == position(primitive)
            };
            let has_area = number(primitive, "mode").is_none_or(|mode| mode > 3);
            if !has_area && placement.primitives.iter().any(is_drawn_on) {
                return Some(json!({ "POSITION": target.position }));
            }
        }
        None
    }
}

/// For each node the first one before it that shows the same mesh.
fn firsts(nodes: &[Shown]) -> Vec<Option<&Shown>> {
    let mut of_mesh = HashMap::new();
    let mut first =
        |shown: &Shown, index: usize| Some(*of_mesh.entry(shown.mesh).or_insert(index)).filter(|&i| i < index);
    nodes.iter().enumerate().map(|(index, shown)| first(shown, index).map(|i| &nodes[i])).collect()
}

/// Brings the weights of a mesh or node to one a target, if there are any.
fn lengthen(holder: &mut Value, total: usize) {
    if let Some(weights) = holder.get_mut("weights").and_then(Value::as_array_mut).filter(|weights| !weights.is_empty())
    {
        weights.resize(total, json!(0.0));
    }
}
