use super::{Mesh, MeshPoint, Pose};

/// A rest mesh with its poses, as a file or a generator gives them.
#[derive(Clone, Debug, Default)]
pub struct MeshSequence {
    /// The undeformed mesh.
    pub rest: Mesh,
    /// The poses, in order.
    pub poses: Vec<Pose>,
    /// Named points; two meshes' landmarks of one name are a marker.
    pub landmarks: Vec<Landmark>,
    /// The clips of the file, whether its poses are frames of them or not.
    pub animations: Vec<Animation>,
    /// Sentences about data of the file that the reader left out.
    pub warnings: Vec<String>,
}

/// A named point of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmark {
    /// The name, unique in the mesh.
    pub name: String,
    /// The point, as the file of the mesh counts.
    pub point: MeshPoint,
}

/// An animation in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// The name, or its number in the file.
    pub name: String,
    /// Length in seconds.
    pub seconds: f64,
    /// The moved part of the scene, e.g. `morph targets` or `skeleton`.
    pub channels: Vec<String>,
}
