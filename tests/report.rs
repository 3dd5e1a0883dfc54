//! Looking at results: the page of a run in a browser, gates, comparisons, pictures, and quality where the truth is known.
#![cfg(feature = "bundled")]

mod common;

use std::{fs, path::Path};

use common::{Project, animals::gallop, json};

/// Width and height of a PNG.
fn png_size(path: &Path) -> [u32; 2] {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n", "{}", path.display());
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn a_broken_gate_names_its_pose_and_ends_with_3_and_results_are_written() {
    let project = Project::new();
    gallop(&project, "gates: { point_error_p95: 0.001 }");
    let output = project.mimesh(&["run", "g.yaml"]);
    assert_eq!(output.status, 3, "{}", output.stderr);
    assert!(output.stdout.contains("verdict: broken gate"), "{}", output.stdout);
    assert!(output.stdout.contains(", broken gate: point error p95"), "{}", output.stdout);
    let report = json(&project.read("out/run.json"));
    assert_eq!(report["verdict"], "broken_gate");
    assert_eq!(report["gates"]["point_error_p95"], 0.001);
    let reason = &report["poses"][0]["verdict"]["reasons"][0];
    assert_eq!((reason["figure"].as_str(), reason["limit"].as_f64()), (Some("p95"), Some(0.001)));
    assert!(project.has("out/camel.glb") && project.has("out/report.html"));

    // The same with room to spare.
    let loose = project.mimesh(&["run", "g.yaml", "--set", "gates.point_error_p95=50", "--json"]);
    assert_eq!(loose.status, 0, "{}", loose.stderr);
    assert_ne!(json(&loose.stdout)["verdict"], "broken_gate");
}

#[test]
fn a_gate_whose_figure_cannot_be_measured_is_broken_and_reported_even_if_quiet() {
    let project = Project::new();
    project.write("truth-1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    project.write("truth-2.obj", &common::leaning(0.2));
    project.edit("pose-*.obj", "pose-?.obj");
    project.edit("output:", "truth: truth-{pose}.obj\ngates: { point_error: 1000 }\noutput:");
    let output = project.mimesh(&["run", "p.yaml", "--quiet"]);
    assert_eq!(output.status, 3, "{}", output.stderr);
    assert!(output.stderr.contains("1, broken gate: point error mean could not be measured"), "{}", output.stderr);
    assert!(!output.stderr.contains("2, broken gate"), "the other pose is measured: {}", output.stderr);

    // One component has no gaps in any pose.
    project.edit("point_error: 1000", "component_gaps: 1");
    project.edit("truth: truth-{pose}.obj\n", "");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 3, "{}", output.stderr);
    assert!(output.stderr.contains("the gate `component_gaps` is broken"), "{}", output.stderr);
}

#[test]
fn settings_of_metrics_are_checked_on_the_meshes_before_anything_runs() {
    let project = Project::new();
    let rims = "{ name: lips, upper: [0], lower: [99], source_upper: [0], source_lower: [1] }";
    project.edit("output:", &format!("metrics: [{{ type: closure, pairs: [{rims}] }}]\noutput:"));
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 65, "{}", output.stderr);
    assert!(
        output.stderr.contains("p.yaml:5:11: metric (closure): ") && output.stderr.contains("99"),
        "{}",
        output.stderr
    );
}

#[test]
fn the_page_needs_no_other_file_and_has_every_pose() {
    let project = Project::new();
    gallop(&project, "");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q"]).status, 0);
    let page = project.read("out/report.html");
    for outside in ["http://", "https://", "<script", "url(", "@import"] {
        // Names of namespaces would be no request, but there are none either.
        assert!(!page.contains(outside), "{outside} in the page");
    }
    let report = json(&project.read("out/run.json"));
    let poses = report["poses"].as_array().unwrap();
    for pose in poses {
        assert!(page.contains(&format!("<th class=\"name\">{}</th>", pose["name"].as_str().unwrap())), "{pose}");
    }
    // Source and target from two sides, the small pictures, and three large ones of each pose that is not good, or of the largest errors.
    let not_good = poses.iter().filter(|pose| pose["verdict"]["level"] != "good").count();
    let large = if not_good > 0 { not_good } else { poses.len() };
    assert_eq!(page.matches("<img ").count(), 4 + poses.len() + 3 * large.min(6));
    assert_eq!(page.matches("alt=\"").count(), page.matches("<img ").count(), "every picture has a text");
    let [width, height] = png_size(&project.path("out/sheet.png"));
    assert!(width > 1000 && height > 300, "{width} x {height}");
    // The page and the sheet are results as any other: the same again.
    let before = (page, project.bytes("out/sheet.png"));
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--threads", "1", "--no-cache"]).status, 0);
    let part = |page: &str| {
        page[page.find("<h2>Look").or(page.find("<h2>Largest")).unwrap()..page.find("<h2>Stages").unwrap()].to_owned()
    };
    assert!(part(&before.0) == part(&project.read("out/report.html")), "another page on one thread");
    assert!(before.1 == project.bytes("out/sheet.png"), "another sheet on one thread");
}

#[test]
fn a_page_without_truth_is_judged_by_the_other_metrics() {
    let project = Project::new();
    project.edit("output: out/{pose}.obj", "output: [\"out/{pose}.obj\", out/report.html]");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let page = project.read("out/report.html");
    assert!(page.contains("edge stretch") && !page.contains("point error"), "no truth, no error");
    assert!(page.contains("Verdict of each pose"));
}

