//! A glTF given back as it was, with morph targets and animations added.
//!
//! The JSON of the file is copied and only what the new targets need is changed: [`morphs`] computes the targets, [`meshes`]
//! enters them, [`names`] has their names, [`clips`] the animations of weights. [`buffers`] brings all bytes into one buffer, of which the file's own first
//! one is the start, so that views and accessors of the file keep their numbers and places.

mod buffers;
mod clips;
mod draco;
mod extension;
mod layout;
mod meshes;
mod morphs;
mod names;
mod place;
mod stored;

use std::collections::HashMap;

use mimesh_core::{
    Error,
    mesh::{ClipTime, Mesh, PosesAre, check_finite},
    stage::{SequenceWriter, WriteError},
};
use nalgebra::Point3;
use serde_json::Value;

use super::{binary::Binary, options::Options, output::Output, pose_clips::PoseList, room};
use crate::gltf::document::GltfDocument;
use layout::{Shown, describes, mesh_name, shown};
use meshes::NewTargets;
use morphs::Morphs;
use names::NewNames;
use stored::list;

/// A copy of a mesh's glTF in the making, to which poses are added as morph targets.
pub struct PatchWriter {
    options: Options,
    mesh: Mesh,
    json: Value,
    output: Output,
    binary: Binary,
    morphs: Morphs,
    names: NewNames,
    poses: PoseList,
    /// The most poses that will be added.
    most: usize,
    /// Bytes of `json`.
    json_length: usize,
    warnings: Vec<String>,
}

/// The glTF from which `mesh` was read, if its vertices are still those of the file.
pub fn document(mesh: &Mesh) -> Option<&GltfDocument> {
    mesh.document.get::<GltfDocument>().filter(|document| describes(document, mesh))
}

impl PatchWriter {
    /// Starts with `document`, from which `mesh` was read; at most `most` poses follow.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn new(
        options: Options,
        mesh: &Mesh,
        document: &GltfDocument,
        most: usize,
        output: Output,
        mut binary: Binary,
    ) -> Result<Self, WriteError> {
        let mut json = document.json.clone();
        let mut warnings = Vec::new();
        buffers::gather(document, &mut json, &mut binary, &mut warnings)?;
        let taken = shown(document).into_iter().flat_map(|shown| names::existing(&document.json, shown.mesh));
        Ok(Self {
            options,
            json_length: room::json_length(&json)?,
            json,
            output,
            binary,
            most,
            morphs: Morphs::new(document, mesh, options.pose_normals),
            names: NewNames::new(taken),
            poses: PoseList::default(),
            warnings,
            mesh: mesh.clone(),
        })
    }

    fn new_targets<'a>(&'a self, document: &'a GltfDocument) -> NewTargets<'a> {
        NewTargets { document, targets: &self.morphs.targets, names: &self.poses.names }
    }
}

impl SequenceWriter for PatchWriter {
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        Error::check_shape("posed vertices (#V)", self.mesh.positions.len(), positions.len())?;
        check_finite(positions)?;
        let Some(document) = document(&self.mesh) else { unreachable!("the writer was made for a document") };
        self.morphs.add(document, &self.mesh, positions, &mut self.binary)?;
        let name = self.names.add(name);
        self.poses.names.push(name);
        self.poses.times.push(time.cloned());
        if !self.binary.tail.is_full() {
            return Ok(());
        }
        let moved = shown(document);
        let primitives = |shown: &Shown| {
            list(&document.json, "meshes").get(shown.mesh).map_or(0, |mesh| list(mesh, "primitives").len())
        };
        let known = room::Known {
            names: &self.poses.names,
            poses: self.most,
            primitives: moved.iter().map(primitives).sum(),
            meshes: moved.len(),
            other: self.json_length,
        };
        Ok(room::leave(&mut self.binary, &known)?)
    }

    fn warnings(&self) -> Vec<String> {
        let Some(document) = document(&self.mesh) else { return Vec::new() };
        let mut warnings = self.warnings.clone();
        warnings.extend(self.names.warning());
        warnings.extend(self.new_targets(document).warnings(&shown(document)));
        for shown in shown(document) {
            let stuck = self.morphs.stuck(&shown);
            if stuck > 0 {
                let name = crate::names::shown(&mesh_name(&document.json, shown.mesh));
                warnings.push(format!(
                    "{stuck} vertices of `{name}` do not move, since joints or nodes flatten the space they are stored in"
                ));
            }
        }
        warnings.extend(self.poses.warnings(self.options.animation));
        warnings
    }

    fn set_poses_are(&mut self, poses: PosesAre) {
        self.poses.are = Some(poses);
    }

    fn renamed(&self) -> &[(String, String)] {
        &self.names.renamed
    }

    fn finish(mut self: Box<Self>) -> Result<(), WriteError> {
        let Some(document) = document(&self.mesh) else { unreachable!("the writer was made for a document") };
        if !self.poses.names.is_empty() {
            let nodes: Vec<Shown> = shown(document);
            let new = NewTargets { document, targets: &self.morphs.targets, names: &self.poses.names };
            new.apply(&nodes, &mut self.json, &mut self.binary, &mut self.morphs.zeros);
            let totals: HashMap<usize, usize> = new.meshes(&nodes, &self.json).collect();
            clips::lengthen(document, &mut self.json, &mut self.binary, &totals)?;
            let clips = self.poses.clips(self.options.animation, self.options.frames_per_second);
            let added = self.poses.names.len();
            clips::add(&mut self.json, &mut self.binary, clips, &nodes, &totals, added, &document.resting)?;
        }
        buffers::settle(&mut self.json, &mut self.binary);
        self.output.finish(self.json, self.binary)
    }
}
