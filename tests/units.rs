//! Units and axes: of files of poses, of the target and of results.
#![cfg(feature = "bundled")]

mod common;

use std::{fs, path::Path};

use common::{Project, arm::json_of_glb, cube, diagnostics};
use mimesh::{
    core::{mesh::MeshSequence, stage::Selection},
    pipeline::{Formats, Reach},
};
use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

/// From metres with Y up to `per_metre` units a metre with Z up.
fn to_z_up(per_metre: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    move |[x, y, z]| [x, -z, y].map(|x| per_metre * x)
}

fn leans(amount: f64) -> impl Fn([f64; 3]) -> [f64; 3] {
    move |[x, y, z]| [x + amount * z, y, z]
}

/// A project whose poses lean a little, all of them changed by `change`.
fn with_poses(change: impl Fn([f64; 3]) -> [f64; 3]) -> Project {
    let project = Project::new();
    for pose in [1, 2, 10] {
        let lean = leans(0.03 * f64::from(pose));
        project.write(&format!("pose-{pose}.obj"), &cube(|corner| change(lean(corner))));
    }
    project
}

fn run(project: &Project, settings: &[&str]) -> Value {
    let mut arguments = vec!["run", "p.yaml", "--json"];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    let output = project.mimesh(&arguments);
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

/// The warnings that have `words`.
fn warnings_with(report: &Value, words: &str) -> Vec<String> {
    let all = report["warnings"].as_array().expect("warnings").iter().filter_map(Value::as_str);
    all.filter(|warning| warning.contains(words)).map(str::to_owned).collect()
}

fn read(project: &Project, name: &str) -> MeshSequence {
    let path = project.path(name);
    let formats = Formats::new(vec![], Reach::new([path.parent().unwrap_or(Path::new(""))]));
    formats.read(&path, &Selection::default()).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn farthest(a: &[Point3<f64>], b: &[Point3<f64>]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// The larger of two results has a diagonal below 12, and OBJs keep coordinates to 5e-10 of it.
const OBJ_ROUNDING: f64 = 1e-8;

const KEYS: &str = "say `source: { unit: m, up: y, poses_unit: cm, poses_up: z }`";

#[test]
fn poses_in_another_unit_and_axes_are_named_and_taken_into_those_of_the_rest() {
    let expected = with_poses(|corner| corner);
    let report = run(&expected, &[]);
    assert_eq!(warnings_with(&report, "another unit"), Vec::<String>::new());

    let project = with_poses(to_z_up(100.0));
    let checked = project.mimesh(&["check", "p.yaml"]);
    assert!((checked.stdout.clone() + &checked.stderr).contains(KEYS), "{} {}", checked.stdout, checked.stderr);
    let told = warnings_with(&run(&project, &[]), KEYS);
    let [told] = &told[..] else { panic!("{told:?}") };
    assert!(told.contains("times 100 and turned from Y up to Z up, (x, y, z) to (x, -z, y)"), "{told}");

    let keys = ["source.unit=m", "source.up=y", "source.poses_unit=cm", "source.poses_up=z"];
    let report = run(&project, &keys);
    assert_eq!(warnings_with(&report, "poses"), Vec::<String>::new());
    for pose in ["1", "2", "10"] {
        let name = format!("out/{pose}.obj");
        let off = farthest(&read(&project, &name).rest.positions, &read(&expected, &name).rest.positions);
        assert!(off <= OBJ_ROUNDING, "{name}: {off}");
    }
    // The keys are part of what results are cached by, and wrong ones are told.
    let told = warnings_with(&run(&project, &["source.unit=m", "source.poses_unit=mm"]), "change these keys");
    assert_eq!(told.len(), 1);
    assert!(farthest(&read(&project, "out/1.obj").rest.positions, &read(&expected, "out/1.obj").rest.positions) > 1.0);
}

#[test]
fn poses_of_a_point_cache_are_converted_too() {
    let project = with_poses(|corner| corner);
    project.edit("target.obj", "rest.obj, unit: m, up: y");
    let outputs = "output=[out/all.pc2, 'out/{pose}.obj']";
    run(&project, &[outputs, "output_unit=cm", "output_up=z"]);
    let [_, high] = extent(&read(&project, "out/1.obj").rest.positions);
    assert_eq!(high.z, 200.0, "two metres high");
    let change = ["source.unit=m", "source.up=y", "source.poses_unit=cm", "source.poses_up=z"];
    let held = [&["source.poses=out/all.pc2", "output=back/{pose}.obj"][..], &change].concat();
    assert_eq!(warnings_with(&run(&project, &held[..2]), KEYS).len(), 1);
    assert_eq!(warnings_with(&run(&project, &held), "another unit"), Vec::<String>::new());
    for (name, pose) in project.names("back").iter().filter(|name| name.ends_with(".obj")).zip([1, 2, 10]) {
        let expected = read(&project, &format!("pose-{pose}.obj"));
        let off = farthest(&read(&project, &format!("back/{name}")).rest.positions, &expected.rest.positions);
        // A point cache has f32: 6e-8 of coordinates up to 4, thrice.
        assert!(off <= 1e-6, "{name}: {off}");
    }
}

fn extent(positions: &[Point3<f64>]) -> [Point3<f64>; 2] {
    positions.iter().fold([positions[0]; 2], |[low, high], p| [low.inf(p), high.sup(p)])
}

#[test]
fn a_quarter_turn_alone_is_told_and_never_undone_unasked() {
    let project = with_poses(to_z_up(1.0));
    let told = warnings_with(&run(&project, &[]), "if the shape really lies in its poses, nothing is to be done");
    let [told] = &told[..] else { panic!("{told:?}") };
    assert!(told.contains("say `source: { up: y, poses_up: z }`"), "{told}");
    let lying = project.read("out/10.obj");
    run(&project, &["source.up=y", "source.poses_up=y"]);
    assert_eq!(project.read("out/10.obj"), lying);
    // A shape that lies in some poses only has fallen.
    project.write("pose-1.obj", &cube(leans(0.03)));
    assert_eq!(warnings_with(&run(&project, &[]), "than their rest"), Vec::<String>::new());
}

/// A target with normals: of its sides, and one that leans.
fn write_target(project: &Project) {
    let normals = "vn 0 0 -1\nvn 0 0 1\nvn 0 -0.6 0.8\nvn 0 1 0\nvn -1 0 0\nvn 1 0 0\n";
    let text = cube(|corner| corner.map(|x| 2.0 * x));
    let faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    let mut with = String::from("# kept\n") + text.split("f ").next().expect("vertices") + normals;
    for (i, face) in faces.into_iter().enumerate() {
        let corners: Vec<_> = face.split(' ').map(|v| format!("{v}//{}", i + 1)).collect();
        with += &format!("f {}\n", corners.join(" "));
    }
    project.write("target.obj", &with);
    project.edit("target.obj", "target.obj, unit: cm, up: y");
}

#[test]
fn results_in_bare_numbers_are_in_the_unit_and_axes_that_the_pipeline_says() {
    let project = Project::new();
    write_target(&project);
    let outputs = |folder: &str| {
        format!(
            "output=[{}]",
            ["obj", "ply", "stl", "off"].map(|kind| format!("'{folder}/{{pose}}.{kind}'")).join(", ")
        )
    };
    run(&project, &[&outputs("as-is")]);
    let report = run(&project, &[&outputs("changed"), "output_unit=mm", "output_up=z"]);
    let told = warnings_with(&report, "as the pipeline says");
    assert_eq!(
        told,
        ["results in .obj, .off, .ply, .stl files are those of the target times 10 and turned from Y up to Z up, \
          (x, y, z) to (x, -z, y), as the pipeline says"]
    );
    assert!(project.read("changed/10.obj").starts_with("# kept\nv "), "the file of the target otherwise");
    let change = to_z_up(10.0);
    for kind in ["obj", "ply", "stl", "off"] {
        let [plain, changed] = ["as-is", "changed"].map(|folder| read(&project, &format!("{folder}/10.{kind}")).rest);
        let back: Vec<_> = plain.positions.iter().map(|p| Point3::from(change((*p).into()))).collect();
        // STL has f32 of coordinates up to 100.
        assert!(farthest(&back, &changed.positions) <= 2e-5, "{kind}");
        assert_eq!(plain.polygons, changed.polygons);
        let normals = |mesh: &mimesh::core::mesh::Mesh| mesh.normals.as_ref().map(|n| n.values.clone());
        assert_eq!(normals(&plain).is_some(), normals(&changed).is_some(), "{kind}");
        for (plain, changed) in normals(&plain).iter().flatten().zip(normals(&changed).iter().flatten()) {
            let turned = Vector3::from(to_z_up(1.0)(*plain));
            // OBJs have four decimals of a normal.
            assert!((turned - Vector3::from(*changed)).norm() <= 2e-4, "{kind}: {plain:?} {changed:?}");
        }
    }
    // The way back, from another target: the same numbers.
    project.write("changed/run.json", "{}");
    let back = ["target={ rest: changed/10.obj, unit: mm, up: z }", "source.poses=rest.obj", "output=back/{pose}.obj"];
    project.write("rest-copy.obj", &project.read("rest.obj"));
    let back = [&back[..1], &["source.poses=rest-copy.obj", back[2], "output_unit=cm", "output_up=y"]].concat();
    run(&project, &back);
    let name = project.names("back").into_iter().find(|name| name.ends_with(".obj")).expect("a result");
    let [there, here] = ["as-is/10.obj", &format!("back/{name}")].map(|name| read(&project, name).rest.positions);
    assert!(farthest(&there, &here) <= 2.0 * OBJ_ROUNDING);
}

#[test]
fn results_in_another_unit_are_compared_as_those_of_the_target() {
    let project = Project::new();
    write_target(&project);
    let folders = ["plain", "again", "changed"];
    for folder in folders {
        let output = format!("output={folder}/{{pose}}.obj");
        let mut settings = vec![output.as_str(), "truth=truth-{pose}.obj"];
        for pose in [1, 2, 10] {
            project.write(&format!("truth-{pose}.obj"), &cube(|corner| corner.map(|x| 2.0 * x)));
        }
        if folder == "changed" {
            settings.extend(["output_unit=mm", "output_up=z"]);
        }
        run(&project, &settings);
    }
    let pictures = |other: &str| -> Vec<String> {
        let output = project.mimesh(&["compare", "plain", other, "--out", "c.html"]);
        assert_eq!(output.status, 0, "{}", output.stderr);
        let page = project.read("c.html");
        page.split("data:image/").skip(1).map(|rest| rest.split('"').next().unwrap_or_default().to_owned()).collect()
    };
    let expected = pictures("again");
    assert!(expected.len() > 1);
    // Images are too long to print.
    assert!(pictures("changed") == expected);
}

#[test]
fn files_that_say_their_unit_say_that_of_the_target_and_others_stay_byte_for_byte() {
    let project = Project::new();
    let outputs = "output=['out/{pose}.obj', out/all.glb, out/all.usda]";
    run(&project, &[outputs]);
    let [obj, usd] = ["out/10.obj", "out/all.usda"].map(|name| project.read(name));
    let glb = project.bytes("out/all.glb");
    run(&project, &[outputs, "target.unit=m", "target.up=y", "output_unit=m", "output_up=y"]);
    assert_eq!(project.bytes("out/all.glb"), glb);
    assert_eq!((project.read("out/10.obj"), project.read("out/all.usda")), (obj.clone(), usd));

    let node = |settings: &[&str]| {
        run(&project, &[&[outputs, "target.unit=cm", "target.up=z"], settings].concat());
        assert_eq!(project.read("out/10.obj"), obj);
        let json = json_of_glb(&fs::read(project.path("out/all.glb")).expect("a file"));
        let nodes = json["nodes"].as_array().expect("nodes").clone();
        nodes.into_iter().find(|node| node.get("mesh").is_some()).expect("a node with a mesh")
    };
    let half = -0.5_f64.sqrt();
    let own = node(&[]);
    assert_eq!((&own["scale"][0], &own["rotation"][0]), (&json!(0.01), &json!(half)));
    let usd = project.read("out/all.usda");
    assert!(usd.contains("metersPerUnit = 0.01") && usd.contains("upAxis = \"Z\""), "{}", &usd[..200]);
    // What the format itself is told stays.
    let set = node(&["formats=[{ type: glb, unit: mm }]"]);
    assert_eq!((&set["scale"][0], &set["rotation"][0]), (&json!(0.001), &json!(half)));
    let third = node(&["target.up=x", "output=out/all.glb"]);
    assert_eq!(third["rotation"], json!([0.5, 0.5, 0.5, 0.5]));
}

#[test]
fn a_unit_that_cannot_be_known_is_asked_for() {
    let project = Project::new();
    let one = |settings: &[&str]| diagnostics(&project, settings).join("\n");
    let unit = one(&["source.poses_unit=cm"]);
    assert!(unit.contains("`poses_unit`, and the unit of the rest is not known"), "{unit}");
    let up = one(&["source.unit=m", "source.poses_up=z"]);
    assert!(up.contains("`poses_up`, and the upward axis of the rest is not known"), "{up}");
    let output = one(&["output_unit=cm", "output_up=z"]);
    assert!(output.contains("`output_unit`, and the unit of the target") && output.contains("`output_up`"), "{output}");
    let wrong = one(&["target.unit=yard"]);
    assert!(wrong.contains("yard"), "{wrong}");
    project.edit("rest: rest.obj, poses: pose-*.obj", "generator: { type: quadruped, frames: 2 }");
    let own = one(&["source.poses_unit=cm"]);
    assert!(own.contains("`poses_unit` for poses that come with the rest"), "{own}");
}
