//! Outputs that are no files, links to files, and a report that is another program's.

use std::{fs, os::unix::fs::symlink, process::Command};

use crate::sets::{project, run};

#[test]
fn what_is_no_file_is_not_written_to_and_links_lead_to_their_files() {
    let project = project();
    assert!(Command::new("mkfifo").arg(project.path("pipe.glb")).status().expect("mkfifo").success());
    symlink("/dev/null", project.path("null.glb")).expect("a link");
    for (name, kind) in [("pipe.glb", "a pipe"), ("null.glb", "a device")] {
        for command in ["check", "run"] {
            let output = project.mimesh(&[command, "p.yaml", "--set", &format!("output={name}")]);
            assert_eq!(output.status, 73, "{}", output.stderr);
            assert!(output.stderr.contains(&format!("there is {kind} of that name")), "{}", output.stderr);
        }
    }
    fs::create_dir(project.path("elsewhere")).expect("a folder");
    symlink("elsewhere/all.glb", project.path("link.glb")).expect("a link");
    let output = project.mimesh(&["run", "p.yaml", "--set", "output=link.glb", "--quiet"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(fs::symlink_metadata(project.path("link.glb")).expect("a link").is_symlink());
    assert!(project.bytes("elsewhere/all.glb").starts_with(b"glTF"));
}

#[test]
fn a_run_json_that_is_no_report_is_not_overwritten() {
    let project = project();
    for foreign in ["{\"scripts\": {}}", "", "not json"] {
        project.write("out/run.json", foreign);
        for command in ["check", "run"] {
            let output = project.mimesh(&[command, "p.yaml"]);
            assert_eq!(output.status, 73, "{}", output.stderr);
            assert!(output.stderr.contains("out/run.json: cannot write the report"), "{}", output.stderr);
        }
        assert_eq!(project.bytes("out/run.json"), foreign.as_bytes());
    }
    fs::remove_file(project.path("out/run.json")).expect("a file");
    run(&project);
    run(&project);
}
