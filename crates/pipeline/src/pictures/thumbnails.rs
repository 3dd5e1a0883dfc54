//! The pictures of the poses of a run, collected while they are measured.

use std::{
    cmp::Ordering,
    collections::BTreeMap,
    sync::{Mutex, MutexGuard, PoisonError},
};

use mimesh_core::{
    mesh::SurfacePoint,
    stage::{Measured, TriangleMap},
};
use mimesh_render::{
    Canvas, Cell, Paint, Picture, Size,
    colour::{INK, SAND, STEEL, WHITE},
    sheet,
};
use nalgebra::Point3;

use super::{
    Camera,
    drawing::{Field, LEGEND_HEIGHT, draw_field, draw_markers, image},
    scene::{SceneFrame, scene_pose, too_large_to_turn},
};
use crate::{
    input::{Prepared, evenly_spaced},
    metrics::{Level, PoseMeasurements, Verdict},
    page::{Image, PanelImages, Pictures, Scene, ScenePose, View3d},
    report::MeshView,
};

/// The most poses with a thumbnail; of more poses some have one, spread over all.
const MAX_THUMBNAILS: usize = 100;
/// The most poses with a large picture, which are the worst.
const MAX_LARGE: usize = 6;
/// Pixels across and down of one mesh in a thumbnail, in a large picture, and at rest.
const THUMBNAIL_SIZE: u32 = 240;
const LARGE_SIZE: u32 = 400;
const REST_SIZE: u32 = 480;

/// Pictures of poses, drawn while poses stream by: small ones of all, and large ones of the worst.
pub struct Thumbnails<'a> {
    prepared: &'a Prepared,
    /// The cameras for source and target.
    cameras: [Camera; 2],
    /// Whether each pose gets a thumbnail.
    chosen: Vec<bool>,
    /// How source and target lie in the 3D view, if the page has one.
    scene: Option<[SceneFrame; 2]>,
    drawn: Mutex<Drawn>,
}

/// A pose, with all that its picture shows.
#[derive(Clone, Copy, Debug)]
pub struct PoseView<'a> {
    /// The name of the pose.
    pub name: &'a str,
    /// The posed vertices of the source's surface.
    pub source: Option<&'a [Point3<f64>]>,
    /// The posed vertices of the target's surface.
    pub result: &'a [Point3<f64>],
    /// The measurements of all metrics.
    pub measurements: &'a PoseMeasurements,
    /// The verdict, if there is one.
    pub verdict: Option<&'a Verdict>,
    /// The largest share that a statistic has of its limit for a bad result.
    pub limit_ratio: f64,
}

/// The pictures so far.
#[derive(Default)]
struct Drawn {
    /// Name and thumbnail by number of the pose.
    small: BTreeMap<usize, (String, Picture)>,
    /// The worst poses, worst first.
    large: Vec<Large>,
}

/// A large picture.
struct Large {
    severity: Severity,
    /// The number of the pose.
    pose: usize,
    name: String,
    picture: Picture,
    scene: Option<ScenePose>,
}

/// How bad a pose is: the larger, the worse.
#[derive(Clone, Copy)]
struct Severity {
    level: Level,
    /// The mean error, or the limit ratio if the true result is unknown.
    size: f64,
}

impl<'a> Thumbnails<'a> {
    /// Prepares for the poses of `prepared`, whose target is turned as its markers or `map` say.
    pub fn new(prepared: &'a Prepared, map: Option<&TriangleMap>) -> Self {
        let mut chosen = vec![false; prepared.poses.len()];
        evenly_spaced(prepared.poses.len(), MAX_THUMBNAILS).into_iter().for_each(|i| chosen[i] = true);
        let cameras = Camera::of_pair(prepared, map);
        let surfaces = [&prepared.source.surface, &prepared.target.surface];
        let is_turned = prepared.view_script.is_some() && why_not_turned(prepared).is_none();
        let scene = is_turned.then(|| [0, 1].map(|k: usize| SceneFrame::new(surfaces[k], cameras[k])));
        Self { prepared, cameras, chosen, scene, drawn: Mutex::default() }
    }

    /// How the target is seen.
    pub fn target_view(&self) -> MeshView {
        self.cameras[1].mesh_view()
    }

