//! The tree of nodes, and where they stand.

use nalgebra::{Matrix3, Matrix4, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use serde_json::Value;

use super::asset::{Asset, get};
use crate::names::shown;

/// Transforms and weights are below this: far beyond f32, and so that the product of a few is finite.
pub const MAX_NUMBER: f64 = 1e60;

/// The transform of a node in its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Local {
    /// Scaled, then rotated, then moved; the quaternion is x, y, z, w of any length.
    Parts { translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3] },
    /// As a matrix.
    Matrix(Matrix4<f64>),
}

impl Local {
    /// The matrix that takes points of the node to its parent.
    pub fn matrix(&self) -> Matrix4<f64> {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts { translation, rotation: [x, y, z, w], scale } => {
                let rotation =
                    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), f64::MIN_POSITIVE).unwrap_or_default();
                Translation3::from(Vector3::from(translation)).to_homogeneous()
                    * rotation.to_homogeneous()
                    * Matrix4::new_nonuniform_scaling(&scale.into())
            }
        }
    }

    /// The same transform in parts, for channels that move one of them; shear is lost, as in other programs.
    pub fn in_parts(&self) -> Self {
        let Self::Matrix(matrix) = self else { return *self };
        let linear: Matrix3<f64> = matrix.fixed_view::<3, 3>(0, 0).into();
        let mut scale: [f64; 3] = std::array::from_fn(|axis| linear.column(axis).norm());
        if linear.determinant() < 0.0 {
            scale[0] = -scale[0];
        }
        let unit = |axis: usize| if scale[axis] == 0.0 { Vector3::zeros() } else { linear.column(axis) / scale[axis] };
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[unit(0), unit(1), unit(2)]));
        let rotation = UnitQuaternion::from_rotation_matrix(&rotation).coords.into();
        Self::Parts { translation: matrix.fixed_view::<3, 1>(0, 3).into_owned().into(), rotation, scale }
    }
}

/// The nodes of a file.
#[derive(Debug)]
pub struct Nodes {
    /// The transforms that the file stores.
    pub locals: Vec<Local>,
    /// The parent of each.
    pub parents: Vec<Option<usize>>,
    /// All nodes, parents first.
    order: Vec<usize>,
}

impl Nodes {
    /// Reads the nodes, and checks that they are a forest.
    ///
    /// # Errors
    ///
    /// Names a node that does not exist, that has two parents, that stands in a circle, or whose transform is no such.
    pub fn new(asset: &Asset) -> Result<Self, String> {
        let nodes = &asset.root.nodes;
        let mut parents = vec![None; nodes.len()];
        for (parent, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten().map(|child| child.value()) {
                get(nodes, child, "node")?;
                if parents[child].replace(parent).is_some() || child == parent {
                    return Err(format!("node {child} stands in two places of the scene"));
                }
            }
        }
        let mut order: Vec<usize> = (0..nodes.len()).filter(|&node| parents[node].is_none()).collect();
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            order.extend(nodes[node].children.iter().flatten().map(|child| child.value()));
            next += 1;
        }
        if order.len() < nodes.len() {
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|&node| reached[node] = true);
            let node = reached.iter().position(|reached| !reached).unwrap_or_default();
            return Err(format!("node {node} stands in a circle of nodes"));
        }
        let locals = (0..nodes.len()).map(|node| local(asset, node)).collect::<Result<_, _>>()?;
        let nodes = Self { locals, parents, order };
        nodes.check(asset, &nodes.worlds(&nodes.locals))?;
        Ok(nodes)
    }

    /// The transforms from each node to the scene.
    pub fn worlds(&self, locals: &[Local]) -> Vec<Matrix4<f64>> {
        let mut worlds = vec![Matrix4::identity(); locals.len()];
        for &node in &self.order {
            let local = locals[node].matrix();
            worlds[node] = self.parents[node].map_or(local, |parent| worlds[parent] * local);
        }
        worlds
    }

    /// Checks that `worlds` are finite, with room for the products with them.
    ///
    /// # Errors
    ///
    /// Names the first node whose transform is not.
    pub fn check(&self, asset: &Asset, worlds: &[Matrix4<f64>]) -> Result<(), String> {
        let is_sound = |matrix: &Matrix4<f64>| matrix.iter().all(|x| x.abs() < MAX_NUMBER);
        match self.order.iter().find(|&&node| !is_sound(&worlds[node])) {
            None => Ok(()),
            Some(&node) => Err(format!("{} has a transform that is not finite", name(asset, node))),
        }
    }

    /// The node and all above it.
    pub fn with_ancestors(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(node), |&node| self.parents[node])
    }
}

/// A node in messages.
pub fn name(asset: &Asset, node: usize) -> String {
    let given = asset.root.nodes.get(node).and_then(|node| node.name.as_deref()).filter(|name| !name.is_empty());
    given.map_or_else(|| format!("node {node}"), |name| format!("node `{}`", shown(name)))
}

fn local(asset: &Asset, node: usize) -> Result<Local, String> {
    let json = &asset.json["nodes"][node];
    let named = |problem: String| format!("{}: {problem}", name(asset, node));
    if let Some(matrix) = floats::<16>(json, "matrix").map_err(named)? {
        return Ok(Local::Matrix(Matrix4::from_column_slice(&matrix)));
    }
    Ok(Local::Parts {
        translation: floats(json, "translation").map_err(named)?.unwrap_or_default(),
        rotation: floats(json, "rotation").map_err(named)?.unwrap_or([0.0, 0.0, 0.0, 1.0]),
        scale: floats(json, "scale").map_err(named)?.unwrap_or([1.0; 3]),
    })
}

/// The `N` numbers of a property; `None` if it is missing or null.
fn floats<const N: usize>(json: &Value, key: &str) -> Result<Option<[f64; N]>, String> {
    let wrong = |found: &Value| format!("`{key}` is {}: expected {N} finite numbers", shown(&found.to_string()));
    match &json[key] {
        Value::Null => Ok(None),
        Value::Array(values) => {
            let numbers: Option<Vec<f64>> = values.iter().map(Value::as_f64).collect();
            let numbers = numbers.and_then(|numbers| numbers.try_into().ok());
            numbers.map(Some).ok_or_else(|| wrong(&json[key]))
        }
        other => Err(wrong(other)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_in_parts_is_the_same_matrix() {
        // Mirrored, unevenly scaled and turned; rounding of a few products.
        let parts =
            Local::Parts { translation: [1.0, 2.0, 3.0], rotation: [0.5, -0.5, 0.5, 0.5], scale: [-2.0, 3.0, 0.5] };
        let again = Local::Matrix(parts.matrix()).in_parts();
        assert!((again.matrix() - parts.matrix()).amax() < 1e-14);
        // A flat node has no rotation about what it lacks, and no NaN.
        let flat = Local::Matrix(Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 0.0, 2.0)));
        assert!((flat.in_parts().matrix() - flat.matrix()).amax() < 1e-14);
    }

    #[test]
    fn a_rotation_of_no_length_is_none() {
        let still = Local::Parts { translation: [0.0; 3], rotation: [0.0; 4], scale: [1.0; 3] };
        assert_eq!(still.matrix(), Matrix4::identity());
    }
}
