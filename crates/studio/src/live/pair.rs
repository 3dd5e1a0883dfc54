//! The markers of a live result, with the point that is dragged where it is.

use mimesh_core::stage::{Marker, TransferPair};

use super::look::Drag;
use crate::{
    markers::{Point, Status, pair::Content},
    project::{Project, Ready},
};

/// Markers of a live result.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveMarkers {
    /// The revision of the document.
    pub revision: u64,
    /// The drag that is shown.
    pub drag: Option<u64>,
    /// The pairs on the surfaces.
    pub markers: Vec<Marker>,
    /// How sure each of them is, from 0 to 1; NaN if nobody knows.
    pub confidences: Vec<f64>,
}

impl LiveMarkers {
    /// The pairs of `project` that stages can use; that of `drag` with its point there.
    pub fn new(project: &Project, drag: Option<&Drag>) -> Self {
        let usable = project.markers.usable();
        let confidences = usable.contents.iter().map(confidence).collect();
        let mut live = Self { revision: usable.revision, drag: None, markers: usable.markers, confidences };
        let Some(Drag { drag, pair, side, point: Some(point) }) = drag else { return live };
        let mesh = project.meshes.for_markers()[side.index()];
        let Some(on) = point.normalised().ok().and_then(|point| mesh.surface.point(point.into())) else { return live };
        match usable.ids.iter().position(|id| id == pair) {
            Some(i) => {
                let point = if side.index() == 0 { &mut live.markers[i].source } else { &mut live.markers[i].target };
                *point = on;
                live.confidences[i] = 1.0;
            }
            // Its first point on this side.
            None => match partner(project, *pair, 1 - side.index()) {
                Some((name, other)) => {
                    let (source, target) = if side.index() == 0 { (on, other) } else { (other, on) };
                    live.markers.push(Marker { name, source, target });
                    live.confidences.push(1.0);
                }
                None => return live,
            },
        }
        // No two pairs may share a point.
        let all = live.markers.iter();
        let is_shared = all
            .clone()
            .enumerate()
            .any(|(i, a)| all.clone().skip(i + 1).any(|b| a.source == b.source || a.target == b.target));
        if is_shared {
            return Self { drag: None, ..Self::new(project, None) };
        }
        live.drag = Some(*drag);
        live
    }
}

/// How sure a pair is; who confirmed it was sure.
fn confidence(content: &Content) -> f64 {
    if content.status == Status::Confirmed { 1.0 } else { content.confidence.unwrap_or(f64::NAN) }
}

/// The name of the incomplete pair `id`, and its point on side `k`.
fn partner(project: &Project, id: u64, k: usize) -> Option<(String, mimesh_core::mesh::SurfacePoint)> {
    let (_, pairs) = project.markers.pairs();
    let pair = pairs.iter().find(|pair| pair.id == id)?;
    let point: Point = pair.content.points[k].filter(|_| pair.content.status != Status::Skipped)?;
    Some((pair.label(), project.meshes.for_markers()[k].surface.point(point.into())?))
}

/// The surfaces of a pipeline with the pairs that are shown.
pub(super) fn pair<'a>(ready: &'a Ready, live: &'a LiveMarkers) -> TransferPair<'a> {
    let prepared = &ready.prepared;
    TransferPair {
        source: &prepared.source.surface,
        target: prepared.target.seen_surface(),
        markers: &live.markers,
        proximity: prepared.proximity.as_ref().map(|proximity| &proximity.graph),
    }
}
