use std::collections::HashMap;

use nalgebra::Point3;
use petgraph::unionfind::UnionFind;

use super::Topology;

/// How boundaries of a mesh that lie at one place are welded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Welding {
    /// Vertices nearer to each other than this are at one place, relative to the diagonal; 0 for exactly one place.
    pub tolerance: f64,
    /// Pairs of vertices of the mesh that are not welded though they are at one place, such as those of closed lips.
    ///
    /// An edge is welded if neither of its ends is in such a pair. The smaller vertex comes first, and pairs are sorted.
    pub opened: Vec<[u32; 2]>,
}

/// For each vertex the first vertex it is welded to, itself if none.
///
/// Files split a vertex where texture coordinates or normals jump; the copies lie at bit-equal positions along two
/// boundaries that run in opposite directions, or nearer to each other than `tolerance`, a length. Exactly those boundary edges
/// are sewn together: two sheets that merely touch at a vertex stay apart, and so do edges with an end in a pair of `opened`.
pub fn seams(positions: &[Point3<f64>], triangles: &[[u32; 3]], tolerance: f64, opened: &[[u32; 2]]) -> Vec<u32> {
    let mut welded = UnionFind::<u32>::new(positions.len());
    for ends in edges(positions, triangles, tolerance) {
        if ends.iter().all(|pair| opened.binary_search(pair).is_err()) {
            ends.iter().for_each(|[a, b]| _ = welded.union(*a, *b));
        }
    }
    firsts(welded, positions.len())
}

/// For each of `count` members of sets the first of its set.
fn firsts(mut sets: UnionFind<u32>, count: usize) -> Vec<u32> {
    let mut first = vec![u32::MAX; count];
    let first_of = |v: u32| {
        let first = &mut first[sets.find_mut(v) as usize];
        // Members come in ascending order.
        *first = v.min(*first);
        *first
    };
    (0..count as u32).map(first_of).collect()
}

/// The pairs of boundary edges that lie at one place and run in opposite directions, as the two pairs of vertices that meet there,
/// the smaller vertex first; in no order.
///
/// Where very many boundaries lie at one place, there are no more pairs than join them all.
pub fn edges(positions: &[Point3<f64>], triangles: &[[u32; 3]], tolerance: f64) -> Vec<[[u32; 2]; 2]> {
    let boundary = Topology::new(triangles).boundary;
    let place =
        if tolerance > 0.0 { near_places(positions, &boundary, tolerance) } else { places(positions, &boundary) };
    let mut at: HashMap<[u32; 2], Vec<[u32; 2]>> = HashMap::new();
    for edge in boundary {
        let ends = edge.map(|v| place[v as usize]);
        // An edge without length would be its own opposite.
        if ends[0] != ends[1] {
            at.entry(ends).or_default().push(edge);
        }
    }
    let mut found = Vec::new();
    for (&[from, to], along) in at.iter().filter(|([from, to], _)| from < to) {
        let Some(against) = at.get(&[to, from]) else { continue };
        let pair = |&[a, b]: &[u32; 2], &[c, d]: &[u32; 2]| [[a.min(d), a.max(d)], [b.min(c), b.max(c)]];
        if along.len().min(against.len()) <= MAX_SHEETS {
            found.extend(along.iter().flat_map(|edge| against.iter().map(move |other| pair(edge, other))));
        } else {
            // So many are one all the same, since the first edge of either side is joined with all of the other.
            found.extend(against.iter().map(|other| pair(&along[0], other)));
            found.extend(along[1..].iter().map(|edge| pair(edge, &against[0])));
        }
    }
    found
}

/// Boundaries of more sheets than this at one place are not paired each with each.
const MAX_SHEETS: usize = 8;

/// For each vertex of `boundary` the first of these at the same position; others are by themselves.
fn places(positions: &[Point3<f64>], boundary: &[[u32; 2]]) -> Vec<u32> {
    let mut place: Vec<u32> = (0..positions.len() as u32).collect();
    let mut first = HashMap::new();
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
    for v in vertices_of(boundary) {
        place[v as usize] = *first.entry(key(&positions[v as usize])).or_insert(v);
    }
    place
}

