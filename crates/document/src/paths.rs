//! Paths: relative to the file that names them, compared, and suggested where they are misspelt.

use std::path::{Component, Path, PathBuf};

use crate::{limits::MAX_STRING_BYTES, suggest::did_you_mean};

/// Files of a folder that are looked at for one with a similar name.
const MAX_LOOKED_AT: usize = 10_000;

/// `path` as seen from the current folder, when it is written in a file in the folder `base`.
pub fn from_base(base: &Path, path: &Path) -> PathBuf {
    if base.as_os_str().is_empty() { path.into() } else { tidy(&base.join(path)) }
}

/// `path` without `.` and without folders that it enters only to leave them with `..`: `a/../b` is `b`.
///
/// What `..` leads to from a link is not what stands before the link, so links are kept, and so is what is no folder.
pub fn tidy(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(result.components().next_back(), Some(Component::Normal(_))) => {
                let folder = result.symlink_metadata().is_ok_and(|found| found.is_dir());
                if !folder || !result.pop() {
                    result.push(part);
                }
            }
            _ => result.push(part),
        }
    }
    if result.as_os_str().is_empty() { ".".into() } else { result }
}

/// The file's name without extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Links in a row that are followed, as Linux does.
const MAX_LINKS: usize = 40;

/// A form of `path` by which two names of one file are seen to be equal.
///
/// Existing files are compared as the system sees them, through links; others by their folder's and their own name. A link to a file
/// that is yet to be made stands for that file.
pub fn identity(path: &Path) -> PathBuf {
    identity_through(path, MAX_LINKS)
}

fn identity_through(path: &Path, links: usize) -> PathBuf {
    // No file has such a path, and its folders are too many to go through.
    if path.as_os_str().len() > MAX_STRING_BYTES {
        return path.into();
    }
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    let folder = || path.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    if links > 0
        && let Ok(aim) = path.read_link()
    {
        return identity_through(&folder().unwrap_or(Path::new("")).join(aim), links - 1);
    }
    let identity = |folder| identity_through(folder, links);
    match (path.components().next_back(), folder()) {
        (Some(Component::Normal(name)), Some(folder)) => identity(folder).join(name),
        // From a folder that is yet to be made, `..` leads back to where it will be.
        (Some(Component::ParentDir), Some(folder)) => {
            let folder = identity(folder);
            folder.parent().map_or(folder.clone(), Path::to_path_buf)
        }
        _ => path.components().filter(|part| *part != Component::CurDir).collect(),
    }
}

/// A form of `path` by which two names of one place in a folder are seen to be equal: links to one file stay different.
pub fn entry_identity(path: &Path) -> PathBuf {
    match (path.symlink_metadata(), path.parent(), path.file_name()) {
        (Ok(found), Some(folder), Some(name)) if found.is_symlink() => {
            identity(if folder.as_os_str().is_empty() { Path::new(".") } else { folder }).join(name)
        }
        // A file system that ignores capitals knows one file by several names.
        _ => identity(path),
    }
}

/// For a hint, the file in the folder of `path` whose name is most like its own.
pub fn similar_file(path: &Path) -> Option<String> {
    if path.components().any(|part| part.as_os_str() == "~") {
        return Some("`~` is not understood here: write the whole path".into());
    }
    let name = path.file_name()?.to_string_lossy().into_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .take(MAX_LOOKED_AT)
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|other| *other != name)
        .collect();
    names.sort();
    did_you_mean(&name, &names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_shown_without_detours_but_links_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| folder.path().join(path);
        std::fs::create_dir_all(at("a/b")).unwrap();
        assert_eq!(tidy(&at("./a/../out/./x.obj")), at("out/x.obj"));
        assert_eq!(tidy(&at("a/b/../../out")), at("out"));
        assert_eq!(tidy(&at("none/../x.obj")), at("none/../x.obj"));
        assert_eq!(from_base(Path::new("."), Path::new("../x.obj")), Path::new("../x.obj"));
        assert_eq!(tidy(Path::new("..//../x")), Path::new("../../x"));
        assert_eq!(
            [".", "", "/..", "/./a"].map(|path| tidy(Path::new(path))),
            [".", ".", "/..", "/a"].map(PathBuf::from)
        );
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("a/b"), at("link")).unwrap();
            assert_eq!(tidy(&at("link/../x.obj")), at("link/../x.obj"));
        }
    }

    #[test]
    fn a_folder_that_is_yet_to_be_made_can_be_left_again() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| identity(&folder.path().join(path));
        assert_eq!(at("new/../out/x.obj"), at("out/x.obj"));
        assert_eq!(at("out/../out/../x.obj"), at("x.obj"));
    }

    #[cfg(unix)]
    #[test]
    fn links_to_a_file_that_is_yet_to_be_made_are_that_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| folder.path().join(path);
        for (link, aim) in [("a", "new.obj"), ("b", "./a"), ("loop", "loop")] {
            std::os::unix::fs::symlink(aim, at(link)).unwrap();
        }
        assert_eq!(identity(&at("a")), identity(&at("new.obj")));
        assert_eq!(identity(&at("b")), identity(&at("a")));
        assert!(identity(&at("loop")).ends_with("loop"));
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_file_are_different_entries() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| folder.path().join(path);
        std::fs::write(at("real"), "").unwrap();
        ["a", "b"].into_iter().for_each(|link| std::os::unix::fs::symlink(at("real"), at(link)).unwrap());
        std::os::unix::fs::symlink(folder.path(), at("here")).unwrap();
        assert_eq!(identity(&at("a")), identity(&at("b")));
        assert_ne!(entry_identity(&at("a")), entry_identity(&at("b")));
        assert_ne!(entry_identity(&at("a")), entry_identity(&at("real")));
        assert_eq!(entry_identity(&at("here/a")), entry_identity(&at("./a")));
        assert_eq!(entry_identity(&at("here/real")), identity(&at("real")));
    }

    #[test]
    fn a_file_that_does_not_exist_is_the_same_by_either_name() {
        let folder = tempfile::tempdir().unwrap();
        let a = identity(&folder.path().join("new/./x.obj"));
        assert_eq!(a, identity(&folder.path().join("./new/x.obj")));
    }
}
