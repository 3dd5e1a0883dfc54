//! MeshLab's picked points: XML with an element `point` a point, whose attributes come in any order.
//!
//! ```xml
//! <PickedPoints>
//!  <point x="0.58" y="187.8" z="46.3" name="nose" active="1"/>
//! </PickedPoints>
//! ```

use std::{fmt::Write, path::Path};

use nalgebra::Point3;

use super::{
    points::{NamedPoint, PointFile, Spot},
    text::{Wrong, number, shorten},
    write::Written,
};
use crate::diagnostic::{Diagnostic, Diagnostics, Location, Result};

/// Parses the text of `file`; points that are not active are left out, with a warning.
///
/// # Errors
///
/// All that is wrong, each with its line.
pub fn parse(file: &Path, text: &str) -> Result<PointFile> {
    let location = |line: usize| Location::Line { file: file.into(), line };
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    let mut result = PointFile { file: file.into(), ..PointFile::default() };
    let mut inactive = Vec::new();
    let mut rooted = false;
    for tag in Tags::of(text) {
        let tag = match tag {
            Ok(tag) => tag,
            Err((line, wrong)) => {
                diagnostics.push(wrong.at(location(line)));
                break;
            }
        };
        if !rooted {
            rooted = true;
            if tag.name != "PickedPoints" {
                let message = format!("expected `<PickedPoints>`, found `<{}>`", shorten(&tag.name));
                let hint = "save the points with MeshLab's PickPoints tool".into();
                return Err(Wrong { message, hint }.at(location(tag.line)).into());
            }
        }
        if tag.name != "point" {
            continue;
        }
        let at = || location(tag.line);
        let name = tag.get("name").map(str::to_owned).filter(|name| !name.is_empty());
        if tag.get("active").is_some_and(|active| ["0", "false"].contains(&active)) {
            inactive.push(name.unwrap_or_else(|| format!("in line {}", tag.line)));
            continue;
        }
        let mut numbers = [0.0; 3];
        let mut good = true;
        for (axis, into) in ["x", "y", "z"].into_iter().zip(&mut numbers) {
            let wrong = match tag.get(axis).map(|text| number(text.trim())) {
                Some(Ok(value)) => {
                    *into = value;
                    continue;
                }
                Some(Err(wrong)) => Wrong { message: format!("`{axis}`: {}", wrong.message), ..wrong },
                None => Wrong {
                    message: format!("the point has no `{axis}`"),
                    hint: "a point is `<point x=\"0\" y=\"0\" z=\"0\" name=\"nose\"/>`".into(),
                },
            };
            diagnostics.push(wrong.at(at()));
            good = false;
        }
        if good {
            result.points.push(NamedPoint { name, spot: Spot::Position(Point3::from(numbers)), location: at() });
        }
    }
    if !rooted && diagnostics.is_empty() {
        let hint = "save the points with MeshLab's PickPoints tool".into();
        diagnostics.push(Wrong { message: "expected `<PickedPoints>`, found no XML".into(), hint }.at(location(1)));
    }
    if !inactive.is_empty() {
        let many = inactive.len();
        let names = inactive.join(", ");
        result.warnings.push(format!("{}: {many} not active and left out: {names}", file.display()));
    }
    if diagnostics.is_empty() { Ok(result) } else { Err(Diagnostics { diagnostics }) }
}

/// The text of a file with `points`, made on the mesh called `mesh`.
pub fn write(points: &[Written], mesh: &str) -> String {
    let mut text = format!(
        "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <DocumentData>\n  <DataFileName name=\"{}\"/>\n </DocumentData>\n",
        escape(mesh)
    );
    for Written { name, position: p, .. } in points {
        let name = escape(name);
        let _ = writeln!(text, " <point x=\"{}\" y=\"{}\" z=\"{}\" name=\"{name}\" active=\"1\"/>", p.x, p.y, p.z);
    }
    text + "</PickedPoints>\n"
}

