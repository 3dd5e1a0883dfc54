//! Distance of each vertex to its known position.

use mimesh_core::{
    Error, Figures, Result,
    mesh::Mesh,
    register,
    stage::{Aggregate, BoundMetric, Measured, Metric, MetricContext, MetricInput, Statistic},
};
use nalgebra::{Point3, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{diagonal, vertex_field};

register!(Metric: PointError);

/// Distance of each vertex to its known position, in percent of the diagonal at rest.
///
/// The result is first moved so that the mean p̄ of its vertices lies on the mean t̄ of the known ones. The error of a vertex is
/// eᵢ = 100 ‖(pᵢ − p̄) − (tᵢ − t̄)‖ / diagonal. Percentiles are interpolated linearly between vertices.
///
/// Beside its statistics it gives the curve `within`: for k = 1 … 50 the share of vertices, in percent, with an error of at most
/// 10 (k / 50)² %. That is figure 14 of the 2018 paper, with most points where good results lie.
///
/// It counts the vertices and components of the file, like other programs. Poses that hardly move are held to tighter limits by
/// `still_max`, since an eyelid that stays open moves little.
///
/// Vertices that no polygon uses, and vertices of the result that are not finite, are left out. The field is the error of each vertex.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PointError {}

#[typetag::serde(name = "point_error")]
impl Metric for PointError {
    fn bind<'a>(&self, context: MetricContext<'a>) -> Result<Box<dyn BoundMetric + 'a>> {
        let diagonal = diagonal::of_target(context.surface)?;
        let used = context.rest.used_vertices();
        Ok(Box::new(Bound { context, diagonal, labels: components(context.rest, &used), used }))
    }

    fn statistics(&self) -> Vec<Statistic> {
        vec![
            Statistic::new("mean", "%", "Mean error.")
                .with_title("mean distance from the known result")
                .with_limits(1.0, 5.0),
            Statistic::new("rms", "%", "Root mean square of the error.").with_aggregate(Aggregate::RootMeanSquare),
            Statistic::new("p50", "%", "Median error."),
            Statistic::new("p95", "%", "95th percentile of the error."),
            Statistic::new("p99", "%", "99th percentile of the error."),
            Statistic::new("max", "%", "Largest error.")
                .with_title("largest distance from the known result")
                .with_limits(5.0, 15.0),
            Statistic::new(
                "still_max",
                "%",
                "The same as `max`, if known positions lie less than 5 % from rest in the mean; else it is missing.",
            )
            .with_title("largest distance from the known result, in a small motion")
            .with_limits(1.0, 1.5),
            Statistic::new("placed", "%", "Mean distance of vertices to their known positions, without the move."),
            Statistic::new(
                "comp_mean",
                "%",
                "Mean over components of the distance between their centroids after the move.",
            ),
            Statistic::new("comp_max", "%", "Largest distance between the centroids of a component after the move."),
            Statistic::new("components", "count", "Components of the file's mesh, if it has several."),
            Statistic::new("vertices", "count", "Vertices of the file's mesh that a polygon uses."),
            Statistic::new("nonfinite", "count", "Vertices of the result that are not finite."),
        ]
    }

    fn fault(&self) -> &'static str {
        "the result is far from the known one"
    }

    fn needs_ground_truth(&self) -> bool {
        true
    }

    fn by_default(&self) -> bool {
        true
    }
}

/// Points of the curve `within`.
const CURVE_POINTS: usize = 50;
/// The error at its last point, in percent.
const MAX_CURVE_ERROR: f64 = 10.0;
/// Poses that move less than this are small, such as expressions, in percent.
const STILL_MOTION: f64 = 5.0;

struct Bound<'a> {
    context: MetricContext<'a>,
    diagonal: f64,
    /// Whether a polygon uses the vertex, #V.
    used: Vec<bool>,
    /// The component of each vertex, #V; that of a vertex without polygons does not count.
    labels: Vec<usize>,
}

