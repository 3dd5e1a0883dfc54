//! Memory that fronts take turns with.

use std::sync::Mutex;

/// Buffers of fewer values than this are made anew, which takes no longer.
const MIN_KEPT: usize = 1 << 12;

/// Buffers that are free, smallest first. What the system gives has to be cleared page by page, so that large ones are kept.
#[derive(Debug, Default)]
pub(super) struct Room {
    free: Mutex<Vec<Vec<f64>>>,
}

impl Room {
    /// A buffer of `size` zeros.
    pub fn take(&self, size: usize) -> Vec<f64> {
        let Some(mut buffer) = self.find(size) else { return vec![0.0; size] };
        buffer.clear();
        buffer.resize(size, 0.0);
        buffer
    }

    /// The smallest free buffer that has room for `size` values, unless it is much larger.
    fn find(&self, size: usize) -> Option<Vec<f64>> {
        if size < MIN_KEPT {
            return None;
        }
        let mut free = self.free.lock().expect("no holder panics");
        let place = free.partition_point(|buffer| buffer.capacity() < size);
        let fits = free.get(place).is_some_and(|buffer| buffer.capacity() <= 2 * size);
        fits.then(|| free.remove(place))
    }

    /// Takes back a buffer.
    pub fn give(&self, buffer: Vec<f64>) {
        if buffer.capacity() >= MIN_KEPT {
            let mut free = self.free.lock().expect("no holder panics");
            let place = free.partition_point(|other| other.capacity() < buffer.capacity());
            free.insert(place, buffer);
        }
    }
}
