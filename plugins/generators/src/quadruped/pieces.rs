//! Animals of many components: a mesh of named pieces, and how its pieces move.

use std::ops::Range;

use mimesh_core::{
    mesh::{Mesh, Part, Polygons},
    spatial::{Orientation, Similarity},
};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::{
    body::{Body, Limb},
    skin::Skin,
};

/// A body cut into pieces, in metres.
#[derive(Debug, Default)]
pub struct Pieces {
    /// V of all pieces, piece by piece.
    pub positions: Vec<Point3<f64>>,
    /// Polygons of all pieces, piece by piece.
    pub polygons: Polygons,
    /// The pieces.
    pub pieces: Vec<Piece>,
}

/// A piece: a closed mesh that shares no vertex with another.
#[derive(Debug)]
pub struct Piece {
    /// The name, unique.
    pub name: String,
    /// The region of the animal that it belongs to.
    pub region: String,
    /// Its vertices.
    pub vertices: Range<usize>,
    /// Its polygons.
    pub polygons: Range<usize>,
    /// Its motion with the body.
    pub motion: Motion,
}

/// How a piece moves with the body.
#[derive(Debug)]
pub enum Motion {
    /// The piece moves by the rigid motion that is nearest, in least squares over its vertices, to that of the body where they
    /// lie.
    Rigid,
    /// The first half of its vertices, the outer side, as the skin does; each of the others stays at a depth below its partner.
    Sheet(Sheet),
}

/// The outer side of a plate and the depth of the inner side below it.
#[derive(Debug)]
pub struct Sheet {
    /// Triangles of the outer side, vertices counted within the piece.
    pub outer: Vec<[u32; 3]>,
    /// For each vertex of the outer side, how deep its partner lies, metres.
    pub depths: Vec<f64>,
}

impl Sheet {
    /// The inner side under an outer side at `outer`: each vertex below its partner, against the normal there.
    pub fn inner(&self, outer: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let mut normals = vec![Vector3::zeros(); outer.len()];
        for t in &self.outer {
            let [a, b, c] = t.map(|v| outer[v as usize]);
            let normal = (b - a).cross(&(c - a));
            t.iter().for_each(|&v| normals[v as usize] += normal);
        }
        let below = |((p, normal), depth): ((&Point3<f64>, &Vector3<f64>), &f64)| p - normal.normalize() * *depth;
        outer.iter().zip(&normals).zip(&self.depths).map(below).collect()
    }
}

impl Pieces {
    /// Adds a piece, given by its own vertices and by polygons that count them from 0.
    pub fn push<'p>(
        &mut self,
        (name, region): (String, String),
        positions: Vec<Point3<f64>>,
        polygons: impl IntoIterator<Item = &'p [u32]>,
        motion: Motion,
    ) {
        let (start, first) = (self.positions.len(), self.polygons.len());
        self.positions.extend(positions);
        let mut corners = vec![];
        for polygon in polygons {
            corners.clear();
            corners.extend(polygon.iter().map(|v| v + start as u32));
            self.polygons.push(&corners);
        }
        let (vertices, polygons) = (start..self.positions.len(), first..self.polygons.len());
        self.pieces.push(Piece { name, region, vertices, polygons, motion });
    }

    /// The mesh at rest, every piece an object of its own in the group of its region.
    pub fn mesh(&self) -> Mesh {
        let part = |piece: &Piece| Part {
            object: Some(piece.name.clone()),
            groups: vec![piece.region.clone()],
            material: None,
            polygons: piece.polygons.clone(),
        };
        Mesh {
            positions: self.positions.clone(),
            polygons: self.polygons.clone(),
            parts: self.pieces.iter().map(part).collect(),
            ..Mesh::default()
        }
    }

    /// The vertices when the body moves them to `carried`.
    pub fn moved(&self, carried: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let piece = |piece: &Piece| {
            let carried = &carried[piece.vertices.clone()];
            match &piece.motion {
                Motion::Rigid => rigidly(&self.positions[piece.vertices.clone()], carried),
                Motion::Sheet(sheet) => {
                    let outer = &carried[..sheet.depths.len()];
                    [outer, &sheet.inner(outer)].concat()
                }
            }
        };
        let pieces: Vec<_> = self.pieces.par_iter().map(piece).collect();
        pieces.concat()
    }

    /// Binds the vertices to `body`.
    pub fn skin<'a>(&'a self, body: &'a Body) -> Skin<'a> {
        Skin::new(body, &self.positions)
    }
}

/// `rest` moved rigidly so that it comes nearest to `carried`.
fn rigidly(rest: &[Point3<f64>], carried: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let weights = vec![1.0; rest.len()];
    let turn = Similarity::fit(rest, carried, &weights, Orientation::Fitted).rotation;
    let middle = |points: &[Point3<f64>]| points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let (from, to) = (middle(rest), middle(carried));
    rest.iter().map(|p| Point3::from(to + turn * (p.coords - from))).collect()
}

