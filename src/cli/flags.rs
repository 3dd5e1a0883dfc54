//! The flags of the command line in diagnostics of the library.
//!
//! The library proposes actions and names settings; it does not know how its host takes them. The command line names
//! the flag or the command for each.

use mimesh_document::{
    Diagnostic, Location, Remedy,
    diagnostic::{SET_VALUE, SHOW_SETTINGS},
};
use mimesh_markers::{MORE_MEMORY, OTHER_OUTPUT_FOLDER, OTHER_ROOT, remedies};
use mimesh_pipeline::{
    ALLOW_COMMANDS, GIVE_MARKERS,
    cache::{OTHER_CACHE_FOLDER, WITHOUT_CACHE},
    check::OTHER_MESHES,
    parse::LIST_TYPES,
    shard::{COMPUTE_POSES, LARGER_CACHE, WARM_FRAMES},
};

use crate::cli::help_commands::quoted;

/// Gives `diagnostic` with the flags that its location and its remedy stand for; the remedy becomes part of the hint.
///
/// A diagnostic that has its flags already stays as it is.
pub fn with_flags(diagnostic: &Diagnostic) -> Diagnostic {
    let mut diagnostic = diagnostic.clone();
    diagnostic.location = diagnostic.location.map(location_as_flag);
    if let Some(remedy) = diagnostic.remedy.take() {
        let words = remedy_with_flag(&remedy);
        diagnostic.hint = Some(match diagnostic.hint {
            Some(hint) => format!("{hint}, or {words}"),
            None => words,
        });
    }
    diagnostic
}

fn location_as_flag(location: Location) -> Location {
    match location {
        Location::Setting(setting) => Location::Argument(format!("--set {setting}")),
        Location::OutputFolder(folder) => Location::Argument(format!("--out {}", folder.display())),
        other => other,
    }
}

/// The remedy in words that end with its flag, e.g. `write elsewhere: --out DIR`.
fn remedy_with_flag(remedy: &Remedy) -> String {
    let Some(flag) = flag(remedy) else { return remedy.words.clone() };
    let setting = format!("`{}`", remedy.argument);
    if remedy.action == SET_VALUE && remedy.words.contains(&setting) {
        // The flag takes the place of the setting, and is used rather than set.
        let words = remedy.words.replace(&setting, &flag);
        return words.strip_prefix("set ").map_or_else(|| words.clone(), |rest| format!("use {rest}"));
    }
    format!("{}: {flag}", remedy.words)
}

