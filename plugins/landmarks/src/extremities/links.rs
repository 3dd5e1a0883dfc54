//! One graph over the points of a cloud, for meshes as for plates and stones.

use std::collections::HashMap;

use mimesh_core::spatial::EdgePaths;
use nalgebra::Point3;
use petgraph::unionfind::UnionFind;

use super::cloud::Cloud;

/// The length of the longest links, in spacings: a point then has about seven to each side of it.
const REACH: f64 = 1.55;

/// Points of one component whose normals have a smaller product face each other, as two legs do, or the sides of a sheet.
const MIN_FACING: f64 = -0.3;

/// Paths along links between near points of `cloud`, which join all of it.
///
/// Points of one component are not linked where they face each other. Pieces that are left over are joined to the nearest point of the
/// rest, the smallest first.
pub fn paths(cloud: &Cloud) -> EdgePaths {
    let places = &cloud.places;
    let faces = |a: usize, b: usize| cloud.normals[a].dot(&cloud.normals[b]) < MIN_FACING;
    let mut links = near_pairs(places, REACH * cloud.spacing);
    links.retain(|&[a, b]| {
        let (a, b) = (a as usize, b as usize);
        cloud.components[a] != cloud.components[b] || !faces(a, b)
    });
    let mut pieces = UnionFind::new(places.len());
    links.iter().for_each(|&[a, b]| _ = pieces.union(a as usize, b as usize));
    while let Some([a, b]) = shortest_from_smallest(places, &pieces.clone().into_labeling()) {
        pieces.union(a, b);
        links.push([a as u32, b as u32]);
    }
    EdgePaths::new(places, &[], &links)
}

/// The pairs of `places` within `reach` of each other, smaller number first, ascending, by a grid of cells of that size.
fn near_pairs(places: &[Point3<f64>], reach: f64) -> Vec<[u32; 2]> {
    let cell = |p: &Point3<f64>| [p.x, p.y, p.z].map(|x| (x / reach).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    (0u32..).zip(places).for_each(|(k, p)| cells.entry(cell(p)).or_default().push(k));
    let mut pairs = Vec::new();
    for (a, p) in (0u32..).zip(places) {
        let [x, y, z] = cell(p);
        let around = (0..27).map(|s| [x + s % 3 - 1, y + s / 3 % 3 - 1, z + s / 9 - 1]);
        let near = around.filter_map(|c| cells.get(&c)).flatten().copied();
        let mut near: Vec<u32> = near.filter(|&b| b > a && (places[b as usize] - p).norm() <= reach).collect();
        near.sort_unstable();
        pairs.extend(near.into_iter().map(|b| [a, b]));
    }
    pairs
}

/// The closest points of the smallest piece and of the rest; `None` if all is one piece. `piece_of` labels the pieces.
fn shortest_from_smallest(places: &[Point3<f64>], piece_of: &[usize]) -> Option<[usize; 2]> {
    let mut sizes = vec![0; places.len()];
    piece_of.iter().for_each(|&piece| sizes[piece] += 1);
    let smallest = (0..sizes.len()).filter(|&piece| sizes[piece] > 0).min_by_key(|&piece| sizes[piece])?;
    let (own, rest): (Vec<usize>, Vec<usize>) = (0..places.len()).partition(|&k| piece_of[k] == smallest);
    let pairs = own.iter().flat_map(|&a| rest.iter().map(move |&b| [a, b]));
    pairs.min_by(|x, y| {
        let length = |[a, b]: &[usize; 2]| (places[*b] - places[*a]).norm_squared();
        length(x).total_cmp(&length(y))
    })
}
