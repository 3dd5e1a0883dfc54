//! The greedy search on errors that are known: each candidate lowers the error by a gain, and some pairs by more.

use std::sync::Mutex;

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint},
    stage::{
        AvailablePoints, BoundClusterer, BoundDeformer, BoundWeights, ChoiceStep, ChoiceWatch, Chosen, Clusterer,
        Deformer, Fit, HandleWeights, KeyPoints, KeyPointsInput, ProximityGraph, Regions, Sampler, Skin, Weights,
    },
    testkit::meshes,
};
use mimesh_key_points::greedy::Greedy;
use nalgebra::{DMatrix, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// The first vertices of the surface, `asked` of them if there are as many.
#[derive(Debug, Deserialize, Serialize)]
struct First {
    asked: usize,
}

#[typetag::serde(name = "first")]
impl Sampler for First {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        Ok(self.sample_available(surface)?.points)
    }

    fn sample_available(&self, surface: &Surface) -> Result<AvailablePoints> {
        let count = self.asked.min(surface.vertex_count());
        Ok(AvailablePoints { points: (0..count as u32).map(SurfacePoint::Vertex).collect(), asked: self.asked })
    }
}

/// W has `mark` where a handle is, and 0 elsewhere; sets with a vertex of `refused` have none.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Marks {
    mark: f64,
    refused: Vec<usize>,
}

#[typetag::serde(name = "marks")]
impl Weights for Marks {
    fn bind(&self, surface: &Surface, _: &[SurfacePoint], _: Option<&ProximityGraph>) -> Result<Box<dyn BoundWeights>> {
        Ok(Box::new(BoundMarks { vertices: surface.vertex_count(), marks: self.clone() }))
    }
}

#[derive(Debug)]
struct BoundMarks {
    vertices: usize,
    marks: Marks,
}

impl BoundWeights for BoundMarks {
    fn solve(&self, handles: &[usize]) -> Result<HandleWeights> {
        if let Some(refused) = handles.iter().find(|handle| self.marks.refused.contains(handle)) {
            return Err(Error::data(format!("no weights for {refused}"), "leave it out"));
        }
        let mut matrix = DMatrix::zeros(self.vertices, handles.len());
        handles.iter().enumerate().for_each(|(column, &row)| matrix[(row, column)] = self.marks.mark);
        Ok(HandleWeights { matrix, figures: Figures::default() })
    }

    fn figures(&self) -> Figures {
        Figures::default()
    }
}

#[derive(Debug, Deserialize, Serialize)]
struct One;

#[typetag::serde(name = "one")]
impl Clusterer for One {
    fn bind(&self, _: &Surface, _: &[Vec<Point3<f64>>]) -> Result<Box<dyn BoundClusterer>> {
        Ok(Box::new(Self))
    }
}

impl BoundClusterer for One {
    fn cluster(&self, weights: &DMatrix<f64>) -> Result<Regions> {
        Ok(Regions { of_vertex: vec![0; weights.nrows()], count: 1, figures: Figures::default() })
    }
}

/// The error is 1 less the gains of the handles and of the pairs among them; ranks are found from `ranks` instead of `gains`.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
struct Gains {
    gains: Vec<f64>,
    ranks: Vec<f64>,
    pairs: Vec<(usize, usize, f64)>,
}

#[typetag::serde(name = "gains")]
impl Deformer for Gains {
    fn bind(&self, _: &Surface) -> Result<Box<dyn BoundDeformer>> {
        Ok(Box::new(self.clone()))
    }
}

impl BoundDeformer for Gains {
    fn skin(&self, weights: &HandleWeights, _: &Regions) -> Result<Box<dyn Skin>> {
        let handles: Vec<usize> = weights.matrix.column_iter().map(|column| column.imax()).collect();
        let gains = if weights.matrix.max() == EXACT { &self.gains } else { &self.ranks };
        let of_pairs = self.pairs.iter().filter(|(a, b, _)| handles.contains(a) && handles.contains(b));
        let sum = handles.iter().map(|&k| gains[k]).sum::<f64>() + of_pairs.map(|pair| pair.2).sum::<f64>();
        Ok(Box::new(Off(1.0 - sum)))
    }
}

/// Misses every pose by this distance.
#[derive(Debug)]
struct Off(f64);

impl Skin for Off {
    fn fit(&self, posed: &[Point3<f64>]) -> Result<Fit> {
        let positions = posed.iter().map(|p| p + Vector3::x() * self.0).collect();
        Ok(Fit { transforms: vec![], positions, figures: Figures::default() })
    }
}

const EXACT: f64 = 1.0;
const RANKING: f64 = 2.0;

fn search(gains: Gains) -> Greedy {
    let marks = |mark| Some(Box::new(Marks { mark, refused: vec![] }) as Box<dyn Weights>);
    Greedy {
        threshold: 0.0,
        min_count: 3,
        max_rounds: 0,
        sampler: Some(Box::new(First { asked: gains.gains.len() })),
        weights: marks(EXACT),
        ranking: marks(RANKING),
        clusterer: Some(Box::new(One)),
        deformer: Some(Box::new(gains)),
        ..Greedy::default()
    }
}

