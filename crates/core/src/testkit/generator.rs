//! The contract of generators.

use super::support::one_thread;
use crate::stage::Generator;

/// The contract of [`Generator`].
pub fn generator(name: &str, stage: &dyn Generator) {
    let make = || stage.make().unwrap_or_else(|error| panic!("{name}: {error}"));
    let sequence = make();
    sequence.rest.validate().unwrap_or_else(|error| panic!("{name}: {error}"));
    for pose in &sequence.poses {
        let positions = pose.positions.get().unwrap();
        assert_eq!(positions.len(), sequence.rest.positions.len(), "{name}: pose {}", pose.name);
        assert!(positions.iter().all(|p| p.coords.iter().all(|x| x.is_finite())), "{name}: pose {}", pose.name);
    }
    let again = one_thread(make);
    assert!(again.rest.positions == sequence.rest.positions && again.poses == sequence.poses, "{name}: not repeatable");
}
