//! Laws of animals that are made of many components.

use std::{collections::BTreeSet, ops::Range, sync::LazyLock};

use mimesh_core::{
    mesh::{Landmark, Mesh, MeshSequence, Part, Statistics, Surface},
    spatial::{ClosestPoint, Nearest},
    stage::Generator,
};
use mimesh_generators::quadruped::{Gait, MadeOf, Proportions, Quadruped};
use nalgebra::Point3;
use proptest::prelude::*;

const ANIMALS: [Proportions; 3] = [Proportions::Horse, Proportions::Camel, Proportions::Giraffe];
const MANY: [MadeOf; 3] = [MadeOf::Pebbles, MadeOf::Plates, MadeOf::Boxes];

/// Each animal made of each material, with a few poses of a gallop.
static ALL: LazyLock<Vec<(Quadruped, MeshSequence)>> = LazyLock::new(|| {
    let all = ANIMALS.into_iter().flat_map(|proportions| MANY.map(|made_of| (proportions, made_of)));
    let settings = all.map(|(proportions, made_of)| Quadruped { proportions, made_of, frames: 4, ..small() });
    settings.map(|settings| (settings.clone(), settings.make().unwrap())).collect()
});

/// The animals with their skin, otherwise as those of [`ALL`].
static SKINS: LazyLock<Vec<MeshSequence>> =
    LazyLock::new(|| ANIMALS.map(|proportions| Quadruped { proportions, frames: 4, ..small() }.make().unwrap()).into());

fn small() -> Quadruped {
    Quadruped { resolution: 40, ..Quadruped::default() }
}

fn made(proportions: Proportions, made_of: MadeOf) -> &'static MeshSequence {
    let found = ALL.iter().find(|(settings, _)| settings.proportions == proportions && settings.made_of == made_of);
    &found.unwrap().1
}

/// The vertices of a part; those of a sample's parts are contiguous.
fn vertices(mesh: &Mesh, part: &Part) -> Range<usize> {
    let corners = || part.polygons.clone().flat_map(|p| mesh.polygons.get(p).iter().map(|&v| v as usize));
    corners().min().unwrap()..corners().max().unwrap() + 1
}

fn triangles_of(surface: &Surface, part: &Part) -> Vec<[u32; 3]> {
    let of_part = |(_, polygon): &(&[u32; 3], &u32)| part.polygons.contains(&(**polygon as usize));
    surface.triangles.iter().zip(&surface.polygon_of).filter(of_part).map(|(t, _)| *t).collect()
}

fn volume(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    // About a point of its own, so that large coordinates do not cancel.
    let origin = positions[triangles[0][0] as usize];
    let sixth = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize] - origin);
        a.dot(&b.cross(&c))
    };
    triangles.iter().map(sixth).sum::<f64>() / 6.0
}

fn check_closed(mesh: &Mesh, what: &str) {
    let statistics = Statistics::new(mesh).unwrap();
    assert_eq!((statistics.boundary_edges, statistics.non_manifold_edges), (0, 0), "{what}");
    assert_eq!((statistics.degenerate_triangles, statistics.unreferenced_vertices), (0, 0), "{what}");
    assert_eq!(statistics.component_sizes.len(), mesh.parts.len(), "{what}: each part is one component");
    let surface = Surface::new(mesh).unwrap();
    for part in &mesh.parts {
        let volume = volume(&mesh.positions, &triangles_of(&surface, part));
        assert!(volume > 0.0, "{what}: {:?} encloses {volume}", part.object);
    }
}

#[test]
fn every_part_is_one_closed_component_that_faces_outwards_at_rest_and_in_every_pose() {
    for (settings, animal) in ALL.iter() {
        check_closed(&animal.rest, &format!("{settings:?}"));
        assert_eq!(animal.poses.len(), 4);
        for pose in &animal.poses {
            let posed = Mesh { positions: pose.positions.get().unwrap().into_owned(), ..animal.rest.clone() };
            check_closed(&posed, &format!("{settings:?} {}", pose.name));
        }
    }
}