/// `text` as the value of an attribute; what XML has no word for is left out.
fn escape(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' | '\r' => {
                let _ = write!(escaped, "&#{};", u32::from(c));
            }
            c if c.is_control() => {}
            c => escaped.push(c),
        }
    }
    escaped
}

/// An opening tag.
struct Tag {
    line: usize,
    name: String,
    attributes: Vec<(String, String)>,
}

impl Tag {
    fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(other, _)| other == name).map(|(_, value)| value.as_str())
    }
}

/// The opening tags of a text, in order, up to the first that is broken.
struct Tags<'t> {
    rest: &'t str,
    line: usize,
}

impl<'t> Tags<'t> {
    fn of(text: &'t str) -> Self {
        Self { rest: text, line: 1 }
    }

    /// Goes on by `bytes`.
    fn pass(&mut self, bytes: usize) {
        let (passed, rest) = self.rest.split_at(bytes);
        self.line += passed.matches('\n').count();
        self.rest = rest;
    }

    fn blanks(&mut self) {
        self.pass(self.rest.len() - self.rest.trim_start().len());
    }

    /// Passes what ends with `end`; false if it does not.
    fn pass_to(&mut self, end: &str) -> bool {
        let found = self.rest.find(end);
        self.pass(found.map_or(self.rest.len(), |at| at + end.len()));
        found.is_some()
    }

    fn tag(&mut self) -> std::result::Result<Tag, (usize, Wrong)> {
        let line = self.line;
        let wrong = |line: usize, message: &str| {
            let hint = "the file is damaged or cut short: save it again, or mend the line".to_owned();
            (line, Wrong { message: format!("not valid XML: {message}"), hint })
        };
        let ends = |c: char| c.is_whitespace() || "/>=<\"'".contains(c);
        let word = |tags: &mut Self| {
            let end = tags.rest.find(ends).unwrap_or(tags.rest.len());
            let word = tags.rest[..end].to_owned();
            tags.pass(end);
            word
        };
        let mut tag = Tag { line, name: word(self), attributes: vec![] };
        loop {
            self.blanks();
            match self.rest.chars().next() {
                None => return Err(wrong(line, "a tag that begins here has no end")),
                Some('>') => {
                    self.pass(1);
                    return Ok(tag);
                }
                Some('/') => self.pass(1),
                Some('<' | '=' | '"' | '\'') => return Err(wrong(self.line, "expected an attribute")),
                Some(_) => {
                    let name = word(self);
                    self.blanks();
                    if !self.rest.starts_with('=') {
                        return Err(wrong(self.line, &format!("the attribute `{}` has no value", shorten(&name))));
                    }
                    self.pass(1);
                    self.blanks();
                    let quote = self.rest.chars().next().filter(|c| "\"'".contains(*c));
                    let value = quote.and_then(|quote| self.rest[1..].split_once(quote));
                    let Some((value, _)) = value else {
                        let message = format!("the value of `{}` is not between quotes", shorten(&name));
                        return Err(wrong(self.line, &message));
                    };
                    tag.attributes.push((name, unescape(value)));
                    self.pass(value.len() + 2);
                }
            }
        }
    }
}

impl Iterator for Tags<'_> {
    type Item = std::result::Result<Tag, (usize, Wrong)>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let at = self.rest.find('<')?;
            self.pass(at);
            let line = self.line;
            let ended = match () {
                () if self.rest.starts_with("<!--") => self.pass_to("-->"),
                () if self.rest.starts_with("<?") => self.pass_to("?>"),
                () if self.rest.starts_with("<!") || self.rest.starts_with("</") => self.pass_to(">"),
                () => {
                    self.pass(1);
                    return Some(self.tag());
                }
            };
            if !ended {
                let hint = "the file is cut short: save it again".into();
                return Some(Err((line, Wrong { message: "not valid XML: a tag has no end".into(), hint })));
            }
        }
    }
}

