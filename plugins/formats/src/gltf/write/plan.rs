//! How a mesh is cut into what glTF can hold: triangles, one attribute value a vertex, one material a primitive.

use std::collections::{HashMap, hash_map::Entry};

use mimesh_core::mesh::{CornerAttribute, Mesh};

use crate::normals::PosedNormals;

/// A mesh in the shape of a glTF.
#[derive(Debug)]
pub struct Plan {
    /// One a name in [`Part::object`](mimesh_core::mesh::Part::object), in order of first use.
    pub objects: Vec<Object>,
    /// The normals of the groups that vertices refer to.
    pub normals: PosedNormals,
}

/// An object, which becomes a node with a mesh.
#[derive(Debug, Default)]
pub struct Object {
    /// Its name, if the mesh has one for it.
    pub name: Option<String>,
    /// First the vertices of the mesh in their order, then further copies of those that lie on a seam.
    pub vertices: Vec<Vertex>,
    /// One a material, in order of first use.
    pub primitives: Vec<Primitive>,
    /// Whether any corner has texture coordinates.
    pub textured: bool,
}

/// A vertex of the mesh with the attributes of some of its corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Vertex {
    /// The vertex of the mesh.
    pub vertex: u32,
    /// The value in the mesh's texture coordinates.
    pub texture: Option<u32>,
    /// The group in [`PosedNormals`]; `None` for a vertex of no polygon.
    pub normal: Option<u32>,
}

/// The triangles of one material.
#[derive(Debug, Default)]
pub struct Primitive {
    /// The name of the material.
    pub material: Option<String>,
    /// Corners of triangles, as entries of [`Object::vertices`].
    pub indices: Vec<u32>,
}

impl Plan {
    /// Cuts polygons into fans from their first corner, and vertices where texture coordinates or normals jump.
    pub fn new(mesh: &Mesh) -> Self {
        let normals = PosedNormals::new(mesh, &mesh.positions);
        let mut objects = Vec::new();
        let mut used = vec![false; mesh.positions.len()];
        mesh.polygons.corners().iter().for_each(|&v| used[v as usize] = true);
        let mut loose: Vec<u32> = (0..used.len() as u32).filter(|&v| !used[v as usize]).collect();
        let textures = mesh.texture_coordinates.as_ref().map(distinct).unwrap_or_default();
        for (name, polygons) in by_object(mesh) {
            objects.push(object(mesh, name, &polygons, std::mem::take(&mut loose), &textures, &normals.group_of));
        }
        Self { objects, normals }
    }
}

/// A polygon and the name of its material.
type Dressed<'a> = (usize, Option<&'a str>);

/// The polygons with three corners or more and their materials, under the names of objects.
fn by_object(mesh: &Mesh) -> Vec<(Option<String>, Vec<Dressed<'_>>)> {
    let mut objects: Vec<(_, Vec<Dressed>)> = Vec::new();
    let mut numbers: HashMap<Option<&str>, usize> = HashMap::new();
    let mut parts = mesh.parts.iter().peekable();
    let (mut object, mut material) = (None, None);
    for polygon in 0..mesh.polygons.len() {
        while let Some(part) = parts.next_if(|part| part.polygons.start <= polygon) {
            (object, material) = (part.object.as_deref(), part.material.as_deref());
        }
        if mesh.polygons.get(polygon).len() < 3 {
            continue;
        }
        let number = *numbers.entry(object).or_insert_with(|| {
            objects.push((object.map(str::to_owned), Vec::new()));
            objects.len() - 1
        });
        objects[number].1.push((polygon, material));
    }
    objects
}

