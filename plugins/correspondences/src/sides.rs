//! Which of two boundaries at one place a vertex belongs to, as at closed lips.

use mimesh_core::{
    mesh::{Surface, SurfacePoint},
    operators::vertex_normals,
    stage::TransferPair,
};
use nalgebra::{Point3, Vector3};

use crate::facing::Facing;

/// The part of the way from a vertex to the middles of its triangles at which its side is looked for.
const INWARDS: f64 = 0.5;

/// How much farther than the closest a triangle of the right side may be, as a part of that way.
const SLACK: f64 = 0.1;

/// Takes source points of target vertices at opened seams to their own side of the source's.
///
/// Two lips that are closed at rest lie at one place, so that the closest point may lie on either. Among the source triangles that are
/// as good as closest, a vertex takes the one closest to a point a little way into its own triangles. `fit` are the target's positions
/// where both surfaces are compared; without such seams on both nothing changes.
pub fn keep_sides(
    pair: TransferPair<'_>,
    fit: &[Point3<f64>],
    facing: &Facing,
    limit: f64,
    points: &mut [Option<SurfacePoint>],
) {
    let of_source = along_seams(pair.source);
    if of_source.is_empty() {
        return;
    }
    let of_target = along_seams(pair.target);
    if of_target.is_empty() {
        return;
    }
    let around_target = pair.target.triangles_around();
    let middles = pair.target.barycentres(fit);
    let normals = vertex_normals(fit, &pair.target.triangles);
    let at_seam = |t: u32| pair.source.triangles[t as usize].iter().any(|v| of_source.binary_search(v).is_ok());
    for v in of_target {
        let (at, normal) = (&fit[v as usize], &normals[v as usize]);
        let Some(closest) = facing.find(at, normal, limit).filter(|found| at_seam(found.triangle)) else { continue };
        let around = &around_target[v as usize];
        let sum: Vector3<f64> = around.iter().map(|&t| middles[t as usize] - at).sum();
        let way = sum / around.len() as f64;
        let reach = closest.distance + SLACK * way.norm();
        let near = |t: u32| facing.find_among(at, reach, |other| other == t && facing.faces(t, normal));
        let side = facing.find_among(&(at + way * INWARDS), limit, |t| facing.faces(t, normal) && near(t).is_some());
        if let Some(found) = side.and_then(|side| near(side.triangle)) {
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
