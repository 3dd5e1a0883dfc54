//! The contract of key points.

use std::sync::Mutex;

use super::support::{bent_bar, one_thread, twisted, with_defects};
use crate::{
    mesh::SurfacePoint,
    stage::{ChoiceStep, ChoiceWatch, Chosen, KeyPoints, KeyPointsInput},
};

/// Records the steps that it is told of, and interrupts after a number of steps.
struct Recorder {
    steps: Mutex<Vec<ChoiceStep>>,
    max_steps: usize,
}

impl ChoiceWatch for Recorder {
    fn step(&self, step: &ChoiceStep) {
        self.steps.lock().expect("no panic while held").push(step.clone());
    }

    fn is_interrupted(&self) -> bool {
        self.steps.lock().expect("no panic while held").len() >= self.max_steps
    }
}

/// The contract of [`KeyPoints`], on a sound surface and on one with defects.
pub fn key_points(name: &str, stage: &dyn KeyPoints) {
    for source in [bent_bar(), with_defects(bent_bar())] {
        let poses = [twisted(&source, 1.0), twisted(&source, -2.0)];
        let input = KeyPointsInput { source: &source, poses: &poses, start: &[] };
        let choose = |input: KeyPointsInput<'_>, watch: &dyn ChoiceWatch| {
            stage.choose(input, watch).unwrap_or_else(|error| panic!("{name}: {error}"))
        };
        let recorder = Recorder { steps: Mutex::default(), max_steps: usize::MAX };
        let chosen = choose(input, &recorder);
        check_laws(name, &chosen, source.vertex_count());
        assert_eq!(
            *recorder.steps.lock().expect("no panic"),
            chosen.steps,
            "{name}: the steps reported are those kept"
        );
        assert!(chosen.points == one_thread(|| choose(input, &())).points, "{name}: other points on one thread");

        let hasty = choose(input, &Recorder { steps: Mutex::default(), max_steps: 2 });
        assert!(hasty.steps.len() <= chosen.steps.len(), "{name}: an interrupt ends the choice");
        let resumed = choose(KeyPointsInput { start: &hasty.points, ..input }, &());
        check_laws(name, &resumed, source.vertex_count());
        assert!(resumed.points.len() >= hasty.points.len(), "{name}: points to start from are kept or exchanged");

        let short = [poses[0][1..].to_vec()];
        assert!(
            stage.choose(KeyPointsInput { poses: &short, ..input }, &()).is_err(),
            "{name}: takes a pose too short"
        );
        assert!(stage.choose(KeyPointsInput { poses: &[], ..input }, &()).is_err(), "{name}: chooses without a pose");
        let nowhere = [SurfacePoint::Vertex(u32::MAX)];
        let outside = KeyPointsInput { start: &nowhere, ..input };
        assert!(stage.choose(outside, &()).is_err(), "{name}: starts from a point that does not exist");
    }
}

fn check_laws(name: &str, chosen: &Chosen, vertices: usize) {
    assert!(!chosen.points.is_empty(), "{name}: no point");
    for (k, point) in chosen.points.iter().enumerate() {
        if let SurfacePoint::Vertex(vertex) = point {
            assert!((*vertex as usize) < vertices, "{name}: no vertex {vertex}");
        }
        assert!(!chosen.points[..k].contains(point), "{name}: {point:?} is chosen twice");
    }
    for pair in chosen.steps.windows(2) {
        let [before, after] = [&pair[0], &pair[1]];
        let rises = after.exchanged && after.error > before.error;
        assert!(!rises, "{name}: an exchange raises the error: {} to {}", before.error, after.error);
        let expected = before.points.len() + usize::from(!after.exchanged);
        assert_eq!(after.points.len(), expected, "{name}: points after a step");
    }
    // What looks at no pose has no steps to report.
    if let Some(last) = chosen.steps.last() {
        assert_eq!(last.points, chosen.points, "{name}: the last step is the result");
    }
}
