//! Clips of skinned files as poses, and the target's own file out.
#![cfg(feature = "bundled")]

mod common;

use common::{
    Project,
    arm::{bent, corners, json_of_glb},
    diagnostics, json,
};

/// The arm's clip onto the arm itself: each triangle moves like itself.
const CLIP: &str = "\
source: { rest: arm.gltf, poses: { clip: Bend, fps: 4 } }
target: { rest: arm.gltf }
correspondence: { type: identity }
transfer: { type: gradient }
output: [ 'out/{pose}.obj', out/arm.glb ]
";

fn arm(pipeline: &str) -> Project {
    let project = Project::new();
    common::arm::write(&project);
    project.write("p.yaml", pipeline);
    project
}

/// The vertices of an OBJ.
fn vertices(text: &str) -> Vec<[f64; 3]> {
    let line = |line: &str| -> [f64; 3] {
        let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        numbers.try_into().expect("three numbers")
    };
    text.lines().filter_map(|text| text.strip_prefix("v ")).map(line).collect()
}

/// The joint's quaternions are f32, and so is what the file holds.
const F32: f64 = 1e-6;

#[track_caller]
fn assert_bent(found: &[[f64; 3]], degrees: f64) {
    let expected: Vec<_> = corners().into_iter().map(|corner| bent(corner, degrees)).collect();
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        for k in 0..3 {
            assert!((found[k] - expected[k]).abs() < F32, "{degrees}°: {found:?}, expected {expected:?}");
        }
    }
}

#[test]
fn frames_of_a_clip_are_poses_with_their_times() {
    let project = arm(CLIP);
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    for (frame, degrees) in [0.0, 22.5, 45.0, 67.5, 90.0].into_iter().enumerate() {
        assert_bent(&vertices(&project.read(&format!("out/Bend-{frame:02}.obj"))), degrees);
    }

    let glb = json_of_glb(&project.bytes("out/arm.glb"));
    let source = common::arm::json(&project);
    for kept in ["nodes", "skins", "textures", "materials", "extensions", "scenes"] {
        assert_eq!(glb[kept], source[kept], "{kept}");
    }
    assert_eq!(
        glb["meshes"][0]["extras"]["targetNames"],
        serde_json::json!(["Bend-00", "Bend-01", "Bend-02", "Bend-03", "Bend-04"])
    );
    assert_eq!(glb["animations"][0], source["animations"][0], "the clip of the skeleton");
    let times = glb["animations"][1]["samplers"][0]["input"].as_u64().expect("times") as usize;
    assert_eq!(glb["accessors"][times]["max"][0], 1.0, "the clip's own time");
    assert!(glb["images"][0].get("uri").is_none(), "the image is inside, wherever the file lies: {}", glb["images"][0]);
}

#[test]
fn what_is_written_moves_as_it_should_when_it_is_read() {
    let project = arm(CLIP);
    project.mimesh(&["run", "p.yaml"]);
    // The written file's morph targets are poses of it.
    project.write(
        "p.yaml",
        &CLIP
            .replace("{ rest: arm.gltf, poses: { clip: Bend, fps: 4 } }", "{ rest: out/arm.glb }")
            .replace("out/", "again/")
            .replace("again/arm.glb }", "out/arm.glb }"),
    );
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert_bent(&vertices(&project.read("again/Bend-02.obj")), 45.0);
}

#[test]
fn a_file_of_poses_gives_its_clip() {
    let project = arm(&CLIP.replace("poses: { clip: Bend, fps: 4 }", "poses: arm.gltf").replace("clip: Bend", ""));
    // The rest itself is no pose; the same mesh in another file is.
    std::fs::copy(project.path("arm.gltf"), project.path("run.gltf")).expect("a copy");
    project.edit("poses: arm.gltf", "poses: run.gltf");
    let plan = project.mimesh(&["check", "p.yaml"]);
    assert!(plan.stdout.contains("25 poses"), "24 frames a second and the last: {}", plan.stdout);
}

#[test]
fn a_moment_of_a_clip_serves_as_the_rest() {
    let project =
        arm(&CLIP.replace("target: { rest: arm.gltf }", "target: { rest: { file: arm.gltf, clip: Bend, time: 1 } }"));
    project.edit("source: { rest: arm.gltf,", "source: { rest: { file: arm.gltf, clip: Bend, time: 1 },");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert_bent(&vertices(&project.read("out/Bend-04.obj")), 90.0);
    assert_bent(&vertices(&project.read("out/Bend-01.obj")), 22.5);
}

