//! What is told on stdout and stderr.

use std::io::{self, IsTerminal, Write};

use serde::Serialize;

use crate::diagnostic::{Diagnostic, Diagnostics};

/// Prints to stdout; a reader that has gone away (`| head`) is no error.
pub fn print(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes()).and_then(|()| io::stdout().flush());
}

/// Prints as JSON to stdout.
pub fn print_json(value: &impl Serialize) {
    if let Ok(text) = serde_json::to_string_pretty(value) {
        print(&(text + "\n"));
    }
}

/// More mistakes than this are counted only: they mostly have one cause.
const MOST_MISTAKES: usize = 100;

/// Tells on stderr what went wrong.
pub fn tell(failure: &Diagnostics) {
    failure.diagnostics.iter().take(MOST_MISTAKES).for_each(tell_one);
    match failure.diagnostics.len() {
        0 | 1 => {}
        count if count <= MOST_MISTAKES => {
            let _ = writeln!(io::stderr(), "{count} mistakes");
        }
        count => {
            let _ = writeln!(io::stderr(), "{count} mistakes, of which {MOST_MISTAKES} are shown");
        }
    }
}

/// Tells one mistake on stderr.
pub fn tell_one(diagnostic: &Diagnostic) {
    let _ = writeln!(io::stderr(), "{}: {diagnostic}", coloured("error", "31"));
}

/// Tells on stderr what looks wrong.
pub fn warn(text: &str) {
    let _ = writeln!(io::stderr(), "{}: {text}", coloured("warning", "33"));
}

/// Whether stderr may be animated and coloured.
pub fn lively() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb") && !set("NO_COLOR")
}

fn coloured(word: &str, colour: &str) -> String {
    if lively() { format!("\x1b[1;{colour}m{word}\x1b[0m") } else { word.into() }
}
