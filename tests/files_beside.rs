//! The files that mesh files refer to: which are opened, and which are not.
#![cfg(all(feature = "bundled", unix))]

mod common;

use std::{fs, os::unix::fs::symlink};

use common::{Project, arm};

const PIPELINE: &str = "\
source: { rest: m/arm.gltf, poses: { clip: Bend, fps: 2 } }
target: { rest: m/arm.gltf }
correspondence: { type: identity }
transfer: { type: copy_displacement }
output: out/arm.glb
";

/// The arm in the folder `p/m` of a pipeline in `p`, with `uri` as its buffer, which lies in `other`.
fn project(uri: &str) -> Project {
    let project = Project::new();
    let mut json = arm::json(&project);
    json["buffers"][0]["uri"] = uri.into();
    project.write("p/m/arm.gltf", &json.to_string());
    project.write("p/p.yaml", PIPELINE);
    fs::create_dir(project.path("other")).unwrap();
    fs::rename(project.path("arm.bin"), project.path("other/arm.bin")).unwrap();
    fs::rename(project.path("skin.png"), project.path("p/m/skin.png")).unwrap();
    project
}

#[test]
fn a_buffer_elsewhere_is_an_error_that_names_the_option() {
    for uri in ["../../other/arm.bin", "/etc/passwd", "link.bin", "/dev/zero"] {
        let project = project(uri);
        symlink(project.path("other/arm.bin"), project.path("p/m/link.bin")).unwrap();
        let output = project.mimesh(&["check", "p/p.yaml"]);
        assert_eq!(output.status, 65, "{uri}: {}", output.stderr);
        for expected in ["arm.gltf", "refers to", "lies neither under its own folder", "`--root DIR`"] {
            assert!(output.stderr.contains(expected), "{uri}: {expected} is not in\n{}", output.stderr);
        }
        assert!(!project.has("p/out"));
    }
}

#[test]
fn a_root_lets_meshes_reach_it() {
    let project = project("../../other/arm.bin");
    for command in [&["check", "p/p.yaml"][..], &["inspect", "p/m/arm.gltf"]] {
        let without = project.mimesh(command);
        assert_eq!(without.status, 65, "{}", without.stderr);
        let with = project.mimesh(&[command, &["--root", "other"]].concat());
        assert_eq!(with.status, 0, "{}", with.stderr);
    }
}

#[test]
fn a_device_under_the_folder_is_not_opened() {
    let project = project("zeros");
    symlink("/dev/zero", project.path("p/m/zeros")).unwrap();
    let output = project.mimesh(&["check", "p/p.yaml", "--root", "/dev"]);
    assert_eq!(output.status, 65, "{}", output.stderr);
    assert!(output.stderr.contains("which is no regular file"), "{}", output.stderr);
}

#[test]
fn the_folder_of_the_pipeline_is_in_reach() {
    let project = project("../arm.bin");
    fs::rename(project.path("other/arm.bin"), project.path("p/arm.bin")).unwrap();
    let output = project.mimesh(&["check", "p/p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
}

#[test]
fn an_image_or_material_library_elsewhere_is_left_alone_with_one_warning() {
    let project = project("arm.bin");
    fs::rename(project.path("other/arm.bin"), project.path("p/m/arm.bin")).unwrap();
    fs::rename(project.path("p/m/skin.png"), project.path("other/skin.png")).unwrap();
    let text = fs::read_to_string(project.path("p/m/arm.gltf")).unwrap();
    fs::write(project.path("p/m/arm.gltf"), text.replace("skin.png", "../../other/skin.png")).unwrap();
    let output = project.mimesh(&["run", "p/p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert_eq!(output.stderr.matches("skin.png").count(), 1, "{}", output.stderr);
    let glb = arm::json_of_glb(&project.bytes("p/out/arm.glb"));
    assert_eq!(glb["images"][0]["uri"], "../../other/skin.png");

    project.write("p/m/box.obj", &format!("mtllib ../../other/box.mtl\nusemtl red\n{}", common::leaning(0.0)));
    project.write("other/box.mtl", "newmtl red\nKd 1 0 0\n");
    let output = project.mimesh(&["inspect", "p/m/box.obj"]);
    assert_eq!((output.status, output.stdout.matches("is not opened").count()), (0, 1), "{}", output.stdout);
    let output = project.mimesh(&["inspect", "p/m/box.obj", "--root", "other"]);
    assert_eq!(output.stdout.matches("is not opened").count(), 0, "{}", output.stdout);
}

#[test]
fn the_files_of_truths_and_poses_are_not_even_hashed_out_of_reach() {
    for uri in ["/dev/zero", "/etc/passwd"] {
        let project = project("arm.bin");
        fs::rename(project.path("other/arm.bin"), project.path("p/m/arm.bin")).unwrap();
        let text = fs::read_to_string(project.path("p/m/arm.gltf")).unwrap().replace("arm.bin", uri);
        fs::write(project.path("p/m/truth-Bend-00.gltf"), &text).unwrap();
        fs::write(project.path("p/m/truth-Bend-01.gltf"), &text).unwrap();
        fs::write(project.path("p/m/truth-Bend-02.gltf"), &text).unwrap();
        project.write("p/p.yaml", &format!("{PIPELINE}truth: 'm/truth-{{pose}}.gltf'\n"));
        // A device without an end would never be hashed.
        let output = project.mimesh(&["run", "p/p.yaml"]);
        assert!(!output.stdout.contains(uri), "{}", output.stdout);
        if project.has("p/out/run.json") {
            let report = common::json(&project.read("p/out/run.json"));
            let inputs = report["inputs"].as_array().expect("inputs");
            assert!(inputs.iter().all(|input| input["path"] != uri), "{uri}: {inputs:?}");
        }
    }
}

/// A file of zeros takes no room on the disk.
#[test]
fn files_beside_count_against_the_memory_before_they_are_read() {
    let project = project("arm.bin");
    fs::rename(project.path("other/arm.bin"), project.path("p/m/arm.bin")).unwrap();
    assert_eq!(project.mimesh(&["inspect", "p/m/arm.gltf", "--memory", "300M"]).status, 0);
    let file = fs::OpenOptions::new().write(true).open(project.path("p/m/arm.bin")).unwrap();
    file.set_len(400 << 20).unwrap();
    let output = project.mimesh(&["inspect", "p/m/arm.gltf", "--memory", "300M"]);
    assert_eq!(output.status, 71, "{}", output.stderr);
    assert!(output.stderr.contains("arm.bin beside the mesh would take 1.3 GB"), "{}", output.stderr);
}
