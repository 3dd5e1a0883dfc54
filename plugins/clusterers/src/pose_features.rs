//! Features of poses at each vertex: rotation and stretch of its ring of neighbours (eqs. 6 to 15 of Yang et al. 2018).

use mimesh_core::{
    mesh::Surface,
    operators::{cotangent_laplacian, polar},
};
use nalgebra::{DMatrix, Matrix3, Point3, Vector3};
use rayon::prelude::*;

use crate::unwrap::logarithms;

/// Dimensions a pose: a rotation, and a symmetric matrix.
const DIMENSIONS: usize = 3 + 6;

/// The least weight of an edge, for cotangents may be negative and then have no least squares.
const MIN_WEIGHT: f64 = 0.01;

/// How much the normal counts against the edges of a ring: it decides across the plane of a ring that is flatter than about the
/// square root of this, times its size.
const NORMAL_WEIGHT: f64 = 0.01;

/// How much not moving counts against the edges of a ring without area.
const REST_WEIGHT: f64 = 1e-6;

/// [γ_logr log r, γ_s s] / √m of each vertex (#V) over m poses.
///
/// Distances between rows are those of the paper: of its nine entries of a symmetric matrix it keeps six, those off the
/// diagonal times √2.
pub(crate) fn pose_features(
    surface: &Surface,
    poses: &[Vec<Point3<f64>>],
    rotation_weight: f64,
    stretch_weight: f64,
) -> DMatrix<f64> {
    let rings = Rings::new(surface);
    let scale = 1.0 / (poses.len().max(1) as f64).sqrt();
    let of_poses: Vec<Vec<[f64; DIMENSIONS]>> = poses
        .par_iter()
        .map(|pose| rings.features(surface, pose, rotation_weight * scale, stretch_weight * scale))
        .collect();
    DMatrix::from_fn(DIMENSIONS * poses.len(), surface.vertex_count(), |d, v| {
        of_poses[d / DIMENSIONS][v][d % DIMENSIONS]
    })
}

/// The neighbours of each vertex with weights, and what of eq. 6 depends on the rest alone.
struct Rings {
    neighbours: Vec<Vec<(u32, f64)>>,
    rings: Vec<Option<Ring>>,
}

struct Ring {
    /// Σ w e eᵀ with what fills it up, inverted.
    inverse: Matrix3<f64>,
    /// Σ w ‖e‖².
    size: f64,
    /// The normal, and its length as a sum of areas; none in a ring without area.
    normal: Option<(Vector3<f64>, f64)>,
}

impl Rings {
    fn new(surface: &Surface) -> Self {
        let mut neighbours = vec![Vec::new(); surface.vertex_count()];
        for (i, j, &value) in cotangent_laplacian(&surface.positions, &surface.triangles).triplet_iter() {
            if i != j {
                let weight = (-value).max(MIN_WEIGHT);
                neighbours[i].push((j as u32, weight));
                neighbours[j].push((i as u32, weight));
            }
        }
        let normals = normals(surface, &surface.positions);
        let p = &surface.positions;
        let rings = neighbours.iter().enumerate().map(|(i, around)| {
            let edges = around.iter().map(|&(j, w)| {
                let e = p[i] - p[j as usize];
                e * e.transpose() * w
            });
            let sum: Matrix3<f64> = edges.sum();
            let size = sum.trace();
            let length = normals[i].norm();
            let normal = (length > 1e-9 * size).then(|| (normals[i] / length, length));
            let along = normal.map_or_else(Matrix3::zeros, |(n, _)| n * n.transpose() * (NORMAL_WEIGHT * size));
            let inverse = (sum + along + Matrix3::identity() * (REST_WEIGHT * size)).try_inverse()?;
            Some(Ring { inverse, size, normal })
        });
        Self { rings: rings.collect(), neighbours }
    }

    fn features(
        &self,
        surface: &Surface,
        pose: &[Point3<f64>],
        rotation_weight: f64,
        stretch_weight: f64,
    ) -> Vec<[f64; DIMENSIONS]> {
        let back = rotation_of_the_whole(&surface.positions, pose).transpose();
        let pose: Vec<_> = pose.iter().map(|q| back * q).collect();
        let normals = normals(surface, &pose);
        let parts: Vec<_> = (0..pose.len()).map(|i| polar(&self.gradient(i, surface, &pose, &normals[i]))).collect();
        let rotations: Vec<_> = parts.iter().map(|part| part.rotation).collect();
        let logarithms = logarithms(&rotations, &self.neighbours);
        let row = |(log, s): (&Vector3<f64>, &Matrix3<f64>)| {
            let (r, d) = (rotation_weight, stretch_weight);
            let twice = d * std::f64::consts::SQRT_2;
            let off = [s[(0, 1)] * twice, s[(0, 2)] * twice, s[(1, 2)] * twice];
            [log.x * r, log.y * r, log.z * r, s[(0, 0)] * d, s[(1, 1)] * d, s[(2, 2)] * d, off[0], off[1], off[2]]
        };
        logarithms.iter().zip(parts.iter().map(|part| &part.stretch)).map(row).collect()
    }

    /// D of eq. 6; the identity where vertex `i` has no ring.
    fn gradient(&self, i: usize, surface: &Surface, pose: &[Point3<f64>], posed_normal: &Vector3<f64>) -> Matrix3<f64> {
        let Some(ring) = &self.rings[i] else { return Matrix3::identity() };
        let p = &surface.positions;
        let edges = self.neighbours[i].iter().map(|&(j, w)| {
            let j = j as usize;
            (pose[i] - pose[j]) * (p[i] - p[j]).transpose() * w
        });
        let sum: Matrix3<f64> = edges.sum();
        let along = ring.normal.map_or_else(Matrix3::zeros, |(n, area)| {
            // As thick as the plane is wide: the normal grows with the square root of the area.
            let posed_area = posed_normal.norm();
            if posed_area > 0.0 { posed_normal * n.transpose() / (posed_area * area).sqrt() } else { Matrix3::zeros() }
        });
        (sum + along * (NORMAL_WEIGHT * ring.size) + Matrix3::identity() * (REST_WEIGHT * ring.size)) * ring.inverse
    }
}

/// For each vertex the sum of twice the areas about it times their normals, #V.
fn normals(surface: &Surface, positions: &[Point3<f64>]) -> Vec<Vector3<f64>> {
    let mut sums = vec![Vector3::zeros(); positions.len()];
    for (t, normal) in surface.triangles.iter().zip(surface.area_normals(positions)) {
        t.iter().for_each(|&v| sums[v as usize] += normal);
    }
    sums
}

/// The rotation of the rigid motion nearest to the pose.
fn rotation_of_the_whole(rest: &[Point3<f64>], pose: &[Point3<f64>]) -> Matrix3<f64> {
    let mean =
        |points: &[Point3<f64>]| points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let (from, to) = (mean(rest), mean(pose));
    let covariance: Matrix3<f64> =
        rest.iter().zip(pose).map(|(p, q)| (q.coords - to) * (p.coords - from).transpose()).sum();
    polar(&covariance).rotation
}
