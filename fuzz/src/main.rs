//! Fuzzes all readers in turn: `mimesh-fuzz --hours H [--target NAME] [--seed S]`; see README.md.

use std::time::Duration;

use mimesh_fuzz::{limits, session, targets};

/// Each target has its turn for so many seconds at most.
const TURN: f64 = 60.0;
const OPTIONS: [&str; 3] = ["--hours", "--target", "--seed"];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some([word, ..]) = arguments.chunks(2).find(|pair| pair.len() < 2 || !OPTIONS.contains(&pair[0].as_str())) {
        return Err(
            format!("`{word}` is no option with a value; mimesh-fuzz [--hours H] [--target NAME] [--seed S]").into()
        );
    }
    let value = |name: &str| arguments.iter().position(|word| word == name).and_then(|at| arguments.get(at + 1));
    let hours: f64 = value("--hours").map_or(Ok(1.0), |hours| hours.parse())?;
    let seed: u64 = value("--seed").map_or(Ok(1), |seed| seed.parse())?;
    let mut chosen = targets();
    if let Some(name) = value("--target") {
        chosen.retain(|target| target.name == name);
    }
    if chosen.is_empty() {
        let names: Vec<_> = targets().iter().map(|target| target.name).collect();
        return Err(format!("no such target; there are {}", names.join(", ")).into());
    }
    // A panic is a finding, which is told with its input.
    std::panic::set_hook(Box::new(|_| ()));
    limits::watch();
    let seconds = hours * 3600.0;
    let turn = (seconds / chosen.len() as f64).min(TURN);
    let turns = (seconds / (turn * chosen.len() as f64)).ceil() as u64;
    for round in 0..turns {
        for target in &chosen {
            println!("{} begins", target.name);
            let tally = session::fuzz(target, Duration::from_secs_f64(turn), seed.wrapping_add(round))?;
            let (runs, corpus, findings) = (tally.runs, tally.corpus, tally.findings);
            println!("{}: {runs} runs, corpus of {corpus}, {findings} kinds of findings", target.name);
        }
    }
    Ok(())
}
