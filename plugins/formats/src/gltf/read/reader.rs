use std::{collections::BTreeSet, sync::Arc};

use mimesh_core::{
    Error, Result,
    mesh::{Document, MeshSequence, Pose, Positions},
    stage::{FileInput, Selection},
};
use serde_json::Value;

use super::{
    asset::{Asset, DAMAGED},
    builder::{Builder, Piece, assemble},
    clips::{self, Weights},
    evaluator::{Evaluator, Run},
    extensions, morphs,
    nodes::Nodes,
    poses::{self, NamedShape},
    scene::{self, Placed},
    told::Told,
    untidy, untidy_data, untidy_joints,
};
use crate::{
    gltf::document::{GltfDocument, Placement, RestingNode, Transforms},
    names::quoted,
};

/// The way out where a file has no part of a name.
const CHOOSE: &str = "name parts that the file has, by their nodes, meshes or materials";

/// The nodes that are placed for checks of poses; a few seconds.
const MAX_CHECKED: usize = 1 << 24;

/// The way out where a file has no shape of a name.
const CHOOSE_SHAPE: &str = "`mimesh inspect` lists the morph targets and clips of a file";

/// Reads the chosen meshes of the default scene as one, in place, and the chosen poses.
///
/// # Errors
///
/// The errors of [`Asset::read`], and [`Error::File`] that names the mesh, node, clip or accessor that cannot be read.
pub fn read(input: &dyn FileInput, selection: &Selection) -> Result<MeshSequence> {
    let path = input.path();
    let damaged = |message: String| Error::file(path, message, DAMAGED);
    let unknown = |message: String| Error::file(path, message, CHOOSE_SHAPE);

    let mut asset = Asset::read(input)?;
    let nodes = Nodes::new(&asset).map_err(damaged)?;
    let mut placed = scene::placed(&asset).map_err(damaged)?;
    scene::choose(&asset, &mut placed, &selection.meshes).map_err(|message| Error::file(path, message, CHOOSE))?;
    let thin = scene::drop_thin(&asset, &mut placed);
    let needed: BTreeSet<(usize, usize)> =
        placed.iter().flat_map(|placed| placed.primitives.iter().map(|&primitive| (placed.mesh, primitive))).collect();
    asset.unpack(input, &|mesh, primitive| needed.contains(&(mesh, primitive)))?;

    let mut builder = Builder::new(&asset);
    for placed in &placed {
        builder.add(placed).map_err(damaged)?;
    }
    let Builder { runs, pieces, shapes, .. } = builder;
    let shapes = shapes.all;
    let names = morphs::unique_names(&shapes, &placed);
    let shapes: Vec<_> =
        shapes.into_iter().zip(names).map(|(shape, name)| NamedShape { name, targets: shape.targets }).collect();
    let weights = stored_weights(&asset);
    warn(&mut asset, &placed, &weights, &thin);
    let mut told = Told::default();
    untidy::warnings(&asset, &nodes, &placed, &runs, &mut told);
    untidy_data::warnings(&asset, &placed, &mut told);
    untidy_joints::warnings(&asset, &nodes, &placed, &runs, &mut told);
    asset.warnings.extend(told.sentences);
    let clips = clips::read(&mut asset);
    let animations = clips::list(&asset, &clips);

    let mut warnings = std::mem::take(&mut asset.warnings);
    let rest = poses::rest(&selection.rest, &shapes, &clips, &mut warnings).map_err(unknown)?;
    let mut evaluator = Evaluator { nodes, weights, clips, runs, poses: Vec::new() };
    let chosen = poses::choose(&selection.poses, &rest, &shapes, &evaluator, &mut warnings).map_err(unknown)?;
    let of_clips = chosen.iter().map(|pose| &pose.shape).filter(|shape| shape.clip.is_some());
    // Of more poses than can be looked at here, the others are checked when they are asked for.
    let most = MAX_CHECKED / evaluator.nodes.locals.len().max(1);
    for shape in [&rest].into_iter().chain(of_clips.take(most.max(1))) {
        evaluator.check(&asset, shape).map_err(damaged)?;
    }
    evaluator.poses = chosen.iter().map(|pose| pose.shape.clone()).collect();

    let transforms = evaluator.transforms(&rest);
    let mut mesh = assemble(&asset, &pieces, &transforms, &evaluator.morphed(&rest), &mut warnings);
    mesh.positions = evaluator.shape(&rest);
    if let Some(colors) = &mut mesh.vertex_colors {
        colors.resize(mesh.positions.len(), [1.0; 4]);
    }
    match mesh.validate() {
        Err(Error::Data { message, hint }) => return Err(Error::file(path, message, hint)),
        other => other?,
    }
    asset.warnings = warnings;
    if selection.keep_document {
        let images = asset.read_images(input);
        let resting = evaluator.moved_nodes(&rest);
        mesh.document = Document::new(document(&mut asset, images, &evaluator, &pieces, transforms, resting));
    }
    let evaluator = Arc::new(evaluator);
    let pose = |(index, pose): (usize, poses::Chosen)| Pose {
        name: pose.name,
        time: pose.time,
        positions: Positions::Computed(evaluator.clone(), index),
    };
    let poses = chosen.into_iter().enumerate().map(pose).collect();
    Ok(MeshSequence { rest: mesh, poses, animations, warnings: asset.warnings, ..MeshSequence::default() })
}

