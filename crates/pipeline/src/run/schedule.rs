//! Poses on their way through a run: several at a time, without waiting for each other, their results in order.

use std::{
    collections::BTreeMap,
    ops::Range,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use rayon::Scope;

use crate::metrics::MEASURED_BEFORE as BEFORE;

/// How poses go through, which are numbered by their places in the order of the run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    /// The number of poses.
    pub count: usize,
    /// The most poses of a batch.
    pub batch: usize,
    /// Whether a batch begins only when the one before it has ended.
    pub in_order: bool,
}

/// What is done with poses. Batches are posed and poses are finished side by side; they are collected one after the other.
pub(super) trait Steps: Sync {
    /// A pose that others may look at.
    type Posed: Send + Sync;
    /// What is made of it.
    type Output: Send;
    /// An error that ends all.
    type Error: Send;

    /// The poses of a batch.
    fn pose(&self, batch: Range<usize>) -> Result<Vec<Self::Posed>, Self::Error>;

    /// What is made of pose `i`; `before` has the poses before it, the last one first.
    fn finish(&self, i: usize, posed: &Self::Posed, before: [Option<&Self::Posed>; BEFORE]) -> Self::Output;
}

impl Schedule {
    /// The most poses under way, and the most that are posed side by side.
    pub fn at_once(self) -> [usize; 2] {
        let posed = if self.in_order { self.batch } else { self.batch * rayon::current_num_threads() };
        [self.window(self.batch), posed].map(|count| count.min(self.count))
    }

    fn window(self, batch: usize) -> usize {
        batch * if self.in_order { 2 } else { 2 * rayon::current_num_threads() }
    }

    /// Sends all poses through `steps` on the threads of the current pool, and hands each to `collect` in order. The number of poses
    /// under way does not grow with their count.
    pub fn run<S: Steps>(
        self,
        steps: &S,
        collect: impl FnMut(usize, &S::Posed, S::Output) -> Result<(), S::Error> + Send,
    ) -> Result<(), S::Error> {
        // Of even size, so that no thread is left with a much smaller one.
        let batches = self.count.div_ceil(self.batch.max(1)).max(1);
        let batch = self.count.div_ceil(batches).max(1);
        let window = self.window(batch);
        let run = Run {
            schedule: Self { batch, ..self },
            window,
            steps,
            collect: Mutex::new(collect),
            state: Mutex::new(State {
                started: 0,
                in_batches: 0,
                posed: BTreeMap::new(),
                is_finishing: vec![false; self.count],
                outputs: BTreeMap::new(),
                collected: 0,
                is_collecting: false,
                error: None,
            }),
        };
        rayon::scope(|scope| run.advance(scope));
        let State { error, .. } = run.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        error.map_or(Ok(()), Err)
    }
}

/// A run under way.
struct Run<'a, S: Steps, C> {
    schedule: Schedule,
    /// The most poses that have begun and are not collected.
    window: usize,
    steps: &'a S,
    collect: Mutex<C>,
    state: Mutex<State<S>>,
}

struct State<S: Steps> {
    /// Poses whose batch has begun.
    started: usize,
    /// Batches under way.
    in_batches: usize,
    /// Poses that are done, as long as others may look at them.
    posed: BTreeMap<usize, Arc<S::Posed>>,
    is_finishing: Vec<bool>,
    outputs: BTreeMap<usize, S::Output>,
    /// Poses that were collected, or are being.
    collected: usize,
    is_collecting: bool,
    error: Option<S::Error>,
}

/// The next thing to be done.
enum Task<S: Steps> {
    Pose(Range<usize>),
    Finish(usize),
    Collect(usize, Arc<S::Posed>, S::Output),
}

impl<S: Steps, C: FnMut(usize, &S::Posed, S::Output) -> Result<(), S::Error> + Send> Run<'_, S, C> {
    fn state(&self) -> MutexGuard<'_, State<S>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins all that can begin. No task waits for another, so that threads are never blocked.
    fn advance<'s>(&'s self, scope: &Scope<'s>) {
        let tasks = self.state().tasks(self.schedule, self.window);
        for task in tasks {
            scope.spawn(move |scope| {
                self.perform(task);
                self.advance(scope);
            });
        }
    }

    fn perform(&self, task: Task<S>) {
        match task {
            Task::Pose(batch) => {
                let posed = self.steps.pose(batch.clone());
                let mut state = self.state();
                state.in_batches -= 1;
                match posed {
                    Ok(posed) => state.posed.extend(batch.zip(posed.into_iter().map(Arc::new))),
                    Err(error) => state.fail(error),
                }
            }
            Task::Finish(i) => {
                let posed = |i: usize| self.state().posed.get(&i).cloned();
                let before: [_; BEFORE] = std::array::from_fn(|back| i.checked_sub(back + 1).and_then(posed));
                if let Some(own) = posed(i) {
                    let output = self.steps.finish(i, &own, before.each_ref().map(Option::as_deref));
                    self.state().outputs.insert(i, output);
                }
            }
            Task::Collect(i, posed, output) => {
                let mut collect = self.collect.lock().unwrap_or_else(PoisonError::into_inner);
                let collected = collect(i, &posed, output);
                let mut state = self.state();
                state.is_collecting = false;
                if let Err(error) = collected {
                    state.fail(error);
                }
            }
        }
    }
}