    /// Draws the pose with number `i`; poses may come in any order, from many threads.
    pub fn add(&self, i: usize, pose: &PoseView<'_>) {
        if self.chosen[i] {
            let picture = self.draw(THUMBNAIL_SIZE, pose);
            self.drawn().small.insert(i, (pose.name.into(), picture));
        }
        let severity = Severity::of(pose);
        // Most poses are not among the worst and need no large picture; asked again once it is drawn.
        if self.drawn().rank(severity, i) < MAX_LARGE {
            let picture = self.draw(LARGE_SIZE, pose);
            let large = Large { severity, pose: i, name: pose.name.into(), picture, scene: self.scene_pose(pose) };
            let mut drawn = self.drawn();
            let rank = drawn.rank(severity, i);
            drawn.large.insert(rank, large);
            drawn.large.truncate(MAX_LARGE);
        }
    }

    fn drawn(&self) -> MutexGuard<'_, Drawn> {
        self.drawn.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Draws source, result and its errors side by side, each `pixels` wide and high.
    fn draw(&self, pixels: u32, pose: &PoseView<'_>) -> Picture {
        let PoseView { source, result, measurements, verdict, .. } = *pose;
        let Prepared { source: from, target, .. } = self.prepared;
        let shown = field(measurements, verdict);
        let mut picture = Picture::new(pixels * if shown.is_some() { 3 } else { 2 }, pixels, WHITE);
        // All meshes of a picture have as much room as the one with a legend below.
        let height = if shown.is_some() { pixels - LEGEND_HEIGHT } else { pixels };
        if let Some(source) = source {
            let view = self.cameras[0].view(&from.surface.positions).and(&self.cameras[0].view(source));
            let mut canvas = Canvas::new(pixels, height, view);
            canvas.mesh(source, &from.surface.triangles, &Paint::Plain(STEEL));
            canvas.draw_onto(&mut picture, 0, 0);
            write_title(&mut picture, 0, "source");
        }
        let view = self.cameras[1].view(&target.surface.positions).and(&self.cameras[1].view(result));
        let mut canvas = Canvas::new(pixels, height, view);
        canvas.mesh(result, &target.surface.triangles, &Paint::Plain(SAND));
        canvas.draw_onto(&mut picture, pixels as i32, 0);
        write_title(&mut picture, pixels, "result");
        if let Some(measured) = shown {
            let field = Field { values: &measured.field, high: measured.field_high, unit: measured.field_unit };
            draw_field(&mut picture, 2 * pixels, &target.surface, result, view, field);
            write_title(&mut picture, 2 * pixels, measured.field_unit.split(',').next().unwrap_or_default());
        }
        picture
    }

    fn scene_pose(&self, pose: &PoseView<'_>) -> Option<ScenePose> {
        let PoseView { name, source, result, measurements, verdict, .. } = *pose;
        let [of_source, of_target] = self.scene.as_ref()?;
        let target = &self.prepared.target.surface;
        Some(scene_pose(name, [of_source, of_target], source, result, target, field(measurements, verdict)))
    }

    /// Returns the 3D view of the page, if the pipeline asks for one, and the poses for it.
    fn view_3d(&self, poses: Vec<ScenePose>) -> Option<View3d> {
        let script = self.prepared.view_script.clone()?;
        if let Some(reason) = why_not_turned(self.prepared) {
            return Some(View3d::None(reason));
        }
        let [of_source, of_target] = self.scene.as_ref()?;
        let meshes = [of_source.mesh(&self.prepared.source.surface), of_target.mesh(&self.prepared.target.surface)];
        let angles = self.cameras[0].direction.angles();
        (!poses.is_empty()).then(|| View3d::Scene(Box::new(Scene { script, angles, meshes, poses })))
    }

    /// Returns the thumbnails on one sheet, as a PNG file.
    pub fn sheet(&self) -> Vec<u8> {
        let drawn = self.drawn();
        let cells: Vec<Cell> = drawn
            .small
            .values()
            .map(|(name, picture)| Cell { picture: picture.clone(), caption: name.clone() })
            .collect();
        let rows: Vec<Vec<Cell>> = cells.chunks(2).map(<[Cell]>::to_vec).collect();
        let title = self.prepared.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        sheet(&title, &rows).png()
    }

