//! The polygons of placed meshes, with what their corners have.

use std::collections::{HashMap, HashSet};

use mimesh_core::mesh::{self, CornerAttribute, Mesh, Part};
use nalgebra::{Matrix3, Matrix4, Vector3};
use ufbx::{Scene, VertexVec2, VertexVec3};

use super::{
    bind::Transforms,
    evaluator::Run,
    placed::{Placed, material_names, material_of},
};

/// The mesh of all placed meshes, still without positions; `transforms` are those of the runs at rest.
///
/// Polygons of mirrored meshes are turned over. With `is_morphed` there are no normals, since the file's are of another shape.
pub fn assemble(scene: &Scene, placed: &[Placed], runs: &[Run], transforms: &[Transforms], is_morphed: bool) -> Mesh {
    let names = material_names(scene);
    let (mut mesh, mut used) = (Mesh::default(), HashSet::new());
    let (mut textures, mut normals) = (Corners::default(), Corners::default());
    for ((placed, run), transforms) in placed.iter().zip(runs).zip(transforms) {
        let (node, stored) = (&scene.nodes[placed.node], &scene.meshes[placed.mesh]);
        let is_mirrored = is_mirrored(transforms);
        textures.start();
        normals.start();
        for &polygon in &placed.polygons {
            let face = &stored.faces[polygon];
            let first = face.index_begin as usize;
            let mut corners: Vec<usize> = (first..first + face.num_indices as usize).collect();
            if is_mirrored {
                corners[1..].reverse();
            }
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
    mesh.materials = materials(scene, &names, &used);
    mesh.texture_coordinates = textures.finish();
    mesh.normals = normals.finish();
    mesh
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

/// The materials that are `used`.
fn materials(scene: &Scene, names: &HashMap<u32, String>, used: &HashSet<u32>) -> Vec<mesh::Material> {
    let used = scene.materials.iter().filter(|material| used.contains(&material.element.element_id));
    let read = |material: &ufbx::Material| {
        let (colour, factor, opacity) = (&material.pbr.base_color, &material.pbr.base_factor, &material.pbr.opacity);
        let factor = if factor.has_value { factor.value_vec4.x } else { 1.0 };
        let [r, g, b] = [colour.value_vec4.x, colour.value_vec4.y, colour.value_vec4.z].map(|channel| channel * factor);
        let base_color = if colour.has_value { [r, g, b] } else { [1.0; 3] };
        let opacity = if opacity.has_value { opacity.value_vec4.x } else { 1.0 };
        let in_range = |channel: f64| if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 1.0 };
        let [r, g, b] = base_color.map(in_range);
        let name = names[&material.element.element_id].clone();
        mesh::Material { name, base_color: [r, g, b, in_range(opacity)] }
    };
    used.map(|material| read(material)).collect()
}
