//! The points that may be chosen, and the sets of them that can serve.

use mimesh_core::{
    Error, Figures, Result,
    mesh::{MeshPoint, Surface, SurfacePoint},
    stage::{AvailablePoints, KeyPointsInput, Sampler},
};
use nalgebra::{Matrix3, Point3, Vector3};

/// Transfers need three points: `biharmonic` to fit a similarity, `nonrigid_fit` to see how the shapes lie to each other.
pub const MIN_POINTS: usize = 3;

/// The points of a sampler, as many as the source offers; `figures` reports their number, and that they are fewer than asked.
pub fn sample(sampler: &dyn Sampler, source: &Surface, figures: &mut Figures) -> Result<Vec<SurfacePoint>> {
    let AvailablePoints { points, asked } = sampler.sample_available(source)?;
    if points.is_empty() {
        return Err(Error::data("the sampler gives no candidates", "choose another `sampler`"));
    }
    if points.len() < asked {
        figures.warn(format!(
            "the source offers only {} of the {asked} candidates that the sampler is to find, so these were used",
            points.len()
        ));
    }
    Ok(points)
}

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

/// What a set of candidates needs to serve as handles and as markers.
pub struct HandleRules {
    names: Vec<String>,
    positions: Vec<Point3<f64>>,
    /// The component of each candidate where each component needs a handle of its own; else nothing.
    components: Option<Vec<Option<u32>>>,
    /// Whether some of the candidates span a plane.
    plane: bool,
}

impl HandleRules {
    /// The rules for `points` on `source`, whose components are linked or not.
    pub fn new(source: &Surface, points: &[SurfacePoint], is_linked: bool) -> Self {
        let positions: Vec<_> = points.iter().map(|point| point.position(source, &source.positions)).collect();
        let components = source.components();
        let of = |point: &SurfacePoint| components.of_vertex[nearest_vertex(source, *point) as usize];
        let name = |(k, point): (usize, &SurfacePoint)| match source.mesh_point(*point) {
            MeshPoint::Vertex(vertex) => format!("candidate {k} (vertex {vertex})"),
            MeshPoint::Triangle(triangle, _) => format!("candidate {k} (on triangle {triangle})"),
        };
        Self {
            names: points.iter().enumerate().map(name).collect(),
            plane: spans_plane(&positions),
            positions,
            components: (!is_linked).then(|| points.iter().map(of).collect()),
        }
    }

    /// A candidate in words: its number, and where it is.
    pub fn name(&self, candidate: usize) -> &str {
        &self.names[candidate]
    }

    /// Whether the set has the points that transfers need, on no line if the candidates allow that.
    pub fn span_enough(&self, set: &[usize]) -> bool {
        let places: Vec<_> = set.iter().map(|&k| self.positions[k]).collect();
        set.len() >= MIN_POINTS && (!self.plane || spans_plane(&places))
    }

    /// Whether `other` can serve where `set` does: on the same components, and not on a line if `set` is not.
    pub fn can_replace(&self, set: &[usize], other: &[usize]) -> bool {
        self.reached(set) == self.reached(other) && (self.span_enough(other) || !self.span_enough(set))
    }

    /// The components that need a handle and have one.
    fn reached(&self, set: &[usize]) -> Vec<u32> {
        let Some(components) = &self.components else { return vec![] };
        let mut reached: Vec<u32> = set.iter().filter_map(|&k| components[k]).collect();
        reached.sort_unstable();
        reached.dedup();
        reached
    }
}

/// Whether the points span a plane, to 1e-6 of their spread, as `nonrigid_fit` demands of markers.
fn spans_plane(points: &[Point3<f64>]) -> bool {
    let mean = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p.coords - mean) * (p.coords - mean).transpose()).sum();
    let values = spread.symmetric_eigenvalues();
    let mut sorted = [values[0], values[1], values[2]];
    sorted.sort_by(f64::total_cmp);
    sorted[1] > 1e-12 * sorted[2]
}

/// The vertex at a point, or the nearest corner of its triangle.
pub fn nearest_vertex(source: &Surface, point: SurfacePoint) -> u32 {
    let corners = point.corners(source);
    corners.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(0, |(v, _)| v)
}
