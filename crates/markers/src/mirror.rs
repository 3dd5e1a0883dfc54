//! Completing markers across the plane of symmetry of both meshes.
//!
//! A pair has a mirror partner if another pair has its name with left and right exchanged, or lies on both meshes where its
//! mirror image is attached. Pairs without a partner get one: the closest places to the mirrored positions. Mirroring again
//! then adds nothing.

use nalgebra::Point3;

use mimesh_core::mesh::bounding_box;
use mimesh_document::Result;

use crate::{
    attacher::{Attached, Attacher, MAX_DISTANCE},
    mesh::{MarkerMesh, MeshRole},
    model::{MarkerFile, MarkerPair},
    side_names::exchange_sides,
};

/// Points nearer to the plane than this, relative to the diagonal, lie on it; partners are as near to mirror images.
const MAX_MIRROR_DISTANCE: f64 = 0.01;

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// The coordinate at which the plane crosses the axis, in the unit of the mesh.
    pub offset: f64,
}

impl Plane {
    /// The plane through the middle of the bounding box of `mesh`.
    pub fn middle(mesh: MarkerMesh<'_>, axis: usize) -> Self {
        let (low, high) = bounding_box(&mesh.surface.positions);
        Self { axis, offset: 0.5 * (low[axis] + high[axis]) }
    }

    /// The mirror image of `p`.
    pub fn mirror(self, p: &Point3<f64>) -> Point3<f64> {
        let mut image = *p;
        image[self.axis] = 2.0 * self.offset - p[self.axis];
        image
    }

    fn distance(self, p: &Point3<f64>) -> f64 {
        (p[self.axis] - self.offset).abs()
    }
}

/// The outcome of mirroring for a pair.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The pair lies on the plane.
    OnPlane,
    /// The pair has a partner: the number of the partner, from 0.
    Partner(usize),
    /// A partner was added: its number, and its distances from the mirrored positions on source and target, relative to the
    /// diagonals.
    Added(usize, [f64; 2]),
    /// No partner was added, for this reason.
    Left(String),
}

/// Mirrored markers.
#[derive(Clone, Debug, Default)]
pub struct Mirrored {
    /// The markers, with the added ones at the end.
    pub markers: MarkerFile,
    /// The outcome of each pair that was there before.
    pub outcomes: Vec<Outcome>,
}

/// The markers before mirroring with their positions and mirror images, where both points are known.
struct Mirror<'a> {
    markers: &'a MarkerFile,
    meshes: [MarkerMesh<'a>; 2],
    planes: [Plane; 2],
    diagonals: [f64; 2],
    positions: Vec<Option<[Point3<f64>; 2]>>,
    images: Vec<Option<[Attached; 2]>>,
}

