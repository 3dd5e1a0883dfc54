//! Commands beside `run` as a script sees them: check, list, show, schema, score, inspect, and wrong usage.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, cube, json};
use mimesh::core::plugin;

#[test]
fn check_prints_an_overview_and_computes_nothing() {
    let project = Project::new();
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!((output.status, output.stderr.as_str()), (0, ""));
    assert_eq!(
        output.stdout,
        "ok: source of 8 vertices, 3 poses; target of 8 vertices; 0 markers; identity then copy_displacement; 3 files to write\n\
         not read: the shapes in 3 files of poses; `--poses` reads them\n"
    );
    assert!(!project.has("out"));
    assert_eq!(json(&project.mimesh(&["check", "p.yaml", "--json"]).stdout)["ok"], true);
}

#[test]
fn check_as_json_has_locations_and_hints() {
    let project = Project::new();
    project.edit("copy_displacement", "copy_displacment");
    let output = project.mimesh(&["check", "p.yaml", "--json"]);
    assert_eq!(output.status, 78);
    let mistake = &json(&output.stdout)["mistakes"][0];
    assert_eq!((&mistake["file"], &mistake["line"], &mistake["column"]), (&"p.yaml".into(), &4.into(), &19.into()));
    assert_eq!(mistake["hint"], "did you mean `copy_displacement`?");
}

#[test]
fn check_reads_poses_when_asked() {
    let project = Project::new();
    project.write("pose-2.obj", &cube(|p| p).replace("f 1 3 4 2\n", ""));
    let seen = project.mimesh(&["check", "p.yaml"]);
    assert!(seen.status == 0 && seen.stdout.contains("not read: the shapes in 3 files"), "{}", seen.stderr);
    assert_eq!(project.mimesh(&["check", "p.yaml", "--poses"]).status, 65);
    // The number of vertices is seen without reading.
    project.write("pose-2.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(project.mimesh(&["check", "p.yaml"]).status, 65);
}

#[test]
fn list_and_show_cover_every_registered_plugin() {
    let project = Project::new();
    let list = project.mimesh(&["list"]).stdout;
    let listed = json(&project.mimesh(&["list", "--json"]).stdout);
    assert_eq!(listed.as_array().unwrap().len(), plugin::all().len());
    for plugin in plugin::all() {
        let name = plugin.name();
        assert!(list.contains(&format!("\n  {name} ")), "{name} is not listed");
        let shown = project.mimesh(&["show", plugin.stage, name]);
        assert_eq!(shown.status, 0);
        assert!(shown.stdout.contains("In YAML"), "{}", shown.stdout);
        let described = json(&project.mimesh(&["show", plugin.stage, name, "--json"]).stdout);
        assert!(!described["description"].as_str().unwrap().is_empty(), "{name} has no description");
        for (setting, schema) in described["schema"]["properties"].as_object().into_iter().flatten() {
            assert!(schema.get("description").is_some(), "{name}.{setting} is not documented");
        }
    }
}

#[test]
fn unknown_stages_and_types_are_reported_with_the_nearest_known() {
    let project = Project::new();
    let stage = project.mimesh(&["show", "tranfer", "gradient"]);
    assert_eq!(
        (stage.status, stage.stderr.as_str()),
        (2, "error: unknown stage `tranfer`\n  hint: did you mean `transfer`?\n")
    );
    let name = project.mimesh(&["show", "transfer", "gradent"]);
    assert_eq!(
        (name.status, name.stderr.as_str()),
        (2, "error: unknown transfer `gradent`\n  hint: did you mean `gradient`?\n")
    );
}

#[test]
fn the_schema_has_every_stage_with_its_types() {
    let project = Project::new();
    let text = project.mimesh(&["schema"]).stdout;
    let schema = json(&text);
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["additionalProperties"], false);
    for plugin in plugin::all() {
        assert!(text.contains(&format!("\"const\": \"{}\"", plugin.name())), "{} is missing", plugin.name());
    }
}

