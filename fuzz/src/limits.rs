//! Time and memory of a run: what takes more stops the process, so that whoever started it knows the input at hand.

use std::{
    alloc::System,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::atomic::{AtomicU64, Ordering},
    thread,
    time::Duration,
};

use cap::Cap;
use cpu_time::ProcessTime;

use crate::Target;

/// Counts what the process has allocated, and refuses more than its limit.
#[global_allocator]
static ALLOCATED: Cap<System> = Cap::new(System, usize::MAX);

/// Bytes that a run may allocate for each byte of its input, and for any input.
const BYTES_A_BYTE: usize = 256;
const BYTES: usize = 192 << 20;

/// Seconds of processor time that a run may take.
const SECONDS: f64 = 2.0;

/// The status of a process that stopped because a run took too long.
pub const TOO_LONG: i32 = 99;

/// When the run at hand began, in microseconds of processor time and one more; 0 if there is none.
static BEGAN: AtomicU64 = AtomicU64::new(0);

/// Runs `target` on `bytes` within limits.
///
/// # Errors
///
/// The promise that was broken, or the message of a panic. Too much time or memory ends the process.
pub fn run(target: &Target, bytes: &[u8]) -> Result<String, String> {
    let limit = ALLOCATED.allocated() + BYTES + BYTES_A_BYTE * bytes.len();
    // Below what is allocated no limit can be set, which cannot be.
    _ = ALLOCATED.set_limit(limit);
    BEGAN.store(now() + 1, Ordering::Relaxed);
    let outcome = catch_unwind(AssertUnwindSafe(|| (target.run)(target.name, bytes)));
    BEGAN.store(0, Ordering::Relaxed);
    _ = ALLOCATED.set_limit(usize::MAX);
    outcome.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        Err(format!("panic: {}", text.unwrap_or_default()))
    })
}

/// Watches from a thread of its own that no run takes too long.
pub fn watch() {
    thread::spawn(|| {
        loop {
            thread::sleep(Duration::from_millis(50));
            let began = BEGAN.load(Ordering::Relaxed);
            if began > 0 && now().saturating_sub(began) as f64 > SECONDS * 1e6 {
                eprintln!("a run takes more than {SECONDS} seconds");
                std::process::exit(TOO_LONG);
            }
        }
    });
}

/// Processor time of the process in microseconds.
fn now() -> u64 {
    ProcessTime::try_now().map_or(0, |time| time.as_duration().as_micros() as u64)
}
