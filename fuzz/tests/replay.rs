//! The corpus and some mutations of it: no reader breaks a promise.

use std::io::Write;

use mimesh_core::random::Random;
use mimesh_fuzz::{corpus, limits, mutate::mutated, targets};

/// Mutations of each target; more are made by `fuzz/run`.
const MUTATIONS: usize = 300;

#[test]
fn no_reader_breaks_a_promise() {
    limits::watch();
    let mut broken = Vec::new();
    for target in targets() {
        // Not captured, so that it is there if the process dies.
        _ = writeln!(std::io::stderr(), "target {}", target.name);
        let seeds = corpus::files("corpus", target.name).unwrap();
        assert!(!seeds.is_empty(), "{} has no corpus", target.name);
        for (name, bytes) in &seeds {
            if let Err(promise) = limits::run(&target, bytes) {
                broken.push(format!("{}/{name}: {promise}", target.name));
            }
        }
        let mut random = Random::new(7);
        for number in 0..MUTATIONS {
            let [from, other] = [0; 2].map(|_| &seeds[random.index(seeds.len())].1);
            let bytes = mutated(&mut random, &target, from, other);
            if let Err(promise) = limits::run(&target, &bytes) {
                let path = corpus::put("findings", target.name, &bytes).unwrap();
                broken.push(format!("{}, mutation {number}: {promise}: {}", target.name, path.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{} promises broken:\n{}", broken.len(), broken.join("\n"));
}
