//! Changes of JSON that leave it JSON.

use mimesh_core::random::Random;
use serde_json::{Value, json};

use crate::bytes::{NUMBERS, raw, text};

/// A change of the JSON in `bytes`; of their text if they are none.
pub fn json(random: &mut Random, bytes: &[u8], words: &[&str]) -> Vec<u8> {
    let Ok(mut tree) = serde_json::from_slice::<Value>(bytes) else { return text(random, bytes.to_vec(), words) };
    for _ in 0..=random.index(3) {
        let count = count(&tree);
        let donor = node(&mut tree, &mut random.index(count)).map(|value| value.clone()).unwrap_or_default();
        if let Some(value) = node(&mut tree, &mut random.index(count)) {
            change(random, value, donor, words);
        }
    }
    tree.to_string().into_bytes()
}

/// A change of a GLB, whose lengths fit afterwards; of its bytes if it is none.
pub fn glb(random: &mut Random, bytes: &[u8], words: &[&str]) -> Vec<u8> {
    let length = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?) as usize);
    let parts = length(12).and_then(|size| {
        let end = 20 + size;
        Some((bytes.get(20..end)?, bytes.get(end + 8..end + 8 + length(end)?)?))
    });
    let Some((text, binary)) = parts else { return raw(random, bytes.to_vec()) };
    let (text, binary) = match random.index(4) {
        0 => (text.to_vec(), raw(random, binary.to_vec())),
        1 => (json(random, text, words), raw(random, binary.to_vec())),
        _ => (json(random, text, words), binary.to_vec()),
    };
    let chunk = |kind: &[u8; 4], mut data: Vec<u8>, blank: u8| {
        data.resize(data.len().next_multiple_of(4), blank);
        [&(data.len() as u32).to_le_bytes(), &kind[..], &data].concat()
    };
    let chunks = [chunk(b"JSON", text, b' '), chunk(b"BIN\0", binary, 0)].concat();
    [&b"glTF\x02\0\0\0"[..], &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}

fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(items) => items.iter().map(count).sum(),
        Value::Object(entries) => entries.values().map(count).sum(),
        _ => 0,
    }
}

/// The value number `left` of a tree, in the order of its text.
fn node<'a>(value: &'a mut Value, left: &mut usize) -> Option<&'a mut Value> {
    if *left == 0 {
        return Some(value);
    }
    *left -= 1;
    match value {
        Value::Array(items) => items.iter_mut().find_map(|item| node(item, left)),
        Value::Object(entries) => entries.values_mut().find_map(|item| node(item, left)),
        _ => None,
    }
}

fn change(random: &mut Random, value: &mut Value, donor: Value, words: &[&str]) {
    let number = || NUMBERS.iter().filter_map(|number| serde_json::from_str::<Value>(number).ok()).collect::<Vec<_>>();
    match (random.index(6), &mut *value) {
        (0, _) => *value = donor,
        (1, Value::Array(items)) if !items.is_empty() => _ = items.remove(random.index(items.len())),
        (2, Value::Array(items)) if !items.is_empty() => {
            let copies = vec![items[random.index(items.len())].clone(); 1 + random.index(200)];
            items.extend(copies);
        }
        (1 | 2, Value::Object(entries)) if !entries.is_empty() => {
            let key = entries.keys().nth(random.index(entries.len())).cloned().unwrap_or_default();
            entries.remove(&key);
        }
        (3, Value::Object(entries)) if !words.is_empty() => {
            entries.insert(words[random.index(words.len())].into(), donor);
        }
        (4, _) if !words.is_empty() => *value = json!(words[random.index(words.len())]),
        _ => *value = number().swap_remove(random.index(number().len())),
    }
}
