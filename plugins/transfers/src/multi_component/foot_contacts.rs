//! Foot contacts: feet that stand still.

use mimesh_core::{
    Error, Result,
    stage::{Marker, TransferPair},
};
use nalgebra::{DMatrix, DVector, Matrix3xX, Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::system::System;

/// Points of the target whose mean stands still for some frames: where it is in the first of them, it stays.
///
/// One contact moves the target as a whole; where several hold at once, the target also bends as little as its energy allows.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct FootContact {
    /// Vertices of the target's file, from 0.
    pub vertices: Vec<u32>,
    /// Names of markers, whose target points count as well.
    pub markers: Vec<String>,
    /// The first and the last frame, from 0.
    pub frames: [usize; 2],
}

impl FootContact {
    /// The target's vertices with weights that sum to 1.
    fn points(&self, pair: TransferPair<'_>) -> Result<Vec<(u32, f64)>> {
        let target = pair.target;
        let refused = |expected: String, found: String| Error::Setting { setting: "plants".into(), expected, found };
        if self.frames[0] > self.frames[1] {
            let found = format!("[{}, {}]", self.frames[0], self.frames[1]);
            return Err(refused("frames: [first, last], the first not after the last".into(), found));
        }
        let count = target.vertex_of.len();
        let mut points = Vec::new();
        for &v in &self.vertices {
            let Some(w) = target.vertex_of.get(v as usize).copied().flatten() else {
                let expected = format!("vertices from 0 to {} that belong to a polygon", count.saturating_sub(1));
                return Err(refused(expected, v.to_string()));
            };
            points.push((w, 1.0));
        }
        for name in &self.markers {
            let Some(marker) = pair.markers.iter().find(|marker| marker.name == *name) else {
                let names: Vec<&str> = pair.markers.iter().map(|m: &Marker| m.name.as_str()).collect();
                return Err(refused(format!("names of markers, of {}", names.join(", ")), name.clone()));
            };
            points.extend(marker.target.corners(target));
        }
        if points.is_empty() {
            return Err(refused("`vertices` or `markers` that stand still".into(), "neither".into()));
        }
        let total: f64 = points.iter().map(|(_, w)| w).sum();
        Ok(points.into_iter().map(|(v, w)| (v, w / total)).collect())
    }
}

/// All foot contacts of a target, ready to hold it.
#[derive(Debug)]
pub struct FootContacts {
    contacts: Vec<Bound>,
}

#[derive(Debug)]
struct Bound {
    frames: [usize; 2],
    points: Vec<(u32, f64)>,
    /// A⁻¹ c: how the unknowns answer to a unit force at the points.
    response: Vec<f64>,
}

impl FootContacts {
    /// Looks for what [`new`](Self::new) would refuse.
    pub fn check(pair: TransferPair<'_>, contacts: &[FootContact]) -> Result<()> {
        contacts.iter().try_for_each(|contact| contact.points(pair).map(drop))
    }

    pub fn new(pair: TransferPair<'_>, contacts: &[FootContact], system: &System) -> Result<Self> {
        let bound = |contact: &FootContact| {
            let points = contact.points(pair)?;
            let response = system.response(&points);
            Ok(Bound { frames: contact.frames, points, response })
        };
        Ok(Self { contacts: contacts.iter().map(bound).collect::<Result<_>>()? })
    }

    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// The contacts that hold at frame `frame`, by their numbers.
    pub fn at(&self, frame: usize) -> impl Iterator<Item = usize> {
        let holds = move |k: &usize| (self.contacts[*k].frames[0]..=self.contacts[*k].frames[1]).contains(&frame);
        (0..self.contacts.len()).filter(holds)
    }

    /// Where contact `k` is when the target is at `positions`.
    pub fn place(&self, k: usize, positions: &[Point3<f64>]) -> Vector3<f64> {
        self.contacts[k].points.iter().map(|&(v, w)| positions[v as usize].coords * w).sum()
    }

    /// Moves the unknowns `x` of `system` with as little energy as can be so that, with the translation returned, the mean of
    /// each contact of `goals` is at its goal.
    ///
    /// With C the means and λ their forces, A y = Cᵀ, x − y λ + t meets C (x − y λ) + t = d, and Σ λ = 0 since no energy
    /// minds t.
    pub fn hold(&self, goals: &[(usize, Vector3<f64>)], system: &System, x: &mut [f64]) -> Vector3<f64> {
        let count = goals.len();
        let stride = x.len() / 3;
        let positions = system.positions(x);
        let residuals = Matrix3xX::from_iterator(
            count,
            goals.iter().flat_map(|&(k, goal)| {
                let now = self.place(k, &positions);
                [now.x - goal.x, now.y - goal.y, now.z - goal.z]
            }),
        )
        .transpose();
        let mean = -residuals.row_sum().transpose() / count as f64;
        if count < 2 {
            return Vector3::from_column_slice(mean.as_slice());
        }
        let mut stiffness = DMatrix::from_fn(count, count, |a, b| {
            let response = &self.contacts[goals[b].0].response;
            self.contacts[goals[a].0].points.iter().map(|&(v, w)| w * response[v as usize]).sum::<f64>()
        });
        // Two contacts at one place would leave their shares open.
        let ridge = 1e-9 * stiffness.diagonal().max();
        (0..count).for_each(|k| stiffness[(k, k)] += ridge);
        let Some(cholesky) = stiffness.cholesky() else { return Vector3::from_column_slice(mean.as_slice()) };
        let ones = cholesky.solve(&DVector::from_element(count, 1.0));
        let forces = cholesky.solve(&residuals);
        let shift = -forces.row_sum().transpose() / ones.sum();
        for c in 0..3 {
            for (a, &(k, _)) in goals.iter().enumerate() {
                let force = forces[(a, c)] + ones[a] * shift[c];
                let response = &self.contacts[k].response;
                x[c * stride..(c + 1) * stride].iter_mut().zip(response).for_each(|(x, r)| *x -= force * r);
            }
        }
        Vector3::from_column_slice(shift.as_slice())
    }
}
