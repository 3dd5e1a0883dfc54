//! Transfers one after the other.
//!
//! The first moves the target as the source moves. What it makes of the target is the source of the next, which moves the same
//! target by it: triangle by triangle its own partner, every marker its own. So the next sees a pose of the very mesh that it
//! is to move, and gives it what the first cannot: rigid parts, feet that stand still, gradients without spikes.
//!
//! Rest gives rest and a rigid motion itself, because each link does so.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::{BindInput, BoundTransfer, Marker, Motion, Transfer, TransferPair, Transferred, TriangleMap},
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::debug_span;

use crate::{
    frames::{Frames, evenly_spaced},
    gradient::GradientTransfer,
};

register!(Transfer: Chain);

/// Transfers one after the other: what one makes of the target is the pose that the next gives to it.
///
/// E.g. `biharmonic` and then `multi_component` with `rigid:` or `plants:`, which handles alone cannot keep.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Chain {
    /// The transfers. The first takes the poses of the source, each other those that the one before gives to the target.
    pub transfers: Vec<Box<dyn Transfer>>,
}

impl Default for Chain {
    fn default() -> Self {
        Self { transfers: vec![Box::new(GradientTransfer::default())] }
    }
}

#[typetag::serde(name = "chain")]
impl Transfer for Chain {
    fn needs_correspondence(&self) -> bool {
        self.transfers.first().is_none_or(|first| first.needs_correspondence())
    }

    fn markers_needed(&self) -> usize {
        self.transfers.iter().map(|transfer| transfer.markers_needed()).max().unwrap_or(0)
    }

    fn gives_motion(&self) -> bool {
        self.transfers.iter().any(|transfer| transfer.gives_motion())
    }

    fn poses_wanted(&self) -> usize {
        self.transfers.iter().map(|transfer| transfer.poses_wanted()).max().unwrap_or(0)
    }

    fn bind(&self, input: BindInput<'_>) -> Result<Box<dyn BoundTransfer>> {
        let pair = input.pair;
        let (first, others) = self.split()?;
        let mut figures = Figures::default();
        let count = self.transfers.len() as f64;
        let part = |k: usize| input.work.part(k as f64 / count, (k + 1) as f64 / count);
        let mut links = vec![link(0, first.as_ref(), BindInput { work: part(0), ..input }, &mut figures)?];
        let markers = on_itself(pair.markers);
        let itself = TransferPair { source: pair.target, markers: &markers, ..pair };
        let identity = identity(pair.target);
        let mut seen = input.poses.to_vec();
        for (k, transfer) in others.iter().enumerate() {
            let later = others[k..].iter().map(|transfer| transfer.poses_wanted()).max().unwrap_or(0);
            seen = evenly_spaced(&seen, later);
            let before = &links[k];
            for pose in &mut seen {
                *pose = before.transfer(pose)?.positions;
            }
            let next = BindInput { pair: itself, map: Some(&identity), poses: &seen, work: part(k + 1) };
            links.push(link(k + 1, &**transfer, next, &mut figures)?);
        }
        Ok(Box::new(Bound { links, figures }))
    }

    fn check(&self, pair: TransferPair<'_>) -> Result<()> {
        let (first, others) = self.split()?;
        first.check(pair).map_err(|error| at(0, error))?;
        let markers = on_itself(pair.markers);
        let itself = TransferPair { source: pair.target, markers: &markers, ..pair };
        others.iter().enumerate().try_for_each(|(k, next)| next.check(itself).map_err(|error| at(k + 1, error)))
    }
}

/// A transfer of the chain.
type Link = Box<dyn Transfer>;

impl Chain {
    /// The first transfer and those after it.
    fn split(&self) -> Result<(&Link, &[Link])> {
        self.transfers.split_first().ok_or_else(|| Error::Setting {
            setting: "transfers".into(),
            expected: "one transfer or more".into(),
            found: "none".into(),
        })
    }
}

