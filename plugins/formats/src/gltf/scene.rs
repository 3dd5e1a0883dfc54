//! The meshes of the default scene with their places.

use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::schema::{Node, Root, get};

/// A node that shows a mesh.
pub struct Placed<'a> {
    /// The node.
    pub node: &'a Node,
    /// The index of its mesh.
    pub mesh: usize,
    /// The transform from the mesh to the scene.
    pub scene_from_mesh: Matrix4<f64>,
}

/// The nodes with a mesh in the default scene, else the first, else in no scene at all; parents before children.
///
/// A skinned mesh is placed by its joints and not by its node, so it stays where its bind pose has it.
///
/// # Errors
///
/// Names the node or scene that does not exist, or that stands in a circle.
pub fn placed(root: &Root) -> Result<Vec<Placed<'_>>, String> {
    let mut pending: Vec<(usize, Matrix4<f64>)> = Vec::new();
    let push_all = |pending: &mut Vec<_>, nodes: &[usize], parent: Matrix4<f64>| {
        pending.extend(nodes.iter().rev().map(|&node| (node, parent)));
    };
    push_all(&mut pending, &roots(root)?, Matrix4::identity());
    let mut found = Vec::new();
    let mut seen = vec![false; root.nodes.len()];
    while let Some((index, parent)) = pending.pop() {
        let node = get(&root.nodes, index, "node")?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("node {index} stands in two places of the scene"));
        }
        let scene_from_node = parent * local(node);
        if let Some(mesh) = node.mesh {
            let scene_from_mesh = if node.skin.is_some() { Matrix4::identity() } else { scene_from_node };
            found.push(Placed { node, mesh, scene_from_mesh });
        }
        push_all(&mut pending, &node.children, scene_from_node);
    }
    Ok(found)
}

/// The nodes to start from.
fn roots(root: &Root) -> Result<Vec<usize>, String> {
    if let Some(scene) = root.scene {
        return Ok(get(&root.scenes, scene, "scene")?.nodes.clone());
    }
    if let Some(scene) = root.scenes.first() {
        return Ok(scene.nodes.clone());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for &child in root.nodes.iter().flat_map(|node| &node.children) {
        is_child.get_mut(child).into_iter().for_each(|is_child| *is_child = true);
    }
    Ok((0..root.nodes.len()).filter(|&node| !is_child[node]).collect())
}

/// The transform of a node in its parent.
fn local(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = &node.matrix {
        return Matrix4::from_column_slice(matrix);
    }
    let translation = Translation3::from(Vector3::from(node.translation.unwrap_or_default()));
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), f64::MIN_POSITIVE).unwrap_or_default();
    let scale = Vector3::from(node.scale.unwrap_or([1.0; 3]));
    translation.to_homogeneous() * rotation.to_homogeneous() * Matrix4::new_nonuniform_scaling(&scale)
}
