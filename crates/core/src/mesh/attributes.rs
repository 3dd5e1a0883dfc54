use std::{ops::Range, sync::Arc};

/// Values attached to the corners of polygons, e.g. texture coordinates: a table and an index a corner.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerAttribute<T> {
    /// The distinct values, in the order of the file.
    pub values: Vec<T>,
    /// For each corner of [`Polygons::corners`](super::Polygons::corners), its value; `None` where the file gives none.
    pub indices: Vec<Option<u32>>,
}

/// A run of polygons that share object, group and material.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Object (OBJ `o`, glTF node or mesh).
    pub object: Option<String>,
    /// Groups (OBJ `g`, which may list several).
    pub groups: Vec<String>,
    /// Name of the material (OBJ `usemtl`).
    pub material: Option<String>,
    /// The polygons.
    pub polygons: Range<usize>,
}

/// The look of a part, as far as it survives between formats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// The name that parts use.
    pub name: String,
    /// Linear red, green, blue, opacity, each 0 to 1.
    pub base_color: [f64; 4],
    /// The image whose colours, by texture coordinates, stand in the place of the base colour's red, green and blue.
    pub base_color_image: Option<Arc<Image>>,
}

/// An image that a material shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// The name by which its file is called.
    pub name: String,
    /// The contents of its file, or why they cannot be had.
    pub contents: Result<Vec<u8>, String>,
}
