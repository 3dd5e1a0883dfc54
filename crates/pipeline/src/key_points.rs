//! Choosing key points on a source, and the file of markers that is to be completed.

use mimesh_core::{
    mesh::{MeshPoint, MeshSequence, Surface, SurfacePoint},
    stage::{ChoiceStep, ChoiceWatch, Chosen, KeyPointsInput},
};
use mimesh_document::{diagnostic::Result, files::hash_file};
use mimesh_markers::{IntoDiagnostic, MarkerFile, MarkerPair, MarkerStatus, MeshReference};
use nalgebra::Point3;
use rayon::prelude::*;

use crate::{
    input::{PoseInput, PreparedSource, read_pose},
    page::chart::{self, Axes, Line, round_up},
};

/// Chooses key points for the source, starting from the source points of `start`.
///
/// # Errors
///
/// If a pose cannot be read, or the stage refuses.
pub fn choose(prepared: &PreparedSource, start: &MarkerFile, watch: &dyn ChoiceWatch) -> Result<Chosen> {
    let PreparedSource { source, poses, formats, key_points, .. } = prepared;
    let read = |pose: &PoseInput| -> mimesh_core::Result<Vec<Point3<f64>>> {
        source.surface.from_mesh(&read_pose(source, formats, &pose.from)?)
    };
    let poses: Vec<_> = poses
        .par_iter()
        .map(|pose| read(pose).map_err(|error| crate::run::pose_error(&pose.name, None, None, error)))
        .collect::<std::result::Result<_, _>>()?;
    let start: Vec<SurfacePoint> =
        start.pairs.iter().filter_map(|pair| Some(on_surface(&source.surface, pair.source?))).collect();
    let input = KeyPointsInput { source: &source.surface, poses: &poses, start: &start };
    let doing = |error: mimesh_core::Error| {
        error.into_diagnostic().doing(format!("key_points ({})", key_points.typetag_name()))
    };
    Ok(key_points.choose(input, watch).map_err(doing)?)
}

/// The point of the surface for a point of the mesh; one that does not exist becomes a vertex that does not, for the stage to refuse.
fn on_surface(surface: &Surface, point: MeshPoint) -> SurfacePoint {
    surface.point(point).unwrap_or(SurfacePoint::Vertex(u32::MAX))
}

/// The file of markers for `points`: those of `before` with their targets, the others without.
pub fn to_complete(prepared: &PreparedSource, points: &[SurfacePoint], before: &MarkerFile) -> MarkerFile {
    let source = &prepared.source;
    let mut pairs: Vec<MarkerPair> = Vec::new();
    // Names of points that were there before stay theirs.
    let mut free = (1..)
        .map(|k| format!("key {k}"))
        .filter(|name| before.pairs.iter().all(|pair| pair.name.as_ref() != Some(name)));
    for &point in points {
        let on_mesh = source.surface.mesh_point(point);
        let is_it = |pair: &&MarkerPair| {
            let known = pair.source.and_then(|point| source.surface.point(point));
            known.is_some_and(|point| source.surface.mesh_point(point) == on_mesh)
        };
        pairs.push(match before.pairs.iter().find(is_it) {
            Some(pair) => MarkerPair { location: None, ..pair.clone() },
            None => MarkerPair {
                name: free.next(),
                source: Some(on_mesh),
                target: None,
                note: Some(note(&source.sequence, &source.surface, point)),
                status: MarkerStatus::Confirmed,
                confidence: None,
                at: [None; 2],
                location: None,
            },
        });
    }
    let reference = |path: Option<&std::path::Path>| {
        path.map(|path| MeshReference {
            mesh: path.file_name().map(|name| name.to_string_lossy().into_owned()),
            vertices: None,
            blake3: None,
        })
    };
    let mut of_source = reference(source.path.as_deref());
    if let (Some(of_source), Some(path)) = (&mut of_source, &source.path) {
        of_source.vertices = Some(source.sequence.rest.positions.len());
        of_source.blake3 = hash_file(path).ok();
    }
    MarkerFile { source: of_source, target: reference(prepared.target.as_deref()), pairs }
}

/// Where a point is, in words: the part, the nearest landmark, and the place in the bounding box.
fn note(sequence: &MeshSequence, surface: &Surface, point: SurfacePoint) -> String {
    let at = point.position(surface, &surface.positions);
    let mut words = Vec::new();
    let landmarks = sequence.landmarks.iter().filter_map(|landmark| {
        let there = surface.point(landmark.point)?.position(surface, &surface.positions);
        Some(((there - at).norm(), &landmark.name))
    });
    if let Some((distance, name)) = landmarks.min_by(|a, b| a.0.total_cmp(&b.0)) {
        words.push(if distance == 0.0 { format!("at {name}") } else { format!("near {name}") });
    }
    let corner = point.corners(surface).first().map_or(0, |corner| corner.0);
    let triangle = surface.triangles.iter().position(|t| t.contains(&corner));
    if let Some(part) = triangle.and_then(|t| surface.part_of.get(t))
        && !surface.part_names[*part as usize].is_empty()
    {
        words.push(format!("on {}", surface.part_names[*part as usize]));
    }
    // Four digits of the size tell a place well enough to a person.
    let digits = (3 - surface.diagonal().max(1e-12).log10().floor() as i32).clamp(0, 15) as usize;
    words.push(format!("at x {:.digits$}, y {:.digits$}, z {:.digits$}", at.x, at.y, at.z));
    let (mut low, mut high) = (at, at);
    for p in &surface.positions {
        low = low.inf(p);
        high = high.sup(p);
    }
    let place = |k: usize, names: [&'static str; 3]| {
        let share = if high[k] > low[k] { (at[k] - low[k]) / (high[k] - low[k]) } else { 0.5 };
        names[((share * 3.0) as usize).min(2)]
    };
    let sides = [
        place(0, ["-x side", "middle of x", "+x side"]),
        place(1, ["-y side", "middle of y", "+y side"]),
        place(2, ["-z side", "middle of z", "+z side"]),
    ];
    words.push(sides.join(", "));
    words.join("; ")
}

/// Returns the curve of figure 6 of Yang et al. 2018, error over number of points, as an SVG file.
pub fn curve(steps: &[ChoiceStep]) -> String {
    let points = |exchanged: bool| -> Vec<[f64; 2]> {
        let of_kind = steps.iter().filter(|step| step.exchanged == exchanged);
        of_kind.map(|step| [step.points.len() as f64, step.error]).collect()
    };
    let most = steps.iter().map(|step| step.points.len()).max().unwrap_or(1);
    let highest = steps.iter().map(|step| step.error).fold(0.0, f64::max);
    let axes = Axes {
        title: "Mean distance to the poses",
        x: "key points",
        y: "source in the unit sphere",
        upto: [most as f64, round_up(highest)],
        counts: true,
        limit: None,
    };
    let added = Line { dots: true, ..Line::new("thick", points(false)) }.named("var(--accent)", "a point added");
    let exchanged = Line { dots: true, points: points(true), ..Line::default() }.named("var(--bad)", "after exchanges");
    chart::file(&axes, &[added, exchanged])
}
