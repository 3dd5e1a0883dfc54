//! Names that tell things of one kind apart.

use std::collections::HashSet;

/// Names as they are; one that an earlier entry has gets the first number from its own on that makes it new.
pub fn all_distinct(names: impl IntoIterator<Item = String>) -> Vec<String> {
    distinct(names.into_iter().map(Some).collect()).into_iter().flatten().collect()
}

/// The names that there are as [`all_distinct`] has them.
pub fn distinct(mut names: Vec<Option<String>>) -> Vec<Option<String>> {
    let mut taken: HashSet<String> = names.iter().flatten().cloned().collect();
    let mut seen = HashSet::new();
    for (index, entry) in names.iter_mut().enumerate() {
        let Some(name) = entry else { continue };
        if seen.insert(name.clone()) {
            continue;
        }
        let mut numbered = (index..).map(|number| format!("{name}-{number}"));
        let free = numbered.find(|name| !taken.contains(name)).expect("there are infinitely many");
        taken.insert(free.clone());
        *name = free;
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_made_distinct_and_the_first_of_each_stays() {
        let distinct = |names: &[&str]| all_distinct(names.iter().map(|name| (*name).to_owned()));
        assert_eq!(distinct(&["a", "b", "a", "a-2", "a"]), ["a", "b", "a-3", "a-2", "a-4"]);
        assert_eq!(distinct(&["a-2", "a", "a"]), ["a-2", "a", "a-3"]);
        assert_eq!(distinct(&["M", "M", "M-1"]), ["M", "M-2", "M-1"]);
    }
}
