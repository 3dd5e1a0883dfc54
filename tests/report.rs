//! Looking at results: the page of a run in a browser, gates, comparisons, pictures, and quality where the truth is known.
#![cfg(feature = "bundled")]

mod common;

use std::{fs, path::Path, process::Command};

use common::Project;
use serde_json::Value;

/// The samples' gallop, small, with a report.
fn gallop(project: &Project, more: &str) {
    project.write(
        "g.yaml",
        &format!(
            "source: {{ generator: {{ type: quadruped, proportions: horse, gait: gallop, resolution: 20, frames: 4 }} }}
target: {{ generator: {{ type: quadruped, proportions: camel, gait: gallop, resolution: 20, frames: 4, seed: 1 }} }}
correspondence: {{ type: nonrigid_fit }}
transfer: {{ type: gradient }}
output: [out/report.html, out/sheet.png, out/camel.glb]
{more}"
        ),
    );
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Width and height of a PNG.
fn png_size(path: &Path) -> [u32; 2] {
    let bytes = fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n", "{}", path.display());
    [16, 20].map(|at| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap()))
}

#[test]
fn a_broken_gate_is_told_with_its_pose_and_status_3_and_results_are_written() {
    let project = Project::new();
    gallop(&project, "gates: { point_error_p95: 0.001 }");
    let said = project.mimesh(&["run", "g.yaml"]);
    assert_eq!(said.status, 3, "{}", said.err);
    assert!(said.out.contains("verdict: broken gate"), "{}", said.out);
    assert!(said.out.contains(", broken gate: point error p95"), "{}", said.out);
    let report = json(&project.read("out/run.json"));
    assert_eq!(report["verdict"], "broken_gate");
    assert_eq!(report["gates"]["point_error_p95"], 0.001);
    let reason = &report["poses"][0]["verdict"]["reasons"][0];
    assert_eq!((reason["figure"].as_str(), reason["limit"].as_f64()), (Some("p95"), Some(0.001)));
    assert!(project.has("out/camel.glb") && project.has("out/report.html"));

    // The same with room to spare.
    let loose = project.mimesh(&["run", "g.yaml", "--set", "gates.point_error_p95=50", "--json"]);
    assert_eq!(loose.status, 0, "{}", loose.err);
    assert_ne!(json(&loose.out)["verdict"], "broken_gate");
}

#[test]
fn a_gate_whose_figure_cannot_be_measured_is_broken_and_told_even_if_quiet() {
    let project = Project::new();
    project.write("truth-1.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    project.write("truth-2.obj", &common::leaning(0.2));
    project.edit("pose-*.obj", "pose-?.obj");
    project.edit("output:", "truth: truth-{pose}.obj\ngates: { point_error: 1000 }\noutput:");
    let said = project.mimesh(&["run", "p.yaml", "--quiet"]);
    assert_eq!(said.status, 3, "{}", said.err);
    assert!(said.err.contains("1, broken gate: point error mean could not be measured"), "{}", said.err);
    assert!(!said.err.contains("2, broken gate"), "the other pose is measured: {}", said.err);

    // One component has no gaps in any pose.
    project.edit("point_error: 1000", "component_gaps: 1");
    project.edit("truth: truth-{pose}.obj\n", "");
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 3, "{}", said.err);
    assert!(said.err.contains("the gate `component_gaps` is broken"), "{}", said.err);
}

#[test]
fn settings_of_metrics_are_checked_on_the_meshes_before_anything_runs() {
    let project = Project::new();
    let rims = "{ name: lips, upper: [0], lower: [99], source_upper: [0], source_lower: [1] }";
    project.edit("output:", &format!("metrics: [{{ type: closure, pairs: [{rims}] }}]\noutput:"));
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(said.status, 65, "{}", said.err);
    assert!(said.err.contains("p.yaml:5:11: metric (closure): ") && said.err.contains("99"), "{}", said.err);
}

#[test]
fn the_page_stands_alone_and_tells_every_pose() {
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
    // Source and target from two sides, the small pictures, and the large ones of the worst.
    assert_eq!(page.matches("<img ").count(), 4 + poses.len() + poses.len().min(6));
    assert_eq!(page.matches("alt=\"").count(), page.matches("<img ").count(), "every picture is told in words");
    let [width, height] = png_size(&project.path("out/sheet.png"));
    assert!(width > 1000 && height > 300, "{width} x {height}");
    // The page and the sheet are results as any other: the same again.
    let before = (page, fs::read(project.path("out/sheet.png")).unwrap());
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--threads", "1", "--no-cache"]).status, 0);
    let part = |page: &str| {
        page[page.find("<h2>Look").or(page.find("<h2>Largest")).unwrap()..page.find("<h2>Stages").unwrap()].to_owned()
    };
    assert!(part(&before.0) == part(&project.read("out/report.html")), "another page on one thread");
    assert!(before.1 == fs::read(project.path("out/sheet.png")).unwrap(), "another sheet on one thread");
}

