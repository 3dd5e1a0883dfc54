//! What of the data of a file is read, or left out, though it is not as glTF wants it.

use serde_json::Value;

use super::{
    accessor::{check_reach, has_data},
    asset::{Asset, size},
    primitive::attribute,
    scene::Placed,
    told::Told,
};
use crate::names::shown;

/// Keys whose values are numbers of entries of a list.
const NUMBERS: [&str; 16] = [
    "bufferView",
    "inverseBindMatrices",
    "mode",
    "buffer",
    "indices",
    "material",
    "mesh",
    "skin",
    "sampler",
    "input",
    "output",
    "node",
    "scene",
    "children",
    "nodes",
    "joints",
];

/// The lists in which they stand.
const LISTS: [&str; 8] = ["accessors", "animations", "bufferViews", "meshes", "nodes", "scenes", "skins", "textures"];

/// The sentences about names, buffers, views, accessors and primitives.
pub fn warnings(asset: &Asset, placed: &[Placed], told: &mut Told) {
    let json = &asset.json;
    let mut negative = Vec::new();
    LISTS.iter().for_each(|list| find_negative(&json[list], list, &mut negative));
    negative.sort();
    negative.dedup();
    told.tell("negative numbers stand for none", negative);
    let mut controls = Vec::new();
    for list in ["nodes", "meshes", "materials", "animations"] {
        let names = json[list].as_array().into_iter().flatten().filter_map(|entry| entry["name"].as_str());
        controls
            .extend(names.filter(|name| name.contains(char::is_control)).map(|name| name.escape_debug().to_string()));
    }
    told.tell("names with characters that no text shows", controls);
    views(asset, told);
    primitives(asset, placed, told);
    let materials = json["materials"].as_array().into_iter().flatten().enumerate();
    let is_no_color = |(_, material): &(usize, &Value)| {
        let color = &material["pbrMetallicRoughness"]["baseColorFactor"];
        let is_color = color.as_array().is_some_and(|parts| parts.len() == 4 && parts.iter().all(Value::is_number));
        !color.is_null() && !is_color
    };
    told.tell(
        "materials whose base colour is not four numbers are white",
        materials.filter(is_no_color).map(|(number, _)| number.to_string()).collect(),
    );
}

/// Adds the keys below `value`, which stands under `key`, whose number of an entry is negative.
fn find_negative(value: &Value, key: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(number) if NUMBERS.contains(&key) && number.as_f64().is_some_and(|x| x < 0.0) => {
            found.push(key.to_owned());
        }
        Value::Array(values) => values.iter().for_each(|value| find_negative(value, key, found)),
        Value::Object(entries) => {
            let entries = entries.iter().filter(|(key, _)| !matches!(&***key, "extras" | "extensions"));
            entries.for_each(|(key, value)| find_negative(value, key, found));
        }
        _ => {}
    }
}

/// Buffers, views and accessors, whether they are read or not.
fn views(asset: &Asset, told: &mut Told) {
    let root = &asset.root;
    let numbers = |wrong: Vec<usize>| wrong.iter().map(usize::to_string).collect::<Vec<_>>();
    let mut beyond = Vec::new();
    let mut uneven = Vec::new();
    for (index, view) in root.buffer_views.iter().enumerate() {
        let end = view.byte_offset.map_or(0, size).saturating_add(size(view.byte_length));
        let length = asset.buffers.get(view.buffer.value()).map_or(0, |buffer| buffer.len());
        // The last bytes may be padding.
        if end > length.saturating_add(super::container::MAX_PADDING) && !asset.decompressed.contains_key(&index) {
            beyond.push(index);
        }
        if view
            .byte_stride
            .is_some_and(|stride| stride.0 > 0 && !(stride.0.is_multiple_of(4) && (4..=252).contains(&stride.0)))
        {
            uneven.push(index);
        }
    }
    told.tell("buffer views that reach beyond their buffer", numbers(beyond));
    told.tell("buffer views with a `byteStride` other than a multiple of 4 up to 252", numbers(uneven));
    let beyond = (0..root.accessors.len()).filter(|&index| !check_reach(asset, index)).collect();
    told.tell("accessors that reach beyond their buffer view", numbers(beyond));
    told.tell(
        "accessors whose sparse entries do not ascend: of two for one entry the last counts",
        numbers(asset.unordered.borrow().iter().copied().collect()),
    );
}

fn primitives(asset: &Asset, placed: &[Placed], told: &mut Told) {
    use gltf::json::mesh::Semantic::Positions;

    let root = &asset.root;
    let (mut empty, mut missing, mut weights, mut still) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for placed in placed {
        let (mesh, json) = (&root.meshes[placed.mesh], &asset.json["meshes"][placed.mesh]);
        for &index in &placed.primitives {
            let primitive = &mesh.primitives[index];
            let has_none = |index| {
                let is_sparse =
                    |at: gltf::json::Index<gltf::json::Accessor>| root.accessors[at.value()].sparse.is_some();
                !has_data(asset, index) && !is_sparse(index)
            };
            if attribute(primitive, Positions).into_iter().chain(primitive.indices).any(has_none) {
                empty.push(placed.name.clone());
            }
            let attributes = json["primitives"][index]["attributes"].as_object();
            // The others are told where they are read.
            let is_read = |name: &str| matches!(name, "POSITION" | "NORMAL" | "TEXCOORD_0" | "COLOR_0");
            for (name, accessor) in attributes.into_iter().flatten().filter(|(name, _)| !is_read(name)) {
                if accessor.as_f64().is_none_or(|number| number < 0.0 || number >= root.accessors.len() as f64) {
                    missing.push(format!("{} of {}", shown(name), shown(&placed.name)));
                }
            }
        }
        let numbers = [&json["weights"], &asset.json["nodes"][placed.node]["weights"]];
        let is_list = |value: &Value| value.as_array().is_some_and(|list| list.iter().all(Value::is_number));
        if numbers.into_iter().any(|value| !value.is_null() && !is_list(value)) {
            weights.push(placed.name.clone());
        }
        let targets = || mesh.primitives.iter().filter_map(|primitive| primitive.targets.as_ref());
        let count = targets().map(Vec::len).max().unwrap_or(0);
        let moves =
            |target: usize| targets().any(|all| all.get(target).is_some_and(|target| target.positions.is_some()));
        still.extend(
            (0..count).filter(|&target| !moves(target)).map(|target| format!("{target} of {}", shown(&placed.name))),
        );
    }
    told.tell("meshes whose positions or indices have no data, and are all 0", empty);
    told.tell("attributes whose accessor the file does not have are left out", missing);
    told.tell("weights of morph targets that are no numbers are 0", weights);
    told.tell("morph targets that move no positions are no poses", still);
}
