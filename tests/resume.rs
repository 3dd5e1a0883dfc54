//! Results cached from run to run: taken only where nothing they depend on has changed, and whole whatever happened before.
#![cfg(feature = "bundled")]

mod common;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Stdio,
    thread,
    time::{Duration, Instant},
};

use common::{Project, wait_for};
use mimesh::core::testkit::random::Random;
use serde_json::Value;

/// A gallop with files a pose and one of all.
const GALLOP: &str = "\
source: { generator: { type: quadruped, proportions: horse, gait: gallop, resolution: 20 } }
target: { generator: { type: quadruped, proportions: camel, gait: gallop, resolution: 24, seed: 1 } }
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
output: [ out/camel-{pose}.obj, out/camel.glb ]
";

fn gallop() -> Project {
    let project = Project::new();
    project.write("p.yaml", GALLOP);
    project
}

fn run(project: &Project, more: &[&str]) -> Value {
    let output = project.mimesh(&[&["run", "p.yaml", "--json"], more].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

/// The bytes of the results by name. The report is left out, for it holds times.
fn results(project: &Project, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let names = project.names(folder).into_iter().filter(|name| name != "run.json");
    names.map(|name| (name.clone(), project.bytes(&format!("{folder}/{name}")))).collect()
}

/// For each stage whether its result came from the cache, and how many poses did.
fn reused(report: &Value) -> (Vec<(String, bool)>, usize) {
    let is_reused = |value: &Value| value["reused"] == true;
    let stages = report["stages"].as_array().expect("stages").iter().filter(|stage| stage.get("type").is_some());
    let stages = stages.map(|stage| (stage["stage"].as_str().expect("a name").to_owned(), is_reused(stage))).collect();
    (stages, report["poses"].as_array().expect("poses").iter().filter(|pose| is_reused(pose)).count())
}

fn stages(of: &[(&str, bool)]) -> Vec<(String, bool)> {
    of.iter().map(|(stage, reused)| (stage.to_string(), *reused)).collect()
}

/// The step of a stage in `mimesh plan p.yaml`: what is done with it, and why.
#[track_caller]
fn planned(project: &Project, stage: &str, more: &[&str]) -> (String, String) {
    let plan = project.mimesh(&[&["plan", "p.yaml", "--json"], more].concat()).json();
    let step = plan["steps"].as_array().expect("steps").iter().find(|step| step["stage"] == stage);
    let text = |key: &str| step.expect(stage)[key].as_str().expect(key).to_owned();
    (text("action"), text("why"))
}

/// The inodes of the entries of a kind in the cache of a project: an entry that is written again has another one.
#[cfg(unix)]
fn inodes(project: &Project, kind: &str) -> Vec<(PathBuf, u64)> {
    use std::os::unix::fs::MetadataExt;
    let inode = |path: PathBuf| fs::metadata(&path).map(|metadata| (path, metadata.ino())).expect("an entry");
    entries(&project.cache().join("v1").join(kind)).into_iter().map(inode).collect()
}

/// The files of all entries of a cache, but for temporary ones.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        let is_temporary = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() {
            found.extend(entries(&path));
        } else if !is_temporary {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn the_same_run_again_does_no_work_and_gives_the_same_bytes() {
    let project = gallop();
    let first = run(&project, &[]);
    assert_eq!(reused(&first), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    let results_of_first = results(&project, "out");
    let plan = project.mimesh(&["plan", "p.yaml"]);
    assert!(plan.stdout.matches("reuse:").count() == 3 && !plan.stdout.contains("run"), "{}", plan.stdout);

    let second = run(&project, &["--threads", "1"]);
    assert_eq!(reused(&second), (stages(&[("correspondence", true), ("transfer", true)]), 12));
    assert_eq!(results(&project, "out"), results_of_first);
    // What stages report is cached with their results.
    let figures =
        |report: &Value| report["stages"].as_array().unwrap().iter().map(|s| s["figures"].clone()).collect::<Vec<_>>();
    assert_eq!(figures(&first), figures(&second));
    assert_eq!(first["metrics"], second["metrics"]);
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!(output.stdout.contains("transfer (gradient): cached by an earlier run"), "{}", output.stdout);
    assert!(output.stdout.contains("12 of 12 cached"), "{}", output.stdout);

    let without = run(&project, &["--no-cache", "--out", "again"]);
    assert_eq!(reused(&without), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    assert_eq!(results(&project, "again"), results_of_first);
}

#[test]
fn a_change_does_again_only_what_depends_on_it() {
    let project = gallop();
    run(&project, &[]);
    let planned = |more: &[&str]| project.mimesh(&[&["plan", "p.yaml"], more].concat()).stdout;

    let transfer = ["--set", "transfer.reweightings=1"];
    let plan = planned(&transfer);
    assert!(plan.contains("reuse: cached") && plan.contains("reweightings is 1, was 5"), "{plan}");
    assert_eq!(reused(&run(&project, &transfer)), (stages(&[("correspondence", true), ("transfer", false)]), 0));
    // Both are cached side by side.
    assert_eq!(reused(&run(&project, &[])).1, 12);
    assert_eq!(reused(&run(&project, &transfer)).1, 12);

    let correspondence = ["--set", "correspondence.steps=5"];
    assert!(planned(&correspondence).contains("steps is 5, was 10"), "{}", planned(&correspondence));
    let report = run(&project, &correspondence);
    assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", false)]), 0));

    // Another target changes all, other formats and files to write nothing.
    assert_eq!(reused(&run(&project, &["--set", "target.generator.seed=2"])).1, 0);
    assert_eq!(reused(&run(&project, &["--set", "output=[only/{pose}.ply]"])).1, 12);
}

#[test]
fn files_count_by_their_contents_and_not_by_name_or_time() {
    let project = Project::new();
    run(&project, &[]);
    let touched = fs::File::options().append(true).open(project.path("pose-2.obj")).expect("a pose");
    touched.set_modified(std::time::SystemTime::UNIX_EPOCH).expect("a time");
    assert_eq!(reused(&run(&project, &[])).1, 3);

    project.write("pose-2.obj", &common::leaning(0.7));
    let report = run(&project, &[]);
    // `copy_displacement` learns from no pose, so that the others stand.
    assert_eq!(reused(&report).1, 2);
    assert_eq!(planned(&project, "poses", &[]).0, "reuse");
    // Renamed, it is the same pose under another name.
    fs::rename(project.path("pose-2.obj"), project.path("pose-3.obj")).expect("another name");
    assert_eq!(reused(&run(&project, &[])).1, 3);
    assert!(project.has("out/3.obj"));
}

/// A glTF of a tetrahedron, its last corner at `height`: the text, and the bytes of its buffer in the file `buffer`.
fn tetrahedron(buffer: &str, height: f32) -> (String, Vec<u8>) {
    let corners: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, height]];
    let triangles: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let positions = corners.iter().flatten().flat_map(|x| x.to_le_bytes());
    let bytes = positions.chain(triangles.iter().flat_map(|corner| corner.to_le_bytes())).collect();
    let text = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 24 },
        ],
        "buffers": [{ "uri": buffer, "byteLength": 72 }],
    });
    (text.to_string(), bytes)
}

