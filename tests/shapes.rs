//! Sets of shapes: what rests stays, and which shapes are taken, under which names, how strong, on which side and where.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, diagnostics, json};
use nalgebra::{Point3, Vector3};

/// Vertices along a side of the plate.
const SIDE: usize = 17;

/// A square plate from -1 to 1, its upper half the object `top`, moved by `shape` and then `place`, with a shade of red a vertex.
fn plate(shape: impl Fn(Point3<f64>) -> Vector3<f64>, place: impl Fn(Point3<f64>) -> Point3<f64>) -> String {
    let mut text = String::new();
    let at = |k: usize| 2.0 * k as f64 / (SIDE - 1) as f64 - 1.0;
    for j in 0..SIDE {
        for i in 0..SIDE {
            let p = Point3::new(at(i), at(j), 0.1 * at(j) * at(j));
            let q = place(p + shape(p));
            text += &format!("v {} {} {} {} 0 0\n", q.x, q.y, q.z, if p.x < 0.0 { 1.0 } else { 0.25 });
        }
    }
    let v = |i: usize, j: usize| j * SIDE + i + 1;
    for j in 0..SIDE - 1 {
        if j == 0 || j == SIDE / 2 {
            text += if j == 0 { "o bottom\n" } else { "o top\n" };
        }
        for i in 0..SIDE - 1 {
            text += &format!("f {} {} {} {}\n", v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1));
        }
    }
    text
}

/// A bump of compact support.
fn bump(centre: [f64; 2], p: Point3<f64>) -> Vector3<f64> {
    let r = ((p.x - centre[0]).powi(2) + (p.y - centre[1]).powi(2)).sqrt() / 0.4;
    Vector3::new(0.02, 0.01, 0.3) * (1.0 - r * r).max(0.0).powi(2)
}

fn rest(_: Point3<f64>) -> Vector3<f64> {
    Vector3::zeros()
}

/// The target is the plate, wider and bent.
fn target(p: Point3<f64>) -> Point3<f64> {
    Point3::new(1.5 * p.x, p.y, p.z - 0.2 * p.x * p.x)
}

/// Three shapes of a plate and their pipeline, which `shapes` completes.
fn project(shapes: &str) -> Project {
    let project = Project::new();
    project.write("rest.obj", &plate(rest, |p| p));
    project.write("target.obj", &plate(rest, target));
    project.write("shape-cheekLeft.obj", &plate(|p| bump([0.5, 0.3], p), |p| p));
    project.write("shape-jawOpen.obj", &plate(|p| bump([0.0, -0.6], p), |p| p));
    project.write("shape-browDown.obj", &plate(|p| bump([0.0, 0.5], p), |p| p));
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: rest.obj, poses: shape-*.obj }}\ntarget: {{ rest: target.obj }}\n\
             correspondence: {{ type: identity }}\ntransfer: {{ type: gradient }}\noutput: out/{{pose}}.obj\n{shapes}"
        ),
    );
    project
}

#[track_caller]
fn run(project: &Project) {
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
}

/// The names of the results.
fn results(project: &Project) -> Vec<String> {
    let files = std::fs::read_dir(project.path("out")).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter_map(|name| Some(name.strip_suffix(".obj")?.to_owned())).collect();
    names.sort();
    names
}

/// The displacements of a result, from the target's own numbers.
fn moved(project: &Project, name: &str) -> Vec<Vector3<f64>> {
    let read = |file: &str| -> Vec<Point3<f64>> {
        let text = std::fs::read_to_string(project.path(file)).unwrap();
        let vertices = text.lines().filter_map(|line| line.strip_prefix("v "));
        vertices
            .map(|line| {
                let numbers: Vec<f64> = line.split_whitespace().map(|number| number.parse().unwrap()).collect();
                Point3::new(numbers[0], numbers[1], numbers[2])
            })
            .collect()
    };
    read(&format!("out/{name}.obj")).iter().zip(read("target.obj")).map(|(p, rest)| p - rest).collect()
}

/// The place of vertex `v` on the flat plate.
fn place(v: usize) -> Point3<f64> {
    let at = |k: usize| 2.0 * k as f64 / (SIDE - 1) as f64 - 1.0;
    Point3::new(at(v % SIDE), at(v / SIDE), 0.0)
}

