//! What the process has used so far.

use serde::{Deserialize, Serialize};

/// CPU time and memory of this process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Usage {
    /// CPU time of all threads, user and system; `None` where the system does not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_seconds: Option<f64>,
    /// The largest resident memory so far; `None` where the system does not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_memory_bytes: Option<u64>,
}

/// The clock ticks a second in which Linux tells times to programs, on every architecture.
const TICKS_PER_SECOND: f64 = 100.0;

/// What the process has used so far; known on Linux only.
pub fn usage() -> Usage {
    let stat = std::fs::read_to_string("/proc/self/stat").ok();
    let status = std::fs::read_to_string("/proc/self/status").ok();
    Usage {
        cpu_seconds: stat.as_deref().and_then(cpu_seconds),
        peak_memory_bytes: status.as_deref().and_then(peak_memory_bytes),
    }
}

/// User and system time are the 14th and 15th field; the second, the program's name, may hold blanks.
fn cpu_seconds(stat: &str) -> Option<f64> {
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / TICKS_PER_SECOND)
}

fn peak_memory_bytes(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_found_behind_a_name_with_blanks_and_brackets() {
        let stat = "7 (a b) c) S 1 2 3 4 5 6 7 8 9 10 250 50 0 0 20";
        assert_eq!(cpu_seconds(stat), Some(3.0));
        assert_eq!(peak_memory_bytes("VmPeak: 9 kB\nVmHWM:\t  12 kB\n"), Some(12 * 1024));
    }
}
