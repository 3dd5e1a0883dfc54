//! E_R: components without markers follow those that have them (Zhou et al. 2010, section 2.2, eq. 4).

use mimesh_core::{mesh::Surface, operators::Tetrahedron, stage::ProximityGraph};
use nalgebra::{Matrix3, Point3, Vector3};

/// Most pairs of a link that get elements; more say the same and only fill the matrix.
const MAX_PAIRS: usize = 12;

/// A tetrahedron lower than this part of its base's size counts as flat.
const MIN_RELATIVE_HEIGHT: f64 = 0.1;

/// Two tetrahedra whose deformation gradients are to be alike, one on a triangle of each component of a link, and the
/// stiffness of the link.
pub type LinkElements = (Tetrahedron, Tetrahedron, f64);

/// For some vertex pairs of each link, the two tetrahedra made of a triangle on one side and a vertex of the triangle on the
/// other: of the triangles around the two vertices, those farthest apart along their normals.
///
/// Where the two triangles are coplanar, their own elements, with their fourth vertices, stand in.
pub fn link_elements(
    rest: &[Point3<f64>],
    surface: &Surface,
    graph: &ProximityGraph,
    own: &[Option<Tetrahedron>],
) -> Vec<LinkElements> {
    let mut around = vec![Vec::new(); rest.len()];
    for (t, corners) in surface.triangles.iter().enumerate().filter(|(t, _)| own[*t].is_some()) {
        corners.iter().for_each(|&v| around[v as usize].push(t));
    }
    let mut result = Vec::new();
    for link in graph.links() {
        let step = link.pairs.len().div_ceil(MAX_PAIRS).max(1);
        for &[i, j] in link.pairs.iter().step_by(step) {
            let Some((a, b)) = opposite(rest, surface, &around[i as usize], &around[j as usize]) else { continue };
            let on_a = tetrahedron(rest, surface.triangles[a], surface.triangles[b]);
            let on_b = tetrahedron(rest, surface.triangles[b], surface.triangles[a]);
            let elements = on_a.zip(on_b).or_else(|| Some((own[a].clone()?, own[b].clone()?)));
            result.extend(elements.map(|(on_a, on_b)| (on_a, on_b, link.stiffness)));
        }
    }
    result
}

/// arg max |h · n_a| + |h · n_b| over triangles a, b of the two sides, h between their barycentres.
fn opposite(rest: &[Point3<f64>], surface: &Surface, left: &[usize], right: &[usize]) -> Option<(usize, usize)> {
    let of = |t: &usize| {
        let [a, b, c] = surface.corners(rest, *t);
        let normal = (b - a).cross(&(c - a)).normalize();
        (*t, (a.coords + b.coords + c.coords) / 3.0, normal)
    };
    let right: Vec<(usize, Vector3<f64>, Vector3<f64>)> = right.iter().map(of).collect();
    let mut best = None;
    for (a, at_a, normal_a) in left.iter().map(of) {
        for &(b, at_b, normal_b) in &right {
            let h = at_b - at_a;
            let apart = h.dot(&normal_a).abs() + h.dot(&normal_b).abs();
            if best.is_none_or(|(most, _)| apart > most) {
                best = Some((apart, (a, b)));
            }
        }
    }
    best.map(|(_, pair)| pair)
}

/// The tetrahedron on `base` with the corner of `other` that stands highest over it; `None` if it is flat.
fn tetrahedron(rest: &[Point3<f64>], base: [u32; 3], other: [u32; 3]) -> Option<Tetrahedron> {
    let [a, b, c] = base.map(|v| rest[v as usize]);
    let normal = (b - a).cross(&(c - a));
    let height = |v: u32| (rest[v as usize] - a).dot(&normal).abs() / normal.norm();
    let apex = other.into_iter().max_by(|&v, &w| height(v).total_cmp(&height(w)))?;
    if height(apex) < MIN_RELATIVE_HEIGHT * normal.norm().sqrt() {
        return None;
    }
    let frame = Matrix3::from_columns(&[b - a, c - a, rest[apex as usize] - a]);
    Some(Tetrahedron::new([base[0], base[1], base[2], apex], &frame))
}
