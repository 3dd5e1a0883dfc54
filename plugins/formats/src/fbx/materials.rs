//! The materials of a scene, with the images of their base colours.

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use mimesh_core::{
    mesh::{Image, Material},
    stage::FileInput,
};
use ufbx::{Scene, Texture};

use crate::images::Beside;

/// The materials that are `used`; with their images if `with_images`. Maps of anything else are told in `left_out`.
pub fn materials(
    input: &dyn FileInput,
    scene: &Scene,
    names: &HashMap<u32, String>,
    used: &HashSet<u32>,
    with_images: bool,
    left_out: &mut Vec<String>,
) -> Vec<Material> {
    let used = scene.materials.iter().filter(|material| used.contains(&material.element.element_id));
    let mut maps = false;
    let mut beside = Beside::new(input);
    let mut read = |material: &ufbx::Material| {
        let (colour, factor, opacity) = (&material.pbr.base_color, &material.pbr.base_factor, &material.pbr.opacity);
        let factor = if factor.has_value { factor.value_vec4.x } else { 1.0 };
        let [r, g, b] = [colour.value_vec4.x, colour.value_vec4.y, colour.value_vec4.z].map(|channel| channel * factor);
        let base_color = if colour.has_value { [r, g, b] } else { [1.0; 3] };
        let opacity = if opacity.has_value { opacity.value_vec4.x } else { 1.0 };
        let in_range = |channel: f64| if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 1.0 };
        let [r, g, b] = base_color.map(in_range);
        let shown = colour.texture.as_deref().and_then(file_texture);
        maps |= material
            .textures
            .iter()
            .filter_map(|map| file_texture(&map.texture))
            .any(|texture| shown.is_none_or(|shown| shown.element.element_id != texture.element.element_id));
        Material {
            name: names[&material.element.element_id].clone(),
            base_color: [r, g, b, in_range(opacity)],
            base_color_image: shown.filter(|_| with_images).map(|texture| image(&mut beside, texture)),
        }
    };
    let materials = used.map(|material| read(material)).collect();
    if maps {
        left_out.push("maps of materials beside that of the colour".into());
    }
    materials
}

/// The texture with a file that `texture` is, or shows first.
fn file_texture(texture: &Texture) -> Option<&Texture> {
    if texture.has_file { Some(texture) } else { texture.file_textures.iter().next().map(|texture| &**texture) }
}

/// The image of a texture: that in the file, else that beside it.
fn image(beside: &mut Beside<'_>, texture: &Texture) -> Arc<Image> {
    let names = [&*texture.relative_filename, &*texture.absolute_filename, &*texture.filename];
    let name = names.into_iter().find(|name| !name.is_empty()).unwrap_or("texture");
    let embedded = texture.video.as_deref().map_or(&texture.content, |video| &video.content);
    if embedded.is_empty() {
        return beside.get("", name);
    }
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    Arc::new(Image { name: name.into(), contents: Ok(embedded.to_vec()) })
}