/// The vertices of `edges`, ascending.
fn vertices_of(edges: &[[u32; 2]]) -> Vec<u32> {
    let mut vertices: Vec<u32> = edges.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// For each vertex of `boundary` the first that it is joined to by steps of at most `tolerance`; others are by themselves.
fn near_places(positions: &[Point3<f64>], boundary: &[[u32; 2]], tolerance: f64) -> Vec<u32> {
    // Two points of such a cell are nearer to each other than the tolerance.
    let side = tolerance / 3.0_f64.sqrt() * (1.0 - 1e-9);
    let cell = |v: u32| -> [f64; 3] { positions[v as usize].coords.map(|x| (x / side).floor()).into() };
    // As floats, cells so far away that integers do not count them stay apart.
    let key = |cell: [f64; 3]| cell.map(|x| (x + 0.0).to_bits());
    let mut cells: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
    vertices_of(boundary).iter().for_each(|&v| cells.entry(key(cell(v))).or_default().push(v));
    let mut joined = UnionFind::<u32>::new(positions.len());
    cells.values().for_each(|members| members.iter().for_each(|&v| _ = joined.union(members[0], v)));
    let is_near = |v: u32, w: u32| (positions[v as usize] - positions[w as usize]).norm() <= tolerance;
    for members in cells.values() {
        let [x, y, z] = cell(members[0]);
        // Half of the cells around: the others meet this one from there.
        for step in 63..125 {
            let along = |x: f64, step: u32| x + f64::from(step % 5) - 2.0;
            let around = key([along(x, step), along(y, step / 5), along(z, step / 25)]);
            let Some(others) = cells.get(&around).filter(|others| !joined.equiv(members[0], others[0])) else {
                continue;
            };
            // Many points within one tolerance are a cloud, of which the first ones stand for all.
            let pairs = members.iter().flat_map(|&v| others.iter().map(move |&w| (v, w))).take(MAX_TRIED);
            if let Some((v, w)) = pairs.into_iter().find(|&(v, w)| is_near(v, w)) {
                joined.union(v, w);
            }
        }
    }
    firsts(joined, positions.len())
}

/// No more pairs of points of two cells are measured.
const MAX_TRIED: usize = 4096;

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: f64, y: f64) -> Point3<f64> {
        Point3::new(x, y, 0.0)
    }

    /// Two triangles along the edge (1,0)-(0,1), split; a third touches only at (0,0).
    fn split() -> (Vec<Point3<f64>>, [[u32; 3]; 3]) {
        let positions =
            vec![p(0., 0.), p(1., 0.), p(0., 1.), p(0., 1.), p(1., 0.), p(1., 1.), p(0., 0.), p(-1., 0.), p(0., -1.)];
        (positions, [[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    }

    #[test]
    fn a_split_edge_is_sewn_and_a_touching_corner_is_not() {
        let (positions, triangles) = split();
        assert_eq!(seams(&positions, &triangles, 0.0, &[]), [0, 1, 2, 2, 1, 5, 6, 7, 8]);
    }

    #[test]
    fn an_edge_with_an_opened_end_is_not_sewn() {
        let (positions, triangles) = split();
        let apart: Vec<u32> = (0..9).collect();
        assert_eq!(seams(&positions, &triangles, 0.0, &[[1, 4]]), apart);
    }

    #[test]
    fn boundaries_of_many_sheets_at_one_place_are_one() {
        let sheet =
            |k: u32| if k.is_multiple_of(2) { [3 * k, 3 * k + 1, 3 * k + 2] } else { [3 * k + 1, 3 * k, 3 * k + 2] };
        let triangles: Vec<[u32; 3]> = (0..5000).map(sheet).collect();
        let positions: Vec<_> =
            (0..5000).flat_map(|k| [p(0., 0.), p(1., 0.), Point3::new(0.0, 1.0, f64::from(k))]).collect();
        assert!(edges(&positions, &triangles, 0.0).len() < 5000);
        for tolerance in [0.0, 1e-3] {
            let welded = seams(&positions, &triangles, tolerance, &[]);
            assert!((0..5000).all(|k| welded[3 * k..3 * k + 3] == [0, 1, 3 * k as u32 + 2]), "{tolerance}");
        }
    }

    #[test]
    fn noise_below_the_tolerance_is_sewn_over() {
        let (mut positions, triangles) = split();
        positions[3].x += 1e-6;
        positions[4].y -= 1e-6;
        let apart: Vec<u32> = (0..9).collect();
        assert_eq!(seams(&positions, &triangles, 0.0, &[]), apart);
        assert_eq!(seams(&positions, &triangles, 9e-7, &[]), apart);
        assert_eq!(seams(&positions, &triangles, 2e-6, &[]), [0, 1, 2, 2, 1, 5, 6, 7, 8]);
    }

    #[test]
    fn positive_and_negative_zero_are_one_place() {
        let positions = vec![Point3::new(0.0, 0.0, 0.0), Point3::new(-0.0, 0.0, -0.0)];
        assert_eq!(places(&positions, &[[0, 1]]), [0, 0]);
    }
}