#[test]
fn a_file_that_a_pose_or_a_truth_names_counts_too() {
    let project = Project::new();
    for (name, height) in [("rest", 1.0), ("pose-1", 1.5), ("truth-1", 1.5)] {
        let (text, bytes) = tetrahedron(&format!("{name}.bin"), height);
        project.write(&format!("{name}.gltf"), &text);
        fs::write(project.path(&format!("{name}.bin")), bytes).expect("a buffer");
    }
    let text = common::PIPELINE.replace("rest.obj", "rest.gltf").replace("pose-*.obj", "pose-*.gltf");
    let text = text.replace("target.obj", "rest.gltf").replace("output:", "truth: truth-{pose}.gltf\noutput:");
    project.write("p.yaml", &text);
    let first = run(&project, &[]);
    let inputs: Vec<_> = first["inputs"].as_array().expect("inputs").iter().map(|input| &input["path"]).collect();
    for name in ["rest", "pose-1", "truth-1"] {
        assert!(inputs.contains(&&Value::from(format!("{name}.bin"))), "{name}: {inputs:?}");
    }
    let mean = |report: &Value| report["poses"][0]["metrics"]["point_error"]["mean"].as_f64().expect("an error");
    assert!(mean(&first) < 1e-6, "the target is the source, and so is the truth: {}", mean(&first));
    assert_eq!(reused(&run(&project, &[])).1, 1);

    fs::write(project.path("truth-1.bin"), tetrahedron("", 2.0).1).expect("a buffer");
    assert!(mean(&run(&project, &[])) > 1.0, "measured against the new truth");
    fs::write(project.path("pose-1.bin"), tetrahedron("", 2.0).1).expect("a buffer");
    let report = run(&project, &[]);
    assert_eq!(reused(&report).1, 0, "another pose");
    assert!(mean(&report) < 1e-6, "{}", mean(&report));
}