#[test]
fn what_rests_in_a_shape_of_the_source_rests_to_the_last_bit() {
    let project = project("");
    run(&project);
    for (name, centre) in [("cheekLeft", [0.5, 0.3]), ("jawOpen", [0.0, -0.6])] {
        let moved = moved(&project, name);
        for (v, moved) in moved.iter().enumerate() {
            let rests = bump(centre, place(v)).norm() == 0.0;
            assert_eq!(moved.norm() == 0.0, rests, "{name}, vertex {v}: {moved}");
        }
        assert!(moved.iter().map(|d| d.norm()).fold(0.0, f64::max) > 0.2);
    }
    // Frames are carried as the transfer has them.
    project.edit("poses: shape-*.obj", "poses: shape-*.obj, poses_are: frames");
    run(&project);
    assert!(moved(&project, "jawOpen").iter().all(|moved| moved.norm() > 0.0));
}

#[test]
fn shapes_are_chosen_renamed_and_strengthened() {
    let project = project("");
    run(&project);
    let full = moved(&project, "jawOpen");
    std::fs::remove_dir_all(project.path("out")).unwrap();
    project.edit(
        "output:",
        "shapes: { only: [jaw*, cheek*], names: vrm, rename: { cheekLeft: puff }, strengths: { jawOpen: 0.5 } }\noutput:",
    );
    run(&project);
    assert_eq!(results(&project), ["aa", "puff"]);
    for (half, full) in moved(&project, "aa").iter().zip(&full) {
        // Numbers in files are rounded to 15 digits or more.
        assert!((half * 2.0 - full).norm() < 1e-12);
    }
    project.write("names.csv", "# shape, result\njawOpen, Mouth Open\nother, x\n");
    project.edit("names: vrm, rename: { cheekLeft: puff }", "except: browDown, rename_file: names.csv");
    std::fs::remove_dir_all(project.path("out")).unwrap();
    run(&project);
    assert_eq!(results(&project), ["Mouth Open", "cheekLeft"]);
}

#[test]
fn the_other_side_is_the_mirror_image() {
    let project = project("shapes: { mirror: { axis: x, from: left } }\n");
    run(&project);
    assert_eq!(results(&project), ["browDown", "cheekLeft", "cheekRight", "jawOpen"]);
    let (left, right) = (moved(&project, "cheekLeft"), moved(&project, "cheekRight"));
    for (v, left) in left.iter().enumerate() {
        let other = v / SIDE * SIDE + (SIDE - 1 - v % SIDE);
        let expected = Vector3::new(-left.x, left.y, left.z);
        // The nearest point is found to some 1e-8.
        assert!((right[other] - expected).norm() < 1e-6, "{v}: {} {expected}", right[other]);
    }
}

#[test]
fn masks_hold_all_else_at_rest() {
    let masked = |mask: &str| {
        let project = project(&format!("shapes: {{ masks: {{ brow*: {mask} }} }}\n"));
        run(&project);
        moved(&project, "browDown")
    };
    let free = {
        let project = project("");
        run(&project);
        moved(&project, "browDown")
    };
    let top = masked("{ parts: [top] }");
    let vertices: Vec<String> = (SIDE * 11..SIDE * SIDE).map(|v| v.to_string()).collect();
    let listed = masked(&format!("{{ vertices: [{}] }}", vertices.join(", ")));
    for v in 0..SIDE * SIDE {
        assert!(v / SIDE >= SIDE / 2 || top[v].norm() == 0.0);
        assert!(v / SIDE >= 11 || listed[v].norm() == 0.0);
    }
    assert!(listed.iter().map(|moved| moved.norm()).fold(0.0, f64::max) > 0.1);
    let shares = masked("{ color: red }");
    for v in 0..SIDE * SIDE {
        let share = if v % SIDE < SIDE / 2 { 1.0 } else { 0.25 };
        assert!((shares[v] - free[v] * share).norm() < 1e-12);
    }
    let painted: Vec<String> = (0..SIDE * SIDE).map(|v| if v % 2 == 0 { "0.5" } else { "0" }.into()).collect();
    let halved = {
        let project = project("shapes: { masks: { brow*: { file: half.target.mask.json } } }\n");
        project.write(
            "half.target.mask.json",
            &format!("{{ \"mesh\": \"b.obj\", \"weights\": [{}] }}", painted.join(", ")),
        );
        run(&project);
        moved(&project, "browDown")
    };
    for v in 0..SIDE * SIDE {
        let share = if v % 2 == 0 { 0.5 } else { 0.0 };
        assert!((halved[v] - free[v] * share).norm() < 1e-12);
    }
    // The jaw moves what no brow does.
    assert!(masked("{ shape: jawOpen }").iter().all(|moved| moved.norm() == 0.0));
}

