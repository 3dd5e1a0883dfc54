//! From matches of limbs to pairs of points, with figures that tell how sure they are.

use mimesh_core::{
    Figures,
    stage::{Marker, Proposal, ProposedPair, TransferPair},
};
use serde_json::json;

use super::{
    Extremities,
    matching::{LimbPair, Match},
    shape::Shape,
    tips::{Tip, tips},
};

/// How many turns beside the best one are told.
const OTHERS: usize = 2;

/// A turn that leads the next by less than this is doubtful.
const SURE_LEAD: f64 = 0.08;

/// Up to the first score shapes fit as animals of one kind do, from the second on as different ones.
const SCORES: [f64; 2] = [0.4, 0.8];

/// A point this near to one of the user's, relative to the diagonal, says nothing new.
const NEAR_MARKER: f64 = 0.02;

/// The pairs of points of the best of `matches`, and of the two after it.
pub fn propose(
    settings: &Extremities,
    pair: TransferPair<'_>,
    source: &Shape,
    target: &Shape,
    matches: &[Match],
) -> Proposal {
    let lead = |k: usize| matches.get(k + 1).map_or(f64::INFINITY, |next| next.score() - matches[k].score());
    let mut readings = matches.iter().take(1 + OTHERS).enumerate().map(|(k, found)| {
        let sure = if k == 0 { sureness(found, lead(0)) } else { 0.0 };
        let tips = found.pairs.iter().map(|&limbs| {
            let (most, reach) = (settings.points_per_limb, settings.max_distance);
            (limbs, tips(source, target, limbs, &found.turn, most, reach))
        });
        let found = tips.flat_map(|(limbs, tips)| named(settings, pair, source, target, limbs, &tips, sure));
        pair.markers.iter().map(given).chain(found).collect::<Vec<_>>()
    });
    let pairs = readings.next().unwrap_or_else(|| pair.markers.iter().map(given).collect());
    let others = readings.collect();
    Proposal { pairs, others, figures: figures(source, target, matches, lead) }
}

/// How sure a match is that leads the next by `lead`, from 0 to 1.
fn sureness(found: &Match, lead: f64) -> f64 {
    let fits = (SCORES[1] - found.score()) / (SCORES[1] - SCORES[0]);
    fits.clamp(0.0, 1.0) * (lead / SURE_LEAD).clamp(0.0, 1.0)
}

/// A marker of the user's, which is right by definition.
fn given(marker: &Marker) -> ProposedPair {
    ProposedPair { marker: marker.clone(), confidence: 1.0 }
}

/// The pairs of points in a pair of limbs, without those beside a marker of the user's.
fn named(
    settings: &Extremities,
    pair: TransferPair<'_>,
    source: &Shape,
    target: &Shape,
    limbs: LimbPair,
    tips: &[Tip],
    sure: f64,
) -> Vec<ProposedPair> {
    let is_new = |tip: &&Tip| {
        let [a, b] = [source.cloud.places[tip.source], target.cloud.places[tip.target]];
        pair.markers.iter().all(|marker| {
            let p = marker.source.position(pair.source, &pair.source.positions);
            let q = marker.target.position(pair.target, &pair.target.positions);
            (p - a).norm() > NEAR_MARKER * pair.source.diagonal()
                && (q - b).norm() > NEAR_MARKER * pair.target.diagonal()
        })
    };
    let share = |value: f64, limit: f64| if limit > 0.0 { (1.0 - value / limit).clamp(0.0, 1.0) } else { 0.0 };
    let proposed = |(k, tip): (usize, &Tip)| ProposedPair {
        marker: Marker {
            name: format!("limb{}-{}", limbs.source + 1, k + 1),
            source: source.cloud.points[tip.source],
            target: target.cloud.points[tip.target],
        },
        confidence: sure
            * share(limbs.misfit, settings.limits.distance).sqrt()
            * share(tip.distance, settings.max_distance).sqrt(),
    };
    tips.iter().filter(is_new).enumerate().map(proposed).collect()
}

fn figures(source: &Shape, target: &Shape, matches: &[Match], lead: impl Fn(usize) -> f64) -> Figures {
    let mut figures = Figures::default();
    figures.set("source_limbs", source.limbs.len());
    figures.set("target_limbs", target.limbs.len());
    let Some(best) = matches.first() else { return figures };
    figures.set("paired_limbs", best.pairs.len());
    figures.set("score", best.score());
    figures.set("place", best.place);
    figures.set("distance", best.distance);
    figures.set("overlap", best.overlap);
    if let Some(next) = matches.get(1) {
        figures.set("next_score", next.score());
    }
    let turn: Vec<Vec<i8>> = best.turn.row_iter().map(|row| row.iter().map(|x| *x as i8).collect()).collect();
    figures.set("turn", json!(turn));
    let sure = sureness(best, lead(0));
    if sure < 0.5 {
        let why = if lead(0) < SURE_LEAD {
            "the source fits almost as well when it is turned"
        } else {
            "the two shapes differ much"
        };
        figures.warn(format!(
            "the landmarks are doubtful: {why}; look at them, give markers by hand, or turn the target as the source"
        ));
    }
    figures
}
