//! A procedural quadruped: horse, camel or giraffe, standing, walking or galloping.
//!
//! The surface is the zero set of smoothly joined limbs (`body`, `animals`), made a mesh by marching tetrahedra
//! (`polygonise`) and `remesh`ing; it moves with a `gait` by a rule (`skin`) whose rotations are the same for
//! every animal. It is a skin, or `pieces`: `pebbles`, `plates` or `boxes` that move with the body. So
//! the poses of one animal are what a good transfer from another should give.

mod animals;
mod body;
mod boxes;
mod chain;
mod gait;
mod landmarks;
mod pebbles;
mod pieces;
mod plates;
mod polygonise;
mod remesh;
mod sites;
mod skin;

use mimesh_core::{
    Error, Result,
    mesh::{Landmark, Mesh, MeshSequence, Pose, Surface},
    plugin::check_ranges,
    register,
    stage::Generator,
};
use nalgebra::{Point3, Rotation3, Vector3};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::gait::Gait;
use self::{
    animals::Animal,
    body::{Body, Part},
    pieces::Pieces,
    skin::Skin,
};

register!(Generator: Quadruped);

/// A procedural four-legged animal with a gait, for trying things and for tests: no file is needed.
///
/// A skin, one closed, manifold component of well-shaped triangles, or many closed components in its shape: pebbles, plates or
/// the boxes of a robot. Mirror-symmetric in shape, y up and facing +z, standing on y = 0. Joints turn by the same angles on every animal, so its poses are the known result of a transfer from another
/// animal; some seventy landmarks of equal names on every animal serve as markers.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Quadruped {
    /// The animal.
    pub proportions: Proportions,
    /// The gait.
    pub gait: Gait,
    /// Poses through one stride, named by their number; the stride closes, the first follows the last.
    #[schemars(range(min = 1, max = 1000))]
    pub frames: usize,
    /// The material: one skin, or many components.
    pub made_of: MadeOf,
    /// About how many pebbles or plates it is made of; left out, 200 pebbles or 60 plates. A skin is one, and how many boxes
    /// a robot has is a matter of its limbs.
    #[schemars(range(min = 20, max = 5000))]
    pub pieces: Option<usize>,
    /// Edges of triangles along the length of the body; thin parts have shorter edges. 60 give about 7000 vertices.
    #[schemars(range(min = 20, max = 1000))]
    pub resolution: usize,
    /// Length of a metre in the unit of the mesh: 1 gives metres, 100 centimetres.
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub size: f64,
    /// Another number gives other triangles of the same shape, and other pebbles and plates; boxes stay as they are.
    pub seed: u64,
}

/// The animals that [`Quadruped`] knows.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Proportions {
    /// A horse, 1.55 m at the withers.
    #[default]
    Horse,
    /// A dromedary, its hump 2.1 m high.
    Camel,
    /// A giraffe, 4.7 m high.
    Giraffe,
}

/// The material of a [`Quadruped`]: one skin, or many closed components.
///
/// Components have names, each its own, and are grouped by the region of the body: trunk, neck, head, `left_front_leg` …
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MadeOf {
    /// One closed surface.
    #[default]
    Skin,
    /// Rounded pebbles side by side below the skin, `trunk_1`, `trunk_2` …, each moved rigidly, as nearly as the body moves
    /// there.
    Pebbles,
    /// Plates cut from the skin, `trunk_1`, `trunk_2` …, with gaps between them; their outer sides move as the skin, their
    /// inner sides stay below at a constant depth.
    Plates,
    /// The boxes of a robot, `pelvis`, `head`, `left_front_shin` …, each moved rigidly, as nearly as the body moves there.
    Boxes,
}

impl Default for Quadruped {
    fn default() -> Self {
        Self {
            proportions: Proportions::Horse,
            gait: Gait::Gallop,
            frames: 12,
            made_of: MadeOf::Skin,
            pieces: None,
            resolution: 60,
            size: 1.0,
            seed: 0,
        }
    }
}

#[typetag::serde(name = "quadruped")]
impl Generator for Quadruped {
    fn make(&self) -> Result<MeshSequence> {
        check_ranges(self)?;
        let count = self.count()?;
        let body = Body::new(self.proportions.animal());
        if self.made_of == MadeOf::Boxes {
            return self.of_pieces(&body, &boxes::boxes(&body, 1.5 * self.edge(&body)));
        }
        let (positions, triangles) = self.mesh(&body);
        match self.made_of {
            MadeOf::Pebbles => {
                let (edge, seed) = (self.edge(&body), self.seed);
                self.of_pieces(&body, &pebbles::pebbles(&body, &positions, &triangles, (count, edge, seed)))
            }
            MadeOf::Plates => self.of_pieces(&body, &plates::plates(&body, &positions, &triangles, (count, self.seed))),
            MadeOf::Skin | MadeOf::Boxes => {
                let landmarks = landmarks::on_skin(&body, &positions, &triangles);
                let skin = Skin::new(&body, &positions);
                let rest = Mesh::from_triangles(positions.clone(), &triangles);
                Ok(self.sequence(rest, landmarks, |time| skin.pose(self.gait, time)))
            }
        }
    }
}

