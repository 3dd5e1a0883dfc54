//! Runs that are killed.

use std::{
    fs,
    os::unix::process::ExitStatusExt,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use mimesh::core::testkit::random::Random;

use crate::{
    calls::{run_command, traced},
    common::Project,
    sets::{POSES, Set, assert_report_is_of, assert_same, old_and_new, project, put_back, results, run, set},
};

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
    assert_same(&set(project), new, &format!("{when}: the next run"));
    assert_report_is_of(project, new);
    is_mixed
}

/// Kills a run after this time; `false` if it ended before.
fn is_killed_after(mut child: Child, time: Duration) -> bool {
    thread::sleep(time);
    // An error of `kill` would be that the run has ended.
    let _ = child.kill();
    child.wait().expect("an end").signal() == Some(9)
}

/// Kills `count` runs at moments spread over the time of a run. `start` gives the command; the number of runs that were killed while
/// files were moved.
fn kill(count: usize, start: impl Fn(&Project) -> Command) -> usize {
    let project = project();
    let sets = old_and_new(&project);
    let started = Instant::now();
    assert!(start(&project).stdout(Stdio::null()).status().expect("the command runs").success());
    let mut whole_run = started.elapsed();
    let mut random = Random::new(7);
    let (mut met, mut mixed, mut missed) = (0, 0, 0);
    while met < count {
        assert!(missed <= 10 * count, "{missed} runs ended before they could be killed, {met} did not");
        put_back(&project, &sets.0);
        let child = start(&project).stdout(Stdio::null()).spawn().expect("the command runs");
        // More kills where files are moved, near the end.
        let share = if met % 2 == 0 { random.between(0.0, 1.0) } else { random.between(0.7, 1.0) };
        if is_killed_after(child, whole_run.mul_f64(share)) {
            met += 1;
            mixed += usize::from(after_a_kill(&project, &sets, &format!("kill {met}")));
            // Other work on the machine may make runs longer than the first. What is too long is mended by the next miss.
            whole_run = whole_run.mul_f64(1.02);
        } else {
            // The run was shorter than thought.
            missed += 1;
            whole_run = whole_run.mul_f64(share);
        }
    }
    println!("{met} runs were killed, {mixed} of them while files were moved");
    mixed
}

#[test]
fn killed_runs_leave_old_results_or_new_ones_after_the_next_run() {
    kill(12, run_command);
}

#[test]
#[ignore = "takes minutes and needs strace; .ci/long runs it"]
fn runs_killed_200_times_leave_old_results_or_new_ones_after_the_next_run() {
    // Moves are over within a thousandth of a second, so that no kill would meet them: each waits. With -D the process to kill is the run.
    let slow_moves = ["-D", "-e", "trace=rename,link,linkat", "-e", "inject=rename,link,linkat:delay_enter=10000"];
    let mixed = kill(200, |project| traced(project, &slow_moves));
    assert!(mixed > 20, "only {mixed} kills came between two moves");
}

/// Kills a run at each of its system calls of some kind, by strace.
#[test]
#[ignore = "takes minutes and needs strace; .ci/long runs it"]
fn a_run_killed_at_any_system_call_of_its_commit_leaves_old_results_or_new_ones() {
    let project = project();
    let sets = old_and_new(&project);
    let status_of = |options: &[&str]| traced(&project, options).status().expect("strace is installed");
    let mut mixed = 0;
    let mut kills = 0;
    for call in ["rename", "link", "linkat", "unlink", "fsync", "flock", "mkdir", "chmod", "fchmodat", "write"] {
        put_back(&project, &sets.0);
        // The report is the last file that is written.
        assert!(status_of(&["-e", &format!("trace={call}")]).success());
        let trace = fs::read_to_string(project.path("trace.txt")).expect("a trace");
        let count = trace.lines().filter(|line| line.contains(&format!("{call}("))).count();
        for number in 1..=count {
            put_back(&project, &sets.0);
            let inject = format!("inject={call}:signal=KILL:when={number}");
            let status = status_of(&["-e", &format!("trace={call}"), "-e", &inject]);
            assert!(!status.success(), "{call} {number} of {count}");
            mixed += usize::from(after_a_kill(&project, &sets, &format!("{call} {number} of {count}")));
            kills += 1;
        }
        println!("{call}: {count} calls");
    }
    println!("{kills} kills, {mixed} of them left old and new files until the next run");
    assert!(mixed > POSES, "{mixed} kills came between two renames");
}
