//! Key points and biharmonic transfer on input with defects: a clear error, or a result that keeps the laws of a transfer.
#![cfg(feature = "bundled")]

mod common;

use common::{Output, Project};
use mimesh::core::{
    mesh::Surface,
    random::Random,
    spatial::{Orientation, Similarity},
    testkit::{data::data, meshes},
};
use nalgebra::{Isometry3, Point3, Rotation3, Vector3};

/// Markers far from each other on [`bar`], by number on both sides.
const APART: [u32; 6] = [0, 20, 45, 70, 90, 100];

fn bar() -> Surface {
    meshes::bar([9, 3, 2], [3.0, 0.9, 0.7])
}

/// A unit square in its plane.
fn patch() -> Surface {
    meshes::grid(9, 9)
}

/// Named meshes one after the other.
fn obj(parts: &[(&str, &Surface)]) -> String {
    let (mut text, mut first) = (String::new(), 1);
    for (name, part) in parts {
        text += &format!("o {name}\n");
        part.positions.iter().for_each(|p| text += &format!("v {} {} {}\n", p.x, p.y, p.z));
        part.triangles.iter().for_each(|t| text += &format!("f {} {} {}\n", t[0] + first, t[1] + first, t[2] + first));
        first += part.vertex_count() as u32;
    }
    text
}

fn positions(text: &str) -> Vec<Point3<f64>> {
    let vertex = |line: &str| {
        let numbers: Vec<f64> =
            line.strip_prefix("v ")?.split_whitespace().map(|n| n.parse().expect("a number")).collect();
        Some(Point3::from_slice(&numbers[..3]))
    };
    text.lines().filter_map(vertex).collect()
}

fn moved(surface: &Surface, motion: impl Fn(&Point3<f64>) -> Point3<f64>) -> Surface {
    Surface { positions: surface.positions.iter().map(motion).collect(), ..surface.clone() }
}

fn motion() -> Isometry3<f64> {
    Random::new(5).rigid_motion(2.0)
}

/// Bends and twists a little.
fn bend(p: &Point3<f64>) -> Point3<f64> {
    Rotation3::from_axis_angle(&Vector3::y_axis(), 0.3 * p.x) * p
}

/// A source of these parts with three poses, 1 at rest, 2 moved rigidly and 10 bent, and a target of these parts.
fn project(source: &[(&str, &Surface)], target: &[(&str, &Surface)], markers: &[(u32, u32)]) -> Project {
    let project = Project::new();
    let posed = |pose: &dyn Fn(&Point3<f64>) -> Point3<f64>| {
        let parts: Vec<_> = source.iter().map(|(name, part)| (*name, moved(part, pose))).collect();
        obj(&parts.iter().map(|(name, part)| (*name, part)).collect::<Vec<_>>())
    };
    project.write("rest.obj", &obj(source));
    project.write("pose-1.obj", &obj(source));
    project.write("pose-2.obj", &posed(&|p| motion() * p));
    project.write("pose-10.obj", &posed(&bend));
    project.write("target.obj", &obj(target));
    let lines: String = markers.iter().map(|(s, t)| format!("{s}, {t}\n")).collect();
    project.write("m.cons", &format!("{}\n{lines}", markers.len()));
    project.write(
        "p.yaml",
        "source: { rest: rest.obj, poses: pose-*.obj }\ntarget: { rest: target.obj }\nmarkers: m.cons\n\
         key_points: { type: greedy, min_count: 3, threshold: 0, max_count: 5, max_rounds: 1, sampler: { type: farthest_point, count: 12 } }\n\
         transfer: { type: biharmonic }\noutput: out/{pose}.obj\n",
    );
    project
}

fn same(vertices: &[u32]) -> Vec<(u32, u32)> {
    vertices.iter().map(|&v| (v, v)).collect()
}

/// Checks that the command failed on bad data, with these words on stderr.
#[track_caller]
fn assert_data_error(output: &Output, words: &[&str]) {
    assert_eq!(output.status, 65, "{}{}", output.stdout, output.stderr);
    words.iter().for_each(|word| assert!(output.stderr.contains(word), "`{word}` in {}", output.stderr));
}