impl Quadruped {
    /// How many pebbles or plates to make.
    fn count(&self) -> Result<usize> {
        let usual = match self.made_of {
            MadeOf::Pebbles => 200,
            MadeOf::Plates => 60,
            MadeOf::Skin | MadeOf::Boxes => match self.pieces {
                None => return Ok(1),
                Some(pieces) => {
                    return Err(Error::Setting {
                        setting: "pieces".into(),
                        expected: "nothing unless `made_of` is pebbles or plates".into(),
                        found: pieces.to_string(),
                    });
                }
            },
        };
        Ok(self.pieces.unwrap_or(usual))
    }

    /// Rest, poses and landmarks of `pieces` of `body`.
    fn of_pieces(&self, body: &Body, pieces: &Pieces) -> Result<MeshSequence> {
        let rest = pieces.mesh();
        let surface = Surface::new(&rest)?;
        let landmarks = landmarks::on_pieces(body, &rest.positions, &surface.triangles)?;
        let skin = pieces.skin(body);
        Ok(self.sequence(rest, landmarks, |time| pieces.moved(&skin.pose(self.gait, time))))
    }

    /// A mesh in metres, its landmarks and its vertices at a time of the stride as what a sample makes.
    fn sequence(
        &self,
        mut rest: Mesh,
        landmarks: Vec<Landmark>,
        at: impl Fn(f64) -> Vec<Point3<f64>> + Sync,
    ) -> MeshSequence {
        let scaled = |positions: &[Point3<f64>]| positions.iter().map(|p| p * self.size).collect::<Vec<_>>();
        let frames = if self.gait == Gait::None { 0 } else { self.frames };
        let digits = frames.to_string().len().max(2);
        let pose = |frame: usize| {
            let positions = scaled(&at(frame as f64 / frames as f64));
            Pose::new(format!("{:0digits$}", frame + 1), positions)
        };
        rest.positions = scaled(&rest.positions);
        MeshSequence { rest, poses: (0..frames).into_par_iter().map(pose).collect(), landmarks, ..Default::default() }
    }

    /// The length of an edge on the trunk, metres.
    fn edge(&self, body: &Body) -> f64 {
        let (low, high) = body.bounds();
        (high.z - low.z) / self.resolution as f64
    }

    /// Vertices (metres) and triangles of `body`.
    fn mesh(&self, body: &Body) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
        let (low, high) = body.bounds();
        let edge = self.edge(body);
        let girth = body.parts[0].chain.at(3.0).width;
        let length = |point: &Point3<f64>| {
            let thickness = body.thickness(point);
            // Thin limbs get shorter edges, and at least some six around.
            let finer = (thickness / girth).powf(0.5).clamp(0.4, 1.1);
            (1.15 * edge * finer).min(0.9 * thickness)
        };
        // The lattice must resolve the thinnest limb; it is turned and moved so that seeds differ in all vertices.
        let thickest = |part: &Part| part.chain.samples.iter().map(|s| s.depth.min(s.width)).fold(0.0, f64::max);
        let thinnest = body.parts.iter().map(thickest).fold(f64::INFINITY, f64::min);
        let cell = (0.6 * edge).min(0.8 * thinnest);
        let turn = Rotation3::from_euler_angles(
            0.3 * fraction(self.seed, 0),
            0.3 * fraction(self.seed, 1),
            0.3 * fraction(self.seed, 2),
        );
        let centre = nalgebra::center(&low, &high);
        let from_lattice = |p: &Point3<f64>| centre + turn * p.coords;
        let corner = |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
        let corners = (0..8).map(|k| turn.inverse() * (corner(k) - centre.coords));
        let reach = corners.fold(Vector3::zeros(), |reach: Vector3<f64>, c| reach.sup(&c.abs()));
        let margin = Vector3::from_fn(|axis, _| cell * (1.5 + fraction(self.seed, 3 + axis as u64)));
        let (positions, triangles) = polygonise::polygonise(
            |p| body.distance(&from_lattice(p)),
            Point3::from(-reach - margin),
            Point3::from(reach + Vector3::repeat(1.5 * cell)),
            cell,
        );
        let positions = positions.iter().map(from_lattice).collect();
        remesh::remesh(positions, triangles, length, |p| body.project(p), 4)
    }
}

