//! Runs one stage on meshes in files, and prints as JSON what it took.
//!
//! `peers.py` and `growth.py` run it, and a peer's function on the same files. It takes a [`Job`] as JSON from the file that its only
//! argument names. Only the work of the stage is timed: reading and writing of meshes stand outside, as they do for peers.

mod clock;
mod files;
mod job;

use std::process::ExitCode;

use job::Job;

fn main() -> ExitCode {
    // `cargo bench` adds `--bench` to what it is given.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let [job] = &arguments[..] else {
        eprintln!("one job is run at a time, by benches/peers/peers.py and benches/growth.py");
        return ExitCode::SUCCESS;
    };
    match Job::read(job).and_then(|job| job.run()) {
        Ok(report) => {
            println!("{report}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
