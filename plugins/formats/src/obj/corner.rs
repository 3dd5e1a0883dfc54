//! Corners of faces: `vertex`, `vertex/texture`, `vertex//normal` or `vertex/texture/normal`.

/// The references of one corner, as they stand in the file; 0 where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Corner {
    /// The reference to a `v` line.
    pub vertex: i64,
    /// The reference to a `vt` line.
    pub texture: i64,
    /// The reference to a `vn` line.
    pub normal: i64,
    /// Whether one of the two is a 0 that the file has.
    pub has_zero: bool,
}

impl Corner {
    /// Reads a corner; `None` if `token` is not one.
    pub fn parse(token: &[u8]) -> Option<Self> {
        let mut fields = token.split(|&b| b == b'/');
        let vertex = integer(fields.next()?)?;
        let mut has_zero = false;
        let mut optional = || match fields.next() {
            None | Some([]) => Some(0),
            Some(field) => {
                let index = integer(field)?;
                has_zero |= index == 0;
                Some(index)
            }
        };
        let (texture, normal) = (optional()?, optional()?);
        let corner = Self { vertex, texture, normal, has_zero };
        fields.next().is_none().then_some(corner)
    }
}

/// A decimal integer with an optional sign.
fn integer(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    // Eighteen digits stay below 2^63.
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits.iter().fold(0, |value, digit| value * 10 + i64::from(digit - b'0'));
    Some(if negative { -value } else { value })
}

/// The entry that an index of the file stands for when `count` entries have been read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The entry, from 0; it may come later in the file.
    Entry(u32),
    /// No entry ever: 0, or further back than the first.
    Nothing,
}

impl Reference {
    /// Resolves an index from 1, or from the end if negative.
    pub fn new(index: i64, count: usize) -> Self {
        let entry = if index > 0 { index - 1 } else { index + count as i64 };
        match u32::try_from(entry) {
            Ok(entry) if index != 0 => Self::Entry(entry),
            _ => Self::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_name_up_to_three_entries() {
        let corner = |vertex, texture, normal| Some(Corner { vertex, texture, normal, has_zero: false });
        assert_eq!(Corner::parse(b"7"), corner(7, 0, 0));
        assert_eq!(Corner::parse(b"7/8"), corner(7, 8, 0));
        assert_eq!(Corner::parse(b"7//9"), corner(7, 0, 9));
        assert_eq!(Corner::parse(b"-1/-2/-3"), corner(-1, -2, -3));
        assert_eq!(Corner::parse(b"7/"), corner(7, 0, 0));
        for wrong in [&b""[..], b"/1", b"1.0", b"1/2/3/4", b"--1", b"a", b"99999999999999999999"] {
            assert_eq!(Corner::parse(wrong), None);
        }
    }

    #[test]
    fn negative_indices_count_from_the_last_entry_read() {
        assert_eq!(Reference::new(1, 3), Reference::Entry(0));
        assert_eq!(Reference::new(-1, 3), Reference::Entry(2));
        assert_eq!(Reference::new(-3, 3), Reference::Entry(0));
        assert_eq!(Reference::new(-4, 3), Reference::Nothing);
        assert_eq!(Reference::new(0, 3), Reference::Nothing);
        assert_eq!(Reference::new(1 << 40, 3), Reference::Nothing);
    }
}
