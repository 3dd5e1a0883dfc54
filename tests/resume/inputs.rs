//! Files that results depend on.

use std::fs;

use serde_json::Value;

use crate::{
    common::{self, Project},
    planned, reused, run, stages,
};

#[test]
fn files_count_by_their_contents_and_not_by_name_or_time() {
    let project = Project::new();
    run(&project, &[]);
    let touched = fs::File::options().append(true).open(project.path("pose-2.obj")).expect("a pose");
    touched.set_modified(std::time::SystemTime::UNIX_EPOCH).expect("a time");
    assert_eq!(reused(&run(&project, &[])).1, 3);

    project.write("pose-2.obj", &common::leaning(0.7));
    let report = run(&project, &[]);
    // `copy_displacement` learns from no pose, so that the others stand.
    assert_eq!(reused(&report).1, 2);
    assert_eq!(planned(&project, "poses", &[]).0, "reuse");
    // Renamed, it is the same pose under another name.
    fs::rename(project.path("pose-2.obj"), project.path("pose-3.obj")).expect("another name");
    assert_eq!(reused(&run(&project, &[])).1, 3);
    assert!(project.has("out/3.obj"));
}

/// A glTF of a tetrahedron, its last corner at `height`: the text, and the bytes of its buffer in the file `buffer`.
fn tetrahedron(buffer: &str, height: f32) -> (String, Vec<u8>) {
    let corners: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]];
    let triangles: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let positions = corners.iter().flatten().flat_map(|x| x.to_le_bytes());
    let bytes = positions.chain(triangles.iter().flat_map(|corner| corner.to_le_bytes())).collect();
    let text = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 24 },
        ],
        "buffers": [{ "uri": buffer, "byteLength": 72 }],
    });
    (text.to_string(), bytes)
}

#[test]
fn a_file_that_a_pose_or_a_truth_names_counts_too() {
    let project = Project::new();
    for (name, height) in [("rest", 1.0), ("pose-1", 1.5), ("truth-1", 1.5)] {
        let (text, bytes) = tetrahedron(&format!("{name}.bin"), height);
        project.write(&format!("{name}.gltf"), &text);
        fs::write(project.path(&format!("{name}.bin")), bytes).expect("a buffer");
    }
    let text = common::PIPELINE.replace("rest.obj", "rest.gltf").replace("pose-*.obj", "pose-*.gltf");
    let text = text.replace("target.obj", "rest.gltf").replace("output:", "truth: truth-{pose}.gltf\noutput:");
    project.write("p.yaml", &text);
    let first = run(&project, &[]);
    let inputs: Vec<_> = first["inputs"].as_array().expect("inputs").iter().map(|input| &input["path"]).collect();
    for name in ["rest", "pose-1", "truth-1"] {
        assert!(inputs.contains(&&Value::from(format!("{name}.bin"))), "{name}: {inputs:?}");
    }
    let mean = |report: &Value| report["poses"][0]["metrics"]["point_error"]["mean"].as_f64().expect("an error");
    assert!(mean(&first) < 1e-6, "the target is the source, and so is the truth: {}", mean(&first));
    assert_eq!(reused(&run(&project, &[])).1, 1);

    fs::write(project.path("truth-1.bin"), tetrahedron("", 2.0).1).expect("a buffer");
    assert!(mean(&run(&project, &[])) > 1.0, "measured against the new truth");
    fs::write(project.path("pose-1.bin"), tetrahedron("", 2.0).1).expect("a buffer");
    let report = run(&project, &[]);
    assert_eq!(reused(&report).1, 0, "another pose");
    assert!(mean(&report) < 1e-6, "{}", mean(&report));
}

#[test]
fn a_file_that_a_stage_reads_counts_too() {
    let project = Project::new();
    project.edit("output:", "keep_correspondence: map.json\noutput:");
    run(&project, &[]);
    project.edit("keep_correspondence: map.json\n", "");
    project.edit("type: identity", "type: from_file, path: map.json");
    run(&project, &[]);
    assert_eq!(reused(&run(&project, &[])).1, 3);
    let map = project.read("map.json");
    project.write("map.json", &format!("{map}\n"));
    assert_eq!(reused(&run(&project, &[])), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    // Under another name it is the same map.
    fs::rename(project.path("map.json"), project.path("other.json")).expect("another name");
    project.edit("path: map.json", "path: other.json");
    assert_eq!(reused(&run(&project, &[])).1, 3);
}
