//! The points of a sampler, whatever the poses: those a user lists, or evenly spread ones as a baseline.

use mimesh_core::{
    Figures, Result,
    plugin::{check_ranges, instance, nested},
    register,
    stage::{ChoiceWatch, Chosen, KeyPoints, KeyPointsInput, Sampler},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::candidates;

register!(KeyPoints: Given);

/// The points of a sampler as they come, whatever the poses: `sampler: { type: given, vertices: […] }` for your own.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Given {
    /// The sampler that gives the points.
    pub sampler: Option<Box<dyn Sampler>>,
    /// Most key points: the first of those given.
    #[schemars(range(min = 1))]
    pub max_count: usize,
}

impl Default for Given {
    fn default() -> Self {
        Self { sampler: instance("farthest_point"), max_count: 20 }
    }
}

#[typetag::serde(name = "given")]
impl KeyPoints for Given {
    fn choose(&self, input: KeyPointsInput<'_>, _: &dyn ChoiceWatch) -> Result<Chosen> {
        check_ranges(self)?;
        candidates::check_poses(input)?;
        candidates::check(input.source, input.start)?;
        let mut figures = Figures::default();
        let sampler = nested("sampler", &self.sampler, "farthest_point")?;
        let sampled = candidates::sample(sampler, input.source, &mut figures)?;
        figures.set("candidates", sampled.len());
        // Points to start from are kept, the others follow.
        let (all, started) = candidates::with_start(input.source, sampled, input.start);
        let others = (0..all.len()).filter(|k| !started.contains(k));
        let points = started.iter().copied().chain(others).take(self.max_count.max(started.len())).map(|k| all[k]);
        Ok(Chosen { points: points.collect(), steps: vec![], figures })
    }
}
