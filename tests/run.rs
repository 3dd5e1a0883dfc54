//! `mimesh run` as a script sees it: exit status, stdout, stderr and files.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, json, leaning, wait_for};

#[test]
fn a_run_writes_every_pose_and_a_report_and_ends_with_0() {
    let project = Project::new();
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
    assert!(
        output.stdout.contains("correspondence found for 12 of 12 target triangles (100.0 %)"),
        "{}",
        output.stdout
    );
    assert!(output.stdout.lines().last().is_some_and(|line| line.starts_with("done in ")), "{}", output.stdout);
}

#[test]
fn poses_go_in_natural_order() {
    let project = Project::new();
    assert_eq!(project.mimesh(&["run", "p.yaml", "--quiet"]).status, 0);
    let report = json(&project.read("out/run.json"));
    let names: Vec<_> = report["poses"].as_array().unwrap().iter().map(|pose| pose["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["1", "2", "10"]);
}

#[test]
fn the_report_records_settings_inputs_and_outputs() {
    let project = Project::new();
    project.edit("output:", "truth: pose-{pose}.obj\noutput:");
    let output = project.mimesh(&["run", "p.yaml", "--set", "target.rest=rest.obj", "--threads", "1"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let report = json(&project.read("out/run.json"));
    assert_eq!(report["mimesh"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["set"], serde_json::json!(["target.rest=rest.obj"]));
    assert_eq!(report["threads"], 1);
    assert_eq!(report["settings"]["target"]["rest"], "rest.obj");
    assert_eq!(report["settings"]["transfer"]["type"], "copy_displacement");
    let rest = report["inputs"].as_array().unwrap().iter().find(|input| input["role"] == "source rest").unwrap();
    let bytes = project.bytes("rest.obj");
    assert_eq!(rest["bytes"], bytes.len());
    assert_eq!(rest["blake3"], blake3::hash(&bytes).to_hex().as_str());
    assert_eq!(report["outputs"].as_array().unwrap().len(), 3);
    // The target is the source, so only rounding is left.
    assert!(report["metrics"]["point_error"]["worst"]["max"].as_f64().unwrap() < 1e-6);
    assert!(report["metrics"]["point_error"]["nothing"]["mean"].as_f64().unwrap() > 1.0);
    assert_eq!(report["stages"][1]["type"], "identity");
}

#[test]
fn json_is_the_report_and_nothing_else() {
    let project = Project::new();
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(json(&output.stdout), json(&project.read("out/run.json")));
}

#[test]
fn without_a_terminal_progress_is_plain_lines_and_quiet_is_silent() {
    let project = Project::new();
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.stderr, "correspondence (identity)\ntransfer (copy_displacement)\nposes (0 of 3)\nwriting\n");
    let quiet = project.mimesh(&["run", "p.yaml", "--quiet"]);
    assert_eq!((quiet.stderr.as_str(), quiet.stdout.as_str()), ("", ""));
}

#[test]
fn results_are_the_same_on_any_number_of_threads() {
    let project = Project::new();
    project.edit("output: out/{pose}.obj", "output: [out/{pose}.obj, out/all.glb]");
    for threads in ["1", "2"] {
        let output = project.mimesh(&["run", "p.yaml", "--threads", threads, "--out", &format!("out{threads}")]);
        assert_eq!(output.status, 0, "{}", output.stderr);
    }
    for name in ["1.obj", "2.obj", "10.obj", "all.glb"] {
        let bytes = |threads: u8| project.bytes(&format!("out{threads}/{name}"));
        assert!(bytes(1) == bytes(2), "{name} differs");
    }
}

#[test]
fn set_values_are_checked_like_those_of_the_file() {
    let project = Project::new();
    let output = project.mimesh(&["run", "p.yaml", "--set", "transfer.type=gradiant", "--set", "source.pose=1"]);
    assert_eq!(output.status, 78);
    assert_eq!(
        output.stderr,
        "error: --set source.pose=1: unknown key `pose`\n  hint: did you mean `poses`?\n\
         error: --set transfer.type=gradiant: unknown transfer `gradiant`\n  hint: did you mean `gradient`?\n2 mistakes\n"
    );
    assert_eq!(project.mimesh(&["run", "p.yaml", "--set", "output"]).status, 2);
}

#[test]
fn an_input_is_never_overwritten() {
    let project = Project::new();
    project.edit("out/{pose}.obj", "pose-{pose}.obj");
    let before = project.read("pose-1.obj");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 78);
    assert_eq!(
        output.stderr,
        "error: p.yaml:5:9: pose-1.obj would overwrite an input (pose)\n   |\n 5 | output: pose-{pose}.obj\n   |         \
         ^^^^^^^^^^^^^^^\n   = hint: write into another folder, e.g. `out/{pose}.obj`\n"
    );
    assert_eq!(project.read("pose-1.obj"), before);
}

#[cfg(unix)]
#[test]
fn an_input_is_not_overwritten_through_a_link_either() {
    let project = Project::new();
    std::os::unix::fs::symlink(project.path("."), project.path("out")).unwrap();
    project.edit("out/{pose}.obj", "out/pose-{pose}.obj");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!(output.stderr.contains("out/pose-1.obj would overwrite an input (pose)"), "{}", output.stderr);
}

#[test]
fn a_bad_pose_leaves_the_others_and_ends_with_4() {
    let project = Project::new();
    project.write("pose-2.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 4);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "run.json"]);
    assert!(output.stdout.contains("failed: 2 (1 of 3)"), "{}", output.stdout);
    assert!(output.stderr.contains("error: pose-2.obj: "), "{}", output.stderr);
    let report = json(&project.read("out/run.json"));
    assert_eq!(report["status"], "partly");
    assert!(report["poses"][1]["error"]["message"].as_str().unwrap().contains("3 vertices"));
}

#[test]
fn a_run_in_which_every_pose_fails_writes_nothing_and_ends_with_65() {
    let project = Project::new();
    for pose in [1, 2, 10] {
        project.write(&format!("pose-{pose}.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    }
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 65);
    assert_eq!(project.names("out"), [""; 0]);
}

#[test]
fn a_run_that_cannot_write_keeps_what_was_there() {
    let project = Project::new();
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 0);
    let before = project.read("out/1.obj");
    // A folder in the place of the second output is found before anything is computed.
    std::fs::create_dir(project.path("out/all.glb")).unwrap();
    project.write("pose-1.obj", &leaning(0.7));
    let output = project.mimesh(&["run", "p.yaml", "--set", "output=['out/{pose}.obj', out/all.glb]"]);
    assert_eq!(output.status, 73, "{}", output.stderr);
    assert_eq!(project.read("out/1.obj"), before);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "all.glb", "run.json"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_ends_with_130_and_leaves_no_partial_file() {
    use std::process::{Command, Stdio};

    let project = Project::new();
    // So many poses that the run goes on for a while after the first temporary file.
    project.write(
        "p.yaml",
        "source: { generator: { type: quadruped, resolution: 40, frames: 600 } }\n\
         target: { generator: { type: quadruped, resolution: 40, gait: none } }\n\
         correspondence: { type: identity }\ntransfer: { type: gradient }\noutput: out/{pose}.obj\n",
    );
    let mut child = project.command(&["run", "p.yaml", "--quiet"]).stdout(Stdio::null()).spawn().unwrap();
    wait_for("a temporary file", || !project.names("out").is_empty());
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let status = child.wait().unwrap();
    assert!(killed.success());
    assert_eq!(status.code(), Some(130));
    assert_eq!(project.names("out"), [""; 0]);
}

#[test]
fn a_correspondence_file_is_read_back() {
    let project = Project::new();
    project.edit("output:", "keep_correspondence: pairs/pairs.json\noutput:");
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 0);
    let file = json(&project.read("pairs/pairs.json"));
    assert_eq!((&file["format"], &file["version"]), (&"mimesh-correspondence".into(), &1.into()));
    assert_eq!(file["source_triangles"], 12);
    let first = project.read("out/2.obj");
    project.edit("keep_correspondence: pairs/pairs.json\n", "");
    project.edit("{ type: identity }", "{ type: from_file, path: pairs/pairs.json }");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.read("out/2.obj"), first);
}

#[test]
fn results_from_a_correspondence_file_are_those_of_the_run_that_wrote_it_to_the_last_bit() {
    let project = Project::new();
    // A fit in which some triangles find no partner, so that the file has every kind of entry.
    let pipeline = |correspondence: &str| {
        format!(
            "source: {{ generator: {{ type: quadruped, resolution: 24, frames: 2 }} }}\n\
             target: {{ generator: {{ type: quadruped, proportions: giraffe, resolution: 24, gait: none }} }}\n\
             correspondence: {correspondence}\ntransfer: {{ type: gradient }}\noutput: [out/{{pose}}.obj, out/all.glb]\n"
        )
    };
    project.write("p.yaml", &pipeline("{ type: nonrigid_fit, max_distance: 0.0005 }"));
    let output =
        project.mimesh(&["run", "p.yaml", "--quiet", "--set", "keep_correspondence=pairs.json", "--out", "first"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let file = json(&project.read("first/pairs.json"));
    for list in ["partners", "points"] {
        let nothing = file[list].as_array().unwrap().iter().filter(|entry| entry.is_null()).count();
        assert!(nothing > 0 && nothing < file[list].as_array().unwrap().len(), "{list}: {nothing} null");
    }
    project.write("p.yaml", &pipeline("{ type: from_file, path: first/pairs.json }"));
    let output = project.mimesh(&["run", "p.yaml", "--quiet", "--out", "second"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    for name in ["01.obj", "02.obj", "all.glb"] {
        let bytes = |folder: &str| project.bytes(&format!("{folder}/{name}"));
        assert!(bytes("first") == bytes("second"), "{name} differs");
    }
}

#[test]
fn a_pipeline_in_another_folder_finds_its_files_and_out_replaces_its_folder() {
    let project = Project::new();
    project.write(
        "sub/p.yaml",
        &project
            .read("p.yaml")
            .replace("rest.obj", "../rest.obj")
            .replace("pose-*", "../pose-*")
            .replace("target.obj", "../target.obj"),
    );
    let output = project.mimesh(&["run", "sub/p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(project.has("sub/out/10.obj"));
    assert_eq!(project.mimesh(&["run", "sub/p.yaml", "--out", "elsewhere"]).status, 0);
    assert_eq!(project.names("elsewhere"), ["1.obj", "10.obj", "2.obj", "run.json"]);
}

#[test]
fn paths_are_shown_without_detours() {
    let project = Project::new();
    project.write(
        "sub/p.yaml",
        "source: { rest: ../rest.obj, poses: ../pose-*.obj }\ntarget: { rest: ./../target.obj }\n\
         correspondence: { type: identity }\ntransfer: { type: copy_displacement }\noutput: ../out/{pose}.obj\n",
    );
    let output = project.mimesh(&["run", "sub/p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(
        output.stdout.contains("\n  out/10.obj ") && output.stdout.contains("\n  out/run.json\n"),
        "{}",
        output.stdout
    );
    let report = json(&project.read("out/run.json"));
    let read: Vec<_> =
        report["inputs"].as_array().unwrap().iter().map(|input| input["path"].as_str().unwrap()).collect();
    assert_eq!(read, ["sub/p.yaml", "rest.obj", "pose-1.obj", "pose-2.obj", "pose-10.obj", "target.obj"]);
}

#[test]
fn morph_targets_of_a_file_are_its_poses() {
    let project = Project::new();
    assert_eq!(project.mimesh(&["run", "p.yaml", "--set", "output=all.glb"]).status, 0);
    project.edit("{ rest: rest.obj, poses: pose-*.obj }", "{ rest: all.glb }");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
}

#[test]
fn a_truth_that_does_not_fit_is_a_warning_and_the_result_is_written_and_not_called_good() {
    let project = Project::new();
    project.write("truth-1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    project.edit("pose-*.obj", "pose-?.obj");
    project.write("truth-2.obj", &leaning(0.2));
    project.edit("output:", "truth: truth-{pose}.obj\noutput:");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(output.stderr.contains("warning: pose 1: not scored: "), "{}", output.stderr);
    let doubt = "1, doubtful: the pose is not scored, since its known result cannot be read";
    assert!(output.stdout.contains(doubt), "{}", output.stdout);
    assert_eq!(project.names("out"), ["1.obj", "2.obj", "run.json"]);
}
