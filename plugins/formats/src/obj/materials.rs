use std::collections::HashSet;

use mimesh_core::{
    Error,
    mesh::{Material, Part},
    stage::FileInput,
};

/// The materials that `parts` name, from the libraries named on the `mtllib` lines of `input`.
///
/// A library that is missing, damaged or out of reach is a warning: no stage needs a colour.
pub fn read(input: &dyn FileInput, lines: &[String], parts: &[Part], warnings: &mut Vec<String>) -> Vec<Material> {
    let mut wanted: HashSet<&str> = parts.iter().filter_map(|part| part.material.as_deref()).collect();
    let mut materials = Vec::new();
    for (library, bytes) in lines.iter().flat_map(|line| libraries(input, line)) {
        match bytes.map_err(|error| reason(&error)).and_then(|bytes| parse(&bytes)) {
            Ok(loaded) => materials.extend(loaded.into_iter().filter(|material| wanted.remove(material.name.as_str()))),
            Err(problem) => warnings.push(format!(
                "material library {} {problem}: materials keep their names but have no colour in other formats",
                input.path_of(&library).display()
            )),
        }
    }
    materials
}

/// A library by its name, with its contents.
type Library = (String, Result<Vec<u8>, Error>);

/// The libraries that a line names: one whose name may hold spaces, or several.
fn libraries(input: &dyn FileInput, line: &str) -> Vec<Library> {
    let open = |name: &str| -> Library {
        let contents = match input.referenced(name) {
            // Files written on Windows may name a folder with backslashes.
            Err(error) if name.contains('\\') => input.referenced(&name.replace('\\', "/")).map_err(|_| error),
            contents => contents,
        };
        (name.into(), contents)
    };
    let whole = open(line);
    if whole.1.is_ok() {
        return vec![whole];
    }
    let several: Vec<_> = line.split_whitespace().map(open).collect();
    if several.iter().any(|(_, contents)| contents.is_ok()) { several } else { vec![whole] }
}

/// Why a library could not be opened.
fn reason(error: &Error) -> String {
    match error {
        Error::Io { source, .. } => format!("cannot be read ({source})"),
        Error::OutOfReach { reason, .. } => format!("is not opened, {reason}"),
        other => format!("cannot be read ({other})"),
    }
}

fn parse(bytes: &[u8]) -> Result<Vec<Material>, String> {
    // Names in other encodings must compare equal to those in the OBJ, which are read in the same lossy way.
    let text = String::from_utf8_lossy(bytes);
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
