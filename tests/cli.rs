//! The commands as a script sees them: exit status, stdout, stderr and files.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, cube, leaning};
use mimesh::core::plugin;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn a_run_writes_every_pose_and_a_report_and_ends_with_0() {
    let project = Project::new();
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
    assert!(said.out.contains("partners found for 12 of 12 target triangles (100.0 %)"), "{}", said.out);
    assert!(said.out.lines().last().is_some_and(|line| line.starts_with("done in ")), "{}", said.out);
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
    let said = project.mimesh(&["run", "p.yaml", "--set", "target.rest=rest.obj", "--threads", "1"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let report = json(&project.read("out/run.json"));
    assert_eq!(report["mimesh"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["set"], serde_json::json!(["target.rest=rest.obj"]));
    assert_eq!(report["threads"], 1);
    assert_eq!(report["settings"]["target"]["rest"], "rest.obj");
    assert_eq!(report["settings"]["transfer"]["type"], "copy_displacement");
    let rest = report["inputs"].as_array().unwrap().iter().find(|input| input["role"] == "source rest").unwrap();
    let bytes = std::fs::read(project.path("rest.obj")).unwrap();
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
    let said = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(json(&said.out), json(&project.read("out/run.json")));
}

#[test]
fn without_a_terminal_progress_is_plain_lines_and_quiet_is_silent() {
    let project = Project::new();
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.err, "correspondence (identity)\ntransfer (copy_displacement)\nposes (0 of 3)\nwriting\n");
    let quiet = project.mimesh(&["run", "p.yaml", "--quiet"]);
    assert_eq!((quiet.err.as_str(), quiet.out.as_str()), ("", ""));
}

#[test]
fn results_are_the_same_on_any_number_of_threads() {
    let project = Project::new();
    project.edit("output: out/{pose}.obj", "output: [out/{pose}.obj, out/all.glb]");
    for threads in ["1", "2"] {
        let said = project.mimesh(&["run", "p.yaml", "--threads", threads, "--out", &format!("out{threads}")]);
        assert_eq!(said.status, 0, "{}", said.err);
    }
    for name in ["1.obj", "2.obj", "10.obj", "all.glb"] {
        let bytes = |threads: u8| std::fs::read(project.path(&format!("out{threads}/{name}"))).unwrap();
        assert!(bytes(1) == bytes(2), "{name} differs");
    }
}

#[test]
fn set_values_are_checked_like_those_of_the_file() {
    let project = Project::new();
    let said = project.mimesh(&["run", "p.yaml", "--set", "transfer.type=gradiant", "--set", "source.pose=1"]);
    assert_eq!(said.status, 78);
    assert_eq!(
        said.err,
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
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 78);
    assert_eq!(
        said.err,
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
    let said = project.mimesh(&["run", "p.yaml"]);
    assert!(said.err.contains("out/pose-1.obj would overwrite an input (pose)"), "{}", said.err);
}

#[test]
fn a_bad_pose_leaves_the_others_and_ends_with_4() {
    let project = Project::new();
    project.write("pose-2.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 4);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "run.json"]);
    assert!(said.out.contains("failed: 2 (1 of 3)"), "{}", said.out);
    assert!(said.err.contains("error: pose-2.obj: "), "{}", said.err);
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
    let said = project.mimesh(&["run", "p.yaml", "--set", "output=['out/{pose}.obj', out/all.glb]"]);
    assert_eq!(said.status, 73, "{}", said.err);
    assert_eq!(project.read("out/1.obj"), before);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "all.glb", "run.json"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_ends_with_130_and_leaves_no_partial_file() {
    use std::process::{Command, Stdio};

    let project = Project::new();
    // Many poses, so that the run is under way for a while when the first results appear aside.
    project.write(
        "p.yaml",
        "source: { generator: { type: quadruped, resolution: 40, frames: 600 } }\n\
         target: { generator: { type: quadruped, resolution: 40, gait: none } }\n\
         correspondence: { type: identity }\ntransfer: { type: gradient }\noutput: out/{pose}.obj\n",
    );
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("mimesh"))
        .args(["run", "p.yaml", "--quiet"])
        .current_dir(project.path("."))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let started = std::time::Instant::now();
    while project.names("out").is_empty() && started.elapsed().as_secs() < 60 {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let status = child.wait().unwrap();
    assert!(killed.success());
    assert_eq!(status.code(), Some(130));
    assert_eq!(project.names("out"), [""; 0]);
}

#[test]
fn kept_correspondences_are_read_back() {
    let project = Project::new();
    project.edit("output:", "keep_correspondence: kept/pairs.json\noutput:");
    assert_eq!(project.mimesh(&["run", "p.yaml"]).status, 0);
    let kept = json(&project.read("kept/pairs.json"));
    assert_eq!((&kept["format"], &kept["version"]), (&"mimesh-correspondence".into(), &1.into()));
    assert_eq!(kept["source_triangles"], 12);
    let first = project.read("out/2.obj");
    project.edit("keep_correspondence: kept/pairs.json\n", "");
    project.edit("{ type: identity }", "{ type: from_file, path: kept/pairs.json }");
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(project.read("out/2.obj"), first);
}

#[test]
fn results_from_a_kept_correspondence_are_those_of_the_run_that_kept_it_to_the_last_bit() {
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
    let said =
        project.mimesh(&["run", "p.yaml", "--quiet", "--set", "keep_correspondence=kept.json", "--out", "first"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let kept = json(&project.read("first/kept.json"));
    for list in ["partners", "points"] {
        let nothing = kept[list].as_array().unwrap().iter().filter(|entry| entry.is_null()).count();
        assert!(nothing > 0 && nothing < kept[list].as_array().unwrap().len(), "{list}: {nothing} null");
    }
    project.write("p.yaml", &pipeline("{ type: from_file, path: first/kept.json }"));
    let said = project.mimesh(&["run", "p.yaml", "--quiet", "--out", "second"]);
    assert_eq!(said.status, 0, "{}", said.err);
    for name in ["01.obj", "02.obj", "all.glb"] {
        let bytes = |folder: &str| std::fs::read(project.path(&format!("{folder}/{name}"))).unwrap();
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
    let said = project.mimesh(&["run", "sub/p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
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
    let said = project.mimesh(&["run", "sub/p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(said.out.contains("\n  out/10.obj ") && said.out.contains("\n  out/run.json\n"), "{}", said.out);
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
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert_eq!(project.names("out"), ["1.obj", "10.obj", "2.obj", "run.json"]);
}

#[test]
fn check_says_ok_with_an_overview_and_computes_nothing() {
    let project = Project::new();
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!((said.status, said.err.as_str()), (0, ""));
    assert_eq!(
        said.out,
        "ok: source of 8 vertices, 3 poses; target of 8 vertices; 0 markers; identity then copy_displacement; 3 files to write\n"
    );
    assert!(!project.has("out"));
    assert_eq!(json(&project.mimesh(&["check", "p.yaml", "--json"]).out)["ok"], true);
}

#[test]
fn check_as_json_has_places_and_hints() {
    let project = Project::new();
    project.edit("copy_displacement", "copy_displacment");
    let said = project.mimesh(&["check", "p.yaml", "--json"]);
    assert_eq!(said.status, 78);
    let mistake = &json(&said.out)["mistakes"][0];
    assert_eq!((&mistake["file"], &mistake["line"], &mistake["column"]), (&"p.yaml".into(), &4.into(), &19.into()));
    assert_eq!(mistake["hint"], "did you mean `copy_displacement`?");
}

#[test]
fn check_reads_poses_when_asked() {
    let project = Project::new();
    project.write("pose-2.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(project.mimesh(&["check", "p.yaml"]).status, 0);
    assert_eq!(project.mimesh(&["check", "p.yaml", "--poses"]).status, 65);
}

#[test]
fn list_and_show_cover_every_registered_plugin() {
    let project = Project::new();
    let list = project.mimesh(&["list"]).out;
    let listed = json(&project.mimesh(&["list", "--json"]).out);
    assert_eq!(listed.as_array().unwrap().len(), plugin::all().len());
    for plugin in plugin::all() {
        let name = (plugin.name)();
        assert!(list.contains(name), "{name} is not listed");
        let shown = project.mimesh(&["show", plugin.stage, name]);
        assert_eq!(shown.status, 0);
        assert!(shown.out.contains("In YAML"), "{}", shown.out);
        let described = json(&project.mimesh(&["show", plugin.stage, name, "--json"]).out);
        assert!(!described["description"].as_str().unwrap().is_empty(), "{name} has no description");
        for (setting, schema) in described["schema"]["properties"].as_object().into_iter().flatten() {
            assert!(schema.get("description").is_some(), "{name}.{setting} is not documented");
        }
    }
}

#[test]
fn unknown_stages_and_types_are_told_with_the_nearest_known() {
    let project = Project::new();
    let stage = project.mimesh(&["show", "tranfer", "gradient"]);
    assert_eq!(
        (stage.status, stage.err.as_str()),
        (2, "error: unknown stage `tranfer`\n  hint: did you mean `transfer`?\n")
    );
    let name = project.mimesh(&["show", "transfer", "gradent"]);
    assert_eq!(
        (name.status, name.err.as_str()),
        (2, "error: unknown transfer `gradent`\n  hint: did you mean `gradient`?\n")
    );
}

#[test]
fn the_schema_has_every_stage_with_its_types() {
    let project = Project::new();
    let text = project.mimesh(&["schema"]).out;
    let schema = json(&text);
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["additionalProperties"], false);
    for plugin in plugin::all() {
        assert!(text.contains(&format!("\"const\": \"{}\"", (plugin.name)())), "{} is missing", (plugin.name)());
    }
}

#[test]
fn score_compares_file_with_file_and_can_be_a_gate() {
    let project = Project::new();
    let equal = project.mimesh(&["score", "pose-*.obj", "pose-*.obj", "--rest", "rest.obj", "--at-most", "max=0"]);
    assert_eq!(equal.status, 0, "{}", equal.err);
    let arguments = ["score", "pose-1.obj", "rest.obj", "--rest", "rest.obj", "--json"];
    let scored = json(&project.mimesh(&arguments).out);
    // Half the corners move by 0.3 to one side, so after aligning centroids each is 0.15 off; the diagonal is √14.
    let expected = 100.0 * 0.15 / 14f64.sqrt();
    assert!((scored["over_poses"]["average"]["rms"].as_f64().unwrap() - expected).abs() < 1e-6);
    let gate = project.mimesh(&["score", "pose-1.obj", "rest.obj", "--at-most", "rms=0.1"]);
    assert_eq!(gate.status, 3);
    let unequal = project.mimesh(&["score", "pose-*.obj", "rest.obj"]);
    assert_eq!((unequal.status, unequal.err.lines().next()), (2, Some("error: 3 results, but 1 known result")));
}

#[test]
fn inspect_tells_counts_and_defects() {
    let project = Project::new();
    let said = project.mimesh(&["inspect", "rest.obj"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(said.out.contains("polygons        6: 6 quads; 12 triangles when cut"), "{}", said.out);
    assert!(said.out.contains("boundary edges  none: the surface is closed"), "{}", said.out);
    let described = json(&project.mimesh(&["inspect", "rest.obj", "--json"]).out);
    assert_eq!(described["statistics"]["vertices"], 8);
    assert_eq!(described["statistics"]["volume"], 6.0);
    assert_eq!(project.mimesh(&["inspect", "none.obj"]).status, 66);
}

#[test]
fn inspect_lists_components_and_draws_their_graph() {
    let project = Project::new();
    let box_at = |x: f64, first: usize, name: &str| {
        let text = cube(|[a, b, c]| [a + x, b, c]);
        let shifted = text.lines().filter(|line| line.starts_with('f')).map(|line| {
            let corners = line.split_whitespace().skip(1).map(|c| c.parse::<usize>().unwrap() + first);
            format!("f {}\n", corners.map(|c| c.to_string()).collect::<Vec<_>>().join(" "))
        });
        let vertices: String =
            text.lines().filter(|line| line.starts_with('v')).map(|line| format!("{line}\n")).collect();
        vertices + &format!("o {name}\n") + &shifted.collect::<String>()
    };
    project.write("two.obj", &(box_at(0.0, 0, "left") + &box_at(1.5, 8, "right")));
    let said = project.mimesh(&["inspect", "two.obj", "--components"]);
    assert!(said.out.contains("  0         8  left: 1* 0.5000\n"), "{}", said.out);
    assert!(said.out.contains("  1         8  right: 0* 0.5000\n"), "{}", said.out);
    let drawn = project.mimesh(&["inspect", "two.obj", "--graphviz"]).out;
    assert!(
        drawn.starts_with("graph components {") && drawn.contains("0 -- 1 [label=\"0.5000\", style=solid];"),
        "{drawn}"
    );
    let described = json(&project.mimesh(&["inspect", "two.obj", "--components", "--json"]).out);
    assert_eq!(described["proximity"]["links"][0]["components"], serde_json::json!([0, 1]));
    assert_eq!(project.mimesh(&["inspect", "two.obj", "--graphviz", "--json"]).status, 2);
}

#[test]
fn every_pipeline_of_the_project_runs_as_it_stands() {
    let project = Project::new();
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    // Markers lie beside the pipelines that name them.
    let is_pipeline = |name: &str| name.ends_with(".yaml") && !name.ends_with(".markers.yaml");
    files.retain(|file| file.file_name().is_some_and(|name| is_pipeline(&name.to_string_lossy())));
    assert!(!files.is_empty());
    for (i, file) in files.iter().enumerate() {
        let out = format!("out-{i}");
        let said = project.mimesh(&["run", &file.to_string_lossy(), "--out", &out, "--quiet"]);
        assert_eq!(said.status, 0, "{}: {}", file.display(), said.err);
        // Of several runs each has a folder of its own.
        let names = project.names(&out);
        let reports = if names.contains(&"run.json".into()) { vec![String::new()] } else { names };
        for run in reports {
            let report = json(&project.read(&format!("{out}/{run}/run.json")));
            let mean = report["metrics"]["point_error"]["average"]["mean"].as_f64().unwrap();
            let nothing = report["metrics"]["point_error"]["nothing"]["mean"].as_f64().unwrap();
            // Any method that deserves its place leaves less than half of what doing nothing leaves.
            let told = format!("{} {run}: {mean} % of the diagonal, doing nothing {nothing} %", file.display());
            assert!(mean < 0.5 * nothing, "{told}");
        }
    }
}

#[test]
fn a_truth_that_does_not_fit_is_a_warning_and_the_result_is_written() {
    let project = Project::new();
    project.write("truth-1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    project.edit("pose-*.obj", "pose-?.obj");
    project.write("truth-2.obj", &leaning(0.2));
    project.edit("output:", "truth: truth-{pose}.obj\noutput:");
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(said.err.contains("warning: pose 1: not scored: "), "{}", said.err);
    assert_eq!(project.names("out"), ["1.obj", "2.obj", "run.json"]);
}

#[test]
fn wrong_usage_ends_with_2_and_help_with_0() {
    let project = Project::new();
    assert_eq!(project.mimesh(&["run"]).status, 2);
    assert_eq!(project.mimesh(&["run", "p.yaml", "--threads", "0"]).status, 2);
    assert_eq!(project.mimesh(&["frobnicate"]).status, 2);
    assert_eq!(project.mimesh(&["--help"]).status, 0);
    let version = project.mimesh(&["--version"]);
    assert_eq!(version.out, format!("mimesh {}\n", env!("CARGO_PKG_VERSION")));
    assert!(project.mimesh(&["completions", "bash"]).out.contains("_mimesh"));
}
