//! FBX: a file of our own as text and as bytes, against known answers and against the glTF of the same scene.

mod support;

use mimesh_core::{
    mesh::MeshSequence,
    stage::{BytesInput, ClipTimes, Format, PoseChoice, RestShape, Selection},
};
use mimesh_formats::Fbx;
use nalgebra::Point3;
use support::{
    distance,
    fbx::{Space, ascii, binary, strip},
    gltf::{self, about_z, bent, clips, names, positions},
    message, read,
};

/// Rounding of a few products of numbers up to 3 (300 in centimetres).
const ROUNDING: f64 = 1e-12;

/// The vertices of the strip; those of the hat follow.
const STRIP_END: usize = 6;

fn files(space: Space, degrees: f64) -> [Vec<u8>; 2] {
    let records = strip(space, degrees);
    [ascii(&records), binary(&records)]
}

fn select(bytes: &[u8], selection: &Selection) -> MeshSequence {
    Fbx::default().read(&BytesInput::new("a.fbx", bytes), selection).unwrap()
}

fn at_keys(bytes: &[u8]) -> Vec<Vec<Point3<f64>>> {
    positions(&select(bytes, &clips(&["Turn"], ClipTimes::Keys, None)))
}

/// The strip of some positions.
fn of_strip(positions: &[Point3<f64>]) -> &[Point3<f64>] {
    &positions[..STRIP_END]
}

/// Where the hat is when it goes with the upper joint: mirrored, its corner two above the ground.
fn hat(degrees: f64) -> Vec<Point3<f64>> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let corners = [[0., 1.], [-1., 1.], [0., 2.]];
    corners.map(|[x, y]| Point3::new(x * cos - y * sin, 1.0 + x * sin + y * cos, 0.0)).into()
}

#[test]
fn text_and_bytes_in_any_unit_and_axes_give_the_glb_of_the_same_scene() {
    let mut glb = gltf::strip();
    let output = glb.floats(&[about_z(0.0), about_z(90.0)]);
    glb.clip("Turn", 3, "rotation", "LINEAR", &[0.0, 1.0], output);
    let at = clips(&["Turn"], ClipTimes::PerSecond(8.0), None);
    let expected = positions(&glb.select(&at).unwrap());
    for space in [Space::MetresYUp, Space::CentimetresZUp] {
        for bytes in files(space, 0.0) {
            let sequence = select(&bytes, &at);
            assert_eq!(sequence.poses.len(), 9);
            let expected = expected.iter();
            for (found, expected) in positions(&sequence).iter().zip(expected) {
                // The glTF has its quaternions in f32.
                assert!(distance(of_strip(found), expected) < 1e-6);
            }
            assert!(distance(of_strip(&sequence.rest.positions), &bent(0.0)) < ROUNDING);
            assert_eq!(
                sequence.warnings.len(),
                usize::from(matches!(space, Space::CentimetresZUp)),
                "{:?}",
                sequence.warnings
            );
        }
    }
}

#[test]
fn polygons_parts_and_texture_coordinates_are_kept() {
    for bytes in files(Space::CentimetresZUp, 0.0) {
        let mesh = select(&bytes, &Selection::default()).rest;
        let polygons: Vec<&[u32]> = mesh.polygons.iter().collect();
        // The hat is mirrored, so that its corners turn round.
        assert_eq!(polygons, [&[0, 1, 3, 2][..], &[2, 3, 5, 4], &[6, 8, 7]]);
        let objects: Vec<_> = mesh.parts.iter().map(|part| part.object.as_deref().unwrap()).collect();
        assert_eq!(objects, ["strip", "hat"]);
        let textures = mesh.texture_coordinates.unwrap();
        let of_corner = |corner: usize| textures.indices[corner].map(|index| textures.values[index as usize]);
        assert_eq!([of_corner(2), of_corner(7), of_corner(8)], [Some([1., 1.]), Some([0., 1.]), None]);
    }
}

