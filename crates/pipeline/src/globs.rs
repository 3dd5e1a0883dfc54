//! Globs: the files that a pattern stands for, in natural order, with the names of the poses in them.
//!
//! Names are those of the system, which may be no Unicode; wildcards see them with a mark in place of what is none.

use std::{
    fs, io,
    path::{Component, Path, PathBuf},
};

use glob::{MatchOptions, Pattern};
use mimesh_document::{
    limits::thousands,
    paths::{from_base, stem, tidy},
};

/// Files and folders that one pattern may look at, and all of a list ten times as many.
const MAX_LOOKED_AT: usize = 100_000;
const MAX_OF_LIST: usize = 10 * MAX_LOOKED_AT;

/// How wildcards match names: a dot at the beginning is written out.
const MATCHING: MatchOptions =
    MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: true };

/// A file found for a glob or a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GlobMatch {
    /// The file.
    pub path: PathBuf,
    /// What the wildcards stand for, else the file's name without extension.
    pub name: String,
}

/// Why a pattern stands for no files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// What is wrong with the pattern, which is named.
    pub message: String,
    /// The way out.
    pub hint: &'static str,
}

/// Whether `pattern` has wildcards.
pub fn is_glob(pattern: &str) -> bool {
    pattern.contains(['*', '?', '['])
}

/// The files that `pattern` stands for, in natural order (`pose-2` before `pose-10`); a path without wildcards is
/// itself. `**` stands for folders within each other; it follows no links. Folders are left out, while a pipe or a link to nothing counts
/// as a file: who reads it is told what it is. `looked_at` counts what all patterns of a list look at.
///
/// # Errors
///
/// A pattern that is no glob, or that looks at more files than it can be meant to, alone or with those before.
pub fn expand(base: &Path, pattern: &str, looked_at: &mut usize) -> Result<Vec<GlobMatch>, Refused> {
    if !is_glob(pattern) {
        let path = from_base(base, Path::new(pattern));
        return Ok(vec![GlobMatch { name: stem(&path), path }]);
    }
    let parts = parts(pattern).map_err(|problem| Refused {
        message: format!("`{pattern}` is no glob: {problem}"),
        hint: "e.g. `horse-??.obj`",
    })?;
    let mut search = Search { found: vec![], looked_at: 0 };
    search.within(base.into(), &parts).map_err(|TooMany| Refused {
        message: format!("`{pattern}` looks at more than {} files and folders", thousands(MAX_LOOKED_AT)),
        hint: "begin it with the folder of the files, e.g. `poses/*.obj`; `**` looks into all folders below",
    })?;
    *looked_at += search.looked_at;
    if *looked_at > MAX_OF_LIST {
        return Err(Refused {
            message: format!(
                "`{pattern}` and those before look at more than {} files and folders",
                thousands(MAX_OF_LIST)
            ),
            hint: "write fewer patterns, which stand for more files each",
        });
    }
    let mut paths = search.found;
    paths.sort_by(|a, b| alphanumeric_sort::compare_path(a, b).then_with(|| a.cmp(b)));
    paths.dedup();
    let tidied = |path: PathBuf| if base.as_os_str().is_empty() { path } else { tidy(&path) };
    Ok(paths.into_iter().map(|path| GlobMatch { name: wild_part(pattern, &path), path: tidied(path) }).collect())
}

/// A part of a pattern between slashes.
enum Part<'p> {
    /// A name, or the beginning of the path.
    Written(Component<'p>),
    /// A name with wildcards.
    Wild(Pattern),
    /// `**`: any folders.
    Folders,
}

fn parts(pattern: &str) -> Result<Vec<Part<'_>>, &'static str> {
    Pattern::new(pattern).map_err(|error| error.msg)?;
    let mut parts = Vec::new();
    for component in Path::new(pattern).components() {
        let text = component.as_os_str().to_str().unwrap_or_default();
        parts.push(match component {
            // One of several in a row says it all.
            Component::Normal(_) if text == "**" => match parts.last() {
                Some(Part::Folders) => continue,
                _ => Part::Folders,
            },
            Component::Normal(_) if is_glob(text) => Part::Wild(Pattern::new(text).map_err(|error| error.msg)?),
            _ => Part::Written(component),
        });
    }
    Ok(parts)
}

/// That a pattern looks at too many files.
struct TooMany;

struct Search {
    found: Vec<PathBuf>,
    looked_at: usize,
}

