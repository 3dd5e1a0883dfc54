use std::fmt::Debug;

use nalgebra::Point3;

use crate::{
    Figures, Result,
    mesh::{Surface, SurfacePoint},
};

/// Chooses the few points of a source that tell its poses best, so that a user has only these to find on the target.
///
/// # Contract
///
/// - points exist on the surface and no two are the same;
/// - the error of a step never rises as points are exchanged; a point added may raise it;
/// - equal inputs give equal points, on one thread or many.
#[typetag::serde(tag = "type")]
pub trait KeyPoints: Debug + Send + Sync {
    /// Chooses points; every step is told to `watch`.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`](crate::Error::Setting) for settings out of range, [`Error::Data`](crate::Error::Data) if there is no
    /// pose or a pose does not fit.
    fn choose(&self, input: KeyPointsInput<'_>, watch: &dyn ChoiceWatch) -> Result<Chosen>;
}

crate::stage_kind!(KeyPoints, "key_points");

/// The input of [`KeyPoints`].
#[derive(Clone, Copy, Debug)]
pub struct KeyPointsInput<'a> {
    /// The source at rest.
    pub source: &'a Surface,
    /// Its poses, each #V.
    pub poses: &'a [Vec<Point3<f64>>],
    /// Points to start from, as those of an earlier choice that was interrupted; may be empty.
    pub start: &'a [SurfacePoint],
}

/// Is told of a choice on its way.
pub trait ChoiceWatch: Sync {
    /// A step is done.
    fn step(&self, step: &ChoiceStep);

    /// Reports which share of the whole choice is done, from 0 to 1, for choices that can tell.
    fn done(&self, _share: f64) {}

    /// Whether to end with the points chosen so far.
    fn is_interrupted(&self) -> bool {
        false
    }
}

/// A watch that does not care.
impl ChoiceWatch for () {
    fn step(&self, _: &ChoiceStep) {}
}

/// The points after a step.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceStep {
    /// All points chosen so far.
    pub points: Vec<SurfacePoint>,
    /// How far the poses are missed with these points, on average, in the unit that the implementation states.
    pub error: f64,
    /// Whether a point was exchanged; else one was added.
    pub exchanged: bool,
}

/// The points chosen.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The points, in the order in which they were added.
    pub points: Vec<SurfacePoint>,
    /// Every step that was kept, the last of which is the result; none where no error is known, as of given points.
    pub steps: Vec<ChoiceStep>,
    /// The report of the search.
    pub figures: Figures,
}
