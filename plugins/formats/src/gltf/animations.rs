use std::collections::HashSet;

use mimesh_core::mesh::Animation;

use super::{accessor::numbers, container::Asset, schema};

/// The animations of a file; one that cannot be read has no length, since nothing depends on it.
pub fn list(asset: &Asset) -> Vec<Animation> {
    let joints: HashSet<usize> = asset.root.skins.iter().flat_map(|skin| skin.joints.iter().copied()).collect();
    let describe = |(index, animation): (usize, &schema::Animation)| {
        let times = animation.samplers.iter().filter_map(|sampler| numbers::<1>(asset, sampler.input).ok()).flatten();
        let moved: HashSet<&str> = animation
            .channels
            .iter()
            .map(|channel| match channel.target.path.as_str() {
                "weights" => "morph targets",
                _ if channel.target.node.is_some_and(|node| joints.contains(&node)) => "skeleton",
                _ => "nodes",
            })
            .collect();
        let channels = ["morph targets", "skeleton", "nodes"].into_iter().filter(|what| moved.contains(what));
        Animation {
            name: animation.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| index.to_string()),
            seconds: times.map(|[time]| time).filter(|time| time.is_finite()).fold(0.0, f64::max),
            channels: channels.map(str::to_owned).collect(),
        }
    };
    asset.root.animations.iter().enumerate().map(describe).collect()
}
