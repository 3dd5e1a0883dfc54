//! What of a mesh has no place in a format, by name.

use mimesh_core::mesh::Mesh;

use crate::{attributes::by_vertex, extras::Extras, gltf::document::GltfDocument};

/// Data of a mesh beside positions and polygons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Polygons of more than three corners.
    Polygons,
    /// Texture coordinates.
    TextureCoordinates,
    /// Normals.
    Normals,
    /// Colours of vertices.
    VertexColors,
    /// Colours of faces.
    FaceColors,
    /// Names of objects.
    Objects,
    /// Names of groups.
    Groups,
    /// Names of materials.
    Materials,
    /// Colours of materials.
    MaterialColors,
    /// Images of materials.
    Textures,
}

use Content::*;

/// All of them, in the order in which they are told.
const ALL: [Content; 10] = [
    Polygons,
    TextureCoordinates,
    Normals,
    VertexColors,
    FaceColors,
    Objects,
    Groups,
    Materials,
    MaterialColors,
    Textures,
];

impl Content {
    /// Its name, if `mesh` has any.
    fn in_mesh(self, mesh: &Mesh) -> Option<&'static str> {
        let (name, is_there) = match self {
            Polygons => ("polygons of more than three corners", mesh.polygons.iter().any(|corners| corners.len() > 3)),
            TextureCoordinates => match &mesh.texture_coordinates {
                Some(textures) if by_vertex(mesh, textures).is_none() => ("texture coordinates with seams", true),
                textures => ("texture coordinates", textures.is_some()),
            },
            Normals => match &mesh.normals {
                Some(normals) if by_vertex(mesh, normals).is_none() => ("normals with hard edges", true),
                normals => ("normals", normals.is_some()),
            },
            VertexColors => ("colours of vertices", mesh.vertex_colors.is_some()),
            FaceColors => ("colours of faces", Extras::of(mesh).is_some_and(|extras| extras.face_colors.is_some())),
            Objects => ("names of objects", mesh.parts.iter().any(|part| part.object.is_some())),
            Groups => ("groups", mesh.parts.iter().any(|part| !part.groups.is_empty())),
            Materials => ("names of materials", mesh.parts.iter().any(|part| part.material.is_some())),
            MaterialColors => ("colours of materials", !mesh.materials.is_empty()),
            Textures => ("textures", mesh.materials.iter().any(|material| material.base_color_image.is_some())),
        };
        is_there.then_some(name)
    }
}

/// The sentence about what of `mesh` is not in files of `format` that keep `kept`; `None` if nothing is lost.
///
/// What the file of the mesh has beside it is lost too, since only a writer of its own format knows it.
pub fn sentence(format: &str, mesh: &Mesh, kept: &[Content]) -> Option<String> {
    let mut lost: Vec<String> = Vec::new();
    lost.extend(
        ALL.iter().filter(|content| !kept.contains(content)).filter_map(|c| c.in_mesh(mesh)).map(str::to_owned),
    );
    lost.extend(Extras::of(mesh).into_iter().flat_map(|extras| extras.left_out.iter().cloned()));
    lost.extend(mesh.document.get::<GltfDocument>().into_iter().flat_map(GltfDocument::beyond_mesh).map(str::to_owned));
    (!lost.is_empty()).then(|| format!("left out of {format}: {}", lost.join(", ")))
}
