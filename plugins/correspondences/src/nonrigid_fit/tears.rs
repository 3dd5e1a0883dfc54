//! Edges of the target whose ends lie far apart along the source.

use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint, diagonal},
    spatial::{DistanceSearch, SurfaceDistance},
    stage::ProximityGraph,
};
use nalgebra::Point3;

/// How much longer than on the target a way along the source may be before it counts.
const STRETCH: f64 = 2.0;

/// What is beyond that counts in full from this length on, in diagonals of the source.
const TEAR: f64 = 0.02;

/// Measures edges of the target along the source, both in the unit frame.
pub struct Tears<'a> {
    distance: SurfaceDistance<'a>,
    /// The length beyond the allowed one from which an edge is torn.
    tear: f64,
}

impl<'a> Tears<'a> {
    /// Prepares for a source with its vertices at `positions`, gaps between whose components are bridged.
    ///
    /// # Errors
    ///
    /// The errors of [`ProximityGraph::bridges`].
    pub fn new(source: &'a Surface, positions: &'a [Point3<f64>]) -> Result<Self> {
        let distance = SurfaceDistance::new(source, positions, &ProximityGraph::bridges(source)?);
        Ok(Self { distance, tear: TEAR * diagonal(positions) })
    }

    /// How badly an edge of that `length` is torn if its ends lie at `p` and `q`: from 0 for not at all to 1.
    ///
    /// It is min(1, max(0, g − 2 l − h) / 0.02 D′), with g the distance along the source, h the longest edge of the two triangles and
    /// D′ the source's diagonal.
    pub fn of_edge(&self, length: f64, p: &SurfacePoint, q: &SurfacePoint, search: &mut DistanceSearch) -> f64 {
        let allowed = STRETCH * length + self.longest_edge(p).max(self.longest_edge(q));
        if self.distance.bound(p, q) <= allowed {
            return 0.0;
        }
        let distance = self.distance.between(p, q, allowed + self.tear, search);
        ((distance - allowed) / self.tear).clamp(0.0, 1.0)
    }

    /// Memory for searches.
    pub fn search(&self) -> DistanceSearch {
        self.distance.search()
    }

    /// Finds the vertices of the source nearer to `centre` than `radius`.
    pub fn ball(&self, centre: &SurfacePoint, radius: f64, search: &mut DistanceSearch) {
        self.distance.ball(centre, radius, search);
    }

    /// The longest edge of the triangle of a point; 0 for a vertex.
    pub fn longest_edge(&self, point: &SurfacePoint) -> f64 {
        self.distance.longest_edge(point)
    }
}