/// `text` with its entities replaced; unknown ones stay as they are.
fn unescape(text: &str) -> String {
    let mut result = String::new();
    let mut rest = text;
    while let Some(at) = rest.find('&') {
        result.push_str(&rest[..at]);
        rest = &rest[at..];
        let named = rest.find(';').and_then(|end| Some((entity(&rest[1..end])?, end + 1)));
        let (c, length) = named.unwrap_or(('&', 1));
        result.push(c);
        rest = &rest[length..];
    }
    result + rest
}

fn entity(name: &str) -> Option<char> {
    match name {
        "amp" => Some('&'),
        "lt" => Some('<'),
        "gt" => Some('>'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => {
            let digits = name.strip_prefix('#')?;
            let number = match digits.strip_prefix(['x', 'X']) {
                Some(hexadecimal) => u32::from_str_radix(hexadecimal, 16),
                None => digits.parse(),
            };
            char::from_u32(number.ok()?)
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Result<PointFile> {
        parse(Path::new("m.pp"), text)
    }

    fn first_lines(text: &str) -> Vec<String> {
        let text = read(text).unwrap_err().to_string();
        text.lines().filter_map(|line| line.strip_prefix("error: m.pp:")).map(str::to_owned).collect()
    }

    #[test]
    fn attributes_come_in_any_order_and_inactive_points_are_told() {
        let file = read(
            "<!DOCTYPE PickedPoints>\r\n<PickedPoints>\n <!-- <point x=\"9\"/> -->\n <DocumentData><User name='a'/></DocumentData>\n \
             <point y=\"2\" name=\"a &amp; b\" x=\"1\" active=\"1\" z=\"3e-1\"/>\n <point x=\"0\" y=\"0\" z=\"0\" active=\"0\" name=\"c\"/>\n \
             <point x='4'\n z='6' y='5'></point></PickedPoints>",
        )
        .unwrap();
        assert_eq!(file.points[0].name.as_deref(), Some("a & b"));
        assert_eq!(file.points[0].spot, Spot::Position(Point3::new(1.0, 2.0, 0.3)));
        assert_eq!(file.points[1].spot, Spot::Position(Point3::new(4.0, 5.0, 6.0)));
        assert_eq!(file.points[1].location, Location::Line { file: "m.pp".into(), line: 7 });
        assert_eq!(file.warnings, ["m.pp: 1 not active and left out: c"]);
    }

    #[test]
    fn every_wrong_point_is_told_with_its_line() {
        let text = "<PickedPoints>\n<point x=\"1,5\" y=\"0\" z=\"0\"/>\n<point x=\"1\" y=\"a\"/>\n<point x=\"1\n";
        assert_eq!(
            first_lines(text),
            [
                "2: `x`: expected a number, found `1,5`",
                "3: `y`: expected a number, found `a`",
                "3: the point has no `z`",
                "4: not valid XML: the value of `x` is not between quotes",
            ]
        );
        assert_eq!(first_lines("<html>\n</html>"), ["1: expected `<PickedPoints>`, found `<html>`"]);
        assert_eq!(first_lines("1 2 3"), ["1: expected `<PickedPoints>`, found no XML"]);
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "(<(!--|[?]|/|point |PickedPoints)?|[a-z=\"'>/ &;#x\n]|[xyz]=\"[0-9.,é]*\"){0,40}") {
            let _ = read(&text);
        }

        #[test]
        fn points_come_back_as_written(
            points in prop::collection::vec(("[ -~é\t]{1,8}", prop::array::uniform3(-1e9..1e9f64)), 0..8),
        ) {
            let written: Vec<Written> = points
                .iter()
                .map(|(name, at)| Written { name: name.clone(), position: Point3::from(*at), ..Written::default() })
                .collect();
            let back = read(&write(&written, "a \"b\"")).unwrap();
            let back: Vec<_> = back.points.into_iter().map(|p| (p.name, p.spot)).collect();
            let expected: Vec<_> =
                points.into_iter().map(|(name, at)| (Some(name), Spot::Position(Point3::from(at)))).collect();
            prop_assert_eq!(back, expected);
        }
    }
}