#[test]
fn runs_are_compared_in_a_table_as_json_and_on_a_page() {
    let project = Project::new();
    gallop(&project, "");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--out", "good"]).status, 0);
    let simple = "transfer.type=copy_displacement";
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--out", "simple", "--set", simple]).status, 0);
    let output = project.mimesh(&["compare", "good", "simple/run.json", "--out", "cmp.html"]);
    assert_eq!((output.status, output.stderr.as_str()), (0, ""));
    let line = output.stdout.lines().find(|line| line.contains("point_error mean")).unwrap();
    assert!(line.contains('*') && line.find('*') < line.rfind(' '), "the better one is marked: {line}");
    let page = project.read("cmp.html");
    assert_eq!(page.matches("<img ").count(), 2 * 4, "a picture of each pose of each run");
    assert!(page.contains("transfer.<wbr>type") && page.contains("copy_<wbr>displacement"), "settings that differ");
    let all = json(&project.mimesh(&["compare", "good", "simple", "--json"]).stdout);
    let mean = |k: usize| all["runs"][k]["metrics"]["point_error"]["average"]["mean"].as_f64().unwrap();
    assert!(mean(0) < mean(1), "{} and {}", mean(0), mean(1));

    let own = project.mimesh(&["compare", "good", "simple", "--out", "good/report.html"]);
    assert_eq!(own.status, 73, "{}", own.stderr);
    assert!(project.read("good/report.html").contains("Verdict of each pose"), "the report of a run was replaced");

    let one = project.mimesh(&["compare", "good"]);
    assert_eq!(one.status, 2);
    assert!(one.stderr.contains("expected at least two"), "{}", one.stderr);
    let none = project.mimesh(&["compare", "good", "bad"]);
    assert_eq!(none.status, 66);
    project.write("other/run.json", "{ \"a\": 1 }");
    let other = project.mimesh(&["compare", "good", "other"]);
    assert_eq!(other.status, 65);
    assert!(other.stderr.contains("not the report of a run"), "{}", other.stderr);
}

#[test]
fn results_of_several_folders_are_found_beside_their_report_and_where_they_are() {
    let project = Project::new();
    gallop(&project, "");
    for folder in ["a", "b"] {
        let output = format!("output=[pages/{folder}/report.html, meshes/{folder}/camel.glb]");
        assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--set", &output]).status, 0);
    }
    let compared = |first: &str| project.mimesh(&["compare", first, "pages/b", "--out", "c.html"]);
    let output = compared("pages/a");
    assert_eq!((output.status, output.stderr.as_str()), (0, ""), "all files are found");
    assert_eq!(project.read("c.html").matches("<img ").count(), 2 * 4);
    // The page moves with the report, the meshes stay.
    fs::rename(project.path("pages/a"), project.path("moved")).unwrap();
    let output = compared("moved");
    assert_eq!((output.status, output.stderr.as_str()), (0, ""), "all files are found");
    let own = project.mimesh(&["compare", "moved", "pages/b", "--out", "moved/report.html"]);
    assert_eq!(own.status, 73, "{}", own.stderr);
}

#[test]
fn a_chart_shows_the_gate_of_its_own_statistic() {
    let project = Project::new();
    gallop(&project, "gates: { point_error: 90, point_error_p95: 0.001 }");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q"]).status, 3);
    let page = project.read("out/report.html");
    // How far below the upper edge of the picture the limit is drawn.
    let limit = |statistic: &str| -> f64 {
        let chart = page.split(&format!("point error, {statistic}</text>")).nth(1).expect(statistic);
        let line = chart.split("class=\"limit\"").nth(1).expect("a limit");
        line.split("y1=\"").nth(1).and_then(|y| y.split('"').next()?.parse().ok()).expect("a number")
    };
    // 90 % is far above the curve, and 0.001 % at its foot.
    assert!(limit("p95") > limit("mean") + 50.0, "{} and {}", limit("p95"), limit("mean"));
}

#[test]
fn meshes_are_drawn_into_a_picture_of_the_size_asked_for() {
    let project = Project::new();
    let output = project.mimesh(&["render", "pose-*.obj", "--out", "p.png", "--size", "100", "--columns", "3"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let [width, height] = png_size(&project.path("p.png"));
    assert!((300..360).contains(&width) && (100..180).contains(&height), "{width} x {height}");
    project.write("m.cons", "2\n0, 1\n7, 6\n");
    let output =
        project.mimesh(&["render", "rest.obj", "--markers", "m.cons", "--out", "m.png", "--view", "top", "--up", "z"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let output = project.mimesh(&["render", "pose-1.obj", "--truth", "pose-2.obj", "--out", "e.png"]);
    assert_eq!(output.status, 0, "{}", output.stderr);

    project.write("small.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (arguments, status, expected) in [
        (&["render", "rest.obj", "--out", "x.jpg"][..], 2, "expected a .png file"),
        (&["render", "no.obj", "--out", "x.png"], 66, "no.obj: no such file"),
        (&["render", "pose-*.obj", "--truth", "rest.obj", "--out", "x.png"], 2, "3 meshes, but 1 known result"),
        (
            &["render", "rest.obj", "--markers", "m.cons", "--truth", "rest.obj", "--out", "x.png"],
            2,
            "cannot be used with",
        ),
        (&["render", "rest.obj", "--markers", "gone.cons", "--out", "x.png"], 66, "gone.cons"),
        (&["render", "rest.obj", "--truth", "small.obj", "--out", "x.png"], 65, "small.obj: "),
    ] {
        let output = project.mimesh(arguments);
        assert_eq!(output.status, status, "{}", output.stderr);
        assert!(output.stderr.contains(expected), "{}", output.stderr);
        assert!(!project.has("x.png") && !project.has("x.jpg"));
    }
}
