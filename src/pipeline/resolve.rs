//! Paths of a pipeline: relative to its file, globs in natural order, names of poses, `{pose}`.

use std::path::{Component, Path, PathBuf};

/// A file found for a glob or a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// The file.
    pub path: PathBuf,
    /// What the wildcards stand for, else the file's name without extension.
    pub name: String,
}

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

/// Whether `pattern` has wildcards.
pub fn is_glob(pattern: &str) -> bool {
    pattern.contains(['*', '?', '['])
}

/// The files that `pattern` stands for, in natural order (`pose-2` before `pose-10`); a path without wildcards is
/// itself.
///
/// # Errors
///
/// What is wrong with the pattern, in words.
pub fn expand(base: &Path, pattern: &str) -> Result<Vec<Found>, String> {
    if !is_glob(pattern) {
        let path = from_base(base, Path::new(pattern));
        return Ok(vec![Found { name: stem(&path), path }]);
    }
    let escaped = glob::Pattern::escape(&base.to_string_lossy());
    let whole = if escaped.is_empty() { pattern.into() } else { from_base(Path::new(&escaped), Path::new(pattern)) };
    let options =
        glob::MatchOptions { require_literal_separator: true, require_literal_leading_dot: true, ..Default::default() };
    let matches = glob::glob_with(&whole.to_string_lossy(), options).map_err(|error| error.msg.to_owned())?;
    let mut paths: Vec<PathBuf> = matches.filter_map(Result::ok).filter(|path| path.is_file()).collect();
    paths.sort_by(|a, b| alphanumeric_sort::compare_path(a, b).then_with(|| a.cmp(b)));
    let tidied = |path: PathBuf| if base.as_os_str().is_empty() { path } else { tidy(&path) };
    Ok(paths.into_iter().map(|path| Found { name: wild_part(pattern, &path), path: tidied(path) }).collect())
}

/// What the wildcards of `pattern` stand for in `path`, from the first to the last of them, without an extension.
fn wild_part(pattern: &str, path: &Path) -> String {
    let without_extension = |text: &str| match (text.rfind('.'), text.rfind(['/', '\\'])) {
        (Some(dot), slash) if slash.is_none_or(|slash| dot > slash + 1) => text[..dot].to_owned(),
        _ => text.to_owned(),
    };
    let whole = without_extension(&path.to_string_lossy());
    let pattern = without_extension(pattern);
    let Some(first) = pattern.find(['*', '?', '[']) else { return stem(path) };
    // The path may begin with the folder of the pipeline, so count what follows the last wildcard from the end, and
    // what precedes the first one from its folder.
    let after = pattern.rfind(['*', '?', ']']).map_or("", |last| &pattern[last + 1..]);
    let folders_after_first = pattern[first..].matches('/').count();
    let starts: Vec<usize> = std::iter::once(0).chain(whole.match_indices('/').map(|(i, _)| i + 1)).collect();
    let before = pattern[..first].rsplit('/').next().unwrap_or_default().len();
    let start = starts[starts.len().saturating_sub(folders_after_first + 1)] + before;
    let end = whole.len().saturating_sub(after.len());
    match whole.get(start..end) {
        Some(part) if !part.is_empty() => part.replace('/', "-"),
        _ => stem(path),
    }
}

/// The file's name without extension.
pub fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// `pattern` with `{pose}` replaced by `name`, in which characters that file systems refuse become `_`.
pub fn with_pose(pattern: &str, name: &str) -> String {
    let safe = |c: char| if c.is_control() || "/\\:*?\"<>|".contains(c) { '_' } else { c };
    pattern.replace("{pose}", &name.chars().map(safe).collect::<String>())
}

/// The placeholders in braces of `pattern`, without the braces.
pub fn placeholders(pattern: &str) -> Vec<&str> {
    pattern.split('{').skip(1).filter_map(|part| Some(part.split_once('}')?.0)).collect()
}

/// A form of `path` by which two names of one file are seen to be equal.
///
/// Existing files are compared as the system sees them, through links; others by their folder's and their own name.
pub fn identity(path: &Path) -> PathBuf {
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    let folder = || path.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
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

/// For a hint, the file in the folder of `path` whose name is most like its own.
pub fn similar_file(path: &Path) -> Option<String> {
    if path.components().any(|part| part.as_os_str() == "~") {
        return Some("`~` is not understood here: write the whole path".into());
    }
    let name = path.file_name()?.to_string_lossy().into_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .filter(|other| *other != name)
        .collect();
    names.sort();
    super::words::did_you_mean(&name, &names)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path, pattern: &str) -> Vec<String> {
        expand(folder, pattern).unwrap().into_iter().map(|found| found.name).collect()
    }

    #[test]
    fn globs_are_in_natural_order_and_poses_are_called_what_the_wildcards_stand_for() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["pose-10.obj", "pose-2.obj", "pose-1.obj", "pose-x.ply"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(names(folder.path(), "pose-*.obj"), ["1", "2", "10"]);
        assert_eq!(names(folder.path(), "*.obj"), ["pose-1", "pose-2", "pose-10"]);
        assert_eq!(names(folder.path(), "pose-?.obj"), ["1", "2"]);
        assert_eq!(names(folder.path(), "pose-[0-9].*"), ["1", "2"]);
        assert_eq!(names(folder.path(), "pose-1.obj"), ["pose-1"]);
        assert!(names(folder.path(), "nothing-*.obj").is_empty());
    }

    #[test]
    fn wildcards_in_folders_name_the_pose_too() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["run/a", "walk/b"] {
            std::fs::create_dir_all(folder.path().join(name)).unwrap();
            std::fs::write(folder.path().join(name).join("mesh.obj"), "").unwrap();
        }
        assert_eq!(names(folder.path(), "*/*/mesh.obj"), ["run-a", "walk-b"]);
        assert_eq!(names(folder.path(), "run/*/m*.obj"), ["a-mesh"]);
    }

    #[test]
    fn names_of_poses_cannot_leave_the_folder() {
        assert_eq!(with_pose("out/{pose}.obj", "../a:b"), "out/.._a_b.obj");
        assert_eq!(placeholders("{a}/x{pose}.obj"), ["a", "pose"]);
    }

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

    #[test]
    fn a_file_that_does_not_exist_is_the_same_by_either_name() {
        let folder = tempfile::tempdir().unwrap();
        let a = identity(&folder.path().join("new/./x.obj"));
        assert_eq!(a, identity(&folder.path().join("./new/x.obj")));
    }
}
