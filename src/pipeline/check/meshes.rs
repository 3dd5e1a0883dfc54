use std::path::{Path, PathBuf};

use super::{Check, Input};
use crate::{
    core::{
        Error,
        mesh::{MeshSequence, Surface},
        stage::Generator,
    },
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location},
    pipeline::{At, OneOrMany, Source, Step, Target, document::path, resolve},
};

/// One of the two meshes at rest.
#[derive(Debug)]
pub struct Side {
    /// Its file, if it is not a generator.
    pub path: Option<PathBuf>,
    /// The mesh with the poses and landmarks that come with it.
    pub sequence: MeshSequence,
    /// Its surface.
    pub surface: Surface,
}

/// A pose of the source.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseInput {
    /// The name, which `{pose}` stands for.
    pub name: String,
    /// Where its positions are.
    pub from: PoseFrom,
}

/// Where the positions of a pose are.
#[derive(Clone, Debug, PartialEq)]
pub enum PoseFrom {
    /// A file of its own.
    File(PathBuf),
    /// That pose of the source's sequence.
    Held(usize),
}

impl Check<'_> {
    /// The source and its poses, as far as they can be had.
    pub(super) fn source(&mut self, source: &Source) -> (Option<Side>, Vec<PoseInput>) {
        if source.generator.is_some() && source.poses.is_some() {
            let hint = "a generator brings its own poses; remove `poses`";
            self.wrong(&path(["source", "poses"]), At::Key, "`poses` beside `generator`", hint);
        }
        let side = self.side("source", source.rest.as_deref(), source.generator.as_deref());
        let poses = match (&source.poses, &side) {
            (Some(patterns), _) => self.pose_files(patterns, source.rest.as_deref()),
            (None, Some(side)) => {
                let named = |(i, pose): (usize, &crate::core::mesh::Pose)| PoseInput {
                    name: pose.name.clone(),
                    from: PoseFrom::Held(i),
                };
                let poses: Vec<_> = side.sequence.poses.iter().enumerate().map(named).collect();
                // A wrong `poses` has been told already.
                let said = self.document.value.get("source").and_then(|source| source.get("poses"));
                if poses.is_empty() && said.is_none_or(serde_json::Value::is_null) {
                    let what =
                        if side.path.is_some() { "the rest file holds none" } else { "the generator makes none" };
                    let hint = "say where they are, e.g. `poses: horse-??.obj`";
                    self.missing(&path(["source"]), format!("the source has no poses: {what}"), hint);
                }
                poses
            }
            (None, None) => vec![],
        };
        (side, self.named(poses))
    }

    pub(super) fn target(&mut self, target: &Target) -> Option<Side> {
        self.side("target", target.rest.as_deref(), target.generator.as_deref())
    }

    /// Warns if one of the two has its faces turned the other way round: correspondences look at where faces point.
    pub(super) fn inside_out(&mut self, source: Option<&Side>, target: Option<&Side>) {
        let (Some(source), Some(target)) = (source, target) else { return };
        if let (Some(of_source), Some(of_target)) = (source.volume(), target.volume())
            && of_source * of_target < 0.0
        {
            let (name, side) = if of_source < 0.0 { ("source", source) } else { ("target", target) };
            let file = side.path.as_ref().map(|path| format!(" ({})", path.display())).unwrap_or_default();
            self.warnings.push(format!(
                "the {name}{file} is inside out: its faces point inwards, those of the other mesh outwards; \
                 reverse its faces if few partners are found"
            ));
        }
    }

    pub(super) fn side(
        &mut self,
        name: &'static str,
        rest: Option<&Path>,
        generator: Option<&dyn Generator>,
    ) -> Option<Side> {
        let slot = path([name]);
        match (rest, generator) {
            (Some(_), Some(_)) => {
                let hint = "a mesh is either read or made; remove one of the two";
                self.wrong(&path([name, "generator"]), At::Key, "`generator` beside `rest`", hint);
                None
            }
            (None, None) => {
                let said = self.document.value.get(name).and_then(|slot| slot.as_object());
                // A wrong `rest` has been told already, and so has a missing slot.
                if said.is_some_and(|said| !said.contains_key("rest") && !said.contains_key("generator")) {
                    let hint = format!("say which mesh, e.g. `{name}: {{ rest: mesh.obj }}`");
                    self.wrong(&slot, At::Value, format!("the {name} has neither `rest` nor `generator`"), hint);
                }
                None
            }
            (None, Some(generator)) => match generator.make().and_then(|made| Side::new(None, made)) {
                Ok(side) => Some(side),
                Err(error) if self.has_told(&error) => None,
                Err(error) => {
                    let at = path([name, "generator"]);
                    let diagnostic = Diagnostic::from(error).doing(format!("generator ({})", generator.typetag_name()));
                    self.diagnostics
                        .push(Diagnostic { location: Some(self.document.location(&at, At::Value)), ..diagnostic });
                    None
                }
            },
            (Some(rest), None) => self.read_side(name, &self.path(&path([name, "rest"]), rest)),
        }
    }

    fn read_side(&mut self, name: &'static str, file: &Path) -> Option<Side> {
        let at = path([name, "rest"]);
        let role = if name == "source" { "source rest" } else { "target rest" };
        let before = self.diagnostics.len();
        self.empty_texts(&at);
        if self.diagnostics.len() > before || !self.input(role, file, &at) {
            return None;
        }
        let format = match self.formats.reader(file) {
            Ok(format) => format,
            Err(unknown) => {
                self.wrong(&at, At::Value, unknown.message, unknown.hint);
                return None;
            }
        };
        match format.read(file).and_then(|sequence| Side::new(Some(file.into()), sequence)) {
            Ok(side) => {
                let warnings = side.sequence.warnings.iter();
                self.warnings.extend(warnings.map(|warning| format!("{}: {warning}", file.display())));
                Some(side)
            }
            Err(error) => {
                self.diagnostics.push(in_file(file, error));
                None
            }
        }
    }

    fn pose_files(&mut self, patterns: &OneOrMany, rest: Option<&Path>) -> Vec<PoseInput> {
        let rest = rest.map(|rest| resolve::identity(&self.path(&path(["source", "rest"]), rest)));
        let mut poses: Vec<PoseInput> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        if patterns.items.is_empty() {
            let at = path(["source", "poses"]);
            self.wrong(&at, At::Value, "the list of poses is empty", "name at least one file");
        }
        self.empty_texts(&path(["source", "poses"]));
        // An item that is no text has been told, and an empty one stands in its place.
        for (i, pattern) in patterns.items.iter().enumerate().filter(|(_, pattern)| !pattern.is_empty()) {
            let mut at = path(["source", "poses"]);
            if patterns.listed {
                at.push(Step::Index(i));
            }
            let found = match resolve::expand(self.document.folder(&at), pattern) {
                Ok(found) => found,
                Err(problem) => {
                    self.wrong(&at, At::Value, format!("`{pattern}` is no glob: {problem}"), "e.g. `horse-??.obj`");
                    continue;
                }
            };
            let is_rest = |file: &Path| rest.as_ref().is_some_and(|rest| *rest == resolve::identity(file));
            let glob = resolve::is_glob(pattern);
            let matched = found.len();
            if glob && matched > 0 && found.iter().all(|found| is_rest(&found.path)) {
                let hint = nearby(&self.path(&at, Path::new(pattern)));
                self.missing(&at, format!("`{pattern}` matches the rest mesh only, which is no pose"), hint);
                continue;
            }
            for found in found {
                if glob && is_rest(&found.path) {
                    self.warnings.push(format!("`{pattern}` also matches the rest mesh, which is not taken as a pose"));
                } else if self.pose_file(&found.path, &at) && seen.insert(resolve::identity(&found.path)) {
                    poses.push(PoseInput { name: found.name, from: PoseFrom::File(found.path) });
                }
            }
            if matched == 0 {
                let hint = nearby(&self.path(&at, Path::new(pattern)));
                self.missing(&at, format!("no file matches `{pattern}`"), hint);
            }
        }
        poses
    }

    fn pose_file(&mut self, file: &Path, at: &[Step]) -> bool {
        if !self.input("pose", file, at) {
            return false;
        }
        let unknown = self.formats.reader(file).err();
        if let Some(unknown) = &unknown {
            self.wrong(at, At::Value, unknown.message.clone(), unknown.hint.clone());
        }
        unknown.is_none()
    }

    /// The poses under names of their own: where wildcards stand for the same, poses are called like their files.
    fn named(&mut self, mut poses: Vec<PoseInput>) -> Vec<PoseInput> {
        let unique = |poses: &[PoseInput]| {
            let mut names: Vec<_> = poses.iter().map(|pose| &pose.name).collect();
            names.sort();
            names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0].clone())
        };
        if unique(&poses).is_some() {
            for pose in &mut poses {
                if let PoseFrom::File(file) = &pose.from {
                    pose.name = resolve::stem(file);
                }
            }
        }
        if let Some(name) = unique(&poses) {
            let files: Vec<_> = poses
                .iter()
                .filter(|pose| pose.name == name)
                .filter_map(
                    |pose| if let PoseFrom::File(file) = &pose.from { Some(file.display().to_string()) } else { None },
                )
                .collect();
            let message = format!("two poses are called `{name}`: {}", files.join(", "));
            let hint =
                "rename one, or use a wildcard where the paths differ: a pose is called what wildcards stand for";
            self.wrong(&path(["source", "poses"]), At::Value, message.trim_end_matches(": "), hint);
            // Told once; that their results collide follows.
            let mut seen = std::collections::HashSet::new();
            poses.retain(|pose| seen.insert(pose.name.clone()));
        }
        poses
    }
}