/// The region of `body` that `point` belongs to, with a number to sort by along the body.
pub fn region(body: &Body, point: &Point3<f64>) -> (String, f64) {
    let distance = |index: usize| {
        let part = &body.parts[index];
        if part.limb == Limb::Spine { body.trunk(point) } else { part.chain.distance(point).0 }
    };
    let nearest = (0..body.parts.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    let part = &body.parts[nearest];
    let s = part.chain.soft_parameter(point);
    let side = if part.right { "right" } else { "left" };
    let name = match part.limb {
        Limb::Spine if s < 6.0 => "trunk".into(),
        Limb::Spine if s < 10.0 => "neck".into(),
        Limb::Spine => "head".into(),
        Limb::Front => format!("{side}_front_leg"),
        Limb::Hind => format!("{side}_hind_leg"),
        Limb::Tail => "tail".into(),
        Limb::Ear => format!("{side}_ear"),
        Limb::Horn => format!("{side}_horn"),
    };
    // A limb's parameter stays below this.
    (name, 100.0 * nearest as f64 + s)
}

/// Names for pieces at `places` (a region and a number to sort by), and the order to put them in: along the body, each
/// region counting its own from 1.
pub fn named(places: &[(String, f64)]) -> Vec<(usize, (String, String))> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&a, &b| places[a].1.total_cmp(&places[b].1).then(a.cmp(&b)));
    let mut count = 0;
    let mut result: Vec<(usize, (String, String))> = vec![];
    for index in order {
        let region = &places[index].0;
        count = if result.last().is_some_and(|(_, (_, last))| last == region) { count + 1 } else { 1 };
        result.push((index, (format!("{region}_{count}"), region.clone())));
    }
    result
}

#[cfg(test)]
mod tests {
    use super::{
        super::{Gait, MadeOf, Proportions, Quadruped, boxes, pebbles, plates},
        *,
    };

    fn camel(made_of: MadeOf) -> (Body, Pieces) {
        let camel = Quadruped { proportions: Proportions::Camel, resolution: 30, ..Quadruped::default() };
        let body = Body::new(camel.proportions.animal());
        let (positions, triangles) = camel.mesh(&body);
        let pieces = match made_of {
            MadeOf::Pebbles => pebbles::pebbles(&body, &positions, &triangles, (120, camel.edge(&body), 3)),
            MadeOf::Plates => plates::plates(&body, &positions, &triangles, (50, 3)),
            MadeOf::Skin | MadeOf::Boxes => boxes::boxes(&body, camel.edge(&body)),
        };
        (body, pieces)
    }

    #[test]
    fn standing_still_gives_the_rest_shape() {
        for made_of in [MadeOf::Pebbles, MadeOf::Plates, MadeOf::Boxes] {
            let (body, pieces) = camel(made_of);
            let still = pieces.moved(&pieces.skin(&body).pose(Gait::None, 0.3));
            for (posed, rest) in still.iter().zip(&pieces.positions) {
                // Normals and rotations add little to what the sums along limbs round to.
                assert!((posed - rest).norm() < 1e-11, "{made_of:?}");
            }
        }
    }

    #[test]
    fn outer_sides_of_plates_follow_the_skin_and_inner_sides_stay_at_their_depth() {
        let (body, plates) = camel(MadeOf::Plates);
        let carried = plates.skin(&body).pose(Gait::Gallop, 0.4);
        let posed = plates.moved(&carried);
        for piece in &plates.pieces {
            let Motion::Sheet(sheet) = &piece.motion else { panic!("{} is rigid", piece.name) };
            assert_eq!(piece.vertices.len(), 2 * sheet.depths.len());
            let (start, inner) = (piece.vertices.start, piece.vertices.start + sheet.depths.len());
            for (v, depth) in sheet.depths.iter().enumerate() {
                // The projection ends once it is this near to the surface.
                assert!(body.distance(&plates.positions[start + v]).abs() < 1e-5, "{}", piece.name);
                // Round a sharp rim, e.g. of a sole, the inner side is deep along the normal and yet not far from the skin.
                assert!(body.distance(&plates.positions[inner + v]) < -0.1 * depth, "{}", piece.name);
                assert_eq!(posed[start + v], carried[start + v]);
                let thickness = (posed[start + v] - posed[inner + v]).norm();
                assert!((thickness - depth).abs() < 1e-12 && *depth > 0.001, "{} {thickness} {depth}", piece.name);
            }
        }
    }

    #[test]
    fn outer_sides_of_pebbles_lie_on_the_skin() {
        let (body, pebbles) = camel(MadeOf::Pebbles);
        for piece in &pebbles.pieces {
            let highest = pebbles.positions[piece.vertices.clone()].iter().map(|p| body.distance(p));
            let highest = highest.fold(f64::NEG_INFINITY, f64::max);
            // Rays end within a ten-thousandth of a pebble of the skin. The crown of a rounded pebble touches it or nearly so.
            assert!(highest < 1e-4 && highest > -0.02, "{}: {highest}", piece.name);
        }
    }
}
