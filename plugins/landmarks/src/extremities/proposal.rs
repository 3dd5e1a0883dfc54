//! What is proposed, with figures that tell how sure it is.

use mimesh_core::{Figures, stage::Proposal};
use serde_json::json;

use super::{
    matching::Match,
    reading::{Reading, sureness},
    shape::Shape,
};

/// Landmarks less sure than this, from 0 to 1, are doubtful.
const DOUBTFUL: f64 = 0.5;

/// The proposal of `readings`, the first of which counts; the first `given` pairs of each are the user's.
pub fn proposal(
    source: &Shape,
    target: &Shape,
    matches: &[Match],
    readings: Vec<Reading<'_>>,
    given: usize,
) -> Proposal {
    let figures = figures(source, target, matches, &readings);
    let [agreed, alone] = sureness(&readings);
    let mut all = readings.into_iter().enumerate().map(|(k, reading)| {
        let around = reading.comparison.map(|comparison| comparison.around);
        let mut pairs = reading.pairs;
        for (n, pair) in pairs.iter_mut().enumerate().skip(given) {
            let around = around.as_ref().map_or(0.0, |around| around[n]);
            pair.confidence *= if k == 0 { agreed * alone * around } else { 0.0 };
        }
        pairs
    });
    Proposal { pairs: all.next().unwrap_or_default(), others: all.collect(), figures }
}

fn figures(source: &Shape, target: &Shape, matches: &[Match], readings: &[Reading<'_>]) -> Figures {
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
    let others = readings.iter().skip(1).filter(|other| other.comparison.is_some()).map(Reading::agreement);
    if let Some(next) = others.reduce(f64::max) {
        figures.set("next_agreement", next);
    }
    let turn: Vec<Vec<f64>> = found.frames.turn().row_iter().map(|row| row.iter().copied().collect()).collect();
    figures.set("turn", json!(turn));
    let [agreed, alone] = sureness(readings);
    let why = if alone < DOUBTFUL {
        "another way to pair the two shapes fits about as well".to_owned()
    } else {
        let share = 100.0 * best.agreement();
        format!("only {share:.0} % of the surface returns to its place when it is fitted to the other and back")
    };
    if agreed.min(alone) < DOUBTFUL {
        figures.warn(format!("the landmarks are doubtful: {why}; look at them, or give corresponding points by hand"));
    }
    figures
}
