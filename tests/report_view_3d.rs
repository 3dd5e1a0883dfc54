//! The 3D view of reports: only where a pipeline asks for it, in one file, and never lost in silence.
#![cfg(feature = "bundled")]

mod common;

use std::path::Path;

use common::{Project, animals::gallop, diagnostics, json};
use mimesh::pipeline::{Options, Plan, Prepared, Progress, input::ViewScript, prepare_all, run};
use serde_json::Value;

struct Silent;

impl Progress for Silent {}

/// Stands for the script that npm builds.
const SCRIPT: &str = "document.title = '</script>';";

fn options(text: Option<&'static str>) -> Options {
    let view_script = ViewScript { text: text.map(Into::into), hint: "run `build-it`".into() };
    Options { view_script, ..Options::default() }
}

/// The report of the gallop with these lines added to its pipeline.
fn page(project: &Project, more: &str) -> String {
    gallop(project, more);
    let all: Vec<Prepared> = prepare_all(&project.path("g.yaml"), &options(Some(SCRIPT)), None).expect("a pipeline");
    run(&all[0], &Plan::new(&all[0], None), 0, None, &Silent).expect("a run");
    project.read("out/report.html")
}

/// All addresses that the page names in attributes.
fn addresses(page: &str) -> Vec<&str> {
    let attributes = [" src=\"", " href=\"", "url("].into_iter();
    attributes.flat_map(|name| page.split(name).skip(1)).map(|rest| rest.split(['"', ')']).next().unwrap()).collect()
}

/// The number of bytes that a text in base64 stands for.
fn bytes(text: &Value) -> usize {
    let text = text.as_str().expect("a text");
    text.len() / 4 * 3 - text.bytes().rev().take_while(|byte| *byte == b'=').count()
}

#[test]
fn a_page_has_no_script_unless_the_pipeline_asks_for_it() {
    let project = Project::new();
    for more in ["", "pictures: { view_3d: false }"] {
        let page = page(&project, more);
        assert!(!page.contains("<script") && !page.contains("view-3d"));
        assert!(page.contains("default-src 'none'") && !page.contains("script-src"));
    }
}

#[test]
fn a_page_with_a_3d_view_is_one_file_and_holds_the_worst_poses() {
    let project = Project::new();
    let page = page(&project, "pictures: { view_3d: true }");
    assert_eq!(page.matches("<script").count(), 2, "data and script");
    assert!(page.contains("<script>document.title = '<\\/script>';</script>"));
    assert_eq!(page.matches("script-src 'sha256-").count(), 1);
    for address in addresses(&page) {
        assert!(address.starts_with("data:"), "{}", &address[..address.len().min(80)]);
    }
    assert!(page.contains("alt=\"result of pose "), "the still pictures stay");

    let data = page.split("type=\"application/json\">").nth(1).unwrap().split("</script>").next().unwrap();
    let data = json(data);
    let report = json(&project.read("out/run.json"));
    for (side, name) in ["source", "target"].into_iter().enumerate() {
        let mesh = &data["meshes"][side];
        let triangles = report[name]["triangles"].as_u64().expect("a number of triangles");
        assert_eq!(bytes(&mesh["triangles"]) as u64, triangles * 6, "{name}");
        assert!(bytes(&mesh["rest"]["steps"]).is_multiple_of(6));
    }
    let poses = data["poses"].as_array().unwrap();
    assert_eq!(poses.len(), 4);
    for pose in poses {
        let found = report["poses"].as_array().unwrap().iter().find(|other| other["name"] == pose["name"]);
        assert_eq!(pose["level"], found.expect("a pose of the run")["verdict"]["level"]);
        let vertices = bytes(&data["meshes"][1]["rest"]["steps"]) / 6;
        assert_eq!(bytes(&pose["result"]["steps"]), vertices * 6);
        assert_eq!(bytes(&pose["field"]["steps"]), vertices * 2);
        assert_eq!((&pose["field"]["unit"], &pose["field"]["high"]), (&json("\"error, %\""), &json("5.0")));
    }
}

#[test]
fn a_program_without_the_script_says_so_at_the_key() {
    let project = Project::new();
    gallop(&project, "pictures: { up: y, view_3d: true }");
    let failure = prepare_all(&project.path("g.yaml"), &options(None), None).unwrap_err();
    let [diagnostic] = &failure.list[..] else { panic!("one diagnostic: {failure:?}") };
    assert_eq!(diagnostic.message, "this program cannot make 3D views: it was built without their script");
    assert_eq!(diagnostic.hint.as_deref(), Some("run `build-it`"));
    let place = diagnostic.location.as_ref().expect("a place").to_string();
    assert!(place.contains("g.yaml:6:20"), "{place}");
}

#[test]
fn the_program_has_the_script_or_names_the_command_that_builds_it() {
    let project = Project::new();
    project.edit("output: out/{pose}.obj", "output: [\"out/{pose}.obj\", out/report.html]");
    let found = diagnostics(&project, &["pictures.view_3d=true"]);
    let output = project.mimesh(&["run", "p.yaml", "--set", "pictures.view_3d=true"]);
    if mimesh_web::report_viewer().is_some() {
        assert!(found.is_empty(), "{found:?}");
        assert!(project.read("out/report.html").contains("id=\"view-3d\""));
    } else {
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(output.status, 78);
        assert!(output.stderr.contains("npm ci --prefix web && npm run build --prefix web"), "{}", output.stderr);
    }
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("web/dist/report/viewer.js").is_file();
    assert_eq!(built, mimesh_web::report_viewer().is_some(), "what was built is part of the program");
}

#[test]
fn a_view_without_a_page_to_stand_in_is_a_warning() {
    let project = Project::new();
    project.edit("output: out/{pose}.obj", "pictures: { view_3d: true }\noutput: out/{pose}.obj");
    let all = prepare_all(&project.path("p.yaml"), &options(Some(SCRIPT)), None).expect("a pipeline");
    let warnings = &all[0].warnings;
    assert!(warnings.iter().any(|warning| warning.contains("no .html is among the outputs")), "{warnings:?}");
}