#[test]
fn wrong_clips_and_meshes_are_named_with_those_there_are() {
    let project = arm(CLIP);
    let first = |setting: &str| {
        let output = project.mimesh(&["check", "p.yaml", "--set", setting]);
        assert_ne!(output.status, 0, "{setting}");
        output.stderr
    };
    let cases = [
        ("source.poses={clip: Bent}", ["no clip is called `Bent`", "the file has `Bend`"]),
        ("source.poses=null", ["has no poses", "poses: { clip: Bend }"]),
        ("source.rest={file: arm.gltf, meshes: [leg]}", ["leg", "arm"]),
        ("target.rest={file: arm.gltf, meshes: []}", ["no mesh is named", "leave `meshes` out"]),
        ("target.rest={file: arm.gltf, time: 1}", ["`time` without `clip`", "name the clip"]),
        ("target.rest={file: arm.gltf, pose: smile, clip: Bend}", ["`clip` beside `pose`", "remove one"]),
        ("target.rest={file: arm.gltf, mesh: arm}", ["unknown key `mesh`", "meshes"]),
        ("source.poses={clip: Bend, fps: 4, at_keys: true}", ["`fps` beside `at_keys`", "remove one"]),
        ("source.poses={clip: Bend, range: [2, 1]}", ["expected a first time", "range: [0.5, 1.5]"]),
        ("source.poses={clip: Bend, fps: 0}", ["`fps`: expected 0.001 to 10000", "found 0"]),
    ];
    for (setting, expected) in cases {
        let stderr = first(setting);
        expected.iter().for_each(|text| assert!(stderr.contains(text), "{setting}: {text} is not in\n{stderr}"));
    }
}

#[test]
fn inspect_lists_clips_and_the_mesh_lies_where_its_joints_put_it() {
    let project = arm(CLIP);
    let inspected = project.mimesh(&["inspect", "arm.gltf", "--json"]).json();
    assert_eq!(inspected["animations"][0]["name"], "Bend");
    assert_eq!(inspected["animations"][0]["seconds"], 1.0);
    // The node of a skinned mesh does not move it: (5, 6, 7) is nowhere.
    assert_eq!(inspected["statistics"]["bounding_box"][1][1], 2.0, "{}", inspected["statistics"]);
}

#[test]
fn names_that_other_systems_refuse_are_found() {
    let project = Project::new();
    let poses = ["pose-CON.obj", "pose-con2.obj", "pose-Con2.obj"];
    for pose in poses {
        project.write(pose, &common::leaning(0.1));
    }
    let warnings = json(&project.mimesh(&["check", "p.yaml", "--json"]).stdout)["warnings"].to_string();
    if cfg!(not(any(windows, target_os = "macos"))) {
        assert!(warnings.contains("names that Windows reserves: `CON.obj`"), "{warnings}");
        assert!(warnings.contains("differ in capitals alone"), "{warnings}");
    }
    let long = "x".repeat(300);
    project.edit("output: out/{pose}.obj", &format!("output: 'out/{long}{{pose}}.obj'"));
    let found = diagnostics(&project, &[]);
    assert!(found[0].contains("more than the 255 of file systems"), "{found:?}");
}

#[test]
fn a_target_that_rests_in_a_morph_target_gets_shapes_that_stand_alone() {
    let project = arm(CLIP);
    project.mimesh(&["run", "p.yaml"]);
    // The first result rests bent by its own morph target, and takes the clip from there.
    std::fs::rename(project.path("out/arm.glb"), project.path("bent.glb")).expect("a move");
    let rest = "source: { rest: { file: arm.gltf, clip: Bend, time: 1 }, poses: { clip: Bend, fps: 4 } }";
    project.edit("source: { rest: arm.gltf, poses: { clip: Bend, fps: 4 } }", rest);
    project.edit("target: { rest: arm.gltf }", "target: { rest: { file: bent.glb, pose: Bend-04 } }");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    let targets = json_of_glb(&project.bytes("out/arm.glb"))["meshes"][0]["extras"]["targetNames"].clone();
    assert_eq!((targets[6].as_str(), targets.as_array().map(Vec::len)), (Some("Bend-01-2"), Some(10)), "{targets}");
    let shown = "source: { rest: out/arm.glb }\ntarget: { rest: arm.gltf }\ncorrespondence: { type: identity }\n\
                 transfer: { type: gradient }\noutput: 'again/{pose}.obj'\n";
    project.write("p.yaml", shown);
    project.mimesh(&["run", "p.yaml"]);
    assert_bent(&vertices(&project.read("again/Bend-01-2.obj")), 22.5);
}
