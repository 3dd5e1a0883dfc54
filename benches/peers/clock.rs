use std::{fs, time::Instant};

use cpu_time::ProcessTime;
use serde_json::{Map, Value, json};

/// Measures the phases of a job.
#[derive(Default)]
pub struct Clock {
    phases: Map<String, Value>,
    resident: Option<u64>,
}

impl Clock {
    /// Runs a phase and notes its seconds: CPU time of all threads, and wall time.
    pub fn phase<T>(&mut self, name: &str, run: impl FnOnce() -> T) -> T {
        self.resident = self.resident.or_else(|| memory("VmRSS:"));
        let (cpu, wall) = (ProcessTime::now(), Instant::now());
        let result = run();
        let phase = json!({ "cpu": cpu.elapsed().as_secs_f64(), "wall": wall.elapsed().as_secs_f64() });
        self.phases.insert(name.to_owned(), phase);
        result
    }

    /// What was measured. `resident` is the memory before the first phase and `peak` the most so far, in bytes, where the system tells.
    pub fn report(self, about: Value) -> Value {
        let peak = memory("VmHWM:");
        json!({ "phases": self.phases, "resident": self.resident, "peak": peak, "about": about })
    }
}

/// The memory of the process, bytes, by its name in `/proc`. What the parent of a process learns includes memory that it had itself
/// when it started the process.
fn memory(name: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}