/// Checks a target with the shape of its source, but for defects: rest gives rest, a rigid motion gives the same motion, and a
/// bend gives most of the bend.
fn assert_laws(what: &str, project: &Project) {
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{what}: {}", output.stderr);
    let rest = positions(&project.read("target.obj"));
    let diagonal = mimesh::core::mesh::diagonal(&rest);
    let off = |found: &[Point3<f64>], truth: &dyn Fn(&Point3<f64>) -> Point3<f64>| -> Vec<f64> {
        assert_eq!(found.len(), rest.len());
        found.iter().zip(&rest).map(|(q, p)| (q - truth(p)).norm() / diagonal).collect()
    };
    let [still, moved, bent] = ["1", "2", "10"].map(|pose| positions(&project.read(&format!("out/{pose}.obj"))));
    let most = |off: Vec<f64>| off.into_iter().fold(0.0, |a, b| if b <= a { a } else { b });
    // The maps of a rigid motion leave no residual, so that nothing but rounding is off: 6e-15 was seen.
    let [still, moved] = [most(off(&still, &|p| *p)), most(off(&moved, &|p| motion() * p))];
    assert!(still < 1e-11 && moved < 1e-11, "{what}: {still} and {moved} of the diagonal");
    // A few handles tell a bend roughly.
    let mean = |off: Vec<f64>| off.iter().sum::<f64>() / off.len() as f64;
    let [bent, nothing] = [mean(off(&bent, &bend)), mean(off(&rest, &bend))];
    assert!(bent < 0.4 * nothing, "{what}: {bent} of the diagonal, doing nothing {nothing}");
}

/// Checks that key points are found and that each lowers the error; returns their vertices.
fn key_points(what: &str, project: &Project) -> Vec<u64> {
    let output = project.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml", "--force", "--json"]);
    assert_eq!(output.status, 0, "{what}: {}", output.stderr);
    let json: serde_json::Value = serde_json::from_str(&output.stdout).expect("JSON");
    let errors: Vec<f64> = json["steps"].as_array().unwrap().iter().map(|s| s["error"].as_f64().unwrap()).collect();
    assert!(errors.iter().all(|e| e.is_finite()) && errors.windows(2).all(|w| w[1] < w[0]), "{what}: {errors:?}");
    let points: Vec<u64> = json["points"].as_array().unwrap().iter().map(|p| p.as_u64().expect("a vertex")).collect();
    let mut different = points.clone();
    different.sort_unstable();
    different.dedup();
    assert!(points.len() >= 3 && different.len() == points.len(), "{what}: {points:?}");
    points
}

#[test]
fn a_component_without_a_handle_is_named_or_bridged() {
    let (body, eye) = (bar(), moved(&meshes::icosphere(1), |p| 0.2 * p + Vector3::new(0.9, 0.0, 0.65)));
    let (whole, plain) = ([("body", &body), ("eye", &eye)], [("body", &body)]);

    let on_target = project(&plain, &whole, &same(&APART));
    let words = ["the target: component without a handle: eye (42 vertices, from vertex", "put a handle on each"];
    assert_data_error(&on_target.mimesh(&["run", "p.yaml"]), &words);
    assert!(!on_target.has("out"), "nothing is written");
    on_target.edit("transfer:", "proximity: { type: spanning_tree }\ntransfer:");
    assert_laws("bridged", &on_target);

    let on_source = project(&whole, &plain, &same(&APART));
    let output = on_source.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "bridged by itself: {}", output.stderr);
    on_source.edit("type: biharmonic", "type: biharmonic, source_proximity: null");
    assert_data_error(
        &on_source.mimesh(&["run", "p.yaml"]),
        &["the source: component without a handle: eye (42 vertices"],
    );

    let first = body.vertex_count() as u64;
    key_points("two components", &on_source);
    on_source.edit("type: farthest_point, count: 12", "type: given, vertices: [0, 20, 45, 70, 90]");
    assert!(key_points("one of two has candidates", &on_source).iter().all(|&v| v < first));
    on_source.edit("type: greedy", "type: greedy, proximity: null");
    let output = on_source.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml", "--force"]);
    assert_data_error(&output, &["key_points (greedy)", "component without a handle: eye (42 vertices"]);
    on_source.edit("type: given, vertices: [0, 20, 45, 70, 90]", "type: farthest_point, count: 12");
    let points = key_points("each component has a point", &on_source);
    assert!(points.iter().any(|&v| v < first) && points.iter().any(|&v| v >= first), "{points:?}");
}

