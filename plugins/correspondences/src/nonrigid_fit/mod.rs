//! Deforms the target onto the source and pairs triangles that then lie together.
//!
//! Minimises, over the deformed vertices x of the target,
//!
//! E = w_S E_S + w_I E_I + w_C E_C + w_R E_R  subject to x = marker positions,
//!
//! E_S = Σ over adjacent triangles ‖F_a − F_b‖², E_I = Σ ‖F_a − I‖², E_C = Σ over vertices with a valid closest point
//! ‖x_i − c_i‖² (Sumner and Popović 2004, eqs. 8–11; Zhou et al. 2010, eq. 3), F being the deformation gradient with the
//! fourth vertex, which stays an unknown here because F is compared between triangles of different planes. E_R (eq. 4, in
//! `link_elements`) lets linked components follow each other, where the pair has a proximity graph.
//!
//! Departures from the papers:
//! - the source is first brought to the place and size of the target by the similarity that the markers say, and both are
//!   scaled to a diagonal of 1;
//! - E_I and E_C are means over the area, times the numbers of triangles and vertices of a usual mesh (40,000 and 20,000),
//!   because E_S does not grow with the number of triangles either: so weights mean the same at any resolution, and a finely
//!   meshed face does not outweigh a leg (`weighting: uniform` for plain sums);
//! - the search for closest points skips triangles that face away, instead of dropping vertices whose nearest point does; inner
//!   sides of the parts of a target of several components take the closest point whichever way it faces;
//! - a small component that has come to lie on two sides of the source, as a plate between the legs, moves to one (`patches`);
//! - triangles without area have no gradient, and links between coplanar components hold no place: ties of two vertices stand in
//!   (`ties`);
//! - Zhou et al. print the rule for pairs the wrong way round (end of 2.2): here a triangle with a marker or a valid closest
//!   point has a partner, and one without is an orphan;
//! - E_R takes at most `link_pairs` vertex pairs a link, and its weight w_R is a setting;
//! - beside partners of triangles, the map tells the source point under each vertex;
//! - a large target is fitted by a simplified one, which it then follows (`proxy`).
//!
//! Cost: one symbolic and 1 + `steps` numeric factorisations of a matrix of #V + #F of the target, or of its proxy.

mod elements;
mod link_elements;
mod markers;
mod patches;
mod proxy;
mod tears;
mod ties;
mod unit_frame;
mod weighting;

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
    operators::vertex_normals,
    plugin::check_ranges,
    register,
    spatial::Orientation,
    stage::{Correspondence, TransferPair, TriangleMap, Work},
};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::{Span, debug_span};

pub use self::weighting::Weighting;
use self::{
    elements::{Elements, EnergyWeights, System},
    patches::{Points, Settled},
    proxy::Proxy,
    unit_frame::UnitFrame,
};
use crate::{facing::Facing, sides::keep_sides};

register!(Correspondence: NonrigidFit);

/// What goes before the steps and what comes after them cost, in steps.
const SETTING_UP: f64 = 6.0;
const PAIRING: f64 = 0.5;

/// Deforms the target onto the source, guided by markers and closest points, and pairs triangles that then lie together
/// (Sumner and Popović 2004; Zhou et al. 2010, section 2.2).
///
/// It suits two shapes of any topology, with a dozen markers or more. Every component of the target needs a marker, or links by
/// `proximity:` to one that has.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct NonrigidFit {
    /// w_S: how alike the deformation of neighbouring triangles is kept. Only ratios of weights matter.
    #[schemars(range(min = 1e-12))]
    pub smoothness: f64,
    /// w_I: how little triangles change at all. The papers' 0.001 is for meshes of no stated size; ten times that measures
    /// better in the unit frame.
    #[schemars(range(min = 1e-12))]
    pub identity: f64,
    /// How strongly linked components follow each other (E_R), relative to `smoothness` and `identity`; 1 as in the paper.
    #[schemars(range(min = 0.0))]
    pub proximity: f64,
    /// How triangles and vertices count in E_I and E_C.
    pub weighting: Weighting,
    /// Most vertex pairs of a link that count in E_R: three fix a rigid motion. Many say the same, fill the matrix, and hold parts
    /// more stiffly to each other; `~` takes all, as in the paper.
    #[schemars(range(min = 1))]
    pub link_pairs: Option<usize>,
    /// w_C in the first and in the last step with closest points; it grows geometrically in between.
    #[schemars(inner(range(min = 0.0)))]
    pub closest: [f64; 2],
    /// Number of steps with closest points, each with a search and a solve; 0 leaves the fit to the markers.
    #[schemars(range(max = 100))]
    pub steps: usize,
    /// Closest points farther away than this are not valid, in diagonals of the target.
    #[schemars(range(min = 0.0))]
    pub max_distance: f64,
    /// On targets of several components, a vertex whose valid point lies this much deeper than the closest point of all, in
    /// diagonals of the target, is taken for an inner side, as of a plate or a pebble: the source has none, and the vertex
    /// takes the closest point whichever way it faces.
    #[schemars(range(min = 0.0))]
    pub inner_depth: f64,
    /// A target of more vertices is fitted by a simplified proxy and then follows it; `~` fits targets of any size themselves.
    pub proxy_above: Option<usize>,
    /// About how many vertices a proxy has. More take longer, and differ less from a fit of the target itself.
    #[schemars(range(min = 100))]
    pub proxy_vertices: usize,
    /// How source and target are turned to each other at rest.
    pub orientation: Orientation,
}

