//! JSON with the line of every value, and with messages for what people write instead of it.

use super::text::{Wrong, shorten};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The line, from 1.
    pub line: usize,
    /// The value.
    pub value: Value,
}

/// A JSON value; numbers as they were written.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A finite number, and whether it was written as a whole one.
    Number(f64, bool),
    /// A text.
    Text(String),
    /// `true`, `false` or `null`.
    Word(String),
    /// A list.
    List(Vec<Node>),
    /// A map, in the order of the file; no key comes twice.
    Map(Vec<(String, Node)>),
}

impl Node {
    /// The value in words, for messages.
    pub fn found(&self) -> String {
        match &self.value {
            Value::Number(number, _) => format!("{number}"),
            Value::Text(text) => format!("the text `{}`", shorten(text)),
            Value::Word(word) => word.clone(),
            Value::List(list) if list.iter().all(|item| matches!(item.value, Value::Number(..))) && list.len() < 9 => {
                let items: Vec<_> = list.iter().map(Self::found).collect();
                format!("[{}]", items.join(", "))
            }
            Value::List(list) => format!("a list of {}", list.len()),
            Value::Map(map) => {
                let keys: Vec<_> = map.iter().take(4).map(|(key, _)| key.as_str()).collect();
                format!("a map with the keys {}", shorten(&keys.join(", ")))
            }
        }
    }
}

/// Values nested deeper than this are refused.
const DEEPEST: usize = 64;

/// Parses `text`.
///
/// # Errors
///
/// The first place that is no JSON: its line, what is expected and found.
pub fn parse(text: &str) -> Result<Node, (usize, Wrong)> {
    let mut reader = Reader { text, at: 0, line: 1 };
    let node = reader.node(0)?;
    reader.blanks();
    match reader.peek() {
        None => Ok(node),
        Some(c) => Err(reader.wrong(format!("expected the end, found `{c}`"), "remove what follows the list")),
    }
}

struct Reader<'t> {
    text: &'t str,
    at: usize,
    line: usize,
}

type Read<T> = Result<T, (usize, Wrong)>;

