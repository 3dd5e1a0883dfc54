//! E_R: components without markers follow those that have them (Zhou et al. 2010, section 2.2, eq. 4).

use std::cell::OnceCell;

use mimesh_core::{
    mesh::{Components, Surface},
    operators::Tetrahedron,
    stage::{Link, ProximityGraph},
};
use nalgebra::{Matrix3, Point3, Vector3};

/// A tetrahedron lower than this part of its base's size counts as flat.
const MIN_RELATIVE_HEIGHT: f64 = 0.1;

/// Two tetrahedra whose deformation gradients are to be alike, one on a triangle of each component of a link, and the
/// stiffness of the link.
pub type LinkElements = (Tetrahedron, Tetrahedron, f64);

/// For some vertex pairs of each link, the two tetrahedra made of a triangle on one side and a vertex of the triangle on the
/// other: of the triangles around the two vertices, those farthest apart along their normals.
///
/// A vertex without a sound triangle has the sound triangle of its component that is nearest to it, if there is one. Where the two
/// triangles are coplanar, their own elements, with their fourth vertices, stand in.
pub fn link_elements(
    rest: &[Point3<f64>],
    surface: &Surface,
    graph: &ProximityGraph,
    own: &[Option<Tetrahedron>],
    most_pairs: Option<usize>,
) -> Vec<LinkElements> {
    let sound = SoundTriangles::new(rest, surface, &graph.components, own);
    let mut result = Vec::new();
    for link in graph.links() {
        for [i, j] in spread_pairs(link, most_pairs) {
            let Some((a, b)) = opposite(rest, surface, &sound.near(i), &sound.near(j)) else { continue };
            let on_a = tetrahedron(rest, surface.triangles[a], surface.triangles[b]);
            let on_b = tetrahedron(rest, surface.triangles[b], surface.triangles[a]);
            let elements = on_a.zip(on_b).or_else(|| Some((own[a].clone()?, own[b].clone()?)));
            result.extend(elements.map(|(on_a, on_b)| (on_a, on_b, link.stiffness)));
        }
    }
    result
}

/// The vertex pairs of a link that get elements: at most so many, or all, spread over the link.
pub fn spread_pairs(link: &Link, most: Option<usize>) -> impl Iterator<Item = [u32; 2]> {
    let step = link.pairs.len().div_ceil(most.unwrap_or(usize::MAX)).max(1);
    link.pairs.iter().copied().step_by(step)
}

/// The triangles that have an element.
struct SoundTriangles<'a> {
    rest: &'a [Point3<f64>],
    surface: &'a Surface,
    components: &'a Components,
    /// Those around each vertex.
    around: Vec<Vec<usize>>,
    /// Those of each component; made when a vertex has none around it.
    of_component: OnceCell<Vec<Vec<usize>>>,
}

impl<'a> SoundTriangles<'a> {
    fn new(
        rest: &'a [Point3<f64>],
        surface: &'a Surface,
        components: &'a Components,
        own: &[Option<Tetrahedron>],
    ) -> Self {
        let mut around = vec![Vec::new(); rest.len()];
        for (t, corners) in surface.triangles.iter().enumerate().filter(|(t, _)| own[*t].is_some()) {
            corners.iter().for_each(|&v| around[v as usize].push(t));
        }
        Self { rest, surface, components, around, of_component: OnceCell::new() }
    }

    /// Those around vertex `v`, or else the nearest of its component.
    fn near(&self, v: u32) -> Vec<usize> {
        let around = &self.around[v as usize];
        if !around.is_empty() {
            return around.clone();
        }
        let Some(component) = self.components.of_vertex[v as usize] else { return vec![] };
        let of_component = &self.of_component.get_or_init(|| self.by_component())[component as usize];
        let distance = |t: &usize| {
            let corners = self.surface.corners(self.rest, *t);
            corners.iter().map(|p| (p - self.rest[v as usize]).norm_squared()).fold(f64::INFINITY, f64::min)
        };
        of_component.iter().copied().min_by(|s, t| distance(s).total_cmp(&distance(t))).into_iter().collect()
    }

    fn by_component(&self) -> Vec<Vec<usize>> {
        let mut result = vec![Vec::new(); self.components.count()];
        for (v, around) in self.around.iter().enumerate() {
            // Each triangle once, at its first corner.
            let first = around.iter().filter(|&&t| self.surface.triangles[t][0] as usize == v);
            if let Some(component) = self.components.of_vertex[v] {
                result[component as usize].extend(first);
            }
        }
        result
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pairs_count_or_some_that_are_spread_over_the_link() {
        let pairs: Vec<[u32; 2]> = (0..100).map(|i| [i, 100 + i]).collect();
        let link = Link { components: [0, 1], distance: 1.0, in_tree: true, stiffness: 1.0, pairs: pairs.clone() };
        assert!(spread_pairs(&link, None).eq(pairs));
        let some: Vec<_> = spread_pairs(&link, Some(12)).collect();
        assert!(some.len() <= 12 && some[0] == [0, 100] && some[some.len() - 1][0] > 88, "{some:?}");
        assert!(spread_pairs(&link, Some(200)).eq(link.pairs.clone()));
    }
}
