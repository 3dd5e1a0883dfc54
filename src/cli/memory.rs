//! How much memory the program may take: `--memory`, or what the machine has.

use std::fs;

use mimesh_core::memory::{self, Limit};

/// The environment variable that takes the place of the option.
pub const VARIABLE: &str = "MIMESH_MEMORY";

/// Lets the process have `bytes`, or what the machine lets it have.
pub fn set(bytes: Option<u64>) {
    let resident = bytes.or_else(of_the_machine).map(|bytes| Limit { bytes, used: resident });
    // What the user's shell allows is told of addresses, of which a process has more than it uses.
    let addresses = of_the_shell().map(|bytes| Limit { bytes, used: addresses });
    memory::set_limits(resident.into_iter().chain(addresses).collect());
}

/// Lets the process have what the environment says, else what the machine lets it have: for programs without a command line.
///
/// # Errors
///
/// The words of what is wrong with the variable of the environment.
pub fn set_from_environment() -> Result<(), String> {
    let given = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty());
    set(given.as_deref().map(size).transpose().map_err(|wrong| format!("{VARIABLE}: {wrong}"))?);
    Ok(())
}

/// Parses a size as `8G`, `1.5GiB`, `500M` or `2000000`; units are powers of 1024.
pub fn size(text: &str) -> Result<u64, String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match text[number.len()..].to_ascii_uppercase().as_str() {
        "" | "B" => 0,
        "K" | "KB" | "KIB" => 1,
        "M" | "MB" | "MIB" => 2,
        "G" | "GB" | "GIB" => 3,
        "T" | "TB" | "TIB" => 4,
        unit => return Err(format!("unknown unit `{unit}`: expected K, M, G or T, e.g. 8G")),
    };
    match number.trim().parse::<f64>() {
        Ok(amount) if amount > 0.0 && amount * 1024f64.powi(power) < u64::MAX as f64 => {
            Ok((amount * 1024f64.powi(power)) as u64)
        }
        _ => Err("expected a size above 0, e.g. 8G or 500M".into()),
    }
}

/// The memory that the process has now; known on Linux only.
fn resident() -> Option<u64> {
    in_kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// The addresses that the process has now; known on Linux only.
fn addresses() -> Option<u64> {
    in_kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmSize:")
}

/// The lesser of the memory of the machine and of the container; known on Linux only.
fn of_the_machine() -> Option<u64> {
    let read = |path: &str| fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| in_kilobytes(&text, "MemTotal:"));
    let number = |text: String| text.trim().parse().ok();
    let containers = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let container = containers.into_iter().find_map(|path| read(path).and_then(number));
    [machine, container].into_iter().flatten().min()
}

/// The addresses that the user's shell allows, by `ulimit -v`; known on Linux only.
fn of_the_shell() -> Option<u64> {
    let text = fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The value of a field such as `VmRSS:   12 kB`, in bytes.
fn in_kilobytes(text: &str, field: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(field))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units_and_are_above_zero() {
        assert_eq!(size("8G"), Ok(8 << 30));
        assert_eq!(size("1.5GiB"), Ok(3 << 29));
        assert_eq!([size("500m"), size("64kb"), size("1000")], [Ok(500 << 20), Ok(64 << 10), Ok(1000)]);
        for wrong in ["", "G", "8X", "-1G", "0", "1e999", "nan", "8 G x", "1e30T"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn fields_are_found_in_what_the_system_tells() {
        assert_eq!(in_kilobytes("VmPeak: 9 kB\nVmRSS:\t  12 kB\n", "VmRSS:"), Some(12 * 1024));
        assert!(!cfg!(target_os = "linux") || resident() < addresses() && of_the_machine().is_some());
    }
}
