//! Components whose triangles point inwards.

use nalgebra::Point3;
use petgraph::unionfind::UnionFind;

use super::{Components, Surface};

/// Closed components of a smaller volume, relative to their area to the power 3/2, have none but for rounding.
const MIN_CLOSED_VOLUME: f64 = 1e-9;

/// Open components of a smaller volume under caps over their holes have no inside; half a sphere has 0.13.
const MIN_OPEN_VOLUME: f64 = 0.05;

/// Components whose holes have no more of their area enclose a volume as closed ones do, however thin their limbs are.
const MAX_HOLES: f64 = 0.1;

/// So many triangles and boxes are looked at, for whether components lie within others; about a second.
///
/// Beyond, on surfaces of very many components, one goes with most of the others.
const MAX_LOOKS: usize = 1 << 28;

/// The components of `surface` whose triangles point inwards, ascending.
///
/// A closed component points inwards if the volume that it encloses is negative. Within another one it may be the wall of a cavity,
/// and goes with most of the others. So do components that are open or flat, since some point inwards by right, like the socket of an
/// eye. Most of the area decides, with caps over holes.
pub fn inward_components(surface: &Surface) -> Vec<u32> {
    let components = surface.components();
    let all = enclosed(surface, &components);
    let outwards: f64 = all.iter().filter(|one| one.volume != 0.0).map(|one| one.area * one.volume.signum()).sum();
    let most = outwards < 0.0;
    let mut within = Within::new(surface, &components, &all);
    let points_inwards = |c: &usize| {
        let own = all[*c].volume < 0.0;
        let decides = all[*c].closed && all[*c].volume != 0.0;
        let differs = decides && own != most && !within.another(*c);
        if differs { own } else { most }
    };
    (0..all.len()).filter(points_inwards).map(|c| c as u32).collect()
}

/// What a component encloses.
#[derive(Clone, Copy, Debug)]
struct Enclosed {
    /// One of its vertices.
    first: Point3<f64>,
    /// The corners of its bounding box.
    bounds: [Point3<f64>; 2],
    /// The area of its triangles.
    area: f64,
    /// The area of caps over its holes.
    holes: f64,
    /// Its volume under caps over its holes, negative if triangles point inwards; 0 if it has no inside.
    volume: f64,
    /// Whether it has no holes.
    closed: bool,
}

/// What each component encloses.
fn enclosed(surface: &Surface, components: &Components) -> Vec<Enclosed> {
    let of = |v: u32| components.of_vertex[v as usize].unwrap_or_default() as usize;
    let mut all: Vec<Option<Enclosed>> = vec![None; components.count()];
    for (p, component) in surface.positions.iter().zip(&components.of_vertex) {
        let Some(c) = component else { continue };
        let empty = Enclosed { first: *p, bounds: [*p; 2], area: 0.0, holes: 0.0, volume: 0.0, closed: true };
        let [low, high] = &mut all[*c as usize].get_or_insert(empty).bounds;
        (*low, *high) = (low.inf(p), high.sup(p));
    }
    let mut all: Vec<Enclosed> = all.into_iter().flatten().collect();
    // About a vertex of the component itself no digits are lost far from the origin.
    let volume = |first: Point3<f64>, corners: [Point3<f64>; 3]| {
        let [p, q, r] = corners.map(|corner| corner - first);
        p.cross(&q).dot(&r) / 6.0
    };
    for (t, area_normal) in surface.area_normals(&surface.positions).iter().enumerate() {
        let one = &mut all[of(surface.triangles[t][0])];
        one.area += area_normal.norm() / 2.0;
        one.volume += volume(one.first, surface.corners(&surface.positions, t));
    }
    let boundary = surface.topology().boundary;
    for (edge, apex) in boundary.iter().zip(apexes(surface, &boundary)) {
        let one = &mut all[of(edge[0])];
        let [from, to] = edge.map(|v| surface.positions[v as usize]);
        one.closed = false;
        one.holes += (from - apex).cross(&(to - apex)).norm() / 2.0;
        one.volume += volume(one.first, [to, from, apex]);
    }
    for one in &mut all {
        let least = if one.holes <= MAX_HOLES * one.area { MIN_CLOSED_VOLUME } else { MIN_OPEN_VOLUME };
        if one.volume.abs() <= least * one.area.powf(1.5) {
            one.volume = 0.0;
        }
    }
    all
}

/// For each boundary edge the tip of the cap over its hole: the mean of all edges that are joined with it.
fn apexes(surface: &Surface, boundary: &[[u32; 2]]) -> Vec<Point3<f64>> {
    let n = surface.vertex_count();
    let mut holes = UnionFind::<u32>::new(n);
    boundary.iter().for_each(|&[a, b]| _ = holes.union(a, b));
    let mut sums = vec![(Point3::origin().coords, 0.0); n];
    for &[a, b] in boundary {
        let (sum, count) = &mut sums[holes.find_mut(a) as usize];
        *sum += surface.positions[a as usize].coords + surface.positions[b as usize].coords;
        *count += 2.0;
    }
    let apex = |&[a, _]: &[u32; 2]| {
        let (sum, count) = sums[holes.find(a) as usize];
        Point3::from(sum / count)
    };
    boundary.iter().map(apex).collect()
}

/// Whether components lie within others.
struct Within<'a> {
    surface: &'a Surface,
    all: &'a [Enclosed],
    /// The triangles of each component.
    triangles: Vec<Vec<u32>>,
    looks: usize,
}

