//! Journals that others have put into a folder move and remove nothing elsewhere.

use std::{
    fs,
    path::{Path, PathBuf},
};

use mimesh_document::Kind;
use serde_json::{Value, json};

use super::{survey, write_all};

const IDENTITY: &str = "abcdef012345";

/// A line as journals have them.
fn line(value: &Value) -> String {
    let text = value.to_string();
    format!("{} {text}\n", blake3::hash(text.as_bytes()).to_hex())
}

/// A folder `download` with a journal of these lines in `download/out`, and `home/secret` beside it.
fn planted(lines: &[Value]) -> (tempfile::TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let top = folder.path().canonicalize().unwrap();
    fs::create_dir_all(top.join("download/out")).unwrap();
    fs::create_dir_all(top.join("home")).unwrap();
    let secret = top.join("home/secret");
    fs::write(&secret, "secret").unwrap();
    let text: String = lines.iter().map(line).collect();
    fs::write(journal(&top), text).unwrap();
    (folder, top, secret)
}

fn journal(top: &Path) -> PathBuf {
    top.join(format!("download/out/.mimesh-{IDENTITY}.journal"))
}

fn move_of(place: usize, text: &str, replaces: bool) -> Value {
    let hash = blake3::hash(text.as_bytes()).to_hex().to_string();
    json!({ "place": place, "bytes": text.len(), "blake3": hash, "replaces": replaces })
}

#[test]
fn a_journal_moves_nothing_in_folders_that_have_no_part_in_it() {
    // What was there before is put back, and a new file that is in its place is removed, when a commit is undone.
    for replaces in [true, false] {
        for named in ["../../home/secret", "link/secret", "../out/../../home/secret"] {
            let head = json!({ "mimesh_journal": 1, "started": 0, "places": ["a.obj", named] });
            let moves = json!({ "moves": [move_of(0, "lost", true), move_of(1, "secret", replaces)] });
            for done in [None, Some(json!({ "done": true })), Some(json!({ "done": false }))] {
                let lines: Vec<Value> = [head.clone(), moves.clone()].into_iter().chain(done.clone()).collect();
                let (_folder, top, secret) = planted(&lines);
                #[cfg(unix)]
                std::os::unix::fs::symlink("../../home", top.join("download/out/link")).unwrap();
                fs::write(top.join(format!("home/.mimesh-{IDENTITY}-1.old")), "planted").unwrap();
                let before = names(&top.join("home"));
                let place = top.join("download/out/a.obj");
                let written = write_all(&[(&place, b"new")]);
                assert_eq!(fs::read(&secret).unwrap(), b"secret", "{named}");
                assert_eq!(names(&top.join("home")), before, "{named}");
                // Where only leftovers are to be removed there is nothing to refuse.
                assert_eq!(written.is_err(), done.is_none(), "{named}");
                if let Err(refused) = written {
                    assert_eq!(refused.kind, Kind::CannotWrite);
                    assert!(refused.message.contains("has no part in it, so nothing was moved"), "{refused}");
                    assert!(journal(&top).exists() && !place.exists());
                    assert_eq!(survey([&*place]).refused, [refused]);
                }
            }
        }
    }
}

fn names(folder: &Path) -> Vec<std::ffi::OsString> {
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    names
}

#[test]
fn a_pointer_that_names_another_journal_makes_no_folder_take_part() {
    let head = json!({ "mimesh_journal": 1, "started": 0, "places": ["a.obj", "../../home/secret"] });
    let moves = json!({ "moves": [move_of(0, "lost", true), move_of(1, "secret", false)] });
    let (_folder, top, secret) = planted(&[head, moves]);
    let pointer = line(&json!({ "mimesh_journal_at": format!("../elsewhere/.mimesh-{IDENTITY}.journal") }));
    fs::write(top.join(format!("home/.mimesh-{IDENTITY}.elsewhere")), pointer).unwrap();
    assert!(write_all(&[(&top.join("download/out/a.obj"), b"new")]).is_err());
    assert!(secret.exists());
}

#[test]
fn what_no_transaction_writes_is_left_alone_and_told() {
    let place = |name: &str| json!({ "mimesh_journal": 1, "started": 0, "places": ["a.obj", name] });
    let two = json!({ "mimesh_journal": 2, "started": 0, "places": ["a.obj"] });
    let out_of_range = json!({ "moves": [move_of(7, "x", false)] });
    for lines in [
        vec![two],
        vec![place(".mimesh-0123456789ab.journal")],
        vec![place("/")],
        vec![place("x"), out_of_range],
        vec![place("x"), json!({ "moves": "all" })],
    ] {
        let (_folder, top, _) = planted(&lines);
        let place = top.join("download/out/a.obj");
        let told = write_all(&[(&place, b"new")]).unwrap().warnings.join("\n");
        assert!(told.contains("another version of mimesh wrote this journal, or it was changed"), "{lines:?}: {told}");
        assert!(journal(&top).exists());
        assert_eq!(survey([&*place]).warnings.len(), 1);
    }
}

#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused_at_once() {
    use std::process::Command;
    let (_folder, top, _) = planted(&[]);
    let (journal, place) = (journal(&top), top.join("download/out/a.obj"));
    let refused = |expected: &str| {
        let refused = write_all(&[(&place, b"new")]).unwrap_err();
        assert_eq!(refused.kind, Kind::CannotWrite);
        assert!(refused.to_string().contains(expected) && refused.hint.is_some(), "{refused}");
        assert_eq!(survey([&*place]).refused, [refused]);
        assert!(journal.symlink_metadata().is_ok() && !place.exists());
    };
    fs::File::options().write(true).open(&journal).unwrap().set_len(1 << 40).unwrap();
    refused("it is larger than any journal");
    fs::remove_file(&journal).unwrap();
    assert!(Command::new("mkfifo").arg(&journal).status().unwrap().success());
    refused("it is a pipe");
    fs::remove_file(&journal).unwrap();
    std::os::unix::fs::symlink("/dev/zero", &journal).unwrap();
    refused("it is a link");
    fs::remove_file(&journal).unwrap();
    fs::create_dir(&journal).unwrap();
    refused("is a folder");
}
