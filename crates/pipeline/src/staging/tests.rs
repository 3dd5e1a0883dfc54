//! A process dies, or a step fails, at each step of moving files: all are new or all are old afterwards.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

use super::{
    Interrupted, Staged, Transaction,
    disk::fault::{self, Fault},
    interrupted, write, write_all,
};
use mimesh_document::Kind;

/// The variables that tell a child of a test what to do.
const FOLDER: &str = "MIMESH_TEST_FOLDER";
const STEP: &str = "MIMESH_TEST_STEP";

/// The files of the tests: two folders, one that is new, one file that is new, and the last that tells what the others are.
const PLACES: [&str; 5] = ["a/1.obj", "a/2.obj", "b/1.obj", "b/new/1.obj", "a/run.json"];

fn places(folder: &Path) -> Vec<PathBuf> {
    PLACES.iter().map(|place| folder.join(place)).collect()
}

/// What a set of files holds.
fn contents(place: &Path, set: &str) -> String {
    format!("{set} {}", place.file_name().unwrap_or_default().to_string_lossy())
}

/// All but the last folder hold old files.
fn old_set(folder: &Path) -> BTreeMap<PathBuf, String> {
    for place in places(folder).iter().filter(|place| !place.to_string_lossy().contains("new")) {
        fs::create_dir_all(place.parent().unwrap()).unwrap();
        fs::write(place, contents(place, "old")).unwrap();
    }
    files(folder)
}

fn new_set(folder: &Path) -> BTreeMap<PathBuf, String> {
    places(folder).into_iter().map(|place| (place.clone(), contents(&place, "new"))).collect()
}

/// Every file below `folder`.
fn files(folder: &Path) -> BTreeMap<PathBuf, String> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => _ = found.insert(path.clone(), fs::read_to_string(&path).unwrap()),
        }
    }
    found
}

/// Writes the new set.
fn commit(folder: &Path) -> Result<(), mimesh_document::Diagnostic> {
    let places = places(folder);
    let transaction = Transaction::begin(places.iter().map(PathBuf::as_path))?;
    let staged: Result<Vec<Staged>, _> =
        places.iter().map(|place| transaction.stage_bytes(place, contents(place, "new").as_bytes())).collect();
    transaction.commit(staged?).map(drop)
}

/// The next run of the same outputs, which ends before it writes anything.
fn next_run(folder: &Path) {
    let places = places(folder);
    drop(Transaction::begin(places.iter().map(PathBuf::as_path)).unwrap());
}

/// Not a test: the process that dies, when a test starts it.
#[test]
fn a_child_that_dies() {
    let (Some(folder), Ok(step)) = (std::env::var_os(FOLDER), std::env::var(STEP)) else { return };
    fault::plan(Some((step.parse().unwrap(), Fault::Dies)));
    commit(Path::new(&folder)).unwrap();
}

#[test]
fn a_process_that_dies_at_any_step_leaves_a_set_that_the_next_run_makes_whole() {
    let counted = tempfile::tempdir().unwrap();
    old_set(counted.path());
    fault::plan(None);
    commit(counted.path()).unwrap();
    let steps = fault::steps();
    assert_eq!(files(counted.path()), new_set(counted.path()));
    assert!(steps > 3 * PLACES.len(), "{steps}");

    let mut kept_old = 0;
    for step in 0..=steps {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (old_set(folder.path()), new_set(folder.path()));
        let status = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "staging::tests::a_child_that_dies", "--test-threads=1"])
            .env(FOLDER, folder.path())
            .env(STEP, step.to_string())
            .output()
            .unwrap()
            .status;
        assert_eq!(status.success(), step == steps, "step {step}");

        let places = places(folder.path());
        let told = interrupted(places.iter().map(PathBuf::as_path));
        let mixed =
            files(folder.path()).into_iter().filter(|(path, _)| places.contains(path)).collect::<BTreeMap<_, _>>();
        if mixed != old && mixed != new {
            assert!(matches!(told[..], [(_, Interrupted::Moving { .. })]), "a set that is mixed is told: {told:?}");
        }
        next_run(folder.path());
        let after = files(folder.path());
        assert!(after == old || after == new, "step {step} of {steps}: {:?}", after.keys());
        kept_old += usize::from(after == old);
        assert!(interrupted(places.iter().map(PathBuf::as_path)).is_empty());
    }
    assert!(kept_old > PLACES.len() && kept_old < steps, "both ends are met: {kept_old} of {steps}");
}

