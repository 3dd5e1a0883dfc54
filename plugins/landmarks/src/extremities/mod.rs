//! Limbs, and the points at their ends.
//!
//! Points are spread evenly over each surface and linked where they are near and do not face each other, whatever the components. Limbs
//! are persistent maxima of the mean distance along these links, as in Hilaga et al. 2001 and Tierny et al. 2006. Under each of the 24
//! turns that take axes to axes the limbs of the two surfaces are assigned to each other, by their places in the bounding box and by
//! mean distance. Pairs whose distances to the others differ are dropped, and the turn that fits best is taken. In each pair of limbs
//! the points that correspond are those that are mutually nearest when the limbs fill the same box.
//!
//! About one second a mesh, whatever its density. Prefer clicks where shapes have no limbs, as faces, or other ones.

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
mod tips;
mod turn;

use mimesh_core::{
    Error, Result,
    plugin::{check_ranges, configured, nested},
    register,
    stage::{Correspondence, Landmarks, Proposal, Sampler, TransferPair},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

pub use self::matching::Limits;
use self::{comparison::Proxies, matching::matches, place::alike, proposal::proposal, reading::Reader, shape::Shape};

register!(Landmarks: Extremities);

/// The ends of limbs such as legs, arms, necks and tails, for shapes that have at least four of them.
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
    /// Most points between limbs, where the fits of two shapes agree nearly everywhere.
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

/// Fewer limbs, or fewer pairs of points, say too little of how two shapes correspond.
const MIN_COUNT: usize = 4;

/// Shapes without limbs are taken to lie alike where fits agree at least so far.
const MIN_ALIKE: f64 = 0.75;

/// Volumes that are smaller, relative to the area to the power 3/2, tell nothing of which side is out.
const MIN_VOLUME: f64 = 1e-3;

#[typetag::serde(name = "extremities")]
impl Landmarks for Extremities {
    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal> {
        check_ranges(self)?;
        pair.check_markers()?;
        let sampler = nested("sampler", &self.sampler, "poisson_disk")?;
        let shape = |surface| Shape::new(surface, sampler, self.sources, self.min_limb);
        let (source, target) = (shape(pair.source)?, shape(pair.target)?);
        check_sides(&source, &target)?;
        let fit = nested("fit", &self.fit, "nonrigid_fit")?;
        let proxies = Proxies::new(pair, self.fit_vertices, fit)?;
        let reader = Reader { settings: self, pair, source: &source, target: &target, proxies: &proxies };
        let given = pair.markers.len();
        let mut matches = matches(&source, &target, self.limits);
        matches.retain(|found| found.pairs.len() >= MIN_COUNT);
        let readings = reader.readings(&matches)?;
        if readings.first().is_some_and(|best| best.pairs.len() >= given + MIN_COUNT) {
            return Ok(proposal(&source, &target, &matches, readings, given));
        }
        let alike = alike(&source, &target);
        let readings = reader.readings(&alike)?;
        if readings.first().is_some_and(|best| best.pairs.len() >= given + MIN_COUNT && best.agreement() >= MIN_ALIKE) {
            return Ok(proposal(&source, &target, &alike, readings, given));
        }
        check_limbs("source", &source)?;
        check_limbs("target", &target)?;
        Err(Error::data(
            format!("fewer than {MIN_COUNT} points of the source were found on the target"),
            "are both meshes of one kind, in similar poses? If so, give markers by hand: these two share too few limbs",
        ))
    }
}

fn check_limbs(side: &str, shape: &Shape) -> Result<()> {
    let found = shape.limbs.len();
    if found >= MIN_COUNT {
        return Ok(());
    }
    Err(Error::data(
        format!("the {side} has {found} limbs: expected at least {MIN_COUNT}, as legs, arms, necks or tails"),
        "give markers by hand: a file of corresponding points",
    ))
}

/// Refuses shapes one of which is turned inside out, as a mirror image whose triangles were not turned is.
fn check_sides(source: &Shape, target: &Shape) -> Result<()> {
    let volumes = [source.cloud.volume, target.cloud.volume];
    if volumes[0] * volumes[1] < 0.0 && volumes.iter().all(|volume| volume.abs() > MIN_VOLUME) {
        let inwards = if volumes[0] < 0.0 { "source" } else { "target" };
        return Err(Error::data(
            format!("the triangles of the {inwards} point inwards, those of the other surface outwards"),
            "if the target is a mirror image of the source, say so with `target: { mirrored: x }`; else turn the triangles round",
        ));
    }
    Ok(())
}
