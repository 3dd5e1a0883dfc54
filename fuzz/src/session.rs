//! Fuzzing for some time: mutations of the corpus, of which those with a new outcome join it.

use std::{
    collections::HashSet,
    fs::{self, File},
    io::{self, Seek, Write},
    path::PathBuf,
    time::{Duration, Instant},
};

use mimesh_core::random::Random;

use crate::{Target, corpus, limits, mutate::mutated};

/// The file that holds the input at hand: what it is when the process dies is a finding.
pub const CURRENT: &str = "findings/current";

/// Outcomes are alike if they begin with the same words.
const WORDS: usize = 10;

/// The most files that runs begin from: outcomes of some readers repeat words of the file, of which there is no end.
const MAX_CORPUS: usize = 2000;

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
    let seeds = corpus::files("corpus", target.name)?;
    let seed_count = seeds.len() as u64;
    let mut known: Vec<(Option<PathBuf>, Vec<u8>)> = seeds.into_iter().map(|(_, bytes)| (None, bytes)).collect();
    let grown = corpus::home().join("grown").join(target.name);
    known.extend(corpus::files("grown", target.name)?.into_iter().map(|(name, bytes)| (Some(grown.join(name)), bytes)));
    let mut current = Current::new()?;
    let (mut outcomes, mut broken) = (HashSet::new(), HashSet::new());
    let (start, mut tally) = (Instant::now(), Tally::default());
    let mut all: Vec<Vec<u8>> = Vec::new();
    let mut known = known.into_iter();
    while start.elapsed() < time {
        // What is known first, as it is.
        let (path, bytes) = match known.next() {
            Some((path, bytes)) => (path, bytes),
            None if all.is_empty() => (None, Vec::new()),
            None => {
                let (from, other) = (random.index(all.len()), random.index(all.len()));
                (None, mutated(&mut random, target, &all[from], &all[other]))
            }
        };
        current.put(&bytes)?;
        let is_seed = tally.runs < seed_count;
        tally.runs += 1;
        match limits::run(target, &bytes) {
            Ok(outcome) if (all.len() < MAX_CORPUS && outcomes.insert(kind(&outcome))) || is_seed => {
                if path.is_none() && !is_seed {
                    corpus::put("grown", target.name, &bytes)?;
                }
                all.push(bytes);
            }
            Ok(_) => {
                if let Some(path) = path {
                    fs::remove_file(path)?;
                }
            }
            Err(promise) => {
                if broken.insert(kind(&promise)) {
                    let path = corpus::put("findings", target.name, &bytes)?;
                    println!("{}: {promise}: {}", target.name, path.display());
                }
            }
        }
    }
    current.end()?;
    Ok(Tally { corpus: all.len(), findings: broken.len(), ..tally })
}

/// The file [`CURRENT`].
struct Current {
    path: PathBuf,
    file: File,
}

impl Current {
    fn new() -> io::Result<Self> {
        let path = corpus::home().join(CURRENT);
        fs::create_dir_all(corpus::home().join("findings"))?;
        let file = File::create(&path)?;
        Ok(Self { path, file })
    }

    /// Puts `bytes` in place of what was there. A file that is cut to nothing first would wait for the disk.
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.rewind()?;
        self.file.write_all(bytes)?;
        self.file.set_len(bytes.len() as u64)
    }

    fn end(self) -> io::Result<()> {
        fs::remove_file(self.path)
    }
}

/// The first words of an outcome that are its own: without numbers, names, and what it quotes of the file.
fn kind(outcome: &str) -> String {
    let line = outcome.lines().next().unwrap_or_default();
    // What is quoted may hold quotes itself, so all between the first and the last is left out.
    let quotes = ['`', '"'];
    let before = line.split(quotes).next().unwrap_or_default();
    let after = if before == line { "" } else { line.rsplit(quotes).next().unwrap_or_default() };
    let own = format!("{before} {after}");
    let words = own.split_whitespace().map(|word| word.trim_end_matches([':', ',', ';', '.']));
    let is_word = |word: &&str| word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase());
    words.filter(is_word).take(WORDS).collect::<Vec<_>>().join(" ")
}
