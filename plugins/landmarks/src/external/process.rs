//! A program with a time limit, whose output is bounded.

use std::{
    io::{self, Read},
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use mimesh_core::{Error, Result};

/// Longer answers are refused.
const MAX_OUTPUT: u64 = 16 << 20;

/// So much of what the program says on standard error stands in messages.
const MAX_MESSAGE: u64 = 2000;

/// How often a program is looked at that is still running.
const PAUSE: Duration = Duration::from_millis(10);

/// What `program` prints to standard output.
///
/// # Errors
///
/// If it cannot be started, fails, prints more than 16 MB, or does not end in time; then it is ended.
pub fn run(program: &str, arguments: &[String], time_limit: Duration) -> Result<Vec<u8>> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| failed(program, &format!("it cannot be started: {error}")))?;
    let output = collect(child.stdout.take(), MAX_OUTPUT + 1);
    let said = collect(child.stderr.take(), MAX_MESSAGE);
    let end = Instant::now() + time_limit;
    let ended = wait(&mut child, end);
    if !matches!(ended, Ok(Some(_))) {
        // It may have ended in the meantime.
        let _ = child.kill();
        let _ = child.wait();
    }
    let status = match ended {
        Ok(Some(status)) => status,
        Ok(None) => return Err(failed(program, &format!("it did not end within {} s", time_limit.as_secs_f64()))),
        Err(error) => return Err(failed(program, &error.to_string())),
    };
    if !status.success() {
        let said = said.recv_timeout(PAUSE * 10).unwrap_or_default();
        let said = String::from_utf8_lossy(&said).trim().to_owned();
        let said = if said.is_empty() { String::new() } else { format!(": {said}") };
        return Err(failed(program, &format!("it ended with {status}{said}")));
    }
    let left = end.saturating_duration_since(Instant::now()).max(PAUSE);
    match output.recv_timeout(left) {
        Ok(bytes) if bytes.len() as u64 > MAX_OUTPUT => Err(failed(program, &too_long())),
        Ok(bytes) => Ok(bytes),
        // Another process holds its output open.
        Err(_) => Err(failed(program, &format!("its output did not end within {} s", time_limit.as_secs_f64()))),
    }
}

/// The error of a program.
pub fn failed(program: &str, message: &str) -> Error {
    let hint = "run it by hand on two OBJ files; `mimesh show external` tells what it gets and what it prints";
    Error::data(format!("the command {program} gives no landmarks: {message}"), hint)
}

fn too_long() -> String {
    format!("it prints more than {MAX_OUTPUT} bytes")
}

/// The status with which the child ended; `None` if it is still running at `end`.
fn wait(child: &mut Child, end: Instant) -> io::Result<Option<ExitStatus>> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if Instant::now() >= end {
            return Ok(None);
        }
        thread::sleep(PAUSE);
    }
}

/// At most `limit` bytes of `from`, once it ends; what follows is read and thrown away, so that the program does not wait for it.
fn collect(from: Option<impl Read + Send + 'static>, limit: u64) -> Receiver<Vec<u8>> {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut from) = from {
            // What was read before an error is all there is.
            let _ = from.by_ref().take(limit).read_to_end(&mut bytes);
            let _ = io::copy(&mut from, &mut io::sink());
        }
        let _ = sender.send(bytes);
    });
    receiver
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str, seconds: f64) -> Result<Vec<u8>> {
        run("sh", &["-c".into(), script.into()], Duration::from_secs_f64(seconds))
    }

    fn message(script: &str, seconds: f64) -> String {
        shell(script, seconds).unwrap_err().to_string()
    }

    #[test]
    fn the_output_comes_whole_and_failures_are_told() {
        assert_eq!(shell("printf abc; echo no >&2", 20.0).unwrap(), b"abc");
        let failed = message("echo no weights >&2; exit 3", 20.0);
        assert!(failed.contains("exit status: 3") && failed.ends_with("no weights"), "{failed}");
        assert!(message("yes", 0.3).contains("did not end within 0.3 s"));
        assert!(message("head -c 20000000 /dev/zero", 20.0).contains("more than 16777216 bytes"));
        let missing = run("/no/such/program", &[], Duration::from_secs(1)).unwrap_err().to_string();
        assert!(missing.contains("cannot be started"), "{missing}");
    }

    #[test]
    fn a_program_that_leaves_another_behind_is_not_waited_for() {
        let start = Instant::now();
        // The one in the background holds the output open.
        assert!(message("sleep 30 & exit 0", 0.5).contains("did not end"));
        assert!(start.elapsed() < Duration::from_secs(10));
    }
}
