//! Names: in messages, and told apart.

use std::collections::{HashMap, HashSet};

/// No message has more names than this.
const MAX_QUOTED: usize = 40;

/// Messages quote so many characters of a file at most.
const MAX_SHOWN: usize = 60;

/// The beginning of a text of a file, as messages quote it.
pub fn shown(text: &str) -> String {
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.into(),
    }
}

/// Names as they are; one that an earlier entry has gets the first number from its own on that makes it new.
pub fn all_distinct(names: impl IntoIterator<Item = String>) -> Vec<String> {
    distinct(names.into_iter().map(Some).collect()).into_iter().flatten().collect()
}

/// The names that there are as [`all_distinct`] has them.
pub fn distinct(mut names: Vec<Option<String>>) -> Vec<Option<String>> {
    let mut taken: HashSet<String> = names.iter().flatten().cloned().collect();
    // For each name seen the number after the last that was tried, below which none is free.
    let mut tried: HashMap<String, usize> = HashMap::new();
    for (index, entry) in names.iter_mut().enumerate() {
        let Some(name) = entry else { continue };
        let Some(next) = tried.get_mut(name) else {
            tried.insert(name.clone(), 0);
            continue;
        };
        let mut number = index.max(*next);
        let free = loop {
            let numbered = format!("{name}-{number}");
            number += 1;
            if taken.insert(numbered.clone()) {
                break numbered;
            }
        };
        *next = number;
        *name = free;
    }
    names
}

/// Names between backticks with commas, each once; of many the first.
pub fn quoted<S: AsRef<str>>(names: &[S]) -> String {
    let mut seen = HashSet::new();
    let once: Vec<&str> = names.iter().map(AsRef::as_ref).filter(|name| seen.insert(*name)).collect();
    let shown: Vec<String> = once.iter().take(MAX_QUOTED).map(|name| format!("`{}`", shown(name))).collect();
    let more = once.len() - shown.len();
    if more > 0 { format!("{} and {more} more", shown.join(", ")) } else { shown.join(", ") }
}

/// The number of the thing called `name` among those of a `kind`.
///
/// # Errors
///
/// Names those that there are.
pub fn find<'a>(kind: &str, names: impl IntoIterator<Item = &'a str>, name: &str) -> Result<usize, String> {
    let names: Vec<&str> = names.into_iter().collect();
    names.iter().position(|known| *known == name).ok_or_else(|| match &names[..] {
        [] => format!("no {kind} is called `{}`: the file has none", shown(name)),
        names => format!("no {kind} is called `{}`: the file has {}", shown(name), quoted(names)),
    })
}

/// The message where no node, mesh or material is called `name`, with those that there are.
pub fn unknown_part(name: &str, nodes_meshes_materials: &[Vec<String>; 3]) -> String {
    let kinds = ["nodes", "meshes", "materials"].into_iter().zip(nodes_meshes_materials);
    let lists: Vec<String> =
        kinds.filter(|(_, all)| !all.is_empty()).map(|(kind, all)| format!("{kind} {}", quoted(all))).collect();
    format!("nothing in the file is called `{}`: it has the {}", shown(name), lists.join(", the "))
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
        let many: Vec<String> = (0..20_000).map(|_| "a".into()).chain((0..20_000).map(|i| format!("a-{i}"))).collect();
        let names = all_distinct(many);
        assert_eq!((&*names[1], &*names[19_999], &*names[20_000]), ("a-20000", "a-39998", "a-0"));
    }
}
