//! Folders that others can write into: what looks like a journal, and journals of other users.

use std::{
    fs,
    os::unix::fs::{PermissionsExt, chown, symlink},
    process::Command,
};

use serde_json::json;

use crate::{common::Project, sets::run, stopped::line};

const JOURNAL: &str = "out/.mimesh-abcdef012345.journal";

/// Checks that `check`, `plan` and `run` refuse at once, for this reason, with a way out; the journal stays.
#[track_caller]
fn assert_refused(project: &Project, reason: &str) {
    let before = project.names("out");
    for command in ["check", "plan", "run"] {
        let output = project.mimesh(&[command, "p.yaml"]);
        assert_eq!(output.status, 73, "{command}: {}", output.stderr);
        assert!(output.stderr.contains(reason) && output.stderr.contains("hint: "), "{command}: {}", output.stderr);
        assert_eq!(output.stderr.matches("error: ").count(), 1, "{command}: {}", output.stderr);
    }
    assert_eq!(project.names("out"), before);
}

#[test]
fn what_has_the_name_of_a_journal_and_is_no_file_is_refused_at_once() {
    let project = Project::new();
    run(&project);
    assert!(Command::new("mkfifo").arg(project.path(JOURNAL)).status().expect("mkfifo").success());
    assert_refused(&project, "it is a pipe");
    fs::remove_file(project.path(JOURNAL)).expect("a pipe");
    symlink("/dev/zero", project.path(JOURNAL)).expect("a link");
    assert_refused(&project, "it is a link");
    fs::remove_file(project.path(JOURNAL)).expect("a link");
    fs::create_dir(project.path(JOURNAL)).expect("a folder");
    assert_refused(&project, "is a folder");
    fs::remove_dir(project.path(JOURNAL)).expect("a folder");
    let huge = fs::File::create(project.path(JOURNAL)).expect("a file");
    huge.set_len(1 << 40).expect("a file with a hole");
    assert_refused(&project, "it is larger than any journal");
}

#[test]
fn a_planted_journal_removes_nothing_elsewhere() {
    let project = Project::new();
    run(&project);
    project.write("home/notes", "mine");
    let hash = blake3::hash(b"mine").to_hex().to_string();
    let moves = json!({ "moves": [
        { "place": 0, "bytes": 1, "blake3": "00", "replaces": true },
        { "place": 1, "bytes": 4, "blake3": hash, "replaces": false },
    ] });
    for named in ["../home/notes".to_owned(), project.path("home/notes").display().to_string()] {
        let head = json!({ "mimesh_journal": 1, "started": 0, "places": ["1.obj", named] });
        project.write(JOURNAL, &(line(&head) + &line(&moves)));
        assert_refused(&project, "which has no part in it, so nothing was moved");
        assert_eq!(project.read("home/notes"), "mine");
    }
    fs::remove_file(project.path(JOURNAL)).expect("a file");
    run(&project);
}

#[test]
fn a_journal_of_another_version_is_left_alone_and_told() {
    let project = Project::new();
    project.write(JOURNAL, &line(&json!({ "mimesh_journal": 99, "all": "new" })));
    for command in ["check", "run"] {
        let output = project.mimesh(&[command, "p.yaml"]);
        assert_eq!(output.status, 0, "{}", output.stderr);
        assert!(output.stderr.contains("another version of mimesh wrote this journal"), "{}", output.stderr);
    }
    assert!(project.has(JOURNAL));
}

/// Nobody gives files away but the superuser.
#[test]
#[ignore = "needs the superuser; .ci/long runs it"]
fn a_journal_of_another_user_is_theirs() {
    const NOBODY: u32 = 65534;
    let project = Project::new();
    run(&project);
    let head = json!({ "mimesh_journal": 1, "started": 0, "places": ["1.obj", "run.json"] });
    project.write(JOURNAL, &line(&head));
    chown(project.path(JOURNAL), Some(NOBODY), None).expect("the superuser");
    assert_refused(&project, "a run of another user (number 65534) was stopped");

    // The same, and the other way round: nobody may read what the superuser keeps.
    chown(project.path(JOURNAL), Some(0), None).expect("the superuser");
    fs::set_permissions(project.path(JOURNAL), fs::Permissions::from_mode(0o600)).expect("a file");
    for folder in [".", "out"] {
        fs::set_permissions(project.path(folder), fs::Permissions::from_mode(0o777)).expect("a folder");
    }
    let as_nobody = |command: &str| {
        let mimesh = project.command(&[command, "p.yaml", "--no-cache"]);
        let mut nobody = Command::new("setpriv");
        nobody
            .args(["--reuid", "65534", "--regid", "65534", "--clear-groups"])
            .arg(mimesh.get_program())
            .args(mimesh.get_args());
        let output = nobody.current_dir(project.path(".")).output().expect("setpriv is installed");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for command in ["check", "run"] {
        let (status, told) = as_nobody(command);
        assert_eq!(status, Some(73), "{told}");
        assert!(told.contains("no permission to read it (of user 0)"), "{told}");
    }
    fs::remove_file(project.path(JOURNAL)).expect("a file");

    // In a folder like /tmp the results of the superuser are not replaced.
    fs::set_permissions(project.path("out"), fs::Permissions::from_mode(0o1777)).expect("a folder");
    let (status, told) = as_nobody("check");
    assert_eq!(status, Some(73), "{told}");
    assert!(told.contains("it belongs to another user (number 0)"), "{told}");
    // One who may write but not look cannot see who else writes there.
    fs::set_permissions(project.path("out"), fs::Permissions::from_mode(0o733)).expect("a folder");
    let (status, told) = as_nobody("check");
    assert!(status == Some(73) && told.contains("no permission to look into out"), "{told}");
}
