//! Clips: the animations of a file, as changes of the nodes and of the weights of morph targets.

use std::{collections::HashSet, sync::Arc};

use gltf::json::{
    self,
    animation::{Channel as JsonChannel, Property},
    validation::Checked,
};
use mimesh_core::mesh::Animation;

use super::{
    accessor::numbers,
    asset::{Asset, follow},
    nodes::Local,
    sampler::Sampler,
    told::Told,
};
use crate::names::{all_distinct, shown};

/// No more clips are told one by one.
const MAX_TOLD: usize = 20;

/// The weights of the morph targets of a node, which others may share.
pub type Weights = Arc<[f64]>;

/// An animation that can be looked at at any time.
#[derive(Debug)]
pub struct Clip {
    /// The name, unique in the file.
    pub name: String,
    /// What moves.
    channels: Vec<Channel>,
}

#[derive(Debug)]
struct Channel {
    node: usize,
    property: Property,
    sampler: Sampler,
}

/// All clips of a file; channels that cannot be read are left out, and told.
pub fn read(asset: &mut Asset) -> Vec<Clip> {
    let animations = &asset.root.animations;
    let given = |(index, animation): (usize, &json::Animation)| {
        animation.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| index.to_string())
    };
    let names = all_distinct(animations.iter().enumerate().map(given));
    let (mut told, mut left_out) = (Told::default(), Vec::new());
    let mut untidy: [Vec<String>; 3] = Default::default();
    let mut warnings = Vec::new();
    let mut clips = Vec::new();
    for (animation, name) in animations.iter().zip(names) {
        let (mut channels, mut problems) = (Vec::new(), Vec::new());
        for channel in &animation.channels {
            match read_channel(asset, animation, channel) {
                Ok(channel) => channels.extend(channel),
                Err(problem) => problems.push(problem),
            }
        }
        if let Some(problem) = problems.first() {
            let count = problems.len();
            left_out.push(format!(
                "{count} channels of the clip `{}` were left out, the first since {problem}",
                shown(&name)
            ));
        }
        let clip = Clip { name, channels };
        let [first, last] = clip.span();
        for (untidy, is_wrong) in untidy.iter_mut().zip(clip.untidy(animation)) {
            untidy.extend(is_wrong.then(|| clip.name.clone()));
        }
        if first == last && clip.channels.iter().any(|channel| channel.sampler.times.len() > 1) {
            left_out.push(format!("the clip `{}` has no length: all its keys are at {first} s", shown(&clip.name)));
        }
        clips.push(clip);
    }
    let more = left_out.len().saturating_sub(MAX_TOLD);
    left_out.truncate(MAX_TOLD);
    warnings.append(&mut left_out);
    if more > 0 {
        warnings.push(format!("{more} further clips have channels that were left out, or no length"));
    }
    let sentences = [
        "clips that have several keys at one time, and jump there",
        "clips that move one property of a node twice: the last counts",
        "clips without channels, which move nothing",
    ];
    sentences.into_iter().zip(untidy).for_each(|(sentence, names)| told.tell(sentence, names));
    warnings.append(&mut told.sentences);
    asset.warnings.extend(warnings);
    clips
}

/// A channel; `None` if what it moves has no morph targets.
fn read_channel(asset: &Asset, animation: &json::Animation, channel: &JsonChannel) -> Result<Option<Channel>, String> {
    let node = follow(&asset.root.nodes, channel.target.node, "node")?;
    let Checked::Valid(property) = channel.target.path else { return Err("it moves an unknown property".into()) };
    let sampler = follow(&animation.samplers, channel.sampler, "sampler")?;
    let Checked::Valid(interpolation) = sampler.interpolation else {
        return Err("its interpolation is not known".into());
    };
    let width = match property {
        Property::Translation | Property::Scale => 3,
        Property::Rotation => 4,
        Property::MorphTargetWeights => {
            let mesh = node.mesh.and_then(|mesh| asset.root.meshes.get(mesh.value()));
            let targets = mesh.into_iter().flat_map(|mesh| &mesh.primitives);
            let targets = targets.map(|primitive| primitive.targets.iter().flatten().count()).max().unwrap_or(0);
            if targets == 0 {
                return Ok(None);
            }
            targets
        }
    };
    let times = numbers::<1>(asset, sampler.input)?.into_flattened();
    let values = match property {
        Property::Translation | Property::Scale => numbers::<3>(asset, sampler.output)?.into_flattened(),
        Property::Rotation => numbers::<4>(asset, sampler.output)?.into_flattened(),
        Property::MorphTargetWeights => numbers::<1>(asset, sampler.output)?.into_flattened(),
    };
    let sampler = Sampler::new(times, values, width, interpolation, property == Property::Rotation)?;
    Ok(Some(Channel { node: channel.target.node.value(), property, sampler }))
}