#[test]
fn parts_are_named_and_grouped_so_that_settings_can_name_them() {
    for (settings, animal) in ALL.iter() {
        let names: Vec<_> = animal.rest.parts.iter().map(|part| part.object.clone().unwrap()).collect();
        assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len(), "{settings:?}: a name occurs twice");
        assert_eq!(Surface::new(&animal.rest).unwrap().part_names, names);
        let groups: BTreeSet<_> = animal.rest.parts.iter().map(|part| part.groups[0].as_str()).collect();
        for region in ["trunk", "neck", "head", "tail", "left_front_leg", "right_hind_leg", "left_ear", "right_ear"] {
            assert!(groups.contains(region), "{settings:?}: no {region} in {groups:?}");
        }
        if settings.made_of != MadeOf::Boxes {
            assert!(names.contains(&"left_front_leg_1".into()) && names.contains(&"trunk_2".into()), "{names:?}");
        }
    }
    let boxes = |proportions| {
        let parts = made(proportions, MadeOf::Boxes).rest.parts.iter();
        parts.map(|part| part.object.clone().unwrap()).collect::<BTreeSet<_>>()
    };
    let [horse, camel, giraffe] = ANIMALS.map(boxes);
    for name in ["pelvis", "chest", "head", "left_front_shin", "right_hind_thigh", "tail_end"] {
        assert!(horse.contains(name), "{name}");
    }
    assert_eq!(horse.len(), 26);
    assert_eq!(camel.difference(&horse).collect::<Vec<_>>(), ["hump"]);
    assert_eq!(giraffe.difference(&horse).collect::<Vec<_>>(), ["left_horn", "right_horn"]);
}

#[test]
fn there_are_as_many_pebbles_and_about_as_many_plates_as_asked_for() {
    let count = |made_of, pieces| {
        let settings = Quadruped { made_of, pieces, gait: Gait::None, ..small() };
        settings.make().unwrap().rest.parts.len()
    };
    assert_eq!(count(MadeOf::Pebbles, None), 200);
    assert_eq!(count(MadeOf::Pebbles, Some(77)), 77);
    // A cell whose skin falls apart gives two plates.
    assert!((60..=66).contains(&count(MadeOf::Plates, None)), "{}", count(MadeOf::Plates, None));
    assert!((150..=165).contains(&count(MadeOf::Plates, Some(150))), "{}", count(MadeOf::Plates, Some(150)));
}

#[test]
fn pebbles_and_boxes_move_rigidly() {
    for (settings, animal) in ALL.iter().filter(|(settings, _)| settings.made_of != MadeOf::Plates) {
        for (part, pose) in animal.rest.parts.iter().flat_map(|part| animal.poses.iter().map(move |pose| (part, pose)))
        {
            let range = vertices(&animal.rest, part);
            let posed = pose.positions.get().unwrap();
            let (rest, posed) = (&animal.rest.positions[range.clone()], &posed[range]);
            // Distances to four points that do not lie in a plane fix all others.
            for k in (0..4).map(|k| k * (rest.len() - 1) / 3) {
                for (a, b) in rest.iter().zip(posed) {
                    let change = (b - posed[k]).norm() - (a - rest[k]).norm();
                    // Lengths are metres; rotations are orthogonal to rounding.
                    assert!(change.abs() < 1e-9, "{settings:?} {:?} {}: {change:e}", part.object, pose.name);
                }
            }
        }
    }
}

