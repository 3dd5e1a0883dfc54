//! Room in the cache: poses of all runs stay there until they are merged.

use std::{fmt::Write as _, fs::File, io::Write as _};

use crate::{GALLOP, common::Project, mimesh, project};

/// Two runs whose poses take .7 MB each.
fn herd() -> Project {
    let camel = "target: { generator: { type: quadruped, proportions: camel, gait: gallop, resolution: 22, seed: 1 } }";
    let rest =
        |seed: u32| format!("{{ generator: {{ type: quadruped, proportions: camel, resolution: 22, seed: {seed} }} }}");
    let targets = format!("targets: {{ one: {}, two: {} }}", rest(1), rest(2));
    let text = GALLOP
        .replace(camel, &targets)
        .replace("gait: gallop, resolution: 20", "gait: gallop, resolution: 20, frames: 20");
    project(&text.replace("out/", "out/{target}/"))
}

/// The limits that a plan names for its runs.
fn limits(project: &Project) -> Vec<u64> {
    let plan = mimesh(project, "plan", &["--json"], 0).json();
    let limit = |run: &serde_json::Value| run["plan"]["cache_limit"].as_u64().expect("a limit");
    plan.as_array().expect("runs").iter().map(limit).collect()
}

#[test]
fn where_the_cache_may_have_removed_poses_the_merge_says_so_and_its_limit_helps() {
    let project = herd();
    for name in ["one", "two"] {
        mimesh(&project, "run", &["--run", name, "--shard", "0/1", "--cache-limit", "1"], 0);
    }
    let refused = mimesh(&project, "merge", &["--cache-limit", "1"], 75).stderr;
    assert!(refused.contains("and may have removed poses: give all parts `--cache-limit "), "{refused}");
    let flag = refused.split("give all parts `--cache-limit ").nth(1).and_then(|rest| rest.split('`').next());
    let flag = flag.expect("a limit");
    for name in ["one", "two"] {
        mimesh(&project, "run", &["--run", name, "--shard", "0/1", "--cache-limit", flag], 0);
    }
    mimesh(&project, "merge", &["--cache-limit", flag], 0);
}

#[test]
fn where_nothing_was_removed_the_merge_does_not_speak_of_it() {
    let project = herd();
    mimesh(&project, "run", &["--run", "one", "--shard", "0/1"], 0);
    let refused = mimesh(&project, "merge", &[], 75).stderr;
    assert!(!refused.contains("removed"), "{refused}");
}

#[test]
fn a_job_has_room_for_the_poses_of_all_its_runs() {
    let project = herd();
    let needed = limits(&project);
    assert_eq!(needed.len(), 2);
    let refused = mimesh(&project, "submit", &["--to", "shell", "--cache-limit", "1"], 2).stderr;
    assert!(refused.contains("--cache-limit 1: the poses of all runs need "), "{refused}");
    assert!(!project.has("p-job"), "nothing is written");
    let enough = needed.iter().sum::<u64>().to_string();
    mimesh(&project, "submit", &["--to", "shell", "--cache-limit", &enough], 0);
    let script = project.read("p-job/job.sh");
    assert!(script.contains(&format!("    '--cache-limit'\n    '{enough}'\n")), "{script}");
}

#[test]
fn a_job_of_more_poses_than_the_cache_holds_by_itself_lets_it_grow() {
    // 2,000 frames of 48,400 vertices take 2.3 GB; the file of their positions has a hole in place of numbers.
    let (side, frames) = (220u32, 2000u32);
    let project = Project::new();
    let mut mesh = String::new();
    for i in 0..side * side {
        writeln!(mesh, "v {} {} 0", i % side, i / side).expect("a string");
    }
    for (x, y) in (1..side).flat_map(|x| (1..side).map(move |y| (x, y))) {
        let corner = (y - 1) * side + x;
        writeln!(mesh, "f {corner} {} {} {}", corner + 1, corner + side + 1, corner + side).expect("a string");
    }
    project.write("sheet.obj", &mesh);
    let mut clip = File::create(project.path("clip.pc2")).expect("a file");
    let header = [&b"POINTCACHE2\0"[..], &1i32.to_le_bytes(), &(side * side).to_le_bytes(), &0f32.to_le_bytes()];
    let rest = [1f32.to_le_bytes(), frames.to_le_bytes()];
    clip.write_all(&[&header.concat()[..], &rest.concat()].concat()).expect("a header");
    clip.set_len(32 + 12 * u64::from(side * side) * u64::from(frames)).expect("a hole");
    drop(clip);
    project.write(
        "p.yaml",
        "source: { rest: sheet.obj, poses: clip.pc2 }\ntarget: { rest: sheet.obj }\ncorrespondence: { type: identity }\n\
         transfer: { type: gradient }\noutput: out/all.pc2\n",
    );
    let limit = mimesh(&project, "plan", &["--json", "--no-cache"], 0).json()["cache_limit"].as_u64().expect("a limit");
    assert!(limit > 2048, "{limit}");
    mimesh(&project, "submit", &["--to", "shell"], 0);
    let script = project.read("p-job/job.sh");
    assert!(script.contains(&format!("    '--cache-limit'\n    '{limit}'\n")), "{script}");
}
