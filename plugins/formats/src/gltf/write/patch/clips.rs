//! Animations of morph weights: those of the file, made longer, and new ones for the poses.

use std::{collections::HashMap, io};

use serde_json::{Value, json};

use super::{
    layout::Shown,
    names::unique,
    stored::{entries, list, number},
};
use crate::gltf::{
    document::{GltfDocument, RestingNode},
    write::{binary::Binary, pose_clips::PoseClip},
};

/// Makes the existing channels of weights as long as the meshes that they move have targets.
///
/// `added` is the number of new targets, `totals` that of all targets by mesh. Samplers are split where others use them too.
///
/// # Errors
///
/// Those of the file.
pub fn lengthen(
    document: &GltfDocument,
    json: &mut Value,
    binary: &mut Binary,
    totals: &HashMap<usize, usize>,
) -> io::Result<()> {
    let nodes = list(json, "nodes").to_vec();
    let mut outputs = HashMap::new();
    for animation in json.get_mut("animations").and_then(Value::as_array_mut).into_iter().flatten() {
        let total = |channel: &Value| totals.get(&moved_mesh(channel, &nodes)?).copied();
        // The total of each channel, and its sampler.
        let wanted: Vec<(Option<usize>, Option<usize>)> =
            list(animation, "channels").iter().map(|channel| (total(channel), number(channel, "sampler"))).collect();
        let mut split: HashMap<(usize, usize), usize> = HashMap::new();
        for (channel, &(total, sampler)) in wanted.iter().enumerate() {
            let (Some(total), Some(sampler)) = (total, sampler) else { continue };
            let place = match split.get(&(sampler, total)) {
                Some(&place) => place,
                None => {
                    let Some(mut longer) = list(animation, "samplers").get(sampler).cloned() else { continue };
                    let Some(output) = longer_output(document, &longer, total, binary, &mut outputs)? else { continue };
                    longer["output"] = output.into();
                    let only_use = wanted.iter().all(|&(other, by)| by != Some(sampler) || other == Some(total));
                    let samplers = animation["samplers"].as_array_mut().expect("it has an entry");
                    let place = if only_use { sampler } else { samplers.len() };
                    if only_use {
                        samplers[place] = longer
                    } else {
                        samplers.push(longer)
                    }
                    *split.entry((sampler, total)).or_insert(place)
                }
            };
            animation["channels"][channel]["sampler"] = place.into();
        }
    }
    Ok(())
}

/// The mesh whose weights a channel moves.
fn moved_mesh(channel: &Value, nodes: &[Value]) -> Option<usize> {
    let target = channel.get("target")?;
    let mesh_of = |node: usize| number(nodes.get(node)?, "mesh");
    match target.get("path")?.as_str()? {
        "weights" => mesh_of(number(target, "node")?),
        "pointer" => {
            let pointer = target.pointer("/extensions/KHR_animation_pointer/pointer")?.as_str()?;
            let (kind, index) = pointer.strip_prefix('/')?.strip_suffix("/weights")?.split_once('/')?;
            let index = index.parse().ok()?;
            if kind == "nodes" { mesh_of(index) } else { Some(index).filter(|_| kind == "meshes") }
        }
        _ => None,
    }
}