impl<S: Steps> State<S> {
    fn fail(&mut self, error: S::Error) {
        self.error.get_or_insert(error);
    }

    /// The tasks that can begin, those last that a thread should take first.
    fn tasks(&mut self, schedule: Schedule, window: usize) -> Vec<Task<S>> {
        let mut tasks = Vec::new();
        if self.error.is_some() {
            return tasks;
        }
        let is_free = |state: &Self| {
            let end = (state.started + schedule.batch).min(schedule.count);
            state.started < end && end - state.collected <= window && !(schedule.in_order && state.in_batches > 0)
        };
        while is_free(self) {
            let end = (self.started + schedule.batch).min(schedule.count);
            tasks.push(Task::Pose(self.started..end));
            (self.started, self.in_batches) = (end, self.in_batches + 1);
        }
        for i in self.collected..self.started {
            let is_ready = (i.saturating_sub(BEFORE)..=i).all(|i| self.posed.contains_key(&i));
            if is_ready && !self.is_finishing[i] {
                self.is_finishing[i] = true;
                tasks.push(Task::Finish(i));
            }
        }
        let next = self.collected;
        if !self.is_collecting
            && let (Some(posed), Some(_)) = (self.posed.get(&next), self.outputs.get(&next))
        {
            let posed = posed.clone();
            if let Some(output) = self.outputs.remove(&next) {
                tasks.push(Task::Collect(next, posed, output));
            }
            (self.collected, self.is_collecting) = (next + 1, true);
            // Poses after this one look no farther back.
            self.posed = self.posed.split_off(&(next + 1).saturating_sub(BEFORE));
        }
        tasks
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Squares numbers, and adds up those before them.
    struct Squares {
        under_way: AtomicUsize,
        most: AtomicUsize,
        fails_at: Option<usize>,
    }

    impl Squares {
        fn new(fails_at: Option<usize>) -> Self {
            Self { under_way: AtomicUsize::new(0), most: AtomicUsize::new(0), fails_at }
        }
    }

    impl Steps for Squares {
        type Posed = usize;
        type Output = [usize; 3];
        type Error = usize;

        fn pose(&self, batch: Range<usize>) -> Result<Vec<usize>, usize> {
            let now = self.under_way.fetch_add(batch.len(), Ordering::SeqCst) + batch.len();
            self.most.fetch_max(now, Ordering::SeqCst);
            std::thread::sleep(std::time::Duration::from_micros((batch.start as u64 * 7919) % 300));
            batch.map(|i| if self.fails_at == Some(i) { Err(i) } else { Ok(i * i) }).collect()
        }

        fn finish(&self, _: usize, posed: &usize, before: [Option<&usize>; BEFORE]) -> [usize; 3] {
            // Nested parallel work must not come to a halt.
            let own: usize = rayon::join(|| *posed, || 0).0;
            [own, before[0].map_or(0, |x| *x), before[1].map_or(0, |x| *x)]
        }
    }

    fn run(threads: usize, schedule: Schedule, squares: &Squares) -> (Result<(), usize>, Vec<[usize; 3]>) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut collected = Vec::new();
        let result = pool.install(|| {
            schedule.run(squares, |i, posed, output| {
                assert_eq!((i, *posed), (collected.len(), output[0]));
                collected.push(output);
                squares.under_way.fetch_sub(1, Ordering::SeqCst);
                Ok(())
            })
        });
        (result, collected)
    }

    #[test]
    fn results_come_in_order_with_those_before_them() {
        let square = |i: Option<usize>| i.map_or(0, |i| i * i);
        for threads in [1, 2, 5] {
            for (count, batch, in_order) in
                [(0, 4, false), (1, 8, false), (100, 8, false), (101, 1, false), (57, 4, true)]
            {
                let squares = Squares::new(None);
                let schedule = Schedule { count, batch, in_order };
                let (result, collected) = run(threads, schedule, &squares);
                assert_eq!(result, Ok(()));
                let expected: Vec<_> =
                    (0..count).map(|i| [square(Some(i)), square(i.checked_sub(1)), square(i.checked_sub(2))]).collect();
                assert_eq!(collected, expected, "{threads} threads, {schedule:?}");
                assert!(
                    squares.most.load(Ordering::SeqCst) <= 2 * threads.max(1) * batch,
                    "poses under way are bounded"
                );
            }
        }
    }

    #[test]
    fn an_error_ends_all() {
        let (result, collected) = run(2, Schedule { count: 100, batch: 4, in_order: false }, &Squares::new(Some(50)));
        assert_eq!(result, Err(50));
        assert!(collected.len() < 100);
    }
}
