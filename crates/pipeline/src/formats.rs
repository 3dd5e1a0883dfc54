//! Which format reads or writes a path.

use std::{
    io::Read,
    path::{Path, PathBuf},
};

use mimesh_core::{
    Error,
    mesh::{Mesh, MeshSequence},
    plugin,
    spatial::{MeshUnits, UpAxis},
    stage::{FileInput, Format, MeshWriter, ScenePoint, Selection},
};
use mimesh_document::{
    diagnostic::{self, Diagnostic, Kind, Location},
    files::check_regular,
};
use mimesh_markers::{IntoDiagnostic, ScenePoints};
use nalgebra::Point3;

use crate::file_on_disk::{FileOnDisk, Reach};

/// The registered formats, with the settings that a pipeline gives some of them, and the files that meshes may open.
#[derive(Debug)]
pub struct Formats {
    all: Vec<Box<dyn Format>>,
    reach: Reach,
}

/// How a path is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Writes {
    /// One file a pose.
    Pose,
    /// One file for rest and poses.
    Sequence,
}

impl Formats {
    /// Every registered format; those in `settings` replace the default of their type. Mesh files open what is in `reach`.
    pub fn new(settings: Vec<Box<dyn Format>>, reach: Reach) -> Self {
        let mut formats: Vec<_> = plugin::instances::<dyn Format>().into_iter().map(|(_, format)| format).collect();
        for format in settings {
            match formats.iter_mut().find(|other| other.typetag_name() == format.typetag_name()) {
                Some(other) => *other = format,
                None => formats.push(format),
            }
        }
        Self { all: formats, reach }
    }

    /// Tells the formats whose files say their unit and axes those of the written mesh; `of` gives them by the format's name.
    pub fn set_units(&mut self, of: impl Fn(&str) -> MeshUnits) {
        for format in &mut self.all {
            if let Some(told) = format.with_units(of(format.typetag_name())) {
                *format = told;
            }
        }
    }

    /// All of them, with their settings.
    pub fn all(&self) -> &[Box<dyn Format>] {
        &self.all
    }

    /// The format of `path`: that of its contents if they are certainly of another than its extension says, else that of its extension.
    ///
    /// # Errors
    ///
    /// [`Unknown`] with the extensions that are read, and the format of the contents if that is known.
    pub fn reader(&self, path: &Path) -> Result<&dyn Format, Unknown> {
        let named = self.find(path, "read", |format| format.reads()).map_err(|unknown| match elsewhere(path) {
            Some(way) => Unknown { hint: format!("{way}; {}", unknown.hint), ..unknown },
            None => unknown,
        });
        let Some((start, length)) = start_of(path) else { return named };
        if named.as_ref().is_ok_and(|named| named.recognises(&start, length) != Some(false)) {
            return named;
        }
        let mut formats = self.all.iter().map(Box::as_ref);
        let by_contents = formats.find(|format| format.recognises(&start, length) == Some(true));
        match (named, by_contents) {
            (Ok(_), Some(other)) => Ok(other),
            (Err(unknown), Some(other)) => {
                let extension = other.extensions()[0];
                let hint = format!("by its contents it is {}: rename it to .{extension}", named_as(other));
                Err(Unknown { hint, ..unknown })
            }
            (named, None) => named,
        }
    }

    /// The sentence about a file that is not of the format that its extension says.
    pub fn warning(&self, path: &Path) -> Option<String> {
        let named = self.find(path, "read", |format| format.reads()).ok()?;
        let read = self.reader(path).ok().filter(|read| read.typetag_name() != named.typetag_name())?;
        Some(format!("by its contents the file is {}, not {}: it is read as such", named_as(read), named_as(named)))
    }

    /// Reads the selected part of the file `path`.
    ///
    /// # Errors
    ///
    /// Those of the format, and [`Error::File`] for a path that no format fits.
    pub fn read(&self, path: &Path, selection: &Selection) -> Result<MeshSequence, Error> {
        let mut read = self.reader_for(path)?.read(&self.input(path), selection)?;
        read.warnings.extend(self.warning(path));
        Ok(read)
    }

    /// Reads the positions of a pose of `rest` (#V × 3) from the file `path`.
    ///
    /// # Errors
    ///
    /// As [`read`](Self::read), and if the file does not have the vertices and polygons of `rest`.
    pub fn read_pose(&self, path: &Path, selection: &Selection, rest: &Mesh) -> Result<Vec<Point3<f64>>, Error> {
        self.reader_for(path)?.read_pose(&self.input(path), selection, rest)
    }

    /// All files that are read with `path`: itself and those that it refers to; `path` alone if it has no format.
    ///
    /// Those that it may not open are not among them, since nothing may be done with them, not even hashing.
    pub fn files(&self, path: &Path) -> Vec<PathBuf> {
        let input = self.input(path);
        let references = self.reader(path).map(|format| format.references(&input)).unwrap_or_default();
        let referenced = references.iter().map(|reference| input.path_of(reference));
        std::iter::once(path.into()).chain(referenced.filter(|file| input.may_open(file))).collect()
    }

    /// How many vertices the file `path` has, as far as a look at it tells; `None` where only some of its parts are `selected`.
    pub fn vertex_count(&self, path: &Path, selected: &Selection) -> Option<usize> {
        let format = self.reader(path).ok().filter(|_| selected.meshes.is_empty())?;
        format.vertex_count(&self.input(path))
    }

