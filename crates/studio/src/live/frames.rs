//! Results of the frames of a clip that were computed ahead, so that they can be played.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use super::measure::Field;

/// The most bytes of frames that are held for one clip.
const MAX_BYTES: usize = 512 << 20;

/// Bytes of a vertex in a frame: its position and its colour.
const VERTEX_BYTES: usize = 16;

/// The vertices of the target's file in a frame, relative to the origin of the target.
pub type Positions = Arc<Vec<f32>>;

/// Frames of one result; the colours are those of one colour map.
#[derive(Debug, Default)]
pub struct Frames(Mutex<State>);

#[derive(Clone, Debug, Default)]
struct State {
    positions: HashMap<usize, Positions>,
    /// The colour map, and the colours of the frames that have some.
    scalar: Option<String>,
    fields: HashMap<usize, Option<Arc<Field>>>,
}

/// How far apart the frames lie that are computed ahead, so that those of a clip with `count` frames fit into memory: 1 for all of them.
pub fn step_for(count: usize, vertices: usize) -> usize {
    let fit = (MAX_BYTES / (VERTEX_BYTES * vertices.max(1))).max(1);
    count.div_ceil(fit).max(1)
}

impl Frames {
    /// The frame `index` with the colours of `scalar`, if both are there.
    pub fn get(&self, index: usize, scalar: Option<&str>) -> Option<(Positions, Option<Arc<Field>>)> {
        let state = self.lock();
        let positions = state.positions.get(&index)?.clone();
        match scalar {
            None => Some((positions, None)),
            Some(_) if state.scalar.as_deref() != scalar => None,
            Some(_) => Some((positions, state.fields.get(&index)?.clone())),
        }
    }

    /// The positions of the frame `index`, if they are there.
    pub fn positions(&self, index: usize) -> Option<Positions> {
        self.lock().positions.get(&index).cloned()
    }

    /// Takes the positions of the frame `index`, if there is room for it.
    pub fn put(&self, index: usize, positions: Positions) {
        let mut state = self.lock();
        // Three numbers of four bytes a vertex.
        let bytes = VERTEX_BYTES * positions.len() / 3;
        if (state.positions.len() + 1) * bytes <= MAX_BYTES || state.positions.is_empty() {
            state.positions.insert(index, positions);
        }
    }

    /// Takes the colours of the frame `index` in the colour map `scalar`; those of another map leave.
    pub fn put_field(&self, index: usize, scalar: &str, field: Option<Arc<Field>>) {
        let mut state = self.lock();
        if state.scalar.as_deref() != Some(scalar) {
            state.fields.clear();
            state.scalar = Some(scalar.into());
        }
        state.fields.insert(index, field);
    }

    /// The same frames without colours, for metrics that have changed.
    pub fn plain(&self) -> Self {
        let positions = self.lock().positions.clone();
        Self(Mutex::new(State { positions, ..State::default() }))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clip_that_does_not_fit_is_played_with_fewer_frames() {
        assert_eq!(step_for(1_000, 10_000), 1);
        // A million vertices are 16 MB a frame, of which 32 fit.
        let step = step_for(300, 1_000_000);
        assert!(300usize.div_ceil(step) * 16_000_000 <= MAX_BYTES && step == 10, "{step}");
        assert_eq!(step_for(3, usize::MAX / 32), 3);
    }

    #[test]
    fn a_frame_with_colours_waits_for_them() {
        let frames = Frames::default();
        frames.put(2, Arc::new(vec![1.0]));
        assert!(frames.get(2, None).is_some() && frames.get(1, None).is_none() && frames.get(2, Some("a")).is_none());
        frames.put_field(2, "a", None);
        assert!(frames.get(2, Some("a")).is_some());
        frames.put_field(3, "b", None);
        assert!(frames.get(2, Some("a")).is_none() && frames.get(2, Some("b")).is_none());
        assert!(frames.plain().get(2, None).is_some());
    }
}
