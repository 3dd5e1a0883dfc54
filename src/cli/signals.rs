//! Signals that would end the program where an error says more.

/// Lets a file that grows beyond the limit of the shell (`ulimit -f`) be an error of writing.
///
/// The signal of that limit would end the program without a word, and temporary files would stay. All threads that are started later
/// hold it back, too.
#[cfg(unix)]
pub fn hold_file_size_limit() {
    let mut signals = nix::sys::signal::SigSet::empty();
    signals.add(nix::sys::signal::Signal::SIGXFSZ);
    // Where that fails all is as it would be without.
    let _ = signals.thread_block();
}

/// Other systems have no such signal.
#[cfg(not(unix))]
pub fn hold_file_size_limit() {}
