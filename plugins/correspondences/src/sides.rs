//! Which of two boundaries at one place a vertex belongs to, as at closed lips.

use std::collections::HashSet;

use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    operators::vertex_normals,
    stage::TransferPair,
};
use nalgebra::{Point3, Vector3};

use crate::facing::Facing;

/// The part of the way from a vertex to the middles of its triangles at which its side is looked for.
const INWARDS: f64 = 0.5;

/// How far around a vertex its side of the source reaches, in ways to the middles of its triangles.
const REACH: f64 = 3.0;

/// Takes source points of target vertices at opened seams to their own side of the source's.
///
/// Two lips that are closed at rest lie at one place, so that the closest point may lie on either. A vertex goes with its triangles:
/// the source triangle closest to a point a little way into them, and those connected with it nearby, are its side. `source` and
/// `fit` are positions of both surfaces where they are compared; without such seams on both nothing changes.
pub fn keep_sides(
    pair: TransferPair<'_>,
    source: &[Point3<f64>],
    fit: &[Point3<f64>],
    facing: &Facing,
    limit: f64,
    points: &mut [Option<SurfacePoint>],
) {
    let (of_source, of_target) = (along_seams(pair.source), along_seams(pair.target));
    if of_source.is_empty() || of_target.is_empty() {
        return;
    }
    let around_target = pair.target.triangles_around();
    let around_source = pair.source.triangles_around();
    let middles = pair.target.barycentres(fit);
    let normals = vertex_normals(fit, &pair.target.triangles);
    let at_seam = |t: u32| pair.source.triangles[t as usize].iter().any(|v| of_source.binary_search(v).is_ok());
    for v in of_target {
        let Some(SurfacePoint::Triangle(triangle, _)) = points[v as usize] else { continue };
        if !at_seam(triangle) {
            continue;
        }
        let (at, around) = (fit[v as usize], &around_target[v as usize]);
        let sum: Vector3<f64> = around.iter().map(|&t| middles[t as usize] - at).sum();
        let way = sum / around.len() as f64;
        let Some(inside) = facing.find(&(at + way * INWARDS), &normals[v as usize], limit) else { continue };
        let reach = REACH * way.norm();
        let near = |t: u32| pair.source.triangles[t as usize].iter().any(|&u| (source[u as usize] - at).norm() < reach);
        let mut side = HashSet::from([inside.triangle]);
        let mut open = vec![inside.triangle];
        while let Some(t) = open.pop() {
            let corners = pair.source.triangles[t as usize];
            for &next in corners.iter().flat_map(|&u| &around_source[u as usize]) {
                if near(next) && side.insert(next) {
                    open.push(next);
                }
            }
        }
        let is_side = |t: u32| side.contains(&t) && facing.faces(t, &normals[v as usize]);
        if let Some(found) = facing.find_among(&at, limit, is_side) {
            points[v as usize] = Some(SurfacePoint::Triangle(found.triangle, found.barycentric));
        }
    }
}

/// The vertices along opened seams, in ascending order.
fn along_seams(surface: &Surface) -> Vec<u32> {
    let mut vertices: Vec<u32> = surface.unwelded_seams().into_iter().flatten().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
