//! The verdict on landmarks that a stage proposed.

use mimesh_core::stage::{Proposal, ProposedPair};

use super::verdict::{Level, Reason};

/// Half of the pairs have at least this confidence, or the landmarks are doubtful.
const MIN_CONFIDENCE: f64 = 0.25;

/// Below this agreement of fits forwards and backwards nothing matches. Right pairs have 0.37 and more.
const MIN_AGREEMENT: f64 = 0.15;

/// How many of the least sure pairs are named.
const MAX_NAMES: usize = 4;

/// Why the pairs of `proposal` are doubtful: the stage warns of them, or is not sure of half of them; bad if its fits agree on nothing.
/// `None` if they are neither.
pub fn landmark_doubt(proposal: &Proposal) -> Option<Reason> {
    let mut pairs: Vec<&ProposedPair> = proposal.pairs.iter().collect();
    pairs.sort_by(|a, b| a.confidence.total_cmp(&b.confidence));
    let median = pairs.get(pairs.len() / 2)?.confidence;
    if proposal.figures.warnings.is_empty() && median >= MIN_CONFIDENCE {
        return None;
    }
    let names: Vec<&str> = pairs.iter().take(MAX_NAMES).map(|pair| pair.marker.name.as_str()).collect();
    let names = names.join(", ");
    let note = format!(
        "the landmarks were found by shape and are doubtful (confidence {median:.2} in the middle), first of all {names}: \
         look at their numbers on both meshes; click points where they are wrong or missing and give the file as `clicks`; or turn the \
         target as the source stands"
    );
    Some(Reason {
        level: match proposal.figures.number("agreement") {
            Some(agreement) if agreement < MIN_AGREEMENT => Level::Bad,
            _ => Level::Doubtful,
        },
        metric: "landmarks".into(),
        statistic: "confidence".into(),
        about: Some(names),
        value: Some(median),
        limit: MIN_CONFIDENCE,
        note: Some(note),
    })
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        Figures,
        stage::{Marker, Proposal},
    };

    use super::*;
    use mimesh_core::mesh::SurfacePoint;

    fn proposal(confidences: &[f64], warnings: &[&str]) -> Proposal {
        let pair = |(i, &confidence): (usize, &f64)| {
            let point = SurfacePoint::Vertex(i as u32);
            ProposedPair { marker: Marker { name: format!("p{i}"), source: point, target: point }, confidence }
        };
        let mut figures = Figures::default();
        warnings.iter().for_each(|warning| figures.warn(*warning));
        Proposal { pairs: confidences.iter().enumerate().map(pair).collect(), figures, ..Proposal::default() }
    }

    #[test]
    fn landmarks_are_doubtful_by_their_confidence_or_by_a_warning() {
        assert!(landmark_doubt(&proposal(&[0.9, 0.1, 0.8], &[])).is_none());
        let unsure = landmark_doubt(&proposal(&[0.9, 0.1, 0.0, 0.2], &[])).unwrap();
        assert_eq!((unsure.level, unsure.about.as_deref()), (Level::Doubtful, Some("p2, p1, p3, p0")));
        let warned = landmark_doubt(&proposal(&[0.9, 0.8, 0.7], &["it fits as well when it is turned"])).unwrap();
        assert!(warned.words().contains("doubtful") && warned.words().contains("p2, p1, p0"), "{}", warned.words());
        assert!(landmark_doubt(&proposal(&[], &[])).is_none());
    }
}
