//! Clips of skinned files as poses, and the target's own file out.
#![cfg(feature = "bundled")]

mod common;

use common::{
    Project,
    arm::{bent, corners, json_of_glb},
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

    // New shapes move the bent arm, and the clip that shows them holds its skeleton bent.
    assert!(output.stderr.contains("rests in the clip `Bend`"), "{}", output.stderr);
    project.write(
        "p.yaml",
        &CLIP
            .replace(
                "arm.gltf, poses: { clip: Bend, fps: 4 }",
                "arm.gltf, poses: { file: out/arm.glb, clip: Bend-poses, at_keys: true }",
            )
            .replace("out/", "again/")
            .replace("again/arm.glb,", "out/arm.glb,"),
    );
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    for (frame, degrees) in [0.0, 22.5, 45.0, 67.5, 90.0].into_iter().enumerate() {
        assert_bent(&vertices(&project.read(&format!("again/Bend-poses-{frame:02}.obj"))), degrees);
    }
}

#[test]
fn a_shape_serves_as_the_rest_of_a_clip() {
    let project = arm(CLIP);
    project.mimesh(&["run", "p.yaml"]);
    project.edit("source: { rest: arm.gltf,", "source: { rest: { file: out/arm.glb, pose: Bend-02 },");
    project.edit("target: { rest: arm.gltf }", "target: { rest: { file: out/arm.glb, pose: Bend-02 } }");
    project.edit("output: [ 'out/{pose}.obj', out/arm.glb ]", "output: 'again/{pose}.obj'");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    // Both rest bent by 45°: the triangles of each move alike.
    assert_bent(&vertices(&project.read("again/Bend-00.obj")), 0.0);
    assert_bent(&vertices(&project.read("again/Bend-04.obj")), 90.0);
}

#[test]
fn clips_of_one_name_in_several_files_are_called_like_their_files() {
    let project = arm(&CLIP.replace("{ clip: Bend, fps: 4 }", "[walk.gltf, run.gltf]"));
    for name in ["walk.gltf", "run.gltf"] {
        std::fs::copy(project.path("arm.gltf"), project.path(name)).expect("a copy");
    }
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert_bent(&vertices(&project.read("out/walk-Bend-12.obj")), 45.0);
    assert_bent(&vertices(&project.read("out/run-Bend-24.obj")), 90.0);
    let glb = json_of_glb(&project.bytes("out/arm.glb"));
    let clips: Vec<_> = glb["animations"].as_array().expect("clips").iter().map(|clip| clip["name"].clone()).collect();
    assert_eq!(clips, ["Bend", "walk-Bend", "run-Bend"]);
}

/// Adds the clip `Still`, which moves a node that carries nothing.
fn add_still_clip(project: &Project, file: &str, alone: bool) {
    let mut json = common::arm::json(project);
    let prop = json["nodes"].as_array().expect("nodes").len();
    json["nodes"].as_array_mut().expect("nodes").push(serde_json::json!({ "name": "prop" }));
    json["scenes"][0]["nodes"].as_array_mut().expect("roots").push(prop.into());
    let mut still = json["animations"][0].clone();
    still["name"] = "Still".into();
    still["channels"][0]["target"]["node"] = prop.into();
    let clips = json["animations"].as_array_mut().expect("clips");
    if alone {
        clips.clear();
    }
    clips.push(still);
    project.write(file, &json.to_string());
}

#[test]
fn clips_that_do_not_move_the_mesh_give_no_poses() {
    let project = arm(&CLIP.replace("clip: Bend", "clip: '*'"));
    add_still_clip(&project, "arm.gltf", false);
    let check = project.mimesh(&["check", "p.yaml"]);
    assert!(check.stdout.contains("5 poses"), "{}", check.stdout);
    assert!(check.stderr.contains("clips that do not move the mesh: `Still`"), "{}", check.stderr);
    let still = project.mimesh(&["check", "p.yaml", "--set", "source.poses={clip: Still}"]);
    assert!(still.status != 0 && still.stderr.contains("no key of the clip moves the mesh"), "{}", still.stderr);
    // A file of one such clip is a pose as it stands.
    add_still_clip(&project, "other.gltf", true);
    let one = project.mimesh(&["check", "p.yaml", "--set", "source.poses=other.gltf"]);
    assert!(one.status == 0 && one.stdout.contains("1 pose"), "{}{}", one.stdout, one.stderr);
    // A clip that is named twice is still one.
    let twice = project.mimesh(&["check", "p.yaml", "--set", "source.poses={clip: [Bend, Bend], fps: 4}"]);
    assert!(twice.stdout.contains("5 poses"), "{}", twice.stdout);
}

#[test]
fn times_outside_a_clip_and_choices_that_a_format_does_not_know_are_told() {
    let project = arm(CLIP);
    project.mimesh(&["run", "p.yaml"]);
    let late = project.mimesh(&["check", "p.yaml", "--set", "target.rest={file: arm.gltf, clip: Bend, time: 7}"]);
    assert!(late.stderr.contains("the clip `Bend` has no time 7 s: the rest is that of 1 s"), "{}", late.stderr);
    for (slot, choice) in [("target", "meshes: [arm]"), ("target", "pose: smile"), ("source", "clip: Bend, time: 1")] {
        let set = format!("{slot}.rest={{file: out/Bend-00.obj, {choice}}}");
        let output = project.mimesh(&["check", "p.yaml", "--set", &set]);
        let key = choice.split(':').next().expect("a key");
        let expected = format!("`{key}` for a .obj file");
        assert!(output.status != 0 && output.stderr.contains(&expected), "{set}: {}", output.stderr);
    }
}

#[test]
fn shapes_of_the_target_are_told_from_results() {
    let project = arm(CLIP);
    project.mimesh(&["run", "p.yaml"]);
    // The target has shapes of the names of the poses already.
    project.edit("target: { rest: arm.gltf }", "target: { rest: out/arm.glb }");
    project.edit("output: [ 'out/{pose}.obj', out/arm.glb ]", "truth: 'out/{pose}.obj'\noutput: again/arm.glb");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    let report: serde_json::Value = serde_json::from_str(&project.read("again/run.json")).expect("a report");
    assert_eq!(report["outputs"][0]["renamed"]["Bend-04"], "Bend-04-2");
    // Pictures show the results, whose errors are known: all vertices have their place.
    let compared = project.mimesh(&["compare", "again/run.json", "out/run.json", "--out", "c.html"]);
    assert_eq!((compared.status, &*compared.stderr), (0, ""));

    // Of a file with both, known results choose theirs.
    let score = project.mimesh(&["score", "again/arm.glb", "out/arm.glb"]);
    assert!(score.stderr.contains("left out: Bend-00-2"), "{}", score.stderr);
    assert_eq!(score.status, 0, "{}", score.stderr);
    // A file that was written from the target is no truth by the names of its own shapes.
    let truth = project.mimesh(&["check", "p.yaml", "--set", "truth=again/arm.glb", "--set", "output=c.glb"]);
    assert!(truth.stderr.contains("the target itself has these shapes"), "{}", truth.stderr);
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
