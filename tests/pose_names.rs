//! Names of poses that become names of files, and frames that are links.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, diagnostics, json, leaning};

/// A project with a pose `pose-NAME.obj` for each of `names`.
fn with_poses(names: &[&str]) -> Project {
    let project = Project::new();
    names.iter().for_each(|name| project.write(&format!("pose-{name}.obj"), &leaning(0.1)));
    project
}

fn warnings(project: &Project) -> String {
    json(&project.mimesh(&["check", "p.yaml", "--json"]).stdout)["warnings"].to_string()
}

#[test]
fn names_that_windows_reserves_are_replaced_and_told() {
    let project = with_poses(&["CON", "aux.l"]);
    let told = warnings(&project);
    assert!(told.contains("p.yaml:5: output: names of poses"), "{told}");
    assert!(told.contains("`CON` as `CON_.obj`") && told.contains("`aux.l` as `aux_.l.obj`"), "{told}");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert!(project.path("out/CON_.obj").is_file() && project.path("out/aux_.l.obj").is_file());
    project.edit("out/{pose}.obj", "out/pose-{pose}.obj");
    assert!(!warnings(&project).contains("reserved"));
}

// The file systems of Windows and macOS cannot hold such poses in the first place.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_one_elsewhere_are_told_with_their_line() {
    let project = with_poses(&["Smile", "smile", "caf\u{e9}", "cafe\u{301}"]);
    let told = warnings(&project);
    assert!(
        told.contains("p.yaml:5: output: names that differ in capitals alone: `Smile` as `Smile.obj`, `smile` as"),
        "{told}"
    );
    assert!(told.contains("Unicode form alone"), "{told}");
    assert!(
        told.contains(r"caf\\u{e9}.obj`, `cafe\\u{301}.obj`") || told.contains(r"cafe\\u{301}.obj`, `caf\\u{e9}.obj`"),
        "{told}"
    );
    assert!(told.contains("write all of them into one file"), "{told}");
}

#[cfg(target_os = "linux")]
#[test]
fn poses_that_become_one_file_are_refused() {
    let project = with_poses(&["a:b", "a?b"]);
    let found = diagnostics(&project, &[]);
    assert_eq!(found, ["p.yaml:5:9: the poses `a:b` and `a?b` would be written to one file, `a_b.obj`"]);
}

#[test]
fn names_that_no_file_system_takes_are_refused_before_anything_is_computed() {
    // The longest of the poses is called 10. Names of temporary files do not grow with it.
    for (letters, fits) in [(251, true), (252, false), (300, false)] {
        let project = with_poses(&["b"]);
        project.edit("out/{pose}.obj", &format!("out/{}{{pose}}.obj", "x".repeat(letters - 2)));
        let found = diagnostics(&project, &[]);
        assert_eq!(found.is_empty(), fits, "{found:?}");
        if fits {
            let output = project.mimesh(&["run", "p.yaml"]);
            assert!([0, 3].contains(&output.status), "{}", output.stderr);
        } else {
            assert!(found[0].starts_with("p.yaml:5:9: the name `xxxx"), "{found:?}");
            assert!(found[0].contains("bytes; file systems take 255"), "{found:?}");
        }
    }
    let project = with_poses(&["b"]);
    project.edit("out/{pose}.obj", &format!("out/{}.glb", "x".repeat(252)));
    assert!(diagnostics(&project, &[])[0].contains("has 256 bytes"));
}

#[cfg(unix)]
#[test]
fn frames_that_are_links_to_one_file_stay_frames() {
    use std::os::unix::fs::symlink;

    let project = Project::new();
    project.write("first.obj", &leaning(0.1));
    project.write("second.obj", &leaning(0.3));
    for (k, held) in ["rest", "first", "first", "second", "second"].into_iter().enumerate() {
        symlink(project.path(&format!("{held}.obj")), project.path(&format!("frame-{}.obj", k + 1))).expect("a link");
    }
    // A frame that is named twice is one; a link to the rest is a frame that holds it.
    project.edit("poses: pose-*.obj", "poses: [frame-*.obj, frame-2.obj]");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    assert!(!output.stderr.contains("rest mesh"), "{}", output.stderr);
    let report = json(&project.read("out/run.json"));
    let names: Vec<_> = report["poses"].as_array().expect("poses").iter().map(|pose| &pose["name"]).collect();
    assert_eq!(names, ["1", "2", "3", "4", "5"]);
    let result = |name: usize| project.read(&format!("out/{name}.obj"));
    assert_eq!(result(2), result(3));
    assert_eq!(result(4), result(5));
    assert_ne!(result(3), result(4));
    assert_ne!(result(1), result(2));
    project.write("raised.obj", &leaning(0.2));
    // The rest file itself is still left out of a glob.
    project.edit("[frame-*.obj, frame-2.obj]", "[frame-*.obj, r*.obj]");
    assert!(warnings(&project).contains("also matches the rest mesh"), "{}", warnings(&project));
}