#[test]
fn a_page_without_truth_is_judged_by_the_other_metrics() {
    let project = Project::new();
    project.edit("output: out/{pose}.obj", "output: [\"out/{pose}.obj\", out/report.html]");
    let said = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let page = project.read("out/report.html");
    assert!(page.contains("edge stretch") && !page.contains("point error"), "no truth, no error");
    assert!(page.contains("Verdict of each pose"));
}

/// A browser without a display, or a visible skip; with CI=true its absence is a failure.
fn browser() -> Option<&'static str> {
    let found = ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success()));
    if found.is_none() {
        assert!(std::env::var("CI").as_deref() != Ok("true"), "no chromium is installed");
        eprintln!("skipped: no chromium is installed");
    }
    found
}

#[test]
fn a_browser_shows_the_page_without_a_complaint_on_a_phone_too() {
    let Some(browser) = browser() else { return };
    let project = Project::new();
    gallop(&project, "gates: { point_error_p95: 0.001 }");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q"]).status, 3);
    // Opens the page in a frame as wide as a phone, and tells what it finds.
    project.write(
        "out/phone.html",
        r#"<!DOCTYPE html><title>phone</title><link rel="icon" href="data:,">
<iframe id="page" src="report.html" width="390" height="800" style="border:0"></iframe><p id="told">waiting</p>
<script>
document.getElementById('page').onload = (event) => {
  const page = event.target.contentDocument;
  const broken = [...page.images].filter((image) => !image.complete || image.naturalWidth === 0).length;
  document.getElementById('told').textContent =
    `wide ${page.documentElement.scrollWidth} images ${page.images.length} broken ${broken} curves ${page.querySelectorAll('svg').length}`;
};
</script>"#,
    );
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=10000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("file://{}", project.path("out/phone.html").display()))
        .output()
        .unwrap();
    let (dom, log) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    let complaints: Vec<_> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(complaints.is_empty(), "{complaints:?}");
    let told = dom.split("id=\"told\">").nth(1).and_then(|rest| rest.split('<').next()).unwrap_or_default();
    let number = |word: &str| -> u32 {
        let rest = told.split(&format!("{word} ")).nth(1).unwrap_or_else(|| panic!("{told}\n{log}"));
        rest.split(' ').next().unwrap().parse().unwrap()
    };
    assert_eq!(number("broken"), 0, "{told}");
    assert!(number("images") >= 8 && number("curves") >= 2, "{told}");
    // 390 pixels less a bar at the side; wider would mean that a reader has to push the page about.
    assert!(number("wide") <= 390, "{told}");
}

#[test]
fn runs_are_compared_in_a_table_as_json_and_on_a_page() {
    let project = Project::new();
    gallop(&project, "");
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--out", "good"]).status, 0);
    let simple = "transfer.type=copy_displacement";
    assert_eq!(project.mimesh(&["run", "g.yaml", "-q", "--out", "simple", "--set", simple]).status, 0);
    let said = project.mimesh(&["compare", "good", "simple/run.json", "--out", "cmp.html"]);
    assert_eq!((said.status, said.err.as_str()), (0, ""));
    let line = said.out.lines().find(|line| line.contains("point_error mean")).unwrap();
    assert!(line.contains('*') && line.find('*') < line.rfind(' '), "the better one is marked: {line}");
    let page = project.read("cmp.html");
    assert_eq!(page.matches("<img ").count(), 2 * 4, "a picture of each pose of each run");
    assert!(page.contains("transfer.type") && page.contains("copy_displacement"), "settings that differ");
    let all = json(&project.mimesh(&["compare", "good", "simple", "--json"]).out);
    let mean = |k: usize| all["runs"][k]["metrics"]["point_error"]["average"]["mean"].as_f64().unwrap();
    assert!(mean(0) < mean(1), "{} and {}", mean(0), mean(1));

    let own = project.mimesh(&["compare", "good", "simple", "--out", "good/report.html"]);
    assert_eq!(own.status, 73, "{}", own.err);
    assert!(project.read("good/report.html").contains("Verdict of each pose"), "the report of a run was replaced");

    let one = project.mimesh(&["compare", "good"]);
    assert_eq!(one.status, 2);
    assert!(one.err.contains("expected two at least"), "{}", one.err);
    let none = project.mimesh(&["compare", "good", "bad"]);
    assert_eq!(none.status, 66);
    project.write("other/run.json", "{ \"a\": 1 }");
    let other = project.mimesh(&["compare", "good", "other"]);
    assert_eq!(other.status, 65);
    assert!(other.err.contains("not the report of a run"), "{}", other.err);
}

