//! Limbs, and the points at their ends.
//!
//! Points are spread evenly over each surface and linked where they are near and do not face each other, whatever the components. Limbs
//! are persistent maxima of the mean distance along these links, as in Hilaga et al. 2001 and Tierny et al. 2006. Under turns of the
//! axes the limbs of the two surfaces are assigned to each other, by their places in the bounding box and by mean distance. Pairs whose
//! distances to the others differ are dropped. In each pair of limbs the points that correspond are those that are mutually nearest
//! when the limbs fill the same box.
//!
//! Fits on surfaces of some 2,000 vertices tell whether that is right: of the target to the source and of the source to the target.
//! Points that one takes over and the other back return to their place if the landmarks are right. Where the best turn is doubtful, the
//! next two are fitted too. Where fits agree nearly everywhere, points between limbs are taken from them.
//!
//! Shapes without limbs, as faces, are laid into one box. Points at the same place start a fit, and are then replaced by points that
//! fits agree on. They are refused where fits do not agree.
//!
//! About one second of computing a mesh, whatever its density, and one to four for the fits. Prefer clicks where shapes differ in kind.

mod assignment;
mod between;
mod cloud;
mod comparison;
mod limbs;
mod links;
mod matching;
mod place;
mod proposal;
mod reading;
mod shape;
mod suggestion;
mod tips;
mod turn;

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
    plugin::{check_ranges, configured, nested},
    register,
    stage::{Correspondence, Landmarks, Marker, Proposal, Sampler, Suggestion, TransferPair, Work},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tracing::{Span, debug_span};

pub use self::matching::Limits;
use self::{
    comparison::Proxies,
    matching::matches,
    place::alike,
    proposal::proposal,
    reading::{Reader, Reading, Wanted},
    shape::Shape,
    suggestion::suggest,
};

register!(Landmarks: Extremities);

/// The ends of limbs such as legs, arms, necks and tails, and points between them; points at the same place for shapes without limbs
/// that lie alike, as faces. Fits forwards and backwards tell how sure they are.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Extremities {
    /// The points that stand for each surface; by default 2000 that keep apart.
    pub sampler: Option<Box<dyn Sampler>>,
    /// How many of these points the mean distance is taken to.
    #[schemars(range(min = 1))]
    pub sources: usize,
    /// How much a limb's mean distance along the surface stands out at least, relative to the mean over the surface. Legs and tails have
    /// 0.19 to 1.2, ears and thumbs at most 0.13.
    #[schemars(range(min = 0.0))]
    pub min_limb: f64,
    /// How far limbs may differ and still be the same.
    pub limits: Limits,
    /// Most pairs of points in a pair of limbs.
    #[schemars(range(min = 1))]
    pub points_per_limb: usize,
    /// The largest distance of a pair of points, in sides of the box of its limb.
    #[schemars(range(min = 0.0))]
    pub max_distance: f64,
    /// Most points between limbs, where the fits of two shapes agree nearly everywhere and the target is one component.
    pub points_between: usize,
    /// The correspondence whose fits are compared; by default `nonrigid_fit`.
    pub fit: Option<Box<dyn Correspondence>>,
    /// How many vertices each surface has where fits are compared; fewer triangles stand for those of the file.
    #[schemars(range(min = 100))]
    pub fit_vertices: usize,
}

impl Default for Extremities {
    fn default() -> Self {
        Self {
            sampler: configured(json!({ "type": "poisson_disk", "count": 2000, "at_vertices": false })),
            sources: 200,
            min_limb: 0.15,
            limits: Limits::default(),
            points_per_limb: 2,
            max_distance: 0.25,
            points_between: 12,
            fit: configured(json!({ "type": "nonrigid_fit", "steps": 20 })),
            fit_vertices: 2000,
        }
    }
}

/// The costs of looking at shapes, and of finding what corresponds.
const COSTS: [f64; 2] = [1.0, 1.0];

/// The costs of surfaces with fewer triangles, and of fits on them.
const COSTS_OF_FITS: [f64; 2] = [1.0, 4.0];

/// Fewer limbs, or fewer pairs of points, say too little of how two shapes correspond.
const MIN_COUNT: usize = 4;

/// Limbs of shapes in other poses are taken for the same where fits agree at least so far.
const MIN_OTHER_POSE: f64 = 0.3;

/// Shapes without limbs are taken to lie alike where fits agree at least so far.
const MIN_ALIKE: f64 = 0.75;

/// Volumes that are smaller, relative to the area to the power 3/2, tell nothing of which side is out.
const MIN_VOLUME: f64 = 1e-3;

#[typetag::serde(name = "extremities")]
impl Landmarks for Extremities {
    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal> {
        self.propose_watched(pair, Work::UNWATCHED)
    }

