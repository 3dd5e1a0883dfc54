//! Attributes of corners that are attributes of vertices.

use mimesh_core::mesh::{CornerAttribute, Mesh};

/// For each vertex the value that all of its corners have; `None` if any vertex has two.
pub fn by_vertex<T>(mesh: &Mesh, attribute: &CornerAttribute<T>) -> Option<Vec<Option<u32>>> {
    let mut values = vec![None; mesh.positions.len()];
    for (&vertex, &value) in mesh.polygons.corners().iter().zip(&attribute.indices) {
        let known = &mut values[vertex as usize];
        if known.is_some() && *known != value {
            return None;
        }
        *known = value;
    }
    Some(values)
}
