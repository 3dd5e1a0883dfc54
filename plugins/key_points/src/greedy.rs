//! Adds the candidate that helps most, again and again, then exchanges points while that helps.
//!
//! Yang et al. 2018, section 3.5 and algorithm 1. With D_S(A) the source deformed by handles S to come closest to the pose
//! A′, the first stage adds to S the candidate of least error (eq. 22) until that falls below a threshold; the second
//! exchanges single points while one exchange lowers it (eq. 23).
//!
//! Departures: the error is the mean over poses and vertices of ‖D_S(A) − A′‖, the source at rest being scaled into the unit
//! sphere, since the paper's Frobenius norm over the number of vertices shrinks with finer meshes (`error: frobenius` for the
//! paper's). The search is fast by default: all candidates are ranked by weights that cost little, unbounded biharmonic
//! ones, and only a short list is judged by the weights themselves (`exhaustive: true` for the paper, which judges all).

use mimesh_core::{
    Error, Figures, Result,
    plugin::{check_ranges, configured, instance, nested},
    register,
    serde_json::json,
    stage::{ChoiceWatch, Chosen, Clusterer, Deformer, KeyPoints, KeyPointsInput, Proximity, Sampler, Weights},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::measure::Measure;
use crate::{
    candidates,
    search::{Evaluator, Search, unit_radius},
};

register!(KeyPoints: Greedy);

/// Adds the candidate that helps most, then exchanges points while that helps (Yang et al. 2018, algorithm 1).
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Greedy {
    /// Ends the first stage once the error is below this: the mean distance to the poses, the source scaled into the unit
    /// sphere.
    #[schemars(range(min = 0.0))]
    pub threshold: f64,
    /// Most key points.
    #[schemars(range(min = 1))]
    pub max_count: usize,
    /// How far poses are missed.
    pub error: Measure,
    /// Judges every candidate by the weights themselves at every step, as in the paper; takes hours on large meshes.
    pub exhaustive: bool,
    /// How many of the best ranked candidates are judged by the weights themselves, if not all.
    #[schemars(range(min = 1))]
    pub shortlist: usize,
    /// Most rounds of exchanges; 0 leaves out the second stage.
    #[schemars(range(min = 0))]
    pub max_rounds: usize,
    /// The candidate to begin with, by its number; the second stage may exchange it.
    pub first: usize,
    /// The candidates; by default 100 farthest points, as in the paper.
    pub sampler: Option<Box<dyn Sampler>>,
    /// How the influence of key points spreads.
    pub weights: Option<Box<dyn Weights>>,
    /// Weights that rank candidates.
    pub ranking: Option<Box<dyn Weights>>,
    /// Links between the components of a source of several; with `null` each has a key point from the beginning.
    pub proximity: Option<Box<dyn Proximity>>,
    /// How the source is divided into regions that move about rigidly.
    pub clusterer: Option<Box<dyn Clusterer>>,
    /// How poses are fitted.
    pub deformer: Option<Box<dyn Deformer>>,
}

impl Default for Greedy {
    fn default() -> Self {
        Self {
            threshold: 0.03,
            max_count: 20,
            error: Measure::Mean,
            exhaustive: false,
            shortlist: 3,
            max_rounds: 10,
            first: 0,
            sampler: instance("farthest_point"),
            weights: instance("bounded_biharmonic"),
            ranking: configured(json!({ "type": "biharmonic", "clamp": true })),
            proximity: instance("spanning_tree"),
            clusterer: instance("rotation_kmeans"),
            deformer: instance("arap_skinning"),
        }
    }
}

#[typetag::serde(name = "greedy")]
impl KeyPoints for Greedy {
    fn choose(&self, input: KeyPointsInput<'_>, watch: &dyn ChoiceWatch) -> Result<Chosen> {
        check_ranges(self)?;
        let KeyPointsInput { source, poses, start } = input;
        candidates::check_poses(input)?;
        candidates::check(source, start)?;
        let sampler = nested("sampler", &self.sampler, "farthest_point")?;
        let weights = nested("weights", &self.weights, "bounded_biharmonic")?;
        let clusterer = nested("clusterer", &self.clusterer, "rotation_kmeans")?;
        let deformer = nested("deformer", &self.deformer, "arap_skinning")?;

        let sampled = sampler.sample(source)?;
        let (points, started) = candidates::with_start(source, sampled, start);
        if started.is_empty() && self.first >= points.len() {
            return Err(Error::Setting {
                setting: "first".into(),
                expected: format!("a candidate from 0 to {}", points.len() - 1),
                found: self.first.to_string(),
            });
        }
        let first = if started.is_empty() { vec![self.first] } else { started };
        let regions = clusterer.bind(source, poses)?;
        let deformer = deformer.bind(source)?;
        let links = match &self.proximity {
            Some(proximity) if source.components().count() > 1 => Some(proximity.proximity(source)?),
            _ => None,
        };
        let judge = |weights: &dyn Weights| -> Result<Evaluator<'_>> {
            Ok(Evaluator {
                weights: weights.bind(source, &points, links.as_ref())?,
                regions: regions.as_ref(),
                deformer: deformer.as_ref(),
                poses,
                measure: self.error,
                unit: unit_radius(&source.positions),
            })
        };
        let exact = judge(weights)?;
        let ranking = match &self.ranking {
            Some(ranking) if !self.exhaustive => Some(judge(ranking.as_ref())?),
            _ => None,
        };
        // A component without a handle or a link cannot be moved, so that each has one from the beginning.
        let first = if links.is_some() { first } else { candidates::cover_components(source, &points, first) };
        let mut search = Search::new(&points, &exact, ranking.as_ref(), self.shortlist, watch);
        search.begin(first)?;
        search.add(self.threshold, self.max_count)?;
        let rounds = search.exchange(self.max_rounds)?;

        let mut figures = Figures::default();
        figures.set("candidates", points.len());
        figures.set("error", search.error);
        figures.set("rounds_of_exchanges", rounds);
        figures.set("judged", search.judged);
        figures.set("ranked", search.ranked);
        if search.error > self.threshold && !watch.is_interrupted() {
            figures.warn(format!(
                "{} key points leave an error of {:.4}, above the threshold of {}; allow more with `max_count`",
                search.chosen.len(),
                search.error,
                self.threshold
            ));
        }
        let chosen = search.chosen.iter().map(|&k| points[k]).collect();
        Ok(Chosen { points: chosen, steps: search.steps, figures })
    }
}
