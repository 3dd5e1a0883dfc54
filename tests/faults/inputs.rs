//! Inputs are never overwritten, by whatever name and with whatever flags.

use std::{fs, os::unix::fs::symlink};

use crate::common::Project;

/// A project with `target.glb`, which is an input of `transfer`, and other names of it.
fn project() -> Project {
    let project = Project::new();
    let made = project.mimesh(&["run", "p.yaml", "--quiet", "--set", "output=[made/t.glb]"]);
    assert_eq!(made.status, 0, "{}", made.stderr);
    fs::rename(project.path("made/t.glb"), project.path("target.glb")).expect("a file");
    symlink("target.glb", project.path("link.glb")).expect("a link");
    symlink(".", project.path("here")).expect("a link");
    fs::hard_link(project.path("target.glb"), project.path("hard.glb")).expect("a second name");
    project.write("m.yaml", "markers:\n  - { name: a, source: 0, target: 0 }\n");
    project
}

const TRANSFER: [&str; 5] = ["transfer", "rest.obj", "target.glb", "--poses", "pose-*.obj"];

#[test]
fn outputs_replace_no_input_even_with_force() {
    let project = project();
    let before = [project.bytes("target.glb"), project.bytes("hard.glb"), project.bytes("pose-1.obj")];
    for output in [
        "target.glb",
        "./target.glb",
        "here/target.glb",
        "link.glb",
        "hard.glb",
        "here/here/target.glb",
        "pose-{pose}.obj",
    ] {
        let output = project.mimesh(&[&TRANSFER[..], &["-o", output, "--force"]].concat());
        assert_eq!(output.status, 78, "{}", output.stderr);
        let is_told = ["would overwrite an input", "is another name (hard link) of an input"];
        assert!(is_told.iter().any(|told| output.stderr.contains(told)), "{}", output.stderr);
    }
    assert_eq!([project.bytes("target.glb"), project.bytes("hard.glb"), project.bytes("pose-1.obj")], before);
}

#[test]
fn what_other_options_name_replaces_no_input_even_with_force() {
    let project = project();
    let before = [project.bytes("m.yaml"), project.bytes("p.yaml")];
    symlink("m.yaml", project.path("also.yaml")).expect("a link");
    let saves = ["m.yaml", "./m.yaml", "also.yaml"];
    let transfers =
        saves.map(|save| [&TRANSFER[..], &["--markers", "m.yaml", "-o", "x.html", "--save", save, "--force"]].concat());
    let key_points =
        ["keypoints", "p.yaml", "--set", "key_points={ type: greedy, max_count: 2 }", "--output", "p.yaml", "--force"];
    let convert = ["markers", "convert", "m.yaml", "p.yaml", "--pipeline", "p.yaml", "--force"];
    let propose = ["markers", "propose", "--pipeline", "p.yaml", "-o", "p.yaml", "--force"];
    for arguments in transfers.iter().map(Vec::as_slice).chain([&key_points[..], &convert, &propose]) {
        let output = project.mimesh(arguments);
        assert_eq!(output.status, 73, "{arguments:?}: {}", output.stderr);
        assert!(output.stderr.contains("reads"), "{arguments:?}: {}", output.stderr);
    }
    assert_eq!([project.bytes("m.yaml"), project.bytes("p.yaml")], before);
}

#[test]
fn two_links_to_a_file_that_is_yet_to_be_made_are_one_output() {
    let project = project();
    for link in ["a.glb", "b.glb"] {
        symlink("new.glb", project.path(link)).expect("a link");
    }
    for outputs in ["output=[a.glb, b.glb]", "output=[new.glb, a.glb]"] {
        for command in ["check", "run"] {
            let output = project.mimesh(&[command, "p.yaml", "--set", outputs]);
            assert_eq!(output.status, 78, "{}", output.stderr);
            assert!(output.stderr.contains("would be written twice"), "{}", output.stderr);
        }
    }
}
