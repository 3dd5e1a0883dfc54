//! Runs that are killed resume where they were.

use std::{
    collections::BTreeMap,
    fs,
    process::Stdio,
    thread,
    time::{Duration, Instant},
};

use mimesh::core::testkit::random::Random;

use crate::{
    common::{Project, cache_entries, wait_for},
    gallop, results, reused, run,
};

/// The poses in the cache.
fn cached_poses(project: &Project) -> usize {
    cache_entries(&project.cache().join("v1/pose")).len()
}

/// Checks that each result of a killed run is whole or not there.
fn assert_whole(project: &Project, expected: &BTreeMap<String, Vec<u8>>) {
    for (name, bytes) in results(project, "out") {
        // Hidden files are temporary.
        if !name.starts_with('.') {
            assert_eq!(Some(&bytes), expected.get(&name), "{name} is neither whole nor absent");
        }
    }
}

#[test]
fn a_killed_run_resumes_after_its_cached_poses_and_ends_in_the_same_bytes() {
    const POSES: usize = 48;
    let project = gallop();
    // So many poses that a kill after a few of them comes long before the last.
    project.edit("gait: gallop, resolution: 20", &format!("gait: gallop, resolution: 20, frames: {POSES}"));
    run(&project, &["--no-cache", "--out", "expected"]);
    let expected = results(&project, "expected");
    assert_eq!(expected.len(), POSES + 1);
    let mut before = 0;
    for poses in [1, 8, 20] {
        let mut child =
            project.command(&["run", "p.yaml", "--quiet"]).stdout(Stdio::null()).spawn().expect("the command runs");
        wait_for("so many cached poses", || cached_poses(&project) >= poses);
        child.kill().expect("a process to kill");
        let status = child.wait().expect("an end");
        let cached = cached_poses(&project);
        assert!(!status.success() && (poses..POSES).contains(&cached), "{status}, {cached} poses: not killed midway");
        assert!(cached >= before, "{before} poses were cached, {cached} are left");
        assert_whole(&project, &expected);
        before = cached;
    }
    let plan = project.mimesh(&["plan", "p.yaml"]).stdout;
    assert!(plan.contains(&format!("run {} of {POSES}", POSES - before)), "{plan}");
    assert_eq!(reused(&run(&project, &[])).1, before);
    assert_eq!(results(&project, "out"), expected, "temporary files of killed runs are gone too");
}

#[test]
#[ignore = "takes minutes: .ci/long runs it"]
fn runs_killed_200_times_at_random_lose_nothing_and_end_in_the_same_bytes() {
    let project = gallop();
    run(&project, &["--no-cache", "--out", "expected"]);
    let expected = results(&project, "expected");
    let started = Instant::now();
    run(&project, &["--cache", "other"]);
    let whole_run = started.elapsed().as_secs_f64();
    let mut random = Random::new(2);
    let (mut before, mut midway, mut completed) = (0, 0, 0);
    for number in 0..200 {
        let mut child =
            project.command(&["run", "p.yaml", "--quiet"]).stdout(Stdio::null()).spawn().expect("the command runs");
        if number % 2 == 0 {
            thread::sleep(Duration::from_secs_f64(random.between(0.0, whole_run)));
        } else {
            // Poses take a small part of a run: these kills wait for the first new one.
            while cached_poses(&project) == before && child.try_wait().expect("a status").is_none() {
                thread::sleep(Duration::from_micros(200));
            }
        }
        // The run may have ended by itself.
        let _ = child.kill();
        child.wait().expect("an end");
        assert_whole(&project, &expected);
        let cached = cached_poses(&project);
        assert!(cached >= before, "{before} poses were cached, {cached} are left");
        midway += usize::from(cached > 0 && cached < 12);
        before = cached;
        if cached == 12 {
            assert_eq!(reused(&run(&project, &[])).1, 12);
            assert_eq!(results(&project, "out"), expected, "temporary files of killed runs are gone too");
            assert_eq!(project.mimesh(&["cache", "--clear"]).status, 0);
            fs::remove_dir_all(project.path("out")).expect("results");
            (before, completed) = (0, completed + 1);
        }
    }
    println!("{midway} of 200 kills came between the first pose and the last, {completed} runs were completed");
    assert!(midway >= 20 && completed >= 5, "{midway} kills midway, {completed} runs completed");
}
