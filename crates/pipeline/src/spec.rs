//! What a pipeline declares, as the types that it is read into.

use std::{collections::BTreeMap, path::PathBuf};

pub use mimesh_core::spatial::UpAxis as Up;
use mimesh_core::{
    mesh::PosesAre,
    spatial::LengthUnit,
    stage::{Correspondence, Format, Generator, KeyPoints, Metric, Proximity, Transfer},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    axis::Axis,
    choices::stage_or_auto,
    marker_source::MarkerSource,
    one_or_many::OneOrMany,
    pose_files::Poses,
    rest::{self, Rest},
    seam_points::SeamPoint,
    shapes::ShapeSettings,
};

/// A pipeline: a source with its poses, a target, and how the target takes the poses.
///
/// Paths are relative to the pipeline's file. Keys that are left out have their defaults.
#[derive(Debug, Default, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pipeline {
    /// The mesh that gives its motion, at rest and in its poses.
    pub source: Source,
    /// The mesh that takes the motion.
    pub target: Target,
    /// For poses that are shapes of a face or body: which are taken, what they are called and what they may move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shapes: Option<ShapeSettings>,
    /// The choice of points on the source that describe its poses best, to be completed as markers; a run does not use it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key_points: Option<Box<dyn KeyPoints>>,
    /// Corresponding points: a file with both sides, `.cons` (a count, then `source, target` vertices from 0) or mimesh's
    /// own `.yaml`; or a file of points for each mesh, `{ source: horse.pp, target: camel.pp }`.
    ///
    /// Files of points are MeshLab's `.pp`, Wrap's `.json` and `.txt`, and named points as `.csv` or `.json`; they are
    /// paired by name, else by order. Points given by position go to the closest place of the surface.
    ///
    /// `{ type: extremities }`, whose settings may follow, finds them by the shapes of the meshes: for shapes with limbs.
    ///
    /// Left out or `auto`, landmarks of equal names are the markers, where both meshes have landmarks (those of generators do). Where
    /// these are too few for what needs markers, they are found by shape. `~` stands for no markers.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["horse_camel.cons", { "source": "horse.pp", "target": "camel.pp" }, "auto"]))]
    pub markers: Option<MarkerSource>,
    /// How the components of the target lie to each other; needed by `transfer: { type: multi_component }`, and for
    /// components without markers to follow those that have them.
    ///
    /// Left out or `auto`, a stage is chosen where others need it. `~` stands for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "stage_or_auto::<dyn Proximity>")]
    pub proximity: Option<Box<dyn Proximity>>,
    /// How triangles of source and target are paired; `transfer: { type: biharmonic }` does without.
    ///
    /// Left out or `auto`, it is chosen where the transfer or a metric that the pipeline names needs it: `identity` for meshes of one
    /// topology, `nearest` for those that lie on each other, else `nonrigid_fit`. `~` stands for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(schema_with = "stage_or_auto::<dyn Correspondence>")]
    pub correspondence: Option<Box<dyn Correspondence>>,
    /// Writes the triangle pairs to this JSON file, for `correspondence: { type: from_file, path: … }`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_correspondence: Option<PathBuf>,
    /// How the motion is carried over.
    ///
    /// Left out or `auto`, `gradient` for a target of one component, and `multi_component` for one of several.
    #[serde(default)]
    #[schemars(schema_with = "stage_or_auto::<dyn Transfer>")]
    pub transfer: Option<Box<dyn Transfer>>,
    /// The known results to score against: a file a pose with `{pose}` in its name, or one file that holds all poses.
    ///
    /// A target made by a generator brings its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["truth/camel-{pose}.obj"]))]
    pub truth: Option<PathBuf>,
    /// Metrics to measure of every pose beside the default ones, or with other settings; `[]` measures nothing.
    ///
    /// docs/metrics.md lists the default ones, and those that need the truth.
    pub metrics: Option<Vec<Box<dyn Metric>>>,
    /// The largest size of a statistic, whatever its sign, that any pose may have: `METRIC_STATISTIC`, or `METRIC` for the primary one.
    /// A run that breaks a gate ends with status 3; its results are written.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("examples" = [{ "point_error_p95": 2.0, "flipped_triangles": 0 }]))]
    pub gates: BTreeMap<String, f64>,
    /// How the pictures of `report.html` and `.png` outputs are taken.
    #[serde(default)]
    pub pictures: PictureSettings,
    /// Settings of file formats that differ from their defaults, e.g. `[{ type: glb, frames_per_second: 30 }]`.
    #[serde(default)]
    pub formats: Vec<Box<dyn Format>>,
    /// Files to write: for one file a pose a path with `{pose}`, for all poses in one file a path without.
    ///
    /// A `.html` is a report to look at, with verdicts, pictures and curves; a `.png` a sheet of pictures of all poses.
    #[schemars(extend("examples" = [["out/camel-{pose}.obj", "out/camel.glb", "out/report.html"]]))]
    pub output: OneOrMany,
    /// The unit of results in files of bare numbers, such as OBJ; left out, that of the target.
    ///
    /// It needs the unit of the target. Files that say their unit, as glTF and USD, are right without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_unit: Option<LengthUnit>,
    /// The axis that points up in results in files of bare numbers, such as OBJ; left out, that of the target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_up: Option<Up>,
}