#[test]
fn score_compares_file_with_file_and_can_be_a_gate() {
    let project = Project::new();
    let equal = project.mimesh(&["score", "pose-*.obj", "pose-*.obj", "--rest", "rest.obj", "--at-most", "max=0"]);
    assert_eq!(equal.status, 0, "{}", equal.stderr);
    let arguments = ["score", "pose-1.obj", "rest.obj", "--rest", "rest.obj", "--json"];
    let scored = json(&project.mimesh(&arguments).stdout);
    // Half the corners move by 0.3 to one side, so after aligning centroids each is 0.15 off; the diagonal is √14.
    let expected = 100.0 * 0.15 / 14f64.sqrt();
    assert!((scored["over_poses"]["average"]["rms"].as_f64().unwrap() - expected).abs() < 1e-6);
    let gate = project.mimesh(&["score", "pose-1.obj", "rest.obj", "--at-most", "rms=0.1"]);
    assert_eq!(gate.status, 3);
    for limit in ["rms=nan", "rms=inf", "rms=much"] {
        let output = project.mimesh(&["score", "pose-1.obj", "rest.obj", "--at-most", limit]);
        assert_eq!(output.status, 2, "{limit}: {}", output.stderr);
    }
    let unequal = project.mimesh(&["score", "pose-*.obj", "rest.obj"]);
    assert_eq!((unequal.status, unequal.stderr.lines().next()), (2, Some("error: 3 results, but 1 known result")));
}

#[test]
fn inspect_shows_counts_and_defects() {
    let project = Project::new();
    let output = project.mimesh(&["inspect", "rest.obj"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(output.stdout.contains("polygons        6: 6 quads; 12 triangles when cut"), "{}", output.stdout);
    assert!(output.stdout.contains("boundary edges  none: the surface is closed"), "{}", output.stdout);
    let described = json(&project.mimesh(&["inspect", "rest.obj", "--json"]).stdout);
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
    let output = project.mimesh(&["inspect", "two.obj", "--components"]);
    assert!(output.stdout.contains("  0         8  left: 1* 0.5000\n"), "{}", output.stdout);
    assert!(output.stdout.contains("  1         8  right: 0* 0.5000\n"), "{}", output.stdout);
    let drawn = project.mimesh(&["inspect", "two.obj", "--graphviz"]).stdout;
    assert!(
        drawn.starts_with("graph components {\n") && drawn.contains("0 -- 1 [ label=\"0.5000\" style=solid ]\n"),
        "{drawn}"
    );
    let described = json(&project.mimesh(&["inspect", "two.obj", "--components", "--json"]).stdout);
    assert_eq!(described["proximity"]["links"][0]["components"], serde_json::json!([0, 1]));
    assert_eq!(project.mimesh(&["inspect", "two.obj", "--graphviz", "--json"]).status, 2);
}

#[test]
fn wrong_usage_ends_with_2_and_help_with_0() {
    let project = Project::new();
    assert_eq!(project.mimesh(&["run"]).status, 2);
    assert_eq!(project.mimesh(&["run", "p.yaml", "--threads", "0"]).status, 2);
    assert_eq!(project.mimesh(&["frobnicate"]).status, 2);
    assert_eq!(project.mimesh(&["--help"]).status, 0);
    let version = project.mimesh(&["--version"]);
    assert_eq!(version.stdout, format!("mimesh {}\n", env!("CARGO_PKG_VERSION")));
    assert!(project.mimesh(&["completions", "bash"]).stdout.contains("_mimesh"));
}

#[test]
fn stages_in_python_need_the_package_for_python() {
    let project = Project::new();
    for arguments in [&["list", "--python", "stages.py"][..], &["--python", "stages.py", "run", "p.yaml"]] {
        let output = project.mimesh(arguments);
        assert_eq!(output.status, 2);
        let told = "error: --python stages.py: this program has no Python";
        assert!(output.stderr.contains(told), "{}", output.stderr);
        assert!(output.stderr.contains("`pip install mimesh`"), "{}", output.stderr);
    }
    assert!(!project.has("out"));
}
