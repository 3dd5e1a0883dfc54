//! The clicks and nothing else.

use mimesh_core::{
    Error, Result, register,
    stage::{Landmarks, Proposal, ProposedPair, TransferPair},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Landmarks: Given);

/// The points that were clicked, and no others.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Given {}

#[typetag::serde(name = "given")]
impl Landmarks for Given {
    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal> {
        mimesh_core::mesh::check_finite(&pair.source.positions)?;
        mimesh_core::mesh::check_finite(&pair.target.positions)?;
        pair.check_markers()?;
        if pair.markers.is_empty() {
            let hint = "name their file, e.g. `markers: { type: given, clicks: pairs.yaml }`, or take another type";
            return Err(Error::data("there are no clicks to give", hint));
        }
        Ok(Proposal { pairs: pair.markers.iter().map(ProposedPair::clicked).collect(), ..Proposal::default() })
    }
}
