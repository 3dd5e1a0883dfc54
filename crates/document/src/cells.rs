//! Texts in the cells of tables, which programs for tables must not compute: names in them come from strangers' files.

use std::borrow::Cow;

/// `cell` with an apostrophe before what programs for tables would compute, such as `=1+1`. [`with_formula`] gives it back.
pub fn without_formula(cell: &str) -> Cow<'_, str> {
    if is_formula(cell.trim_start_matches('\'')) { format!("'{cell}").into() } else { cell.into() }
}

/// The text that was written as `cell`.
pub fn with_formula(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|rest| is_formula(rest.trim_start_matches('\''))).unwrap_or(cell)
}

fn is_formula(cell: &str) -> bool {
    // Programs may pass over what people cannot see.
    let is_passed_over = |c: char| c == ' ' || (c.is_whitespace() && !c.is_control()) || is_unseen(c);
    let begins = cell
        .trim_start_matches(is_passed_over)
        .starts_with(['=', '+', '-', '@', '\t', '\r', '\n', '＝', '＋', '－', '＠']);
    begins && cell.parse::<f64>().is_err()
}

/// Whether `c` has no width.
fn is_unseen(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_get_an_apostrophe_and_lose_it_again() {
        for (text, cell) in [
            ("=1+1", "'=1+1"),
            ("+1", "+1"),
            ("-2.5e-3", "-2.5e-3"),
            ("-x", "'-x"),
            ("@a", "'@a"),
            ("\tb", "'\tb"),
            (" =c", "' =c"),
            ("＝d", "'＝d"),
            ("\u{feff}=x", "'\u{feff}=x"),
            ("\u{a0}=x", "'\u{a0}=x"),
            ("\u{200b}=x", "'\u{200b}=x"),
            ("e=f", "e=f"),
            ("-", "'-"),
            ("'=g", "''=g"),
            ("'h", "'h"),
        ] {
            assert_eq!((without_formula(text), with_formula(cell)), (cell.into(), text));
        }
    }
}
