use std::collections::HashMap;

use nalgebra::Point3;
use petgraph::unionfind::UnionFind;

use super::Topology;

/// For each vertex the first vertex it is welded to, itself if none.
///
/// Files split a vertex where texture coordinates or normals jump; the copies lie at bit-equal positions along two
/// boundaries that run in opposite directions. Exactly those boundary edges are sewn together: two sheets that merely touch
/// at a vertex, or closed lips that only meet within a distance, stay apart.
pub fn seams(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut welded = UnionFind::<u32>::new(positions.len());
    let place = places(positions);
    let mut edges: HashMap<[u32; 2], Vec<[u32; 2]>> = HashMap::new();
    for edge in Topology::new(triangles).boundary {
        let ends = edge.map(|v| place[v as usize]);
        // An edge without length would be its own opposite.
        if ends[0] != ends[1] {
            edges.entry(ends).or_default().push(edge);
        }
    }
    for (&[from, to], along) in &edges {
        let Some(against) = edges.get(&[to, from]) else { continue };
        for &[a, b] in along {
            for &[c, d] in against {
                welded.union(a, d);
                welded.union(b, c);
            }
        }
    }
    let mut first = HashMap::new();
    (0..positions.len() as u32).map(|v| *first.entry(welded.find_mut(v)).or_insert(v)).collect()
}

/// For each vertex the first vertex at the same position.
fn places(positions: &[Point3<f64>]) -> Vec<u32> {
    let mut first = HashMap::new();
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
    positions.iter().enumerate().map(|(v, p)| *first.entry(key(p)).or_insert(v as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_split_edge_is_sewn_and_a_touching_corner_is_not() {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        // Two triangles along the edge (1,0)-(0,1), split; a third touches only at (0,0).
        let positions =
            vec![p(0., 0.), p(1., 0.), p(0., 1.), p(0., 1.), p(1., 0.), p(1., 1.), p(0., 0.), p(-1., 0.), p(0., -1.)];
        let triangles = [[0, 1, 2], [3, 4, 5], [6, 7, 8]];
        assert_eq!(seams(&positions, &triangles), [0, 1, 2, 2, 1, 5, 6, 7, 8]);
    }

    #[test]
    fn positive_and_negative_zero_are_one_place() {
        let positions = vec![Point3::new(0.0, 0.0, 0.0), Point3::new(-0.0, 0.0, -0.0)];
        assert_eq!(places(&positions), [0, 0]);
    }
}
