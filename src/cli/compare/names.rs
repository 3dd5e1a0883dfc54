//! Names of compared runs.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

use mimesh_pipeline::Report;

/// Gives each run a name of its own, without the words that all names begin with.
///
/// The names are those that the reports give, else those of the folders, else the paths of the reports.
pub fn distinct(files: &[PathBuf], reports: &[Report]) -> Vec<String> {
    let from_reports: Option<Vec<_>> = reports.iter().map(|report| Some(report.run.as_ref()?.name.clone())).collect();
    let from_folders: Option<Vec<_>> = files.iter().map(|file| folder_name(file)).collect();
    let names = [from_reports, from_folders].into_iter().flatten().find(|names| are_distinct(names));
    let paths = || files.iter().map(|file| file.display().to_string()).collect();
    without_common_words(names.unwrap_or_else(paths))
}

fn folder_name(file: &Path) -> Option<String> {
    Some(file.parent()?.file_name()?.to_string_lossy().into_owned())
}

fn are_distinct(names: &[String]) -> bool {
    names.iter().collect::<HashSet<_>>().len() == names.len()
}

/// Removes the words that all names begin with, as long as a part of each name remains.
fn without_common_words(names: Vec<String>) -> Vec<String> {
    let Some(first) = names.first() else { return names };
    let word_ends = first.char_indices().filter(|(_, c)| "-/,_ ".contains(*c)).map(|(i, c)| i + c.len_utf8());
    let is_common = |end: &usize| names.iter().all(|name| name.len() > *end && name.starts_with(&first[..*end]));
    let common = word_ends.rev().find(is_common).unwrap_or(0);
    names.iter().map(|name| name[common..].to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_words_that_all_names_share_are_removed() {
        let names = ["a-bc-1", "a-bd-1"].map(String::from).to_vec();
        assert_eq!(without_common_words(names), ["bc-1", "bd-1"]);
        let nothing_would_remain = ["a-", "a-b"].map(String::from).to_vec();
        assert_eq!(without_common_words(nothing_would_remain), ["a-", "a-b"]);
    }
}