/// Adds to `markers`, all of which are on the meshes, the mirror partners that are missing.
///
/// # Errors
///
/// As [`Attacher::new`].
pub fn mirror(markers: &MarkerFile, meshes: [MarkerMesh<'_>; 2], planes: [Plane; 2]) -> Result<Mirrored> {
    let attachers = [Attacher::new(meshes[0])?, Attacher::new(meshes[1])?];
    let image = |at: &[Point3<f64>; 2]| [0, 1].map(|k: usize| attachers[k].attach(&planes[k].mirror(&at[k])));
    let positions: Vec<_> = markers.pairs.iter().map(|pair| positions(pair, meshes)).collect();
    let images = positions.iter().map(|at| at.as_ref().map(image)).collect();
    let diagonals = [attachers[0].diagonal, attachers[1].diagonal];
    let mirror = Mirror { markers, meshes, planes, diagonals, positions, images };
    let mut result = Mirrored { markers: markers.clone(), outcomes: vec![] };
    for i in 0..markers.pairs.len() {
        let outcome = mirror.outcome(i, &mut result.markers);
        result.outcomes.push(outcome);
    }
    Ok(result)
}

fn positions(pair: &MarkerPair, [source, target]: [MarkerMesh<'_>; 2]) -> Option<[Point3<f64>; 2]> {
    Some([source.position(pair.source?)?, target.position(pair.target?)?])
}

impl Mirror<'_> {
    /// The outcome of pair `i`, whose partner is added to `result` if it is missing.
    fn outcome(&self, i: usize, result: &mut MarkerFile) -> Outcome {
        let (Some(at), Some(images)) = (&self.positions[i], &self.images[i]) else {
            return Outcome::Left(format!(
                "it has no {} yet",
                if self.markers.pairs[i].source.is_none() { MeshRole::Source } else { MeshRole::Target }
            ));
        };
        let on_plane = [0, 1].map(|k| self.planes[k].distance(&at[k]) <= MAX_MIRROR_DISTANCE * self.diagonals[k]);
        if on_plane == [true; 2] {
            return Outcome::OnPlane;
        }
        if let Some(partner) = self.named_partner(i).or_else(|| self.placed_partner(i)) {
            return Outcome::Partner(partner);
        }
        match self.obstacle(i, on_plane, images) {
            Some(reason) => Outcome::Left(reason),
            None => self.add(i, images, result),
        }
    }

    /// The pair that has the name of pair `i` with left and right exchanged.
    fn named_partner(&self, i: usize) -> Option<usize> {
        let other = exchange_sides(self.markers.pairs[i].name.as_deref()?)?;
        self.markers.pairs.iter().position(|pair| pair.name.as_deref() == Some(&other))
    }

    /// The pair that lies on both meshes where pair `i` is mirrored to, or that is mirrored to where pair `i` lies.
    fn placed_partner(&self, i: usize) -> Option<usize> {
        let image_of_i = self.others(i).find(|&j| self.falls_on(i, j) == [true; 2]);
        image_of_i.or_else(|| self.others(i).find(|&j| self.falls_on(j, i) == [true; 2]))
    }

    /// The reason why pair `i` cannot get a partner.
    fn obstacle(&self, i: usize, on_plane: [bool; 2], images: &[Attached; 2]) -> Option<String> {
        let [source, target] = MeshRole::BOTH;
        if on_plane != [false; 2] {
            let (on, off) = if on_plane[0] { (source, target) } else { (target, source) };
            return Some(format!("on the plane of the {on}, but not on that of the {off}"));
        }
        if let Some(j) = self.others(i).find(|&j| self.falls_on(i, j) != [false; 2]) {
            let on = if self.falls_on(i, j)[0] { source } else { target };
            return Some(format!("its mirror image is marker {} on the {on} only", self.markers.name(j)));
        }
        let (role, farthest) = if images[0].distance > images[1].distance {
            (source, images[0].distance)
        } else {
            (target, images[1].distance)
        };
        let percent = 100.0 * farthest;
        (farthest > MAX_DISTANCE)
            .then(|| format!("its mirror image lies {percent:.1} % of the diagonal off the {role}"))
    }

    /// Adds the partner of pair `i` to `result`.
    fn add(&self, i: usize, images: &[Attached; 2], result: &mut MarkerFile) -> Outcome {
        let name = self.markers.pairs[i].name.as_deref().map(|name| free_name(result, name));
        let at = [0, 1].map(|k: usize| self.meshes[k].position(images[k].point));
        result.pairs.push(MarkerPair { name, at, ..MarkerPair::new(images[0].point, images[1].point) });
        Outcome::Added(result.pairs.len() - 1, [images[0].distance, images[1].distance])
    }

    /// Whether the image of pair `i` lies on pair `j`, on source and target.
    fn falls_on(&self, i: usize, j: usize) -> [bool; 2] {
        let (Some(images), Some(at)) = (&self.images[i], &self.positions[j]) else { return [false; 2] };
        [0, 1].map(|k: usize| {
            let image = self.meshes[k].position(images[k].point);
            image.is_some_and(|image| (image - at[k]).norm() <= MAX_MIRROR_DISTANCE * self.diagonals[k])
        })
    }

    fn others(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        (0..self.markers.pairs.len()).filter(move |&j| j != i)
    }
}

/// A name for the mirror partner of `name` that no marker has.
fn free_name(markers: &MarkerFile, name: &str) -> String {
    let wanted = exchange_sides(name).unwrap_or_else(|| format!("{name} mirrored"));
    let is_taken = |name: &str| markers.pairs.iter().any(|pair| pair.name.as_deref() == Some(name));
    let mut free = wanted.clone();
    let mut number = 2;
    while is_taken(&free) {
        free = format!("{wanted} {number}");
        number += 1;
    }
    free
}
