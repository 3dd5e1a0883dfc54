//! Links components by a minimum spanning tree and by what else lies as close.
//!
//! Zhou et al. 2010, section 2.1. The complete graph on components, weighted by the shortest distance d_ab between vertices,
//! has the minimum spanning tree K; d_a is the longest edge of K at component a, ε_a = `epsilon_factor` × the longest edge of
//! a. Components a and b that K does not join are linked too where d_ab ≤ d_a + ε_a and d_ab ≤ d_b + ε_b. A link holds pairs
//! of vertices no farther apart than d_ab + min(ε_a, ε_b).
//!
//! Departures: of all pairs within that distance, those are candidates in which one vertex is the nearest to the other, and at
//! most `max_pairs` of them are kept, spread evenly over the gap: where components interpenetrate, the paper's set has
//! millions of pairs that say the same (`pairs: all` for the paper).
//!
//! Cost: the tree is exact without all distances. Pairs of components wait in a queue under the distance of their bounding
//! boxes; only those that come to its front before the tree is complete are measured (`tree.rs`), and only those that lie close
//! enter the queue at all (`sweep.rs`).

use std::collections::BTreeMap;

use mimesh_core::{
    Error, Figures, Result,
    mesh::Surface,
    plugin::check_ranges,
    register,
    stage::{ComponentRef, Link, Proximity, ProximityGraph},
};
use nalgebra::Point3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    parts::Part,
    sweep::Sweep,
    tree::{Measured, tree},
};

register!(Proximity: SpanningTree);

/// Links components by a minimum spanning tree over their distances, and others as close (Zhou et al. 2010, section 2.1).
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpanningTree {
    /// ε over the longest edge of a component: how much farther than its neighbours in the tree a component may be and still
    /// be linked. Larger values make the target more cohesive.
    #[schemars(range(min = 0.0))]
    pub epsilon_factor: f64,
    /// Which pairs of vertices a link keeps.
    pub pairs: Pairs,
    /// Most pairs of vertices a link keeps, with `pairs: spread`.
    #[schemars(range(min = 1))]
    pub max_pairs: usize,
    /// Links to have in any case, between components given by number or by name; each component of the first is linked with
    /// the nearest of the second.
    pub add: Vec<[ComponentRef; 2]>,
    /// Links not to have, e.g. between upper and lower teeth that touch at rest.
    pub forbid: Vec<[ComponentRef; 2]>,
    /// Links that hold as if glued: added like `add`, and a thousand times as stiff.
    pub weld: Vec<[ComponentRef; 2]>,
}

impl Default for SpanningTree {
    fn default() -> Self {
        Self { epsilon_factor: 1.5, pairs: Pairs::Spread, max_pairs: 60, add: vec![], forbid: vec![], weld: vec![] }
    }
}

/// Which pairs of vertices a link keeps, of those no farther apart than d_ab + min(ε_a, ε_b).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pairs {
    /// At most `max_pairs`, spread evenly over the gap, of those in which one vertex is the nearest to the other.
    #[default]
    Spread,
    /// All, as in the paper (section 2.1): millions where components interpenetrate or lie close.
    All,
}

/// How much stiffer a welded link is.
const WELD_STIFFNESS: f64 = 1000.0;

#[typetag::serde(name = "spanning_tree")]
impl Proximity for SpanningTree {
    fn proximity(&self, target: &Surface) -> Result<ProximityGraph> {
        check_ranges(self)?;
        let components = target.components();
        let parts = Part::all(target, &components)?;
        let between = |pairs: &[[ComponentRef; 2]]| -> Result<Vec<[Vec<u32>; 2]>> {
            let both =
                |[a, b]: &[ComponentRef; 2]| Ok([a.resolve(target, &components)?, b.resolve(target, &components)?]);
            pairs.iter().map(both).collect()
        };
        let forbidden = between(&self.forbid)?;
        let allowed = |a: u32, b: u32| {
            let is = |x: u32, y: u32| forbidden.iter().any(|[s, t]| s.contains(&x) && t.contains(&y));
            !is(a, b) && !is(b, a)
        };

        let tree = tree(&parts, allowed);
        if tree.len() + 1 < parts.len() {
            return Err(Error::data(
                "forbidden links leave components without any tie to the rest",
                "forbid fewer links, or add others",
            ));
        }
        // Distance, whether in the tree, stiffness.
        let mut links: BTreeMap<[u32; 2], (f64, bool, f64)> = BTreeMap::new();
        links.extend(tree.iter().map(|&(distance, pair)| (pair, (distance, true, 1.0))));
        for (distance, pair) in self.as_close(&parts, &tree, allowed) {
            links.entry(pair).or_insert((distance, false, 1.0));
        }
        for (asked, stiffness) in [(between(&self.add)?, 1.0), (between(&self.weld)?, WELD_STIFFNESS)] {
            for (distance, pair) in asked.iter().flat_map(|[from, to]| nearest(&parts, from, to)) {
                links.entry(pair).or_insert((distance, false, 1.0)).2 = stiffness;
            }
        }
        let links: Vec<(Link, bool)> = links
            .into_par_iter()
            .map(|(components, (distance, in_tree, stiffness))| {
                let (pairs, capped) = self.pairs(target, &parts, components, distance);
                (Link { components, distance, in_tree, stiffness, pairs }, capped)
            })
            .collect();
        let mut figures = Figures::default();
        figures.set("components", parts.len());
        figures.set("links", links.len());
        figures.set("links_in_the_tree", tree.len());
        figures.set("pairs", links.iter().map(|(link, _)| link.pairs.len()).sum::<usize>());
        figures.set("links_with_pairs_left_out", links.iter().filter(|(_, capped)| *capped).count());
        ProximityGraph::new(components, links.into_iter().map(|(link, _)| link).collect(), figures)
    }
}

