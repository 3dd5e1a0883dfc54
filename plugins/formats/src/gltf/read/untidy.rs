//! What of a file is read though it is not as glTF wants it, as sentences.

use gltf::json::{accessor::ComponentType, mesh::Semantic, validation::Checked};
use serde_json::Value;

use super::{
    asset::Asset,
    evaluator::Run,
    nodes::{Local, Nodes, name},
    primitive::attribute,
    scene::Placed,
    told::Told,
};

/// The sentences about nodes, skins, buffer views and indices.
pub fn warnings(asset: &Asset, nodes: &Nodes, placed: &[Placed], runs: &[Run], told: &mut Told) {
    let root = &asset.root;
    let mut tell = |what: &str, names: Vec<String>| told.tell(what, names);
    let all = || 0..root.nodes.len();
    let named = |node: usize| name(asset, node).trim_start_matches("node ").trim_matches('`').to_owned();
    let is_still = |node: &usize| matches!(nodes.locals[*node], Local::Parts { rotation, .. } if rotation == [0.0; 4]);
    tell("nodes whose rotation has no length are not rotated", all().filter(is_still).map(named).collect());
    let lacks_skin = |node: &usize| root.nodes[*node].skin.is_some_and(|skin| skin.value() >= root.skins.len());
    tell("nodes that name a skin which the file does not have", all().filter(lacks_skin).map(named).collect());
    let views = root.buffer_views.iter().enumerate();
    let without_stride = views.filter(|(_, view)| view.byte_stride.is_some_and(|stride| stride.0 == 0));
    tell(
        "buffer views with a `byteStride` of 0 are read as without gaps",
        without_stride.map(|(view, _)| view.to_string()).collect(),
    );
    let primitives = || placed.iter().flat_map(|placed| placed.primitives.iter().map(move |index| (placed, *index)));
    let has_floats = |(placed, index): &(&Placed, usize)| {
        let indices = root.meshes[placed.mesh].primitives[*index].indices;
        let accessor = indices.and_then(|indices| root.accessors.get(indices.value()));
        let kind = accessor.map(|accessor| accessor.component_type);
        matches!(kind, Some(Checked::Valid(kind)) if kind.0 == ComponentType::F32)
    };
    tell(
        "meshes whose indices are floats, which glTF does not allow",
        primitives().filter(has_floats).map(|(placed, _)| placed.name.clone()).collect(),
    );
    let worlds = nodes.worlds(&nodes.locals);
    let is_flattened = |placed: &&Placed| {
        let has_skin = root.nodes[placed.node].skin.is_some();
        !has_skin && worlds[placed.node].fixed_view::<3, 3>(0, 0).determinant() == 0.0
    };
    tell(
        "meshes that their nodes flatten, with a scale of 0",
        placed.iter().filter(is_flattened).map(|placed| placed.name.clone()).collect(),
    );
    let is_negative = |value: &Value| value["byteOffset"].as_f64().is_some_and(|offset| offset < 0.0);
    for (list, what) in [("bufferViews", "buffer views"), ("accessors", "accessors")] {
        let all = asset.json[list].as_array().into_iter().flatten().enumerate();
        let negative = all.filter(|(_, value)| is_negative(value)).map(|(number, _)| number.to_string()).collect();
        tell(&format!("{what} with a negative `byteOffset` are read from their start"), negative);
    }
    let lists = ["extensionsUsed", "extensionsRequired"].map(|key| asset.json[key].as_array());
    let quantized = lists.into_iter().flatten().flatten().any(|name| name == "KHR_mesh_quantization");
    let has_integers = |(placed, index): &(&Placed, usize)| {
        let position = attribute(&root.meshes[placed.mesh].primitives[*index], Semantic::Positions);
        let accessor = position.and_then(|position| root.accessors.get(position.value()));
        let kind = accessor.map(|accessor| accessor.component_type);
        !quantized && matches!(kind, Some(Checked::Valid(kind)) if kind.0 != ComponentType::F32)
    };
    tell(
        "meshes whose positions are integers, though the file does not name KHR_mesh_quantization",
        primitives().filter(has_integers).map(|(placed, _)| placed.name.clone()).collect(),
    );
    let mut flat: Vec<usize> = runs.iter().flat_map(|run| &run.skin).flat_map(|(skin, _)| skin.singular()).collect();
    flat.sort_unstable();
    flat.dedup();
    tell("joints whose inverse bind matrix is singular", flat.into_iter().map(named).collect());
    let uneven: usize = runs.iter().flat_map(|run| &run.skin).map(|(_, influences)| influences.uneven).sum();
    if uneven > 0 {
        told.sentences.push(format!(
            "the weights of joints at {uneven} vertices are negative or do not sum to 1: they are divided by their sum"
        ));
    }
}