#[derive(Default)]
struct Recorder(Mutex<Vec<ChoiceStep>>);

impl ChoiceWatch for Recorder {
    fn step(&self, step: &ChoiceStep) {
        self.0.lock().unwrap().push(step.clone());
    }
}

fn choose_on(source: &Surface, search: &Greedy) -> Result<Chosen> {
    let poses = [source.positions.clone()];
    let watch = Recorder::default();
    let chosen = search.choose(KeyPointsInput { source, poses: &poses, start: &[] }, &watch)?;
    assert_eq!(*watch.0.lock().unwrap(), chosen.steps, "the steps reported are those kept");
    Ok(chosen)
}

/// The choice on a sphere of radius 1 with 12 vertices.
fn choose(search: &Greedy) -> Chosen {
    choose_on(&meshes::icosphere(0), search).unwrap()
}

fn vertices(chosen: &Chosen) -> Vec<u32> {
    let vertex = |point: &SurfacePoint| match point {
        SurfacePoint::Vertex(v) => *v,
        SurfacePoint::Triangle(..) => panic!("{point:?} is not a vertex"),
    };
    chosen.points.iter().map(vertex).collect()
}

#[track_caller]
fn assert_errors(chosen: &Chosen, expected: &[f64]) {
    let errors: Vec<f64> = chosen.steps.iter().map(|step| step.error).collect();
    assert_eq!(errors.len(), expected.len(), "{errors:?}");
    // Rounding of sums over a dozen vertices.
    assert!(errors.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{errors:?}");
}

#[track_caller]
fn assert_warns(chosen: &Chosen, expected: &[&str]) {
    assert_eq!(chosen.figures.warnings, expected);
}

#[test]
fn judging_goes_on_until_a_candidate_helps() {
    // The three that help rank last.
    let ranks = (0..12).map(|k| -0.01 * f64::from(k)).collect();
    let gains = [&[-0.01; 9][..], &[0.20, 0.21, 0.22]].concat();
    let mut search = Greedy { max_count: 4, ..search(Gains { gains, ranks, pairs: vec![] }) };
    let fast = choose(&search);
    assert_eq!(vertices(&fast), [0, 9, 10, 11]);
    search.exhaustive = true;
    let exhaustive = choose(&search);
    assert_eq!(vertices(&exhaustive), [0, 11, 10, 9]);
    assert_eq!(fast.figures.number("error"), exhaustive.figures.number("error"));
    // All that are left, at each of three steps, and the first.
    assert_eq!(exhaustive.figures.values["judged"], 1 + 11 + 10 + 9);
    assert_eq!(fast.figures.values["judged"], 1 + 3 * (3 + 6));
    assert_eq!(fast.figures.values["ended_by"], "max_count");
}

#[test]
fn a_short_list_that_helps_is_enough() {
    let gains: Vec<f64> = (0..12).map(|k| 0.05 - 0.001 * f64::from(k)).collect();
    let search = Greedy { max_count: 5, ..search(Gains { ranks: gains.clone(), gains, pairs: vec![] }) };
    let chosen = choose(&search);
    assert_eq!(vertices(&chosen), [0, 1, 2, 3, 4]);
    assert_eq!(chosen.figures.values["judged"], 1 + 4 * 3);
}

#[test]
fn a_point_that_raises_the_error_is_kept_only_if_a_later_one_makes_up_for_it() {
    let gains = vec![0.0, 0.2, 0.2, -0.05, -0.06, -0.5];
    let pairs = vec![(3, 4, 0.3)];
    for exhaustive in [false, true] {
        let ranks = gains.clone();
        let gains = Gains { gains: gains.clone(), ranks, pairs: pairs.clone() };
        let chosen = choose(&Greedy { exhaustive, max_count: 6, ..search(gains) });
        assert_eq!(vertices(&chosen), [0, 1, 2, 3, 4]);
        assert_errors(&chosen, &[1.0, 0.8, 0.6, 0.65, 0.41]);
        assert_eq!(chosen.figures.values["points_tried"], 6);
        assert_warns(
            &chosen,
            &["5 key points leave an error of 0.4100, above the threshold of 0; up to 6 were tried, and more did not \
               help; other candidates may, set `sampler`"],
        );
    }
}

#[test]
fn min_count_holds_below_the_threshold_and_where_points_do_harm() {
    let gains = vec![0.0, 0.3, 0.3, -0.01, -0.02, -0.03];
    let with = |min_count| {
        let gains = Gains { ranks: gains.clone(), gains: gains.clone(), pairs: vec![] };
        choose(&Greedy { threshold: 0.5, min_count, ..search(gains) })
    };
    for fewest in [1, 3] {
        assert_errors(&with(fewest), &[1.0, 0.7, 0.4]);
    }
    let more = with(5);
    assert_errors(&more, &[1.0, 0.7, 0.4, 0.41, 0.43]);
    assert_eq!(more.figures.values["ended_by"], "threshold");
    assert_warns(&more, &[]);
}

#[test]
fn never_fewer_points_than_transfers_need() {
    let gains = Gains { gains: vec![0.1; 12], ranks: vec![0.1; 12], pairs: vec![] };
    let chosen = choose(&Greedy { max_count: 2, threshold: 2.0, ..search(gains.clone()) });
    assert_eq!(chosen.points.len(), 3);
    assert_warns(&chosen, &["`max_count: 2` allows fewer points than the 3 that transfers need, so 3 were allowed"]);
    // The first three vertices of a grid lie on its edge.
    let mut gains = gains;
    gains.gains[1] = 0.3;
    gains.gains[2] = 0.2;
    gains.ranks = gains.gains.clone();
    let chosen = choose_on(&meshes::grid(2, 3), &Greedy { threshold: 2.0, ..search(gains) }).unwrap();
    assert_eq!(vertices(&chosen)[..3], [0, 1, 2]);
    assert_eq!(chosen.points.len(), 4, "three points on a line do not suffice");
}

#[test]
fn a_source_with_fewer_candidates_gives_all() {
    let gains = Gains { gains: vec![0.05; 12], ranks: vec![0.05; 12], pairs: vec![] };
    let chosen = choose(&Greedy { sampler: Some(Box::new(First { asked: 100 })), ..search(gains) });
    assert_eq!(chosen.points.len(), 12);
    assert_eq!(chosen.figures.values["ended_by"], "candidates");
    assert_warns(
        &chosen,
        &[
            "the source offers only 12 of the 100 candidates that the sampler is to find, so these were used",
            "12 key points leave an error of 0.4000, above the threshold of 0; these are all 12 candidates; give more \
             with `sampler`",
        ],
    );
}

#[test]
fn candidates_that_cannot_be_judged_are_named() {
    let gains = || Gains { gains: vec![0.1; 6], ranks: vec![0.1; 6], pairs: vec![] };
    let refuse = |refused: Vec<usize>| Some(Box::new(Marks { mark: EXACT, refused }) as Box<dyn Weights>);
    let chosen = choose(&Greedy { weights: refuse(vec![1]), max_count: 4, ..search(gains()) });
    assert_eq!(vertices(&chosen), [0, 2, 3, 4]);
    let of_error = "could not be judged in 3 of the sets tried, the first time: no weights for 1; leave it out";
    assert_eq!(chosen.figures.warnings[1], format!("candidate 1 (vertex 1) {of_error}"));

    let chosen = choose(&Greedy { weights: refuse(vec![2, 3, 5]), ..search(gains()) });
    assert_eq!(vertices(&chosen), [0, 1, 4]);
    assert_eq!(chosen.figures.values["ended_by"], "not_judged");
    assert!(
        chosen.figures.warnings[0].ends_with("; no other candidate can be judged"),
        "{:?}",
        chosen.figures.warnings
    );

    let search = Greedy { weights: refuse(vec![1, 2, 3, 4, 5]), ..search(gains()) };
    let error = choose_on(&meshes::icosphere(0), &search).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no candidate can be added to 1 key points; candidate 1 (vertex 1): no weights for 1"
    );
}

