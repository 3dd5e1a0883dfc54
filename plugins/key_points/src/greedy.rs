//! Adds the candidate that helps most, again and again, then exchanges points while that helps.
//!
//! Yang et al. 2018, section 3.5 and algorithm 1. With D_S(A) the source deformed by handles S to come closest to the pose
//! A′, the first stage adds to S the candidate of least error (eq. 22) until that falls below a threshold; the second
//! exchanges single points while one exchange lowers it (eq. 23). `exhaustive: true` judges all candidates at every step, as
//! the paper does.
//!
//! By default the search is fast. All candidates are ranked by weights that cost little, unbounded biharmonic ones (with
//! `ranking_vertices` on a surface over some of the vertices), and only a short list is judged by the weights themselves. Where a
//! point is added and none of the list lowers the error, more are judged in the order of their ranks, until one does or all are
//! judged. Where a point is exchanged, those are judged that rank about as well as the set there is.
//!
//! The best candidate is added even where it raises the error, as in the paper, for a later one may make up for it. Where
//! the limit of points or the last candidate ends the first stage, the best of its sets is kept. (Where the threshold ends it,
//! the last set is the best.)
//!
//! Departures, of either search: the number of points has limits, which the paper leaves to the threshold. The error is the
//! mean over poses and vertices of ‖D_S(A) − A′‖, the source at rest being scaled into the unit sphere, since the paper's
//! Frobenius norm over the number of vertices shrinks with finer meshes (`error: frobenius` for the paper's). An exchange
//! leaves no component without a handle, and the points on no line.

use mimesh_core::{
    Error, Figures, Result,
    mesh::Surface,
    plugin::{check_ranges, configured, instance, nested},
    register,
    serde_json::json,
    stage::{
        ChoiceWatch, Chosen, Clusterer, Deformer, KeyPoints, KeyPointsInput, Proximity, ProximityGraph, Sampler,
        Weights,
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::measure::Measure;
use crate::{
    candidates::{self, HandleRules, MIN_POINTS},
    coarse::CoarseSource,
    evaluator::{Evaluator, Ground, unit_radius},
    judge::Judge,
    report::report,
    search::{Limits, Search},
};

register!(KeyPoints: Greedy);

/// Adds the candidate that helps most, then exchanges points while that helps (Yang et al. 2018, algorithm 1).
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Greedy {
    /// Ends the first stage once the error is at most this: the mean distance to the poses, the source scaled into the unit
    /// sphere. The paper has 0.03.
    #[schemars(range(min = 0.0))]
    pub threshold: f64,
    /// Fewest key points, even if fewer reach the threshold; `max_count` counts if it is less. Transfers need 3, so that many
    /// are chosen in any case.
    #[schemars(range(min = 1))]
    pub min_count: usize,
    /// Most key points.
    #[schemars(range(min = 1))]
    pub max_count: usize,
    /// How far poses are missed.
    pub error: Measure,
    /// Judges every candidate by the weights themselves at every step, as in the paper; takes hours on large meshes.
    pub exhaustive: bool,
    /// How many of the best ranked candidates are judged by the weights themselves at first; more are if none of them helps.
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
    /// About as many vertices of the source as candidates are ranked on, where it has many more; on all of them if not given. On a
    /// body of 2,161 vertices 800 take a third off the time; errors were 0.94 to 1.15 times as large, in the mean 1.04.
    #[schemars(range(min = 1))]
    pub ranking_vertices: Option<usize>,
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
            threshold: 0.005,
            min_count: 8,
            max_count: 20,
            error: Measure::Mean,
            exhaustive: false,
            shortlist: 3,
            max_rounds: 10,
            first: 0,
            sampler: instance("farthest_point"),
            weights: instance("bounded_biharmonic"),
            ranking: configured(json!({ "type": "biharmonic", "clamp": true })),
            ranking_vertices: None,
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

        let mut figures = Figures::default();
        let sampled = candidates::sample(sampler, source, &mut figures)?;
        let (points, started) = candidates::with_start(source, sampled, start);
        if started.is_empty() && self.first >= points.len() {
            return Err(Error::Setting {
                setting: "first".into(),
                expected: format!("a candidate from 0 to {}", points.len() - 1),
                found: self.first.to_string(),
            });
        }
        let first = if started.is_empty() { vec![self.first] } else { started };
        let links = self.links(source)?;
        let ground = Ground {
            regions: clusterer.bind(source, poses)?,
            deformer: deformer.bind(source)?,
            poses: poses.into(),
            counts: None,
        };
        let (measure, unit) = (self.error, unit_radius(&source.positions));
        let weights = weights.bind(source, &points, links.as_ref())?;
        let exact = Evaluator { weights, ground: &ground, measure, unit };
        let ranking = self.ranking.as_ref().filter(|_| !self.exhaustive);
        let coarse = match (&ranking, self.ranking_vertices) {
            (Some(_), Some(vertices)) => CoarseSource::new(source, &points, vertices)?,
            _ => None,
        };
        let coarse_ground = coarse.as_ref().map(|coarse| coarse.ground(poses, clusterer, deformer)).transpose()?;
        let ranking = match (ranking, &coarse, &coarse_ground) {
            (None, ..) => None,
            (Some(ranking), Some(coarse), Some(ground)) => {
                let links = self.links(coarse.surface())?;
                let weights = ranking.bind(coarse.surface(), &coarse.points, links.as_ref())?;
                Some(Evaluator { weights, ground, measure, unit })
            }
            (Some(ranking), ..) => {
                let weights = ranking.bind(source, &points, links.as_ref())?;
                Some(Evaluator { weights, ground: &ground, measure, unit })
            }
        };
        // A component without a handle or a link cannot be moved, so that each has one from the beginning.
        let first = if links.is_some() { first } else { candidates::cover_components(source, &points, first) };
        let rules = HandleRules::new(source, &points, links.is_some());
        let judge = Judge::new(&exact, ranking.as_ref(), self.shortlist, watch);
        let limits = self.limits(&mut figures);
        let mut search = Search::begin(&points, &rules, judge, watch, first)?;
        let added = search.add(limits, self.max_rounds)?;
        let exchanged = search.exchange(self.max_rounds);
        figures.set("candidates", points.len());
        report(&mut figures, &search, &rules, limits, (&added, &exchanged));
        let chosen = search.chosen.iter().map(|&k| points[k]).collect();
        Ok(Chosen { points: chosen, steps: search.steps, figures })
    }
}

impl Greedy {
    /// The links between the components of a surface of several.
    fn links(&self, surface: &Surface) -> Result<Option<ProximityGraph>> {
        let proximity = self.proximity.as_ref().filter(|_| surface.components().count() > 1);
        proximity.map(|proximity| proximity.proximity(surface)).transpose()
    }

    fn limits(&self, figures: &mut Figures) -> Limits {
        if self.max_count < MIN_POINTS {
            figures.warn(format!(
                "`max_count: {}` allows fewer points than the {MIN_POINTS} that transfers need, so {MIN_POINTS} were allowed",
                self.max_count
            ));
        }
        let max_count = self.max_count.max(MIN_POINTS);
        Limits { threshold: self.threshold, min_count: self.min_count.clamp(MIN_POINTS, max_count), max_count }
    }
}
