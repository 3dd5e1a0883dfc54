//! Numbers, sizes and tables as people read them.

pub use mimesh_document::limits::thousands;

use mimesh_document::cells::without_formula;

/// A number with four significant digits, without an exponent where it can be avoided.
pub fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-4..7).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    if value.fract() == 0.0 {
        return format!("{value}");
    }
    format!("{value:.*}", (3 - magnitude).max(0) as usize)
}

/// A count with its noun, e.g. `8,431 vertices`.
pub fn count(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", thousands(count), if count == 1 { one } else { many })
}

/// A size in bytes, kB, MB or GB of 1000.
pub fn bytes(size: u64) -> String {
    let (value, unit) = match size {
        0..1_000 => return format!("{size} bytes"),
        1_000..1_000_000 => (size as f64 / 1e3, "kB"),
        1_000_000..1_000_000_000 => (size as f64 / 1e6, "MB"),
        _ => (size as f64 / 1e9, "GB"),
    };
    format!("{value:.*} {unit}", if value < 10.0 { 1 } else { 0 })
}

/// Rows as comma-separated values.
pub fn csv(rows: &[Vec<String>]) -> String {
    let quoted = |cell: &String| {
        let cell = without_formula(cell);
        match cell.contains(['"', ',', '\n', '\r']) {
            true => format!("\"{}\"", cell.replace('"', "\"\"")),
            false => cell.into_owned(),
        }
    };
    rows.iter().map(|row| row.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n").collect()
}

/// Rows as a table of a page, the first as its heading; columns from `numbers` on are flush right.
pub fn markdown(rows: &[Vec<String>], numbers: usize) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let mut text = String::new();
    for (i, row) in rows.iter().enumerate() {
        text += &line(row);
        if i == 0 {
            let rule = (0..row.len()).map(|i| if i < numbers { "---" } else { "---:" }.to_owned());
            text += &line(&rule.collect::<Vec<_>>());
        }
    }
    text
}

/// A duration, e.g. `0.04 s`, `12.3 s`, `3 min 20 s`.
pub fn seconds(seconds: f64) -> String {
    if seconds < 9.95 {
        format!("{seconds:.2} s")
    } else if seconds < 99.5 {
        format!("{seconds:.1} s")
    } else {
        let whole = seconds.round() as u64;
        format!("{} min {} s", whole / 60, whole % 60)
    }
}

/// A time that is left, in whole seconds, e.g. `7 s`, `3 min 20 s`, `2 h 5 min`.
pub fn time_left(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, 0) => "less than 1 s".into(),
        (0, 0, seconds) => format!("{seconds} s"),
        (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
        (hours, minutes, _) => format!("{hours} h {minutes} min"),
    }
}

/// Rows under each other: the first column to the left, the others to the right, two blanks between.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<_> = (0..columns).map(width).collect();
    let mut result = String::new();
    for row in rows {
        let mut line = String::from("  ");
        for (column, cell) in row.iter().enumerate() {
            let blanks = " ".repeat(widths[column] - cell.chars().count());
            line += &if column == 0 { format!("{cell}{blanks}") } else { format!("  {blanks}{cell}") };
        }
        result += line.trim_end();
        result.push('\n');
    }
    result
}

/// Name and text under each other, both to the left.
pub fn pairs(rows: &[(String, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let line = |(name, text): &(String, String)| {
        let blanks = " ".repeat(width - name.chars().count());
        format!("  {name}{blanks}  {}", text.replace('\n', &format!("\n  {}  ", " ".repeat(width))))
            .trim_end()
            .to_owned()
            + "\n"
    };
    rows.iter().map(line).collect()
}

/// Names in a message, ten at most.
pub fn some_of<S: AsRef<str>>(names: &[S]) -> String {
    let more = if names.len() > 10 { ", …" } else { "" };
    let first: Vec<&str> = names.iter().take(10).map(AsRef::as_ref).collect();
    format!("{}{more}", first.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        assert_eq!(
            [1.23456, 0.000123456, 1234567.0, 0.5, 1e9, 0.0].map(number),
            ["1.235", "0.0001235", "1234567", "0.5000", "1.000e9", "0"]
        );
        assert_eq!([7, 8431, 1234567].map(thousands), ["7", "8,431", "1,234,567"]);
        assert_eq!([999, 1500, 22_400_000].map(bytes), ["999 bytes", "1.5 kB", "22 MB"]);
        assert_eq!([0.041, 12.34, 200.0].map(seconds), ["0.04 s", "12.3 s", "3 min 20 s"]);
        let left = [0.3, 59.4, 61.0, 7500.0].map(time_left);
        assert_eq!(left, ["less than 1 s", "59 s", "1 min 1 s", "2 h 5 min"]);
    }

    #[test]
    fn columns_of_tables_are_flush() {
        let rows = vec![vec!["pose".into(), "mean".into()], vec!["long name".into(), "1".into()]];
        assert_eq!(table(&rows), "  pose       mean\n  long name     1\n");
    }

    #[test]
    fn cells_are_no_formulas() {
        let cells = ["=1+1", "+1", "-2.5e-3", "-x", "@a", "\tb", " =c", "＝d", "e=f", "=\"g\",h", "-"];
        let row = cells.map(str::to_owned).to_vec();
        assert_eq!(csv(&[row]), "'=1+1,+1,-2.5e-3,'-x,'@a,'\tb,' =c,'＝d,e=f,\"'=\"\"g\"\",h\",'-\n");
    }
}
