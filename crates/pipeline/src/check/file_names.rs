//! Names of files that some file system refuses or takes for one.

use std::{
    collections::{BTreeMap, HashMap},
    path::PathBuf,
};

use mimesh_document::{At, Step};

use super::findings::{Findings, Scope};
use crate::{
    input::PoseInput,
    placeholder::{POSE, with_pose},
};

/// What every file system in use takes for a name, in bytes.
const MAX_BYTES: usize = 255;

/// Whether the file systems of this machine usually take names that differ in capitals for one.
const IGNORES_CAPITALS: bool = cfg!(any(windows, target_os = "macos"));

/// Finds names of `files`, which the pattern at `at` stands for, that are too long, reserved, or differ in capitals alone.
///
/// What cannot be written here is a diagnostic, and what cannot be written elsewhere a warning.
pub(super) fn check_file_names(
    scope: Scope<'_>,
    found: &mut Findings,
    poses: &[PoseInput],
    files: &[PathBuf],
    at: &[Step],
) {
    let names: Vec<String> =
        files.iter().filter_map(|file| file.file_name()).map(|name| name.to_string_lossy().into_owned()).collect();
    if let Some(long) = names.iter().find(|name| name.len() > MAX_BYTES) {
        let start: String = long.chars().take(40).collect();
        let message =
            format!("the name `{start}…` has {} bytes, more than the {MAX_BYTES} of file systems", long.len());
        found.wrong(scope, at, At::Value, message, "give the pose a shorter name, or write all poses into one file");
    }
    warn_of_replaced(found, poses);
    let reserved: Vec<&str> = names.iter().map(String::as_str).filter(|name| is_reserved(name)).collect();
    if !reserved.is_empty() {
        let message = format!("names that Windows reserves: {}", listed(&reserved));
        let hint = "rename the poses, or put letters before `{pose}`, e.g. `pose-{pose}.obj`";
        report(scope, found, at, message, hint, cfg!(windows));
    }
    for same in alike(&names).values() {
        let message = format!("names that differ in capitals alone: {}", listed(same));
        let hint =
            "on Windows and macOS one would replace the other: rename the poses, or write all of them into one file";
        report(scope, found, at, message, hint, IGNORES_CAPITALS);
    }
}

/// Tells which poses are called otherwise in names of files.
fn warn_of_replaced(found: &mut Findings, poses: &[PoseInput]) {
    let replaced = poses.iter().map(|pose| (&pose.name, with_pose(POSE, &pose.name))).filter(|(old, new)| *old != new);
    let replaced: Vec<String> = replaced.map(|(old, new)| format!("`{old}` as `{new}`")).collect();
    if let Some(first) = replaced.first() {
        let more = if replaced.len() > 1 { format!(" and {} more", replaced.len() - 1) } else { String::new() };
        found.warnings.push(format!("output: names of poses have characters that files cannot have: {first}{more}"));
    }
}

/// Adds a diagnostic if `is_wrong`, else a warning.
fn report(scope: Scope<'_>, found: &mut Findings, at: &[Step], message: String, hint: &str, is_wrong: bool) {
    if is_wrong {
        found.wrong(scope, at, At::Value, message, hint);
    } else {
        found.warnings.push(format!("output: {message}; {hint}"));
    }
}

/// Names that are equal in small letters, at least two of them, by these letters.
fn alike(names: &[String]) -> BTreeMap<String, Vec<&str>> {
    let mut by_letters: HashMap<String, Vec<&str>> = HashMap::new();
    for name in names {
        let same = by_letters.entry(name.to_lowercase()).or_default();
        // Equal names are written twice, which has a diagnostic of its own.
        if !same.contains(&name.as_str()) {
            same.push(name);
        }
    }
    by_letters.into_iter().filter(|(_, same)| same.len() > 1).collect()
}

/// Whether Windows refuses the name of a file: a device of that name, with any extension, or a dot or blank at the end.
fn is_reserved(name: &str) -> bool {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_uppercase();
    let is_device = matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL");
    let numbered = ["COM", "LPT"].iter().filter_map(|device| stem.strip_prefix(device));
    let is_port = numbered.into_iter().any(|number| matches!(number.as_bytes(), [b'1'..=b'9']));
    is_device || is_port || name.ends_with(['.', ' '])
}

fn listed(names: &[&str]) -> String {
    let more = if names.len() > 5 { ", …" } else { "" };
    let quoted: Vec<_> = names.iter().take(5).map(|name| format!("`{name}`")).collect();
    format!("{}{more}", quoted.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_are_reserved_with_any_extension() {
        for reserved in ["con.obj", "NUL", "Aux.tar.gz", "com1.ply", "LPT9.obj", "a.", "b "] {
            assert!(is_reserved(reserved), "{reserved}");
        }
        for fine in ["cone.obj", "com0.obj", "com10.obj", "a.con", ".con.obj"] {
            assert!(!is_reserved(fine), "{fine}");
        }
    }

    #[test]
    fn names_that_differ_in_capitals_are_alike() {
        let names = ["Smile.obj", "smile.obj", "frown.obj", "Frown2.obj", "frown.obj"].map(str::to_owned);
        assert_eq!(alike(&names).into_values().collect::<Vec<_>>(), [["Smile.obj", "smile.obj"]]);
    }
}