#[test]
fn pieces_move_as_the_skin_beside_them() {
    for (settings, animal) in ALL.iter() {
        let skin = &SKINS[settings.proportions as usize];
        let search = Nearest::new(&skin.rest.positions).unwrap();
        let beside: Vec<_> = animal.rest.positions.iter().map(|p| search.find(p).0 as usize).collect();
        for (pose, posed_skin) in animal.poses.iter().zip(&skin.poses) {
            let (positions, posed_skin) = (pose.positions.get().unwrap(), posed_skin.positions.get().unwrap());
            let moved: f64 = posed_skin.iter().zip(&skin.rest.positions).map(|(a, b)| (a - b).norm()).sum();
            let moved = moved / skin.rest.positions.len() as f64;
            let differ = |(v, &s): (usize, &usize)| {
                let own = positions[v] - animal.rest.positions[v];
                (own - (posed_skin[s] - skin.rest.positions[s])).norm()
            };
            let mean = beside.iter().enumerate().map(differ).sum::<f64>() / beside.len() as f64;
            // Half a pebble or plate inside, and a rigid box where the body bends, move a little otherwise.
            assert!(mean < 0.25 * moved, "{settings:?} {}: {mean} of {moved}", pose.name);
        }
    }
}

#[test]
fn pebbles_cover_the_skin_and_do_not_touch() {
    for proportions in ANIMALS {
        let pebbles = &made(proportions, MadeOf::Pebbles).rest;
        let surface = Surface::new(pebbles).unwrap();
        let search = ClosestPoint::new(&surface.positions, &surface.triangles).unwrap();
        let skin = &SKINS[proportions as usize];
        let diagonal = skin.rest.diagonal();
        let away = |p: &Point3<f64>| search.find(p, f64::INFINITY, |_| true).unwrap().distance / diagonal;
        let away: Vec<f64> = skin.rest.positions.iter().map(away).collect();
        // A pebble is about a twentieth of the body long; between rounded pebbles the skin is open.
        assert!(away.iter().sum::<f64>() / (away.len() as f64) < 0.005, "{proportions:?}");
        assert!(away.iter().copied().fold(0.0, f64::max) < 0.03, "{proportions:?}");

        for (part, own) in pebbles.parts.iter().enumerate() {
            let range = vertices(pebbles, own);
            let other = |t: u32| !own.polygons.contains(&(surface.polygon_of[t as usize] as usize));
            for p in &pebbles.positions[range] {
                let near = search.find(p, f64::INFINITY, other).unwrap();
                assert!(near.distance > 1e-4 * diagonal, "{proportions:?} pebble {part}");
            }
        }
    }
}

/// Where a landmark lies on the surface of its animal.
fn place(landmark: &Landmark, surface: &Surface) -> Point3<f64> {
    surface.point(landmark.point).unwrap().position(surface, &surface.positions)
}

#[test]
fn landmarks_are_those_of_the_skin_at_nearly_their_places() {
    for (settings, animal) in ALL.iter() {
        let skin = &SKINS[settings.proportions as usize];
        let (surface, skin_surface) = (Surface::new(&animal.rest).unwrap(), Surface::new(&skin.rest).unwrap());
        let mut sum = 0.0;
        assert_eq!(animal.landmarks.len(), skin.landmarks.len());
        for (own, other) in animal.landmarks.iter().zip(&skin.landmarks) {
            assert_eq!(own.name, other.name);
            let own_place = place(own, &surface);
            let away = (own_place - place(other, &skin_surface)).norm();
            sum += away / skin.rest.diagonal();
            // A corner of a box lies about this far off a round body.
            assert!(away < 0.06 * skin.rest.diagonal(), "{settings:?} {}: {away}", own.name);
        }
        assert!(sum / (skin.landmarks.len() as f64) < 0.01, "{settings:?} {}", sum / skin.landmarks.len() as f64);
    }
}

#[test]
fn no_two_landmarks_of_an_animal_coincide() {
    for (settings, animal) in ALL.iter() {
        let surface = Surface::new(&animal.rest).unwrap();
        let place = |k: usize| place(&animal.landmarks[k], &surface);
        for (i, j) in (0..animal.landmarks.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let names = (&animal.landmarks[i].name, &animal.landmarks[j].name);
            assert!((place(i) - place(j)).norm() > 0.005, "{settings:?} {names:?}");
        }
    }
}

