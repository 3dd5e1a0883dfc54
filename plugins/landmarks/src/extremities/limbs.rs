//! Limbs: where a surface is far from the rest of itself.

use mimesh_core::spatial::EdgePaths;

/// A limb whose tip is nearer than this to that of a greater one, relative to the longest distance, is part of it.
const MERGED: f64 = 0.05;

/// The outer part of a limb, from its tip to where it joins another, in terms of the mean distance.
const OUTER: f64 = 0.5;

/// A limb of a shape.
#[derive(Clone, Debug)]
pub struct Limb {
    /// The point of the cloud that is farthest out.
    pub tip: usize,
    /// The points of the cloud that make its outer half, ascending.
    pub outer: Vec<usize>,
    /// The distance of every point of the cloud from the tip.
    pub distances: Vec<f64>,
}

/// The limbs of a shape with the mean distances `far` (#P), greatest first: the maxima that stand out by at least `persistence`.
pub fn limbs(paths: &EdgePaths, far: &[f64], persistence: f64) -> Vec<Limb> {
    let mut found: Vec<Maximum> = maxima(paths, far);
    found.retain(|maximum| maximum.persistence(far) >= persistence);
    // The greatest never merges with another: it ends where the first of the others does.
    if let Some(highest) = found.iter().skip(1).map(|maximum| maximum.saddle).reduce(f64::max) {
        found[0].saddle = highest;
    }
    let distances: Vec<_> = found.iter().map(|maximum| paths.distances(&[maximum.point as u32])).collect();
    let longest = distances.iter().flatten().copied().fold(0.0, f64::max);
    let mut limbs: Vec<Limb> = Vec::new();
    for (maximum, distances) in found.into_iter().zip(distances) {
        if limbs.iter().all(|limb| limb.distances[maximum.point] >= MERGED * longest) {
            let level = far[maximum.point] - OUTER * (far[maximum.point] - maximum.saddle);
            limbs.push(Limb { tip: maximum.point, outer: above(paths, far, maximum.point, level), distances });
        }
    }
    limbs
}

/// A maximum of a function on the points of a graph.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Maximum {
    point: usize,
    /// The value below which its surroundings are those of a higher maximum; for the highest the minimum.
    saddle: f64,
}

impl Maximum {
    fn persistence(&self, values: &[f64]) -> f64 {
        values[self.point] - self.saddle
    }
}

/// All maxima of `values`, the most persistent first [Edelsbrunner, Letscher and Zomorodian 2002].
///
/// Points are added from the highest down. Where one joins the surroundings of several maxima, all but the highest of these end.
fn maxima(paths: &EdgePaths, values: &[f64]) -> Vec<Maximum> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]).then(a.cmp(&b)));
    let mut rank = vec![0; values.len()];
    order.iter().enumerate().for_each(|(k, &v)| rank[v] = k);
    let mut parent: Vec<Option<usize>> = vec![None; values.len()];
    let mut found = Vec::new();
    for &v in &order {
        let neighbours = paths.neighbours(v as u32).iter().map(|&(u, _)| u as usize);
        let mut roots: Vec<usize> = neighbours.filter_map(|u| parent[u].map(|_| root(&mut parent, u))).collect();
        roots.sort_by_key(|&r| rank[r]);
        roots.dedup();
        let highest = roots.first().copied().unwrap_or(v);
        parent[v] = Some(highest);
        for &r in roots.iter().skip(1) {
            found.push(Maximum { point: r, saddle: values[v] });
            parent[r] = Some(highest);
        }
    }
    if let (Some(&first), Some(&last)) = (order.first(), order.last()) {
        found.push(Maximum { point: first, saddle: values[last] });
    }
    found.sort_by(|a, b| {
        b.persistence(values).total_cmp(&a.persistence(values)).then(rank[a.point].cmp(&rank[b.point]))
    });
    found
}

/// The maximum whose surroundings `v` belongs to; shortens the way there.
fn root(parent: &mut [Option<usize>], mut v: usize) -> usize {
    while let Some(up) = parent[v].filter(|&up| up != v) {
        parent[v] = parent[up];
        v = up;
    }
    v
}

/// The points with a value above `level` that are joined to `start` by such points, ascending.
fn above(paths: &EdgePaths, values: &[f64], start: usize, level: f64) -> Vec<usize> {
    let mut is_found = vec![false; values.len()];
    is_found[start] = true;
    let mut waiting = vec![start];
    while let Some(v) = waiting.pop() {
        for &(u, _) in paths.neighbours(v as u32) {
            let u = u as usize;
            if values[u] > level && !std::mem::replace(&mut is_found[u], true) {
                waiting.push(u);
            }
        }
    }
    (0..values.len()).filter(|&v| is_found[v]).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// A chain of points with links between neighbours.
    fn chain(count: u32) -> EdgePaths {
        let places: Vec<_> = (0..count).map(|x| Point3::new(f64::from(x), 0.0, 0.0)).collect();
        let links: Vec<_> = (1..count).map(|b| [b - 1, b]).collect();
        EdgePaths::new(&places, &[], &links)
    }

    #[test]
    fn maxima_end_where_they_meet_higher_ones() {
        let values = [3.0, 1.0, 5.0, 2.0, 4.0, 0.0];
        let expected = [(2, 0.0), (4, 2.0), (0, 1.0)].map(|(point, saddle)| Maximum { point, saddle });
        assert_eq!(maxima(&chain(6), &values), expected);
    }

    #[test]
    fn equal_neighbours_are_one_maximum() {
        let found = maxima(&chain(5), &[0.0, 2.0, 2.0, 2.0, 1.0]);
        assert!(found.iter().filter(|maximum| maximum.saddle < 2.0).count() == 1, "{found:?}");
    }

    #[test]
    fn the_outer_part_ends_halfway_to_the_saddle() {
        let values = [4.0, 3.0, 2.0, 1.0, 0.0, 1.5, 3.0];
        let limbs = limbs(&chain(7), &values, 1.0);
        let outer: Vec<_> = limbs.iter().map(|limb| (limb.tip, limb.outer.clone())).collect();
        // The second ends at 0; so does the greatest then, whose own end is the minimum, 0 as well.
        assert_eq!(outer, [(0, vec![0, 1]), (6, vec![6])]);
    }
}
