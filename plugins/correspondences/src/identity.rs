//! Pairs triangles of one number: the same mesh, or two of the same topology.

use std::collections::HashSet;

use mimesh_core::{
    Error, Result,
    mesh::SurfacePoint,
    register,
    stage::{Correspondence, TransferPair, TriangleMap},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Correspondence: Identity);

/// Each target triangle moves like the source triangle of the same number: for meshes of one topology.
///
/// The corners of a triangle may be listed in another order, as after turning a mesh inside out.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Identity {}

#[typetag::serde(name = "identity")]
impl Correspondence for Identity {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        self.check(pair)?;
        let (source, target) = (pair.source, pair.target);
        let triangles = (0..source.triangle_count() as u32).map(Some).collect();
        let map = TriangleMap { source_triangle_count: source.triangle_count(), triangles, ..TriangleMap::default() };
        let partners = partners(pair);
        if source.triangles.iter().zip(&target.triangles).all(|(s, t)| has_same_order(s, t, &partners)) {
            return Ok(map);
        }
        // Corners of one number are not one corner, so that it must be told which are.
        let mut points = vec![None; target.vertex_count()];
        for (a, b) in source.vertex_of.iter().zip(&target.vertex_of) {
            if let (&Some(a), &Some(b)) = (a, b) {
                points[b as usize].get_or_insert(SurfacePoint::Vertex(a));
            }
        }
        Ok(TriangleMap { points, ..map })
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        let (source, target) = (&pair.source.triangles, &pair.target.triangles);
        let partners = partners(pair);
        let is_same = |(s, t): (&[u32; 3], &[u32; 3])| {
            let are_partners = |a: u32, b: u32| partners.contains(&(a, b));
            let has_partner = |a: &u32| t.iter().any(|b| are_partners(*a, *b));
            has_same_order(s, t, &partners)
                || (s.iter().all(has_partner) && t.iter().all(|b| s.iter().any(|a| are_partners(*a, *b))))
        };
        let differs = source.iter().zip(target).position(|pair| !is_same(pair));
        if source.len() != target.len() || differs.is_some() {
            let place = differs.map_or_else(String::new, |t| format!(", and triangle {t} (from 0) differs"));
            return Err(Error::data(
                format!(
                    "source and target have {} and {} triangles{place}: expected one topology",
                    source.len(),
                    target.len()
                ),
                "use `correspondence: { type: nearest }` for meshes that lie on each other, and `{ type: nonrigid_fit }` with markers \
                 for others",
            ));
        }
        Ok(())
    }
}

/// The vertices of both surfaces that any vertex of the files became: seams may be welded on one side only.
fn partners(pair: TransferPair<'_>) -> HashSet<(u32, u32)> {
    let both = pair.source.vertex_of.iter().zip(&pair.target.vertex_of);
    both.filter_map(|(source, target)| Some(((*source)?, (*target)?))).collect()
}

/// Whether corners of one number are partners.
fn has_same_order(source: &[u32; 3], target: &[u32; 3], partners: &HashSet<(u32, u32)>) -> bool {
    source.iter().zip(target).all(|(&a, &b)| partners.contains(&(a, b)))
}