#[test]
fn a_repeated_handle_is_named() {
    let bar = bar();
    let project = project(&[("bar", &bar)], &[("bar", &bar)], &same(&[0, 20, 45, 20, 90]));
    let words = "m.cons:5: marker 4 lies on the same point of the source as marker 2 (line 3)";
    assert_data_error(&project.mimesh(&["run", "p.yaml"]), &[words, "remove one of the two"]);
    // Two points within one triangle that are nearest to the same corner.
    let inside = |a: f64| format!("{{ triangle: 0, barycentric: [{a}, {}, 0] }}", 1.0 - a);
    let points = [inside(0.9), inside(0.8), "45".into(), "70".into(), "90".into()];
    let lines: String = points.iter().map(|p| format!("  - {{ source: {p}, target: {p} }}\n")).collect();
    project.write("m.yaml", &format!("markers:\n{lines}"));
    project.edit("m.cons", "m.yaml");
    assert_data_error(
        &project.mimesh(&["run", "p.yaml"]),
        &[
            "handles on the source (markers, counted from 0): points 0 and 1 lie at the same vertex",
            "keep one of the two",
        ],
    );

    project.edit("type: farthest_point, count: 12", "type: given, vertices: [0, 20, 45, 20]");
    assert_data_error(&project.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml"]), &["vertex 20 is listed twice"]);
}

#[test]
fn repeated_key_points_of_a_file_are_resumed_once() {
    let bar = bar();
    let project = project(&[("bar", &bar)], &[("bar", &bar)], &same(&APART));
    project.write("k.yaml", "markers:\n  - { source: 20, target: null }\n  - { source: 20, target: null }\n");
    let output = project.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml", "--resume"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.read("k.yaml").matches("source: 20,").count(), 1, "{}", project.read("k.yaml"));
}

/// The same shape with three vertices of its own for each triangle, as a file with hard normals has it.
fn split(surface: &Surface) -> Surface {
    let positions = surface.triangles.iter().flatten().map(|&v| surface.positions[v as usize]).collect();
    let triangles = (0..surface.triangle_count() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Surface::from_triangles(positions, triangles).expect("a surface")
}

#[test]
fn handles_on_copies_of_a_vertex_are_one() {
    let whole = bar();
    let bar = split(&whole);
    let copies = |v: u32| (0..).zip(whole.triangles.iter().flatten()).filter(move |(_, w)| **w == v).map(|(i, _)| i);
    let apart: Vec<u32> = APART.iter().map(|&v| copies(v).next().expect("a corner")).collect();
    let good = project(&[("bar", &bar)], &[("bar", &bar)], &same(&apart));
    assert_laws("split", &good);
    let bent = positions(&good.read("out/10.obj"));
    for v in 0..whole.vertex_count() as u32 {
        let places: Vec<_> = copies(v).map(|i| bent[i as usize]).collect();
        assert!(places.iter().all(|p| p == &places[0]), "copies of a vertex stay together");
    }
    key_points("split", &good);

    let twice = copies(0).nth(1).expect("another corner");
    let bad = project(&[("bar", &bar)], &[("bar", &bar)], &same(&[&apart[..], &[twice]].concat()));
    let words = "marker 7 lies on the same point of the source as marker 1";
    assert_data_error(&bad.mimesh(&["run", "p.yaml"]), &[words]);
    let list = format!("type: given, vertices: [{}, {twice}]", apart[0]);
    bad.edit("type: farthest_point, count: 12", &list);
    let words = [&*format!("vertices {} and {twice} are the same point of the surface", apart[0]), "seam"];
    assert_data_error(&bad.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml"]), &words);
}

#[test]
fn flat_patches_keep_laws_and_their_markers_may_lie_on_a_line() {
    let patch = patch();
    let project = |markers: &[u32]| project(&[("patch", &patch)], &[("patch", &patch)], &same(markers));
    let spread = project(&[0, 9, 44, 90, 99]);
    assert_laws("patch", &spread);
    key_points("patch", &spread);
    for reconstruction in ["blend", "gradients"] {
        let line = project(&[0, 3, 6, 9]);
        line.edit("type: biharmonic", &format!("type: biharmonic, reconstruction: {reconstruction}"));
        assert_laws("markers on a line", &line);
        // What the maps do off their plane shows on a target that leaves it.
        let hill = moved(&patch, |p| p + Vector3::z() * (4.0 * p.x * (1.0 - p.x) * p.y * (1.0 - p.y)));
        let hill = self::project(&[("patch", &patch)], &[("hill", &hill)], &same(&[0, 9, 90, 99]));
        hill.edit("type: biharmonic", &format!("type: biharmonic, reconstruction: {reconstruction}"));
        assert_laws("a hill that follows a patch", &hill);
    }
}

/// A surface with triangles that have no area, and one of their vertices.
fn defective(how: &str) -> (Surface, u32) {
    let mut surface = bar();
    let (end, [a, b, _]) = (surface.vertex_count() as u32, surface.triangles[0]);
    let [p, q] = [a, b].map(|v| surface.positions[v as usize]);
    let along = |t: f64| p + (q - p) * t;
    match how {
        "a vertex on an edge" => {
            surface.positions.push(along(0.5));
            surface.triangles.push([a, b, end]);
        }
        "a corner twice" => surface.triangles.push([a, a, b]),
        "an edge without length" => surface.positions[b as usize] = p,
        "a loose line" => {
            surface.positions.extend([along(0.2), along(0.5), along(0.8)]);
            surface.triangles.push([end, end + 1, end + 2]);
        }
        "a loose point" => {
            surface.positions.extend([p; 3]);
            surface.triangles.push([end, end + 1, end + 2]);
        }
        _ => unreachable!("{how}"),
    }
    (surface.clone(), surface.triangles.last().map_or(0, |t| t[2]))
}

#[test]
fn triangles_without_area_do_no_harm() {
    for how in ["a vertex on an edge", "a corner twice", "an edge without length", "a loose line", "a loose point"] {
        let (sound, (defective, vertex)) = (bar(), defective(how));
        let (sound, defective) = ([("bar", &sound)], [("bar", &defective)]);
        let apart = same(&APART[1..]);
        let on_source = project(&defective, &sound, &apart);
        assert_laws(&format!("{how} on the source"), &on_source);
        key_points(how, &on_source);
        assert_laws(&format!("{how} on the target"), &project(&sound, &defective, &apart));
        // A handle there.
        let there = [&apart[..], &[(vertex, vertex)]].concat();
        assert_laws(&format!("{how}, with a handle"), &project(&defective, &defective, &there));
    }
}

#[test]
fn a_handle_on_a_vertex_without_a_triangle_is_named() {
    let bar = bar();
    let mut stray = bar.clone();
    stray.positions.push(Point3::new(0.0, 2.0, 0.0));
    let vertex = bar.vertex_count() as u32;
    let markers = [&same(&APART)[..], &[(5, vertex)]].concat();
    let project = project(&[("bar", &bar)], &[("bar", &stray)], &markers);
    assert_data_error(&project.mimesh(&["run", "p.yaml"]), &[&format!("vertex {vertex}"), "belongs to no polygon"]);
}

/// A project with horse or camel as the source, which is at rest, moved and in its first pose.
fn animals(source: &str, target: &str) -> Option<Project> {
    let (horse, camel, markers) = (data("sumner-horse-poses")?, data("sumner-camel-poses")?, data("markers")?);
    let path = |animal: &str, pose: &str| {
        let folder = if animal == "horse" { &horse } else { &camel };
        folder.join(format!("{animal}-{pose}.obj"))
    };
    let text = std::fs::read_to_string(markers.join("horse_camel.cons")).expect("markers");
    let all: Vec<(u32, u32)> = text
        .lines()
        .filter_map(|line| line.split_once(','))
        .map(|(horse, camel)| (horse.trim().parse().expect("a vertex"), camel.trim().parse().expect("a vertex")))
        .map(|(horse, camel)| if source == "horse" { (horse, camel) } else { (camel, horse) })
        .collect();
    let read = |animal: &str, pose: &str| std::fs::read_to_string(path(animal, pose)).expect("a mesh");
    let target_text = read(target, "reference");
    let places = positions(&target_text);
    // A dozen of the 107 pairs, each the farthest from those before.
    let mut pairs = vec![all[0]];
    while pairs.len() < 12 {
        let apart = |pair: &&(u32, u32)| {
            let to = |other: &(u32, u32)| (places[pair.1 as usize] - places[other.1 as usize]).norm();
            pairs.iter().map(to).fold(f64::INFINITY, f64::min)
        };
        pairs.push(*all.iter().max_by(|a, b| apart(a).total_cmp(&apart(b))).expect("pairs"));
    }
    let project = project(&[], &[], &pairs);
    let rest = read(source, "reference");
    let vertices = positions(&rest).into_iter().map(|p| motion() * p);
    let faces = rest.lines().filter(|line| line.starts_with("f "));
    let turned: String =
        vertices.map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).chain(faces.map(|f| format!("{f}\n"))).collect();
    project.write("rest.obj", &rest);
    project.write("pose-1.obj", &rest);
    project.write("pose-2.obj", &turned);
    project.write("pose-10.obj", &read(source, "01"));
    project.write("target.obj", &target_text);
    project.write("truth.obj", &read(target, "01"));
    Some(project)
}

#[test]
fn a_camel_that_is_no_manifold_takes_and_gives_poses() {
    for (source, target) in [("horse", "camel"), ("camel", "horse")] {
        let Some(project) = animals(source, target) else { return };
        let output = project.mimesh(&["run", "p.yaml"]);
        assert_eq!(output.status, 0, "{}", output.stderr);
        let [rest, at_rest, turned, posed, truth] = ["target", "out/1", "out/2", "out/10", "truth"]
            .map(|name| positions(&project.read(&format!("{name}.obj"))));
        let diagonal = mimesh::core::mesh::diagonal(&rest);
        let mean = |a: &[Point3<f64>], b: &[Point3<f64>]| {
            let shift = a.iter().zip(b).map(|(p, q)| q - p).sum::<Vector3<f64>>() / a.len() as f64;
            a.iter().zip(b).map(|(p, q)| (q - p - shift).norm()).sum::<f64>() / a.len() as f64 / diagonal * 100.0
        };
        let still = at_rest.iter().zip(&rest).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max) / diagonal;
        assert!(still < 1e-9, "{target} at rest: {still} of the diagonal");
        // The target is somewhere else than the source, but turns as one and keeps its size.
        let whole = Similarity::fit(&rest, &turned, &vec![1.0; rest.len()], Orientation::Fitted);
        let there: Vec<_> = rest.iter().map(|p| whole.apply(p)).collect();
        let rigid = there.iter().zip(&turned).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max) / diagonal;
        assert!(rigid < 1e-8 && (whole.scale - 1.0).abs() < 1e-8, "{target}: {rigid}, scale {}", whole.scale);
        let angle = motion().rotation.angle().to_degrees();
        assert!((whole.angle_degrees() - angle).abs() < 1e-5, "{target}: {} and {angle}", whole.angle_degrees());
        let (done, nothing) = (mean(&posed, &truth), mean(&rest, &truth));
        // 20 to 25 % of doing nothing were seen; `truth` is another method's result.
        assert!(done < 0.3 * nothing, "{target}: {done} %, doing nothing {nothing} %");
        if source == "camel" {
            project.edit("pose-*.obj", "pose-10.obj");
            project.edit("max_count: 5, max_rounds: 1", "max_count: 3, max_rounds: 0");
            project.edit("count: 12", "count: 8");
            key_points("camel", &project);
        }
    }
}
