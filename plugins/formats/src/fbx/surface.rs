//! The polygons of placed meshes, with what their corners have.

use std::collections::{HashMap, HashSet};

use mimesh_core::mesh::{CornerAttribute, Mesh, Part};
use nalgebra::{Matrix3, Matrix4, Vector3};
use ufbx::{Scene, VertexVec2, VertexVec3};

use super::{
    bind::Transforms,
    colors::VertexColors,
    evaluator::Run,
    placed::{Placed, material_names, material_of},
};

/// The mesh of all placed meshes, still without positions; `transforms` are those of the runs at rest.
///
/// Polygons of mirrored meshes are turned over. With `is_morphed` there are no normals, since the file's are of another shape.
pub fn assemble(
    scene: &Scene,
    placed: &[Placed],
    runs: &[Run],
    transforms: &[Transforms],
    is_morphed: bool,
) -> Assembled {
    let names = material_names(scene);
    let (mut mesh, mut used, mut left_out) = (Mesh::default(), HashSet::new(), Vec::new());
    let mut colors = VertexColors::default();
    let (mut textures, mut normals) = (Corners::default(), Corners::default());
    for ((placed, run), transforms) in placed.iter().zip(runs).zip(transforms) {
        let (node, stored) = (&scene.nodes[placed.node], &scene.meshes[placed.mesh]);
        let is_mirrored = is_mirrored(transforms);
        tell_left_out(stored, &mut left_out);
        textures.start();
        normals.start();
        for &polygon in &placed.polygons {
            let face = &stored.faces[polygon];
            let first = face.index_begin as usize;
            let mut corners: Vec<usize> = (first..first + face.num_indices as usize).collect();
            if is_mirrored {
                corners[1..].reverse();
            }
            corners.iter().for_each(|&corner| {
                colors.add(&stored.vertex_color, corner, run.vertices.start + stored.vertex_indices[corner] as usize)
            });
            let vertex = |corner: &usize| stored.vertex_indices[*corner] as usize;
            let vertices: Vec<u32> = corners.iter().map(|c| (run.vertices.start + vertex(c)) as u32).collect();
            mesh.polygons.push(&vertices);
            for corner in &corners {
                textures.add(texture(&stored.vertex_uv, *corner));
                let normal = (!is_morphed).then(|| normal(&stored.vertex_normal, *corner, vertex(corner), transforms));
                normals.add(normal.flatten());
            }
            let material = material_of(node, stored, polygon);
            used.extend(material);
            let material = material.and_then(|material| names.get(&material)).cloned();
            let number = mesh.polygons.len();
            match mesh.parts.last_mut() {
                Some(last) if last.object.as_deref() == Some(&placed.name) && last.material == material => {
                    last.polygons.end = number;
                }
                _ => mesh.parts.push(Part {
                    object: Some(placed.name.clone()),
                    material,
                    polygons: number - 1..number,
                    ..Part::default()
                }),
            }
        }
    }
    mesh.vertex_colors = colors.finish(runs.last().map_or(0, |run| run.vertices.end), &mut left_out);
    mesh.texture_coordinates = textures.finish();
    mesh.normals = normals.finish();
    Assembled { mesh, materials: used, left_out }
}

/// A mesh with what does not fit into it.
pub struct Assembled {
    pub mesh: Mesh,
    /// The materials of its polygons, by the numbers of the elements.
    pub materials: HashSet<u32>,
    /// The names of what was not read.
    pub left_out: Vec<String>,
}

/// Adds the names of what `mesh` has beyond one set of texture coordinates and one of colours, each once.
fn tell_left_out(mesh: &ufbx::Mesh, left_out: &mut Vec<String>) {
    for (count, name) in
        [(mesh.uv_sets.len(), "further texture coordinates"), (mesh.color_sets.len(), "further colours of vertices")]
    {
        if count > 1 && !left_out.iter().any(|known| known == name) {
            left_out.push(name.into());
        }
    }
}

/// The values of corners; one that corners share is there once.
struct Corners<T> {
    attribute: CornerAttribute<T>,
    /// The values of the current mesh, by their number in it and the vertex that moves them.
    known: HashMap<(u32, usize), u32>,
}

impl<T> Default for Corners<T> {
    fn default() -> Self {
        let attribute = CornerAttribute { values: Vec::new(), indices: Vec::new() };
        Self { attribute, known: HashMap::new() }
    }
}

impl<T> Corners<T> {
    fn start(&mut self) {
        self.known.clear();
    }

    fn add(&mut self, value: Option<((u32, usize), T)>) {
        let index = value.map(|(key, value)| {
            *self.known.entry(key).or_insert_with(|| {
                self.attribute.values.push(value);
                (self.attribute.values.len() - 1) as u32
            })
        });
        self.attribute.indices.push(index);
    }

    fn finish(self) -> Option<CornerAttribute<T>> {
        (!self.attribute.values.is_empty()).then_some(self.attribute)
    }
}

/// The texture coordinates of a corner; both have their origin at the lower left.
fn texture(coordinates: &VertexVec2, corner: usize) -> Option<((u32, usize), [f64; 2])> {
    let index = *coordinates.indices.get(corner)?;
    let value = coordinates.values.get(index as usize)?;
    (value.x.is_finite() && value.y.is_finite()).then_some(((index, 0), [value.x, value.y]))
}

/// The unit normal of a corner, moved as its vertex is.
fn normal(
    normals: &VertexVec3,
    corner: usize,
    vertex: usize,
    transforms: &Transforms,
) -> Option<((u32, usize), [f64; 3])> {
    let index = *normals.indices.get(corner)?;
    let value = normals.values.get(index as usize)?;
    let value = cofactors(transforms.of(vertex)) * Vector3::new(value.x, value.y, value.z);
    let length = value.norm();
    // Vertices of one transform share their normals.
    let mover = if matches!(transforms, Transforms::Uniform(_)) { 0 } else { vertex };
    (length > 0.0 && length.is_finite()).then(|| ((index, mover), (value / length).into()))
}

/// The matrix that moves normals with points: of cofactors, up to a positive factor the inverse transpose.
fn cofactors(matrix: &Matrix4<f64>) -> Matrix3<f64> {
    let linear: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
    let [x, y, z] = [0, 1, 2].map(|column| linear.column(column).into_owned());
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    Matrix3::from_columns(&[y.cross(&z), z.cross(&x), x.cross(&y)]) * sign
}

/// Whether most vertices are mirrored, which turns their polygons inside out.
fn is_mirrored(transforms: &Transforms) -> bool {
    let is_mirror = |matrix: &Matrix4<f64>| matrix.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
    match transforms {
        Transforms::Uniform(matrix) => is_mirror(matrix),
        Transforms::Skinned(matrices) => 2 * matrices.iter().filter(|m| is_mirror(m)).count() > matrices.len(),
    }
}