impl Default for NonrigidFit {
    fn default() -> Self {
        Self {
            smoothness: 1.0,
            identity: 0.01,
            proximity: 1.0,
            weighting: Weighting::Area,
            link_pairs: Some(6),
            closest: [1.0, 5000.0],
            steps: 10,
            max_distance: 0.05,
            inner_depth: 0.003,
            proxy_above: Some(150_000),
            proxy_vertices: 50_000,
            orientation: Orientation::Auto,
        }
    }
}

#[typetag::serde(name = "nonrigid_fit")]
impl Correspondence for NonrigidFit {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        self.correspond_watched(pair, Work::UNWATCHED)
    }

    fn correspond_watched(&self, pair: TransferPair<'_>, work: Work<'_>) -> Result<TriangleMap> {
        self.check(pair)?;
        let [setting_up, fitting, pairing] = work.parts([SETTING_UP, 1.0 + self.steps as f64, PAIRING]);
        let pair = self.linked(pair);
        let (source, target) = (pair.source, pair.target);
        let unit = UnitFrame::new(pair, self.orientation);
        let proxy = debug_span!("proxy").in_scope(|| self.proxy(pair, &unit))?;
        let unit_of_proxy = proxy.as_ref().map(|proxy| proxy.unit(&unit));
        let fitted_unit = unit_of_proxy.as_ref().unwrap_or(&unit);
        let fitted_pair = proxy.as_ref().map_or(pair, |proxy| proxy.pair(pair));
        let elements = Elements::new(&fitted_unit.target, fitted_pair.target);
        // Neither needs the other.
        let span = Span::current();
        let (facing, system) = rayon::join(
            || debug_span!(parent: &span, "search tree").in_scope(|| Facing::new(&unit.source, &source.triangles)),
            || {
                let span = debug_span!(parent: &span, "system");
                span.in_scope(|| elements.system(self.energy_weights(), fitted_pair, fitted_unit))
            },
        );
        let (mut facing, system) = (facing?, system?);
        if target.components().count() > 1 {
            facing = facing.with_inner_sides(self.inner_depth);
        }
        setting_up.done(1.0);
        let mut system = system;
        let (fit, guesses) = self.fit(fitted_pair, fitted_unit, &facing, &mut system, fitting)?;
        let mut figures = Figures::default();
        figures.set("smoothness_energy", elements.smoothness_energy(&system));
        if elements.skipped() > 0 {
            figures.set("triangles_skipped", elements.skipped());
        }
        drop(system);
        let (fit, mut points) = match &proxy {
            Some(proxy) => {
                figures.set("proxy_vertices", proxy.vertex_count());
                let carried = debug_span!("proxy").in_scope(|| proxy.carry(&unit.target, &fit));
                let mut points = self.closest(&facing, &carried, target, &[]);
                self.find_lost(&facing, &carried, &proxy.normals(&fit), &mut points);
                (carried, points)
            }
            None => {
                let points = self.closest(&facing, &fit, target, &guesses);
                (fit, points)
            }
        };
        keep_sides(pair, &fit, &facing, self.max_distance, &mut points);
        measure(pair, &unit, &fit, &points, &mut figures);
        let mut valid: Vec<bool> = points.iter().map(Option::is_some).collect();
        for marker in pair.markers {
            marker.target.corners(target).iter().for_each(|&(v, _)| valid[v as usize] = true);
            if let SurfacePoint::Vertex(vertex) = marker.target {
                points[vertex as usize] = Some(marker.source);
            }
        }
        let mut triangles =
            debug_span!("partners").in_scope(|| facing.triangles(&fit, &target.triangles, f64::INFINITY, &points));
        pairing.done(0.5);
        for (partner, t) in triangles.iter_mut().zip(&target.triangles) {
            *partner = partner.filter(|_| t.iter().any(|&v| valid[v as usize]));
        }
        let settled = Settled { pair, unit: &unit, facing: &facing, fit: &fit, max_distance: self.max_distance };
        let moves = debug_span!("patches").in_scope(|| settled.moves(&points))?;
        moves.iter().for_each(|moved| moved.apply(&settled, &mut points, &mut triangles));
        patches::report(&moves, target, &mut figures);
        Ok(TriangleMap { source_triangle_count: source.triangle_count(), triangles, points, figures })
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        check_ranges(self)?;
        markers::check(self.linked(pair))
    }

    fn markers_needed(&self) -> usize {
        markers::MIN_MARKERS
    }
}