impl BoundMetric for Bound<'_> {
    fn measure(&self, input: MetricInput<'_>) -> Result<Measured> {
        self.context.check(&input)?;
        let Some(ground_truth) = input.ground_truth else { return Ok(Measured::default()) };
        let (result, known) = (input.result.mesh, ground_truth.mesh);
        let used: Vec<usize> = (0..result.len()).filter(|&v| self.used[v]).collect();
        let count = used.len();
        if let Some(vertex) = used.iter().find(|&&v| !vertex_field::is_finite(&known[v])) {
            return Err(Error::data(
                format!("the truth is not finite at vertex {vertex} (from 0)"),
                "export the known result again without NaN and infinity",
            ));
        }
        let finite: Vec<usize> = used.into_iter().filter(|&v| vertex_field::is_finite(&result[v])).collect();
        let mut statistics = Figures::default();
        statistics.set("vertices", count);
        statistics.set("nonfinite", count - finite.len());
        if finite.len() < count {
            statistics.warn(format!(
                "{} of {count} vertices are not finite and are left out of the errors",
                count - finite.len()
            ));
        }
        if finite.is_empty() {
            return Ok(Measured { statistics, ..Measured::default() });
        }
        let percent = 100.0 / self.diagonal;
        let placed: Vec<Vector3<f64>> = finite.iter().map(|&v| result[v] - known[v]).collect();
        let shift = mean_vector(&placed);
        let aligned: Vec<Vector3<f64>> = placed.iter().map(|d| d - shift).collect();

        let mut errors: Vec<f64> = aligned.iter().map(|d| percent * d.norm()).collect();
        let mut field = vec![f64::NAN; result.len()];
        finite.iter().zip(&errors).for_each(|(&v, &error)| field[v] = error);
        errors.sort_unstable_by(f64::total_cmp);
        let number = errors.len() as f64;
        statistics.set("mean", errors.iter().sum::<f64>() / number);
        statistics.set("rms", (errors.iter().map(|e| e * e).sum::<f64>() / number).sqrt());
        for (name, share) in [("p50", 0.50), ("p95", 0.95), ("p99", 0.99), ("max", 1.0)] {
            statistics.set(name, percentile(&errors, share));
        }
        if percent * motion(&self.context.rest.positions, known, &finite) < STILL_MOTION {
            statistics.set("still_max", percentile(&errors, 1.0));
        }
        let within = |bound: f64| 100.0 * errors.partition_point(|e| *e <= bound) as f64 / number;
        let bound = |k: usize| MAX_CURVE_ERROR * (k as f64 / CURVE_POINTS as f64).powi(2);
        statistics.set("within", (1..=CURVE_POINTS).map(|k| within(bound(k))).collect::<Vec<f64>>());
        statistics.set("placed", percent * placed.iter().map(Vector3::norm).sum::<f64>() / number);

        let labels = &self.labels;
        if finite.iter().any(|&v| labels[v] > 0) {
            let offsets: Vec<f64> = component_offsets(labels, &finite, &aligned).iter().map(|d| percent * d).collect();
            statistics.set("components", offsets.len());
            statistics.set("comp_mean", offsets.iter().sum::<f64>() / offsets.len() as f64);
            statistics.set("comp_max", offsets.iter().copied().fold(0.0, f64::max));
        }
        Ok(Measured { statistics, about: vec![], field, field_unit: "error, %", field_high: 5.0 })
    }
}

/// The mean distance of `known` from `rest` at some vertices after aligning the means, in the unit of the file.
fn motion(rest: &[Point3<f64>], known: &[Point3<f64>], vertices: &[usize]) -> f64 {
    let moved: Vec<Vector3<f64>> = vertices.iter().map(|&v| known[v] - rest[v]).collect();
    let shift = mean_vector(&moved);
    moved.iter().map(|d| (d - shift).norm()).sum::<f64>() / moved.len() as f64
}

/// The mean of `vectors`.
fn mean_vector(vectors: &[Vector3<f64>]) -> Vector3<f64> {
    vectors.iter().sum::<Vector3<f64>>() / vectors.len() as f64
}

/// The value below which `share` (0 to 1) of `sorted` (ascending, not empty) lie, interpolated between neighbours.
fn percentile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + (above - below) * place.fract()
}

