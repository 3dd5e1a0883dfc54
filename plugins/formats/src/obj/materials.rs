use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

use mimesh_core::mesh::{Material, Part};

/// The materials that `parts` name, from the libraries named on the `mtllib` lines of the file at `path`.
///
/// A library that is missing or damaged is a warning: no stage needs a colour.
pub fn read(path: &Path, lines: &[String], parts: &[Part], warnings: &mut Vec<String>) -> Vec<Material> {
    let mut wanted: HashSet<&str> = parts.iter().filter_map(|part| part.material.as_deref()).collect();
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials = Vec::new();
    for library in lines.iter().flat_map(|line| libraries(folder, line)) {
        match load(&library) {
            Ok(loaded) => materials.extend(loaded.into_iter().filter(|material| wanted.remove(material.name.as_str()))),
            Err(problem) => warnings.push(format!(
                "material library {} {problem}: materials keep their names but have no colour in other formats",
                library.display()
            )),
        }
    }
    materials
}

/// The files a line names: one name that may hold spaces, or several names.
fn libraries(folder: &Path, line: &str) -> Vec<PathBuf> {
    let place = |name: &str| {
        let direct = folder.join(name);
        // Files written on Windows may name a folder with backslashes.
        if direct.exists() { direct } else { folder.join(name.replace('\\', "/")) }
    };
    let whole = place(line);
    if whole.is_file() {
        return vec![whole];
    }
    let several: Vec<_> = line.split_whitespace().map(place).collect();
    if several.iter().any(|library| library.is_file()) { several } else { vec![whole] }
}

fn load(library: &Path) -> Result<Vec<Material>, String> {
    let bytes = std::fs::read(library).map_err(|problem| format!("cannot be read ({problem})"))?;
    // Names in other encodings must compare equal to those in the OBJ, which are read in the same lossy way.
    let text = String::from_utf8_lossy(&bytes);
    let (materials, _) =
        tobj::load_mtl_buf(&mut text.as_bytes()).map_err(|problem| format!("is not understood ({problem})"))?;
    Ok(materials.into_iter().map(material).collect())
}

fn material(material: tobj::Material) -> Material {
    let [r, g, b] = material.diffuse.unwrap_or([1.0; 3]);
    let base_color = [r, g, b, material.dissolve.unwrap_or(1.0)];
    let bounded = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 1.0 };
    Material { name: material.name, base_color: base_color.map(bounded) }
}