impl Side {
    /// The mesh with its surface.
    ///
    /// # Errors
    ///
    /// As [`Surface::new`], and if no triangle has an area.
    pub fn new(path: Option<PathBuf>, sequence: MeshSequence) -> Result<Self, Error> {
        let surface = Surface::new(&sequence.rest)?;
        let area: f64 = surface.area_normals(&surface.positions).iter().map(|normal| normal.norm()).sum();
        let diagonal = surface.diagonal();
        // Below this, areas are rounding errors of the positions.
        if area <= 1e-12 * diagonal * diagonal {
            let what = if diagonal == 0.0 { "all vertices lie on one point" } else { "all vertices lie on a line" };
            return Err(Error::data(format!("the mesh has no area: {what}"), "export the mesh again with its shape"));
        }
        Ok(Self { path, surface, sequence })
    }

    /// The volume inside, negative if faces point inwards; none if the surface is open.
    fn volume(&self) -> Option<f64> {
        let surface = &self.surface;
        let corner = |t: &[u32; 3]| surface.positions[t[0] as usize] - surface.positions[0];
        let normals = surface.area_normals(&surface.positions);
        let volume = || surface.triangles.iter().zip(&normals).map(|(t, normal)| corner(t).dot(normal) / 6.0).sum();
        surface.topology().boundary.is_empty().then(volume)
    }
}

