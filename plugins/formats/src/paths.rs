//! Paths from one folder to files in another.

use std::path::{Component, Path, PathBuf};

/// `path` without links, as far as it exists.
pub fn resolved(path: &Path) -> PathBuf {
    let path = std::path::absolute(if path.as_os_str().is_empty() { Path::new(".") } else { path });
    let path = path.unwrap_or_default();
    for existing in path.ancestors() {
        if let Ok(found) = existing.canonicalize() {
            return found.join(path.strip_prefix(existing).unwrap_or(Path::new("")));
        }
    }
    path
}

/// `file` as it is called from `folder`, with `/` between names; the whole path where there is no way between the two.
///
/// Both are [`resolved`].
pub fn relative(folder: &Path, file: &Path) -> String {
    let (from, to): (Vec<_>, Vec<_>) = (folder.components().collect(), file.components().collect());
    let shared = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if shared == 0 {
        return file.display().to_string();
    }
    let up = from[shared..].iter().map(|_| "..".into());
    let down = to[shared..].iter().map(|component| match component {
        Component::Normal(name) => name.to_string_lossy(),
        other => other.as_os_str().to_string_lossy(),
    });
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_called_from_any_folder() {
        let from = |folder: &str, file: &str| relative(Path::new(folder), Path::new(file));
        assert_eq!(from("/a/b", "/a/b/c.mtl"), "c.mtl");
        assert_eq!(from("/a/b/out", "/a/b/c d.mtl"), "../c d.mtl");
        assert_eq!(from("/a/b/out/x", "/a/in/c.mtl"), "../../../in/c.mtl");
    }

    #[test]
    fn folders_that_are_yet_to_be_made_are_below_those_that_exist() {
        let top = tempfile::tempdir().unwrap();
        let real = top.path().canonicalize().unwrap();
        assert_eq!(resolved(&top.path().join("new/er")), real.join("new/er"));
    }
}
