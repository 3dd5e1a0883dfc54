//! `mimesh new plugin`: what it writes and what it refuses. `tests/adding_a_stage.sh` builds what it writes.
#![cfg(feature = "bundled")]

mod common;

use common::Project;

#[test]
fn a_crate_is_written_whole() {
    let project = Project::new();
    let output = project.mimesh(&["new", "plugin", "ridge-points", "--stage", "sampler"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(
        output.stdout.contains("cd ridge-points") && output.stdout.contains("keypoints pipeline.yaml"),
        "{}",
        output.stdout
    );
    assert_eq!(
        project.names("ridge-points"),
        [".gitignore", "Cargo.lock", "Cargo.toml", "README.md", "pipeline.yaml", "src", "tests"]
    );
    let library = project.read("ridge-points/src/lib.rs");
    assert!(library.contains("register!(Sampler: RidgePoints);") && library.contains("name = \"ridge_points\""));
    assert!(project.read("ridge-points/src/main.rs").starts_with("use ridge_points as _;\n"));
    assert!(project.read("ridge-points/tests/contracts.rs").contains("keeps(\"sampler\", \"ridge_points\")"));
    let manifest = project.read("ridge-points/Cargo.toml");
    assert!(manifest.contains("name = \"ridge-points\"") && manifest.contains("\n[workspace]\n"), "{manifest}");
    assert!(manifest.contains("\nserde = { version") && !manifest.contains("rayon"), "{manifest}");
    // cargo builds all dependencies again for another profile, which takes minutes.
    let profile = |manifest: &str| {
        let (_, rest) = manifest.split_once("[profile.release]\n").expect("a release profile");
        rest.lines().next().map(str::to_owned)
    };
    assert_eq!(profile(&manifest), profile(include_str!("../Cargo.toml")));
}

#[test]
fn the_folder_of_mimesh_may_be_given_and_is_written_as_it_is_found_from_anywhere() {
    let project = Project::new();
    let source = env!("CARGO_MANIFEST_DIR");
    let given = ["new", "plugin", "ridges", "--path", "here/ridges", "--mimesh", source];
    let output = project.mimesh(&given);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let manifest = project.read("here/ridges/Cargo.toml");
    assert!(manifest.contains(&format!("mimesh = {{ path = {} }}", serde_json::json!(source))), "{manifest}");
    assert!(project.read("here/ridges/src/lib.rs").contains("register!(Transfer: Ridges);"), "a transfer by default");

    let output = project.mimesh(&["new", "plugin", "others", "--mimesh", "here"]);
    assert_eq!(output.status, 66);
    assert!(
        output.stderr.contains("here: is not the source of mimesh") && output.stderr.contains("cloned into"),
        "{}",
        output.stderr
    );
    assert!(!project.has("others"));
}

#[test]
fn nothing_is_overwritten() {
    let project = Project::new();
    project.write("ridges/notes.txt", "mine");
    let output = project.mimesh(&["new", "plugin", "ridges"]);
    assert_eq!(output.status, 73);
    assert_eq!(
        output.stderr,
        "error: ridges: exists already\n  hint: nothing is overwritten; give another folder with `--path DIR`\n"
    );
    assert_eq!(project.names("ridges"), ["notes.txt"]);
    std::fs::create_dir(project.path("empty")).expect("a folder");
    assert_eq!(project.mimesh(&["new", "plugin", "ridges", "--path", "empty"]).status, 0, "an empty folder will do");
}

#[test]
fn names_that_cannot_be_are_refused_with_one_that_can() {
    let project = Project::new();
    for (name, stage, message, hint) in [
        ("RidgePoints", "sampler", "cannot name a crate", "e.g. `ridge-points`"),
        ("../ridges", "sampler", "cannot name a crate", "e.g. `ridges`"),
        ("", "sampler", "cannot name a crate", "e.g. `my-sampler`"),
        ("match", "sampler", "has a meaning of its own", "e.g. `my-match`"),
        ("serde", "sampler", "has a meaning of its own", "e.g. `my-serde`"),
        ("surface", "sampler", "has a meaning of its own", "e.g. `my-surface`"),
        ("poisson-disk", "sampler", "there is a sampler `poisson_disk` already", "`mimesh list`"),
    ] {
        let output = project.mimesh(&["new", "plugin", name, "--stage", stage]);
        assert_eq!(output.status, 2, "{name}: {}", output.stderr);
        assert!(output.stderr.contains(message) && output.stderr.contains(hint), "{name}: {}", output.stderr);
        assert!(name.is_empty() || name.starts_with("..") || !project.has(name), "{name}");
    }
    let output = project.mimesh(&["new", "plugin", "ridges", "--stage", "samplr"]);
    assert!(output.status == 2 && output.stderr.contains("'sampler'"), "{}", output.stderr);
}
