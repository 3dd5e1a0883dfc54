//! Pairs triangles that lie together at rest.

use mimesh_core::{
    Figures, Result,
    operators::vertex_normals,
    plugin::check_ranges,
    register,
    stage::{Correspondence, TransferPair, TriangleMap},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{facing::Facing, sides::keep_sides};

register!(Correspondence: Nearest);

/// Each target triangle moves like the source triangle closest to it at rest, among those that face the same way.
///
/// It suits meshes that already lie on each other: another resolution of one shape, or clothes on a body. A vertex that lies on the
/// source, to 1e-6 of the diagonal, stays there whichever way it faces.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Nearest {
    /// Target triangles whose barycentre is farther from the source than this are orphans, in diagonals of the target.
    #[schemars(range(min = 0.0))]
    pub max_distance: f64,
}

/// Points nearer to the source than this lie on it, in diagonals of the target.
///
/// Decimation turns triangles over in tight corners such as those of a mouth, and what faces the same way there is the other lip.
const COINCIDENT: f64 = 1e-6;

impl Default for Nearest {
    fn default() -> Self {
        Self { max_distance: 0.1 }
    }
}

#[typetag::serde(name = "nearest")]
impl Correspondence for Nearest {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        check_ranges(self)?;
        let (source, target) = (pair.source, pair.target);
        let diagonal = target.diagonal();
        let facing = Facing::new(&source.positions, &source.triangles)?.with_coincident(COINCIDENT * diagonal);
        let limit = self.max_distance * diagonal;
        let normals = vertex_normals(&target.positions, &target.triangles);
        let mut points = facing.points(&target.positions, &normals, limit, &[]);
        keep_sides(pair, &target.positions, &facing, limit, &mut points);
        let triangles = facing.triangles(&target.positions, &target.triangles, limit, &points);
        let mut figures = Figures::default();
        figures.set("vertices_with_a_point", points.iter().flatten().count());
        Ok(TriangleMap { source_triangle_count: source.triangle_count(), triangles, points, figures })
    }
}
