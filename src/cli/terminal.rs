//! Output on stdout and stderr.

use std::{
    borrow::Cow,
    io::{self, IsTerminal, Write},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
};

use mimesh_document::{
    Diagnostic, Diagnostics, Kind,
    files::io_message,
    limits::{on_one_line, without_controls},
};
use serde::Serialize;

use super::flags::with_flags;

/// Why something could not be printed to stdout, once that is so.
static UNPRINTED: Mutex<Option<Diagnostic>> = Mutex::new(None);

/// Prints to stdout, through which all results go. A reader that has closed the pipe (`| head`) is not an error; what else is wrong is
/// kept for the end of the command ([`unprinted`]), whose work is done either way.
pub fn print(text: &str) {
    note(io::stdout().write_all(without_controls(text).as_bytes()).and_then(|()| io::stdout().flush()));
}

/// Keeps the failure of printing to stdout, if it is one.
pub fn note(printed: io::Result<()>) {
    let printed = printed.and_then(|()| check_stdout());
    if let Err(error) = printed.as_ref()
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        let diagnostic = Diagnostic::new(Kind::CannotWrite, format!("standard output: {}", io_message("write", error)));
        let is_full = matches!(error.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded);
        let first = if is_full { "free some space, or send" } else { "send" };
        keep(diagnostic.hint(format!("{first} it elsewhere: `mimesh … > FILE`")));
    }
}

/// Checks that stdout takes what is written, as a descriptor that is open for reading does not (`1< FILE`): Rust takes that for success.
///
/// A descriptor that is closed (`>&-`) cannot be told from `/dev/null`: before `main` Rust opens that in its place.
#[cfg(unix)]
fn check_stdout() -> io::Result<()> {
    use std::{fs::File, os::fd::AsFd};
    let mut stdout = File::from(io::stdout().as_fd().try_clone_to_owned()?);
    stdout.write(&[]).map(drop).map_err(|error| match error.raw_os_error() {
        Some(number) if number == nix::errno::Errno::EBADF as i32 => {
            io::Error::new(io::ErrorKind::InvalidInput, "it is not open for writing")
        }
        _ => error,
    })
}

/// Elsewhere such descriptors are not known.
#[cfg(not(unix))]
fn check_stdout() -> io::Result<()> {
    Ok(())
}

fn keep(diagnostic: Diagnostic) {
    UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(diagnostic);
}

/// Why something could not be printed to stdout, if so.
pub fn unprinted() -> Option<Diagnostic> {
    UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Prints to stderr what belongs to a result, where stdout has the result for other programs.
pub fn print_beside(text: &str) {
    let _ = io::stderr().write_all(without_controls(text).as_bytes());
}

/// Prints as JSON to stdout.
pub fn print_json(value: &impl Serialize) {
    match serde_json::to_string_pretty(value) {
        Ok(text) => print(&(escaped(&text) + "\n")),
        Err(error) => keep(Diagnostic::new(Kind::Internal, format!("the result cannot be printed as JSON: {error}"))),
    }
}

/// JSON whose strings hold no character that steers a terminal; within strings JSON lets some of them stand as they are.
fn escaped(json: &str) -> String {
    let shown = |c: char| if c.is_control() && c != '\n' { format!("\\u{:04x}", u32::from(c)) } else { c.into() };
    json.chars().map(shown).collect()
}

/// A path as a text of JSON, with a mark in place of what is no Unicode.
pub fn shown(path: &Path) -> Cow<'_, str> {
    path.to_string_lossy()
}

/// Paths as texts of JSON.
pub fn all_shown(paths: &[PathBuf]) -> Vec<Cow<'_, str>> {
    paths.iter().map(|path| shown(path)).collect()
}

/// The largest number of diagnostics that are shown. More of them mostly have one cause.
const MAX_SHOWN: usize = 100;

/// Shows diagnostics on stderr, and their number if there are several.
pub fn report(diagnostics: &Diagnostics) {
    diagnostics.list.iter().take(MAX_SHOWN).for_each(report_one);
    match diagnostics.len() {
        0 | 1 => {}
        count if count <= MAX_SHOWN => {
            let _ = writeln!(io::stderr(), "{count} mistakes");
        }
        count => {
            let _ = writeln!(io::stderr(), "{count} mistakes, of which {MAX_SHOWN} are shown");
        }
    }
}

/// Shows one diagnostic on stderr.
pub fn report_one(diagnostic: &Diagnostic) {
    let _ = writeln!(io::stderr(), "{}: {}", coloured("error", "31"), with_flags(diagnostic));
}

/// Shows a warning on stderr.
pub fn warn(text: &str) {
    let _ = writeln!(io::stderr(), "{}: {}", coloured("warning", "33"), on_one_line(text));
}

/// Whether stderr may be animated and coloured.
pub fn is_interactive() -> bool {
    let is_dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    let no_colour = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    io::stderr().is_terminal() && !is_dumb && !no_colour
}

/// Gives `word` in bold with an ANSI colour code, where stderr may be coloured.
fn coloured(word: &str, colour: &str) -> String {
    if is_interactive() { format!("\x1b[1;{colour}m{word}\x1b[0m") } else { word.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_stays_json_and_steers_no_terminal() {
        let value = serde_json::json!({ "a\u{7f}": "b\n\u{1b}\u{9b}é" });
        let text = escaped(&serde_json::to_string_pretty(&value).unwrap());
        assert!(!text.contains(|c: char| c.is_control() && c != '\n'), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), value);
    }
}
