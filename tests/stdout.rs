//! Every command that prints ends with status 73 where standard output cannot be written, and quietly where its reader has gone.
#![cfg(all(feature = "bundled", target_os = "linux"))]

mod common;

use std::{
    fs::OpenOptions,
    io::Read,
    process::{Command, Stdio},
};

use common::Project;

/// A command line for each command, that prints to stdout; `new plugin` makes a folder of that name.
const COMMANDS: [&[&str]; 27] = [
    &["transfer", "rest.obj", "target.obj", "--poses", "pose-1.obj", "-o", "out/t-{pose}.obj"],
    &["run", "p.yaml"],
    &["run", "p.yaml", "--json"],
    &["check", "p.yaml"],
    &["check", "p.yaml", "--json"],
    &["check", "none.yaml", "--json"],
    &["plan", "p.yaml"],
    &["prepare", "p.yaml"],
    &["merge", "p.yaml"],
    &["submit", "--to", "shell", "p.yaml", "--dir", "out/job"],
    &["keypoints", "p.yaml", "--set", "key_points={ type: greedy, max_count: 2 }", "--output", "out/k.yaml"],
    &["markers", "convert", "m.yaml", "out/c.yaml", "--pipeline", "p.yaml", "--force"],
    &["markers", "mirror", "m.yaml", "out/m.yaml", "--pipeline", "p.yaml", "--force"],
    &["markers", "propose", "--pipeline", "animals.yaml"],
    &[
        "markers",
        "reattach",
        "m.yaml",
        "out/r.yaml",
        "--pipeline",
        "p.yaml",
        "--old-source",
        "rest.obj",
        "--old-target",
        "target.obj",
    ],
    &["markers", "suggest", "--pipeline", "animals.yaml"],
    &["list"],
    &["show", "transfer", "gradient"],
    &["schema"],
    &["inspect", "rest.obj"],
    &["score", "pose-1.obj", "rest.obj", "--rest", "rest.obj"],
    &["compare", "a/run.json", "b/run.json"],
    &["render", "rest.obj", "--out", "out/r.png"],
    &["cache"],
    &["new", "pipeline", "rest.obj", "target.obj", "--poses", "pose-1.obj"],
    &["completions", "bash"],
    &["help"],
];

fn project() -> Project {
    let project = Project::new();
    project.edit("output:", "markers: m.yaml\noutput:");
    let pairs: String = (0..8).map(|v| format!("  - {{ name: m{v}, source: {v}, target: {v} }}\n")).collect();
    project.write("m.yaml", &format!("markers:\n{pairs}"));
    // The markers of shapes without limbs are nobody's guess.
    let animal = "generator: { type: quadruped, resolution: 20 }";
    project.write("animals.yaml", &format!("source: {{ {animal} }}\ntarget: {{ {animal} }}\noutput: out/a.glb\n"));
    for folder in ["a", "b"] {
        let output = project.mimesh(&["run", "p.yaml", "--out", folder]);
        assert_eq!(output.status, 0, "{}", output.stderr);
    }
    project
}

/// The status of a command, and what it told on stderr.
fn status(mut command: Command, stdout: Stdio) -> (i32, String) {
    let output = command.stdout(stdout).stderr(Stdio::piped()).output().expect("the command runs");
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn what_cannot_be_printed_is_told() {
    let project = project();
    for arguments in COMMANDS {
        let full = OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let (status, stderr) = status(project.command(arguments), full.into());
        assert_eq!(status, 73, "{arguments:?}: {stderr}");
        assert!(stderr.contains("standard output: cannot write: the disk is full"), "{arguments:?}: {stderr}");
    }
}

#[test]
fn a_descriptor_that_is_open_for_reading_only_prints_nothing_and_is_told() {
    let project = project();
    let others: [&[&str]; 2] = [&["--help"], &["--version"]];
    for arguments in COMMANDS.into_iter().chain(others) {
        let reading = OpenOptions::new().read(true).open("/dev/null").expect("/dev/null");
        let (status, stderr) = status(project.command(arguments), reading.into());
        assert_eq!(status, 73, "{arguments:?}: {stderr}");
        assert!(stderr.contains("standard output: it is not open for writing"), "{arguments:?}: {stderr}");
    }
    // Who prints nothing needs no stdout.
    let reading = OpenOptions::new().read(true).open("/dev/null").expect("/dev/null");
    assert_eq!(status(project.command(&["run", "p.yaml", "--quiet"]), reading.into()).0, 0);
}

#[test]
fn a_reader_that_has_gone_is_no_error() {
    let project = project();
    for arguments in COMMANDS {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let (status, stderr) = status(project.command(arguments), writer.into());
        // A pipeline that is not there is told as always.
        let expected = if arguments.contains(&"none.yaml") { 66 } else { 0 };
        assert_eq!(status, expected, "{arguments:?}: {stderr}");
        assert!(!stderr.contains("standard output") && !stderr.contains("panicked"), "{arguments:?}: {stderr}");
    }
}

#[test]
fn every_command_is_among_them() {
    let project = Project::new();
    let names = |help: &str| -> Vec<String> {
        let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
        let named = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
        named.map(|line| line.split_whitespace().next().unwrap_or_default().to_owned()).collect()
    };
    // The studio prints its address and goes on, and `new plugin` needs the sources of the program.
    let left_out = ["studio", "plugin"];
    for group in [&[][..], &["markers"], &["new"]] {
        let help = project.mimesh(&[group, &["--help"]].concat()).stdout;
        let names = names(&help);
        assert!(!names.is_empty(), "{help}");
        for name in names.iter().filter(|name| !left_out.contains(&name.as_str())) {
            let line = [group, &[name]].concat();
            let is_help = name == "help";
            assert!(is_help || COMMANDS.iter().any(|command| command.starts_with(&line)), "{line:?} is not tried");
        }
    }
}

#[test]
fn help_and_version_go_to_a_full_disk_too() {
    for argument in ["--help", "--version"] {
        let full = OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
        let (status, stderr) = status(Project::new().command(&[argument]), full.into());
        assert_eq!(status, 73, "{argument}: {stderr}");
    }
    let mut out = String::new();
    let mut child = Project::new().command(&["--version"]).stdout(Stdio::piped()).spawn().expect("the command runs");
    child.stdout.take().expect("a pipe").read_to_string(&mut out).expect("text");
    assert!(child.wait().expect("it ends").success() && out.starts_with("mimesh "), "{out}");
}