impl Input {
    /// Whether it is the file of a pose.
    pub fn is_pose(&self) -> bool {
        self.role == "pose"
    }
}

/// An error about the contents of `file`; those that do not name it are placed there, and one about a file that it
/// needs says so.
pub fn in_file(file: &Path, error: Error) -> Diagnostic {
    let mut diagnostic = Diagnostic::from(error);
    if let Some(Location::File(other)) = &diagnostic.location
        && other != file
    {
        diagnostic.message += &format!(", and {} needs it", file.display());
    }
    let location = diagnostic.location.clone().unwrap_or_else(|| Location::File(file.into()));
    let status = if diagnostic.kind == Kind::BadPipeline { Kind::BadData } else { diagnostic.kind };
    Diagnostic { kind: status, ..diagnostic.at(location) }
}

/// What there is in the folder where a glob matched nothing.
pub fn nearby(pattern: &Path) -> String {
    let folder = pattern.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if resolve::is_glob(&folder.to_string_lossy()) {
        return "globs are relative to the folder of the pipeline's file".into();
    }
    let Ok(entries) = std::fs::read_dir(folder) else {
        return format!("there is no folder {}", folder.display());
    };
    let extension = pattern.extension();
    let mut names: Vec<_> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|p| p.extension() == extension).collect();
    names.sort_by(|a, b| alphanumeric_sort::compare_path(a, b));
    let kind = extension.map(|e| format!(".{} ", e.to_string_lossy())).unwrap_or_default();
    match &names[..] {
        [] => format!("there are no {kind}files in {}", folder.display()),
        [one] => format!("the only {kind}file there is {}", one.display()),
        [first, .., last] => format!("the {} {kind}files there go from {} to {}", names.len(), name(first), name(last)),
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
