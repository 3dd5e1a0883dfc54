//! Choosing key points on a source, and the file of markers that is to be completed.

use nalgebra::Point3;
use rayon::prelude::*;

use super::{check::PreparedSource, hash_file, poses};
use crate::{
    core::{
        mesh::{MeshSequence, Surface, SurfacePoint},
        stage::{ChoiceStep, ChoiceWatch, Chosen, KeyPointsInput},
    },
    diagnostic::Result,
    markers::{Entry, MarkerFile, MeshReference},
};

/// Chooses key points for the source, starting from the source points of `start`.
///
/// # Errors
///
/// If a pose cannot be read, or the stage refuses.
pub fn choose(prepared: &PreparedSource, start: &MarkerFile, watch: &dyn ChoiceWatch) -> Result<Chosen> {
    let PreparedSource { source, poses, formats, key_points, .. } = prepared;
    let read = |pose: &super::check::PoseInput| -> crate::core::Result<Vec<Point3<f64>>> {
        source.surface.from_mesh(&poses::read(source, formats, &pose.from)?)
    };
    let poses: Vec<_> = poses
        .par_iter()
        .map(|pose| read(pose).map_err(|error| super::run::of_pose(&pose.name, None, None, error)))
        .collect::<std::result::Result<_, _>>()?;
    let start: Vec<SurfacePoint> =
        start.entries.iter().map(|entry| on_surface(&source.surface, entry.source)).collect();
    let input = KeyPointsInput { source: &source.surface, poses: &poses, start: &start };
    let doing =
        |error| crate::diagnostic::Diagnostic::from(error).doing(format!("key_points ({})", key_points.typetag_name()));
    Ok(key_points.choose(input, watch).map_err(doing)?)
}

/// The point of the surface for a point of the mesh; those that do not exist are the stage's to refuse.
fn on_surface(surface: &Surface, point: SurfacePoint) -> SurfacePoint {
    match point {
        SurfacePoint::Vertex(v) => SurfacePoint::Vertex(surface.vertex_of.get(v as usize).copied().unwrap_or(u32::MAX)),
        point => point,
    }
}

/// The file of markers for `points`: those of `before` with their targets, the others without.
pub fn to_complete(prepared: &PreparedSource, points: &[SurfacePoint], before: &MarkerFile) -> MarkerFile {
    let source = &prepared.source;
    let of_mesh = |point: SurfacePoint| match point {
        SurfacePoint::Vertex(v) => SurfacePoint::Vertex(source.surface.representative[v as usize]),
        point => point,
    };
    let mut entries: Vec<Entry> = Vec::new();
    // Names of points that were there before stay theirs.
    let mut free = (1..)
        .map(|k| format!("key {k}"))
        .filter(|name| before.entries.iter().all(|entry| entry.name.as_ref() != Some(name)));
    for &point in points {
        let on_mesh = of_mesh(point);
        let known = before.entries.iter().find(|entry| of_mesh(on_surface(&source.surface, entry.source)) == on_mesh);
        entries.push(match known {
            Some(entry) => Entry { location: None, ..entry.clone() },
            None => Entry {
                name: free.next(),
                source: on_mesh,
                target: None,
                note: Some(note(&source.sequence, &source.surface, point)),
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
    MarkerFile { source: of_source, target: reference(prepared.target.as_deref()), entries }
}

/// Where a point is, in words: the part, the nearest landmark, and the place in the bounding box.
fn note(sequence: &MeshSequence, surface: &Surface, point: SurfacePoint) -> String {
    let at = point.position(surface, &surface.positions);
    let mut words = Vec::new();
    let landmarks = sequence.landmarks.iter().map(|landmark| {
        let there = on_surface(surface, landmark.point).position(surface, &surface.positions);
        ((there - at).norm(), &landmark.name)
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

/// The curve of figure 6 of Yang et al. 2018, error over number of points, as an SVG picture.
pub fn curve(steps: &[ChoiceStep]) -> String {
    use std::fmt::Write;
    const WIDTH: f64 = 640.0;
    const HEIGHT: f64 = 400.0;
    const MARGIN: f64 = 60.0;
    let most = steps.iter().map(|step| step.points.len()).max().unwrap_or(1).max(2) as f64;
    let top = steps.iter().map(|step| step.error).fold(0.0, f64::max).max(1e-12);
    let x = |count: usize| MARGIN + (count as f64 - 1.0) / (most - 1.0) * (WIDTH - 2.0 * MARGIN);
    let y = |error: f64| HEIGHT - MARGIN - error / top * (HEIGHT - 2.0 * MARGIN);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for k in 0..=4 {
        let error = top * f64::from(k) / 4.0;
        let _ = writeln!(
            svg,
            "<path d=\"M{MARGIN} {y:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{text}\" y=\"{y:.1}\" \
             text-anchor=\"end\">{error:.4}</text>",
            y = y(error),
            right = WIDTH - MARGIN,
            text = MARGIN - 8.0,
        );
    }
    for count in 1..=most as usize {
        if count == 1 || count % (most as usize / 10 + 1) == 0 {
            let (at, below) = (x(count), HEIGHT - MARGIN + 18.0);
            let _ = writeln!(svg, "<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{count}</text>");
        }
    }
    let points = |exchanged: bool| steps.iter().filter(move |step| step.exchanged == exchanged);
    let line: Vec<_> = points(false).map(|step| format!("{:.1},{:.1}", x(step.points.len()), y(step.error))).collect();
    let _ =
        writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"#1f77b4\" stroke-width=\"2\"/>", line.join(" "));
    for (exchanged, colour) in [(false, "#1f77b4"), (true, "#d62728")] {
        for step in points(exchanged) {
            let (x, y) = (x(step.points.len()), y(step.error));
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>");
        }
    }
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">key points</text>\n<text x=\"{MARGIN}\" y=\"24\">mean distance to \
         the poses, the source in the unit sphere (red: after exchanges)</text>\n</svg>",
        WIDTH / 2.0,
        HEIGHT - 12.0
    );
    svg
}
