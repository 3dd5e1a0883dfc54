//! Opening a pipeline, or two meshes.

use std::{
    path::{Path, PathBuf},
    sync::{
        Arc, RwLock,
        atomic::{AtomicU64, Ordering},
    },
    time::{SystemTime, UNIX_EPOCH},
};

use mimesh_document::{diagnostic, paths};
use mimesh_pipeline::{
    Options,
    cache::Cache,
    input::{HelpCommands, PosedMeshes, ViewScript},
    prepare_posed_meshes,
};
use serde::Deserialize;
use serde_json::json;

use super::{
    initial::initial_markers,
    recent::RecentPoses,
    state::{Project, meshes_of},
};
use crate::{markers::MarkerStore, meshes::Meshes, pipeline::PipelineStore};

/// What to open.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Opening {
    /// A pipeline.
    Pipeline {
        /// Its file.
        pipeline: PathBuf,
    },
    /// Two meshes.
    Pair {
        /// The mesh that gives its motion.
        source: PathBuf,
        /// The mesh that takes it.
        target: PathBuf,
    },
}

/// What all projects of a server have in common.
#[derive(Debug)]
pub struct Context {
    /// Folders that meshes may open files from, beside their own.
    pub roots: Vec<PathBuf>,
    /// Whether stages may run programs.
    pub allow_commands: bool,
    /// Results of earlier runs.
    pub cache: Option<Cache>,
    /// A folder for files that nobody else sees.
    pub scratch: PathBuf,
    /// The commands that the reports of a pipeline name.
    pub help: fn(&Path) -> HelpCommands,
}

impl Context {
    /// The options with which `pipeline` is checked and run.
    pub fn options(&self, pipeline: &Path) -> Options {
        let view_script = ViewScript { text: mimesh_web::report_viewer(), hint: mimesh_web::HOW_TO_BUILD.into() };
        let Self { roots, allow_commands, help, .. } = self;
        let (roots, allow_commands, help) = (roots.clone(), *allow_commands, help(pipeline));
        Options { roots, allow_commands, view_script, help, ..Options::default() }
    }
}

impl Project {
    /// Opens what `opening` names: absolute paths without links.
    ///
    /// # Errors
    ///
    /// What is wrong with the meshes, and a file of markers of ours that cannot be read.
    pub fn open(opening: &Opening, context: &Context) -> diagnostic::Result<Self> {
        let (file, text) = match opening {
            Opening::Pipeline { pipeline } => {
                // Opening a pipeline is reading its file.
                if let Err(error) = std::fs::metadata(pipeline) {
                    return Err(mimesh_document::files::unreadable(pipeline, "read", &error).into());
                }
                (pipeline.clone(), String::new())
            }
            Opening::Pair { source, target } => pair(source, target),
        };
        Self::read(Arc::new(PipelineStore::open(file, text)?), None, context)
    }

    /// The same pipeline, which names other meshes or poses now. Markers stay with their history where both meshes are as they were.
    ///
    /// # Errors
    ///
    /// As [`open`](Self::open).
    pub fn reopened(&self, context: &Context) -> diagnostic::Result<Self> {
        Self::read(self.pipeline.clone(), Some(self), context)
    }

    fn read(pipeline: Arc<PipelineStore>, before: Option<&Self>, context: &Context) -> diagnostic::Result<Self> {
        let (document, included) = pipeline.document().1?;
        let opened_by = meshes_of(&document.value);
        let read = prepare_posed_meshes(document, included, &context.options(pipeline.file()), context.cache.as_ref())?;
        let PosedMeshes { source, target, poses, poses_are, fps, units, formats, markers, landmarks, warnings: _ } =
            read;
        let fps = fps.or_else(|| fps_of(&poses));
        let clips = source.sequence.animations.iter().map(|clip| (clip.name.clone(), clip.seconds)).collect();
        let meshes = Arc::new(Meshes::new(Arc::new(source), Arc::new(target)));
        let own = paths::stem(pipeline.file());
        let own = pipeline.file().with_file_name(format!("{own}.markers.yaml"));
        let (file, initial) = initial_markers(markers.as_ref(), own, &meshes, &formats);
        let same = before.filter(|before| before.markers.file() == file && before.meshes.are_like(&meshes));
        let markers = match same {
            Some(before) => before.markers.clone(),
            None => Arc::new(MarkerStore::open(file, meshes.clone(), initial)?),
        };
        let number = number();
        Ok(Self {
            number,
            opened: before.map_or(number, |before| before.opened),
            name: paths::stem(pipeline.file()),
            meshes,
            poses,
            poses_are,
            clips,
            fps,
            formats,
            units,
            landmarks,
            markers,
            pipeline,
            masks_saved: AtomicU64::new(0),
            opened_by,
            recent: RecentPoses::default(),
            ready: RwLock::new(None),
        })
    }
}

/// The file and the text of the pipeline of two meshes, beside the target.
fn pair(source: &Path, target: &Path) -> (PathBuf, String) {
    let stem = format!("{}-from-{}", paths::stem(target), paths::stem(source));
    let folder = target.parent().unwrap_or(Path::new(""));
    let name = |path: &Path| json!(relative(folder, path).to_string_lossy());
    let extension = target.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let extension = if ["glb", "gltf", "vrm"].contains(&&*extension) { extension } else { "glb".into() };
    let output = json!([format!("{stem}.{extension}"), format!("{stem}.html")]);
    let text =
        format!("source: {{ rest: {} }}\ntarget: {{ rest: {} }}\noutput: {output}\n", name(source), name(target));
    (folder.join(format!("{stem}.yaml")), text)
}

/// `path` as seen from `folder`; both are absolute and without links.
fn relative(folder: &Path, path: &Path) -> PathBuf {
    let shared = folder.components().zip(path.components()).take_while(|(a, b)| a == b).count();
    if shared <= 1 {
        return path.into();
    }
    let up = folder.components().skip(shared).map(|_| "..");
    up.map(PathBuf::from).chain(path.components().skip(shared).map(|part| PathBuf::from(part.as_os_str()))).collect()
}

/// The frames a second by the times of the frames.
fn fps_of(poses: &[mimesh_pipeline::input::PoseInput]) -> Option<f64> {
    let times: Vec<f64> = poses.iter().filter_map(|pose| Some(pose.time.as_ref()?.seconds)).collect();
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 1e-6).collect();
    steps.sort_by(f64::total_cmp);
    Some((1.0 / steps.get(steps.len() / 2)?).clamp(1.0, 240.0))
}

/// A number that no project had before: the time in milliseconds, or one more than the last.
fn number() -> u64 {
    static LAST: AtomicU64 = AtomicU64::new(0);
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |time| time.as_millis() as u64);
    let last = LAST.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |last| Some(now.max(last + 1)));
    last.map_or(now, |last| now.max(last + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_meshes_are_a_pipeline_beside_the_target() {
        let (file, text) = pair(Path::new("/data/in/horse.glb"), Path::new("/data/out/camel.obj"));
        assert_eq!(file, Path::new("/data/out/camel-from-horse.yaml"));
        assert!(text.starts_with("source: { rest: \"../in/horse.glb\" }\ntarget: { rest: \"camel.obj\" }\n"), "{text}");
        assert_eq!(relative(Path::new("/a/b"), Path::new("/c/d.obj")), Path::new("/c/d.obj"));
    }

    #[test]
    fn numbers_rise() {
        let (a, b) = (number(), number());
        assert!(a < b);
    }
}
