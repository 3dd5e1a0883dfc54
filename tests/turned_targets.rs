//! Targets that are inside out or mirror images: recognised, named, and transferred like what they are.
#![cfg(feature = "bundled")]

mod common;

use common::{
    Output, Project,
    ellipsoid::{ellipsoid, obj},
};
use nalgebra::Point3;

type Mesh = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// A bent ellipsoid without any symmetry.
fn bent(rings: usize, sectors: usize) -> Mesh {
    let (positions, triangles) = ellipsoid(rings, sectors);
    let bend = |p: Point3<f64>| Point3::new(p.x * (1.3 + 0.2 * p.y) + 0.15 * p.z * p.z, p.y + 0.1 * p.x * p.z, p.z);
    (positions.into_iter().map(bend).collect(), triangles)
}

/// The vertices at most along some directions, which correspond between resolutions.
fn extremes((positions, _): &Mesh) -> Vec<usize> {
    let directions =
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [1, 1, 0], [-1, 1, 1], [1, -1, 1]];
    let farthest = |[x, y, z]: [i32; 3]| {
        let along = |p: &Point3<f64>| f64::from(x) * p.x + f64::from(y) * p.y + f64::from(z) * p.z;
        (0..positions.len()).max_by(|&a, &b| along(&positions[a]).total_cmp(&along(&positions[b]))).unwrap()
    };
    directions.map(farthest).to_vec()
}

/// A project that carries a twist of a bent ellipsoid to `change` of a finer one.
fn project(change: impl Fn(Mesh) -> Mesh, target: &str) -> Project {
    let project = Project::new();
    let (source, other) = (bent(10, 12), bent(12, 16));
    project.write("source.obj", &obj(&source.0, &source.1));
    let twist = |p: &Point3<f64>| {
        let (sin, cos) = (0.3 * p.z).sin_cos();
        Point3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, 1.1 * p.z)
    };
    project.write("twisted.obj", &obj(&source.0.iter().map(twist).collect::<Vec<_>>(), &source.1));
    let pairs = extremes(&source).into_iter().zip(extremes(&other));
    let pairs: Vec<String> = pairs.map(|(a, b)| format!("{a}, {b}")).collect();
    project.write("m.cons", &format!("{}\n{}\n", pairs.len(), pairs.join("\n")));
    let (positions, triangles) = change(other);
    project.write("target.obj", &obj(&positions, &triangles));
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: source.obj, poses: twisted.obj }}\ntarget: {target}\nmarkers: m.cons\n\
             correspondence: {{ type: nonrigid_fit }}\ntransfer: {{ type: gradient }}\noutput: out/{{pose}}.obj\n"
        ),
    );
    project
}

/// The vertices of the result.
fn result(project: &Project) -> Vec<[f64; 3]> {
    let output: Output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let text = String::from_utf8(project.bytes("out/twisted.obj")).unwrap();
    let numbers = |line: &str| line.split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
    text.lines().filter_map(|line| line.strip_prefix("v ")).map(numbers).collect()
}

fn warnings(project: &Project) -> String {
    project.mimesh(&["check", "p.yaml"]).stderr
}

fn turned((positions, mut triangles): Mesh) -> Mesh {
    triangles.iter_mut().for_each(|t| t.swap(1, 2));
    (positions, triangles)
}

fn mirrored((positions, triangles): Mesh) -> Mesh {
    (positions.into_iter().map(|p| Point3::new(-p.x, p.y, p.z)).collect(), triangles)
}

const PLAIN: &str = "{ rest: target.obj }";

#[test]
fn a_target_that_is_inside_out_moves_like_one_that_is_not() {
    let (plain, inside_out) = (project(|mesh| mesh, PLAIN), project(turned, PLAIN));
    assert_eq!(warnings(&plain), "");
    assert!(warnings(&inside_out).contains("the target (target.obj) is inside out"), "{}", warnings(&inside_out));
    assert_eq!(result(&plain), result(&inside_out), "the same surface, so the same bits");
    let faces = |text: &str| text.lines().filter(|line| line.starts_with("f ")).map(str::to_owned).collect::<Vec<_>>();
    let [given, written] =
        ["target.obj", "out/twisted.obj"].map(|file| String::from_utf8(inside_out.bytes(file)).unwrap());
    assert_eq!(faces(&given), faces(&written), "the user's faces stay as they are");
}

#[test]
fn a_mirrored_target_is_named_and_moves_like_the_mirror_image_once_the_user_says_so() {
    let plain = result(&project(|mesh| mesh, PLAIN));
    let image: Vec<[f64; 3]> = plain.iter().map(|&[x, y, z]| [-x, y, z]).collect();
    // Mirrored coordinates alone turn a mesh inside out; other programs turn its faces too.
    for change in [mirrored as fn(Mesh) -> Mesh, |mesh| turned(mirrored(mesh))] {
        let silent = project(change, PLAIN);
        let warning = warnings(&silent);
        assert!(warning.contains("left and right are swapped by the markers"), "{warning}");
        assert!(warning.contains("`target: { mirrored: x }`"), "the axis that was mirrored: {warning}");
        let told = project(change, "{ rest: target.obj, mirrored: x }");
        assert!(!warnings(&told).contains("left and right"), "{}", warnings(&told));
        assert_eq!(result(&told), image, "the mirror image of the plain result, to the last bit");
    }
    let wrong = project(|mesh| mesh, "{ rest: target.obj, mirrored: y }");
    assert!(warnings(&wrong).contains("`mirrored: y` fits worse than none"), "{}", warnings(&wrong));
}

#[test]
fn a_mirrored_target_without_markers_is_named_by_the_correspondence() {
    let project = project(|_| mirrored(bent(10, 12)), PLAIN);
    project.edit("markers: m.cons\n", "");
    project.edit("nonrigid_fit", "identity");
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let report = output.json();
    let stages = report["stages"].to_string();
    assert!(stages.contains("left and right are swapped by the correspondence"), "{stages}");
    assert_eq!(report["rest_verdict"]["level"], "bad", "{}", report["rest_verdict"]);
}