impl Clip {
    /// Whether it has keys at one time but for a clip of no length, two channels of one thing, or no channel.
    fn untidy(&self, animation: &json::Animation) -> [bool; 3] {
        let [first, last] = self.span();
        let samplers = || self.channels.iter().map(|channel| &channel.sampler);
        let mut moved = HashSet::new();
        let has_twice = !self.channels.iter().all(|channel| moved.insert((channel.node, channel.property as u8)));
        [
            first < last && samplers().any(|sampler| sampler.times.windows(2).any(|pair| pair[0] == pair[1])),
            has_twice,
            animation.channels.is_empty(),
        ]
    }

    /// Moves what the clip moves to where it is at `seconds`; all else stays.
    pub fn apply(&self, seconds: f64, locals: &mut [Local], weights: &mut [Weights]) {
        for channel in &self.channels {
            let value = channel.sampler.at(seconds);
            if channel.property == Property::MorphTargetWeights {
                weights[channel.node] = value.into();
                continue;
            }
            let mut local = locals[channel.node].in_parts();
            if let Local::Parts { translation, rotation, scale } = &mut local {
                match channel.property {
                    Property::Translation => translation.copy_from_slice(&value),
                    Property::Rotation => rotation.copy_from_slice(&value),
                    _ => scale.copy_from_slice(&value),
                }
            }
            locals[channel.node] = local;
        }
    }

    /// The times of the first and of the last key in seconds; both 0 if there is none.
    pub fn span(&self) -> [f64; 2] {
        let times = || self.channels.iter().flat_map(|channel| &channel.sampler.times).copied();
        let [first, last] = [times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max)];
        if first.is_finite() { [first, last] } else { [0.0; 2] }
    }

    /// The times of the keys that move one of `nodes` or the weights of one of `morphing`, in order, each once.
    pub fn key_times(&self, nodes: &HashSet<usize>, morphing: &HashSet<usize>) -> Vec<f64> {
        let moves = |channel: &&Channel| match channel.property {
            Property::MorphTargetWeights => morphing.contains(&channel.node),
            _ => nodes.contains(&channel.node),
        };
        let channels = self.channels.iter().filter(moves);
        let mut times: Vec<f64> = channels.flat_map(|channel| &channel.sampler.times).copied().collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        times
    }
}

/// The clips as a file's list of them.
pub fn list(asset: &Asset, clips: &[Clip]) -> Vec<Animation> {
    let joints = asset.root.skins.iter().flat_map(|skin| skin.joints.iter().map(|joint| joint.value()));
    let joints: HashSet<usize> = joints.collect();
    let describe = |clip: &Clip| {
        let moved: HashSet<&str> = clip
            .channels
            .iter()
            .map(|channel| match channel.property {
                Property::MorphTargetWeights => "morph targets",
                _ if joints.contains(&channel.node) => "skeleton",
                _ => "nodes",
            })
            .collect();
        let channels = ["morph targets", "skeleton", "nodes"].into_iter().filter(|what| moved.contains(what));
        let [_, seconds] = clip.span();
        Animation { name: clip.name.clone(), seconds, channels: channels.map(str::to_owned).collect() }
    };
    clips.iter().map(describe).collect()
}