/// Binds transfer `k` and adds its figures under its name.
fn link(
    k: usize,
    transfer: &dyn Transfer,
    input: BindInput<'_>,
    figures: &mut Figures,
) -> Result<Box<dyn BoundTransfer>> {
    let poses = evenly_spaced(input.poses, transfer.poses_wanted());
    let span = debug_span!("transfer", "type" = transfer.typetag_name());
    let bound = span.in_scope(|| transfer.bind(BindInput { poses: &poses, ..input })).map_err(|error| at(k, error))?;
    add(figures, k, bound.figures());
    Ok(bound)
}

/// Adds the figures of transfer `k`.
fn add(figures: &mut Figures, k: usize, of_link: Figures) {
    of_link.values.into_iter().for_each(|(name, value)| figures.set(&format!("{}_{name}", k + 1), value));
    figures.warnings.extend(of_link.warnings);
}

/// The error of transfer `k`.
fn at(k: usize, error: Error) -> Error {
    match error {
        Error::Data { message, hint } => Error::Data { message: format!("transfers[{k}]: {message}"), hint },
        other => other,
    }
}

/// The markers of the target as pairs of the target with itself.
fn on_itself(markers: &[Marker]) -> Vec<Marker> {
    markers.iter().map(|m| Marker { source: m.target, ..m.clone() }).collect()
}

fn identity(target: &Surface) -> TriangleMap {
    TriangleMap {
        source_triangle_count: target.triangle_count(),
        triangles: (0..target.triangle_count() as u32).map(Some).collect(),
        points: (0..target.vertex_count() as u32).map(|v| Some(SurfacePoint::Vertex(v))).collect(),
        ..TriangleMap::default()
    }
}

#[derive(Debug)]
struct Bound {
    links: Vec<Box<dyn BoundTransfer>>,
    figures: Figures,
}

impl BoundTransfer for Bound {
    fn transfer(&self, posed: &[Point3<f64>]) -> Result<Transferred> {
        run(self.links.iter(), posed, |link, posed| link.transfer(posed))
    }

    fn bytes(&self, poses: usize) -> u64 {
        self.links.iter().map(|link| link.bytes(poses)).sum()
    }

    fn at_once(&self) -> usize {
        self.links.iter().map(|link| link.at_once()).max().unwrap_or(1)
    }

    fn transfer_all(&self, poses: &[&[Point3<f64>]]) -> Vec<Result<Transferred>> {
        let start = |posed: &&[Point3<f64>]| Ok(Transferred { positions: posed.to_vec(), figures: Figures::default() });
        let mut results: Vec<Result<Transferred>> = poses.iter().map(start).collect();
        for (k, link) in self.links.iter().enumerate() {
            let sound: Vec<&[Point3<f64>]> = results.iter().flatten().map(|result| &result.positions[..]).collect();
            let mut next = link.transfer_all(&sound).into_iter();
            for result in &mut results {
                if let Ok(before) = result {
                    match next.next().expect("each pose has a result") {
                        Ok(next) => hand_on(before, k, next),
                        Err(error) => *result = Err(error),
                    }
                }
            }
        }
        results
    }

    fn motion(&self) -> Option<Box<dyn Motion + '_>> {
        Some(Box::new(InMotion { links: Frames::of(self.links.iter().map(|link| &**link))? }))
    }

    fn figures(&self) -> Figures {
        self.figures.clone()
    }
}

/// Hands each link's result to the next.
fn run<L>(
    links: impl Iterator<Item = L>,
    posed: &[Point3<f64>],
    mut one: impl FnMut(L, &[Point3<f64>]) -> Result<Transferred>,
) -> Result<Transferred> {
    let mut result = Transferred { positions: posed.to_vec(), figures: Figures::default() };
    for (k, link) in links.enumerate() {
        let next = one(link, &result.positions)?;
        hand_on(&mut result, k, next);
    }
    Ok(result)
}

/// Takes over the result of link `k`.
fn hand_on(result: &mut Transferred, k: usize, next: Transferred) {
    result.positions = next.positions;
    add(&mut result.figures, k, next.figures);
}

struct InMotion<'a> {
    links: Vec<Frames<'a>>,
}

impl Motion for InMotion<'_> {
    fn frame(&mut self, frame: usize, posed: &[Point3<f64>]) -> Result<Transferred> {
        run(self.links.iter_mut(), posed, |link, posed| link.frame(frame, posed))
    }
}
