//! Pairs triangles of one number: the same mesh, or two of the same topology.

use std::collections::HashSet;

use mimesh_core::{
    Error, Result, register,
    stage::{Correspondence, TransferPair, TriangleMap},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Correspondence: Identity);

/// Each target triangle moves like the source triangle of the same number: for meshes of one topology.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Identity {}

#[typetag::serde(name = "identity")]
impl Correspondence for Identity {
    fn correspond(&self, pair: TransferPair<'_>) -> Result<TriangleMap> {
        self.check(pair)?;
        let count = pair.source.triangle_count();
        let triangles = (0..count as u32).map(Some).collect();
        Ok(TriangleMap { source_triangle_count: count, triangles, ..TriangleMap::default() })
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        let (source, target) = (&pair.source.triangles, &pair.target.triangles);
        // Seams may be welded on one side only; corners are one if any vertex of the files became both.
        let both = pair.source.vertex_of.iter().copied().zip(pair.target.vertex_of.iter().copied());
        let same: HashSet<(u32, u32)> = both.collect();
        let is_same = |(s, t): (&[u32; 3], &[u32; 3])| s.iter().zip(t).all(|(&a, &b)| same.contains(&(a, b)));
        let differs = source.iter().zip(target).position(|pair| !is_same(pair));
        if source.len() != target.len() || differs.is_some() {
            let place = differs.map_or_else(String::new, |t| format!(", and triangle {t} (from 0) differs"));
            return Err(Error::data(
                format!(
                    "source and target have {} and {} triangles{place}: expected one topology",
                    source.len(),
                    target.len()
                ),
                "use `correspondence: { type: nonrigid_fit }` with markers for meshes of different topology",
            ));
        }
        Ok(())
    }
}