/// The component of each vertex of the rest mesh, joined by polygons and numbered by first vertex; 0 for vertices that are not
/// `used`.
fn components(rest: &Mesh, used: &[bool]) -> Vec<usize> {
    let count = rest.positions.len();
    let mut parent: Vec<usize> = (0..count).collect();
    for polygon in rest.polygons.iter().filter(|corners| corners.len() >= 3) {
        for edge in polygon.windows(2) {
            let [a, b] = [edge[0], edge[1]].map(|v| root(&mut parent, v as usize));
            // The smaller vertex stays root, so that components come in order of their first vertex.
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut labels = vec![0; count];
    let mut next = 0;
    for vertex in (0..count).filter(|&v| used[v]) {
        let first = root(&mut parent, vertex);
        if first == vertex {
            labels[vertex] = next;
            next += 1;
        } else {
            labels[vertex] = labels[first];
        }
    }
    labels
}

/// The root of `vertex`, halving the path to it.
fn root(parent: &mut [usize], mut vertex: usize) -> usize {
    while parent[vertex] != vertex {
        parent[vertex] = parent[parent[vertex]];
        vertex = parent[vertex];
    }
    vertex
}

/// The distance that the centroid of each component moves if the vertices `finite` move by `moved`.
fn component_offsets(labels: &[usize], finite: &[usize], moved: &[Vector3<f64>]) -> Vec<f64> {
    let mut sums = vec![(Vector3::zeros(), 0usize); labels.iter().max().map_or(0, |largest| largest + 1)];
    for (&vertex, offset) in finite.iter().zip(moved) {
        let (sum, count) = &mut sums[labels[vertex]];
        *sum += offset;
        *count += 1;
    }
    sums.iter()
        .filter(|(_, count)| *count > 0)
        .map(|(sum, count): &(Vector3<f64>, usize)| sum.norm() / *count as f64)
        .collect()
}

#[cfg(test)]
mod tests {
    use mimesh_core::{
        mesh::{Mesh, Surface},
        stage::Posed,
        testkit::meshes,
    };
    use nalgebra::Point3;
    use proptest::prelude::*;

    use super::*;

    fn mesh(surface: mimesh_core::mesh::Surface) -> Mesh {
        Mesh::from_triangles(surface.positions, &surface.triangles)
    }

    fn measure(rest: &Mesh, result: &[Point3<f64>], known: &[Point3<f64>]) -> Figures {
        try_measure(rest, result, known).unwrap()
    }

    fn try_measure(rest: &Mesh, result: &[Point3<f64>], known: &[Point3<f64>]) -> Result<Figures> {
        let surface = Surface::new(rest)?;
        let context = MetricContext::alone(rest, &surface);
        // It reads positions of the mesh alone.
        let [result, known] = [result, known].map(|mesh| Posed { mesh, ..context.at_rest() });
        Ok(PointError::default().bind(context)?.measure(MetricInput::against(result, known))?.statistics)
    }

    /// Sums of some hundred numbers of size 100 round to about this.
    const ROUNDING: f64 = 1e-11;

    #[track_caller]
    fn assert_statistic(statistics: &Figures, name: &str, expected: f64) {
        let found = statistics.number(name).unwrap();
        assert!((found - expected).abs() < ROUNDING, "{name}: {found}, expected {expected}");
    }

    #[test]
    fn a_move_of_everything_counts_only_as_placed() {
        let rest = mesh(meshes::icosphere(1));
        let moved: Vec<_> = rest.positions.iter().map(|p| p + Vector3::new(0.3, 0.0, 0.4) * rest.diagonal()).collect();
        let statistics = measure(&rest, &moved, &rest.positions);
        ["mean", "rms", "p50", "p95", "p99", "max"].iter().for_each(|name| assert_statistic(&statistics, name, 0.0));
        assert_statistic(&statistics, "placed", 50.0);
        assert!(statistics.number("components").is_none(), "one component has no offsets");
    }

    #[test]
    fn a_scaled_grid_has_errors_in_proportion_to_the_distance_from_its_centre() {
        let rest = mesh(meshes::grid(2, 2));
        let grown: Vec<_> = rest.positions.iter().map(|p| p * 2.0).collect();
        let statistics = measure(&rest, &grown, &rest.positions);
        // Distances from the centre: once 0, four times 1/2, four times 1/√2; the diagonal is √2.
        let (near, far) = (50.0 / 2f64.sqrt(), 50.0);
        assert_statistic(&statistics, "mean", (4.0 * near + 4.0 * far) / 9.0);
        assert_statistic(&statistics, "rms", ((4.0 * near * near + 4.0 * far * far) / 9.0).sqrt());
        assert_statistic(&statistics, "p50", near);
        assert_statistic(&statistics, "p95", far);
        let within = statistics.values["within"].as_array().unwrap();
        assert_eq!((within.len(), within[49].as_f64()), (50, Some(100.0 / 9.0)), "only the centre is within 10 %");
        assert_statistic(&statistics, "max", far);
    }

    #[test]
    fn percentiles_lie_between_neighbours() {
        let sorted = [0.0, 1.0, 2.0, 4.0];
        assert_eq!(percentile(&sorted, 0.5), 1.5);
        assert_eq!(percentile(&sorted, 1.0), 4.0);
        assert!((percentile(&sorted, 0.9) - 3.4).abs() < 1e-12);
        assert_eq!(percentile(&[3.0], 0.5), 3.0);
    }

    #[test]
    fn components_that_move_apart_are_each_off_by_half_of_it() {
        let rest = mesh(meshes::two_components());
        let half = rest.positions.len() / 2;
        let step = Vector3::y() * rest.diagonal();
        let apart: Vec<_> =
            rest.positions.iter().enumerate().map(|(v, p)| if v < half { *p } else { p + step }).collect();
        let statistics = measure(&rest, &apart, &rest.positions);
        assert_statistic(&statistics, "components", 2.0);
        assert_statistic(&statistics, "comp_mean", 50.0);
        assert_statistic(&statistics, "comp_max", 50.0);
        assert_statistic(&statistics, "max", 50.0);
    }

    #[test]
    fn vertices_that_no_polygon_uses_change_nothing() {
        let rest = mesh(meshes::two_components());
        let result: Vec<_> = rest.positions.iter().map(|p| p + Vector3::new(0.0, 0.1 * p.x, 0.3 * p.y * p.z)).collect();
        let alone = measure(&rest, &result, &rest.positions);
        // One before all others, far off, and one behind, which is not even finite in the result.
        let (near, far) = (Point3::new(1e4, -1e3, 7.0), Point3::new(0.0, 0.0, -1e5));
        let between = |positions: &[Point3<f64>], last| [&[near], positions, &[last]].concat();
        let mut with_strays = Mesh { positions: between(&rest.positions, far), ..Mesh::default() };
        rest.polygons.iter().for_each(|t| with_strays.polygons.push(&[t[0] + 1, t[1] + 1, t[2] + 1]));
        let nowhere = Point3::new(f64::NAN, 0.0, 0.0);
        assert_eq!(alone, measure(&with_strays, &between(&result, nowhere), &between(&rest.positions, nowhere)));
    }

    #[test]
    fn vertices_that_are_not_finite_are_counted_and_left_out() {
        let rest = mesh(meshes::tetrahedron());
        let mut result = rest.positions.clone();
        result[2].y = f64::NAN;
        let statistics = measure(&rest, &result, &rest.positions);
        assert_statistic(&statistics, "nonfinite", 1.0);
        assert_statistic(&statistics, "max", 0.0);
        assert_eq!(statistics.warnings, ["1 of 4 vertices are not finite and are left out of the errors"]);
        result.iter_mut().for_each(|p| p.x = f64::INFINITY);
        assert_eq!(measure(&rest, &result, &rest.positions).number("mean"), None);
    }

    #[test]
    fn counts_that_differ_and_a_mesh_without_size_are_errors() {
        let rest = mesh(meshes::tetrahedron());
        let error = try_measure(&rest, &rest.positions[1..], &rest.positions).unwrap_err();
        assert_eq!(error.to_string(), "vertices of the result (#V): expected 4, found 3");
        let error = try_measure(&rest, &rest.positions, &rest.positions[1..]).unwrap_err();
        assert_eq!(error.to_string(), "vertices of the truth (#V): expected 4, found 3");
        let flat = Mesh { positions: vec![Point3::origin(); 4], ..rest.clone() };
        assert!(try_measure(&flat, &rest.positions, &rest.positions).unwrap_err().to_string().contains("diagonal 0"));
    }

    proptest! {
        #[test]
        fn statistics_are_ordered_and_do_not_depend_on_where_the_result_lies(
            offsets in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 42),
            shift in prop::array::uniform3(-10.0..10.0f64),
        ) {
            let rest = mesh(meshes::icosphere(1));
            let result: Vec<_> = rest.positions.iter().zip(&offsets).map(|(p, &d)| p + Vector3::from(d)).collect();
            let moved: Vec<_> = result.iter().map(|p| p + Vector3::from(shift)).collect();
            let (one, other) = (measure(&rest, &result, &rest.positions), measure(&rest, &moved, &rest.positions));
            let get = |name| one.number(name).unwrap();
            prop_assert!(get("p50") <= get("p95") && get("p95") <= get("p99") && get("p99") <= get("max"));
            prop_assert!(get("mean") <= get("rms") && get("rms") <= get("max"));
            for name in ["mean", "rms", "p50", "max"] {
                // Moving by up to ten radii costs a digit.
                prop_assert!((get(name) - other.number(name).unwrap()).abs() < 10.0 * ROUNDING, "{}", name);
            }
        }
    }
}
