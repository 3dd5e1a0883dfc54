//! What a run reports while it is under way.

use std::sync::atomic::{AtomicU64, Ordering};

/// Receives the progress of a run.
pub trait Progress: Sync {
    /// A stage begins, e.g. `correspondence (nonrigid_fit)`.
    fn stage(&self, _name: &str) {}

    /// This share of the stage under way is done, from 0 to 1. Stages that do not tell never call it.
    fn done(&self, _share: f64) {}

    /// The poses begin; there are `count`.
    fn poses(&self, _count: usize) {}

    /// A pose is done, or has failed.
    fn pose_done(&self) {}

    /// Something was done that the user has to know even if the run fails; a run that gives results has it among its warnings too.
    fn warning(&self, _text: &str) {}
}

/// Passes on shares that are done, unless more was done before.
#[derive(Debug, Default)]
pub(crate) struct Rising {
    /// The bits of the largest share; numbers that are not negative have the order of their bits.
    most: AtomicU64,
}

impl Rising {
    /// Passes `share` to `report` if it is larger than all before.
    pub fn pass(&self, share: f64, report: impl FnOnce(f64)) {
        let share = share.max(0.0);
        if self.most.fetch_max(share.to_bits(), Ordering::Relaxed) < share.to_bits() {
            report(share);
        }
    }
}

/// The time that work still takes, by how much of it was done at what time.
///
/// What is left is done at the speed of the latter half of the time so far: results from a cache come first and in no time, and
/// a part of a stage may be dearer than its share. Times are in seconds since the work began.
#[derive(Clone, Debug, Default)]
pub struct TimeLeft {
    /// Times and shares, both rising.
    reports: Vec<[f64; 2]>,
}

/// Reports that are less apart than this share are taken together.
const MIN_STEP: f64 = 1e-3;

/// Before this share is done, or this time has passed, nothing is said.
const MIN_SHARE: f64 = 0.01;
const MIN_SECONDS: f64 = 0.5;

impl TimeLeft {
    /// At `time` the share `done` is done, from 0 to 1; one that is not larger than before says nothing.
    pub fn report(&mut self, time: f64, done: f64) {
        let before = self.reports.last().map_or(0.0, |report| report[1]);
        if done < before + MIN_STEP && done < 1.0 || done <= before {
            return;
        }
        self.reports.push([time, done.min(1.0)]);
    }

    /// The share that is done.
    pub fn share(&self) -> f64 {
        self.reports.last().map_or(0.0, |report| report[1])
    }

    /// Seconds that are left at `now`; `None` if too little is known.
    pub fn seconds(&self, now: f64) -> Option<f64> {
        let &[time, done] = self.reports.last()?;
        if done < MIN_SHARE || now < MIN_SECONDS {
            return None;
        }
        // What was done at about half the time.
        let half = self.reports.partition_point(|report| report[0] <= time / 2.0);
        let [from_time, from_done] = half.checked_sub(1).map_or([0.0, 0.0], |i| self.reports[i]);
        let speed = (done - from_done) / (time - from_time).max(f64::MIN_POSITIVE);
        let left = (1.0 - done) / speed - (now - time);
        // A report that is overdue: the next step is about as long as the last, and is not done yet.
        let before = self.reports.len().checked_sub(2).map_or(0.0, |i| self.reports[i][1]);
        let next = (done + (done - before)).min(1.0);
        let slower = (next - from_done) / (now - from_time).max(f64::MIN_POSITIVE);
        Some(left.max((1.0 - next) / slower.max(f64::MIN_POSITIVE)).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The estimate at `now` of work that reports what `done` gives at the times `reports`.
    fn left(reports: impl Iterator<Item = f64>, done: impl Fn(f64) -> f64, now: f64) -> f64 {
        let mut left = TimeLeft::default();
        reports.take_while(|time| *time <= now).for_each(|time| left.report(time, done(time)));
        left.seconds(now).expect("an estimate")
    }

    #[test]
    fn even_work_tells_the_time_that_is_left() {
        let times = || (1..1000).map(|i| f64::from(i) * 0.1);
        for now in [2.0, 25.0, 50.0, 75.0, 99.0] {
            assert!((left(times(), |time| time / 100.0, now) - (100.0 - now)).abs() < 0.2, "at {now}");
        }
    }

    #[test]
    fn time_left_falls_between_reports_that_are_rare() {
        // A report every 10 of 100 seconds.
        let times = || (1..10).map(|i| f64::from(i) * 10.0);
        for now in [12.0, 25.0, 58.0, 79.9] {
            assert!((left(times(), |time| time / 100.0, now) - (100.0 - now)).abs() < 1e-9, "at {now}");
        }
    }

    #[test]
    fn a_report_that_is_overdue_makes_it_more() {
        let mut left = TimeLeft::default();
        (1..=5).for_each(|i| left.report(f64::from(i), f64::from(i) / 10.0));
        assert_eq!(left.seconds(5.0), Some(5.0));
        // The sixth step takes 4 seconds and more.
        let waited = left.seconds(9.0).expect("an estimate");
        assert!((4.0..8.0).contains(&waited), "{waited}");
    }

    #[test]
    fn results_that_were_there_before_say_nothing_of_the_rest() {
        // Half was cached; the rest takes 100 seconds.
        let done = |time: f64| if time <= 1.0 { 0.5 * time } else { 0.5 + 0.5 * (time - 1.0) / 100.0 };
        let times = || (1..2000).map(|i| f64::from(i) * 0.05);
        for now in [26.0, 51.0, 76.0] {
            let found = left(times(), done, now);
            assert!((found - (101.0 - now)).abs() < 0.05 * (101.0 - now), "{found} at {now}");
        }
    }

    #[test]
    fn too_little_is_no_estimate_and_shares_never_fall() {
        let mut left = TimeLeft::default();
        assert_eq!(left.seconds(10.0), None);
        left.report(0.1, 0.5);
        assert_eq!(left.seconds(0.2), None);
        left.report(1.0, 0.4);
        assert_eq!(left.share(), 0.5);
        left.report(2.0, 1.0);
        assert_eq!(left.seconds(2.0), Some(0.0));
        let rising = Rising::default();
        let mut passed = vec![];
        [0.2, 0.1, 0.2, 0.3, -1.0].into_iter().for_each(|share| rising.pass(share, |share| passed.push(share)));
        assert_eq!(passed, [0.2, 0.3]);
    }
}
