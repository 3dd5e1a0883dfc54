//! Pipelines, and what they name, of people who mean no good: no command hangs, none needs much memory, and each says what is wrong.
#![cfg(all(feature = "bundled", target_os = "linux"))]

mod common;

use std::{
    ffi::OsStr,
    fs,
    os::unix::{ffi::OsStrExt, fs::symlink},
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use common::{PIPELINE, Project, json, leaning};

/// A command that takes longer is taken for one that hangs.
const LONG: Duration = Duration::from_secs(20);

/// The status, stdout and stderr of a command that must end.
#[track_caller]
fn ended(mut command: Command) -> (i32, String, String) {
    let mut child =
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it runs");
    let started = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if started.elapsed() > LONG {
            child.kill().expect("a child");
            panic!("{command:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().expect("its output");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
}

/// What `check p.yaml` says with the text `pipeline`, and its status.
#[track_caller]
fn checked(project: &Project, pipeline: &str) -> (i32, String) {
    project.write("p.yaml", pipeline);
    let (status, _, stderr) = ended(project.command(&["check", "p.yaml", "--no-cache"]));
    (status, stderr)
}

#[track_caller]
fn assert_told(project: &Project, pipeline: &str, status: i32, expected: &str) {
    let (found, stderr) = checked(project, pipeline);
    assert_eq!(found, status, "{stderr}");
    assert!(stderr.contains(expected) && stderr.len() < 100_000, "{expected} is not in {stderr}");
}

#[test]
fn small_files_cannot_ask_for_endless_work() {
    let project = Project::new();
    let variables = |item: &dyn Fn(&str) -> String| {
        let lines: String = (1..10).map(|i| format!("  v{i}: {}\n", item(&format!("${{v{}}}", i - 1)))).collect();
        format!("variables:\n  v0: x\n{lines}")
    };
    let texts = variables(&|one| format!("'{}'", one.repeat(10)));
    let with = |text: &str, from: &str, to: &str| format!("{text}{}", PIPELINE.replace(from, to));
    let many = "variables make more than 250,000 values";
    assert_told(&project, &with(&texts, "out/{pose}", "out/${v9}/{pose}"), 78, many);
    let lists = variables(&|one| format!("[{}]", [one; 10].join(", ")));
    assert_told(&project, &with(&lists, "out/{pose}.obj", "${v9}"), 78, many);
    let row: String = (1..6000).map(|i| format!("  v{i}: ${{v{}}}\n", i - 1)).collect();
    let row = with(&format!("variables:\n  v0: x\n{row}"), "out/{pose}", "out/${v5999}/{pose}");
    assert_told(&project, &row, 78, "more than 64 variables use each other in a row");
    let long = "a".repeat(1 << 20);
    assert_told(&project, &with("", "rest.obj", &long), 78, "the text has 1,048,576 bytes, expected 4,096 at most");
    let deep = "o/".repeat(1 << 19);
    assert_told(&project, &with("", "out/{pose}", &format!("{deep}{{pose}}")), 78, "expected 4,096 at most");
    let keys: String = (0..60_000).map(|i| format!("k{i}: 1\n")).collect();
    assert_told(&project, &format!("{PIPELINE}{keys}"), 78, "unknown key `k0`");
    let undefined: String = (0..20_000).map(|i| format!("k{i}: '${{u{i}}}', ")).collect();
    assert_told(&project, &format!("{PIPELINE}gates: {{ {undefined} }}\n"), 78, "undefined variable `u0`");
    let numbers: String = (0..50_000).map(|i| format!("{i}, ")).collect();
    assert_told(&project, &with("", "pose-*.obj", &format!("[{numbers}]")), 78, "expected a string, found 0");
    let values = numbers.clone();
    assert_told(
        &project,
        &format!("{PIPELINE}matrix: {{ transfer.x: [{values}] }}\n"),
        78,
        "more than 10000 combinations",
    );
    let axes: String = (0..3000).map(|i| format!("a.b{i}: [1], ")).collect();
    assert_told(&project, &format!("{PIPELINE}matrix: {{ {axes} }}\n"), 78, "3000 keys, expected 64 at most");
    let dots = "a.".repeat(2000);
    assert_told(&project, &format!("{PIPELINE}matrix:\n  ? {dots}b\n  : [1]\n"), 78, "is no path of keys");
    let targets: String = (0..11_000).map(|i| format!("  t{i}: {{ rest: target.obj }}\n")).collect();
    let targets = PIPELINE.replace("target: { rest: target.obj }", &format!("targets:\n{targets}"));
    assert_told(&project, &targets, 78, "the file has 11,000 runs, expected 10,000 at most");
}

#[test]
fn patterns_that_are_repeated_are_taken_once_and_those_of_a_list_have_a_limit() {
    let project = Project::new();
    let poses = |list: &str| PIPELINE.replace("pose-*.obj", &format!("[{list}]"));
    let (status, stderr) = checked(&project, &poses(&"'pose-*.obj', ".repeat(20_000)));
    assert!(
        status == 0 && stderr.contains("`pose-*.obj` is named more than once and taken once (19,999 such)"),
        "{stderr}"
    );
    let (status, stderr) = checked(&project, &poses("pose-1.obj, ./pose-1.obj, pose-2.obj"));
    assert!(status == 0 && stderr.contains("`./pose-1.obj` is named more than once"), "{stderr}");
    (0..1_100).for_each(|i| project.write(&format!("many/{i}.obj"), ""));
    let many: String = (0..1_100).map(|i| format!("many/{i}?obj, ")).collect();
    assert_told(
        &project,
        &poses(&format!("pose-1.obj, {many}")),
        78,
        "and those before look at more than 1,000,000 files",
    );
    assert_told(
        &project,
        &format!("{PIPELINE}variables: &a [*a]\n"),
        78,
        "an alias stands within the value that it repeats",
    );
}

#[test]
fn names_from_files_do_not_steer_the_terminal() {
    let project = Project::new();
    fs::rename(project.path("pose-1.obj"), project.path("pose-a\nerror: \u{1b}[2J\u{9b}.obj")).expect("a new name");
    fs::write(project.path("p.yaml"), PIPELINE).expect("a pipeline");
    for command in [["check", "p.yaml"], ["run", "p.yaml"], ["inspect", "pose-a\nerror: \u{1b}[2J\u{9b}.obj"]] {
        let (_, stdout, stderr) = ended(project.command(&command));
        let steers = |c: char| c.is_control() && !"\n\t".contains(c);
        assert!(!stdout.contains(steers) && !stderr.contains(steers), "{stdout}{stderr}");
        assert!(!stderr.lines().any(|line| line.starts_with("error")), "{stderr}");
    }
}

#[test]
fn what_must_be_unicode_is_named_if_it_is_none() {
    let project = Project::new();
    let mut command = project.command(&["check", "p.yaml", "--set"]);
    command.arg(OsStr::from_bytes(b"markers=m\xff.yaml"));
    let (status, _, stderr) = ended(command);
    assert!(status == 2 && stderr.contains("`markers=m\u{fffd}.yaml`: expected Unicode"), "{stderr}");
    project.write("p.yaml", &format!("{PIPELINE}markers: '${{env:NAME}}.yaml'\n"));
    let mut command = project.command(&["check", "p.yaml"]);
    command.env("NAME", OsStr::from_bytes(b"\xff"));
    let (status, _, stderr) = ended(command);
    assert!(status == 78 && stderr.contains("the variable `NAME` of the environment is no Unicode"), "{stderr}");
}

#[test]
fn a_glob_over_a_whole_system_ends() {
    let project = Project::new();
    // Wherever the test runs, more than 100,000 files lie below `/proc`.
    (0..400).for_each(|i| fs::create_dir_all(project.path(&format!("many/{i}"))).expect("a folder"));
    let pattern = "many/*/../*/../*/*.obj";
    assert_told(&project, &PIPELINE.replace("pose-*.obj", pattern), 78, "looks at more than 100,000 files and folders");
    symlink(project.path(""), project.path("many/0/round")).expect("a link");
    let (status, stderr) = checked(&project, &PIPELINE.replace("pose-*.obj", "'**/pose-*.obj'"));
    assert_eq!(status, 0, "{stderr}");
}

#[test]
fn what_is_no_regular_file_is_neither_read_nor_waited_for() {
    let project = Project::new();
    let made = Command::new("mkfifo").arg(project.path("pipe")).status().expect("mkfifo");
    assert!(made.success());
    fs::create_dir(project.path("folder")).expect("a folder");
    symlink("none", project.path("broken")).expect("a link");
    symlink("round", project.path("round")).expect("a link");
    for (file, expected) in [
        ("pipe", "is a pipe, expected a file"),
        ("/dev/zero", "is a device, expected a file"),
        ("folder", "is a folder, expected a file"),
        ("broken", "which does not exist"),
        ("round", "cannot read"),
    ] {
        for pipeline in [
            format!("include: {file}\n{PIPELINE}"),
            format!("markers: {file}\n{PIPELINE}"),
            PIPELINE.replace("pose-*.obj", file),
            PIPELINE.replace("rest.obj", file),
            format!("{PIPELINE}truth: {file}.obj\n").replace("truth: /dev/zero.obj", "truth: zero.obj"),
        ] {
            for ending in ["pipe.obj", "folder.obj", "broken.obj", "round.obj", "zero.obj"] {
                let _ = fs::remove_file(project.path(ending));
                let aim = if ending == "zero.obj" {
                    "/dev/zero".into()
                } else {
                    project.path(ending.trim_end_matches(".obj"))
                };
                symlink(aim, project.path(ending)).expect("a link");
            }
            let (status, stderr) = checked(&project, &pipeline);
            assert!([65, 66].contains(&status), "{pipeline}{status}: {stderr}");
            assert!(stderr.contains(expected), "{pipeline}: {stderr}");
        }
        for arguments in
            [&["check", file][..], &["inspect", file], &["compare", file, file], &["render", file, "--out", "x.png"]]
        {
            let (status, _, stderr) = ended(project.command(arguments));
            assert!([2, 65, 66].contains(&status) && stderr.starts_with("error: "), "{arguments:?}: {status} {stderr}");
        }
    }
}

#[test]
fn of_files_elsewhere_no_line_is_shown() {
    let project = Project::new();
    project.write("secret/key", "top: secret: word\n");
    project.write("p/p.yaml", "include: ../secret/key\n");
    symlink(project.path("secret/key"), project.path("p/link.yaml")).expect("a link");
    project.write("p/q.yaml", "include: link.yaml\n");
    project.write("p/own.yaml", "top: secret: word\n");
    project.write("p/r.yaml", "include: own.yaml\n");
    for (pipeline, is_shown) in [("p/p.yaml", false), ("p/q.yaml", false), ("p/r.yaml", true)] {
        let (status, _, stderr) = ended(project.command(&["check", pipeline]));
        assert_eq!((status, stderr.contains("secret: word")), (78, is_shown), "{pipeline}: {stderr}");
    }
}

#[test]
fn names_that_are_no_unicode_are_names_like_others() {
    let project = Project::new();
    let folder = project.path("").join(OsStr::from_bytes(b"in\xff"));
    fs::create_dir_all(folder.join(OsStr::from_bytes(b"\xfe"))).expect("a folder");
    for name in ["rest.obj", "target.obj", "p.yaml", "pose-1.obj"] {
        fs::copy(project.path(name), folder.join(name)).expect("a copy");
    }
    fs::write(folder.join(OsStr::from_bytes(b"pose-\xff.obj")), leaning(0.5)).expect("a file");
    fs::write(folder.join(OsStr::from_bytes(b"\xff.yaml")), PIPELINE).expect("a file");
    let pairs: String = (0..4).map(|v| format!("  - {{ name: m{v}, source: {v}, target: {v} }}\n")).collect();
    fs::write(folder.join(OsStr::from_bytes(b"m\xff.yaml")), format!("markers:\n{pairs}")).expect("a file");
    for (json_is_printed, arguments) in [
        (true, &[&b"run"[..], b"in\xff/p.yaml", b"--json"][..]),
        (true, &[b"check", b"in\xff/\xff.yaml", b"--json"]),
        (true, &[b"check", b"in\xff/p.yaml", b"--json", b"--set", b"source.rest=none.obj"]),
        (true, &[b"plan", b"in\xff/p.yaml", b"--json"]),
        (true, &[b"inspect", b"in\xff/pose-\xff.obj", b"--json"]),
        (
            false,
            &[
                b"run",
                b"in\xff/\xff.yaml",
                b"--out",
                b"out\xff",
                b"--table",
                b"\xff.csv",
                b"--set",
                b"output=[out/{pose}.obj, out/r.html]",
            ],
        ),
        (false, &[b"run", b"in\xff/p.yaml", b"--profile=\xff.json"]),
        (true, &[b"compare", b"in*/out/run.json", b"out*/run.json", b"--json"]),
        (true, &[b"score", b"in*/out/1.obj", b"target.obj", b"--rest", b"target.obj", b"--json"]),
        (false, &[b"render", b"in*/pose-*.obj", b"--out", b"\xff.png"]),
        (
            true,
            &[
                b"markers",
                b"convert",
                b"in\xff/m\xff.yaml",
                b"out-\xff.yaml",
                b"--source",
                b"in\xff/rest.obj",
                b"--target",
                b"target.obj",
                b"--json",
            ],
        ),
        (true, &[b"cache", b"--cache", b"cache\xff", b"--json"]),
        (true, &[b"run", b"p.yaml", b"--cache", b"cache\xff", b"--json"]),
        (false, &[b"new", b"pipeline", b"in\xff/rest.obj", b"target.obj", b"--poses", b"pose-1.obj"]),
        (false, &[b"transfer", b"in\xff/rest.obj", b"target.obj", b"--poses", b"pose-1.obj"]),
    ] {
        let mut command = project.command(&[]);
        command.args(arguments.iter().map(|argument| OsStr::from_bytes(argument)));
        let (status, stdout, stderr) = ended(command);
        // What the document of a command names must be text, and is told if it is none.
        let told = arguments[0] == b"new" || arguments[0] == b"transfer" || stdout.contains("none.obj");
        assert!(status == 0 || (told && [2, 66].contains(&status)), "{arguments:?}: {status} {stderr}");
        if [&b"new"[..], b"transfer"].contains(&arguments[0]) {
            assert!(stderr.contains("no Unicode"), "{stderr}");
        }
        if json_is_printed {
            json(&stdout);
        }
    }
    let report = json(&fs::read_to_string(folder.join("out/run.json")).expect("a report"));
    assert_eq!(report["poses"][1]["name"], "\u{fffd}", "{}", report["poses"]);
    assert!(folder.join("out/\u{fffd}.obj").is_file());
}

#[test]
fn encodings_are_told_by_name() {
    let project = Project::new();
    let utf16: Vec<u8> = "\u{feff}a: 1\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (bytes, expected) in [
        (utf16, "the text is UTF-16 (little-endian, with a byte order mark), expected UTF-8"),
        (b"# gr\xfc\xdfe\n".to_vec(), "not UTF-8 text: byte 0xfc at offset 4 (line 1)"),
    ] {
        fs::write(project.path("bad"), &bytes).expect("a file");
        fs::copy(project.path("bad"), project.path("bad.json")).expect("a copy");
        fs::copy(project.path("bad"), project.path("bad.csv")).expect("a copy");
        let with = |line: &str| format!("{line}\n{PIPELINE}");
        for pipeline in [
            with("include: bad"),
            with("shapes: { rename_file: bad.csv }"),
            with("markers: { source: bad.csv, target: bad.csv }"),
        ] {
            let (status, stderr) = checked(&project, &pipeline);
            assert!(status == 65 || status == 78, "{pipeline}: {stderr}");
            assert!(stderr.contains(expected) && stderr.contains("iconv"), "{pipeline}: {stderr}");
        }
        let (status, _, stderr) = ended(project.command(&["compare", "bad.json", "bad"]));
        assert!(status == 65 && stderr.contains(expected), "{stderr}");
    }
}

#[test]
fn other_json_in_place_of_a_kept_correspondence_is_told_as_what_it_is() {
    let project = Project::new();
    for (text, expected) in [
        ("{}", "found other JSON: there is no `format`"),
        ("{\"format\": \"x\", \"version\": 1}", "found the format `x`"),
        ("{\"format\": \"mimesh-correspondence\"}", "found no version"),
        ("{\"format\": \"mimesh-correspondence\", \"version\": 7}", "found version 7"),
        ("[1]", "found other JSON"),
        ("7", "not a kept correspondence: its values are others"),
        ("", "not a kept correspondence: it is no JSON"),
    ] {
        project.write("pairs.json", text);
        let pipeline = PIPELINE.replace("{ type: identity }", "{ type: from_file, path: pairs.json }");
        assert_told(&project, &pipeline, 65, expected);
    }
}

#[test]
fn poses_of_another_mesh_are_found_before_anything_is_computed() {
    let project = Project::new();
    let small = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    project.write("pose-2.obj", small);
    let message = "pose-2.obj: pose has 3 vertices, the rest mesh 8";
    let told = project.mimesh(&["check", "p.yaml"]);
    assert!(told.status == 65 && told.stderr.contains(message), "{}", told.stderr);
    // One of several is left out by the run, which gives the others.
    let partly = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(partly.status, 4, "{}", partly.stderr);
    let truth =
        project.mimesh(&["check", "p.yaml", "--set", "truth=pose-{pose}.obj", "--set", "source.poses=[pose-1.obj]"]);
    assert_eq!(truth.status, 66, "{}", truth.stderr);
    // Where none can be a pose the run ends at once.
    for pose in [1, 10] {
        project.write(&format!("pose-{pose}.obj"), small);
    }
    let none = project.mimesh(&["run", "p.yaml"]);
    assert!(none.status == 65 && none.stderr.contains(message), "{}", none.stderr);
}

#[test]
fn names_of_runs_add_no_folder_and_no_formula() {
    let project = Project::new();
    let matrix = "matrix: { variables.v: [\"=1+1\", ../x, \"-y\"] }\nvariables: { v: 1 }\noutput:";
    project.edit("output:", matrix);
    project.edit("out/{pose}.obj", "[out/{matrix}/{pose}.obj, a/b/${v}/{matrix}.glb]");
    let output = project.mimesh(&["run", "p.yaml", "--table", "t.csv"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(project.names("out"), ["v=1+1", "v=x", "v=y"]);
    // What the author writes, with variables, is the author's.
    assert!(project.has("a/x/v=x.glb") && project.has("a/b/=1+1/v=1+1.glb"));
    let table = project.read("t.csv");
    let cells: Vec<&str> = table.lines().skip(1).map(|line| line.split(',').next().unwrap_or_default()).collect();
    assert_eq!(cells, ["'=1+1", "../x", "'-y"], "{table}");
}

#[test]
fn names_of_targets_are_names_everywhere() {
    for name in ["../x", "a/b", "a\\b", "..", "CON", "nul.x", "\u{202e}a", "a.", "{pose}"] {
        let project = Project::new();
        let target = format!("targets: {{ {}: {{ rest: target.obj }} }}", serde_json::json!(name));
        let pipeline = common::with_targets(&target);
        assert_told(&project, &pipeline, 78, "cannot name a target");
    }
    let project = Project::new();
    let pipeline = common::with_targets("targets: { a: { rest: target.obj }, A: { rest: target.obj } }");
    assert_told(&project, &pipeline, 78, "`a` and `A` differ in capitals alone");
    let long = "x".repeat(300);
    let pipeline = PIPELINE.replace("out/", &format!("{long}/"));
    assert_told(&project, &pipeline, 78, "of a folder has 300 bytes");
}