/// The weights of morph targets that the file stores for each node: its own, else those of its mesh.
fn stored_weights(asset: &Asset) -> Vec<Weights> {
    let numbers = |weights: &Value| -> Weights {
        weights.as_array().into_iter().flatten().map(|weight| weight.as_f64().unwrap_or(0.0)).collect()
    };
    let of_meshes: Vec<Weights> =
        (0..asset.root.meshes.len()).map(|mesh| numbers(&asset.json["meshes"][mesh]["weights"])).collect();
    let none = Weights::default();
    let of_node = |(index, node): (usize, &gltf::json::Node)| {
        let own = &asset.json["nodes"][index]["weights"];
        let mesh = node.mesh.and_then(|mesh| of_meshes.get(mesh.value()));
        if own.is_array() { numbers(own) } else { mesh.unwrap_or(&none).clone() }
    };
    asset.root.nodes.iter().enumerate().map(of_node).collect()
}

/// Warns of what the rest or the mesh leaves out.
fn warn(asset: &mut Asset, placed: &[Placed], weights: &[Weights], thin: &[String]) {
    let is_shaped = |placed: &&Placed| weights[placed.node].iter().any(|&weight| weight != 0.0);
    let shaped: Vec<_> = placed.iter().filter(is_shaped).map(|placed| &placed.name).collect();
    if !shaped.is_empty() {
        let names = quoted(&shaped);
        asset.warnings.push(format!("the rest pose has all morph targets at 0, unlike the file's default: {names}"));
    }
    if !thin.is_empty() {
        asset.warnings.push(format!("primitives of points or lines were left out: {}", quoted(thin)));
    }
    asset.warnings.extend(extensions::unread_of_nodes(asset));
}

/// The file as it is, for a writer.
fn document(
    asset: &mut Asset,
    images: Vec<(usize, Arc<Vec<u8>>)>,
    evaluator: &Evaluator,
    pieces: &[Piece],
    transforms: Vec<Transforms>,
    resting: Vec<RestingNode>,
) -> GltfDocument {
    let mut primitives = vec![Vec::new(); evaluator.runs.len()];
    pieces.iter().for_each(|piece| primitives[piece.run].push(piece.primitive));
    let placement = |((run, scene_from_stored), primitives): ((&Run, Transforms), Vec<usize>)| Placement {
        node: run.node,
        mesh: run.mesh,
        primitives,
        vertices: run.vertices.clone(),
        stored: run.stored.clone(),
        scene_from_stored,
    };
    let placements = evaluator.runs.iter().zip(transforms).zip(primitives).map(placement);
    let mut buffers = std::mem::take(&mut asset.buffers);
    for (buffer, described) in buffers.iter_mut().zip(&asset.root.buffers).filter(|(buffer, _)| !buffer.is_empty()) {
        // Padding that the file counts but does not hold.
        buffer.padding = (described.byte_length.0 as usize).saturating_sub(buffer.length);
    }
    GltfDocument {
        json: std::mem::take(&mut asset.json),
        buffers,
        images,
        decompressed: std::mem::take(&mut asset.decompressed),
        unpacked: std::mem::take(&mut asset.unpacked),
        placements: placements.collect(),
        resting,
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::data::{data, input};
    use nalgebra::{Matrix4, Point3};

    use super::*;

    #[test]
    fn placements_lead_from_the_stored_vertices_to_the_mesh() {
        let Some(path) = data("robot/RobotExpressive.glb") else { return };
        let keep = Selection { keep_document: true, ..Selection::default() };
        let mesh = read(&input(path), &keep).unwrap().rest;
        let document: &GltfDocument = mesh.document.get().unwrap();
        let mut next = 0;
        for placement in &document.placements {
            assert_eq!(placement.vertices.start, next);
            assert!(!placement.primitives.is_empty());
            next = placement.vertices.end;
            let placed = |vertex: usize, stored: &Point3<f64>| {
                let matrix: &Matrix4<f64> = match &placement.scene_from_stored {
                    Transforms::Uniform(matrix) => matrix,
                    Transforms::Skinned(matrices) => &matrices[vertex],
                };
                matrix.transform_point(stored)
            };
            let positions = &mesh.positions[placement.vertices.clone()];
            for (vertex, (stored, position)) in placement.stored.iter().zip(positions).enumerate() {
                // The same sums; one program adds the last row too.
                assert!((placed(vertex, stored) - position).norm() < 1e-12);
            }
        }
        assert_eq!(next, mesh.positions.len());
        assert!(document.placements.iter().any(|placed| matches!(placed.scene_from_stored, Transforms::Skinned(_))));
    }
}