impl Proportions {
    fn animal(self) -> &'static Animal {
        match self {
            Self::Horse => &animals::HORSE,
            Self::Camel => &animals::CAMEL,
            Self::Giraffe => &animals::GIRAFFE,
        }
    }
}

/// A number in 0 to 1 for each seed and index, by SplitMix64.
fn fraction(seed: u64, index: u64) -> f64 {
    let mut z = seed.wrapping_mul(8).wrapping_add(index + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use std::{collections::BTreeSet, sync::LazyLock};

    use mimesh_core::mesh::{Statistics, Surface};
    use proptest::prelude::*;

    use super::*;

    const ALL: [Proportions; 3] = [Proportions::Horse, Proportions::Camel, Proportions::Giraffe];

    static ANIMALS: LazyLock<Vec<MeshSequence>> = LazyLock::new(|| {
        ALL.map(|proportions| Quadruped { proportions, ..Quadruped::default() }.make().unwrap()).into()
    });

    fn smallest_angle(surface: &Surface, positions: &[Point3<f64>]) -> f64 {
        let angles = (0..surface.triangle_count()).flat_map(|t| {
            let corners = surface.corners(positions, t);
            (0..3).map(move |k| {
                let (at, to) = (corners[k], [corners[(k + 1) % 3], corners[(k + 2) % 3]]);
                (to[0] - at).angle(&(to[1] - at)).to_degrees()
            })
        });
        angles.fold(180.0, f64::min)
    }

    #[test]
    fn every_animal_is_one_closed_manifold_of_well_shaped_triangles() {
        for animal in ANIMALS.iter() {
            let statistics = Statistics::new(&animal.rest).unwrap();
            assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0));
            assert_eq!((statistics.component_sizes.len(), statistics.degenerate_triangles), (1, 0));
            assert!(statistics.volume.unwrap() > 0.0);
            let genus_zero = 2 * statistics.vertices == statistics.triangles + 4;
            assert!(genus_zero, "no limb grows through another: {} {}", statistics.vertices, statistics.triangles);
            assert!((6000..12000).contains(&statistics.vertices), "{}", statistics.vertices);
            let surface = Surface::new(&animal.rest).unwrap();
            let angle = smallest_angle(&surface, &surface.positions);
            assert!(angle > 20.0, "{angle}");
        }
    }

    #[test]
    fn poses_keep_triangles_in_shape_and_the_volume_of_the_body() {
        for animal in ANIMALS.iter() {
            let surface = Surface::new(&animal.rest).unwrap();
            let volume = |positions: &[Point3<f64>]| {
                let normals = surface.area_normals(positions);
                let sixths =
                    surface.triangles.iter().zip(normals).map(|(t, n)| positions[t[0] as usize].coords.dot(&n));
                sixths.sum::<f64>() / 6.0
            };
            let rest = volume(&animal.rest.positions);
            assert_eq!(animal.poses.len(), 12);
            for pose in &animal.poses {
                // Bending keeps volume to first order; joints that bend by 70° lose some inside.
                let ratio = volume(&pose.positions.get().unwrap()) / rest;
                assert!((ratio - 1.0).abs() < 0.03, "{} {ratio}", pose.name);
                assert!(smallest_angle(&surface, &pose.positions.get().unwrap()) > 2.0, "{}", pose.name);
            }
        }
    }

    /// Where a landmark lies when the vertices of its animal's surface are at `positions`.
    fn place(landmark: &Landmark, surface: &Surface, positions: &[Point3<f64>]) -> Point3<f64> {
        surface.point(landmark.point).unwrap().position(surface, positions)
    }

    #[test]
    fn landmarks_pair_up_between_animals_and_do_not_coincide() {
        let names = |animal: &MeshSequence| animal.landmarks.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
        let expected = names(&ANIMALS[0]);
        assert_eq!(expected.iter().collect::<BTreeSet<_>>().len(), expected.len(), "a name occurs twice");
        for animal in ANIMALS.iter() {
            assert_eq!(names(animal), expected);
            let surface = Surface::new(&animal.rest).unwrap();
            let places: Vec<_> = animal.landmarks.iter().map(|l| place(l, &surface, &surface.positions)).collect();
            for (i, a) in places.iter().enumerate() {
                for (j, b) in places.iter().enumerate().take(i) {
                    assert!((a - b).norm() > 0.02, "{} and {}", expected[i], expected[j]);
                }
            }
        }
    }

    #[test]
    fn landmarks_move_alike_on_every_animal() {
        // Two landmarks of a rigid part turn by the same angle on every animal: the line from the front of the hoof
        // to its back.
        let line = |animal: &MeshSequence, name: &str, pose: usize| {
            let surface = Surface::new(&animal.rest).unwrap();
            let point = |end: &str| {
                let landmark = animal.landmarks.iter().find(|l| l.name == format!("{name}_{end}")).unwrap();
                let at = |positions: &[Point3<f64>]| place(landmark, &surface, positions);
                (at(&surface.positions), at(&animal.poses[pose].positions.get().unwrap()))
            };
            let (front, back) = (point("front"), point("back"));
            let angle = |v: Vector3<f64>| v.y.atan2(v.z).to_degrees();
            (angle(front.1 - back.1) - angle(front.0 - back.0)).rem_euclid(360.0)
        };
        for (name, pose) in (0..12).flat_map(|p| ["left_front_hoof", "right_hind_hoof"].map(|name| (name, p))) {
            let [horse, camel, giraffe] = [0, 1, 2].map(|a| line(&ANIMALS[a], name, pose));
            // The neighbourhood of the fetlock reaches into the hoof by less than this.
            assert!((horse - camel).abs() < 3.0 && (horse - giraffe).abs() < 3.0, "{horse} {camel} {giraffe}");
        }
    }

    #[test]
    fn the_shape_is_mirror_symmetric() {
        for proportions in ALL {
            let body = Body::new(proportions.animal());
            for k in 0..200 {
                let [x, y, z] = [0, 1, 2].map(|axis| fraction(k, axis));
                let point = Point3::new(0.4 * x, 2.5 * y, 3.5 * z - 1.5);
                let mirrored = Point3::new(-point.x, point.y, point.z);
                assert_eq!(body.distance(&point).to_bits(), body.distance(&mirrored).to_bits());
            }
        }
    }

    #[test]
    fn one_thread_and_many_give_the_same_and_another_seed_other_triangles() {
        let small = Quadruped { resolution: 30, frames: 2, ..Quadruped::default() };
        let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (one, many) = (on(1).install(|| small.make().unwrap()), on(4).install(|| small.make().unwrap()));
        assert_eq!(one.rest.positions, many.rest.positions);
        assert_eq!(one.rest.polygons, many.rest.polygons);
        assert_eq!(one.poses, many.poses);
        assert_eq!(one.landmarks, many.landmarks);
        let other = Quadruped { seed: 1, ..small }.make().unwrap();
        assert_ne!(one.rest.polygons, other.rest.polygons);
    }

    #[test]
    fn size_scales_everything_and_no_gait_has_no_poses() {
        let metres = Quadruped { resolution: 30, frames: 1, ..Quadruped::default() };
        let (one, large) = (metres.make().unwrap(), Quadruped { size: 100.0, ..metres.clone() }.make().unwrap());
        let scaled = |positions: &[Point3<f64>]| positions.iter().map(|p| p * 100.0).collect::<Vec<_>>();
        assert_eq!(large.rest.positions, scaled(&one.rest.positions));
        assert_eq!(*large.poses[0].positions.get().unwrap(), scaled(&one.poses[0].positions.get().unwrap()));
        assert!(Quadruped { gait: Gait::None, ..metres }.make().unwrap().poses.is_empty());
    }

    #[test]
    fn settings_out_of_range_are_errors() {
        let error = |quadruped: Quadruped| quadruped.make().unwrap_err().to_string();
        let base = Quadruped::default;
        assert_eq!(error(Quadruped { frames: 0, ..base() }), "frames: expected 1 to 1000, found 0");
        assert_eq!(error(Quadruped { resolution: 5, ..base() }), "resolution: expected 20 to 1000, found 5");
        assert!(error(Quadruped { size: f64::NAN, ..base() }).starts_with("size: expected "));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(6))]
        #[test]
        fn any_resolution_and_seed_give_a_closed_manifold(resolution in 20usize..70, seed: u64, animal in 0usize..3) {
            let (proportions, gait) = (ALL[animal], Gait::None);
            let quadruped = Quadruped { proportions, resolution, seed, gait, ..Quadruped::default() };
            let statistics = Statistics::new(&quadruped.make().unwrap().rest).unwrap();
            prop_assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0));
            prop_assert_eq!(statistics.component_sizes.len(), 1);
            prop_assert_eq!(2 * statistics.vertices, statistics.triangles + 4);
        }
    }
}
