//! From matches of limbs to pairs of points, with figures that tell how sure they are.

use mimesh_core::{
    Figures,
    stage::{Marker, Proposal, ProposedPair, TransferPair},
};
use serde_json::json;

use super::{
    Extremities,
    comparison::{Comparison, Proxies},
    matching::{LimbPair, Match},
    shape::Shape,
    tips::{Tip, tips},
};

/// How many matches beside the best one are told.
const OTHERS: usize = 2;

/// A match that leads the next by less than this is doubtful.
const SURE_LEAD: f64 = 0.08;

/// Up to the first score shapes fit as animals of one kind do, from the second on as different ones.
const SCORES: [f64; 2] = [0.4, 0.8];

/// Above the first agreement fits forwards and backwards are one map, below the second they have nothing to do with each other.
const AGREEMENTS: [f64; 2] = [0.75, 0.4];

/// A point this near to one of the user's, relative to the diagonal, says nothing new.
const NEAR_MARKER: f64 = 0.02;

/// A match with the pairs of points that it leads to.
pub struct Reading<'a> {
    found: &'a Match,
    pairs: Vec<ProposedPair>,
    /// What fits make of it; `None` if none was made, or it failed.
    comparison: Option<Comparison>,
}

impl Reading<'_> {
    /// How many points were found beside those of the user.
    pub fn found(&self, pair: TransferPair<'_>) -> usize {
        self.pairs.len() - pair.markers.len()
    }
}

/// The readings of the best of `matches`, the likeliest first.
///
/// Fits on proxies are made of the best match, and of the others where that one is doubtful.
pub fn readings<'a>(
    settings: &Extremities,
    pair: TransferPair<'_>,
    shapes: [&Shape; 2],
    matches: &'a [Match],
    proxies: &Proxies<'_>,
) -> Vec<Reading<'a>> {
    let read = |found: &'a Match| Reading { found, pairs: pairs(settings, pair, shapes, found), comparison: None };
    let mut readings: Vec<Reading<'a>> = matches.iter().take(1 + OTHERS).map(read).collect();
    let lead = lead(matches);
    for k in 0..readings.len() {
        let is_sure = readings[0].agreement() >= AGREEMENTS[0] && lead >= SURE_LEAD;
        if k == 0 || !is_sure {
            let markers: Vec<Marker> = readings[k].pairs.iter().map(|pair| pair.marker.clone()).collect();
            readings[k].comparison = proxies.compare(pair, &markers).ok();
        }
    }
    readings.sort_by(|a, b| b.worth().total_cmp(&a.worth()));
    readings
}

/// How much better the best match is than the next.
fn lead(matches: &[Match]) -> f64 {
    let score = |k: usize| matches.get(k).map_or(f64::INFINITY, Match::score);
    score(1) - score(0)
}

/// The proposal of `readings`, the likeliest of which counts.
pub fn proposal(shapes: [&Shape; 2], matches: &[Match], readings: Vec<Reading<'_>>) -> Proposal {
    let figures = figures(shapes, matches, &readings);
    let sure = readings.first().map_or(0.0, |reading| reading.sureness(matches));
    let mut all = readings.into_iter().enumerate().map(|(k, reading)| {
        let around = reading.comparison.map(|comparison| comparison.around);
        let mut pairs = reading.pairs;
        for (n, pair) in pairs.iter_mut().enumerate().filter(|(_, pair)| pair.confidence < 1.0) {
            let local = around.as_ref().map_or(0.0, |around| around[n]);
            pair.confidence *= if k == 0 { sure * local } else { 0.0 };
        }
        pairs
    });
    Proposal { pairs: all.next().unwrap_or_default(), others: all.collect(), figures }
}

impl Reading<'_> {
    fn agreement(&self) -> f64 {
        self.comparison.as_ref().map_or(0.0, Comparison::agreement)
    }

    /// The higher, the likelier it is right.
    fn worth(&self) -> f64 {
        self.agreement() - self.found.score()
    }

    /// How sure it is as a whole, from 0 to 1.
    fn sureness(&self, matches: &[Match]) -> f64 {
        let share = |value: f64, [sure, wrong]: [f64; 2]| ((value - wrong) / (sure - wrong)).clamp(0.0, 1.0);
        let lead = (lead(matches) / SURE_LEAD).clamp(0.0, 1.0);
        share(self.agreement(), AGREEMENTS) * share(self.found.score(), SCORES).max(lead * 0.0) * lead
    }
}

/// A marker of the user's, which is right by definition.
fn given(marker: &Marker) -> ProposedPair {
    ProposedPair { marker: marker.clone(), confidence: 1.0 }
}

/// The user's markers, and the pairs of points in the limbs that a match pairs.
fn pairs(
    settings: &Extremities,
    pair: TransferPair<'_>,
    [source, target]: [&Shape; 2],
    found: &Match,
) -> Vec<ProposedPair> {
    let in_limbs = found.pairs.iter().flat_map(|&limbs| {
        let tips = tips(source, target, limbs, &found.frames, settings.points_per_limb, settings.max_distance);
        named(settings, pair, [source, target], limbs, &tips)
    });
    pair.markers.iter().map(given).chain(in_limbs).collect()
}

/// The pairs of points in a pair of limbs, without those beside a marker of the user's.
fn named(
    settings: &Extremities,
    pair: TransferPair<'_>,
    [source, target]: [&Shape; 2],
    limbs: LimbPair,
    tips: &[Tip],
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
        confidence: share(limbs.misfit, settings.limits.distance).sqrt()
            * share(tip.distance, settings.max_distance).sqrt(),
    };
    tips.iter().filter(is_new).enumerate().map(proposed).collect()
}

fn figures([source, target]: [&Shape; 2], matches: &[Match], readings: &[Reading<'_>]) -> Figures {
    let mut figures = Figures::default();
    figures.set("source_limbs", source.limbs.len());
    figures.set("target_limbs", target.limbs.len());
    let Some(best) = readings.first() else { return figures };
    let found = best.found;
    figures.set("paired_limbs", found.pairs.len());
    figures.set("score", found.score());
    figures.set("place", found.place);
    figures.set("distance", found.distance);
    figures.set("overlap", found.overlap);
    if let Some(next) = matches.get(1) {
        figures.set("next_score", next.score());
    }
    figures.set("agreement", best.agreement());
    let all: Vec<_> = readings
        .iter()
        .map(|r| {
            let c = r.comparison.as_ref();
            json!([r.found.score(), c.map(|c| c.returned), r.found.pairs.len(), c.map(|c| c.around.clone())])
        })
        .collect();
    figures.set("hypotheses", json!(all));
    let turn: Vec<Vec<f64>> = found.frames.turn().row_iter().map(|row| row.iter().copied().collect()).collect();
    figures.set("turn", json!(turn));
    let sure = best.sureness(matches);
    if sure < 0.5 {
        let why = if lead(matches) < SURE_LEAD {
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
