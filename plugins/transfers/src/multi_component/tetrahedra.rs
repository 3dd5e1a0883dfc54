//! Tetrahedra across gaps, which the linear method of Zhou et al. 2010 (figure 7 d) wants to deform alike.

use mimesh_core::{mesh::Surface, operators::Tetrahedron, stage::ProximityGraph};
use nalgebra::{Matrix3, Point3, Vector3};

/// A tetrahedron lower than this part of its base's size counts as flat.
const MIN_RELATIVE_HEIGHT: f64 = 0.1;

/// Two tetrahedra on two triangles that face each other across a gap.
#[derive(Debug)]
pub struct Bridge {
    pub elements: [Tetrahedron; 2],
    pub triangles: [u32; 2],
    /// The stiffness of the link.
    pub stiffness: f64,
}

/// A bridge for each pair of vertices (section 2.2): of the triangles a, b around the two, those with the largest
/// |h · n_a| + |h · n_b|, h being the way between their middles; on each the tetrahedron with a vertex of the other.
///
/// Where these are flat, both take the fourth vertex of a, an unknown of its own: `unknowns` is counted up.
pub fn bridges(target: &Surface, graph: Option<&ProximityGraph>, unknowns: &mut usize) -> Vec<Bridge> {
    let Some(graph) = graph else { return vec![] };
    let around = target.triangles_around();
    let mut result = Vec::new();
    for link in graph.links() {
        for &[i, j] in &link.pairs {
            let Some([a, b]) = opposite(target, &around[i as usize], &around[j as usize]) else { continue };
            let corners = [a, b].map(|t| target.triangles[t as usize]);
            let elements =
                match [over_other(target, corners[0], corners[1]), over_other(target, corners[1], corners[0])] {
                    [Some(on_a), Some(on_b)] => [on_a, on_b],
                    _ => {
                        let Some(elements) = over_fourth(target, [a, b], *unknowns as u32) else { continue };
                        *unknowns += 1;
                        elements
                    }
                };
            result.push(Bridge { elements, triangles: [a, b], stiffness: link.stiffness });
        }
    }
    result
}

/// The middle and the unit normal of a triangle; `None` without area.
fn plane(target: &Surface, t: u32) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let [a, b, c] = target.corners(&target.positions, t as usize);
    Some(((a.coords + b.coords + c.coords) / 3.0, (b - a).cross(&(c - a)).try_normalize(0.0)?))
}

fn opposite(target: &Surface, left: &[u32], right: &[u32]) -> Option<[u32; 2]> {
    let mut best: Option<(f64, [u32; 2])> = None;
    for &a in left {
        let Some((at_a, normal_a)) = plane(target, a) else { continue };
        for &b in right {
            let Some((at_b, normal_b)) = plane(target, b) else { continue };
            let way = at_b - at_a;
            let apart = way.dot(&normal_a).abs() + way.dot(&normal_b).abs();
            if best.is_none_or(|(most, _)| apart > most) {
                best = Some((apart, [a, b]));
            }
        }
    }
    best.map(|(_, pair)| pair)
}

/// The tetrahedron on `base` with the corner of `other` that stands highest over it; `None` if it is flat.
fn over_other(target: &Surface, base: [u32; 3], other: [u32; 3]) -> Option<Tetrahedron> {
    let apex = |height: &dyn Fn(Point3<f64>) -> f64| {
        let of = |v: u32| height(target.positions[v as usize]);
        other.into_iter().max_by(|&v, &w| of(v).total_cmp(&of(w)))
    };
    let [a, b, c] = base.map(|v| target.positions[v as usize]);
    let normal = (b - a).cross(&(c - a));
    let height = |p: Point3<f64>| (p - a).dot(&normal).abs() / normal.norm();
    let apex = apex(&height)?;
    let at = target.positions[apex as usize];
    (height(at) >= MIN_RELATIVE_HEIGHT * normal.norm().sqrt()).then(|| {
        let frame = Matrix3::from_columns(&[b - a, c - a, at - a]);
        Tetrahedron::new([base[0], base[1], base[2], apex], &frame)
    })
}

/// Tetrahedra on both triangles with the fourth vertex of the first; `None` if that lies in the plane of the second.
fn over_fourth(target: &Surface, [a, b]: [u32; 2], fourth: u32) -> Option<[Tetrahedron; 2]> {
    let corners = target.corners(&target.positions, a as usize);
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let at = corners[0] + normal / normal.norm().sqrt();
    let [p, q, r] = target.corners(&target.positions, b as usize);
    let frame = Matrix3::from_columns(&[q - p, r - p, at - p]);
    frame.is_invertible().then(|| {
        let [i, j, k] = target.triangles[b as usize];
        [Tetrahedron::over(target.triangles[a as usize], fourth, &corners), Tetrahedron::new([i, j, k, fourth], &frame)]
    })
}