/// The flag or the command that does what `remedy` proposes, in backticks; `None` for an action without one.
fn flag(remedy: &Remedy) -> Option<String> {
    let argument = &remedy.argument;
    Some(match remedy.action {
        SET_VALUE => format!("`--set {}`", quoted(argument)),
        SHOW_SETTINGS => format!("`mimesh show {argument}`"),
        LIST_TYPES => "`mimesh list`".into(),
        MORE_MEMORY => "`--memory SIZE`".into(),
        OTHER_OUTPUT_FOLDER => "`--out DIR`".into(),
        OTHER_ROOT => "`--root DIR`".into(),
        WITHOUT_CACHE => "`--no-cache`".into(),
        OTHER_CACHE_FOLDER => "`--cache DIR`".into(),
        ALLOW_COMMANDS => "`--allow-commands`".into(),
        GIVE_MARKERS => "`--set markers=FILE`".into(),
        OTHER_MESHES => "`--source MESH --target MESH`".into(),
        COMPUTE_POSES => format!("`mimesh run PIPELINE --frames {argument}`"),
        LARGER_CACHE => format!("`--cache-limit {argument}`"),
        WARM_FRAMES => "`--warm N`".into(),
        remedies::FROM_ONE => format!("`mimesh markers convert --from-one {argument}`"),
        remedies::FIT_UNIT_AXES => "`mimesh markers convert --fit`".into(),
        remedies::OLD_MESH => format!("`--old-{argument} MESH`"),
        remedies::FORCE_REATTACH => "`--force`".into(),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use mimesh_document::Kind;

    use super::*;

    /// The hint of a diagnostic with a remedy, as the command line shows it.
    fn hint(hint: &str, action: &'static str, argument: &str, words: &str) -> String {
        let diagnostic = Diagnostic::new(Kind::Usage, "no").hint(hint).remedy(action, argument, words);
        with_flags(&diagnostic).hint.expect("the remedy is a hint")
    }

    #[test]
    fn every_action_names_its_flag() {
        let elsewhere = hint("free some space", OTHER_OUTPUT_FOLDER, "", "write elsewhere");
        assert_eq!(elsewhere, "free some space, or write elsewhere: `--out DIR`");
        let root = hint("put the file beside the mesh", OTHER_ROOT, "", "allow its folder");
        assert_eq!(root, "put the file beside the mesh, or allow its folder: `--root DIR`");
        assert_eq!(hint("", WITHOUT_CACHE, "", "run without the cache"), "run without the cache: `--no-cache`");
        let other_cache = hint("", OTHER_CACHE_FOLDER, "", "name another folder for the cache");
        assert_eq!(other_cache, "name another folder for the cache: `--cache DIR`");
        let settings = hint("", SHOW_SETTINGS, "transfer gradient", "see the settings of this type");
        assert_eq!(settings, "see the settings of this type: `mimesh show transfer gradient`");
        assert_eq!(hint("name one", LIST_TYPES, "", "list the types"), "name one, or list the types: `mimesh list`");
        let missing = hint("", COMPUTE_POSES, "3-5", "compute them first");
        assert_eq!(missing, "compute them first: `mimesh run PIPELINE --frames 3-5`");
        assert_eq!(hint("", LARGER_CACHE, "4000", "let it grow"), "let it grow: `--cache-limit 4000`");
        assert_eq!(hint("run it whole", WARM_FRAMES, "", "warm up"), "run it whole, or warm up: `--warm N`");
        let meshes = hint("", OTHER_MESHES, "", "give the two meshes themselves");
        assert_eq!(meshes, "give the two meshes themselves: `--source MESH --target MESH`");
        let from_one = hint("", remedies::FROM_ONE, "target", "convert the markers");
        assert_eq!(from_one, "convert the markers: `mimesh markers convert --from-one target`");
        let fitted = hint("", remedies::FIT_UNIT_AXES, "", "convert them");
        assert_eq!(fitted, "convert them: `mimesh markers convert --fit`");
        let old_mesh = hint("", remedies::OLD_MESH, "source", "give the source that they were made on");
        assert_eq!(old_mesh, "give the source that they were made on: `--old-source MESH`");
        let forced = hint("check the mesh", remedies::FORCE_REATTACH, "", "carry them over all the same");
        assert_eq!(forced, "check the mesh, or carry them over all the same: `--force`");
    }

    #[test]
    fn a_value_to_set_is_named_once_with_its_flag() {
        let example = hint("", SET_VALUE, "transfer.type=gradient", "e.g. `transfer.type=gradient`");
        assert_eq!(example, "e.g. `--set transfer.type=gradient`");
        assert_eq!(hint("", SET_VALUE, "matrix=", "set `matrix=`"), "use `--set matrix=`");
        let sequence = hint("", SET_VALUE, "list=[…]", "set the whole sequence `list`");
        assert_eq!(sequence, "set the whole sequence `list`: `--set 'list=[…]'`");
    }

    #[test]
    fn a_remedy_without_a_flag_keeps_its_words() {
        assert_eq!(hint("", "something_else", "", "ask again"), "ask again");
    }

    #[test]
    fn locations_are_the_flags_that_gave_them_in_text_and_json() {
        let set = Diagnostic::new(Kind::Usage, "no").at(Location::Setting("transfer.k=1".into()));
        let out = Diagnostic::new(Kind::Usage, "no").at(Location::OutputFolder("try".into()));
        for (diagnostic, option) in [(set, "--set transfer.k=1"), (out, "--out try")] {
            let shown = with_flags(&diagnostic.remedy(OTHER_OUTPUT_FOLDER, "", "write elsewhere"));
            assert_eq!(shown.to_string(), format!("{option}: no\n  hint: write elsewhere: `--out DIR`"));
            let json = shown.to_json();
            assert_eq!((&json["option"], &json["hint"]), (&option.into(), &"write elsewhere: `--out DIR`".into()));
            assert_eq!(with_flags(&shown), shown, "flags are named once");
        }
    }
}
