//! Lines that begin with no word of an OBJ, and are kept as they are.

use crate::names::shown;

/// The words that lines begin with, of polygons, curves, surfaces, looks and old versions alike, beside those that are read.
const KNOWN: [&str; 50] = [
    "v",
    "vt",
    "vn",
    "vp",
    "f",
    "fo",
    "o",
    "g",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "l",
    "p",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "cstype",
    "deg",
    "bmat",
    "step",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "call",
    "csh",
    "res",
    "bsp",
    "bzp",
    "cdc",
    "cdp",
    "ctmap",
    "vw",
    "sf",
    "vc",
    "mm_gid",
];

/// The lines of a file that are not known.
#[derive(Debug, Default)]
pub struct UnknownLines {
    count: usize,
    /// The first, with its number.
    first: Option<(usize, String)>,
}

impl UnknownLines {
    /// Counts a line that begins with `word`, if that is none of an OBJ.
    pub fn add(&mut self, word: &[u8], line: usize) {
        // Zeros fill up files.
        let is_known = KNOWN.iter().any(|known| known.as_bytes() == word) || word.iter().all(|&byte| byte == 0);
        if !is_known {
            self.count += 1;
            self.first.get_or_insert_with(|| (line, shown(&String::from_utf8_lossy(word))));
        }
    }

    /// The sentence about them.
    pub fn warning(&self) -> Option<String> {
        let (line, word) = self.first.as_ref()?;
        Some(format!(
            "lines that begin with no word of an OBJ are not read: {}, the first `{word}` (line {line})",
            self.count
        ))
    }
}