/// The output of a sampler with `total` weights a key, the new ones 0; `None` if it is damaged or has as many already.
fn longer_output(
    document: &GltfDocument,
    sampler: &Value,
    total: usize,
    binary: &mut Binary,
    known: &mut HashMap<(usize, usize, usize), usize>,
) -> io::Result<Option<usize>> {
    let accessors = list(&document.json, "accessors");
    let counts = || {
        let (input, output) = (number(sampler, "input")?, number(sampler, "output")?);
        Some((output, number(accessors.get(input)?, "count")?, number(accessors.get(output)?, "count")?))
    };
    let Some((output, keys, count)) = counts() else { return Ok(None) };
    // A key of a cubic spline has tangents before and after its value, each with all weights.
    let rows = if sampler.get("interpolation").is_some_and(|kind| kind == "CUBICSPLINE") { 3 * keys } else { keys };
    // A channel without any weights is damaged, and its number of keys is bounded by nothing.
    if rows == 0 || count == 0 || count % rows != 0 || count / rows >= total {
        return Ok(None);
    }
    if let Some(&accessor) = known.get(&(output, rows, total)) {
        return Ok(Some(accessor));
    }
    let Some(stored) = entries(document, output) else { return Ok(None) };
    let (row, longer) = (count / rows * stored.size, total * stored.size);
    let mut bytes = Vec::with_capacity(rows * longer);
    for (index, weights) in stored.bytes.chunks(row.max(1)).enumerate() {
        bytes.extend_from_slice(weights);
        bytes.resize((index + 1) * longer, 0);
    }
    let accessor = binary.like(&accessors[output], &bytes, rows * total)?;
    known.insert((output, rows, total), accessor);
    Ok(Some(accessor))
}

/// Adds `clips` for the meshes of `nodes`, which have `added` new targets after their others.
///
/// Where the mesh rests in a clip of the file, new targets move it right on the skeleton of that time: the new clips hold it there,
/// as `resting` has it.
///
/// # Errors
///
/// Those of the file.
pub fn add(
    json: &mut Value,
    binary: &mut Binary,
    clips: Vec<PoseClip>,
    nodes: &[Shown],
    totals: &HashMap<usize, usize>,
    added: usize,
    resting: &[RestingNode],
) -> io::Result<()> {
    for clip in clips {
        let name = {
            let animations = list(json, "animations");
            let taken =
                |name: &str| animations.iter().any(|other| other.get("name").is_some_and(|other| other == name));
            if taken(&clip.name) && clip.name != "poses" {
                unique(&format!("{}-poses", clip.name), taken)
            } else {
                unique(&clip.name, taken)
            }
        };
        let (times, poses): (Vec<f32>, Vec<usize>) = clip.keys.into_iter().unzip();
        let input = binary.times(&times)?;
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        let mut of_total: HashMap<usize, usize> = HashMap::new();
        for shown in nodes {
            let Some(&total) = number(&list(json, "nodes")[shown.node], "mesh").and_then(|mesh| totals.get(&mesh))
            else {
                continue;
            };
            let sampler = match of_total.get(&total) {
                Some(&sampler) => sampler,
                None => {
                    let targets: Vec<usize> = poses.iter().map(|pose| total - added + pose).collect();
                    let output = binary.weights(&targets, total)?;
                    samplers.push(json!({ "input": input, "interpolation": "LINEAR", "output": output }));
                    *of_total.entry(total).or_insert(samplers.len() - 1)
                }
            };
            channels.push(json!({ "sampler": sampler, "target": { "node": shown.node, "path": "weights" } }));
        }
        hold(resting, binary, &mut samplers, &mut channels)?;
        let animation = json!({ "name": name, "samplers": samplers, "channels": channels });
        match json.get_mut("animations").and_then(Value::as_array_mut) {
            Some(animations) => animations.push(animation),
            None => json["animations"] = json!([animation]),
        }
    }
    Ok(())
}

/// Adds a channel of one key for each property of nodes that are held where they are at rest.
fn hold(
    resting: &[RestingNode],
    binary: &mut Binary,
    samplers: &mut Vec<Value>,
    channels: &mut Vec<Value>,
) -> io::Result<()> {
    if resting.is_empty() {
        return Ok(());
    }
    let input = binary.times(&[0.0])?;
    for RestingNode { node, translation, rotation, scale } in resting {
        let outputs = [
            ("translation", binary.keys(&[translation.map(|x| x as f32)])?),
            ("rotation", binary.keys(&[rotation.map(|x| x as f32)])?),
            ("scale", binary.keys(&[scale.map(|x| x as f32)])?),
        ];
        for (path, output) in outputs {
            channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": input, "interpolation": "LINEAR", "output": output }));
        }
    }
    Ok(())
}