/// The mesh that gives its motion: files, or a generator.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("x-renamed" = { "sample": "generator" }))]
pub struct Source {
    /// The mesh at rest: a file, or a mapping such as `{ file: horse.glb, meshes: [Body], pose: stand }`.
    ///
    /// `meshes` are the parts that give their motion. Both rests should show the same shape, e.g. both animals standing. Where the file
    /// rests otherwise, one of the poses may serve (`pose: NAME`), or a clip (`clip: Run, time: 0.4`).
    #[serde(
        skip_serializing_if = "Option::is_none",
        deserialize_with = "rest::path_or_mapping",
        serialize_with = "rest::as_short_as_possible"
    )]
    #[schemars(schema_with = "rest::schema", extend("examples" = ["horse.obj", { "file": "horse.glb", "pose": "stand" }]))]
    pub rest: Option<Rest>,
    /// Its poses: a glob such as `horse-??.obj`, or a sequence of paths and globs; in natural order, without the rest mesh.
    ///
    /// A pose is called what the wildcards stand for, else like its file. A file that holds poses gives all of them, its morph targets
    /// or else its clip. `{ clip: Run, fps: 24 }` are frames of a clip, of the rest's file or another. Files that have the vertices of
    /// the rest but other polygons are `{ files: 'horse-??.obj', same_vertices: true }`. Left out, the poses are the morph targets of
    /// the rest's file, or else its first clip that lasts.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["horse-??.obj", { "clip": "Run", "fps": 24 }]))]
    pub poses: Option<Poses>,
    /// The unit of the rest; left out, what its format says: metres for glTF and FBX. Only `poses_unit` asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<LengthUnit>,
    /// The axis that points up in the rest; left out, what its format says: Y for glTF and FBX. Only `poses_up` asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// The unit of files of poses that are in another one than the rest; they are taken into that of the rest first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses_unit: Option<LengthUnit>,
    /// The axis that points up in files of poses, where it is another one than in the rest; they are turned first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses_up: Option<Up>,
    /// Whether the poses are `shapes` that stand alone, or `frames` of one motion.
    ///
    /// Shapes are not played as an animation nor judged as a motion, and vertices that rest in a shape of the source rest in that of
    /// the target to the last bit. Left out, frames of clips and names that end in numbers are frames, as `01, 02`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poses_are: Option<PosesAre>,
    /// Boundaries are welded where their vertices are nearer to each other than this, relative to the diagonal; left out, where they
    /// coincide exactly. For meshes whose triangles are apart by noise in the last digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.01))]
    pub weld_tolerance: Option<f64>,
    /// Vertices of the file, from 0, along boundaries that coincide at rest and open, such as closed lips: `12` parts from all that
    /// lie at its place, and `[12, 40]` part from each other.
    ///
    /// Left out, what any pose parts by more than 1e-4 of the diagonal opens; `[]` opens nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opened_seams: Option<Vec<SeamPoint>>,
    /// Made instead of read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<Box<dyn Generator>>,
}

/// The mesh that takes the motion: a file, or a generator.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(extend("x-renamed" = { "sample": "generator" }))]
pub struct Target {
    /// The mesh at rest: a file, or a mapping such as `{ file: avatar.glb, meshes: [Face] }`.
    ///
    /// `meshes` are the parts that take the motion; results keep the others as they are. `pose: NAME` or `clip: Run, time: 0.4` takes
    /// another shape that the file holds for its rest.
    #[serde(
        skip_serializing_if = "Option::is_none",
        deserialize_with = "rest::path_or_mapping",
        serialize_with = "rest::as_short_as_possible"
    )]
    #[schemars(schema_with = "rest::schema", extend("examples" = ["camel.obj", { "file": "avatar.glb", "meshes": ["Face"] }]))]
    pub rest: Option<Rest>,
    /// Boundaries are welded where their vertices are nearer to each other than this, relative to the diagonal; left out, where they
    /// coincide exactly. For meshes whose triangles are apart by noise in the last digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.01))]
    pub weld_tolerance: Option<f64>,
    /// Vertices of the file, from 0, along boundaries that coincide at rest and open, such as closed lips: `12` parts from all that
    /// lie at its place, and `[12, 40]` part from each other.
    ///
    /// Left out, a target with the polygons of the source opens where the source does, and another opens nowhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opened_seams: Option<Vec<SeamPoint>>,
    /// The unit of its numbers; left out, what its format says: metres for glTF and FBX.
    ///
    /// Results that say their unit, as glTF and USD, then say the right one. `output_unit` converts others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<LengthUnit>,
    /// The axis that points up in it; left out, what its format says: Y for glTF and FBX.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// Made instead of read; its poses are the truth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generator: Option<Box<dyn Generator>>,
    /// The target is a mirror image: what lies on one side of the source lies on the other side of the target along this axis.
    ///
    /// Stages then see its mirror image, and results are mirrored back.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirrored: Option<Axis>,
}

/// From where the meshes are looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PictureSettings {
    /// The side that is seen.
    pub view: ViewFrom,
    /// The axis that points up; left out, that of the source: what `source.up` or its format says, else Y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// The axis that points up in the target; left out, the target is turned as the markers or the correspondence say, so that
    /// both are seen from the same side.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target_up: Option<Up>,
    /// Whether the worst poses can be turned and looked at closely in `report.html`, which then has a script and is larger.
    pub view_3d: bool,
}

/// A side to look from; the front is that towards which z points, or with z up, that away from y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ViewFrom {
    /// From the front, turned and raised a little.
    #[default]
    ThreeQuarter,
    /// From the front.
    Front,
    /// From the side.
    Side,
    /// From above.
    Top,
}
