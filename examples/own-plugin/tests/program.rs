//! The program of this package knows its stages as well as those that mimesh brings.

use std::{
    path::PathBuf,
    process::{Command, Output},
};

const FOLDER: &str = env!("CARGO_MANIFEST_DIR");

/// What the program says: exit status, stdout, stderr.
fn program(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_own-plugin"));
    let Output { status, stdout, stderr } = command.current_dir(FOLDER).args(arguments).output().expect("it starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (status.code().unwrap_or(-1), text(stdout), text(stderr))
}

/// A folder for results of a test.
fn folder(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn all_stages_are_listed_shown_and_in_the_schema() {
    let (_, list, _) = program(&["list"]);
    let (_, schema, _) = program(&["schema"]);
    for (stage, name, bundled) in [
        ("sampler", "curvature", "farthest_point"),
        ("weights", "inverse_distance", "harmonic"),
        ("transfer", "exaggerate", "gradient"),
    ] {
        for name in [name, bundled] {
            assert!(list.contains(&format!("\n  {name} ")), "{name} in {list}");
            assert!(schema.contains(&format!("\"const\": \"{name}\"")), "{name} in the schema");
        }
        let (status, page, _) = program(&["show", stage, name]);
        assert!(status == 0 && page.starts_with(&format!("{stage} {name}\n")) && page.contains("default"), "{page}");
    }
}

#[test]
fn the_pipeline_runs_with_all_three() {
    let out = folder("run");
    let (status, said, error) = program(&["run", "pipeline.yaml", "--out", &out.to_string_lossy()]);
    assert_eq!(status, 0, "{error}");
    assert!(said.contains("exaggerate"), "{said}");
    let poses = std::fs::read_dir(out).expect("the folder").filter(|entry| {
        entry.as_ref().is_ok_and(|entry| entry.path().extension().is_some_and(|extension| extension == "obj"))
    });
    assert_eq!(poses.count(), 6, "{said}");
}

#[test]
fn key_points_are_chosen_with_the_own_sampler_and_weights() {
    let markers = folder("own.markers.yaml");
    let given = ["keypoints", "pipeline.yaml", "--force", "--output", &markers.to_string_lossy()];
    let (status, _, error) = program(&given);
    assert_eq!(status, 0, "{error}");
    let text = std::fs::read_to_string(markers).expect("the markers");
    // The error falls below the threshold with fewer points than are allowed.
    assert!((3..=8).contains(&text.matches("target: null").count()), "{text}");
}

#[test]
fn misspelt_stages_and_settings_are_told_with_what_was_meant() {
    for (set, meant) in [
        ("transfer.type=exagerate", "did you mean `exaggerate`?"),
        ("transfer.strenght=1", "did you mean `strength`?"),
        ("transfer.of.weights.type=inverse_distanc", "did you mean `inverse_distance`?"),
        ("key_points.sampler.type=curvatur", "did you mean `curvature`?"),
        ("transfer.of.type=biharmonik", "did you mean `biharmonic`?"),
        ("transfer.strength=11", "0 to 10"),
    ] {
        let (status, _, error) = program(&["check", "pipeline.yaml", "--set", set]);
        assert_eq!(status, 78, "{set}: {error}");
        assert!(error.contains(meant), "{set}: {error}");
    }
}