#[test]
fn numbered_shapes_are_no_animation_if_that_is_said() {
    let project = project("");
    project.write("shape-01.obj", &plate(|p| bump([0.5, 0.3], p), |p| p));
    project.write("shape-02.obj", &plate(|p| bump([0.0, 0.3], p), |p| p));
    project.edit("shape-*.obj", "shape-0?.obj");
    project.edit("out/{pose}.obj", "out/a.glb");
    let animations = |project: &Project| {
        run(project);
        let text = project.mimesh(&["inspect", "out/a.glb", "--json"]).stdout;
        json(&text)["animations"].as_array().map_or(0, Vec::len)
    };
    assert_eq!(animations(&project), 1);
    project.edit("shape-0?.obj", "shape-0?.obj, poses_are: shapes");
    assert_eq!(animations(&project), 0);
}

#[test]
fn mistakes_are_told_at_their_place() {
    let mut wrong = Vec::new();
    for (shapes, message) in [
        ("only: mouth*", "p.yaml:6:17: no shape of the source is called `mouth*`"),
        ("only: jawOpn", "p.yaml:6:17: no shape of the source is called `jawOpn`"),
        ("except: '*'", "p.yaml:6:9: `only` and `except` leave no shape"),
        ("strengths: { jaw: 2 }", "p.yaml:6:24: no shape of the source is called `jaw`"),
        ("strength: 100", "p.yaml:6:21: `strength`: expected -10 to 10, found 100"),
        ("rename: { jawOpen: browDown }", "p.yaml:6:9: two shapes become `browDown`: `browDown` and `jawOpen`"),
        ("rename_file: no.csv", "p.yaml:6:24: no such file: no.csv"),
        ("mirror: { axis: x, from: right }", "p.yaml:6:19: no shape is of the side to mirror from"),
        ("masks: { jawOpen: { parts: Top } }", "p.yaml:6:29: the target has no part called `Top`"),
        ("masks: { jawOpen: { vertices: [289] } }", "p.yaml:6:29: the target has no vertex 289"),
        (
            "masks: { jawOpen: {} }",
            "p.yaml:6:29: a mask has one of the keys `vertices`, `parts`, `color`, `shape` and `file`",
        ),
        ("masks: { jawOpen: { file: no.json } }", "p.yaml:6:37: no such file: no.json"),
        (
            "masks: { jawOpen: { file: short.json } }",
            "p.yaml:6:29: short.json has 1 weights, the target has 289 vertices",
        ),
        (
            "masks: { jawOpen: { file: large.json } }",
            "p.yaml:6:29: large.json: the weight of vertex 288 is 2, expected 0 to 1",
        ),
        ("masks: { jawOpen: { file: p.yaml } }", "p.yaml:6:29: p.yaml: expected value at line 1"),
        ("names: blender", "p.yaml:6:18: `names`: unknown value `blender`"),
    ] {
        let project = project(&format!("shapes: {{ {shapes} }}\n"));
        project.write("short.json", "{ \"weights\": [1] }");
        project.write("large.json", &format!("{{ \"weights\": [{}2] }}", "0.5, ".repeat(288)));
        let found = diagnostics(&project, &[]);
        if found.len() != 1 || !found[0].starts_with(message) {
            wrong.push(format!("{shapes}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_point_cache_is_inspected_without_a_mesh() {
    let project = project("");
    project.edit("out/{pose}.obj", "out/run.pc2");
    run(&project);
    let text = project.mimesh(&["inspect", "out/run.pc2"]).stdout;
    assert!(text.contains("vertices    289") && text.contains("poses       3: run-0"), "{text}");
    let found = json(&project.mimesh(&["inspect", "out/run.pc2", "--json"]).stdout);
    assert_eq!((&found["vertices"], found["poses"].as_array().map(Vec::len)), (&289.into(), Some(3)));
}

#[test]
fn masks_of_frames_are_refused_since_all_outside_would_stand_still() {
    let project = project("shapes: { masks: { brow*: { parts: [top] } } }\n");
    for command in ["check", "run"] {
        let output = project.mimesh(&[command, "p.yaml", "--set", "source.poses_are=frames"]);
        assert_eq!(output.status, 78, "{}", output.stderr);
        let message =
            "masks are for shapes, and the poses are frames of a motion: all outside of a mask would stand still";
        assert!(output.stderr.contains(message) && output.stderr.contains("poses_are: shapes"), "{}", output.stderr);
    }
}
