//! Materials as a glTF holds them, with their images.

use std::{io, sync::Arc};

use mimesh_core::mesh::{Image, Mesh};
use serde_json::{Value, json};

use super::{binary::Binary, plan::Plan};

/// The materials that primitives name.
pub struct Materials<'a> {
    names: Vec<&'a str>,
    /// One a name, in order of first use.
    pub json: Vec<Value>,
    images: Images,
}

impl<'a> Materials<'a> {
    /// Those of the primitives of `plan`, with the looks that `mesh` has for them.
    pub fn new(plan: &'a Plan, mesh: &Mesh) -> Self {
        let mut names: Vec<&str> = Vec::new();
        let primitives = plan.objects.iter().flat_map(|object| &object.primitives);
        for name in primitives.filter_map(|primitive| primitive.material.as_deref()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let mut images = Images::default();
        let json = names.iter().map(|name| material(mesh, name, &mut images)).collect();
        Self { names, json, images }
    }

    /// Adds the images to `binary`, and with their textures to `root`.
    ///
    /// # Errors
    ///
    /// Those of the file.
    pub fn add_images(&self, binary: &mut Binary, root: &mut Value) -> io::Result<()> {
        let (mut images, mut textures) = (Vec::new(), Vec::new());
        for image in &self.images.0 {
            let (Ok(media_type), Ok(contents)) = (media_type(image), &image.contents) else { continue };
            textures.push(json!({ "source": images.len() }));
            let view = binary.plain_view(contents)?;
            images.push(json!({ "name": image.name, "mimeType": media_type, "bufferView": view }));
        }
        if !images.is_empty() {
            root["images"] = images.into();
            root["textures"] = textures.into();
        }
        Ok(())
    }

    /// The number of a material that a primitive names.
    pub fn index(&self, name: &str) -> usize {
        self.names.iter().position(|other| *other == name).expect("every material in use has an entry")
    }
}

/// A matt material; without a known colour it is white.
fn material(mesh: &Mesh, name: &str, images: &mut Images) -> Value {
    let known = mesh.materials.iter().find(|material| material.name == name);
    let mut color = known.map_or([1.0; 4], |material| material.base_color.map(|x| x.clamp(0.0, 1.0)));
    let texture = known.and_then(|material| images.texture(material.base_color_image.as_ref()?));
    if texture.is_some() {
        // The image stands in the place of the colour, and glTF would multiply the two.
        color = [1.0, 1.0, 1.0, color[3]];
    }
    let mut json = json!({
        "name": name,
        "pbrMetallicRoughness": { "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 1.0 },
    });
    if let Some(texture) = texture {
        json["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    }
    if color[3] < 1.0 {
        json["alphaMode"] = "BLEND".into();
    }
    json
}

/// The images that materials show, each once; a texture has the number of its image.
#[derive(Default)]
struct Images(Vec<Arc<Image>>);

impl Images {
    /// The number of the texture that shows `image`, if a glTF can hold it.
    fn texture(&mut self, image: &Arc<Image>) -> Option<usize> {
        media_type(image).ok()?;
        let known = self.0.iter().position(|other| other == image);
        Some(known.unwrap_or_else(|| {
            self.0.push(image.clone());
            self.0.len() - 1
        }))
    }
}

/// The media type of an image, or why a glTF cannot hold it.
fn media_type(image: &Image) -> Result<&'static str, String> {
    let contents = image.contents.as_deref().map_err(|reason| format!("`{}` {reason}", image.name))?;
    match contents {
        [0x89, b'P', b'N', b'G', ..] => Ok("image/png"),
        [0xff, 0xd8, 0xff, ..] => Ok("image/jpeg"),
        _ => {
            Err(format!("`{}` is neither PNG nor JPEG: convert it, and name the new file in the material", image.name))
        }
    }
}

/// A sentence for each image of `mesh` that a glTF cannot hold.
pub fn warnings(mesh: &Mesh) -> Vec<String> {
    let images = mesh.materials.iter().filter_map(|material| material.base_color_image.as_deref());
    let mut problems: Vec<String> = images.filter_map(|image| media_type(image).err()).collect();
    problems.dedup();
    problems.into_iter().map(|problem| format!("texture left out: {problem}")).collect()
}
