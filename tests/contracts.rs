//! Holds every registered implementation of every stage to its contract.
#![cfg(feature = "bundled")]

use std::{collections::BTreeSet, fs, path::Path};

// Links the bundled stages.
use mimesh as _;
use mimesh_core::{plugin, testkit::contracts};

/// Stages whose settings name what they give, which no contract can promise; other tests run them on files and points.
const GIVEN_BY_USER: [(&str, &str); 2] = [("correspondence", "from_file"), ("sampler", "given")];

/// All Rust sources below `folder`.
fn sources(folder: &Path) -> Vec<String> {
    let mut texts = Vec::new();
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("a readable entry").path();
        if path.is_dir() {
            texts.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            texts.push(fs::read_to_string(path).expect("UTF-8 text"));
        }
    }
    texts
}

/// A crate that is never named is not linked, and its stages are not registered: what the sources of the plug-ins register, the
/// registry must have.
#[test]
fn every_stage_of_the_plugins_is_linked_and_no_name_is_taken_twice() {
    let plugins = Path::new(env!("CARGO_MANIFEST_DIR")).join("plugins");
    let mut in_sources: Vec<String> = Vec::new();
    for text in
        fs::read_dir(plugins).expect("plugins").flat_map(|crate_| sources(&crate_.expect("a crate").path().join("src")))
    {
        let registered = text.lines().filter(|line| line.starts_with("register!(")).count();
        let names = text.lines().filter_map(|line| line.strip_prefix("#[typetag::serde(name = \"")?.split('"').next());
        let names: Vec<_> = names.map(str::to_owned).collect();
        assert_eq!(names.len(), registered, "a file registers as many stages as it names: {names:?}");
        in_sources.extend(names);
    }
    in_sources.sort();
    let mut linked: Vec<String> = plugin::all().into_iter().map(|plugin| plugin.name().to_owned()).collect();
    linked.sort();
    assert_eq!(linked, in_sources);
    let distinct: BTreeSet<_> = plugin::all().into_iter().map(|plugin| (plugin.stage, plugin.name())).collect();
    assert_eq!(distinct.len(), linked.len());
}

/// Every kind of stage is held to its contract by name, as a stranger's stage is.
#[test]
fn every_stage_keeps_its_contract() {
    let mut kinds = BTreeSet::new();
    for plugin in plugin::all() {
        let name = plugin.name();
        if GIVEN_BY_USER.contains(&(plugin.stage, name)) {
            contracts::described(plugin);
        } else {
            contracts::keeps(plugin.stage, name);
            kinds.insert(plugin.stage);
        }
    }
    let all: BTreeSet<_> = plugin::all().into_iter().map(|plugin| plugin.stage).collect();
    assert_eq!(kinds, all, "each kind has a stage that is held to its contract");
}
