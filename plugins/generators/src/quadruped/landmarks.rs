//! Named points at the same places of every animal.

use mimesh_core::{
    Result,
    mesh::{Landmark, MeshPoint},
    spatial::ClosestPoint,
};
use nalgebra::{Point3, Vector3};

use super::body::{Body, Limb, Part};

/// The direction in which a landmark lies from the centre line of its limb.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// The back of the trunk, the front of a leg.
    Front,
    /// The belly, the back of a leg.
    Back,
    /// The animal's left.
    Left,
    /// The animal's right.
    Right,
    /// Away from the middle.
    Outer,
    /// Along the limb.
    Tip,
    /// Against it.
    Root,
}
use Way::{Back, Front, Left, Outer, Right, Root, Tip};

const SPINE: &[(&str, f64, Way)] = &[
    ("rump", 0.0, Root),
    ("croup", 1.0, Front),
    ("loin", 2.2, Front),
    ("withers", 5.0, Front),
    ("flank_left", 2.4, Left),
    ("flank_right", 2.4, Right),
    ("belly", 3.0, Back),
    ("chest", 5.6, Back),
    ("crest_low", 6.6, Front),
    ("crest", 8.0, Front),
    ("crest_high", 9.2, Front),
    ("throat_low", 7.0, Back),
    ("throat", 8.2, Back),
    ("throat_high", 9.3, Back),
    ("neck_left", 7.6, Left),
    ("neck_right", 7.6, Right),
    ("forehead", 11.0, Front),
    ("cheek_left", 11.0, Left),
    ("cheek_right", 11.0, Right),
    ("jaw", 11.4, Back),
    ("nose", 13.0, Tip),
    ("nostril_left", 12.7, Left),
    ("nostril_right", 12.7, Right),
];

const FRONT: &[(&str, f64, Way)] = &[
    ("shoulder", 0.3, Outer),
    ("elbow", 3.0, Outer),
    ("forearm_front", 3.8, Front),
    ("forearm_back", 3.8, Back),
    ("knee_front", 6.0, Front),
    ("knee_back", 6.0, Back),
    ("knee_outer", 6.0, Outer),
    ("fetlock_front", 9.0, Front),
    ("fetlock_back", 9.0, Back),
    ("fetlock_outer", 9.0, Outer),
    ("hoof_front", 11.6, Front),
    ("hoof_back", 11.6, Back),
    ("sole", 11.8, Tip),
];

const HIND: &[(&str, f64, Way)] = &[
    ("hip", 0.3, Outer),
    ("buttock", 1.6, Back),
    ("stifle_front", 2.9, Front),
    ("stifle_outer", 3.2, Outer),
    ("gaskin_front", 4.4, Front),
    ("gaskin_back", 4.4, Back),
    ("hock_front", 6.0, Front),
    ("hock_back", 6.0, Back),
    ("hock_outer", 6.0, Outer),
    ("fetlock_front", 9.0, Front),
    ("fetlock_back", 9.0, Back),
    ("fetlock_outer", 9.0, Outer),
    ("hoof_front", 11.6, Front),
    ("hoof_back", 11.6, Back),
    ("sole", 11.8, Tip),
];

const TAIL: &[(&str, f64, Way)] = &[("dock", 1.0, Back), ("tail", 2.4, Back), ("tail_tip", 4.0, Tip)];

const EAR: &[(&str, f64, Way)] = &[("ear_root", 0.4, Outer), ("ear_tip", 2.0, Tip)];

/// A point to be found on the body's surface.
#[derive(Debug)]
pub struct LandmarkSite {
    /// The name of the landmark.
    pub name: String,
    /// The point on the surface of the body.
    pub at: Point3<f64>,
}

/// The landmarks of `body` on its surface.
pub fn places(body: &Body) -> Vec<LandmarkSite> {
    let mut result = vec![];
    for part in &body.parts {
        let side = if part.right { "right" } else { "left" };
        let (points, prefix) = match part.limb {
            Limb::Spine => (SPINE, String::new()),
            Limb::Front => (FRONT, format!("{side}_front_")),
            Limb::Hind => (HIND, format!("{side}_hind_")),
            Limb::Tail => (TAIL, String::new()),
            Limb::Ear => (EAR, format!("{side}_")),
            // Not every animal has horns.
            Limb::Horn => continue,
        };
        for &(name, s, way) in points {
            result.push(LandmarkSite { name: format!("{prefix}{name}"), at: on_surface(body, part, s, way) });
        }
    }
    result
}

