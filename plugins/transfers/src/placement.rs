use mimesh_core::{Error, Result, stage::TransferPair};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::alignment::Alignment;

/// The rule that fixes the global translation, which deformation gradients leave free.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Placement {
    /// The mean of all corresponding points moves as it does on the source, scaled to the size of the target.
    #[default]
    Motion,
    /// The mean of the markers moves as it does on the source, scaled to the size of the target.
    Markers,
    /// This marker moves as it does on the source, scaled to the size of the target: a foot that treads where the source's does,
    /// as in figure 3 of Zhou et al. 2010.
    Marker(String),
    /// The mean of these vertices of the target's file (from 0) stays where it is at rest.
    Anchor(Vec<u32>),
    /// The mean of all corresponding points stays where it is at rest: the motion of the source as a whole is dropped.
    Rest,
}

impl Placement {
    /// Prepares for poses.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there are no markers to follow, or [`Error::Setting`] if a marker or an anchor does not exist.
    pub fn bind(&self, pair: TransferPair<'_>, alignment: Alignment) -> Result<BoundPlacement> {
        let (source, target) = (pair.source, pair.target);
        let (source_points, target_points): (Weighted, Weighted) = match self {
            Self::Motion | Self::Rest => (vec![], vec![]),
            Self::Markers if pair.markers.is_empty() => {
                return Err(Error::data(
                    "placement: no markers to follow",
                    "give `markers: FILE`, or `placement: motion`",
                ));
            }
            Self::Markers => (
                pair.markers.iter().flat_map(|m| m.source.corners(source)).collect(),
                pair.markers.iter().flat_map(|m| m.target.corners(target)).collect(),
            ),
            Self::Marker(name) => {
                let Some(marker) = pair.markers.iter().find(|marker| marker.name == *name) else {
                    let names: Vec<&str> = pair.markers.iter().map(|marker| marker.name.as_str()).collect();
                    return Err(Error::Setting {
                        setting: "placement.marker".into(),
                        expected: format!("the name of a marker, of {}", names.join(", ")),
                        found: name.clone(),
                    });
                };
                (marker.source.corners(source), marker.target.corners(target))
            }
            Self::Anchor(vertices) => {
                let count = target.vertex_of.len();
                let on_surface = |&v: &u32| target.vertex_of.get(v as usize).copied().flatten();
                let points: Option<Weighted> = vertices.iter().map(|v| Some((on_surface(v)?, 1.0))).collect();
                match points.filter(|points| !points.is_empty()) {
                    Some(points) => (vec![], points),
                    None => {
                        return Err(Error::Setting {
                            setting: "placement.anchor".into(),
                            expected: format!("vertices from 0 to {} that belong to a polygon", count - 1),
                            found: format!("{vertices:?}"),
                        });
                    }
                }
            }
        };
        let mut bound = BoundPlacement {
            follows: matches!(self, Self::Motion | Self::Markers | Self::Marker(_)),
            alignment,
            source_points,
            target_points,
            source_rest: Vector3::zeros(),
            target_rest: Vector3::zeros(),
        };
        bound.source_rest = bound.source_mean(&source.positions);
        bound.target_rest = bound.target_mean(&target.positions);
        Ok(bound)
    }
}

/// Vertices with weights.
type Weighted = Vec<(u32, f64)>;

/// A [`Placement`] for one pair.
#[derive(Debug)]
pub struct BoundPlacement {
    /// Whether the target goes where the source goes.
    follows: bool,
    /// How the pair lies to each other at rest.
    pub alignment: Alignment,
    /// Points whose mean counts; empty for all corresponding points.
    source_points: Weighted,
    target_points: Weighted,
    source_rest: Vector3<f64>,
    target_rest: Vector3<f64>,
}

impl BoundPlacement {
    /// Moves the posed target as a whole to its place when the source is at `posed`.
    pub fn apply(&self, posed: &[Point3<f64>], target: &mut [Point3<f64>]) {
        let mut goal = self.target_rest;
        if self.follows {
            let similarity = &self.alignment.target_from_source;
            goal += similarity.rotation * (self.source_mean(posed) - self.source_rest) * similarity.scale;
        }
        let shift = goal - self.target_mean(target);
        target.iter_mut().for_each(|p| *p += shift);
    }

    /// Moves the posed target on from where it was, at `target_before`, as the source moves from `source_before` to `posed`.
    pub fn apply_since(
        &self,
        source_before: &[Point3<f64>],
        target_before: &[Point3<f64>],
        posed: &[Point3<f64>],
        target: &mut [Point3<f64>],
    ) {
        let similarity = &self.alignment.target_from_source;
        let way = self.source_mean(posed) - self.source_mean(source_before);
        let goal = self.target_mean(target_before) + similarity.rotation * way * similarity.scale;
        let shift = goal - self.target_mean(target);
        target.iter_mut().for_each(|p| *p += shift);
    }

    fn source_mean(&self, positions: &[Point3<f64>]) -> Vector3<f64> {
        mean(positions, &self.source_points).unwrap_or_else(|| self.alignment.source_mean(positions))
    }

    fn target_mean(&self, positions: &[Point3<f64>]) -> Vector3<f64> {
        mean(positions, &self.target_points).unwrap_or_else(|| self.alignment.target_mean(positions))
    }
}

fn mean(positions: &[Point3<f64>], points: &Weighted) -> Option<Vector3<f64>> {
    let total: f64 = points.iter().map(|(_, w)| w).sum();
    (total > 0.0).then(|| points.iter().map(|&(v, w)| positions[v as usize].coords * w).sum::<Vector3<f64>>() / total)
}