impl NonrigidFit {
    /// The pair without its proximity if that is not to count.
    fn linked<'a>(&self, pair: TransferPair<'a>) -> TransferPair<'a> {
        if self.proximity > 0.0 { pair } else { TransferPair { proximity: None, ..pair } }
    }

    /// The proxy that is fitted in place of the target, if it is large.
    fn proxy(&self, pair: TransferPair<'_>, unit: &UnitFrame) -> Result<Option<Proxy>> {
        match self.proxy_above {
            Some(most) if pair.target.vertex_count() > most => Proxy::new(pair, unit, self.proxy_vertices),
            _ => Ok(None),
        }
    }

    /// The deformed target in the unit frame, and the valid source points of its vertices in the last step.
    fn fit(
        &self,
        pair: TransferPair<'_>,
        unit: &UnitFrame,
        facing: &Facing,
        system: &mut System,
        work: Work<'_>,
    ) -> Result<(Vec<Point3<f64>>, Points)> {
        let mut fit = debug_span!("solve").in_scope(|| system.solve(&[]));
        let place = |point: &SurfacePoint| point.position(pair.source, &unit.source);
        let mut points = Points::new();
        for step in 0..self.steps {
            // Vertices move little from step to step.
            points = self.closest(facing, &fit, pair.target, &points);
            let goals: Vec<_> = points.iter().map(|point| point.as_ref().map(place)).collect();
            debug_span!("factorisation").in_scope(|| system.add_targets(self.closest_weight(step), &goals))?;
            fit = debug_span!("solve").in_scope(|| system.solve(&goals));
            work.done((step + 1) as f64 / (self.steps + 1) as f64);
        }
        Ok((fit, points))
    }

    /// The valid source point of each vertex of `target` at `fit`; `guesses` are points that are likely near, or empty.
    fn closest(
        &self,
        facing: &Facing,
        fit: &[Point3<f64>],
        target: &Surface,
        guesses: &[Option<SurfacePoint>],
    ) -> Points {
        debug_span!("closest points")
            .in_scope(|| facing.points(fit, &vertex_normals(fit, &target.triangles), self.max_distance, guesses))
    }

    /// Finds points for vertices that have none, by how a proxy faces there: small triangles may be turned over where it is not.
    fn find_lost(&self, facing: &Facing, fit: &[Point3<f64>], normals: &[Vector3<f64>], points: &mut Points) {
        for (v, point) in points.iter_mut().enumerate().filter(|(_, point)| point.is_none()) {
            let found = facing.find(&fit[v], &normals[v], self.max_distance);
            *point = found.map(|found| SurfacePoint::Triangle(found.triangle, found.barycentric));
        }
    }

    fn energy_weights(&self) -> EnergyWeights {
        let NonrigidFit { smoothness, identity, proximity, weighting, link_pairs, .. } = *self;
        EnergyWeights { smoothness, identity, proximity, weighting, link_pairs }
    }

    /// w_C of a step, geometrically from the first to the last.
    fn closest_weight(&self, step: usize) -> f64 {
        let [first, last] = self.closest;
        let along = step as f64 / (self.steps - 1).max(1) as f64;
        if first > 0.0 && last > 0.0 { first * (last / first).powf(along) } else { first + (last - first) * along }
    }
}

/// Reports how far the target, deformed to `fit`, lies from the source.
fn measure(
    pair: TransferPair<'_>,
    unit: &UnitFrame,
    fit: &[Point3<f64>],
    points: &[Option<SurfacePoint>],
    figures: &mut Figures,
) {
    let place = |point: &SurfacePoint| point.position(pair.source, &unit.source);
    let squares = fit.iter().zip(points).filter_map(|(x, point)| Some((x - place(point.as_ref()?)).norm_squared()));
    let count = points.iter().flatten().count();
    figures.set("vertices_on_the_source", count);
    figures.set("rms_distance_percent", 100.0 * (squares.sum::<f64>() / count.max(1) as f64).sqrt());
    if 2 * count < fit.len() {
        figures.warn(format!(
            "only {count} of {} target vertices came to lie on the source, facing the same way; look whether markers are \
             swapped, whether one mesh is inside out, or give more markers",
            fit.len()
        ));
    }
}