impl SpanningTree {
    fn epsilon(&self, part: &Part) -> f64 {
        self.epsilon_factor * part.longest_edge
    }

    /// Pairs of components that are not joined in the tree but as close as what is.
    fn as_close(&self, parts: &[Part], tree: &[Measured], allowed: impl Fn(u32, u32) -> bool + Sync) -> Vec<Measured> {
        let mut reach = vec![0.0f64; parts.len()];
        for &(distance, pair) in tree {
            pair.into_iter().for_each(|c| reach[c as usize] = reach[c as usize].max(distance));
        }
        reach.iter_mut().zip(parts).for_each(|(reach, part)| *reach += self.epsilon(part));
        let sweep = Sweep::new(parts);
        let others = |place: usize| {
            let (parts, reach, allowed) = (&parts, &reach, &allowed);
            sweep.near(place, reach[sweep.part(place) as usize]).filter_map(move |[a, b]| {
                let (p, q) = (&parts[a as usize], &parts[b as usize]);
                let limit = reach[a as usize].min(reach[b as usize]);
                if !allowed(a, b) || p.box_distance(q) > limit {
                    return None;
                }
                let distance = p.distance(q);
                (distance <= limit).then_some((distance, [a, b]))
            })
        };
        (0..parts.len()).into_par_iter().flat_map_iter(others).collect()
    }

    /// The pairs of vertices of a link, closest first, and whether some were left out.
    fn pairs(&self, target: &Surface, parts: &[Part], [a, b]: [u32; 2], distance: f64) -> (Vec<[u32; 2]>, bool) {
        let (p, q) = (&parts[a as usize], &parts[b as usize]);
        let limit = distance + self.epsilon(p).min(self.epsilon(q));
        if self.pairs == Pairs::All {
            return (all_pairs(target, p, q, limit), false);
        }
        let mut near = p.near(q, limit);
        near.extend(q.near(p, limit).into_iter().map(|(d, v, w)| (d, w, v)));
        near.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        near.dedup_by_key(|x| (x.1, x.2));
        let middle = |&(_, v, w): &(f64, u32, u32)| {
            nalgebra::center(&target.positions[v as usize], &target.positions[w as usize])
        };
        let middles: Vec<_> = near.iter().map(middle).collect();
        let mut kept = farthest_subset(&middles, self.max_pairs);
        kept.sort_unstable();
        (kept.iter().map(|&k| [near[k].1, near[k].2]).collect(), kept.len() < near.len())
    }
}

/// All pairs of vertices no farther apart than `limit`, closest first.
fn all_pairs(target: &Surface, p: &Part, q: &Part, limit: f64) -> Vec<[u32; 2]> {
    let at = |v: u32| target.positions[v as usize];
    // A vertex that is not near to any of the other component is in no pair.
    let (left, right) = (p.near(q, limit), q.near(p, limit));
    let mut pairs: Vec<(f64, [u32; 2])> = left
        .iter()
        .flat_map(|&(_, v, _)| right.iter().map(move |&(_, w, _)| [v, w]))
        .map(|[v, w]| ((at(v) - at(w)).norm(), [v, w]))
        .filter(|&(distance, _)| distance <= limit)
        .collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    pairs.into_iter().map(|(_, pair)| pair).collect()
}

/// For each component of `from` the nearest one of `to`.
fn nearest(parts: &[Part], from: &[u32], to: &[u32]) -> Vec<Measured> {
    let closest = |&a: &u32| {
        let others = to.iter().filter(|&&b| b != a);
        let found = others.map(|&b| (parts[a as usize].distance(&parts[b as usize]), [a.min(b), a.max(b)]));
        found.min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)))
    };
    from.iter().filter_map(closest).collect()
}

/// At most `count` of the points, spread evenly: the first, then always the one farthest from those taken.
fn farthest_subset(points: &[Point3<f64>], count: usize) -> Vec<usize> {
    if points.len() <= count {
        return (0..points.len()).collect();
    }
    let mut taken = Vec::new();
    let mut distance = vec![f64::INFINITY; points.len()];
    let mut next = 0;
    while taken.len() < count.min(points.len()) {
        taken.push(next);
        distance[next] = f64::NEG_INFINITY;
        for (d, p) in distance.iter_mut().zip(points) {
            *d = d.min((p - points[next]).norm_squared());
        }
        next = (0..points.len()).max_by(|&i, &j| distance[i].total_cmp(&distance[j]).then(j.cmp(&i))).unwrap_or(0);
    }
    taken
}