impl Search {
    /// Adds the files below `folder` that `parts` stand for.
    fn within(&mut self, folder: PathBuf, parts: &[Part<'_>]) -> Result<(), TooMany> {
        let Some((first, rest)) = parts.split_first() else {
            // A pipe, a device or a link to nothing is found too: who reads it is told.
            if folder.symlink_metadata().is_ok() && !folder.is_dir() {
                self.found.push(folder);
            }
            return Ok(());
        };
        match first {
            Part::Written(name) => self.within(folder.join(name), rest),
            Part::Wild(pattern) => {
                for entry in self.entries(&folder)? {
                    let name = entry.file_name();
                    let fits = pattern.matches_with(&name.to_string_lossy(), MATCHING);
                    // Only a folder has something below.
                    if fits && (rest.is_empty() || entry.path().is_dir()) {
                        self.within(folder.join(name), rest)?;
                    }
                }
                Ok(())
            }
            // Folders alone are no files.
            Part::Folders if rest.is_empty() => Ok(()),
            Part::Folders => {
                let mut folders = vec![folder];
                while let Some(folder) = folders.pop() {
                    for entry in self.entries(&folder)? {
                        let name = entry.file_name();
                        // Behind a link the same folders may lie again.
                        let is_folder = entry.file_type().is_ok_and(|found| found.is_dir());
                        if is_folder && !name.as_encoded_bytes().starts_with(b".") {
                            folders.push(folder.join(name));
                        }
                    }
                    self.within(folder, rest)?;
                }
                Ok(())
            }
        }
    }

    /// What lies in `folder`; nothing if it is none, or closed.
    fn entries(&mut self, folder: &Path) -> Result<Vec<fs::DirEntry>, TooMany> {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let mut list = Vec::new();
        for entry in fs::read_dir(folder).into_iter().flatten().filter_map(io::Result::ok) {
            self.looked_at += 1;
            if self.looked_at > MAX_LOOKED_AT {
                return Err(TooMany);
            }
            list.push(entry);
        }
        Ok(list)
    }
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
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return format!("there is no folder {}", folder.display());
        }
        Err(error) => return format!("the folder {} cannot be looked into: {error}", folder.display()),
    };
    let extension = pattern.extension();
    let mut names: Vec<_> = entries
        .take(MAX_LOOKED_AT)
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|p| p.extension() == extension)
        .collect();
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
        expand(folder, pattern, &mut 0).unwrap().into_iter().map(|found| found.name).collect()
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

    #[cfg(unix)]
    #[test]
    fn a_link_to_nothing_is_found_and_a_folder_is_not() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("pose-1.obj")).unwrap();
        std::os::unix::fs::symlink("nowhere", folder.path().join("pose-2.obj")).unwrap();
        assert_eq!(names(folder.path(), "pose-*.obj"), ["2"]);
        assert_eq!(names(folder.path(), "*/none.obj"), Vec::<String>::new());
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
    fn two_stars_stand_for_folders_within_each_other_but_follow_no_links() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.obj", "x/b.obj", "x/y/c.obj", ".hidden/d.obj"] {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, "").unwrap();
        }
        #[cfg(unix)]
        std::os::unix::fs::symlink(folder.path(), folder.path().join("x/round")).unwrap();
        let files = |pattern: &str| -> Vec<String> {
            let found = expand(folder.path(), pattern, &mut 0).unwrap();
            found.iter().map(|one| one.path.strip_prefix(folder.path()).unwrap().display().to_string()).collect()
        };
        assert_eq!(files("**/*.obj"), ["a.obj", "x/b.obj", "x/y/c.obj"]);
        assert_eq!(files("**/**/c.obj"), ["x/y/c.obj"]);
        assert_eq!(files("x/**/*.obj"), ["x/b.obj", "x/y/c.obj"]);
        assert!(files("**").is_empty());
        assert!(expand(folder.path(), "a**/b", &mut 0).unwrap_err().message.contains("is no glob"));
        assert!(expand(folder.path(), "[a", &mut 0).unwrap_err().message.contains("is no glob"));
    }

    #[test]
    fn a_pattern_cannot_look_at_a_whole_system() {
        let folder = tempfile::tempdir().unwrap();
        // 330 folders are looked into 330 times.
        (0..330).for_each(|i| fs::create_dir(folder.path().join(i.to_string())).unwrap());
        let parts = parts("*/../*/../*.obj").unwrap();
        let mut search = Search { found: vec![], looked_at: 0 };
        assert!(search.within(folder.path().into(), &parts).is_err());
        assert!(search.looked_at <= MAX_LOOKED_AT + 1);
    }

    #[cfg(all(unix, not(target_os = "macos")))]
    #[test]
    fn names_that_are_no_unicode_are_found_like_others() {
        use std::{ffi::OsStr, os::unix::ffi::OsStrExt};
        let folder = tempfile::tempdir().unwrap();
        let odd = folder.path().join(OsStr::from_bytes(b"pose-\xff.obj"));
        fs::write(&odd, "").unwrap();
        fs::write(folder.path().join("pose-1.obj"), "").unwrap();
        let within = folder.path().join(OsStr::from_bytes(b"in\xfe"));
        fs::create_dir(&within).unwrap();
        fs::write(within.join("a.obj"), "").unwrap();
        let found = expand(folder.path(), "pose-*.obj", &mut 0).unwrap();
        let names: Vec<_> = found.iter().map(|one| one.name.as_str()).collect();
        assert_eq!((names, &found[1].path), (vec!["1", "\u{fffd}"], &odd));
        assert_eq!(expand(folder.path(), "*/a.obj", &mut 0).unwrap()[0].path, within.join("a.obj"));
        assert_eq!(expand(&within, "*.obj", &mut 0).unwrap()[0].path, within.join("a.obj"));
        assert!(nearby(&folder.path().join("none-*.obj")).contains("the 2 .obj files there"));
    }
}
