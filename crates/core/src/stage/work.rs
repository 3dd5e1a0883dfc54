//! How much of a long work is done.

use std::{
    fmt,
    sync::atomic::{AtomicUsize, Ordering},
};

/// Long work under way, which reports how much of it is done.
///
/// Whoever waits shows the share that is done and the time that is left. So a share is one of time: a stage divides its work into
/// [`parts`](Self::parts) by what they cost. A stage may also report nothing. Results never depend on what is reported.
#[derive(Clone, Copy, Default)]
pub struct Work<'a> {
    report: Option<&'a (dyn Fn(f64) + Sync)>,
    from: f64,
    to: f64,
}

impl<'a> Work<'a> {
    /// Work that nobody waits for.
    pub const UNWATCHED: Work<'static> = Work { report: None, from: 0.0, to: 1.0 };

    /// Work whose share done, from 0 to 1, is told to `report`, from any thread. Parts that are done side by side may report a share
    /// that is less than one before.
    pub fn new(report: &'a (dyn Fn(f64) + Sync)) -> Self {
        Self { report: Some(report), from: 0.0, to: 1.0 }
    }

    /// Reports that `share` of this work is done, from 0 to 1.
    pub fn done(&self, share: f64) {
        if let Some(report) = self.report
            && share.is_finite()
        {
            report(self.from + (self.to - self.from) * share.clamp(0.0, 1.0));
        }
    }

    /// The part of this work that begins when the share `from` of it is done, and ends with `to`.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let at = |share: f64| self.from + (self.to - self.from) * share.clamp(0.0, 1.0);
        Self { from: at(from), to: at(to), ..*self }
    }

    /// Parts that are done one after the other, by their costs in any unit.
    pub fn parts<const N: usize>(&self, costs: [f64; N]) -> [Self; N] {
        let sum: f64 = costs.iter().sum();
        let mut end = 0.0;
        costs.map(|cost| {
            let from = end;
            end += cost / sum.max(f64::MIN_POSITIVE);
            self.part(from, end)
        })
    }

    /// Parts that are done in any order, on any thread, and together cost `total`.
    pub fn tally(&self, total: usize) -> Tally<'a> {
        Tally { work: *self, total, done: AtomicUsize::new(0) }
    }
}

impl fmt::Debug for Work<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { report, from, to } = self;
        write!(f, "Work {{ from: {from}, to: {to}, is_watched: {} }}", report.is_some())
    }
}

/// The parts of a [`Work`] that are done in any order.
#[derive(Debug)]
pub struct Tally<'a> {
    work: Work<'a>,
    total: usize,
    done: AtomicUsize,
}

impl Tally<'_> {
    /// Reports that parts of this `cost` are done.
    pub fn add(&self, cost: usize) {
        let done = self.done.fetch_add(cost, Ordering::Relaxed) + cost;
        self.work.done(done as f64 / self.total.max(1) as f64);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use rayon::prelude::*;

    use super::*;

    fn reported(work: impl FnOnce(Work<'_>)) -> Vec<f64> {
        let shares = Mutex::new(vec![]);
        work(Work::new(&|share| shares.lock().unwrap().push(share)));
        shares.into_inner().unwrap()
    }

    #[test]
    fn parts_fill_the_whole_by_their_costs() {
        let shares = reported(|work| {
            let [first, second] = work.parts([1.0, 3.0]);
            first.done(1.0);
            let [half, rest] = second.parts([2.0, 2.0]);
            half.done(0.5);
            half.done(1.0);
            rest.done(1.0);
        });
        assert_eq!(shares, [0.25, 0.4375, 0.625, 1.0]);
    }

    #[test]
    fn parts_in_any_order_end_with_the_whole() {
        let shares = reported(|work| {
            let tally = work.part(0.5, 1.0).tally(100);
            (0..50).into_par_iter().for_each(|_| tally.add(2));
        });
        assert_eq!(shares.len(), 50);
        assert_eq!(shares.iter().copied().fold(0.0, f64::max), 1.0);
        assert!(shares.iter().all(|share| (0.5..=1.0).contains(share)));
    }

    #[test]
    fn no_report_leaves_its_part_and_none_is_no_number() {
        let shares = reported(|work| {
            work.part(0.2, 0.4).done(7.0);
            work.part(0.2, 0.4).done(-7.0);
            work.done(f64::NAN);
            work.parts([0.0, 0.0])[1].done(1.0);
            work.tally(0).add(0);
        });
        assert_eq!(shares, [0.4, 0.2, 0.0, 0.0]);
    }

    #[test]
    fn unwatched_work_reports_to_nobody() {
        Work::UNWATCHED.done(0.5);
        Work::default().tally(2).add(1);
    }
}
