//! What the user should do next.

use mimesh_core::{
    plugin,
    stage::{Landmarks, TransferPair},
};
use serde::Serialize;

use crate::{
    markers::{Pair, Point, Status, store::Usable},
    project::Project,
};

/// Proposals above this confidence are not asked about one by one.
const SURE: f64 = 0.75;

/// What the user should do next.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Next {
    kind: NextKind,
    pair: Option<u64>,
    source: Option<Point>,
    target: Option<Point>,
    reason: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum NextKind {
    Partner,
    Doubtful,
    New,
    None,
}

/// What the user should do next in `project`, after the pair `after`: find a partner, look at a doubtful proposal, or click a point that
/// would help.
pub fn next(project: &Project, after: Option<u64>) -> Next {
    let (_, pairs) = project.markers.pairs();
    let used = |pair: &&Pair| pair.content.status != Status::Skipped;
    let pairs: Vec<&Pair> = pairs.iter().map(|pair| &**pair).filter(used).collect();
    let incomplete: Vec<&Pair> = pairs.iter().copied().filter(|pair| pair.content.points.contains(&None)).collect();
    if let Some(pair) = following(&incomplete, after) {
        let side = if pair.content.points[0].is_none() { "source" } else { "target" };
        return of_pair(NextKind::Partner, pair, format!("its point on the {side} is still to be found"));
    }
    let confidence = |pair: &Pair| pair.content.confidence.unwrap_or(0.0);
    let mut doubtful: Vec<&Pair> = pairs
        .iter()
        .copied()
        .filter(|pair| pair.content.status == Status::Proposed && confidence(pair) < SURE)
        .collect();
    doubtful.sort_by(|a, b| confidence(a).total_cmp(&confidence(b)));
    if let Some(pair) = following(&doubtful, after) {
        let percent = (100.0 * confidence(pair)).round();
        return of_pair(
            NextKind::Doubtful,
            pair,
            format!("the proposal is {percent} % sure: confirm it, or move its points"),
        );
    }
    suggested(project).unwrap_or(Next {
        kind: NextKind::None,
        pair: None,
        source: None,
        target: None,
        reason: "no point stands out that would help".into(),
    })
}

/// The one after `after` in the list, else the first.
fn following<'p>(list: &[&'p Pair], after: Option<u64>) -> Option<&'p Pair> {
    let at = after.and_then(|after| list.iter().position(|pair| pair.id == after));
    at.and_then(|at| list.get(at + 1)).or(list.first()).copied()
}

fn of_pair(kind: NextKind, pair: &Pair, reason: String) -> Next {
    let [source, target] = pair.content.points;
    Next { kind, pair: Some(pair.id), source, target, reason }
}

/// The point that a stage suggests: that of the pipeline, else the first that can.
fn suggested(project: &Project) -> Option<Next> {
    let Usable { markers, .. } = project.markers.usable();
    let [source, target] = [&project.meshes.sides[0], &project.meshes.sides[1]];
    let pair =
        TransferPair { source: &source.surface, target: target.seen_surface(), markers: &markers, proximity: None };
    let others = plugin::instances::<dyn Landmarks>().into_iter().map(|(_, stage)| stage);
    let suggest = |stage: &dyn Landmarks| {
        if stage.command().is_some() { None } else { stage.suggest(pair).ok().flatten() }
    };
    let own = project.landmarks.as_deref().and_then(suggest);
    let found = own.or_else(|| others.into_iter().find_map(|stage| suggest(stage.as_ref())))?;
    let reason = match found.doubt {
        Some(doubt) => format!("what the pairs say of this place differs by {:.1} % of the diagonal", 100.0 * doubt),
        None => "it is the place farthest from all pairs".into(),
    };
    Some(Next {
        kind: NextKind::New,
        pair: None,
        source: Some(source.surface.mesh_point(found.source).into()),
        target: found.target.map(|point| target.surface.mesh_point(point).into()),
        reason,
    })
}
