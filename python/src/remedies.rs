//! The ways out that diagnostics of the library propose, in the words of Python.

use mimesh_document::{
    Diagnostic, Remedy,
    diagnostic::{SET_VALUE, SHOW_SETTINGS},
};
use mimesh_markers::{MORE_MEMORY, OTHER_OUTPUT_FOLDER, OTHER_ROOT};
use mimesh_pipeline::{
    ALLOW_COMMANDS, GIVE_MARKERS,
    cache::{OTHER_CACHE_FOLDER, WITHOUT_CACHE},
    check::{NAME_POSES, OTHER_MESHES},
    parse::LIST_TYPES,
};

/// Gives `diagnostic` with what Python calls its remedy, which becomes part of the hint.
pub fn in_python(diagnostic: &Diagnostic) -> Diagnostic {
    let mut diagnostic = diagnostic.clone();
    if let Some(remedy) = diagnostic.remedy.take() {
        let words = words(&remedy);
        diagnostic.hint = Some(match diagnostic.hint {
            Some(hint) => format!("{hint}, or {words}"),
            None => words,
        });
    }
    diagnostic
}

/// The remedy in words that end with what Python calls it, e.g. `write elsewhere: out="DIR"`.
fn words(remedy: &Remedy) -> String {
    let argument = &remedy.argument;
    let call = match remedy.action {
        SET_VALUE => {
            let call = format!("`set=[\"{argument}\"]`");
            let setting = format!("`{argument}`");
            if remedy.words.contains(&setting) {
                let words = remedy.words.replace(&setting, &call);
                return words.strip_prefix("set ").map_or_else(|| words.clone(), |rest| format!("use {rest}"));
            }
            call
        }
        SHOW_SETTINGS => format!("`print(mimesh.describe(\"{}\"))`", argument.replace(' ', "\", \"")),
        LIST_TYPES => "`print(mimesh.describe())`".into(),
        MORE_MEMORY => "set the environment variable `MIMESH_MEMORY`, e.g. to 8G".into(),
        OTHER_OUTPUT_FOLDER => "`out=\"DIR\"`".into(),
        OTHER_ROOT => "`roots=[\"DIR\"]`".into(),
        WITHOUT_CACHE => "`cache=False`".into(),
        OTHER_CACHE_FOLDER => "`cache=\"DIR\"`".into(),
        ALLOW_COMMANDS => "`allow_commands=True`".into(),
        GIVE_MARKERS => "`markers=[(source, target), …]` with vertices that correspond, or `markers=\"FILE\"`".into(),
        NAME_POSES => "`poses=…` with positions, meshes or files".into(),
        OTHER_MESHES => "`mimesh.load(\"MESH\")`".into(),
        _ => return remedy.words.clone(),
    };
    format!("{}: {call}", remedy.words)
}
