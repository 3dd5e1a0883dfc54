use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use mimesh_core::{
    Error,
    mesh::{Material, Part},
    stage::FileInput,
};

use crate::{
    beside::FilesBeside,
    images::{self, Beside},
    names::shown,
};

/// The materials of a file, and the names of its libraries that exist.
#[derive(Debug, Default)]
pub struct Libraries {
    pub materials: Vec<Material>,
    /// For each `mtllib` line the paths that it names, as they hold from the folder of the file; none if it has no library there.
    pub names: Vec<Vec<String>>,
}

/// The materials that `parts` name, from the libraries named on the `mtllib` lines of `input`; with their images if `images`.
///
/// A library that is missing, damaged or out of reach is a warning: no stage needs a colour.
pub fn read(
    input: &dyn FileInput,
    lines: &[String],
    parts: &[Part],
    images: bool,
    warnings: &mut Vec<String>,
) -> Libraries {
    let mut wanted: HashSet<&str> = parts.iter().filter_map(|part| part.material.as_deref()).collect();
    let mut result = Libraries::default();
    let mut beside = Beside::new(input);
    // The libraries of each line are opened once, however often it stands in the file.
    let mut known: HashMap<&str, Vec<String>> = HashMap::new();
    let mut opened = 0;
    // Names on one line, or lines that differ in blanks, may name one library again and again.
    let mut files = FilesBeside::new(input);
    let mut parsed = HashSet::new();
    for line in lines {
        if let Some(names) = known.get(&**line) {
            result.names.push(names.clone());
            continue;
        }
        let mut names = Vec::new();
        for (library, bytes) in libraries(&mut files, line, MAX_LIBRARIES - opened) {
            opened += 1;
            // A library out of reach is there all the same.
            if matches!(bytes, Ok(_) | Err(Error::OutOfReach { .. })) {
                names.push(library.clone());
            }
            if let Ok(bytes) = &bytes
                && !parsed.insert(Arc::as_ptr(bytes))
            {
                continue;
            }
            match bytes.map_err(|error| images::reason(&error)).and_then(|bytes| parse(&bytes)) {
                Ok(loaded) => {
                    let loaded = loaded.into_iter().filter(|material| wanted.remove(material.name.as_str()));
                    let with_image = |loaded| material(&mut beside, &library, loaded, images);
                    result.materials.extend(loaded.map(with_image));
                }
                Err(problem) => warnings.push(format!(
                    "material library {} {problem}: materials keep their names but have no colour in other formats",
                    input.path_of(&shown(&library)).display()
                )),
            }
        }
        known.insert(line, names.clone());
        result.names.push(names);
        if opened == MAX_LIBRARIES {
            warnings.push(format!("no more than {MAX_LIBRARIES} material libraries are read"));
            result.names.resize(lines.len(), Vec::new());
            break;
        }
    }
    result
}

/// No more libraries are opened.
const MAX_LIBRARIES: usize = 256;

/// A library by its name, with its contents.
type Library = (String, Result<Arc<Vec<u8>>, Error>);

/// The libraries that a line names: one whose name may hold spaces, or several, of which the first `most`.
fn libraries(files: &mut FilesBeside<'_>, line: &str, most: usize) -> Vec<Library> {
    let mut open = |name: &str| -> Library {
        let slashes = name.replace('\\', "/");
        match files.read(name) {
            // Files written on Windows may name a folder with backslashes.
            Err(error) if slashes != name => match files.read(&slashes) {
                Ok(contents) => (slashes, Ok(contents)),
                Err(_) => (name.into(), Err(error)),
            },
            contents => (name.into(), contents),
        }
    };
    let whole = open(line);
    if whole.1.is_ok() {
        return vec![whole];
    }
    let several: Vec<_> = line.split_whitespace().take(most).map(open).collect();
    if several.iter().any(|(_, contents)| contents.is_ok()) { several } else { vec![whole] }
}

fn parse(bytes: &[u8]) -> Result<Vec<tobj::Material>, String> {
    let decoded = crate::encoding::from_utf16(bytes);
    // Names in other encodings must compare equal to those in the OBJ, which are read in the same lossy way.
    let text = String::from_utf8_lossy(decoded.as_deref().unwrap_or(bytes));
    // `tobj` panics at a colour of fewer than three numbers.
    if let Some((number, line)) = text.lines().enumerate().find(|(_, line)| lacks_numbers(line)) {
        return Err(format!("has no colour of three finite numbers in line {}: `{}`", number + 1, shown(line.trim())));
    }
    let (materials, _) =
        tobj::load_mtl_buf(&mut text.as_bytes()).map_err(|problem| format!("is not understood ({problem})"))?;
    if materials.is_empty() {
        return Err("has no material".into());
    }
    Ok(materials)
}

/// Whether a line is of a colour that is not three finite numbers.
fn lacks_numbers(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let is_color = words.next().is_some_and(|word| matches!(word, "Ka" | "Kd" | "Ks" | "Ke"));
    let numbers = words.take(3).filter(|word| word.parse::<f64>().is_ok_and(f64::is_finite));
    is_color && numbers.count() < 3
}

/// A material of `library`; its image stands in the place of its colour, as programs that write both leave that black or grey.
fn material(beside: &mut Beside<'_>, library: &str, material: tobj::Material, images: bool) -> Material {
    let [r, g, b] = material.diffuse.unwrap_or([1.0; 3]);
    let base_color = [r, g, b, material.dissolve.unwrap_or(1.0)];
    let bounded = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 1.0 };
    let map = material.diffuse_texture.as_deref().map(file_of).filter(|_| images);
    let folder = library.rfind('/').map_or("", |end| &library[..=end]);
    let image = map.map(|map| beside.get(folder, map));
    Material { name: material.name, base_color: base_color.map(bounded), base_color_image: image }
}

/// The file of a map, which stands behind options such as `-s 2 2 1` or `-clamp on`.
fn file_of(map: &str) -> &str {
    let mut rest = map.trim();
    while rest.starts_with('-') {
        let Some((_, behind)) = rest.split_once(char::is_whitespace) else { return rest };
        rest = behind.trim_start();
        let mut values = 0;
        while let Some((value, behind)) = rest.split_once(char::is_whitespace) {
            let is_value = value.parse::<f64>().is_ok() || (values == 0 && !value.contains('.'));
            if !is_value || values == 3 || value.starts_with('-') && value.parse::<f64>().is_err() {
                break;
            }
            values += 1;
            rest = behind.trim_start();
        }
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_the_file_of_a_map_are_skipped() {
        let cases = [
            ("face.png", "face.png"),
            ("my face.png", "my face.png"),
            ("-s 2 2 1 my face.png", "my face.png"),
            ("-clamp on -o 0.5 -0.5 face.png", "face.png"),
            ("-bm 0.2 -imfchan r 2.png", "2.png"),
            ("-mm 0 1 textures\\face.png", "textures\\face.png"),
        ];
        for (map, file) in cases {
            assert_eq!(file_of(map), file, "{map}");
        }
    }
}
