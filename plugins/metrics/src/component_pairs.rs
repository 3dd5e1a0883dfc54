//! Pairs of vertices of components that lie close to each other at rest, and names of components.

use std::collections::BTreeMap;

use mimesh_core::{Result, mesh::Surface, spatial::ClosestPoint};
use rayon::prelude::*;

/// Vertices that look for a partner.
const MAX_QUERIES: usize = 20_000;
/// Neighbours of a component.
const MAX_NEIGHBOURS: usize = 6;
/// Pairs between two components.
const MAX_PAIRS: usize = 8;

/// Pairs of vertices of different components at most `max_distance` apart, sorted.
///
/// Each component has pairs with its six nearest others, at most eight with each: the closest, and others far from it. On a large
/// surface only every n-th vertex looks for a partner.
///
/// # Errors
///
/// [`Error::Data`](mimesh_core::Error::Data) if there is no triangle.
pub fn near(surface: &Surface, max_distance: f64) -> Result<Vec<[u32; 2]>> {
    let components = surface.components();
    if components.count() < 2 {
        return Ok(vec![]);
    }
    let closest = ClosestPoint::new(&surface.positions, &surface.triangles)?;
    let of_triangle = |t: u32| components.of_vertex[surface.triangles[t as usize][0] as usize];
    let step = surface.vertex_count().div_ceil(MAX_QUERIES);
    let candidate = |v: usize| {
        let own = components.of_vertex[v]?;
        let found = closest.find(&surface.positions[v], max_distance, |t| of_triangle(t) != Some(own))?;
        // The corner nearest to the closest point.
        let corners = surface.triangles[found.triangle as usize];
        let distance = |u: u32| (surface.positions[u as usize] - surface.positions[v]).norm();
        let partner = corners.into_iter().min_by(|a, b| distance(*a).total_cmp(&distance(*b)))?;
        let other = components.of_vertex[partner as usize]?;
        Some(([own, other], Candidate { distance: distance(partner), pair: [v as u32, partner] }))
    };
    // The first vertex of every component looks for a partner, so that no small component is skipped.
    let mut seen = vec![false; components.count()];
    let queries: Vec<usize> = (0..surface.vertex_count())
        .filter(|&v| {
            let Some(c) = components.of_vertex[v] else { return false };
            v % step == 0 || !std::mem::replace(&mut seen[c as usize], true)
        })
        .collect();
    let found: Vec<_> = queries.par_iter().with_min_len(256).filter_map(|&v| candidate(v)).collect();
    let mut of_component: BTreeMap<u32, BTreeMap<u32, Vec<Candidate>>> = BTreeMap::new();
    for ([own, other], candidate) in found {
        of_component.entry(own).or_default().entry(other).or_default().push(candidate);
    }
    let mut pairs = Vec::new();
    for others in of_component.into_values() {
        let mut others: Vec<Vec<Candidate>> = others.into_values().map(sorted).collect();
        others.sort_by(|a, b| a[0].distance.total_cmp(&b[0].distance));
        pairs.extend(others.iter().take(MAX_NEIGHBOURS).flat_map(|candidates| spread_out(surface, candidates)));
    }
    pairs.iter_mut().for_each(|pair| pair.sort_unstable());
    pairs.sort_unstable();
    pairs.dedup();
    Ok(pairs)
}

/// A pair of vertices and the distance between them.
struct Candidate {
    distance: f64,
    pair: [u32; 2],
}

fn sorted(mut candidates: Vec<Candidate>) -> Vec<Candidate> {
    candidates.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.pair.cmp(&b.pair)));
    candidates
}

/// The closest pair of sorted `candidates`, then in turn the pair farthest from those chosen.
fn spread_out(surface: &Surface, candidates: &[Candidate]) -> Vec<[u32; 2]> {
    let position = |k: usize| surface.positions[candidates[k].pair[0] as usize];
    let mut distances = vec![f64::INFINITY; candidates.len()];
    let mut chosen = vec![];
    let mut next = 0;
    while chosen.len() < MAX_PAIRS.min(candidates.len()) {
        chosen.push(candidates[next].pair);
        let at = position(next);
        distances.iter_mut().enumerate().for_each(|(k, distance)| *distance = distance.min((position(k) - at).norm()));
        next = (0..distances.len()).fold(0, |best, k| if distances[k] > distances[best] { k } else { best });
    }
    chosen
}

/// The component `number` (from 0) for people: its part's name, number of vertices and first vertex.
pub fn describe(surface: &Surface, number: usize) -> String {
    format!("component {number} {}", surface.describe_components(&surface.components(), &[number]))
}
