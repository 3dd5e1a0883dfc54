//! Pairs of vertices of components that lie close to each other at rest.

use std::collections::BTreeMap;

use mimesh_core::{Result, mesh::Surface, spatial::ClosestPoint};
use rayon::prelude::*;

/// Vertices that look for a neighbour at most.
const SEEKERS: usize = 20_000;
/// Neighbours of a component at most.
const NEIGHBOURS: usize = 6;
/// Pairs that join two components at most.
const PAIRS: usize = 8;

/// Pairs of vertices of different components at most `reach` apart: for each component those to its nearest six others, at most
/// eight each, the closest and others far from it. Of large surfaces every n-th vertex looks for neighbours.
///
/// # Errors
///
/// If there is no triangle.
pub fn pairs(surface: &Surface, reach: f64) -> Result<Vec<[u32; 2]>> {
    let components = surface.components();
    if components.count() < 2 {
        return Ok(vec![]);
    }
    let closest = ClosestPoint::new(&surface.positions, &surface.triangles)?;
    let of_triangle = |t: u32| components.of_vertex[surface.triangles[t as usize][0] as usize];
    let step = surface.vertex_count().div_ceil(SEEKERS);
    let seek = |v: usize| {
        let own = components.of_vertex[v]?;
        let found = closest.find(&surface.positions[v], reach, |t| of_triangle(t) != Some(own))?;
        // The corner that the point found lies nearest to.
        let corners = surface.triangles[found.triangle as usize];
        let distance = |u: u32| (surface.positions[u as usize] - surface.positions[v]).norm();
        let partner = corners.into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
        let other = components.of_vertex[partner as usize]?;
        Some(([own, other], Candidate { distance: distance(partner), pair: [v as u32, partner] }))
    };
    // Components smaller than a step are not passed over: their first vertex always looks.
    let mut seen = vec![false; components.count()];
    let seekers: Vec<usize> = (0..surface.vertex_count())
        .filter(|&v| {
            let Some(c) = components.of_vertex[v] else { return false };
            v % step == 0 || !std::mem::replace(&mut seen[c as usize], true)
        })
        .collect();
    let found: Vec<_> = seekers.par_iter().with_min_len(256).filter_map(|&v| seek(v)).collect();
    let mut of_component: BTreeMap<u32, BTreeMap<u32, Vec<Candidate>>> = BTreeMap::new();
    for ([own, other], candidate) in found {
        of_component.entry(own).or_default().entry(other).or_default().push(candidate);
    }
    let mut pairs = Vec::new();
    for others in of_component.into_values() {
        let mut others: Vec<Vec<Candidate>> = others.into_values().map(sorted).collect();
        others.sort_by(|a, b| a[0].distance.total_cmp(&b[0].distance));
        pairs.extend(others.iter().take(NEIGHBOURS).flat_map(|candidates| spread_out(surface, candidates)));
    }
    pairs.iter_mut().for_each(|pair| pair.sort_unstable());
    pairs.sort_unstable();
    pairs.dedup();
    Ok(pairs)
}

struct Candidate {
    distance: f64,
    pair: [u32; 2],
}

fn sorted(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.pair.cmp(&b.pair)));
    candidates
}

/// The closest pair, and in turn the pair farthest from those chosen.
fn spread_out(surface: &Surface, candidates: &[Candidate]) -> Vec<[u32; 2]> {
    let place = |k: usize| surface.positions[candidates[k].pair[0] as usize];
    let mut away = vec![f64::INFINITY; candidates.len()];
    let mut chosen = vec![];
    let mut next = 0;
    while chosen.len() < PAIRS.min(candidates.len()) {
        chosen.push(candidates[next].pair);
        let at = place(next);
        away.iter_mut().enumerate().for_each(|(k, away)| *away = away.min((place(k) - at).norm()));
        next = (0..away.len()).fold(0, |best, k| if away[k] > away[best] { k } else { best });
    }
    chosen
}

/// Component `number` in words: its part's name, number of vertices and first vertex.
pub fn component(surface: &Surface, number: usize) -> String {
    format!("component {number} {}", surface.describe_components(&surface.components(), &[number]))
}
