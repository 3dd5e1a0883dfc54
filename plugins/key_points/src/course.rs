//! How much of a search is done.
//!
//! Points are added until there are as many as are allowed. The exchanges that follow end when every place was tried without success. How many
//! that takes is not known before; the more often exchanges helped of late, the more are expected.

use mimesh_core::stage::ChoiceWatch;

/// What a step costs beside the part that grows with the points, in costs of a point.
const COST_OF_STEP: f64 = 10.0;

/// An exchange costs this many additions to as many points.
const COST_OF_EXCHANGE: f64 = 1.0;

/// Places that are tried again after an exchange, in numbers of points.
const PLACES_AFTER: f64 = 2.5;

/// How fast earlier exchanges are forgotten: after so many numbers of points.
const MEMORY: f64 = 1.0;

/// The course of a search.
pub struct Course<'a> {
    watch: &'a dyn ChoiceWatch,
    /// Cost of what is done.
    done: f64,
    /// How often exchanges help.
    success: f64,
}

impl<'a> Course<'a> {
    /// A search begins.
    pub fn new(watch: &'a dyn ChoiceWatch) -> Self {
        Self { watch, done: 0.0, success: 1.0 }
    }

    /// A point was added, the `count`-th of `max_count`; up to `max_rounds` rounds of exchanges follow.
    pub fn added(&mut self, count: usize, max_count: usize, max_rounds: usize) {
        self.done += cost(count);
        let additions: f64 = (count + 1..=max_count).map(cost).sum();
        self.tell(additions + self.exchanges(max_count, 0, max_rounds));
    }

    /// A place of `count` was tried, the `unchanged`-th without success since the last exchange.
    pub fn tried(&mut self, count: usize, unchanged: usize, rounds_left: usize) {
        self.done += COST_OF_EXCHANGE * cost(count);
        let weight = 1.0 / (MEMORY * count as f64).max(1.0);
        self.success += weight * (f64::from(u8::from(unchanged == 0)) - self.success);
        self.tell(self.exchanges(count, unchanged, rounds_left));
    }

    /// The cost of exchanges that are still expected among `count` points.
    fn exchanges(&self, count: usize, unchanged: usize, rounds: usize) -> f64 {
        let expected = count.saturating_sub(unchanged) as f64 + PLACES_AFTER * self.success * count as f64;
        expected.min((rounds * count) as f64) * COST_OF_EXCHANGE * cost(count)
    }

    fn tell(&self, left: f64) {
        self.watch.done(self.done / (self.done + left).max(f64::MIN_POSITIVE));
    }
}

/// The cost of adding a point that makes them `count`.
fn cost(count: usize) -> f64 {
    COST_OF_STEP + count as f64
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use mimesh_core::stage::ChoiceStep;

    use super::*;

    #[derive(Default)]
    struct Shares(Mutex<Vec<f64>>);

    impl ChoiceWatch for Shares {
        fn step(&self, _: &ChoiceStep) {}

        fn done(&self, share: f64) {
            self.0.lock().unwrap().push(share);
        }
    }

    #[test]
    fn additions_alone_end_with_the_whole() {
        let shares = Shares::default();
        let mut course = Course::new(&shares);
        (1..=12).for_each(|count| course.added(count, 12, 0));
        let shares = shares.0.into_inner().unwrap();
        assert!(shares.is_sorted(), "{shares:?}");
        assert_eq!(shares.last(), Some(&1.0));
    }

    #[test]
    fn exchanges_that_fail_bring_the_end_nearer_and_those_that_help_put_it_off() {
        let left_after = |successes: [bool; 8]| {
            let shares = Shares::default();
            let mut course = Course::new(&shares);
            (1..=12).for_each(|count| course.added(count, 12, 10));
            let mut unchanged = 0;
            for success in successes {
                unchanged = if success { 0 } else { unchanged + 1 };
                course.tried(12, unchanged, 10);
            }
            1.0 - shares.0.into_inner().unwrap().pop().unwrap()
        };
        // Eight of twelve places are done, and success is expected half as often.
        assert!(left_after([false; 8]) < 0.8 * left_after([true; 8]));
    }
}
