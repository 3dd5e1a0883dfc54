//! Names with a left or right in them.

/// Words for the sides; either may stand for the other.
const WORDS: [[&str; 2]; 3] = [["left", "right"], ["Left", "Right"], ["LEFT", "RIGHT"]];

/// `name` with left and right exchanged, as words (`left ear`, `earLeft`) or as a letter at its end or beginning (`ear_L`,
/// `ear.l`, `L_ear`); `None` if it names no side. Exchanging twice gives `name` again.
pub fn exchange_sides(name: &str) -> Option<String> {
    exchange_words(name).or_else(|| exchange_letter(name))
}

fn exchange_words(name: &str) -> Option<String> {
    let mut result = String::new();
    let mut changed = false;
    let mut at = 0;
    while let Some(c) = name[at..].chars().next() {
        match side_word(name, at) {
            Some((word, other)) => {
                result.push_str(other);
                at += word.len();
                changed = true;
            }
            None => {
                result.push(c);
                at += c.len_utf8();
            }
        }
    }
    changed.then_some(result)
}

/// The word for a side at byte `at` of `name`, and the word for the other side.
///
/// `cleft` and `upright` have none; `earLeft` and `left_ear` have one.
fn side_word(name: &str, at: usize) -> Option<(&'static str, &'static str)> {
    let before = name[..at].chars().next_back();
    let candidates = WORDS.into_iter().flat_map(|[left, right]| [(left, right), (right, left)]);
    candidates.into_iter().find(|(word, _)| {
        let Some(rest) = name[at..].strip_prefix(word) else { return false };
        let capitalized = word.starts_with(char::is_uppercase);
        let begins = match before {
            Some(before) if before.is_alphabetic() => capitalized && before.is_lowercase(),
            _ => true,
        };
        let all_upper = word.chars().all(char::is_uppercase);
        let ends = match rest.chars().next() {
            Some(after) if after.is_alphabetic() => !all_upper && after.is_uppercase(),
            _ => true,
        };
        begins && ends
    })
}

fn exchange_letter(name: &str) -> Option<String> {
    let mut chars: Vec<char> = name.chars().collect();
    match chars[..] {
        [.., separator, last] if is_separator(separator) && other_letter(last).is_some() => {
            *chars.last_mut()? = other_letter(last)?;
        }
        [first, separator, ..] if is_separator(separator) => chars[0] = other_letter(first)?,
        _ => return None,
    }
    Some(chars.into_iter().collect())
}

fn other_letter(c: char) -> Option<char> {
    match c {
        'L' => Some('R'),
        'R' => Some('L'),
        'l' => Some('r'),
        'r' => Some('l'),
        _ => None,
    }
}

fn is_separator(c: char) -> bool {
    "_.- ".contains(c)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn names_have_sides_as_words_and_as_letters() {
        for (name, expected) in [
            ("left ear", "right ear"),
            ("earLeft", "earRight"),
            ("LeftEar", "RightEar"),
            ("EAR_RIGHT", "EAR_LEFT"),
            ("ear_L", "ear_R"),
            ("ear.l", "ear.r"),
            ("R_ear", "L_ear"),
            ("eye L", "eye R"),
        ] {
            assert_eq!(exchange_sides(name).as_deref(), Some(expected));
        }
        for name in ["cleft", "upright", "nose", "leftover", "tail", "L", ""] {
            assert_eq!(exchange_sides(name), None, "{name}");
        }
    }

    proptest! {
        #[test]
        fn exchanging_sides_twice_gives_the_name_again(name in "(left|right|Left|RIGHT|[ a-cL-R_.é]){0,6}") {
            if let Some(other) = exchange_sides(&name) {
                prop_assert_eq!(exchange_sides(&other), Some(name));
            }
        }
    }
}