#[test]
fn meshes_are_drawn_into_a_picture_of_the_size_asked_for() {
    let project = Project::new();
    let said = project.mimesh(&["render", "pose-*.obj", "--out", "p.png", "--size", "100", "--columns", "3"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let [width, height] = png_size(&project.path("p.png"));
    assert!((300..360).contains(&width) && (100..180).contains(&height), "{width} x {height}");
    project.write("m.cons", "2\n0, 1\n7, 6\n");
    let said =
        project.mimesh(&["render", "rest.obj", "--markers", "m.cons", "--out", "m.png", "--view", "top", "--up", "z"]);
    assert_eq!(said.status, 0, "{}", said.err);
    let said = project.mimesh(&["render", "pose-1.obj", "--truth", "pose-2.obj", "--out", "e.png"]);
    assert_eq!(said.status, 0, "{}", said.err);

    for (arguments, status, told) in [
        (&["render", "rest.obj", "--out", "x.jpg"][..], 2, "expected a .png file"),
        (&["render", "no.obj", "--out", "x.png"], 66, "no.obj: no such file"),
        (&["render", "pose-*.obj", "--truth", "rest.obj", "--out", "x.png"], 2, "3 meshes, but 1 known result"),
        (
            &["render", "rest.obj", "--markers", "m.cons", "--truth", "rest.obj", "--out", "x.png"],
            2,
            "cannot be used with",
        ),
        (&["render", "rest.obj", "--markers", "gone.cons", "--out", "x.png"], 66, "gone.cons"),
    ] {
        let said = project.mimesh(arguments);
        assert_eq!(said.status, status, "{}", said.err);
        assert!(said.err.contains(told), "{}", said.err);
        assert!(!project.has("x.png") && !project.has("x.jpg"));
    }
}

#[test]
fn every_method_is_measured_on_a_folder_of_meshes() {
    let project = Project::new();
    for (from, to) in [("rest.obj", "rest"), ("pose-1.obj", "lean"), ("pose-2.obj", "lean-more")] {
        project.write(&format!("bodies/source/{to}.obj"), &project.read(from));
        let name = if to == "rest" { "rest".into() } else { format!("truth-{to}") };
        project.write(&format!("bodies/twin/{name}.obj"), &project.read(from));
    }
    project.write("bodies/twin/landmarks.json", r#"{ "source": [0, 1, 2, 4, 7], "target": [0, 1, 2, 4, 7] }"#);
    project.write("bodies/notes/readme.txt", "nothing to see");
    let arguments = ["bench-quality", "bodies", "--markers", "4,5", "--methods", "copy_displacement,gradient"];
    let said = project.mimesh(&[&arguments[..], &["--table", "t.csv", "--out", "bench"]].concat());
    assert_eq!(said.status, 0, "{}", said.err);
    assert!(said.err.contains("passed over: notes: no mesh called `rest`"), "{}", said.err);
    let table = project.read("t.csv");
    assert_eq!(table.lines().count(), 1 + 2 * 3, "doing nothing and two methods with 4 and with 5 markers: {table}");
    let mean = |row: &str| -> f64 {
        table.lines().find(|line| line.starts_with(row)).unwrap().split(',').nth(3).unwrap().parse().unwrap()
    };
    // The twin is the source itself, so that the fit has nothing to bend; doing nothing misses all of the pose.
    assert!(mean("twin-5,gradient") < 0.1 && mean("twin-5,doing nothing") > 1.0, "{table}");
    assert!(project.has("bench/twin-5-gradient.yaml") && project.has("bench/twin-5-gradient/report.html"));
    assert_eq!(project.mimesh(&["check", "bench/twin-4-gradient.yaml"]).status, 0, "the pipelines can be run again");

    let wrong = project.mimesh(&["bench-quality", "--methods", "gradiant"]);
    assert_eq!(wrong.status, 2);
    assert!(wrong.err.contains("did you mean `gradient`?"), "{}", wrong.err);
    let empty = project.mimesh(&["bench-quality", "bench"]);
    assert_eq!(empty.status, 66);
    assert!(empty.err.contains("no folder `source`"), "{}", empty.err);
}
