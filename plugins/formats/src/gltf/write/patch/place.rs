//! A placement of the document with what its displacements are computed from.

use mimesh_core::mesh::Mesh;
use nalgebra::{Matrix3, Matrix4, Point3, Vector3};

use super::stored::{list, number, vectors};
use crate::{
    gltf::document::{GltfDocument, Placement, Transforms},
    normals::PosedNormals,
};

/// Above this condition number a displacement in the stored space has no digits left in f32.
const MAX_CONDITION: f64 = 1e6;

/// A placement, its transforms inverted.
#[derive(Debug)]
pub struct Place {
    /// From scene to stored mesh, without translations; `None` where there is no way back.
    stored_from_scene: Linear,
    /// Where the file shows the vertices with all morph targets at 0, in the scene.
    at_zero: Vec<Point3<f64>>,
    /// The normals of each accessor that the primitives have.
    pub normals: Vec<StoredNormals>,
    /// One a primitive: its entry in `normals`.
    pub normals_of: Vec<Option<usize>>,
    /// Whether a vertex has moved where there is no way back.
    pub stuck: Vec<bool>,
}

/// Linear maps of vertices.
#[derive(Debug)]
enum Linear {
    Uniform(Option<Matrix3<f64>>),
    Skinned(Vec<Option<Matrix3<f64>>>),
}

impl Linear {
    fn get(&self, vertex: usize) -> Option<&Matrix3<f64>> {
        match self {
            Self::Uniform(linear) => linear.as_ref(),
            Self::Skinned(linear) => linear[vertex].as_ref(),
        }
    }
}

/// The normals of the vertices of a placement.
#[derive(Debug)]
pub struct StoredNormals {
    /// As they stand in the file.
    stored: Vec<[f64; 3]>,
    /// The group of [`PosedNormals`] that each vertex turns with.
    group_of: Vec<Option<u32>>,
}

impl Place {
    /// Inverts the transforms of `placement` in `mesh`; with `normals` of its mesh, also finds how the stored ones turn.
    pub fn new(
        document: &GltfDocument,
        placement: &Placement,
        mesh: &Mesh,
        normals: Option<(&PosedNormals, &CornersAt)>,
    ) -> Self {
        let stored_from_scene = match &placement.scene_from_stored {
            Transforms::Uniform(matrix) => Linear::Uniform(inverse(matrix)),
            Transforms::Skinned(matrices) => Linear::Skinned(matrices.iter().map(inverse).collect()),
        };
        let mut place = Self {
            stored_from_scene,
            at_zero: at_zero(placement, &mesh.positions[placement.vertices.clone()]),
            normals: Vec::new(),
            normals_of: vec![None; placement.primitives.len()],
            stuck: vec![false; placement.vertices.len()],
        };
        let Some((posed, corners)) = normals else { return place };
        let mut known: Vec<usize> = Vec::new();
        for (at, &primitive) in placement.primitives.iter().enumerate() {
            let primitive = &list(&list(&document.json, "meshes")[placement.mesh], "primitives")[primitive];
            let Some(accessor) = primitive.get("attributes").and_then(|all| number(all, "NORMAL")) else { continue };
            let entry = match known.iter().position(|&other| other == accessor) {
                Some(entry) => entry,
                None => {
                    let Some(stored) = vectors(document, accessor, placement.vertices.len()) else { continue };
                    place.normals.push(StoredNormals::new(stored, placement, posed, corners));
                    known.push(accessor);
                    known.len() - 1
                }
            };
            place.normals_of[at] = Some(entry);
        }
        place
    }

    /// The displacements in the stored space that move the vertices to `posed` in the scene.
    ///
    /// They start where all other morph targets are at 0, even if the mesh rests in one of them: shown alone, a target gives its pose.
    /// A vertex that stays has exactly 0; so has one without a way back, which is noted in [`stuck`](Self::stuck).
    pub fn displacements(&mut self, posed: &[Point3<f64>]) -> Vec<[f32; 3]> {
        let displacement = |(vertex, (from, to)): (usize, (&Point3<f64>, &Point3<f64>))| {
            if from == to {
                return [0.0; 3];
            }
            let moved = self.stored_from_scene.get(vertex).map(|linear| (linear * (to - from)).map(|x| x as f32));
            match moved.filter(|moved| moved.iter().all(|x| x.is_finite())) {
                Some(moved) => moved.into(),
                None => {
                    self.stuck[vertex] = true;
                    [0.0; 3]
                }
            }
        };
        self.at_zero.iter().zip(posed).enumerate().map(displacement).collect()
    }

