//! Fuzzing for some time: mutations of the corpus, of which those with a new outcome join it.

use std::{
    collections::HashSet,
    fs, io,
    time::{Duration, Instant},
};

use mimesh_core::random::Random;

use crate::{Target, corpus, limits, mutate::mutated};

/// The file that holds the input at hand: what it is when the process dies is a finding.
pub const CURRENT: &str = "findings/current";

/// What came of some time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Runs.
    pub runs: u64,
    /// Files that runs begin from.
    pub corpus: usize,
    /// Promises broken, each counted once.
    pub findings: usize,
}

/// Fuzzes `target` for `time`.
///
/// # Errors
///
/// Those of the system.
pub fn fuzz(target: &Target, time: Duration, seed: u64) -> io::Result<Tally> {
    let mut random = Random::new(seed ^ corpus::hash(target.name.as_bytes()));
    let mut all: Vec<Vec<u8>> = Vec::new();
    for folder in ["corpus", "grown"] {
        all.extend(corpus::files(folder, target.name)?.into_iter().map(|(_, bytes)| bytes));
    }
    if all.is_empty() {
        all.push(Vec::new());
    }
    fs::create_dir_all(corpus::home().join("findings"))?;
    let current = corpus::home().join(CURRENT);
    let (mut outcomes, mut broken) = (HashSet::new(), HashSet::new());
    let (start, mut tally) = (Instant::now(), Tally::default());
    let known = all.len();
    while start.elapsed() < time {
        let number = tally.runs as usize;
        // Those of the corpus first, as they are.
        let bytes = if number < known {
            all[number].clone()
        } else {
            let (from, other) = (random.index(all.len()), random.index(all.len()));
            mutated(&mut random, target, &all[from], &all[other])
        };
        fs::write(&current, &bytes)?;
        tally.runs += 1;
        match limits::run(target, &bytes) {
            Ok(outcome) => {
                if outcomes.insert(corpus::hash(without_numbers(&outcome).as_bytes())) && number >= known {
                    corpus::put("grown", target.name, &bytes)?;
                    all.push(bytes);
                }
            }
            Err(promise) => {
                if broken.insert(without_numbers(&promise)) {
                    let path = corpus::put("findings", target.name, &bytes)?;
                    println!("{}: {promise}: {}", target.name, path.display());
                }
            }
        }
    }
    fs::remove_file(&current)?;
    Ok(Tally { corpus: all.len(), findings: broken.len(), ..tally })
}

/// A text without its numbers and what it quotes, so that outcomes of one kind are equal.
fn without_numbers(text: &str) -> String {
    let outside = text.split('`').step_by(2).collect::<String>();
    outside.chars().filter(|c| c.is_alphabetic() || *c == ' ').take(300).collect()
}