impl<'a> Within<'a> {
    fn new(surface: &'a Surface, components: &Components, all: &'a [Enclosed]) -> Self {
        let mut triangles = vec![Vec::new(); all.len()];
        for (t, corners) in (0..).zip(&surface.triangles) {
            triangles[components.of_vertex[corners[0] as usize].unwrap_or_default() as usize].push(t);
        }
        Self { surface, all, triangles, looks: 0 }
    }

    /// Whether a vertex of component `c` lies inside another closed component, or there are too many to look.
    fn another(&mut self, c: usize) -> bool {
        let point = self.all[c].first;
        for other in 0..self.all.len() {
            self.looks += 1;
            let Enclosed { bounds: [low, high], closed, volume, .. } = self.all[other];
            let may_enclose =
                other != c && closed && volume != 0.0 && (0..3).all(|k| (low[k]..=high[k]).contains(&point[k]));
            if may_enclose {
                // An angle takes ten times as long as a box.
                self.looks += 10 * self.triangles[other].len();
                if winding_number(self.surface, &point, &self.triangles[other]).abs() > 0.5 {
                    return true;
                }
            }
            if self.looks > MAX_LOOKS {
                return true;
            }
        }
        false
    }
}

/// How often `triangles` wind around `point` (Van Oosterom and Strackee 1983).
fn winding_number(surface: &Surface, point: &Point3<f64>, triangles: &[u32]) -> f64 {
    let solid_angle = |&triangle: &u32| {
        let [a, b, c] = surface.triangles[triangle as usize].map(|v| surface.positions[v as usize] - point);
        let (x, y, z) = (a.norm(), b.norm(), c.norm());
        let below = x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y;
        2.0 * a.cross(&b).dot(&c).atan2(below)
    };
    let sum: f64 = triangles.iter().map(solid_angle).sum();
    sum / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    /// The surfaces side by side as one, each scaled, moved along x and turned inside out or not.
    fn together(parts: &[(&Surface, f64, f64, bool)]) -> Surface {
        let (mut positions, mut triangles) = (vec![], vec![]);
        for &(part, scale, along, inwards) in parts {
            let first = positions.len() as u32;
            positions.extend(part.positions.iter().map(|p| Point3::new(scale * p.x + along, scale * p.y, scale * p.z)));
            let order = |[a, b, c]: [u32; 3]| if inwards { [c, b, a] } else { [a, b, c] };
            triangles.extend(part.triangles.iter().map(|t| order(*t).map(|v| v + first)));
        }
        Surface::from_triangles(positions, triangles).unwrap()
    }

    #[test]
    fn each_closed_component_speaks_for_itself() {
        let sphere = meshes::icosphere(1);
        let all = |inwards: [bool; 3]| {
            let at = |i: usize| (&sphere, 1.0, 1e4 + 3.0 * i as f64, inwards[i]);
            inward_components(&together(&[at(0), at(1), at(2)]))
        };
        assert_eq!(all([false, false, false]), [0u32; 0]);
        assert_eq!(all([false, true, false]), [1]);
        assert_eq!(all([true, true, false]), [0, 1]);
        assert_eq!(all([true, true, true]), [0, 1, 2]);
    }

    #[test]
    fn the_wall_of_a_cavity_goes_with_what_is_around_it() {
        let sphere = meshes::icosphere(1);
        let shell =
            |outer, inner| inward_components(&together(&[(&sphere, 1.0, 0.0, outer), (&sphere, 0.5, 0.0, inner)]));
        assert_eq!(shell(false, true), [0u32; 0], "a hollow sphere");
        assert_eq!(shell(true, false), [0, 1], "the same, inside out");
        assert_eq!(shell(false, false), [0u32; 0], "an eye in a head");
        assert_eq!(shell(true, true), [0, 1], "the same, inside out");
    }

    /// An animal with holes for its eyes has little volume for its area, and eyes that point inwards must not decide for it.
    #[test]
    fn a_thin_component_with_small_holes_has_an_inside() {
        let sphere = meshes::icosphere(1);
        let mut bar = meshes::bar([40, 1, 1], [40.0, 1.0, 1.0]);
        bar.triangles.remove(0);
        let eye_inwards = (&sphere, 0.2, 60.0, true);
        assert_eq!(inward_components(&together(&[(&bar, 1.0, 0.0, false), eye_inwards])), [1]);
        assert_eq!(inward_components(&together(&[(&bar, 1.0, 0.0, true), eye_inwards])), [0, 1]);
    }

    #[test]
    fn open_components_go_with_most_of_the_area() {
        let sphere = meshes::icosphere(4);
        let cap = |above: f64| {
            let is_kept = |t: &&[u32; 3]| t.iter().all(|&v| sphere.positions[v as usize].z >= above);
            Surface::from_triangles(
                sphere.positions.clone(),
                sphere.triangles.iter().filter(is_kept).copied().collect(),
            )
            .unwrap()
        };
        let (mask, sheet) = (cap(0.0), meshes::grid(3, 3));
        assert_eq!(inward_components(&mask), [0u32; 0]);
        assert_eq!(inward_components(&together(&[(&mask, 1.0, 0.0, true)])), [0]);
        // A sheet has no inside, and nor has a plate that is bent a little.
        for flat in [&sheet, &cap(0.97)] {
            assert_eq!(inward_components(&together(&[(flat, 1.0, 0.0, true)])), [0u32; 0]);
        }
        // A socket in a head points inwards by right; in a head inside out it goes with the head.
        assert_eq!(inward_components(&together(&[(&sphere, 1.0, 0.0, false), (&mask, 0.2, 0.0, true)])), [0u32; 0]);
        assert_eq!(inward_components(&together(&[(&mask, 1.0, 0.0, true), (&mask, 0.2, 3.0, false)])), [0, 1]);
    }
}