/// The landmarks of `body` on the mesh of its surface.
pub fn on_skin(body: &Body, positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Landmark> {
    let mut around = vec![vec![]; positions.len()];
    for (t, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|&v| around[v as usize].push(t as u32));
    }
    let landmark =
        |place: LandmarkSite| Landmark { point: nearest(&place.at, positions, triangles, &around), name: place.name };
    places(body).into_iter().map(landmark).collect()
}

/// The landmarks of `body` on a mesh of pieces: each at the nearest point whose side faces outwards as the skin does.
///
/// # Errors
///
/// [`Error::Data`](mimesh_core::Error::Data) if there is no triangle.
pub fn on_pieces(body: &Body, positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Vec<Landmark>> {
    let search = ClosestPoint::new(positions, triangles)?;
    let outwards = |triangle: u32, skin: &Vector3<f64>, least: f64| {
        let [a, b, c] = triangles[triangle as usize].map(|v| positions[v as usize]);
        let normal = (b - a).cross(&(c - a));
        normal.dot(skin) > least * normal.norm()
    };
    let mut result = vec![];
    for LandmarkSite { name, at } in places(body) {
        let skin = body.gradient(&at).normalize();
        // At the tip of a limb nothing may face as the skin does.
        let found = [0.7, 0.0, -2.0].into_iter().find_map(|least| {
            let near = if least > 0.0 { body.thickness(&at) } else { f64::INFINITY };
            search.find(&at, near, |t| outwards(t, &skin, least))
        });
        if let Some(found) = found {
            result.push(Landmark { name, point: MeshPoint::Triangle(found.triangle, found.barycentric) });
        }
    }
    Ok(result)
}

/// The point at which the ray from the centre line at `s` leaves the body.
fn on_surface(body: &Body, part: &Part, s: f64, way: Way) -> Point3<f64> {
    const STEP: f64 = 0.002;
    let (from, tangent) = (part.chain.at(s).at, part.chain.tangent(s));
    let front = Vector3::new(0.0, tangent.z, -tangent.y).normalize();
    let outward = if part.right { -1.0 } else { 1.0 };
    let direction = match way {
        Front => front,
        Back => -front,
        Left => Vector3::x(),
        Right => -Vector3::x(),
        Outer => Vector3::x() * outward,
        Tip => tangent,
        Root => -tangent,
    };
    let mut reached = 0.0;
    while body.distance(&(from + direction * reached)) < 0.0 {
        reached += STEP;
    }
    body.project(from + direction * (reached - STEP / 2.0))
}

/// The point of the mesh nearest to `place`, among the triangles around the nearest vertex.
fn nearest(place: &Point3<f64>, positions: &[Point3<f64>], triangles: &[[u32; 3]], around: &[Vec<u32>]) -> MeshPoint {
    let distance = |v: &usize| (positions[*v] - place).norm_squared();
    let vertex = (0..positions.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    let mut best = (distance(&vertex), MeshPoint::Vertex(vertex as u32));
    for &t in &around[vertex] {
        let [a, b, c] = triangles[t as usize].map(|v| positions[v as usize]);
        let (ab, ac, ap) = (b - a, c - a, place - a);
        let (aa, bb, mixed) = (ab.norm_squared(), ac.norm_squared(), ab.dot(&ac));
        let (pa, pb) = (ap.dot(&ab), ap.dot(&ac));
        let area = aa * bb - mixed * mixed;
        let (v, w) = ((bb * pa - mixed * pb) / area, (aa * pb - mixed * pa) / area);
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            let away = (ap - ab * v - ac * w).norm_squared();
            if away < best.0 {
                best = (away, MeshPoint::Triangle(t, [1.0 - v - w, v, w]));
            }
        }
    }
    best.1
}