    fn propose_watched(&self, pair: TransferPair<'_>, work: Work<'_>) -> Result<Proposal> {
        check_ranges(self)?;
        pair.check_markers()?;
        let [measuring, finding] = work.parts(COSTS);
        let shapes = self.shapes(pair)?;
        measuring.done(1.0);
        if are_opposite(&shapes) {
            // The triangles of one side show what is inside, so that normals and fits would tell nothing.
            let target = turned(pair.target);
            let markers: Vec<Marker> = pair.markers.iter().map(turned_marker).collect();
            let pair = TransferPair { target: &target, markers: &markers, ..pair };
            let mut proposal = self.find(pair, self.shapes(pair)?, finding)?;
            let all = std::iter::once(&mut proposal.pairs).chain(&mut proposal.others).flatten();
            all.for_each(|pair| pair.marker = turned_marker(&pair.marker));
            proposal.figures.warn(
                "the triangles of one surface point inwards, those of the other outwards; the landmarks are found as if they were turned \
                 round, but a correspondence goes by what they are: turn them round",
            );
            return Ok(proposal);
        }
        self.find(pair, shapes, finding)
    }

    fn suggest(&self, pair: TransferPair<'_>) -> Result<Option<Suggestion>> {
        check_ranges(self)?;
        pair.check_markers()?;
        let fit = nested("fit", &self.fit, "nonrigid_fit")?;
        let proxies = Proxies::new(pair, self.fit_vertices, fit)?;
        // Without a fit, as of too few markers, points spread over the surface.
        let comparison = proxies.compare(pair, pair.markers).ok();
        suggest(pair, &proxies, comparison.as_ref())
    }
}

impl Extremities {
    /// The shapes of source and target.
    fn shapes(&self, pair: TransferPair<'_>) -> Result<[Shape; 2]> {
        let sampler = nested("sampler", &self.sampler, "poisson_disk")?;
        let span = Span::current();
        let shape = |surface| {
            let span = debug_span!(parent: &span, "shape");
            span.in_scope(|| Shape::new(surface, sampler, self.sources, self.min_limb))
        };
        let (source, target) = rayon::join(|| shape(pair.source), || shape(pair.target));
        Ok([source?, target?])
    }

    /// The proposal for two surfaces whose triangles point the same way.
    fn find(&self, pair: TransferPair<'_>, [source, target]: [Shape; 2], work: Work<'_>) -> Result<Proposal> {
        let fit = nested("fit", &self.fit, "nonrigid_fit")?;
        let [simplifying, fitting] = work.parts(COSTS_OF_FITS);
        let proxies = debug_span!("proxies").in_scope(|| Proxies::new(pair, self.fit_vertices, fit))?;
        simplifying.done(1.0);
        let wanted = Wanted {
            in_limb: self.points_per_limb,
            max_distance: self.max_distance,
            max_misfit: self.limits.distance,
            between: self.points_between,
        };
        let reader = Reader { wanted, pair, source: &source, target: &target, proxies: &proxies };
        let given = pair.markers.len();
        // The first limits mostly do.
        let [first, second, last] = fitting.parts([0.9, 0.05, 0.05]);
        for (limits, least, work) in [(self.limits, 0.0, first), (self.limits.of_other_poses(), MIN_OTHER_POSE, second)]
        {
            let mut matches = matches(&source, &target, limits);
            matches.retain(|found| found.pairs.len() >= MIN_COUNT);
            let readings = reader.readings(&matches, work)?;
            let is_enough = |best: &Reading<'_>| best.pairs.len() >= given + MIN_COUNT && best.agreement() >= least;
            if readings.first().is_some_and(is_enough) {
                return Ok(proposal(&source, &target, &matches, readings, given));
            }
        }
        let alike = alike(&source, &target);
        let readings = reader.readings(&alike, last)?;
        if readings.first().is_some_and(|best| best.pairs.len() >= given + MIN_COUNT && best.agreement() >= MIN_ALIKE) {
            return Ok(proposal(&source, &target, &alike, readings, given));
        }
        check_limbs("source", &source)?;
        check_limbs("target", &target)?;
        Err(Error::data(
            format!("fewer than {MIN_COUNT} points of the source were found on the target"),
            "these two share too few limbs, or are of different kinds; corresponding points by hand say what is what",
        ))
    }
}

fn check_limbs(side: &str, shape: &Shape) -> Result<()> {
    let found = shape.limbs.len();
    if found >= MIN_COUNT {
        return Ok(());
    }
    Err(Error::data(
        format!(
            "the {side} has {found} limbs, as legs, arms, necks or tails: expected at least {MIN_COUNT}, or two shapes without limbs \
             that lie alike, as faces cut at the same place"
        ),
        "corresponding points by hand say what is what",
    ))
}

/// Whether the triangles of one of two shapes point inwards.
fn are_opposite([source, target]: &[Shape; 2]) -> bool {
    let volumes = [source.cloud.volume, target.cloud.volume];
    volumes[0] * volumes[1] < 0.0 && volumes.iter().all(|volume| volume.abs() > MIN_VOLUME)
}

/// The surface with its triangles turned round.
fn turned(surface: &Surface) -> Surface {
    let mut turned = surface.clone();
    turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    turned
}

/// The marker on a target whose triangles are turned round.
fn turned_marker(marker: &Marker) -> Marker {
    let target = match marker.target {
        SurfacePoint::Triangle(triangle, [a, b, c]) => SurfacePoint::Triangle(triangle, [a, c, b]),
        vertex => vertex,
    };
    Marker { target, ..marker.clone() }
}
