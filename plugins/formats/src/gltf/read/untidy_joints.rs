//! What of nodes and skins is read though it is not as glTF wants it.

use std::collections::HashSet;

use gltf::json::{accessor::ComponentType, mesh::Semantic, validation::Checked};

use super::{
    asset::Asset,
    evaluator::Run,
    nodes::{Local, Nodes, name},
    primitive::attribute,
    scene::Placed,
    skin::is_affine,
    told::Told,
};

/// Rotations whose length is that near to 1 are those of 32-bit numbers, or of 8 bits.
const MAX_UNEVEN: f64 = 0.02;

/// The sentences about transforms, and about joints and weights.
pub fn warnings(asset: &Asset, nodes: &Nodes, placed: &[Placed], runs: &[Run], told: &mut Told) {
    let root = &asset.root;
    let named = |node: usize| name(asset, node).trim_start_matches("node ").trim_matches('`').to_owned();
    let all =
        |is_wrong: &dyn Fn(usize) -> bool| (0..root.nodes.len()).filter(|&node| is_wrong(node)).map(named).collect();
    let is_uneven = |node: usize| {
        matches!(nodes.locals[node], Local::Parts { rotation, .. } if {
            let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
            length > 0.0 && (length - 1.0).abs() > MAX_UNEVEN
        })
    };
    told.tell("nodes whose rotation is no unit quaternion are rotated by its direction", all(&is_uneven));
    let is_projective = |node: usize| matches!(&nodes.locals[node], Local::Matrix(matrix) if !is_affine(matrix));
    told.tell("nodes whose matrix ends in another row than 0 0 0 1, which is left out", all(&is_projective));
    let has_both = |node: usize| {
        let json = &asset.json["nodes"][node];
        !json["matrix"].is_null() && ["translation", "rotation", "scale"].iter().any(|key| !json[key].is_null())
    };
    told.tell("nodes with a matrix beside translation, rotation or scale, of which the matrix counts", all(&has_both));
    skins(asset, nodes, runs, told);

    let has = |placed: &Placed, semantic: fn(u32) -> Semantic, set: u32| {
        let primitives = &root.meshes[placed.mesh].primitives;
        placed.primitives.iter().any(|&index| attribute(&primitives[index], semantic(set)).is_some())
    };
    let is_halved =
        |placed: &&Placed| (0..8).any(|set| has(placed, Semantic::Joints, set) != has(placed, Semantic::Weights, set));
    let names = |wrong: Vec<&Placed>| wrong.into_iter().map(|placed| placed.name.clone()).collect::<Vec<_>>();
    told.tell(
        "meshes with joints without weights, or weights without joints, which are left out",
        names(placed.iter().filter(is_halved).collect()),
    );
    let skinned: HashSet<usize> =
        root.nodes.iter().filter(|node| node.skin.is_some()).filter_map(|node| Some(node.mesh?.value())).collect();
    let lacks_skin = |placed: &&Placed| has(placed, Semantic::Joints, 0) && !skinned.contains(&placed.mesh);
    told.tell(
        "meshes with joints and weights that no node gives a skin are moved by their nodes",
        names(placed.iter().filter(lacks_skin).collect()),
    );
    let lacks_joints = |placed: &&Placed| root.nodes[placed.node].skin.is_some() && !has(placed, Semantic::Joints, 0);
    told.tell(
        "meshes with a skin, but without joints and weights, are moved by their nodes",
        names(placed.iter().filter(lacks_joints).collect()),
    );
    let has_floats = |placed: &&Placed| {
        let primitives = &root.meshes[placed.mesh].primitives;
        let mut accessors =
            placed.primitives.iter().filter_map(|&index| attribute(&primitives[index], Semantic::Joints(0)));
        accessors.any(|index| {
            let kind = root.accessors.get(index.value()).map(|accessor| accessor.component_type);
            matches!(kind, Some(Checked::Valid(kind)) if kind.0 == ComponentType::F32)
        })
    };
    told.tell(
        "meshes whose joints are floats, which glTF does not allow",
        names(placed.iter().filter(has_floats).collect()),
    );
}

fn skins(asset: &Asset, nodes: &Nodes, runs: &[Run], told: &mut Told) {
    let named = |node: usize| name(asset, node).trim_start_matches("node ").trim_matches('`').to_owned();
    let worlds = nodes.worlds(&nodes.locals);
    let (mut flat, mut projective, mut twice) = (Vec::new(), Vec::new(), Vec::new());
    let mut seen = HashSet::new();
    for (skin, _) in runs.iter().filter_map(|run| run.skin.as_ref()) {
        if !seen.insert(std::sync::Arc::as_ptr(skin)) {
            continue;
        }
        let mut joints = HashSet::new();
        for &joint in &skin.joints {
            if worlds[joint].fixed_view::<3, 3>(0, 0).determinant() == 0.0 {
                flat.push(named(joint));
            }
            if !joints.insert(joint) {
                twice.push(named(joint));
            }
        }
        projective.extend(skin.projective().map(named));
    }
    told.tell("joints that flatten what they move, with a scale of 0", flat);
    told.tell("joints that stand twice in one skin", twice);
    told.tell("joints whose inverse bind matrix ends in another row than 0 0 0 1, which is left out", projective);
}
