//! The accessors of new morph targets, pose by pose.

use std::{collections::HashMap, io};

use mimesh_core::mesh::Mesh;
use nalgebra::Point3;

use super::{
    layout::Shown,
    meshes::{Target, Zeros},
    place::{CornersAt, Place},
};
use crate::{
    gltf::{
        document::{GltfDocument, Placement},
        write::binary::Binary,
    },
    normals::PosedNormals,
};

/// The new morph targets of the placements of a document.
#[derive(Debug)]
pub struct Morphs {
    places: Vec<Place>,
    normals: Option<PosedNormals>,
    /// For each placement a number that those of the same primitives share.
    sources: Vec<usize>,
    /// One a placement, one a pose.
    pub targets: Vec<Vec<Target>>,
    /// The accessors of those that do not move.
    pub zeros: Zeros,
}

/// The displacements of the vertices of a placement.
type Moves = Vec<[f32; 3]>;

/// The normals of the groups of corners at rest and in a pose.
struct GroupNormals<'a> {
    rest: &'a [[f64; 3]],
    posed: Vec<[f64; 3]>,
}

impl Morphs {
    /// No targets yet for `mesh`, which `document` describes; `pose_normals` if they are to have normals.
    pub fn new(document: &GltfDocument, mesh: &Mesh, pose_normals: bool) -> Self {
        let normals = pose_normals.then(|| (PosedNormals::new(mesh, &mesh.positions), CornersAt::new(mesh)));
        let of_places = normals.as_ref().map(|(normals, corners)| (normals, corners));
        let places = document.placements.iter().map(|placement| Place::new(document, placement, mesh, of_places));
        let places: Vec<_> = places.collect();
        let mut sources = HashMap::new();
        let mut source = |placement: &Placement| {
            let next = sources.len();
            *sources.entry((placement.mesh, placement.primitives.clone())).or_insert(next)
        };
        Self {
            sources: document.placements.iter().map(&mut source).collect(),
            targets: vec![Vec::new(); places.len()],
            normals: normals.map(|(normals, _)| normals),
            places,
            zeros: Zeros::default(),
        }
    }

    /// Adds a target to each placement, which moves its vertices of `mesh` to `positions` (#V × 3).
    ///
    /// Placements of one mesh under several nodes share a target where they move alike.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn add(
        &mut self,
        document: &GltfDocument,
        mesh: &Mesh,
        positions: &[Point3<f64>],
        binary: &mut Binary,
    ) -> io::Result<()> {
        let normals = self.normals.as_ref();
        let normals = normals.map(|all| GroupNormals { rest: all.rest(), posed: all.of_groups(mesh, positions) });
        // By source the moves that differ, each with the first placement that has them.
        let mut seen: HashMap<usize, Vec<(usize, Moves)>> = HashMap::new();
        for (index, placement) in document.placements.iter().enumerate() {
            let range = placement.vertices.clone();
            let place = &mut self.places[index];
            let moves = place.displacements(&positions[range]);
            let of_source = seen.entry(self.sources[index]).or_default();
            let twin = of_source.iter().find(|(_, other)| equal_in_file(&moves, other, placement));
            let target = match twin {
                Some(&(twin, _)) => self.targets[twin].last().expect("it was added just now").clone(),
                None => {
                    let target = target(place, placement, &moves, normals.as_ref(), binary, &mut self.zeros)?;
                    of_source.push((index, moves));
                    target
                }
            };
            self.targets[index].push(target);
        }
        Ok(())
    }

    /// The vertices of a node that should have moved and could not.
    pub fn stuck(&self, shown: &Shown) -> usize {
        shown.placements.iter().flat_map(|&place| &self.places[place].stuck).filter(|stuck| **stuck).count()
    }
}

/// The target of a placement: `moves`, and the turns of its normals.
fn target(
    place: &Place,
    placement: &Placement,
    moves: &[[f32; 3]],
    normals: Option<&GroupNormals>,
    binary: &mut Binary,
    zeros: &mut Zeros,
) -> io::Result<Target> {
    let mut accessor = |values: &[[f32; 3]], bounds| {
        if values.iter().all(|value| *value == [0.0; 3]) {
            return Ok(zeros.get(binary, values.len()));
        }
        binary.displacements(values, bounds)
    };
    let position = accessor(moves, true)?;
    let mut turned = Vec::new();
    if let Some(GroupNormals { rest, posed }) = normals {
        for stored in &place.normals {
            turned.push(accessor(&place.turns(stored, &placement.scene_from_stored, rest, posed), false)?);
        }
    }
    Ok(Target { position, normals: place.normals_of.iter().map(|entry| entry.map(|entry| turned[entry])).collect() })
}

/// Whether displacements differ by no more than the rounding of the stored positions.
///
/// Nodes that show one mesh have different transforms, whose rounding must not make them differ.
fn equal_in_file(a: &[[f32; 3]], b: &[[f32; 3]], placement: &Placement) -> bool {
    if a == b {
        return true;
    }
    let size = placement.stored.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let bound = (f64::from(f32::EPSILON) * size) as f32;
    a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= bound)
}
