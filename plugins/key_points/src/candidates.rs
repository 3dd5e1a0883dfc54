//! The points that may be chosen.

use mimesh_core::{
    Error, Result,
    mesh::{Surface, SurfacePoint},
    stage::KeyPointsInput,
};

/// Checks that there are poses, and that they are poses of the source.
pub fn check_poses(input: KeyPointsInput<'_>) -> Result<()> {
    if input.poses.is_empty() {
        return Err(Error::data("no poses to choose key points for", "give the source poses"));
    }
    let count = input.source.vertex_count();
    input.poses.iter().try_for_each(|pose| Error::check_shape("vertices of a pose (#V)", count, pose.len()))
}

/// Checks that points to start from exist.
pub fn check(source: &Surface, start: &[SurfacePoint]) -> Result<()> {
    for point in start {
        let (what, number, count) = match *point {
            SurfacePoint::Vertex(v) => ("vertex", v, source.vertex_count()),
            SurfacePoint::Triangle(t, _) => ("triangle", t, source.triangle_count()),
        };
        if number as usize >= count {
            return Err(Error::data(
                format!(
                    "a key point to start from is {what} {number}, which the source does not have: expected 0 to {}",
                    count - 1
                ),
                "were the points made on another mesh? Start anew",
            ));
        }
    }
    Ok(())
}

/// The candidates with the points `start` added where they are none yet, and the numbers of the latter.
pub fn with_start(
    source: &Surface,
    mut points: Vec<SurfacePoint>,
    start: &[SurfacePoint],
) -> (Vec<SurfacePoint>, Vec<usize>) {
    let mut numbers = Vec::new();
    for point in start {
        let vertex = nearest_vertex(source, *point);
        let found = points.iter().position(|other| nearest_vertex(source, *other) == vertex);
        let number = found.unwrap_or_else(|| {
            points.push(*point);
            points.len() - 1
        });
        if !numbers.contains(&number) {
            numbers.push(number);
        }
    }
    (points, numbers)
}

/// `chosen` and the first candidate on each component that has none of them.
pub fn cover_components(source: &Surface, points: &[SurfacePoint], mut chosen: Vec<usize>) -> Vec<usize> {
    let components = source.components();
    let of = |k: usize| components.of_vertex[nearest_vertex(source, points[k]) as usize];
    let mut reached = vec![false; components.count()];
    chosen.iter().filter_map(|&k| of(k)).for_each(|c| reached[c as usize] = true);
    for k in 0..points.len() {
        if let Some(c) = of(k)
            && !std::mem::replace(&mut reached[c as usize], true)
        {
            chosen.push(k);
        }
    }
    chosen
}

/// The vertex at a point, or the nearest corner of its triangle.
fn nearest_vertex(source: &Surface, point: SurfacePoint) -> u32 {
    let corners = point.corners(source);
    corners.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(0, |(v, _)| v)
}
