//! Globs: the files that a pattern stands for, in natural order, with the names of the poses in them.

use std::path::{Path, PathBuf};

use mimesh_document::paths::{from_base, stem, tidy};

/// A file found for a glob or a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GlobMatch {
    /// The file.
    pub path: PathBuf,
    /// What the wildcards stand for, else the file's name without extension.
    pub name: String,
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
pub fn expand(base: &Path, pattern: &str) -> Result<Vec<GlobMatch>, String> {
    if !is_glob(pattern) {
        let path = from_base(base, Path::new(pattern));
        return Ok(vec![GlobMatch { name: stem(&path), path }]);
    }
    let escaped = glob::Pattern::escape(&base.to_string_lossy());
    let whole = if escaped.is_empty() { pattern.into() } else { from_base(Path::new(&escaped), Path::new(pattern)) };
    let options =
        glob::MatchOptions { require_literal_separator: true, require_literal_leading_dot: true, ..Default::default() };
    let matches = glob::glob_with(&whole.to_string_lossy(), options).map_err(|error| error.msg.to_owned())?;
    let mut paths: Vec<PathBuf> = matches.filter_map(Result::ok).filter(|path| path.is_file()).collect();
    paths.sort_by(|a, b| alphanumeric_sort::compare_path(a, b).then_with(|| a.cmp(b)));
    let tidied = |path: PathBuf| if base.as_os_str().is_empty() { path } else { tidy(&path) };
    Ok(paths.into_iter().map(|path| GlobMatch { name: wild_part(pattern, &path), path: tidied(path) }).collect())
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

/// A hint about the files in the folder where `pattern` matched nothing.
pub fn nearby(pattern: &Path) -> String {
    let folder = pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if is_glob(&folder.to_string_lossy()) {
        return "globs are relative to the folder of the pipeline's file".into();
    }
    let Ok(entries) = std::fs::read_dir(folder) else {
        return format!("there is no folder {}", folder.display());
    };
    let extension = pattern.extension();
    let mut names: Vec<_> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|p| p.extension() == extension).collect();
    names.sort_by(|a, b| alphanumeric_sort::compare_path(a, b));
    let kind = extension.map(|e| format!(".{} ", e.to_string_lossy())).unwrap_or_default();
    match &names[..] {
        [] => format!("there are no {kind}files in {}", folder.display()),
        [one] => format!("the only {kind}file there is {}", one.display()),
        [first, .., last] => {
            format!("the {} {kind}files there go from {} to {}", names.len(), file_name(first), file_name(last))
        }
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
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
}
