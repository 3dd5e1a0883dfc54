//! Morph targets: their names, and which of them are one pose.

use gltf::json::Mesh;
use serde_json::Value;

use super::{asset::Asset, scene::Placed};

/// The displacements of a morph target, of those vertices that it moves.
#[derive(Debug, Default)]
pub struct Moves {
    /// The vertices, from the first of their run.
    pub vertices: Vec<u32>,
    /// The displacement of each at weight 1.
    pub displacements: Vec<[f64; 3]>,
}

impl Moves {
    /// The displacements that are not 0.
    pub fn new(all: &[[f64; 3]]) -> Self {
        let moved = all.iter().enumerate().filter(|(_, displacement)| **displacement != [0.0; 3]);
        let (vertices, displacements) = moved.map(|(vertex, displacement)| (vertex as u32, displacement)).unzip();
        Self { vertices, displacements }
    }
}

/// The name of a morph target.
#[derive(Clone, Debug, PartialEq)]
pub enum Name {
    /// The file gives it; targets of one given name are one pose, on whatever meshes they are.
    Given(String),
    /// Target of this number of the mesh of this number.
    Numbered { mesh: usize, target: usize },
}

/// The names of the morph targets of a mesh: in `extras` of the mesh, else of a primitive, else of the accessors.
///
/// A name that an earlier target of the mesh has is told apart by the number.
pub fn names(asset: &Asset, mesh_index: usize, mesh: &Mesh) -> Vec<Name> {
    let json = &asset.json["meshes"][mesh_index];
    let primitives = json["primitives"].as_array().into_iter().flatten();
    let lists = std::iter::once(json).chain(primitives).filter_map(|object| object["extras"]["targetNames"].as_array());
    let lists: Vec<&Vec<Value>> = lists.collect();
    let count = mesh.primitives.iter().map(|primitive| primitive.targets.iter().flatten().count()).max().unwrap_or(0);
    let mut names: Vec<Name> = Vec::new();
    for target in 0..count {
        let of_lists = lists.iter().find_map(|list| list.get(target)?.as_str().filter(|name| !name.is_empty()));
        let given = of_lists.or_else(|| accessor_name(asset, mesh, target));
        let name = given.map_or(Name::Numbered { mesh: mesh_index, target }, |given| Name::Given(given.to_owned()));
        let name = match name {
            Name::Given(given) if names.contains(&Name::Given(given.clone())) => {
                Name::Given(format!("{given}-{target}"))
            }
            other => other,
        };
        names.push(name);
    }
    names
}

fn accessor_name<'a>(asset: &'a Asset, mesh: &Mesh, target: usize) -> Option<&'a str> {
    let accessors = mesh.primitives.iter().filter_map(|primitive| primitive.targets.as_ref()?.get(target)?.positions);
    let names = accessors.filter_map(|index| asset.root.accessors.get(index.value())?.name.as_deref());
    names.into_iter().find(|name| !name.is_empty())
}

/// A pose that consists of morph targets at weight 1.
#[derive(Debug)]
pub struct Shape {
    name: Name,
    /// Runs of vertices and targets of these, by number.
    pub targets: Vec<(usize, usize)>,
}

/// Adds target `target` of run `run`, called `name`, to the shape of that name.
pub fn add(shapes: &mut Vec<Shape>, name: &Name, run: usize, target: usize) {
    match shapes.iter_mut().find(|shape| shape.name == *name) {
        Some(shape) => shape.targets.push((run, target)),
        None => shapes.push(Shape { name: name.clone(), targets: vec![(run, target)] }),
    }
}

/// The names of shapes, each once.
///
/// Targets without names are `target-0` and so on, after the name of their mesh if several meshes have such.
pub fn unique_names(shapes: &[Shape], placed: &[Placed]) -> Vec<String> {
    let mesh_of = |shape: &Shape| match shape.name {
        Name::Numbered { mesh, .. } => Some(mesh),
        Name::Given(_) => None,
    };
    let first = shapes.iter().find_map(mesh_of);
    let has_several = shapes.iter().filter_map(mesh_of).any(|mesh| Some(mesh) != first);
    let name = |shape: &Shape| match &shape.name {
        Name::Given(given) => given.clone(),
        Name::Numbered { target, .. } if !has_several => format!("target-{target}"),
        Name::Numbered { mesh, target } => {
            let of_mesh = placed.iter().find(|placed| placed.mesh == *mesh).map_or("mesh", |placed| &placed.name);
            format!("{of_mesh}-target-{target}")
        }
    };
    distinct(shapes.iter().map(name))
}

/// Names as they are; one that an earlier entry has gets the first number that makes it new.
pub fn distinct(names: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut seen = std::collections::HashSet::new();
    let mut unique = Vec::new();
    for (index, name) in names.into_iter().enumerate() {
        let mut candidate = name.clone();
        let mut number = index;
        while !seen.insert(candidate.clone()) {
            candidate = format!("{name}-{number}");
            number += 1;
        }
        unique.push(candidate);
    }
    unique
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_made_distinct() {
        let names = ["a", "b", "a", "a-2", "a"].map(str::to_owned);
        assert_eq!(distinct(names), ["a", "b", "a-2", "a-2-3", "a-4"]);
    }

    #[test]
    fn still_vertices_take_no_room() {
        let moves = Moves::new(&[[0.0; 3], [0.0, 1.0, 0.0], [0.0; 3]]);
        assert_eq!((moves.vertices, moves.displacements), (vec![1], vec![[0.0, 1.0, 0.0]]));
    }
}