    /// The differences from the stored `normals` to those that turn as the groups do, from `rest` to `posed`.
    pub fn turns(
        &self,
        normals: &StoredNormals,
        transforms: &Transforms,
        rest: &[[f64; 3]],
        posed: &[[f64; 3]],
    ) -> Vec<[f32; 3]> {
        let turn = |(vertex, stored): (usize, &[f64; 3])| {
            let Some(group) = normals.group_of[vertex].map(|group| group as usize) else { return [0.0; 3] };
            if posed[group] == rest[group] || self.stored_from_scene.get(vertex).is_none() {
                return [0.0; 3];
            }
            // Normals go with the inverse transpose, so back with the transpose.
            let normal = linear(transform(transforms, vertex)).transpose() * Vector3::from(posed[group]);
            let Some(normal) = normal.try_normalize(f64::MIN_POSITIVE) else { return [0.0; 3] };
            let turn = (normal - Vector3::from(*stored)).map(|x| x as f32);
            if turn.iter().all(|x| x.is_finite()) { turn.into() } else { [0.0; 3] }
        };
        normals.stored.iter().enumerate().map(turn).collect()
    }
}

impl StoredNormals {
    fn new(stored: Vec<[f64; 3]>, placement: &Placement, posed: &PosedNormals, corners: &CornersAt) -> Self {
        let group_of = stored.iter().enumerate().map(|(vertex, normal)| {
            if Vector3::from(*normal).norm_squared() == 0.0 {
                return None;
            }
            let inverse = inverse(transform(&placement.scene_from_stored, vertex))?;
            let in_scene = (inverse.transpose() * Vector3::from(*normal)).try_normalize(f64::MIN_POSITIVE)?;
            // Primitives may share a vertex and have different normals there: the corner whose normal this one is.
            let groups =
                corners.at(placement.vertices.start + vertex).iter().map(|&corner| posed.group_of[corner as usize]);
            let likeness = |group: u32| in_scene.dot(&Vector3::from(posed.rest()[group as usize]));
            groups.max_by(|&a, &b| likeness(a).total_cmp(&likeness(b)).then(b.cmp(&a)))
        });
        let group_of = group_of.collect();
        Self { stored, group_of }
    }
}

/// Where the vertices of `placement` are in the scene with all morph targets at 0; exactly at `rest` where that is no morph target.
fn at_zero(placement: &Placement, rest: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let extent = rest.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let place = |(vertex, (stored, rest)): (usize, (&Point3<f64>, &Point3<f64>))| {
        let stored = transform(&placement.scene_from_stored, vertex).transform_point(stored);
        // Rounding errors of the two ways to the scene are far smaller, displacements in f32 larger.
        if (stored - rest).norm() <= 1e-9 * extent { *rest } else { stored }
    };
    placement.stored.iter().zip(rest).enumerate().map(place).collect()
}

/// The corners at each vertex of a mesh.
#[derive(Debug)]
pub struct CornersAt {
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl CornersAt {
    /// Sorts the corners of `mesh` by vertex.
    pub fn new(mesh: &Mesh) -> Self {
        let vertices = mesh.polygons.corners();
        let mut starts = vec![0_u32; mesh.positions.len() + 1];
        vertices.iter().for_each(|&vertex| starts[vertex as usize + 1] += 1);
        (1..starts.len()).for_each(|i| starts[i] += starts[i - 1]);
        let mut corners: Vec<u32> = (0..vertices.len() as u32).collect();
        corners.sort_by_key(|&corner| vertices[corner as usize]);
        Self { starts, corners }
    }

    fn at(&self, vertex: usize) -> &[u32] {
        &self.corners[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

fn transform(transforms: &Transforms, vertex: usize) -> &Matrix4<f64> {
    match transforms {
        Transforms::Uniform(matrix) => matrix,
        Transforms::Skinned(matrices) => &matrices[vertex],
    }
}

fn linear(matrix: &Matrix4<f64>) -> Matrix3<f64> {
    matrix.fixed_view::<3, 3>(0, 0).into()
}

/// The inverse of the linear part; `None` if that is singular or so nearly that f32 holds no digit of the result.
fn inverse(matrix: &Matrix4<f64>) -> Option<Matrix3<f64>> {
    let linear = linear(matrix);
    // Scaled to size 1, so that small models are not taken for singular ones.
    let size = linear.norm();
    let inverse = (linear / size).try_inverse()?;
    (inverse.norm() <= MAX_CONDITION).then(|| inverse / size).filter(|inverse| inverse.iter().all(|x| x.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_without_a_way_back_has_no_inverse() {
        let scale = |x, y, z| Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z));
        for matrix in [scale(1., 0., 1.), scale(1., 1e-7, 1.), scale(0., 0., 0.), scale(f64::NAN, 1., 1.)] {
            assert_eq!(inverse(&matrix), None, "{matrix}");
        }
        // Small is not singular.
        let tiny = inverse(&scale(1e-12, 1e-12, 1e-12)).unwrap();
        assert!((tiny * 1e-12 - Matrix3::identity()).norm() < 1e-15);
        assert!(inverse(&scale(1., 1e-4, -1.)).is_some());
    }
}
