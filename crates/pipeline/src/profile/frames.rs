//! The spans that a thread is in, and the time that each of them has of the thread.

use std::{
    cell::RefCell,
    sync::atomic::{AtomicU32, Ordering},
    time::Duration,
};

use cpu_time::ThreadTime;

/// Time on the clock and CPU time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Times {
    /// On the clock.
    pub wall: Duration,
    /// Of the CPU.
    pub cpu: Duration,
}

impl Times {
    /// The clock at `wall`, and the CPU time of this thread so far.
    pub fn of_thread(wall: Duration) -> Self {
        Self { wall, cpu: ThreadTime::try_now().map(|time| time.as_duration()).unwrap_or_default() }
    }

    fn since(self, before: Self) -> Self {
        Self { wall: self.wall.saturating_sub(before.wall), cpu: self.cpu.saturating_sub(before.cpu) }
    }

    fn add(&mut self, other: Self) {
        self.wall += other.wall;
        self.cpu += other.cpu;
    }
}

/// A span that the thread is in.
#[derive(Debug)]
struct Frame {
    /// The numbers of the span and of its ancestors, the span last.
    path: Box<[u64]>,
    entered: Times,
    /// Time in spans that were entered directly within.
    nested: Times,
    /// Time in spans within that are no descendants: work of others, done while this span waited.
    foreign: Times,
}

/// What a span had of a thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Visit {
    /// When it was entered.
    pub start: Duration,
    /// From entering to leaving, with all that was done meanwhile.
    pub whole: Times,
    /// The same without the work of others.
    pub own: Times,
    /// Whether an ancestor was entered on this thread before.
    pub is_within: bool,
    /// The thread.
    pub thread: u32,
}

thread_local! {
    static FRAMES: RefCell<Vec<Frame>> = const { RefCell::new(vec![]) };
    static THREAD: u32 = next_thread();
}

/// Numbers threads in the order in which they enter their first span.
fn next_thread() -> u32 {
    static THREADS: AtomicU32 = AtomicU32::new(0);
    THREADS.fetch_add(1, Ordering::Relaxed)
}

/// This thread enters the span of `path`.
pub(super) fn enter(path: &[u64], now: Times) {
    let frame = Frame { path: path.into(), entered: now, nested: Times::default(), foreign: Times::default() };
    FRAMES.with_borrow_mut(|frames| frames.push(frame));
}

/// This thread leaves the span of `path`; `None` if it is not the last one that it entered.
pub(super) fn leave(path: &[u64], now: Times) -> Option<Visit> {
    FRAMES.with_borrow_mut(|frames| {
        let frame = frames.pop_if(|frame| *frame.path == *path)?;
        let whole = now.since(frame.entered);
        let itself = whole.since(frame.nested);
        if let Some(below) = frames.last_mut() {
            below.nested.add(whole);
        }
        let is_ancestor = |other: &Frame| other.path.last().is_some_and(|number| path.contains(number));
        let is_within = frames.iter().any(is_ancestor);
        frames.iter_mut().filter(|other| !is_ancestor(other)).for_each(|other| other.foreign.add(itself));
        let own = whole.since(frame.foreign);
        Some(Visit { start: frame.entered.wall, whole, own, is_within, thread: THREAD.with(|thread| *thread) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(wall: u64, cpu: u64) -> Times {
        Times { wall: Duration::from_millis(wall), cpu: Duration::from_millis(cpu) }
    }

    #[test]
    fn work_of_another_span_counts_there_only() {
        // 1 is the whole, 2 a part that waits from 20 to 70, 3 another part whose work the thread does from 30 to 60, with 4 in it.
        enter(&[1], at(0, 0));
        enter(&[1, 2], at(10, 10));
        enter(&[1, 3], at(30, 20));
        enter(&[1, 3, 4], at(40, 30));
        let inner = leave(&[1, 3, 4], at(50, 40)).unwrap();
        let other = leave(&[1, 3], at(60, 50)).unwrap();
        let waiting = leave(&[1, 2], at(70, 50)).unwrap();
        let whole = leave(&[1], at(100, 80)).unwrap();
        assert_eq!((inner.own, inner.is_within), (at(10, 10), true));
        assert_eq!(other.own, at(30, 30));
        // 60 ms on the clock, 30 of them for another; 10 of CPU before it waited.
        assert_eq!((waiting.whole, waiting.own), (at(60, 40), at(30, 10)));
        assert_eq!((whole.own, whole.is_within), (at(100, 80), false));
    }

    #[test]
    fn a_span_that_is_left_out_of_turn_is_not_measured() {
        enter(&[7], at(0, 0));
        enter(&[7, 8], at(1, 1));
        assert_eq!(leave(&[7], at(2, 2)), None);
        assert!(leave(&[7, 8], at(3, 3)).is_some());
        assert!(leave(&[7], at(4, 4)).is_some());
    }
}
