use std::fmt::Debug;

use serde::{Deserialize, Serialize};

use super::{Marker, TransferPair, Work};
use crate::{Figures, Result, mesh::SurfacePoint};

/// Proposes corresponding points of two surfaces, so that nobody has to pick them.
///
/// The surfaces need not share size, place or axes. The markers of the pair are those that the user has picked so far, perhaps none.
///
/// # Contract
///
/// `testkit::contracts` holds implementations to this:
/// - points exist on their surfaces, and no two pairs share a point of either side;
/// - confidences are finite and lie in 0 to 1;
/// - the user's markers come first, as they are and with confidence 1;
/// - equal inputs give equal pairs, on one thread or many;
/// - what is refused is an error with a way out: a few wrong pairs do more harm than none.
#[typetag::serde(tag = "type")]
pub trait Landmarks: Debug + Send + Sync {
    /// Pairs of corresponding points of the rest surfaces of `pair`.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range, [`Error::Data`](crate::Error::Data) for surfaces between
    /// which no pairs are found that can be trusted.
    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal>;

    /// [`propose`](Self::propose), for methods that take long: they report to `work` how much is done.
    ///
    /// # Errors
    ///
    /// The errors of [`propose`](Self::propose).
    fn propose_watched(&self, pair: TransferPair<'_>, _work: Work<'_>) -> Result<Proposal> {
        self.propose(pair)
    }

    /// The place where one more click would help most, where the markers of `pair` are those that are known so far; `None` where the
    /// stage cannot tell.
    ///
    /// # Errors
    ///
    /// As [`propose`](Self::propose).
    fn suggest(&self, _pair: TransferPair<'_>) -> Result<Option<Suggestion>> {
        Ok(None)
    }

    /// The program that the stage runs, with its arguments; `None` for a stage that computes by itself.
    ///
    /// A pipeline runs such a stage only where the user allows commands, and never to check or to plan. Its answers need not be equal.
    fn command(&self) -> Option<&[String]> {
        None
    }
}

crate::stage_kind!(Landmarks, "landmarks");

/// What a stage [`Landmarks`] proposes.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Proposal {
    /// The pairs that are likeliest right.
    pub pairs: Vec<ProposedPair>,
    /// Other readings of the two shapes, likeliest first, for who can compare what comes of them; may be empty.
    pub others: Vec<Vec<ProposedPair>>,
    /// What was found.
    pub figures: Figures,
}

/// Two points that are proposed to correspond.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct ProposedPair {
    /// The points, with a name for messages.
    #[serde(flatten)]
    pub marker: Marker,
    /// How sure the pair is, from 0 to 1: it ranks pairs, and is no probability.
    pub confidence: f64,
}

/// A point that a person should click next.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Suggestion {
    /// The point of the source.
    pub source: SurfacePoint,
    /// Where its partner probably is.
    pub target: Option<SurfacePoint>,
    /// How far fits from both sides disagree around it, relative to the diagonal of the source; `None` if the points that are known are
    /// too few for a fit.
    pub doubt: Option<f64>,
}

impl ProposedPair {
    /// A marker of the user's, which is right by definition.
    pub fn clicked(marker: &Marker) -> Self {
        Self { marker: marker.clone(), confidence: 1.0 }
    }
}

impl Proposal {
    /// The points of the pairs, without confidences.
    pub fn markers(&self) -> Vec<Marker> {
        self.pairs.iter().map(|pair| pair.marker.clone()).collect()
    }

    /// Checks that all points exist, that no two pairs share one, and that confidences lie in 0 to 1, in every reading.
    ///
    /// # Errors
    ///
    /// [`Error::Data`](crate::Error::Data) that names the pair.
    pub fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        for pairs in std::iter::once(&self.pairs).chain(&self.others) {
            let markers: Vec<_> = pairs.iter().map(|pair| pair.marker.clone()).collect();
            TransferPair { markers: &markers, ..pair }.check_markers()?;
            if let Some(wrong) = pairs.iter().find(|pair| !(0.0..=1.0).contains(&pair.confidence)) {
                return Err(crate::Error::data(
                    format!(
                        "landmark {}: expected a confidence of 0 to 1, found {}",
                        wrong.marker.name, wrong.confidence
                    ),
                    "this is a fault of the stage that proposes landmarks; pick markers by hand instead",
                ));
            }
        }
        Ok(())
    }
}
