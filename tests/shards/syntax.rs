//! Laws of frames and shards, for numbers drawn at random.

use std::collections::BTreeSet;

use mimesh::{
    core::testkit::random::Random,
    pipeline::shard::{Frames, Shard, in_ranges},
};

/// A whole number from 0 below `end`.
fn below(random: &mut Random, end: usize) -> usize {
    (random.between(0.0, end as f64) as usize).min(end - 1)
}

#[test]
fn what_is_written_as_ranges_is_read_as_the_same_frames() {
    let mut random = Random::new(1);
    for _ in 0..500 {
        let poses = 1 + below(&mut random, 60);
        let chosen: BTreeSet<usize> = (0..1 + below(&mut random, poses)).map(|_| below(&mut random, poses)).collect();
        let chosen: Vec<usize> = chosen.into_iter().collect();
        let text = in_ranges(&chosen);
        assert_eq!(text.parse::<Frames>().expect(&text).of(poses).expect(&text), chosen, "{text}");
    }
}

#[test]
fn a_list_is_the_union_of_its_ranges_in_any_order() {
    let mut random = Random::new(2);
    for _ in 0..500 {
        let mut expected = BTreeSet::new();
        let mut parts = Vec::new();
        for _ in 0..1 + below(&mut random, 5) {
            let (first, length, step) = (below(&mut random, 40), below(&mut random, 30), 1 + below(&mut random, 9));
            let last = first + length;
            let mut frame = first;
            while frame <= last {
                expected.insert(frame);
                frame += step;
            }
            parts.push(format!("{first}-{last}:{step}"));
        }
        let text = parts.join(",");
        let frames = text.parse::<Frames>().expect(&text);
        let expected: Vec<usize> = expected.into_iter().collect();
        let poses = expected.last().expect("a frame") + 1;
        assert_eq!(frames.of(poses).expect(&text), expected, "{text}");
        assert!(frames.of(poses - 1).is_err(), "{text} lies beyond the last of {}", poses - 1);
        // As it is shown it is read again.
        assert_eq!(frames.to_string().parse::<Frames>().expect("frames").of(poses), Ok(expected));
    }
}

#[test]
fn shards_are_disjoint_and_together_all_poses() {
    let mut random = Random::new(3);
    for _ in 0..500 {
        let (poses, of) = (below(&mut random, 2000), 1 + below(&mut random, 300));
        let shards: Vec<Shard> = (0..of).map(|number| format!("{number}/{of}").parse().expect("a shard")).collect();
        let all: Vec<usize> = shards.iter().flat_map(|shard| shard.range(poses)).collect();
        assert_eq!(all, (0..poses).collect::<Vec<_>>(), "{poses} poses in {of} shards");
    }
}