#[test]
fn candidates_that_cannot_be_ranked_are_judged_all_the_same() {
    let gains = Gains { gains: vec![0.0, 0.1, 0.2, 0.3, 0.1, 0.1], ranks: vec![0.0; 6], pairs: vec![] };
    let ranking = Marks { mark: RANKING, refused: (0..6).collect() };
    let chosen = choose(&Greedy { ranking: Some(Box::new(ranking)), max_count: 3, ..search(gains) });
    assert_eq!(vertices(&chosen), [0, 3, 2]);
    let named = "could not be ranked in 2 of the sets tried";
    assert!(chosen.figures.warnings[1].starts_with(&format!("candidate 1 (vertex 1) {named}")));
    assert_eq!(chosen.figures.warnings.last().unwrap(), "2 more candidates could not be ranked in some sets");
}

#[test]
fn exchanges_that_are_cut_short_are_reported() {
    let gains = Gains { gains: vec![0.0, 0.3, 0.2, 0.1], ranks: vec![0.0, 0.3, 0.2, 0.1], pairs: vec![] };
    let warnings = |max_rounds| choose(&Greedy { max_rounds, max_count: 3, ..search(gains.clone()) }).figures.warnings;
    let warning = "exchanges ended with round 1, which still lowered the error; allow more with `max_rounds`";
    assert!(warnings(1).iter().any(|found| found == warning), "{:?}", warnings(1));
    // The second round finds nothing more to exchange.
    assert!(warnings(2).len() == 1 && warnings(0).len() == 1, "{:?}", warnings(2));
}
