//! A match with the points that it leads to, and what fits make of them.

use mimesh_core::{
    Result,
    stage::{Marker, ProposedPair, TransferPair, Work},
};

use super::{
    between::between,
    comparison::{Comparison, Proxies},
    matching::{LimbPair, Match},
    place::spread,
    shape::Shape,
    tips::{Tip, tips},
};

/// How many matches beside the best one are read.
const OTHERS: usize = 2;

/// A match that leads the next by less than this is compared with it: the points that happen to stand for the shapes make up to 0.08.
const SURE_LEAD: f64 = 0.16;

/// A reading whose agreement leads that of the next by less than this is doubtful.
const AGREEMENT_LEAD: f64 = 0.15;

/// Above the first agreement, fits forwards and backwards are one map. Below the second they have nothing to do with each other.
const AGREEMENTS: [f64; 2] = [0.75, 0.4];

/// Above this agreement, fits are right between limbs too.
const RELIABLE: f64 = 0.9;

/// A point this near to one of the user's, relative to the diagonal, says nothing new.
const NEAR_MARKER: f64 = 0.02;

/// How many points at the same place a first fit of shapes without limbs takes.
const AT_PLACE: usize = 20;

/// How often such points are replaced by those that fits agree on.
const ROUNDS: usize = 2;

/// A match with the pairs of points that it leads to, the user's markers first.
pub struct Reading<'a> {
    pub found: &'a Match,
    pub pairs: Vec<ProposedPair>,
    /// What fits make of it; `None` if none was made, or it failed.
    pub comparison: Option<Comparison>,
}

/// How many points are wanted, and how far they may lie apart.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Most points in a pair of limbs.
    pub in_limb: usize,
    /// The largest distance of a pair of points, in sides of the box of its limb.
    pub max_distance: f64,
    /// The largest misfit of a pair of limbs.
    pub max_misfit: f64,
    /// Most points between limbs.
    pub between: usize,
}

/// The surfaces as a reader sees them.
#[derive(Clone, Copy)]
pub struct Reader<'a> {
    pub wanted: Wanted,
    pub pair: TransferPair<'a>,
    pub source: &'a Shape,
    pub target: &'a Shape,
    pub proxies: &'a Proxies<'a>,
}

