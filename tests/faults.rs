//! Runs that die, disks that are full and folders that are closed: results are those of one run, old or new, and nothing is left over.
#![cfg(all(feature = "bundled", target_os = "linux"))]

mod common;

use std::{
    collections::BTreeMap,
    ffi::OsStr,
    fs,
    os::unix::{
        fs::{PermissionsExt, symlink},
        process::ExitStatusExt,
    },
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use common::{Output, PIPELINE, Project, leaning};
use mimesh::core::testkit::random::Random;

/// Poses of the tests.
const POSES: usize = 12;

/// The files of a set by their folders and names.
type Set = BTreeMap<String, Vec<u8>>;

/// A pipeline with results in two folders.
fn project() -> Project {
    let project = Project::new();
    for pose in project.names(".").iter().filter(|name| name.starts_with("pose-")) {
        fs::remove_file(project.path(pose)).expect("a pose");
    }
    project.write("p.yaml", &PIPELINE.replace("out/{pose}.obj", "[out/{pose}.obj, more/{pose}.ply, out/all.glb]"));
    lean(&project, 0.1);
    project
}

/// Makes the poses others, by which the next run makes another set.
fn lean(project: &Project, by: f64) {
    for pose in 0..POSES {
        project.write(&format!("pose-{pose:02}.obj"), &leaning(by + 0.01 * pose as f64));
    }
}

/// All files of the folders of results but the report, which holds times.
fn set(project: &Project) -> Set {
    let of = |folder: &str| {
        let names = if project.path(folder).is_dir() { project.names(folder) } else { vec![] };
        let files = names.into_iter().map(|name| format!("{folder}/{name}")).collect::<Vec<_>>();
        files
            .into_iter()
            .filter(|name| name != "out/run.json")
            .map(|name| (name.clone(), project.bytes(&name)))
            .collect::<Vec<_>>()
    };
    ["out", "more"].into_iter().flat_map(of).collect()
}

/// The results of a set, without temporary files.
fn results(set: &Set) -> Set {
    set.iter()
        .filter(|(name, _)| !name.contains("/.mimesh-"))
        .map(|(name, bytes)| (name.clone(), bytes.clone()))
        .collect()
}

#[track_caller]
fn run(project: &Project) -> Output {
    let output = project.mimesh(&["run", "p.yaml", "--no-cache", "--quiet"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    output
}

/// Checks that the report holds the size and the hash of every result.
#[track_caller]
fn assert_report_is_of(project: &Project, set: &Set) {
    let report = common::json(&String::from_utf8(project.bytes("out/run.json")).expect("text"));
    let outputs = report["outputs"].as_array().expect("outputs");
    assert_eq!(outputs.len(), set.len());
    for output in outputs {
        let path = output["path"].as_str().expect("a path");
        let (_, bytes) = set.iter().find(|(name, _)| path.ends_with(name.as_str())).expect("a result");
        assert_eq!(output["blake3"], blake3::hash(bytes).to_hex().as_str(), "{path}");
        assert_eq!(output["bytes"], bytes.len());
    }
}

/// The old and the new set; the old one is in place, and the poses are those of the new one.
fn old_and_new(project: &Project) -> (Set, Set) {
    lean(project, 0.5);
    run(project);
    let new = set(project);
    lean(project, 0.1);
    run(project);
    let old = set(project);
    assert!(
        old.len() == 2 * POSES + 1 && old.keys().eq(new.keys()) && old.values().zip(new.values()).all(|(a, b)| a != b)
    );
    lean(project, 0.5);
    (old, new)
}

/// What has become of a run that was killed: `true` if its files were old ones and new ones.
#[track_caller]
fn after_a_kill(project: &Project, (old, new): &(Set, Set), when: &str) -> bool {
    let found = results(&set(project));
    for (name, bytes) in &found {
        assert!(*bytes == old[name] || *bytes == new[name], "{when}: {name} is torn");
    }
    let is_mixed = found != *old && found != *new;
    let told = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(told.status, 0, "{}", told.stderr);
    if is_mixed {
        assert!(told.stderr.contains("so the files are of two runs"), "{when}: {}", told.stderr);
        let plan = project.mimesh(&["plan", "p.yaml"]);
        assert!((plan.stdout + &plan.stderr).contains("so the files are of two runs"), "{when}");
    }
    run(project);
    assert_eq!(set(project), *new, "{when}: the next run");
    assert_report_is_of(project, new);
    is_mixed
}

/// Puts the old set in place again.
fn put_back(project: &Project, old: &Set) {
    lean(project, 0.1);
    run(project);
    assert_eq!(set(project), *old);
    lean(project, 0.5);
}

/// Kills `count` runs at moments spread over the time of a run.
fn kill(count: usize) {
    let project = project();
    let sets = old_and_new(&project);
    let started = Instant::now();
    run(&project);
    let whole_run = started.elapsed().as_secs_f64();
    let mut random = Random::new(7);
    let (mut met, mut mixed) = (0, 0);
    while met < count {
        put_back(&project, &sets.0);
        let mut command = project.command(&["run", "p.yaml", "--no-cache", "--quiet"]);
        let mut child = command.stdout(Stdio::null()).spawn().expect("the command runs");
        // More kills where files are moved, near the end.
        let share = if met % 2 == 0 { random.between(0.0, 1.0) } else { random.between(0.7, 1.0) };
        thread::sleep(Duration::from_secs_f64(share * whole_run));
        child.kill().expect("a process to kill");
        if child.wait().expect("an end").signal() == Some(9) {
            met += 1;
            mixed += usize::from(after_a_kill(&project, &sets, &format!("kill {met}")));
        }
    }
    println!("{met} runs were killed, {mixed} of them while files were moved");
}

#[test]
fn killed_runs_leave_old_results_or_new_ones_after_the_next_run() {
    kill(12);
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn runs_killed_200_times_leave_old_results_or_new_ones_after_the_next_run() {
    kill(200);
}

/// Kills a run at each of its system calls of some kind, by strace.
#[test]
#[ignore = "takes minutes and needs strace; .ci/long runs it"]
fn a_run_killed_at_any_system_call_of_its_commit_leaves_old_results_or_new_ones() {
    let project = project();
    let sets = old_and_new(&project);
    let traced = |options: &[&str]| {
        let mimesh = project.command(&["run", "p.yaml", "--no-cache", "--quiet", "--threads", "1"]);
        let mut command = Command::new("strace");
        command.args(["-f", "-qq", "-o", "trace.txt"]).args(options).arg(mimesh.get_program()).args(mimesh.get_args());
        command.current_dir(project.path(".")).stdout(Stdio::null());
        mimesh.get_envs().for_each(|(name, value)| _ = command.env(name, value.unwrap_or_default()));
        command.status().expect("strace is installed")
    };
    let mut mixed = 0;
    let mut kills = 0;
    for call in ["rename", "link", "linkat", "unlink", "fsync", "flock", "mkdir", "chmod", "fchmodat", "write"] {
        put_back(&project, &sets.0);
        // The report is the last file that is written.
        assert!(traced(&["-e", &format!("trace={call}")]).success());
        let trace = fs::read_to_string(project.path("trace.txt")).expect("a trace");
        let count = trace.lines().filter(|line| line.contains(&format!("{call}("))).count();
        for number in 1..=count {
            put_back(&project, &sets.0);
            let inject = format!("inject={call}:signal=KILL:when={number}");
            let status = traced(&["-e", &format!("trace={call}"), "-e", &inject]);
            assert!(!status.success(), "{call} {number} of {count}");
            mixed += usize::from(after_a_kill(&project, &sets, &format!("{call} {number} of {count}")));
            kills += 1;
        }
        println!("{call}: {count} calls");
    }
    println!("{kills} kills, {mixed} of them left old and new files until the next run");
    assert!(mixed > POSES, "{mixed} kills came between two renames");
}

/// Runs a command of `sh` that ends in `mimesh run`.
fn by_shell(project: &Project, before: &str) -> Output {
    let mimesh = project.command(&["run", "p.yaml", "--no-cache", "--quiet"]);
    let words: Vec<&OsStr> = std::iter::once(mimesh.get_program()).chain(mimesh.get_args()).collect();
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("{before} exec \"$@\"")).arg("sh").args(words).current_dir(project.path("."));
    mimesh.get_envs().for_each(|(name, value)| _ = command.env(name, value.unwrap_or_default()));
    let output = command.output().expect("sh runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    Output { status: output.status.code().unwrap_or(-1), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn a_disk_that_takes_no_more_leaves_the_old_results_and_nothing_else() {
    let project = project();
    let (old, _) = old_and_new(&project);
    // The largest file that may be written has a block of 512 bytes: the file of all poses, or an OBJ, is longer.
    let output = by_shell(&project, "trap '' XFSZ; ulimit -f 1;");
    assert_eq!(output.status, 73, "{}", output.stderr);
    assert!(output.stderr.contains("cannot write") || output.stderr.contains("File too large"), "{}", output.stderr);
    assert_eq!(set(&project), old);
}

#[test]
fn a_closed_folder_is_refused_before_anything_is_computed() {
    let project = project();
    let (old, new) = old_and_new(&project);
    fs::set_permissions(project.path("more"), fs::Permissions::from_mode(0o555)).expect("a folder");
    // Nobody closes a folder to the superuser.
    let closed = fs::write(project.path("more/try"), "").is_err();
    let output = project.mimesh(&["run", "p.yaml", "--no-cache", "--quiet"]);
    fs::set_permissions(project.path("more"), fs::Permissions::from_mode(0o755)).expect("a folder");
    let _ = fs::remove_file(project.path("more/try"));
    if closed {
        assert_eq!(output.status, 73, "{}", output.stderr);
        assert!(output.stderr.contains("no permission to make files in"), "{}", output.stderr);
        assert_eq!(set(&project), old);
    } else {
        assert_eq!(set(&project).len(), new.len());
    }
}

#[test]
fn of_two_runs_at_once_one_writes_all_or_the_other() {
    let project = project();
    let (old, new) = old_and_new(&project);
    let mut refused = 0;
    // One makes the old set, and one the new one.
    for (folder, by) in [("older", 0.1), ("newer", 0.5)] {
        lean(&project, by);
        for pose in project.names(".").into_iter().filter(|name| name.starts_with("pose-")) {
            project.write(&format!("{folder}/{pose}"), &project.read(&pose));
        }
    }
    for _ in 0..6 {
        let start = |folder: &str| {
            let poses = format!("source.poses={folder}/pose-*.obj");
            let mut command = project.command(&["run", "p.yaml", "--no-cache", "--quiet", "--set", &poses]);
            command.stderr(Stdio::piped()).spawn().expect("the command runs")
        };
        let (first, second) = (start("older"), start("newer"));
        let statuses: Vec<i32> = [first, second]
            .into_iter()
            .map(|child| {
                let output = child.wait_with_output().expect("an end");
                let told = String::from_utf8_lossy(&output.stderr).into_owned();
                let status = output.status.code().expect("a status");
                assert!(
                    status == 0 || (status == 75 && told.contains("another process is writing this file")),
                    "{told}"
                );
                status
            })
            .collect();
        refused += statuses.iter().filter(|status| **status == 75).count();
        assert!(statuses.contains(&0), "{statuses:?}");
        let found = set(&project);
        assert_report_is_of(&project, &found);
        assert!(found == old || found == new, "{:?}", found.keys());
    }
    println!("{refused} runs were refused");
}

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