#[test]
fn a_step_that_fails_leaves_the_old_set_or_the_new_one_and_nothing_else() {
    let counted = tempfile::tempdir().unwrap();
    old_set(counted.path());
    fault::plan(None);
    commit(counted.path()).unwrap();
    let steps = fault::steps();
    for step in 0..steps {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (old_set(folder.path()), new_set(folder.path()));
        fault::plan(Some((step, Fault::Fails)));
        let done = commit(folder.path());
        fault::plan(None);
        let found = files(folder.path());
        let expected = if done.is_ok() { &new } else { &old };
        let of_places = |set: &BTreeMap<PathBuf, String>| {
            set.iter()
                .filter(|(path, _)| places(folder.path()).contains(path))
                .map(|(p, b)| (p.clone(), b.clone()))
                .collect::<BTreeMap<_, _>>()
        };
        assert_eq!(of_places(&found), *expected, "step {step}: {done:?}");
        if done.is_err() {
            assert_eq!(found, old, "step {step}: nothing else is left");
            assert!(!folder.path().join("b/new").exists(), "step {step}: a folder that was made is gone");
        }
        next_run(folder.path());
        assert_eq!(files(folder.path()), *expected);
    }
}

#[test]
fn files_of_another_process_are_never_touched_and_the_second_writer_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = (folder.path().join("1"), folder.path().join("2"));
    let first = Transaction::begin([&*one]).unwrap();
    let staged = first.stage_bytes(&one, b"first").unwrap();
    let refused = Transaction::begin([&*two, &*one]).unwrap_err();
    assert_eq!(refused.kind, Kind::Busy);
    let told = refused.to_string();
    assert!(told.contains("another process is writing this file, since a moment ago") && told.contains("1:"), "{told}");
    assert_eq!(interrupted([&*one]), [(one.canonicalize().unwrap_or(one.clone()), Interrupted::Alive)]);
    write(&two, b"second").unwrap();
    first.commit(vec![staged]).unwrap();
    assert_eq!(files(folder.path()), BTreeMap::from([(one, "first".into()), (two, "second".into())]));
}

#[test]
fn a_file_is_in_its_place_only_after_the_commit_with_size_and_hash() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("new/a.txt");
    let transaction = Transaction::begin([&*place]).unwrap();
    let staged = transaction.stage_bytes(&place, b"abc").unwrap();
    assert!(!place.exists());
    let written = transaction.commit(vec![staged]).unwrap();
    assert_eq!((written[0].bytes, &*written[0].blake3), (3, blake3::hash(b"abc").to_hex().as_str()));
    assert_eq!(files(folder.path()), BTreeMap::from([(place, "abc".into())]));
}

#[test]
fn a_failure_while_writing_leaves_nothing_and_keeps_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let (old, new) = (folder.path().join("a.txt"), folder.path().join("b/c/d.txt"));
    fs::write(&old, "old").unwrap();
    let transaction = Transaction::begin([&*old, &*new]).unwrap();
    let failed = transaction.stage(&old, |out| {
        let _ = out.write_all(&[0; 100_000]);
        Err(mimesh_core::Error::data("no", ""))
    });
    assert!(failed.is_err());
    drop(transaction);
    assert_eq!(files(folder.path()), BTreeMap::from([(old, "old".into())]));
    assert!(!folder.path().join("b").exists(), "folders that were made go, too");
}

#[test]
fn a_name_may_be_as_long_as_the_file_system_takes() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("x".repeat(255));
    write(&place, b"1").unwrap();
    assert_eq!(fs::read(&place).unwrap(), b"1");
}

#[cfg(unix)]
#[test]
fn links_stay_links_and_permissions_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("file", &link).unwrap();
    let other = folder.path().join("other");
    write_all(&[(&link, b"new"), (&other, b"2")]).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    assert_eq!(files(folder.path()).len(), 3);
}

#[test]
fn a_journal_that_was_just_made_when_its_writer_died_is_removed_and_one_of_another_version_stays() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("a");
    let [empty, cut, other] = ["000000000000", "111111111111", "222222222222"]
        .map(|identity| folder.path().join(format!(".mimesh-{identity}.journal")));
    fs::write(&empty, "").unwrap();
    fs::write(&cut, "0123456789abcdef").unwrap();
    fs::write(&other, "another layout\n").unwrap();
    write(&place, b"1").unwrap();
    assert_eq!(files(folder.path()).keys().collect::<Vec<_>>(), [&other, &place]);
}

#[cfg(unix)]
#[test]
fn names_that_are_no_unicode_are_written_and_recovered() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join(std::ffi::OsStr::from_bytes(b"a\xff.obj"));
    let transaction = Transaction::begin([&*place]).unwrap();
    assert_eq!(interrupted([&*place]).len(), 1);
    let staged = transaction.stage_bytes(&place, b"1").unwrap();
    transaction.commit(vec![staged]).unwrap();
    assert_eq!(fs::read(&place).unwrap(), b"1");
}
