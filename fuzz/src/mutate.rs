//! Bytes made out of others.

use mimesh_core::random::Random;

use crate::{
    bytes::{raw, text},
    target::{Form, Target},
    tree,
};

/// No file grows beyond this.
const MAX_LENGTH: usize = 1 << 16;

/// A mutation of `bytes`, of which a part may come from `other`.
pub fn mutated(random: &mut Random, target: &Target, bytes: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = match target.form {
        Form::Json if random.unit() < 0.7 => tree::json(random, bytes, target.words),
        Form::Glb if random.unit() < 0.8 => tree::glb(random, bytes, target.words),
        form => plain(random, form, bytes, other, target.words),
    };
    bytes.truncate(MAX_LENGTH);
    bytes
}

/// A mutation without regard to a tree.
fn plain(random: &mut Random, form: Form, bytes: &[u8], other: &[u8], words: &[&str]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.index(4) {
        let is_text = form == Form::Text || random.unit() < 0.4;
        bytes = if is_text { text(random, bytes, words) } else { raw(random, bytes) };
        if random.unit() < 0.05 {
            let (end, start) = (random.index(bytes.len() + 1), random.index(other.len() + 1));
            bytes.truncate(end);
            bytes.extend_from_slice(&other[start..]);
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mutations_differ_are_bounded_and_come_back_with_their_seed() {
        let bytes = b"solid a\nfacet normal 0 0 1\n".repeat(20);
        for target in crate::targets() {
            let all = |seed| -> Vec<Vec<u8>> {
                let mut random = Random::new(seed);
                (0..100).map(|_| mutated(&mut random, &target, &bytes, b"other")).collect()
            };
            let mutations = all(1);
            assert_eq!(mutations, all(1), "{}", target.name);
            assert!(mutations.iter().filter(|mutation| **mutation != bytes).count() > 50, "{}", target.name);
            assert!(mutations.iter().all(|mutation| mutation.len() <= MAX_LENGTH));
        }
    }
}
