//! The program of this package knows its stages as well as those that mimesh brings.

use std::{io::Write, path::Path, process::Command};

use tempfile::TempDir;

/// The exit status of the program and what it printed.
struct Output {
    status: i32,
    stdout: String,
    stderr: String,
}

fn temporary() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Runs the program in the folder of this package, with a cache of its own.
fn program(arguments: &[&str]) -> Output {
    run_with_cache(Path::new(env!("CARGO_BIN_EXE_own-plugin")), temporary().path(), arguments)
}

fn run_with_cache(program: &Path, cache: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(program);
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env("MIMESH_CACHE", cache).args(arguments);
    let output = command.output().expect("the program runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    Output { status: output.status.code().unwrap_or(-1), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn all_stages_are_listed_shown_and_in_the_schema() {
    let list = program(&["list"]).stdout;
    let schema = program(&["schema"]).stdout;
    for (stage, name, bundled) in [
        ("sampler", "curvature", "farthest_point"),
        ("weights", "inverse_distance", "harmonic"),
        ("transfer", "exaggerate", "gradient"),
    ] {
        for name in [name, bundled] {
            assert!(list.contains(&format!("\n  {name} ")), "{name} in {list}");
            assert!(schema.contains(&format!("\"const\": \"{name}\"")), "{name} in the schema");
        }
        let shown = program(&["show", stage, name]);
        assert_eq!(shown.status, 0, "{}", shown.stderr);
        assert!(shown.stdout.starts_with(&format!("{stage} {name}\n")), "{}", shown.stdout);
        assert!(shown.stdout.contains("default"), "{}", shown.stdout);
    }
}

#[test]
fn the_pipeline_runs_with_all_three() {
    let out = temporary();
    let output = program(&["run", "pipeline.yaml", "--out", &out.path().to_string_lossy()]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(output.stdout.contains("exaggerate"), "{}", output.stdout);
    let files = std::fs::read_dir(out.path()).expect("the folder").map(|entry| entry.expect("an entry").path());
    assert_eq!(files.filter(|file| file.extension().is_some_and(|e| e == "obj")).count(), 6, "{}", output.stdout);
}

#[test]
fn key_points_are_chosen_with_the_own_sampler_and_weights() {
    let out = temporary();
    let markers = out.path().join("own.markers.yaml");
    let output = program(&["keypoints", "pipeline.yaml", "--output", &markers.to_string_lossy()]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let text = std::fs::read_to_string(markers).expect("the markers");
    // At least the default `min_count`, and no more than the pipeline allows.
    assert!((3..=8).contains(&text.matches("target: null").count()), "{text}");
}

#[test]
fn misspelt_stages_and_settings_are_reported_with_the_nearest_known() {
    for (set, expected) in [
        ("transfer.type=exagerate", "did you mean `exaggerate`?"),
        ("transfer.strenght=1", "did you mean `strength`?"),
        ("transfer.of.weights.type=inverse_distanc", "did you mean `inverse_distance`?"),
        ("key_points.sampler.type=curvatur", "did you mean `curvature`?"),
        ("transfer.of.type=biharmonik", "did you mean `biharmonic`?"),
        ("transfer.strength=11", "0 to 10"),
    ] {
        let output = program(&["check", "pipeline.yaml", "--set", set]);
        assert_eq!(output.status, 78, "{set}: {}", output.stderr);
        assert!(output.stderr.contains(expected), "{set}: {}", output.stderr);
    }
}

/// Who edits a stage seldom raises its version: results of the program before must not pass for those of the one after.
#[test]
fn another_build_of_the_program_does_not_reuse_results() {
    let (folder, cache) = (temporary(), temporary());
    let build = folder.path().join("program");
    std::fs::copy(env!("CARGO_BIN_EXE_own-plugin"), &build).expect("a copy");
    let run = |arguments: &[&str]| {
        let out = folder.path().join("out");
        run_with_cache(&build, cache.path(), &[arguments, &["pipeline.yaml", "--out", &out.to_string_lossy()]].concat())
    };
    assert_eq!(run(&["run"]).status, 0);
    let plan = run(&["plan"]).stdout;
    assert!(plan.contains("reuse:") && !plan.contains("run"), "{plan}");
    // Bytes after the end of the executable change nothing but its hash.
    let file = std::fs::OpenOptions::new().append(true).open(&build);
    file.expect("the copy").write_all(b"another build").expect("more bytes");
    let plan = run(&["plan"]).stdout;
    assert!(!plan.contains("reuse:") && plan.contains("changed since the last run: program"), "{plan}");
}
