//! The vertices that lie farthest along each axis, forwards and backwards, for meshes that share their axes.

use mimesh_core::{
    Figures, Result,
    mesh::{Surface, SurfacePoint, check_finite},
    plugin::check_ranges,
    register,
    stage::{Landmarks, Marker, Proposal, ProposedPair, TransferPair},
};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Landmarks: MyStage);

/// The vertices that lie farthest along each axis, forwards and backwards.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {
    /// The confidence of each pair.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub confidence: f64,
}

impl Default for MyStage {
    fn default() -> Self {
        Self { confidence: 0.5 }
    }
}

#[typetag::serde(name = "my_stage")]
impl Landmarks for MyStage {
    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal> {
        check_ranges(self)?;
        check_finite(&pair.source.positions)?;
        check_finite(&pair.target.positions)?;
        pair.check_markers()?;
        // The user's markers come first.
        let given = |marker: &Marker| ProposedPair { marker: marker.clone(), confidence: 1.0 };
        let mut pairs: Vec<ProposedPair> = pair.markers.iter().map(given).collect();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            for (sign, way) in [(1.0, "high"), (-1.0, "low")] {
                let direction = Vector3::ith(axis, sign);
                let [source, target] = [pair.source, pair.target].map(|surface| farthest(surface, direction));
                // A point has one partner only.
                let is_new = |other: &ProposedPair| other.marker.source != source && other.marker.target != target;
                if pairs.iter().all(is_new) {
                    let marker = Marker { name: format!("{name}-{way}"), source, target };
                    pairs.push(ProposedPair { marker, confidence: self.confidence });
                }
            }
        }
        let mut figures = Figures::default();
        figures.set("pairs", pairs.len());
        Ok(Proposal { pairs, others: vec![], figures })
    }
}

/// The vertex of `surface` that lies farthest along `direction`, the first of several.
fn farthest(surface: &Surface, direction: Vector3<f64>) -> SurfacePoint {
    let along = |v: usize| surface.positions[v].coords.dot(&direction);
    let best = (0..surface.vertex_count()).reduce(|best, v| if along(v) > along(best) { v } else { best });
    SurfacePoint::Vertex(best.unwrap_or(0) as u32)
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn a_longer_capsule_keeps_its_poles() {
        let (source, target) = (meshes::capsule(12, 4, 2.0), meshes::capsule(16, 6, 5.0));
        let pair = TransferPair { source: &source, target: &target, markers: &[], proximity: None };
        let pairs = MyStage::default().propose(pair).unwrap().pairs;
        let top = pairs.iter().find(|pair| pair.marker.name == "y-high").unwrap();
        assert_eq!(top.marker.source.position(&source, &source.positions).y, 3.0);
        assert_eq!(top.marker.target.position(&target, &target.positions).y, 6.0);
    }
}
