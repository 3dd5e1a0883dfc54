//! Changes of bytes and of texts, without regard to what they mean.

use mimesh_core::random::Random;

/// Numbers at the edges of what readers count with.
pub const NUMBERS: [&str; 24] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "255",
    "256",
    "65535",
    "65536",
    "16777216",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551615",
    "0.5",
    "1e38",
    "3.5e38",
    "1e308",
    "1e-320",
    "nan",
    "inf",
];

/// The same as 32-bit words.
const WORDS: [u32; 14] = [
    0,
    1,
    2,
    0x7f,
    0xff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7f80_0000,
    0xff80_0000,
    0x7fc0_0000,
    0x7f7f_ffff,
    1,
];

/// A part of `bytes`, as a range.
fn part(random: &mut Random, length: usize) -> std::ops::Range<usize> {
    let start = random.index(length + 1);
    start..(start + 1 + random.index(32)).min(length)
}

/// A change of bytes.
pub fn raw(random: &mut Random, mut bytes: Vec<u8>) -> Vec<u8> {
    if bytes.is_empty() {
        return vec![random.bits() as u8];
    }
    let at = random.index(bytes.len());
    match random.index(7) {
        0 => bytes[at] ^= 1 << random.index(8),
        1 => bytes[at] = random.bits() as u8,
        2 | 3 => {
            let word = WORDS[random.index(WORDS.len())];
            let word = if random.unit() < 0.5 { word.to_le_bytes() } else { word.to_be_bytes() };
            // Most numbers are aligned.
            let at = if random.unit() < 0.7 { at / 4 * 4 } else { at };
            bytes.iter_mut().skip(at).zip(word).for_each(|(byte, new)| *byte = new);
        }
        4 => _ = bytes.drain(part(random, bytes.len())),
        5 => {
            let copied = bytes[part(random, bytes.len())].repeat(1 + random.index(40));
            bytes.splice(at..at, copied);
        }
        _ => bytes.truncate(at),
    }
    bytes
}

/// A change of words and lines.
pub fn text(random: &mut Random, bytes: Vec<u8>, words: &[&str]) -> Vec<u8> {
    let text = String::from_utf8_lossy(&bytes).into_owned();
    match random.index(6) {
        0 | 1 => {
            let number = NUMBERS[random.index(NUMBERS.len())];
            replaced(random, &text, number)
        }
        2 if !words.is_empty() => {
            let word = words[random.index(words.len())];
            replaced(random, &text, word)
        }
        3 if !words.is_empty() => {
            let at = text.char_indices().nth(random.index(text.chars().count().max(1))).map_or(0, |(at, _)| at);
            [&text[..at], words[random.index(words.len())], " ", &text[at..]].concat().into_bytes()
        }
        4 => {
            let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
            let (from, to) = (random.index(lines.len()), random.index(lines.len()));
            match random.index(3) {
                0 => _ = (!lines.is_empty()).then(|| lines.remove(from)),
                1 if !lines.is_empty() => lines.swap(from, to),
                _ => {
                    let copies = vec![lines.get(from).copied().unwrap_or_default(); 1 + random.index(30)];
                    lines.splice(to..to, copies);
                }
            }
            lines.concat().into_bytes()
        }
        _ => raw(random, bytes),
    }
}

/// The text with `word` in the place of one of its words.
fn replaced(random: &mut Random, text: &str, word: &str) -> Vec<u8> {
    let is_word = |c: char| c.is_alphanumeric() || "+-._".contains(c);
    let starts: Vec<usize> = text
        .char_indices()
        .filter(|(at, c)| is_word(*c) && !text[..*at].ends_with(is_word))
        .map(|(at, _)| at)
        .collect();
    let Some(&start) = starts.get(random.index(starts.len())) else { return [text, word].concat().into_bytes() };
    let end = text[start..].find(|c| !is_word(c)).map_or(text.len(), |length| start + length);
    [&text[..start], word, &text[end..]].concat().into_bytes()
}
