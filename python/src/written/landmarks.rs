//! Landmarks.

use std::sync::Arc;

use mimesh_core::{
    Figures, Result,
    mesh::check_finite,
    register,
    stage::{Landmarks, Marker, Proposal, ProposedPair, TransferPair},
};
use pyo3::types::PyAnyMethods;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use super::call::{Written, marker_pairs, surface};
use crate::surface::{PointParts, point};

register!(Landmarks: PythonLandmarks);

/// A landmarks that is written in Python; its own name says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PythonLandmarks {
    /// The name under which its class is registered.
    pub class: String,
    /// The settings of the class.
    pub settings: Map<String, Value>,
}

/// As pipelines have it, under its own name.
impl Serialize for PythonLandmarks {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.settings.serialize(serializer)
    }
}

impl PythonLandmarks {
    fn written(&self) -> Written<'_> {
        Written { kind: "landmarks", class: &self.class, settings: &self.settings }
    }
}

#[typetag::deserialize(name = "python")]
impl Landmarks for PythonLandmarks {
    fn typetag_name(&self) -> &'static str {
        self.written().name()
    }

    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal> {
        check_finite(&pair.source.positions)?;
        check_finite(&pair.target.positions)?;
        pair.check_markers()?;
        let (source, target) = (Arc::new(pair.source.clone()), Arc::new(pair.target.clone()));
        let found: Vec<(PointParts, PointParts, f64)> = self.written().call(|py, stage| {
            let helper = py.import("mimesh._surface")?.getattr("propose")?;
            let arguments = (stage, surface(py, &source)?, surface(py, &target)?, marker_pairs(pair.markers));
            helper.call1(arguments)?.extract()
        })?;
        let clicked = pair.markers.iter().map(ProposedPair::clicked);
        let proposed = found.into_iter().enumerate().map(|(i, (source, target, confidence))| ProposedPair {
            marker: Marker { name: format!("{i}"), source: point(source), target: point(target) },
            confidence,
        });
        let proposal =
            Proposal { pairs: clicked.chain(proposed).collect(), others: vec![], figures: Figures::default() };
        proposal.check(pair)?;
        Ok(proposal)
    }
}
