//! The names of temporary files.

use std::{
    ffi::{OsStr, OsString},
    path::Path,
};

/// What the names of all temporary files begin with.
pub(super) const PREFIX: &str = ".mimesh-";

/// The ending of a journal.
pub(super) const JOURNAL: &str = ".journal";

/// The ending of a file that tells where the journal is, in the other folders of a transaction.
const POINTER: &str = ".elsewhere";

/// Letters of an identity.
pub(super) const IDENTITY_LETTERS: usize = 12;

/// The name of the file that tells where the journal of `identity` is.
pub(super) fn pointer(identity: &str) -> String {
    format!("{PREFIX}{identity}{POINTER}")
}

/// The name of the file in the making that has the number `number`.
pub(super) fn part(identity: &str, number: usize) -> String {
    format!("{PREFIX}{identity}-{number}.part")
}

/// The name under which what was there before is kept.
pub(super) fn old(identity: &str, number: usize) -> String {
    format!("{PREFIX}{identity}-{number}.old")
}

/// The most bytes of a name that all usual file systems take.
const MAX_NAME: usize = 255;

/// The name for a file that was edited in the place `place` of a result, the `number`th from 1. It has no extension of a mesh, so that
/// no pattern of poses takes it for one.
pub(super) fn edited(place: &Path, number: usize) -> OsString {
    let ending = if number == 1 { ".edited".to_owned() } else { format!(".edited-{number}") };
    let mut name = place.file_name().unwrap_or_default().to_owned();
    if name.len() + ending.len() > MAX_NAME {
        let text = name.to_string_lossy();
        let end = text.floor_char_boundary(MAX_NAME - ending.len());
        name = text[..end].into();
    }
    name.push(ending);
    name
}

/// What a file of a transaction is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found<'a> {
    /// The journal of this identity.
    Journal(&'a str),
    /// The pointer to the journal of this identity.
    Pointer(&'a str),
}

/// What the name of `path` says, if it is a journal or a pointer.
pub(super) fn parse(path: &Path) -> Option<Found<'_>> {
    let name = path.file_name().and_then(OsStr::to_str)?.strip_prefix(PREFIX)?;
    let is_identity = |text: &&str| text.len() == IDENTITY_LETTERS && text.bytes().all(|c| c.is_ascii_alphanumeric());
    let of = |ending| name.strip_suffix(ending).filter(is_identity);
    of(JOURNAL).map(Found::Journal).or_else(|| of(POINTER).map(Found::Pointer))
}

/// Whether `name` is one that transactions take for themselves, so that no result has it.
pub(super) fn is_ours(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes();
    let has = |ending: &str| name.ends_with(ending.as_bytes());
    name.starts_with(PREFIX.as_bytes()) && [JOURNAL, POINTER, ".part", ".old"].into_iter().any(has)
}

/// Whether `name` is that of a file in the making, or of one that is kept, of `identity`.
pub(super) fn belongs_to(name: &OsStr, identity: &str) -> bool {
    name.to_str()
        .and_then(|name| name.strip_prefix(PREFIX)?.strip_prefix(identity)?.strip_prefix('-'))
        .and_then(|rest| rest.strip_suffix(".part").or_else(|| rest.strip_suffix(".old")))
        .is_some_and(|number| !number.is_empty() && number.bytes().all(|c| c.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(identity: &str) -> String {
        format!("{PREFIX}{identity}{JOURNAL}")
    }

    #[test]
    fn the_name_of_an_edited_file_is_never_too_long() {
        assert_eq!(edited(Path::new("out/a.obj"), 1), "a.obj.edited");
        assert_eq!(edited(Path::new("out/a.obj"), 2), "a.obj.edited-2");
        let long = format!("{}é.obj", "x".repeat(244));
        let name = edited(Path::new(&long), 12);
        // Half a letter is none.
        assert_eq!(name.to_str(), Some(&*format!("{}.edited-12", "x".repeat(244))));
    }

    #[test]
    fn names_are_told_apart() {
        let identity = "abcDEF012345";
        assert_eq!(parse(Path::new(&format!("a/{}", journal(identity)))), Some(Found::Journal(identity)));
        assert_eq!(parse(Path::new(&pointer(identity))), Some(Found::Pointer(identity)));
        for other in
            [".mimesh-short.journal", ".mimesh-abcDEF01234/.journal", "abcDEF012345.journal", ".mimesh-.journal"]
        {
            assert_eq!(parse(Path::new(other)), None, "{other}");
        }
        assert!(
            belongs_to(OsStr::new(&part(identity, 12)), identity)
                && belongs_to(OsStr::new(&old(identity, 0)), identity)
        );
        for other in [
            journal(identity),
            part("abcDEF012346", 1),
            format!("{PREFIX}{identity}-.part"),
            format!("{PREFIX}{identity}-x.old"),
        ] {
            assert!(!belongs_to(OsStr::new(&other), identity), "{other}");
        }
    }
}
