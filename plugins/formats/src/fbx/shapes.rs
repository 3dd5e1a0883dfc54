//! Blend shapes: those of one name are one pose.

use std::collections::HashMap;

use ufbx::Scene;

use super::placed::Placed;

/// A pose that consists of blend shapes at full weight.
#[derive(Debug)]
pub struct NamedShape {
    /// The name, unique in the file.
    pub name: String,
    /// The channels, by number in the scene, with the runs of vertices that they move; in the order of the runs.
    pub channels: Vec<(usize, usize)>,
}

/// The shapes of placed meshes, in the order in which their names come up.
///
/// A channel without a name is called by its shape, else by its number.
pub fn shapes(scene: &Scene, placed: &[Placed]) -> Vec<NamedShape> {
    let mut shapes: Vec<NamedShape> = Vec::new();
    let mut by_name: HashMap<String, usize> = HashMap::new();
    for (run, placed) in placed.iter().enumerate() {
        for deformer in &scene.meshes[placed.mesh].blend_deformers {
            for channel in &deformer.channels {
                let Some(shape) = &channel.target_shape else { continue };
                let number = channel.element.typed_id as usize;
                let given = [&*channel.element.name, &*shape.element.name].into_iter().find(|name| !name.is_empty());
                let name = given.map_or_else(|| format!("target-{number}"), str::to_owned);
                // Maya writes `deformer.shape`.
                let prefix = format!("{}.", &*deformer.element.name);
                let name = name.strip_prefix(&prefix).filter(|rest| !rest.is_empty()).unwrap_or(&name).to_owned();
                let index = *by_name.entry(name.clone()).or_insert(shapes.len());
                match shapes.get_mut(index) {
                    Some(shape) => shape.channels.push((run, number)),
                    None => shapes.push(NamedShape { name, channels: vec![(run, number)] }),
                }
            }
        }
    }
    shapes
}

/// The names of the placed meshes whose stored shape is not that with all blend shapes at 0.
pub fn stored_shapes(scene: &Scene, placed: &[Placed]) -> Vec<String> {
    let is_shaped = |placed: &&Placed| {
        let deformers = &scene.meshes[placed.mesh].blend_deformers;
        deformers.iter().any(|deformer| deformer.channels.iter().any(|channel| channel.weight != 0.0))
    };
    placed.iter().filter(is_shaped).map(|placed| placed.name.clone()).collect()
}