#[test]
fn a_plan_says_what_the_run_will_do_whatever_is_left_of_the_cache() {
    let project = Project::new();
    run(&project, &[]);
    let remove = |kind: &str| fs::remove_dir_all(project.cache().join("v1").join(kind)).expect("cached results");
    let cached = "cached for this transfer and these poses".to_owned();

    // Poses stand alone and are all there, so that only what the transfer reported has to be found again.
    remove("transfer");
    assert_eq!(planned(&project, "poses", &[]), ("reuse".into(), cached.clone()));
    assert_eq!(planned(&project, "transfer", &[]), ("run".into(), "its result is no longer cached".into()));
    assert_eq!(reused(&run(&project, &[])).1, 3);

    // With all poses and their measurements nothing needs the map.
    remove("correspondence");
    assert_eq!(planned(&project, "correspondence", &[]), ("skip".into(), "all poses are cached".into()));
    assert_eq!(reused(&run(&project, &[])), (stages(&[("transfer", true)]), 3));
    assert!(entries(&project.cache().join("v1/correspondence")).is_empty(), "it was skipped as planned");

    // Pictures show more than measurements hold, so that poses are measured again; and a file of the map needs the map.
    for more in [["--set", "output=[out/{pose}.obj, out/r.html]"], ["--set", "keep_correspondence=map.json"]] {
        assert_eq!(planned(&project, "correspondence", &more).0, "run", "{more:?}");
        assert_eq!(planned(&project, "poses", &more), ("reuse".into(), cached.clone()));
        let report = run(&project, &more);
        assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", true)]), 3), "{more:?}");
        remove("correspondence");
    }
}

#[test]
fn the_seconds_of_a_run_are_those_of_one_clock() {
    let project = Project::new();
    project.edit("correspondence:", "proximity: { type: spanning_tree }\ncorrespondence:");
    let started = Instant::now();
    let report = run(&project, &["--no-cache"]);
    let elapsed = started.elapsed().as_secs_f64();
    let seconds = report["seconds"].as_f64().expect("seconds");
    let stages = report["stages"].as_array().expect("stages").iter();
    let sum: f64 = stages.map(|stage| stage["seconds"].as_f64().expect("seconds")).sum();
    // Clocks of stages lie within the whole, apart from the rounding of sums.
    assert!(sum <= seconds + 1e-9 && seconds <= elapsed, "{sum} of {seconds}, {elapsed} outside");
}

