//! Output on stdout and stderr.

use std::io::{self, IsTerminal, Write};

use mimesh_document::{Diagnostic, Diagnostics};
use serde::Serialize;

use super::flags::with_flags;

/// Prints to stdout. A reader that has closed the pipe (`| head`) is not an error.
pub fn print(text: &str) {
    let _ = io::stdout().write_all(text.as_bytes()).and_then(|()| io::stdout().flush());
}

/// Prints to stderr what belongs to a result, where stdout has the result for other programs.
pub fn print_beside(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Prints as JSON to stdout.
pub fn print_json(value: &impl Serialize) {
    if let Ok(text) = serde_json::to_string_pretty(value) {
        print(&(text + "\n"));
    }
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
    let _ = writeln!(io::stderr(), "{}: {text}", coloured("warning", "33"));
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