#[test]
fn clips_meet_their_keys_and_what_hangs_on_a_joint_goes_with_it() {
    for bytes in files(Space::MetresYUp, 0.0) {
        let keys = at_keys(&bytes);
        assert_eq!(keys.len(), 2);
        for (key, degrees) in keys.iter().zip([0.0, 90.0]) {
            assert!(distance(of_strip(key), &bent(degrees)) < ROUNDING);
            assert!(distance(&key[STRIP_END..], &hat(degrees)) < ROUNDING);
        }
        let sequence = select(&bytes, &clips(&["Turn"], ClipTimes::PerSecond(2.0), None));
        assert_eq!(names(&sequence), ["Turn-00", "Turn-01", "Turn-02"]);
        assert!(distance(of_strip(&sequence.poses[1].positions.get().unwrap()), &bent(45.0)) < ROUNDING);
        let clip = &sequence.animations[0];
        assert_eq!((&clip.name[..], clip.seconds, &clip.channels[..]), ("Turn", 1.0, &["skeleton".to_owned()][..]));
    }
}

#[test]
fn the_rest_is_the_bind_pose_and_shapes_move_it_there() {
    for bytes in files(Space::MetresYUp, 30.0) {
        let sequence = select(&bytes, &Selection::default());
        assert!(distance(of_strip(&sequence.rest.positions), &bent(0.0)) < ROUNDING);
        assert!(distance(&sequence.rest.positions[STRIP_END..], &hat(0.0)) < ROUNDING);
        assert_eq!(names(&sequence), ["lift"]);
        let lifted = sequence.poses[0].positions.get().unwrap();
        for (vertex, (lifted, rest)) in lifted.iter().zip(&sequence.rest.positions).enumerate() {
            // Vertices that the shape leaves alone stay where they are, to the last bit.
            let height = if vertex == 4 || vertex == 5 { 1.0 } else { 0.0 };
            assert_eq!((lifted - rest).norm(), height);
        }
        // A time of the clip as the rest takes the shapes along: at 1 s up has become −x.
        let rest = RestShape::Clip { name: "Turn".into(), seconds: 1.0 };
        let turned = select(&bytes, &Selection { rest, ..Selection::default() });
        assert!(distance(of_strip(&turned.rest.positions), &bent(90.0)) < ROUNDING);
        let moved = turned.poses[0].positions.get().unwrap()[4] - turned.rest.positions[4];
        assert!((moved - nalgebra::Vector3::new(-1.0, 0.0, 0.0)).norm() < ROUNDING);
        let rest = RestShape::Pose("lift".into());
        let lift = select(&bytes, &Selection { rest, poses: PoseChoice::Nothing, ..Selection::default() });
        assert_eq!(lift.rest.positions, lifted.into_owned());
    }
}

#[test]
fn meshes_are_chosen_by_the_names_of_nodes_and_meshes() {
    let [text, _] = files(Space::MetresYUp, 0.0);
    for name in ["hat", "hatMesh"] {
        let chosen = Selection { meshes: vec![name.into()], ..Selection::default() };
        assert!(distance(&select(&text, &chosen).rest.positions, &hat(0.0)) < ROUNDING);
    }
    let unknown = |selection: Selection| {
        message(&Fbx::default().read(&BytesInput::new("a.fbx", &text[..]), &selection).unwrap_err())
    };
    assert_eq!(
        unknown(Selection { meshes: vec!["cap".into()], ..Selection::default() }),
        "a.fbx: nothing in the file is called `cap`: it has the nodes `strip`, `hat`, the meshes `stripMesh`, `hatMesh`\n\
         name parts that the file has, by their nodes, meshes or materials"
    );
    assert_eq!(
        unknown(clips(&["Run"], ClipTimes::Keys, None)),
        "a.fbx: no clip is called `Run`: the file has `Turn`\n`mimesh inspect` lists the morph targets and clips of a file"
    );
}

#[test]
fn damage_is_an_error_that_names_the_file() {
    for bytes in files(Space::MetresYUp, 0.0) {
        for end in (0..bytes.len()).step_by(7) {
            if let Err(error) = read(&Fbx::default(), "a.fbx", &bytes[..end]) {
                assert!(message(&error).starts_with("a.fbx: "), "{error}");
            }
        }
        // Any byte may be another: no panic, and what is read is finite.
        for place in (30..bytes.len()).step_by(5) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x55;
            if let Ok(sequence) = read(&Fbx::default(), "a.fbx", &damaged) {
                assert!(sequence.rest.positions.iter().all(|p| p.iter().all(|x| x.is_finite())));
                sequence
                    .poses
                    .iter()
                    .for_each(|pose| assert_eq!(pose.positions.get().unwrap().len(), sequence.rest.positions.len()));
            }
        }
    }
    assert!(message(&read(&Fbx::default(), "a.fbx", b"solid no\n").unwrap_err()).starts_with("a.fbx: not an FBX"));
}