    /// Returns the pictures for the page of the run.
    pub fn pictures(self) -> Pictures {
        let mut drawn = std::mem::take(&mut *self.drawn());
        let poses = drawn.large.iter_mut().filter_map(|large| large.scene.take()).collect();
        Pictures {
            rest: rest_images(self.prepared, self.cameras),
            worst: drawn.large.iter().map(|large| panel_images(&large.name, &large.picture)).collect(),
            sheet: drawn.small.values().map(|(name, picture)| pose_image(name, picture)).collect(),
            view_3d: self.view_3d(poses),
        }
    }
}

impl Drawn {
    /// Returns the place of a pose among the large pictures; of poses as bad as each other the first comes first.
    fn rank(&self, severity: Severity, pose: usize) -> usize {
        let is_before = |other: &&Large| other.severity.compare(severity).then(pose.cmp(&other.pose)).is_gt();
        self.large.iter().filter(is_before).count()
    }
}

impl Severity {
    fn of(pose: &PoseView<'_>) -> Self {
        let level = pose.verdict.map(|verdict| verdict.level).unwrap_or_default();
        let errors = pose.measurements.measured.iter().find(|(name, _)| name == "point_error");
        let error = errors.and_then(|(_, measured)| measured.statistics.number("mean"));
        Self { level, size: error.unwrap_or(pose.limit_ratio) }
    }

    fn compare(self, other: Self) -> Ordering {
        self.level.cmp(&other.level).then(self.size.total_cmp(&other.size))
    }
}

fn write_title(picture: &mut Picture, x: u32, title: &str) {
    picture.text((x + 6) as i32, 4, title, Size::Small, INK);
}

fn pose_image(name: &str, picture: &Picture) -> Image {
    image(name, format!("source, result and errors of pose {name}"), picture)
}

/// Returns the panels of a picture of a pose, each of them a square.
fn panel_images(name: &str, picture: &Picture) -> PanelImages {
    let size = picture.height;
    let panels = ["source", "result", "errors"].into_iter().zip(0..picture.width / size.max(1));
    let panels = panels.map(|(shown, k)| {
        let mut panel = Picture::new(size, size, WHITE);
        panel.paste(picture, -((k * size) as i32), 0);
        image(name, format!("{shown} of pose {name}"), &panel)
    });
    PanelImages { name: name.into(), panels: panels.collect() }
}

/// Returns why the page of a run does not show its meshes in 3D, if they are too large.
fn why_not_turned(prepared: &Prepared) -> Option<String> {
    too_large_to_turn([&prepared.source, &prepared.target].map(|mesh| mesh.surface.triangle_count()))
}

/// Returns both meshes at rest with numbered markers, each seen from the camera and from behind.
fn rest_images(prepared: &Prepared, cameras: [Camera; 2]) -> Vec<Image> {
    let source: Vec<SurfacePoint> = prepared.markers().iter().map(|marker| marker.source).collect();
    let target: Vec<SurfacePoint> = prepared.markers().iter().map(|marker| marker.target).collect();
    let sides = [
        ("source", &prepared.source, source, STEEL, cameras[0], cameras[0].behind()),
        ("target", &prepared.target, target, SAND, cameras[1], cameras[1].behind()),
    ];
    let mut images = Vec::new();
    for (name, side, points, colour, before, behind) in sides {
        for (camera, suffix) in [(before, ""), (behind, ", from behind")] {
            let picture = draw_markers(&side.surface, &points, camera, REST_SIZE, colour);
            let alt = format!("the {name} at rest{suffix}, with {} numbered markers", points.len());
            images.push(image(&format!("{name}{suffix}"), alt, &picture));
        }
    }
    images
}

/// Returns the field to show in colour: the point error if there is one, else that of the verdict's reason, else the stretch.
fn field<'m>(measurements: &'m PoseMeasurements, verdict: Option<&Verdict>) -> Option<&'m Measured> {
    let of = |name: &str| {
        let found =
            measurements.measured.iter().find(|(metric, measured)| metric == name && !measured.field.is_empty());
        found.map(|(_, measured)| measured)
    };
    let reasons = verdict.into_iter().flat_map(|verdict| &verdict.reasons).map(|reason| reason.metric.as_str());
    let wanted = std::iter::once("point_error").chain(reasons).chain(["edge_stretch"]);
    wanted.into_iter().find_map(of).or_else(|| {
        let any = measurements.measured.iter().find(|(_, measured)| !measured.field.is_empty());
        any.map(|(_, measured)| measured)
    })
}