    fn input(&self, path: &Path) -> FileOnDisk<'_> {
        FileOnDisk { path: path.into(), reach: &self.reach }
    }

    /// The axis that points up in the file `path`, if its format says it.
    pub fn up_of(&self, path: &Path) -> Option<UpAxis> {
        self.reader(path).ok()?.reads_in().up
    }

    fn reader_for(&self, path: &Path) -> Result<&dyn Format, Error> {
        self.reader(path).map_err(|unknown| Error::file(path, unknown.message, unknown.hint))
    }

    /// The format of the file `path`.
    ///
    /// # Errors
    ///
    /// A diagnostic if there is no such file, or no format for it.
    pub fn reader_of(&self, path: &Path) -> diagnostic::Result<&dyn Format> {
        // Of a file that is not there its ending does not matter.
        check_regular(path).map_err(|error| Error::read(path, error).into_diagnostic())?;
        let unreadable = |unknown: Unknown| Diagnostic::new(Kind::BadData, unknown.message).hint(unknown.hint);
        Ok(self.reader(path).map_err(|unknown| unreadable(unknown).at(Location::File(path.into())))?)
    }

    /// The format of `path`, which can write, and how.
    ///
    /// # Errors
    ///
    /// [`Unknown`] with the extensions that are written.
    pub fn writer(&self, path: &Path) -> Result<(&dyn Format, Writes), Unknown> {
        let format = self.find(path, "write", |format| format.writer().is_some())?;
        match format.writer() {
            Some(MeshWriter::Sequence(_)) => Ok((format, Writes::Sequence)),
            _ => Ok((format, Writes::Pose)),
        }
    }

    fn find(&self, path: &Path, does: &str, can: impl Fn(&dyn Format) -> bool) -> Result<&dyn Format, Unknown> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let able = || self.all.iter().map(Box::as_ref).filter(|format| can(*format));
        if let Some(format) = able().find(|f| extension.as_deref().is_some_and(|e| f.extensions().contains(&e))) {
            return Ok(format);
        }
        let known: Vec<_> = able().flat_map(|format| format.extensions().iter().map(|e| format!(".{e}"))).collect();
        let message = match extension {
            Some(extension) => format!("no format can {does} .{extension} files"),
            None => format!("the file name has no extension, so its format is not known to {does} it"),
        };
        Err(Unknown { message, hint: format!("formats that {does}: {}", known.join(", ")) })
    }
}

impl ScenePoints for Formats {
    fn scene_points(&self, file: &Path) -> Option<Result<Vec<ScenePoint>, Error>> {
        let format = self.reader(file).ok().filter(|format| format.holds_points())?;
        Some(format.read_points(&self.input(file)))
    }
}

/// The bytes by which a format is recognised.
const START: u64 = 4096;

/// The first bytes of the regular file `path`, and its length.
fn start_of(path: &Path) -> Option<(Vec<u8>, u64)> {
    let metadata = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    let mut start = Vec::new();
    std::fs::File::open(path).ok()?.take(START).read_to_end(&mut start).ok()?;
    Some((start, metadata.len()))
}

/// A format with its article, e.g. `a PLY`.
fn named_as(format: &dyn Format) -> String {
    let name = format.typetag_name().to_uppercase();
    // Said letter by letter, these begin with a vowel.
    let article = if name.starts_with(['A', 'E', 'F', 'I', 'L', 'M', 'N', 'O', 'R', 'S']) { "an" } else { "a" };
    format!("{article} {name}")
}

/// How files of other programs become files that are read; `None` where the extension is not known.
fn elsewhere(path: &Path) -> Option<&'static str> {
    const BLENDER: &str = "import it in Blender and export glTF 2.0 (.glb)";
    const FBX: &str = "open it in its program and export FBX";
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    Some(match extension.as_str() {
        "blend" => {
            "export glTF 2.0 in Blender: \
             `blender -b in.blend --python-expr \"import bpy; bpy.ops.export_scene.gltf(filepath='out.glb')\"`"
        }
        "abc" => "import it in Blender, export the mesh as .obj or .glb and its frames as .pc2 or .mdd",
        "usd" | "usda" | "usdc" | "usdz" => BLENDER,
        "bvh" => {
            "a .bvh has a skeleton without a mesh: pose the character with it in Blender and export glTF 2.0 (.glb)"
        }
        "max" => "export FBX in 3ds Max: File > Export, with skins and morphs",
        "ma" | "mb" => "export FBX in Maya: File > Export All, type FBX export, with skins and blend shapes",
        "c4d" => "export FBX in Cinema 4D: File > Export > FBX",
        "ztl" | "zpr" => "export OBJ or FBX in ZBrush",
        "hip" | "hipnc" | "bgeo" | "geo" => "export FBX or OBJ in Houdini",
        "lwo" | "lws" | "skp" | "3dm" | "xsi" | "mud" | "spp" | "iclone" => FBX,
        "dae" | "3ds" | "x" | "x3d" | "wrl" | "vrml" | "3mf" | "ase" | "ac" | "ms3d" | "md2" | "md5mesh" => {
            "convert it with Assimp: `assimp export IN out.glb`, or import it in Blender and export glTF 2.0 (.glb)"
        }
        "step" | "stp" | "iges" | "igs" | "brep" | "fcstd" => {
            "cut it into triangles in FreeCAD: Mesh > Create mesh from shape"
        }
        "pmx" | "pmd" | "vmd" => "import it in Blender by MMD Tools and export glTF 2.0 (.glb)",
        "vtk" | "vtp" | "vtu" | "inp" | "msh" | "mesh" => "convert it with meshio: `meshio convert IN out.ply`",
        "pcd" | "las" | "laz" | "e57" | "xyz" | "asc" => {
            "these are points without a surface: make a mesh of them in MeshLab or CloudCompare"
        }
        _ => return None,
    })
}

/// The error of a path that no format fits.
#[derive(Debug)]
pub struct Unknown {
    /// What is wrong.
    pub message: String,
    /// What would do.
    pub hint: String,
}