impl<'a> Reader<'a> {
    /// The readings of the best of `matches`, the likeliest first.
    ///
    /// Fits on proxies are made of the best match, and of the others where that one is doubtful.
    ///
    /// # Errors
    ///
    /// Those of points between limbs.
    pub fn readings(self, matches: &'a [Match], work: Work<'_>) -> Result<Vec<Reading<'a>>> {
        let mut readings: Vec<_> = matches.iter().take(1 + OTHERS).map(|found| self.read(found)).collect();
        // A sure lead mostly stays one.
        let expected = if lead(matches) >= SURE_LEAD { 1 } else { readings.len() };
        for k in 0..readings.len() {
            let is_sure = k > 0 && readings[0].agreement() >= AGREEMENTS[0] && lead(matches) >= SURE_LEAD;
            if !is_sure {
                readings[k].comparison = self.compare(&readings[k].pairs);
                work.done((k + 1) as f64 / expected.max(k + 2) as f64);
            }
        }
        let worth = |reading: &Reading<'_>| reading.agreement() - reading.found.score();
        readings.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        if let Some(best) = readings.first_mut() {
            self.refine(best)?;
        }
        Ok(readings)
    }

    /// What fits make of `pairs`; `None` if they cannot be made.
    fn compare(self, pairs: &[ProposedPair]) -> Option<Comparison> {
        let markers: Vec<Marker> = pairs.iter().map(|pair| pair.marker.clone()).collect();
        self.proxies.compare(self.pair, &markers).ok()
    }

    /// The user's markers, and the pairs of points that a match leads to.
    fn read(self, found: &'a Match) -> Reading<'a> {
        let given = self.pair.markers.iter().map(|marker| ProposedPair { marker: marker.clone(), confidence: 1.0 });
        let pairs = if found.pairs.is_empty() {
            let tips = spread(self.source, self.target, &found.frames, AT_PLACE);
            given.chain(self.named("place", &tips, 1.0)).collect()
        } else {
            distinct(given.chain(found.pairs.iter().flat_map(|&limbs| self.in_limbs(found, limbs))))
        };
        Reading { found, pairs, comparison: None }
    }

    /// The pairs of points in a pair of limbs.
    fn in_limbs(self, found: &Match, limbs: LimbPair) -> Vec<ProposedPair> {
        let Wanted { in_limb, max_distance, max_misfit, .. } = self.wanted;
        let tips = tips(self.source, self.target, limbs, &found.frames, in_limb, max_distance);
        self.named(&format!("limb{}", limbs.source + 1), &tips, share(limbs.misfit, max_misfit).sqrt())
    }

    /// Pairs of points named `name` with a number, without those beside a marker of the user's.
    fn named(self, name: &str, tips: &[Tip], sure: f64) -> Vec<ProposedPair> {
        let is_new = |tip: &&Tip| {
            let [a, b] = [self.source.cloud.places[tip.source], self.target.cloud.places[tip.target]];
            let (source, target) = (self.pair.source, self.pair.target);
            self.pair.markers.iter().all(|marker| {
                let p = marker.source.position(source, &source.positions);
                let q = marker.target.position(target, &target.positions);
                (p - a).norm() > NEAR_MARKER * source.diagonal() && (q - b).norm() > NEAR_MARKER * target.diagonal()
            })
        };
        let proposed = |(k, tip): (usize, &Tip)| ProposedPair {
            marker: Marker {
                name: format!("{name}-{}", k + 1),
                source: self.source.cloud.points[tip.source],
                target: self.target.cloud.points[tip.target],
            },
            confidence: sure * share(tip.distance, self.wanted.max_distance).sqrt(),
        };
        // Numbered before, so that a click changes no names.
        tips.iter().enumerate().filter(|(_, tip)| is_new(tip)).map(proposed).collect()
    }

    /// Adds points between limbs, or puts points that fits agree on in place of those at the same place.
    fn refine(self, reading: &mut Reading<'_>) -> Result<()> {
        let given = self.pair.markers.len();
        let markers = |pairs: &[ProposedPair]| pairs.iter().map(|pair| pair.marker.clone()).collect::<Vec<_>>();
        let proposed = |marker| ProposedPair { marker, confidence: 1.0 };
        if reading.agreement() < if reading.found.pairs.is_empty() { AGREEMENTS[0] } else { RELIABLE } {
            return Ok(());
        }
        if !reading.found.pairs.is_empty() {
            let Some(comparison) = &mut reading.comparison else { return Ok(()) };
            // A marker holds a small part as a whole, which a fit of few triangles does not know well enough.
            let most = if self.target.cloud.is_parted() { 0 } else { self.wanted.between };
            let more = between(self.pair, &comparison.agreed, &markers(&reading.pairs), most, "between-")?;
            comparison.around.extend(more.iter().map(|_| comparison.returned[0].min(comparison.returned[1])));
            reading.pairs.extend(more.into_iter().map(proposed));
            return Ok(());
        }
        for _ in 0..ROUNDS {
            let Some(comparison) = &reading.comparison else { return Ok(()) };
            let better = between(self.pair, &comparison.agreed, &markers(&reading.pairs), AT_PLACE, "place-")?;
            let mut pairs = reading.pairs[..given].to_vec();
            pairs.extend(better.into_iter().map(proposed));
            let comparison = self.compare(&pairs).filter(|new| new.agreement() >= RELIABLE * reading.agreement());
            if comparison.is_none() {
                return Ok(());
            }
            (reading.pairs, reading.comparison) = (pairs, comparison);
        }
        Ok(())
    }
}

impl Reading<'_> {
    /// How well fits agree; 0 if none was made.
    pub fn agreement(&self) -> f64 {
        self.comparison.as_ref().map_or(0.0, Comparison::agreement)
    }
}

/// How much better the best match is than the next.
pub fn lead(matches: &[Match]) -> f64 {
    let score = |k: usize| matches.get(k).map_or(f64::INFINITY, Match::score);
    score(1) - score(0)
}

/// How sure the first of `readings` is as a whole, and how sure it is among them, from 0 to 1 each.
pub fn sureness(readings: &[Reading<'_>]) -> [f64; 2] {
    let Some(best) = readings.first() else { return [0.0; 2] };
    let [sure, wrong] = AGREEMENTS;
    let others = readings.iter().skip(1).filter(|other| other.comparison.is_some()).map(Reading::agreement);
    let lead = best.agreement() - others.fold(f64::NEG_INFINITY, f64::max);
    [((best.agreement() - wrong) / (sure - wrong)).clamp(0.0, 1.0), (lead / AGREEMENT_LEAD).clamp(0.0, 1.0)]
}

/// The pairs without those that share a point with one before, as those of limbs that grow together may.
fn distinct(pairs: impl Iterator<Item = ProposedPair>) -> Vec<ProposedPair> {
    let mut found: Vec<ProposedPair> = Vec::new();
    for pair in pairs {
        let shares = |a: &Marker, b: &Marker| a.source == b.source || a.target == b.target;
        if found.iter().all(|other| !shares(&other.marker, &pair.marker)) {
            found.push(pair);
        }
    }
    found
}

/// 1 for a value of 0 and 0 for `limit` or more.
fn share(value: f64, limit: f64) -> f64 {
    if limit > 0.0 { (1.0 - value / limit).clamp(0.0, 1.0) } else { 0.0 }
}