#[test]
fn the_robot_is_mirror_symmetric() {
    for proportions in ANIMALS {
        let robot = &made(proportions, MadeOf::Boxes).rest;
        let part = |name: &str| robot.parts.iter().find(|part| part.object.as_deref() == Some(name));
        for own in &robot.parts {
            let name = own.object.clone().unwrap();
            if name.starts_with("right_") {
                continue;
            }
            let twin = part(&name.replace("left_", "right_")).unwrap();
            let twins = &robot.positions[vertices(robot, twin)];
            for p in &robot.positions[vertices(robot, own)] {
                let mirrored = Point3::new(-p.x, p.y, p.z);
                assert!(twins.iter().any(|q| (q - mirrored).norm() < 1e-12), "{proportions:?} {name}");
            }
        }
    }
}

#[test]
fn one_thread_and_many_give_the_same_and_another_seed_other_pieces() {
    for made_of in MANY {
        let settings = Quadruped { made_of, resolution: 25, frames: 2, ..Quadruped::default() };
        let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (one, many) = (on(1).install(|| settings.make().unwrap()), on(4).install(|| settings.make().unwrap()));
        assert_eq!(one.rest.positions, many.rest.positions);
        assert_eq!(one.rest.polygons, many.rest.polygons);
        assert_eq!(one.rest.parts, many.rest.parts);
        assert_eq!((one.poses, one.landmarks), (many.poses, many.landmarks));
        let other = Quadruped { seed: 1, ..settings }.make().unwrap();
        // Boxes are a matter of proportions alone.
        assert_eq!(other.rest.positions == one.rest.positions, made_of == MadeOf::Boxes);
    }
}

#[test]
fn size_scales_pieces_and_no_gait_has_no_poses() {
    for made_of in MANY {
        let metres = Quadruped { made_of, resolution: 25, frames: 1, ..Quadruped::default() };
        let (one, large) = (metres.make().unwrap(), Quadruped { size: 100.0, ..metres.clone() }.make().unwrap());
        let scaled = |positions: &[Point3<f64>]| positions.iter().map(|p| p * 100.0).collect::<Vec<_>>();
        assert_eq!(large.rest.positions, scaled(&one.rest.positions));
        assert_eq!(*large.poses[0].positions.get().unwrap(), scaled(&one.poses[0].positions.get().unwrap()));
        assert!(Quadruped { gait: Gait::None, ..metres }.make().unwrap().poses.is_empty());
    }
}

#[test]
fn pebbles_whose_middle_is_hardly_theirs_are_closed_too() {
    // The point of the layer nearest to the middle lies almost in the next pebble.
    for seed in [6628234072674231029, 6627424962069656538] {
        let settings = Quadruped {
            proportions: Proportions::Camel,
            made_of: MadeOf::Pebbles,
            pieces: Some(81),
            resolution: 30,
            seed,
            ..Quadruped::default()
        };
        check_closed(&settings.make().unwrap().rest, &format!("{settings:?}"));
    }
}

#[test]
fn a_number_of_pieces_that_cannot_be_is_an_error() {
    let error = |made_of, pieces| {
        let settings = Quadruped { made_of, pieces: Some(pieces), ..Quadruped::default() };
        settings.make().unwrap_err().to_string()
    };
    assert_eq!(error(MadeOf::Pebbles, 3), "pieces: expected 20 to 5000, found 3");
    assert_eq!(error(MadeOf::Plates, 6000), "pieces: expected 20 to 5000, found 6000");
    for made_of in [MadeOf::Skin, MadeOf::Boxes] {
        assert_eq!(error(made_of, 100), "pieces: expected nothing unless `made_of` is pebbles or plates, found 100");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn any_number_of_pieces_resolution_and_seed_give_closed_pieces(
        pieces in 20usize..300,
        resolution in 20usize..50,
        seed: u64,
        animal in 0usize..3,
        plates: bool,
    ) {
        let made_of = if plates { MadeOf::Plates } else { MadeOf::Pebbles };
        let (proportions, gait, pieces) = (ANIMALS[animal], Gait::None, Some(pieces));
        let settings = Quadruped { proportions, made_of, pieces, resolution, seed, gait, ..Quadruped::default() };
        check_closed(&settings.make().unwrap().rest, &format!("{settings:?}"));
    }
}
