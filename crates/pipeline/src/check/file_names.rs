//! Names of files that some file system refuses or takes for one.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use icu_normalizer::ComposingNormalizerBorrowed;
use mimesh_document::{At, Location, Step};

use super::findings::{Findings, Scope};
use crate::{
    input::PoseInput,
    placeholder::{MAX_NAME, POSE, is_reserved},
};

/// Names in a message about many.
const MAX_LISTED: usize = 5;

/// Whether the file systems of this machine usually take names that differ in capitals for one.
const IGNORES_CAPITALS: bool = cfg!(any(windows, target_os = "macos"));

/// Whether the file systems of this machine take the Unicode forms of a name for one.
const IGNORES_FORM: bool = cfg!(target_os = "macos");

/// Finds names of `files`, which `pattern` at `at` stands for, that are too long, reserved, or one name on some system.
///
/// What cannot be written here is a diagnostic, and what cannot be written elsewhere a warning. `false` if there is a diagnostic.
pub(super) fn check_file_names(
    scope: Scope<'_>,
    found: &mut Findings,
    poses: &[PoseInput],
    pattern: &Path,
    files: &[PathBuf],
    at: &[Step],
) -> bool {
    let before = found.diagnostics.len();
    let names: Vec<String> =
        files.iter().map(|file| file.file_name().unwrap_or_default().to_string_lossy().into_owned()).collect();
    if let Some((long, pose)) = names.iter().zip(poses).find(|(name, _)| name.len() > MAX_NAME) {
        let message = too_long(long);
        let hint = match pose.name.len() > MAX_NAME / 2 {
            true => "give the pose a shorter name where it comes from, or write all poses into one file",
            false => "write a shorter pattern, e.g. `out/{pose}.obj`",
        };
        found.wrong(scope, at, At::Value, message, hint);
    }
    let pattern = pattern.file_name().unwrap_or_default().to_string_lossy();
    let replaced = poses.iter().zip(&names).filter(|(pose, name)| pattern.replace(POSE, &pose.name) != **name);
    let replaced: Vec<String> = replaced.map(|(pose, name)| format!("`{}` as `{name}`", pose.name)).collect();
    if !replaced.is_empty() {
        let more = if replaced.len() > MAX_LISTED { ", …" } else { "" };
        let (place, some) = (place(scope, at), replaced.iter().take(MAX_LISTED).map(String::as_str));
        found.warnings.push(format!(
            "{place}: names of poses have characters that files cannot have, or are reserved by Windows: {}{more}",
            some.collect::<Vec<_>>().join(", ")
        ));
    }
    let reserved: Vec<&str> = names.iter().map(String::as_str).filter(|name| is_reserved(name)).collect();
    if !reserved.is_empty() {
        let message = format!("names that Windows reserves: {}", listed(&reserved));
        report(scope, found, at, message, "write other letters before `{pose}`, e.g. `pose-{pose}.obj`", cfg!(windows));
    }
    for same in alike(&names) {
        report_alike(scope, found, poses, &names, &same, at);
    }
    found.diagnostics.len() == before
}

/// What is wrong with the name `long` of a file, in words.
pub(super) fn too_long(long: &str) -> String {
    let start: String = long.chars().take(40).collect();
    let bytes = long.len();
    format!("the name `{start}…` has {bytes} bytes; file systems take {MAX_NAME}")
}

/// Reports files, by number, whose `names` are equal or are taken for one by some system.
fn report_alike(
    scope: Scope<'_>,
    found: &mut Findings,
    poses: &[PoseInput],
    names: &[String],
    same: &[usize],
    at: &[Step],
) {
    const RENAME: &str = "rename the poses where they come from, or write all of them into one file";
    let all = |name: &dyn Fn(usize) -> String| listed(&same.iter().map(|&i| name(i)).collect::<Vec<_>>());
    let first = same[0];
    let poses_and_files = || {
        let pairs = same.iter().map(|&i| format!("`{}` as `{}`", poses[i].name, names[i]));
        pairs.take(MAX_LISTED).collect::<Vec<_>>().join(", ")
    };
    if let Some(&twin) = same[1..].iter().find(|&&i| names[i] == names[first]) {
        let message = format!(
            "the poses `{}` and `{}` would be written to one file, `{}`",
            poses[first].name, poses[twin].name, names[first]
        );
        found.wrong(scope, at, At::Value, message, RENAME);
    } else if same.iter().all(|&i| composed(&names[i]) == composed(&names[first])) {
        let message = format!("names that differ in their Unicode form alone: {}", all(&|i| escaped(&names[i])));
        let hint = format!("on macOS one would replace the other, and they look alike everywhere: {RENAME}");
        report(scope, found, at, message, &hint, IGNORES_FORM);
    } else {
        let message = format!("names that differ in capitals alone: {}", poses_and_files());
        let hint = format!("on Windows and macOS one would replace the other: {RENAME}");
        report(scope, found, at, message, &hint, IGNORES_CAPITALS);
    }
}

/// Adds a diagnostic if `is_wrong`, else a warning.
fn report(scope: Scope<'_>, found: &mut Findings, at: &[Step], message: String, hint: &str, is_wrong: bool) {
    if is_wrong {
        found.wrong(scope, at, At::Value, message, hint);
    } else {
        found.warnings.push(format!("{}: {message}; {hint}", place(scope, at)));
    }
}

/// The place of a value in words: the line of its file.
fn place(scope: Scope<'_>, at: &[Step]) -> String {
    match scope.document.location(at, At::Value) {
        Location::Line { file, line } | Location::Span { file, line, .. } => {
            format!("{}:{line}: output", file.display())
        }
        _ => "output".into(),
    }
}

/// Files, by number, whose names are one name for a system that ignores capitals and Unicode forms: at least two each.
fn alike(names: &[String]) -> Vec<Vec<usize>> {
    let mut by_letters: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (i, name) in names.iter().enumerate() {
        by_letters.entry(composed(&composed(name).to_lowercase())).or_default().push(i);
    }
    let mut all: Vec<_> = by_letters.into_values().filter(|same| same.len() > 1).collect();
    all.sort();
    all
}

/// The name in the composed form of Unicode (NFC).
fn composed(name: &str) -> String {
    ComposingNormalizerBorrowed::new_nfc().normalize(name).into_owned()
}

/// The name with other letters than those of ASCII as their numbers: what looks alike is seen to differ.
fn escaped(name: &str) -> String {
    let letter = |c: char| if c.is_ascii() { c.to_string() } else { c.escape_unicode().to_string() };
    name.chars().map(letter).collect()
}

fn listed<S: AsRef<str>>(names: &[S]) -> String {
    let more = if names.len() > MAX_LISTED { ", …" } else { "" };
    let quoted: Vec<_> = names.iter().take(MAX_LISTED).map(|name| format!("`{}`", name.as_ref())).collect();
    format!("{}{more}", quoted.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_one_on_some_system_are_alike() {
        let names =
            ["Smile.obj", "smile.obj", "frown.obj", "Frown2.obj", "caf\u{e9}.obj", "Cafe\u{301}.obj", "frown.obj"];
        assert_eq!(alike(&names.map(str::to_owned)), [vec![0, 1], vec![2, 6], vec![4, 5]]);
        assert_eq!(composed("cafe\u{301}"), "caf\u{e9}");
        assert_eq!(escaped("e\u{301}"), "e\\u{301}");
    }
}
