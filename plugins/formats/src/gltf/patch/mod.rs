//! A glTF given back as it was, with morph targets and animations added.
//!
//! The JSON of the file is copied and only what the new targets need is changed: [`meshes`] has the targets, [`names`] their
//! names, [`clips`] the animations of weights. [`buffers`] brings all bytes into one buffer, of which the file's own first
//! one is the start, so that views and accessors of the file keep their numbers and places.

mod buffers;
mod clips;
mod layout;
mod meshes;
mod names;
mod place;
mod stored;

use std::{collections::HashMap, io::Write};

use mimesh_core::{
    Error,
    mesh::{ClipTime, Mesh, check_finite},
    stage::{SequenceWriter, WriteError},
};
use nalgebra::Point3;
use serde_json::Value;

use super::{binary::Binary, document::GltfDocument, options::Options, output, pose_clips::PoseList};
use crate::normals::PosedNormals;
use layout::{Shown, describes, mesh_name, shown};
use meshes::{NewTargets, Target, Zeros};
use names::NewNames;
use place::{CornersAt, Place};

/// A copy of a mesh's glTF in the making, to which poses are added as morph targets.
pub struct PatchWriter {
    options: Options,
    mesh: Mesh,
    json: Value,
    binary: Binary,
    places: Vec<Place>,
    normals: Option<PosedNormals>,
    /// One a placement, one a pose.
    targets: Vec<Vec<Target>>,
    zeros: Zeros,
    names: NewNames,
    poses: PoseList,
    warnings: Vec<String>,
}

/// The glTF from which `mesh` was read, if its vertices are still those of the file.
pub fn document(mesh: &Mesh) -> Option<&GltfDocument> {
    mesh.document.get::<GltfDocument>().filter(|document| describes(document, mesh))
}

impl PatchWriter {
    /// Starts with the glTF from which `mesh` was read; `None` if there is none, or the vertices are not its own any more.
    ///
    /// # Errors
    ///
    /// If the mesh is damaged, or there is no room for temporary data.
    pub fn new(options: Options, mesh: &Mesh) -> Result<Option<Self>, WriteError> {
        mesh.validate()?;
        let Some(document) = document(mesh) else { return Ok(None) };
        let mut json = document.json.clone();
        let mut warnings = Vec::new();
        let binary = buffers::gather(document, &mut json, &mut warnings)?;
        let normals = options.pose_normals.then(|| (PosedNormals::new(mesh, &mesh.positions), CornersAt::new(mesh)));
        let place =
            |placement| Place::new(document, placement, normals.as_ref().map(|(normals, corners)| (normals, corners)));
        let places: Vec<_> = document.placements.iter().map(place).collect();
        let taken = shown(document).into_iter().flat_map(|shown| names::existing(&document.json, shown.mesh));
        Ok(Some(Self {
            options,
            json,
            binary,
            normals: normals.map(|(normals, _)| normals),
            targets: vec![Vec::new(); places.len()],
            places,
            zeros: Zeros::default(),
            names: NewNames::new(taken),
            poses: PoseList::default(),
            warnings,
            mesh: mesh.clone(),
        }))
    }

    fn new_targets<'a>(&'a self, document: &'a GltfDocument) -> NewTargets<'a> {
        NewTargets { document, targets: &self.targets, names: &self.poses.names }
    }
}

impl SequenceWriter for PatchWriter {
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", self.mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        let Some(document) = document(&self.mesh) else { unreachable!("the writer was made for a document") };
        let normals = self.normals.as_ref().map(|normals| (normals.rest(), normals.of_groups(&self.mesh, positions)));
        let mut all_moves: Vec<Vec<[f32; 3]>> = Vec::new();
        for (index, placement) in document.placements.iter().enumerate() {
            let range = placement.vertices.clone();
            let place = &mut self.places[index];
            let moves = place.displacements(&self.mesh.positions[range.clone()], &positions[range]);
            let twin = document.placements[..index].iter().zip(&all_moves).position(|(other, other_moves)| {
                (other.mesh, &other.primitives) == (placement.mesh, &placement.primitives)
                    && equal_in_file(&moves, other_moves, placement)
            });
            let target = match twin {
                Some(twin) => self.targets[twin].last().expect("it was added just now").clone(),
                None => {
                    let turns = |(rest, posed): &(&[[f64; 3]], Vec<[f64; 3]>)| -> Vec<Vec<[f32; 3]>> {
                        place
                            .normals
                            .iter()
                            .map(|n| place.turns(n, &placement.scene_from_stored, rest, posed))
                            .collect()
                    };
                    let turns = normals.as_ref().map(turns).unwrap_or_default();
                    let mut accessor = |values: &[[f32; 3]], bounds| {
                        if values.iter().all(|value| *value == [0.0; 3]) {
                            return Ok(self.zeros.get(&mut self.binary, values.len()));
                        }
                        self.binary.displacements(values, bounds)
                    };
                    let position = accessor(&moves, true)?;
                    let turns = turns.iter().map(|turns| accessor(turns, false)).collect::<Result<Vec<_>, _>>()?;
                    Target { position, normals: place.normals_of.iter().map(|entry| entry.map(|n| turns[n])).collect() }
                }
            };
            self.targets[index].push(target);
            all_moves.push(moves);
        }
        let name = self.names.add(name);
        self.poses.names.push(name);
        self.poses.times.push(time.cloned());
        Ok(())
    }

    fn warnings(&self) -> Vec<String> {
        let Some(document) = document(&self.mesh) else { return Vec::new() };
        let mut warnings = self.warnings.clone();
        warnings.extend(self.names.warning());
        warnings.extend(self.new_targets(document).warnings(&shown(document)));
        for shown in shown(document) {
            let stuck =
                shown.placements.iter().flat_map(|&place| &self.places[place].stuck).filter(|stuck| **stuck).count();
            if stuck > 0 {
                let name = mesh_name(&document.json, shown.mesh);
                warnings.push(format!(
                    "{stuck} vertices of `{name}` do not move, since joints or nodes flatten the space they are stored in"
                ));
            }
        }
        warnings.extend(self.poses.warnings(self.options.animation));
        warnings
    }

    fn finish(mut self: Box<Self>, out: &mut dyn Write) -> Result<(), WriteError> {
        let Some(document) = document(&self.mesh) else { unreachable!("the writer was made for a document") };
        if !self.poses.names.is_empty() {
            let nodes: Vec<Shown> = shown(document);
            let new = NewTargets { document, targets: &self.targets, names: &self.poses.names };
            new.apply(&nodes, &mut self.json, &mut self.binary, &mut self.zeros);
            let totals: HashMap<usize, usize> = new.meshes(&nodes, &self.json).collect();
            clips::lengthen(document, &mut self.json, &mut self.binary, &totals)?;
            let clips = self.poses.clips(self.options.animation, self.options.frames_per_second);
            clips::add(&mut self.json, &mut self.binary, clips, &nodes, &totals, self.poses.names.len())?;
        }
        buffers::settle(&mut self.json, &mut self.binary);
        output::write(self.json, self.binary, self.options.binary, out)
    }
}

/// Whether displacements differ by no more than the rounding of the stored positions.
///
/// Nodes that show one mesh have different transforms, whose rounding must not make them differ.
fn equal_in_file(a: &[[f32; 3]], b: &[[f32; 3]], placement: &super::document::Placement) -> bool {
    if a == b {
        return true;
    }
    let size = placement.stored.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let bound = (f64::from(f32::EPSILON) * size) as f32;
    a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= bound)
}