impl Reader<'_> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn next(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.at += c.len_utf8();
        self.line += usize::from(c == '\n');
        Some(c)
    }

    fn blanks(&mut self) {
        while self.peek().is_some_and(char::is_whitespace) {
            self.next();
        }
    }

    fn wrong(&self, message: String, hint: &str) -> (usize, Wrong) {
        (self.line, Wrong { message: format!("not valid JSON: {message}"), hint: hint.into() })
    }

    /// What stands here, for messages.
    fn here(&self) -> String {
        match self.peek() {
            None => "the end of the file".into(),
            Some(_) => {
                let word = self.text[self.at..].split(|c: char| c.is_whitespace() || ",:[]{}".contains(c)).next();
                match word.filter(|word| !word.is_empty()) {
                    Some(word) => format!("`{}`", shorten(word)),
                    None => format!("`{}`", self.peek().unwrap_or(' ')),
                }
            }
        }
    }

    fn node(&mut self, depth: usize) -> Read<Node> {
        self.blanks();
        let line = self.line;
        if depth > DEEPEST {
            return Err(self.wrong("nested too deeply".into(), "points are lists or maps of a few levels"));
        }
        let value = match self.peek() {
            Some('[') => self.list(depth)?,
            Some('{') => self.map(depth)?,
            Some('"') => Value::Text(self.string()?),
            Some(c) if c.is_ascii_digit() || "+-.".contains(c) => self.number()?,
            _ => self.word()?,
        };
        Ok(Node { line, value })
    }

    fn list(&mut self, depth: usize) -> Read<Value> {
        self.next();
        let mut items = Vec::new();
        let mut comma = false;
        loop {
            self.blanks();
            if self.ends(']', comma)? {
                return Ok(Value::List(items));
            }
            items.push(self.node(depth + 1)?);
            comma = self.comma(']', "list")?;
        }
    }

    fn map(&mut self, depth: usize) -> Read<Value> {
        self.next();
        let mut entries: Vec<(String, Node)> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        let mut comma = false;
        loop {
            self.blanks();
            if self.ends('}', comma)? {
                return Ok(Value::Map(entries));
            }
            if self.peek() != Some('"') {
                let found = self.here();
                return Err(
                    self.wrong(format!("expected a name in quotes, found {found}"), "e.g. `\"nose\": [0.1, 0.2, 0.3]`")
                );
            }
            let key = self.string()?;
            if !seen.insert(key.clone()) {
                let message = format!("the name `{}` comes a second time", shorten(&key));
                return Err(self.wrong(message, "give each point its own name"));
            }
            self.blanks();
            if self.peek() != Some(':') {
                let found = self.here();
                let message = format!("expected `:` behind the name, found {found}");
                return Err(self.wrong(message, "e.g. `\"nose\": [0.1, 0.2, 0.3]`"));
            }
            self.next();
            entries.push((key, self.node(depth + 1)?));
            comma = self.comma('}', "map")?;
        }
    }

    /// Whether a list or map ends here, which it must not after a comma.
    fn ends(&mut self, end: char, after_comma: bool) -> Read<bool> {
        if self.peek() != Some(end) {
            return Ok(false);
        }
        if after_comma {
            return Err(self.wrong(format!("a comma before `{end}`"), "remove the comma behind the last value"));
        }
        self.next();
        Ok(true)
    }

    /// Whether a comma stands here, which is passed; else it must be `end`, which is left.
    fn comma(&mut self, end: char, what: &str) -> Read<bool> {
        self.blanks();
        match self.peek() {
            Some(',') => {
                self.next();
                Ok(true)
            }
            Some(c) if c == end => Ok(false),
            None => Err(self.wrong(
                format!("the file ends inside a {what}: expected `{end}`"),
                "the file is cut short: save it again",
            )),
            Some(c) => {
                let found = self.here();
                let hint = if c == ';' { "separate values by commas" } else { "a comma is missing here, or before" };
                Err(self.wrong(format!("expected `,` or `{end}`, found {found}"), hint))
            }
        }
    }

    fn string(&mut self) -> Read<String> {
        let line = self.line;
        self.next();
        let mut result = String::new();
        loop {
            match self.next() {
                None => {
                    let hint = "close it with a quote".to_owned();
                    return Err((line, Wrong { message: "not valid JSON: a text has no end".into(), hint }));
                }
                Some('"') => return Ok(result),
                Some('\\') => result.push(self.escape()?),
                Some(c) => result.push(c),
            }
        }
    }

    fn escape(&mut self) -> Read<char> {
        let simple = match self.next() {
            Some('n') => '\n',
            Some('t') => '\t',
            Some('r') => '\r',
            Some('b') => '\u{8}',
            Some('f') => '\u{c}',
            Some(c @ ('"' | '\\' | '/')) => c,
            Some('u') => return self.unicode(),
            _ => return Err(self.wrong("an unknown `\\` in a text".into(), "write a backslash as `\\\\`")),
        };
        Ok(simple)
    }

    fn unicode(&mut self) -> Read<char> {
        let high = self.hexadecimal()?;
        // Characters beyond the first plane are written as two halves.
        let code = match high {
            0xd800..0xdc00 if self.text[self.at..].starts_with("\\u") => {
                self.at += 2;
                let low = self.hexadecimal()?;
                0x10000 + ((high - 0xd800) << 10) + (low.wrapping_sub(0xdc00) & 0x3ff)
            }
            code => code,
        };
        Ok(char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER))
    }

    fn hexadecimal(&mut self) -> Read<u32> {
        let digits = self.text.get(self.at..self.at + 4).filter(|digits| digits.chars().all(|c| c.is_ascii_hexdigit()));
        match digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()) {
            Some(code) => {
                self.at += 4;
                Ok(code)
            }
            None => Err(self.wrong("expected four digits behind `\\u`".into(), "save the file again as JSON")),
        }
    }

    fn number(&mut self) -> Read<Value> {
        let rest = &self.text[self.at..];
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c))).unwrap_or(rest.len());
        let text = &rest[..end];
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.at += end;
                Ok(Value::Number(value, !text.contains(['.', 'e', 'E'])))
            }
            _ => {
                let found = shorten(text);
                Err(self.wrong(format!("expected a number, found `{found}`"), "numbers are e.g. `12` or `-0.5`"))
            }
        }
    }

    fn word(&mut self) -> Read<Value> {
        let found = self.here();
        for word in ["true", "false", "null"] {
            if found == format!("`{word}`") {
                self.at += word.len();
                return Ok(Value::Word(word.into()));
            }
        }
        let hint = match found.as_str() {
            "`NaN`" | "`Infinity`" => "JSON has no such number: give the point a place, or remove it",
            "`,`" => "a value is missing between two commas",
            "the end of the file" => "the file is empty or cut short: save it again",
            _ if found.starts_with("`#") || found.starts_with("`//") => "JSON has no comments: remove them",
            _ if found.starts_with("`'") => "put texts between double quotes",
            _ => "values are numbers, texts in double quotes, lists and maps",
        };
        Err(self.wrong(format!("expected a value, found {found}"), hint))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn wrong(text: &str) -> (usize, String, String) {
        let (line, wrong) = parse(text).unwrap_err();
        (line, wrong.message.trim_start_matches("not valid JSON: ").into(), wrong.hint)
    }

    #[test]
    fn what_people_write_instead_of_json_is_told_with_its_line() {
        let told = |text: &str| {
            let (line, message, _) = wrong(text);
            format!("{line}: {message}")
        };
        assert_eq!(told("[\n[1, 2],\n]"), "3: a comma before `]`");
        assert_eq!(told("{\"a\": 1,}"), "1: a comma before `}`");
        assert_eq!(told("[1; 2]"), "1: expected `,` or `]`, found `;`");
        assert_eq!(told("[1\n2]"), "2: expected `,` or `]`, found `2`");
        assert_eq!(told("{a: 1}"), "1: expected a name in quotes, found `a`");
        assert_eq!(told("[NaN]"), "1: expected a value, found `NaN`");
        assert_eq!(told("[1.2.3]"), "1: expected a number, found `1.2.3`");
        assert_eq!(told("[1"), "1: the file ends inside a list: expected `]`");
        assert_eq!(told("{\"a\": 1, \"a\": 2}"), "1: the name `a` comes a second time");
        assert_eq!(told("[1] [2]"), "1: expected the end, found `[`");
        assert_eq!(told(&"[".repeat(100)), "1: nested too deeply");
        assert_eq!(told(""), "1: expected a value, found the end of the file");
        assert!(wrong("['a']").2.contains("double quotes"));
    }

    #[test]
    fn values_keep_their_lines_and_whether_numbers_are_whole() {
        let Value::List(items) = parse("[\r\n 1, 1.0,\n \"\\u00e9\\ud83d\\ude00\"]").unwrap().value else {
            panic!("a list")
        };
        assert_eq!(items[0], Node { line: 2, value: Value::Number(1.0, true) });
        assert_eq!(items[1].value, Value::Number(1.0, false));
        assert_eq!(items[2], Node { line: 3, value: Value::Text("é😀".into()) });
    }

    fn same(node: &Node, other: &serde_json::Value) -> bool {
        match (&node.value, other) {
            (Value::Number(a, _), serde_json::Value::Number(b)) => Some(*a) == b.as_f64(),
            (Value::Text(a), serde_json::Value::String(b)) => a == b,
            (Value::Word(a), serde_json::Value::Bool(b)) => *a == b.to_string(),
            (Value::Word(a), serde_json::Value::Null) => a == "null",
            (Value::List(a), serde_json::Value::Array(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
            }
            (Value::Map(a), serde_json::Value::Object(b)) => {
                a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
            }
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "([\\[\\]{},:\"\\\\ué \n]|[0-9.eE+-]{1,4}|null|true){0,30}") {
            let _ = parse(&text);
        }

        #[test]
        fn what_serde_writes_is_read_alike(
            map in prop::collection::btree_map(".{0,6}", (any::<i32>(), -1e9..1e9f64, prop::option::of(".{0,6}"), any::<bool>()), 0..5)
        ) {
            let value = serde_json::json!([map]);
            let node = parse(&serde_json::to_string_pretty(&value).unwrap()).unwrap();
            prop_assert!(same(&node, &value));
        }
    }
}