#[test]
fn a_file_that_a_stage_reads_counts_too() {
    let project = Project::new();
    project.edit("output:", "keep_correspondence: map.json\noutput:");
    run(&project, &[]);
    project.edit("keep_correspondence: map.json\n", "");
    project.edit("type: identity", "type: from_file, path: map.json");
    run(&project, &[]);
    assert_eq!(reused(&run(&project, &[])).1, 3);
    let map = project.read("map.json");
    project.write("map.json", &format!("{map}\n"));
    assert_eq!(reused(&run(&project, &[])), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    // Under another name it is the same map.
    fs::rename(project.path("map.json"), project.path("other.json")).expect("another name");
    project.edit("path: map.json", "path: other.json");
    assert_eq!(reused(&run(&project, &[])).1, 3);
}

#[test]
fn damaged_entries_are_reported_and_computed_again() {
    let project = gallop();
    run(&project, &[]);
    let expected = results(&project, "out");
    let all = entries(project.cache());
    assert!(all.len() > 12, "{all:?}");
    let mut random = Random::new(1);
    for (i, path) in all.iter().enumerate() {
        let mut bytes = fs::read(path).expect("an entry");
        let at = random.index(bytes.len());
        match i % 3 {
            0 => bytes[at] ^= 1,
            1 => bytes.truncate(at),
            _ => bytes.clear(),
        }
        fs::write(path, bytes).expect("an entry");
    }
    let report = run(&project, &[]);
    assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    assert!(report["warnings"].to_string().contains("damaged"), "{}", report["warnings"]);
    assert_eq!(results(&project, "out"), expected);
    assert_eq!(reused(&run(&project, &[])).1, 12);
}

/// The poses in the cache.
fn cached_poses(project: &Project) -> usize {
    entries(&project.cache().join("v1/pose")).len()
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

#[test]
fn two_runs_at_once_share_a_cache() {
    let project = gallop();
    run(&project, &["--no-cache", "--out", "expected"]);
    let expected = results(&project, "expected");
    std::thread::scope(|scope| {
        for folder in ["a", "b", "c"] {
            let (project, expected) = (&project, &expected);
            scope.spawn(move || {
                run(project, &["--out", folder]);
                assert_eq!(results(project, folder), *expected);
            });
        }
    });
    assert_eq!(reused(&run(&project, &[])).1, 12);
}

#[test]
fn a_cache_that_cannot_be_written_is_only_a_warning() {
    let project = gallop();
    project.write("file", "no folder");
    let report = run(&project, &["--cache", "file"]);
    let warnings = report["warnings"].to_string();
    assert!(
        warnings.matches("results are not cached").count() == 1 && warnings.contains("another folder"),
        "{warnings}"
    );
    assert_eq!(results(&project, "out").len(), 13);
}

#[test]
fn the_cache_is_shown_bounded_and_cleared() {
    let project = gallop();
    run(&project, &[]);
    let shown = project.mimesh(&["cache"]).stdout;
    assert!(shown.contains("pose") && shown.contains("12 results"), "{shown}");
    let bytes = || -> u64 {
        let json: Value = serde_json::from_str(&project.mimesh(&["cache", "--json"]).stdout).expect("JSON");
        json["bytes"].as_u64().expect("bytes")
    };
    assert!(bytes() > 1 << 19, "{}", bytes());
    run(&project, &["--set", "transfer.reweightings=1", "--cache-limit", "1"]);
    assert!(bytes() <= 1 << 20, "{}", bytes());
    assert!(project.mimesh(&["cache", "--clear"]).stdout.contains("removed"));
    assert_eq!(bytes(), 0);
    assert_eq!(reused(&run(&project, &[])).1, 0);
}

#[test]
fn frames_of_one_motion_are_cached_together() {
    let project = gallop();
    let motion = "type: multi_component, sequence: true";
    project.edit("type: gradient", motion);
    project.edit("correspondence:", "proximity: { type: spanning_tree }\ncorrespondence:");
    let first = run(&project, &[]);
    let expected = results(&project, "out");
    assert_eq!(reused(&run(&project, &[])).1, 12);
    assert_eq!(results(&project, "out"), expected);
    assert_eq!(reused(&first).1, 0);
    // One frame is lost: all of them run, for each begins where the one before ended.
    let frame = entries(&project.cache().join("v1/frame"));
    fs::remove_file(&frame[5]).expect("a frame");
    assert!(project.mimesh(&["plan", "p.yaml"]).stdout.contains("run 12 of 12"));
    let report = run(&project, &[]);
    assert_eq!(reused(&report), (stages(&[("proximity", true), ("correspondence", true), ("transfer", false)]), 0));
    assert_eq!(results(&project, "out"), expected);
}

#[test]
fn metrics_are_cached_until_a_pose_the_truth_or_a_metric_changes() {
    let project = Project::new();
    for (pose, by) in [(1, 0.1), (2, 0.2), (10, 1.0)] {
        project.write(&format!("truth-{pose}.obj"), &common::leaning(by));
    }
    project.edit("output:", "truth: truth-{pose}.obj\noutput:");
    let cached = |project: &Project| entries(project.cache()).len();
    let judged = |report: &Value| -> Vec<Value> {
        let of = |pose: &Value| serde_json::json!([pose["metrics"], pose["nothing"], pose["verdict"], pose["figures"]]);
        report["poses"].as_array().expect("poses").iter().map(of).collect()
    };
    let first = run(&project, &[]);
    assert!(first["poses"][1]["metrics"]["point_error"]["mean"].as_f64() > Some(0.0));
    let entries_of_first = cached(&project);
    #[cfg(unix)]
    let written_by_first = inodes(&project, "metrics");
    let second = run(&project, &[]);
    assert_eq!(judged(&first), judged(&second), "cached metrics come back to the last bit");
    assert_eq!((&first["metrics"], cached(&project)), (&second["metrics"], entries_of_first));
    #[cfg(unix)]
    {
        assert_eq!(written_by_first.len(), 3);
        assert_eq!(inodes(&project, "metrics"), written_by_first, "nothing was measured");
    }

    // Limits are no part of what is measured.
    let output = project.mimesh(&["run", "p.yaml", "--json", "--set", "gates.point_error=0.001"]);
    assert_eq!(output.status, 3, "{}", output.stderr);
    assert_eq!(cached(&project), entries_of_first);

    project.write("truth-2.obj", &common::leaning(0.7));
    let third = run(&project, &[]);
    assert_eq!((&judged(&third)[0], &judged(&third)[2]), (&judged(&first)[0], &judged(&first)[2]));
    assert_ne!(judged(&third)[1], judged(&first)[1], "another truth");
    let entries_of_third = cached(&project);
    run(&project, &["--set", "metrics=[{ type: self_intersections }]"]);
    assert_eq!(cached(&project), entries_of_third + 3, "another metric");
    let page = run(&project, &["--set", "output=[\"out/{pose}.obj\", out/r.html]"]);
    assert_eq!(judged(&page), judged(&third), "pictures change no figure");
}