/// One object; `loose` are vertices of no polygon, which it takes in so that vertices keep their numbers.
fn object(
    mesh: &Mesh,
    name: Option<String>,
    polygons: &[Dressed],
    loose: Vec<u32>,
    textures: &[Option<u32>],
    group_of: &[u32],
) -> Object {
    let vertex_at = |corner: usize| Vertex {
        vertex: mesh.polygons.corners()[corner],
        texture: textures.get(corner).copied().flatten(),
        normal: Some(group_of[corner]),
    };
    let corners = polygons.iter().flat_map(|&(polygon, _)| mesh.polygons.corner_range(polygon));
    let mut wanted: Vec<(u32, Option<usize>)> = corners.map(|c| (mesh.polygons.corners()[c], Some(c))).collect();
    wanted.extend(loose.into_iter().map(|vertex| (vertex, None)));
    wanted.sort_unstable();

    let mut vertices = Vec::new();
    let mut copies = Vec::new();
    let mut numbers: HashMap<Vertex, u32> = HashMap::new();
    let mut last = None;
    for (vertex, corner) in wanted {
        let entry = corner.map_or(Vertex { vertex, texture: None, normal: None }, vertex_at);
        if last != Some(vertex) {
            numbers.insert(entry, vertices.len() as u32);
            vertices.push(entry);
            last = Some(vertex);
        } else if let Entry::Vacant(vacant) = numbers.entry(entry) {
            // Its number is known when all vertices are.
            vacant.insert(u32::MAX);
            copies.push(entry);
        }
    }
    for copy in copies {
        numbers.insert(copy, vertices.len() as u32);
        vertices.push(copy);
    }

    let mut primitives: Vec<Primitive> = Vec::new();
    let mut of_material: HashMap<Option<&str>, usize> = HashMap::new();
    for &(polygon, material) in polygons {
        let number = *of_material.entry(material).or_insert_with(|| {
            primitives.push(Primitive { material: material.map(str::to_owned), indices: Vec::new() });
            primitives.len() - 1
        });
        let corners: Vec<u32> = mesh.polygons.corner_range(polygon).map(|c| numbers[&vertex_at(c)]).collect();
        for pair in corners[1..].windows(2) {
            primitives[number].indices.extend([corners[0], pair[0], pair[1]]);
        }
    }
    let textured = vertices.iter().any(|vertex| vertex.texture.is_some());
    Object { name, vertices, primitives, textured }
}

/// For each corner the first value that is the same in f32, so that equal values make no seam.
fn distinct(textures: &CornerAttribute<[f64; 2]>) -> Vec<Option<u32>> {
    let mut first = HashMap::with_capacity(textures.values.len());
    let key = |value: &[f64; 2]| value.map(|x| (x as f32 + 0.0).to_bits());
    let entries = textures.values.iter().enumerate();
    let same: Vec<u32> = entries.map(|(i, value)| *first.entry(key(value)).or_insert(i as u32)).collect();
    textures.indices.iter().map(|index| index.map(|index| same[index as usize])).collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::mesh::Part;
    use nalgebra::Point3;

    use super::*;

    fn quads() -> Mesh {
        let positions = (0..7).map(|i| Point3::new(f64::from(i / 2), f64::from(i % 2), 0.0)).collect();
        let mut mesh = Mesh { positions, ..Mesh::default() };
        mesh.polygons.push(&[0, 2, 3, 1]);
        mesh.polygons.push(&[2, 4, 5, 3]);
        mesh
    }

    #[test]
    fn vertices_keep_their_numbers_and_copies_come_after_them() {
        let mut mesh = quads();
        // A seam of texture coordinates along 2-3; the second quad repeats a value of the first.
        let values = vec![[0., 0.], [0.5, 0.], [0.5, 1.], [0., 1.], [0.7, 0.], [1., 0.], [1., 1.], [0.5, 1.]];
        let indices = (0..8).map(Some).collect();
        mesh.texture_coordinates = Some(CornerAttribute { values, indices });
        let plan = Plan::new(&mesh);
        let object = &plan.objects[0];
        let vertices: Vec<_> = object.vertices.iter().map(|vertex| vertex.vertex).collect();
        assert_eq!(vertices, [0, 1, 2, 3, 4, 5, 6, 2]);
        assert_eq!(object.primitives[0].indices, [0, 2, 3, 0, 3, 1, 7, 4, 5, 7, 5, 3]);
        assert_eq!(object.vertices[6].normal, None);
    }

    #[test]
    fn objects_become_nodes_and_materials_primitives() {
        let mut mesh = quads();
        let part = |object: &str, material: &str, polygons| Part {
            object: Some(object.into()),
            groups: Vec::new(),
            material: Some(material.into()),
            polygons,
        };
        mesh.parts = vec![part("a", "red", 0..1), part("a", "blue", 1..2)];
        let plan = Plan::new(&mesh);
        assert_eq!(plan.objects.len(), 1);
        assert_eq!(plan.objects[0].primitives.len(), 2);
        mesh.parts[1].object = Some("b".into());
        let plan = Plan::new(&mesh);
        assert_eq!(plan.objects.len(), 2);
        assert_eq!(plan.objects[1].vertices.iter().map(|v| v.vertex).collect::<Vec<_>>(), [2, 3, 4, 5]);
        assert_eq!(plan.objects[1].primitives[0].indices, [0, 2, 3, 0, 3, 1]);
    }
}
