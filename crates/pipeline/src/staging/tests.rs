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
    survey, write_all,
};
use mimesh_document::{Diagnostic, Kind};

/// The variables that tell a child of a test what to do.
const FOLDER: &str = "MIMESH_TEST_FOLDER";
const STEP: &str = "MIMESH_TEST_STEP";

/// The files of the tests: two folders, one that is new, one file that is new, and the last that tells what the others are.
const PLACES: [&str; 5] = ["a/1.obj", "a/2.obj", "b/1.obj", "b/new/1.obj", "a/run.json"];

/// The transactions that write one of `places`.
fn interrupted<'p>(places: impl IntoIterator<Item = &'p Path>) -> Vec<(PathBuf, Interrupted)> {
    survey(places).interrupted
}

/// Writes one file.
fn write(place: &Path, bytes: &[u8]) -> Result<(), Diagnostic> {
    write_all(&[(place, bytes)]).map(drop)
}

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
fn commit(folder: &Path) -> Result<(), Diagnostic> {
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

/// Lets a process write the new set and die at a step; whether it came to its end before.
fn die_at(folder: &Path, step: usize) -> bool {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "staging::tests::a_child_that_dies", "--test-threads=1"]);
    child.env(FOLDER, folder).env(STEP, step.to_string()).output().unwrap().status.success()
}

/// How many steps the new set takes.
fn count_steps() -> usize {
    let counted = tempfile::tempdir().unwrap();
    old_set(counted.path());
    fault::plan(None);
    commit(counted.path()).unwrap();
    assert_eq!(files(counted.path()), new_set(counted.path()));
    fault::steps()
}

#[test]
fn a_process_that_dies_at_any_step_leaves_a_set_that_the_next_run_makes_whole() {
    let steps = count_steps();
    assert!(steps > 3 * PLACES.len(), "{steps}");

    let mut kept_old = 0;
    for step in 0..=steps {
        let folder = tempfile::tempdir().unwrap();
        let (old, new) = (old_set(folder.path()), new_set(folder.path()));
        assert_eq!(die_at(folder.path(), step), step == steps, "step {step}");

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

/// Somebody edits a result after a process has died, at whatever step.
#[test]
fn what_is_edited_after_a_process_has_died_is_never_lost() {
    let steps = count_steps();
    let (mut beside, mut in_place) = (0, 0);
    for step in 0..steps {
        // A new file, one that is replaced, and the last.
        for edited in ["a/1.obj", "b/new/1.obj", "a/run.json"] {
            let folder = tempfile::tempdir().unwrap();
            let (old, new) = (old_set(folder.path()), new_set(folder.path()));
            die_at(folder.path(), step);
            let edited = folder.path().join(edited);
            fs::create_dir_all(edited.parent().unwrap()).unwrap();
            fs::write(&edited, "by hand").unwrap();
            let places = places(folder.path());
            let told = Transaction::begin(places.iter().map(PathBuf::as_path)).unwrap().warnings().join("\n");
            let mut after = files(folder.path());
            let aside = after.remove(&PathBuf::from(format!("{}.edited", edited.display())));
            if after.get(&edited).is_some_and(|text| text == "by hand") {
                in_place += 1;
                after.remove(&edited);
            } else {
                assert_eq!(aside.as_deref(), Some("by hand"), "step {step}: {told}");
                assert!(told.contains(".edited") && told.contains("was edited"), "step {step}: {told}");
                beside += 1;
            }
            let of_set = |set: &BTreeMap<PathBuf, String>| after.iter().all(|(path, text)| set.get(path) == Some(text));
            assert!(of_set(&old) || of_set(&new), "step {step}: the other files are of one set: {after:?}");
        }
    }
    assert!(beside > PLACES.len() && in_place > PLACES.len(), "{beside} {in_place}");
}

#[test]
fn a_temporary_file_that_is_gone_ends_the_commit_as_it_began() {
    for gone in 0..PLACES.len() {
        let folder = tempfile::tempdir().unwrap();
        let old = old_set(folder.path());
        let places = places(folder.path());
        let transaction = Transaction::begin(places.iter().map(PathBuf::as_path)).unwrap();
        let staged: Vec<Staged> = places
            .iter()
            .map(|place| transaction.stage_bytes(place, contents(place, "new").as_bytes()).unwrap())
            .collect();
        fs::remove_file(&staged[gone].part).unwrap();
        let refused = transaction.commit(staged).unwrap_err();
        assert_eq!(refused.kind, Kind::CannotWrite);
        assert!(refused.message.contains("its temporary file was removed or changed"), "{refused}");
        assert_eq!(files(folder.path()), old);
    }
}

#[cfg(unix)]
#[test]
fn a_journal_that_is_gone_ends_the_commit_as_it_began() {
    let folder = tempfile::tempdir().unwrap();
    let old = old_set(folder.path());
    let places = places(folder.path());
    let transaction = Transaction::begin(places.iter().map(PathBuf::as_path)).unwrap();
    let staged: Vec<Staged> = places.iter().map(|place| transaction.stage_bytes(place, b"new").unwrap()).collect();
    let is_journal = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == "journal");
    fs::remove_file(files(folder.path()).keys().find(is_journal).unwrap()).unwrap();
    let refused = transaction.commit(staged).unwrap_err();
    assert!(refused.message.contains("the journal of this run was removed"), "{refused}");
    assert_eq!(files(folder.path()), old);
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_renamed_meanwhile_ends_the_commit_and_the_next_run_there_clears_up() {
    let folder = tempfile::tempdir().unwrap();
    let (out, moved) = (folder.path().join("out"), folder.path().join("moved"));
    let (one, two) = (out.join("1"), out.join("2"));
    write_all(&[(&one, b"old"), (&two, b"old")]).unwrap();
    let transaction = Transaction::begin([&*one, &*two]).unwrap();
    let staged = vec![transaction.stage_bytes(&one, b"new").unwrap(), transaction.stage_bytes(&two, b"new").unwrap()];
    fs::rename(&out, &moved).unwrap();
    fs::create_dir(&out).unwrap();
    assert_eq!(transaction.commit(staged).unwrap_err().kind, Kind::CannotWrite);
    assert_eq!(files(&out), BTreeMap::new());
    let old = [(moved.join("1"), "old".to_owned()), (moved.join("2"), "old".to_owned())].into();
    drop(Transaction::begin([&*moved.join("1")]).unwrap());
    assert_eq!(files(&moved), old);
}

#[test]
fn a_step_that_fails_leaves_the_old_set_or_the_new_one_and_nothing_else() {
    for step in 0..count_steps() {
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
    let told = write_all(&[(&place, b"1")]).unwrap().warnings.join("\n");
    assert_eq!(files(folder.path()).keys().collect::<Vec<_>>(), [&other, &place]);
    assert!(told.contains("another version of mimesh wrote this journal") && told.contains("222222222222"), "{told}");
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
