//! Folders of caches: damaged, shared, closed, bounded.

use std::fs;

use mimesh::core::testkit::random::Random;
use serde_json::Value;

use crate::{common::cache_entries, gallop, results, reused, run, stages};

#[test]
fn damaged_entries_are_reported_and_computed_again() {
    let project = gallop();
    run(&project, &[]);
    let expected = results(&project, "out");
    let all = cache_entries(project.cache());
    assert!(all.len() > 12, "{all:?}");
    let mut random = Random::new(1);
    for (i, path) in all.iter().enumerate() {
        let mut bytes = fs::read(path).expect("an entry");
        let at = random.index(bytes.len());
        match i % 3 {
            0 => bytes[at] ^= 1,
            1 => bytes.truncate(at),
            _ => bytes.clear(),
        }
        fs::write(path, bytes).expect("an entry");
    }
    let report = run(&project, &[]);
    assert_eq!(reused(&report), (stages(&[("correspondence", false), ("transfer", false)]), 0));
    assert!(report["warnings"].to_string().contains("damaged"), "{}", report["warnings"]);
    assert_eq!(results(&project, "out"), expected);
    assert_eq!(reused(&run(&project, &[])).1, 12);
}

#[test]
fn two_runs_at_once_share_a_cache() {
    let project = gallop();
    run(&project, &["--no-cache", "--out", "expected"]);
    let expected = results(&project, "expected");
    std::thread::scope(|scope| {
        for folder in ["a", "b", "c"] {
            let (project, expected) = (&project, &expected);
            scope.spawn(move || {
                run(project, &["--out", folder]);
                assert_eq!(results(project, folder), *expected);
            });
        }
    });
    assert_eq!(reused(&run(&project, &[])).1, 12);
}

#[test]
fn a_cache_that_cannot_be_written_is_only_a_warning() {
    let project = gallop();
    project.write("file", "no folder");
    let report = run(&project, &["--cache", "file"]);
    let warnings = report["warnings"].to_string();
    assert!(
        warnings.matches("results are not cached").count() == 1 && warnings.contains("another folder"),
        "{warnings}"
    );
    assert_eq!(results(&project, "out").len(), 13);
}

#[test]
fn the_cache_is_shown_bounded_and_cleared() {
    let project = gallop();
    run(&project, &[]);
    let shown = project.mimesh(&["cache"]).stdout;
    assert!(shown.contains("pose") && shown.contains("12 results"), "{shown}");
    let bytes = || -> u64 {
        let json: Value = serde_json::from_str(&project.mimesh(&["cache", "--json"]).stdout).expect("JSON");
        json["bytes"].as_u64().expect("bytes")
    };
    assert!(bytes() > 1 << 19, "{}", bytes());
    run(&project, &["--set", "transfer.reweightings=1", "--cache-limit", "1"]);
    assert!(bytes() <= 1 << 20, "{}", bytes());
    assert!(project.mimesh(&["cache", "--clear"]).stdout.contains("removed"));
    assert_eq!(bytes(), 0);
    assert_eq!(reused(&run(&project, &[])).1, 0);
}
