//! Morph targets: their names, and which of them are one pose.

use std::collections::HashMap;

use gltf::json::{Accessor, Index, Mesh};
use serde_json::Value;

use super::{
    accessor::{few, numbers},
    asset::Asset,
    scene::Placed,
};
use crate::names::{all_distinct, distinct};

/// The displacements of a morph target, of those vertices that it moves.
#[derive(Debug, Default)]
pub struct Moves {
    /// The vertices, from the first of their run.
    pub vertices: Vec<u32>,
    /// The displacement of each at weight 1.
    pub displacements: Vec<[f64; 3]>,
}

impl Moves {
    /// Reads the displacements of an accessor.
    ///
    /// # Errors
    ///
    /// What is wrong with the accessor, or the vertex whose displacement is not finite.
    pub fn read(asset: &Asset, accessor: Index<Accessor>) -> Result<Self, String> {
        let moves = match few(asset, accessor)? {
            Some(few) => Self::new(few),
            None => Self::new(numbers(asset, accessor)?.into_iter().enumerate()),
        };
        match moves.displacements.iter().position(|displacement| !displacement.iter().all(|x| x.is_finite())) {
            None => Ok(moves),
            Some(entry) => {
                Err(format!("vertex {} (from 0) has a displacement that is not finite", moves.vertices[entry]))
            }
        }
    }

    /// The displacements that are not 0, of vertices by number.
    fn new(all: impl IntoIterator<Item = (usize, [f64; 3])>) -> Self {
        let moved = all.into_iter().filter(|(_, displacement)| *displacement != [0.0; 3]);
        let (vertices, displacements) = moved.map(|(vertex, displacement)| (vertex as u32, displacement)).unzip();
        Self { vertices, displacements }
    }
}

/// The name of a morph target.
#[derive(Clone, Debug, Eq, Hash, PartialEq)]
pub enum Name {
    /// The file gives it; targets of one given name are one pose, on whatever meshes they are.
    Given(String),
    /// Target of this number of the mesh of this number.
    Numbered { mesh: usize, target: usize },
}

/// The names of the morph targets of a mesh: in `extras` of the mesh, else of a primitive, else of the accessors.
///
/// A name that an earlier target of the mesh has is told apart by a number.
pub fn names(asset: &Asset, mesh_index: usize, mesh: &Mesh) -> Vec<Name> {
    let json = &asset.json["meshes"][mesh_index];
    let primitives = json["primitives"].as_array().into_iter().flatten();
    let lists = std::iter::once(json).chain(primitives).filter_map(|object| object["extras"]["targetNames"].as_array());
    let lists: Vec<&Vec<Value>> = lists.collect();
    let count = mesh.primitives.iter().map(|primitive| primitive.targets.iter().flatten().count()).max().unwrap_or(0);
    let mut given: Vec<Option<String>> = vec![None; count];
    // Primitive by primitive, since each has few of the targets that another one may have.
    for list in lists {
        for (name, listed) in given.iter_mut().zip(list).filter(|(name, _)| name.is_none()) {
            *name = listed.as_str().filter(|name| !name.is_empty()).map(str::to_owned);
        }
    }
    for targets in mesh.primitives.iter().filter_map(|primitive| primitive.targets.as_ref()) {
        for (name, target) in given.iter_mut().zip(targets).filter(|(name, _)| name.is_none()) {
            let accessor = target.positions.and_then(|index| asset.root.accessors.get(index.value()));
            *name = accessor.and_then(|accessor| accessor.name.clone()).filter(|name| !name.is_empty());
        }
    }
    let name = |(target, name): (usize, Option<String>)| match name {
        Some(name) => Name::Given(name),
        None => Name::Numbered { mesh: mesh_index, target },
    };
    distinct(given).into_iter().enumerate().map(name).collect()
}

/// A pose that consists of morph targets at weight 1.
#[derive(Debug)]
pub struct Shape {
    name: Name,
    /// Runs of vertices and targets of these, by number.
    pub targets: Vec<(usize, usize)>,
}

/// Poses that morph targets make, in the order in which their names come up.
#[derive(Debug, Default)]
pub struct Shapes {
    /// The poses.
    pub all: Vec<Shape>,
    by_name: HashMap<Name, usize>,
}

impl Shapes {
    /// Adds target `target` of run `run`, called `name`, to the shape of that name.
    pub fn add(&mut self, name: &Name, run: usize, target: usize) {
        let index = *self.by_name.entry(name.clone()).or_insert(self.all.len());
        match self.all.get_mut(index) {
            Some(shape) => shape.targets.push((run, target)),
            None => self.all.push(Shape { name: name.clone(), targets: vec![(run, target)] }),
        }
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
    let of_meshes: HashMap<usize, &str> = placed.iter().rev().map(|placed| (placed.mesh, &*placed.name)).collect();
    let name = |shape: &Shape| match &shape.name {
        Name::Given(given) => given.clone(),
        Name::Numbered { target, .. } if !has_several => format!("target-{target}"),
        Name::Numbered { mesh, target } => {
            let of_mesh = of_meshes.get(mesh).copied().unwrap_or("mesh");
            format!("{of_mesh}-target-{target}")
        }
    };
    all_distinct(shapes.iter().map(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn still_vertices_take_no_room() {
        let moves = Moves::new([(0, [0.0; 3]), (1, [0.0, 1.0, 0.0]), (2, [0.0; 3])]);
        assert_eq!((moves.vertices, moves.displacements), (vec![1], vec![[0.0, 1.0, 0.0]]));
    }
}
