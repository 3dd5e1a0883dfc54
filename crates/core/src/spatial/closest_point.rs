use nalgebra::Point3;
use parry3d_f64::{
    math::Vector,
    partitioning::BvhNode,
    query::{PointQuery as _, PointQueryWithLocation as _},
    shape::{TriMesh, TriMeshBuilderError},
};

use crate::{Error, Result};

/// Finds the closest point of a surface, by a bounding volume hierarchy over its triangles.
pub struct ClosestPoint {
    mesh: TriMesh,
}

/// A point found on a surface.
#[derive(Clone, Copy, Debug)]
pub struct OnSurface {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric coordinates of its corners.
    pub barycentric: [f64; 3],
    /// The point.
    pub point: Point3<f64>,
    /// Its distance to the query.
    pub distance: f64,
}

impl ClosestPoint {
    /// Prepares to search the triangles over `positions`.
    ///
    /// # Errors
    ///
    /// [`Error::Data`] if there is no triangle.
    pub fn new(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self> {
        let vertices = positions.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        match TriMesh::new(vertices, triangles.to_vec()) {
            Ok(mesh) => Ok(Self { mesh }),
            Err(TriMeshBuilderError::EmptyIndices) => {
                Err(Error::data("a surface without triangles has no closest point", "give a mesh with triangles"))
            }
            Err(error) => Err(Error::Other(Box::new(error))),
        }
    }

    /// What [`find`](Self::find) gives, sooner where `guess`, a triangle that `accept` takes, is near.
    pub fn find_near(
        &self,
        query: &Point3<f64>,
        max_distance: f64,
        guess: u32,
        accept: impl Fn(u32) -> bool,
    ) -> Option<OnSurface> {
        let at = Vector::new(query.x, query.y, query.z);
        let (projection, _) = self.mesh.triangle(guess).project_local_point_and_get_location(at, true);
        // Wide enough that all that the search compares with the nearest is compared, whatever the rounding of distances: then it
        // finds the same one among equals.
        let bounds = self.mesh.bvh().root_aabb();
        let size = bounds.mins.abs().max(bounds.maxs.abs()).max(at.abs()).max_element();
        let reach = (projection.point - at).length() * (1.0 + 1e-9) + 1e-12 * size;
        // Not `min`, which would hide NaN.
        let limit = if reach < max_distance { reach } else { max_distance };
        self.find(query, limit, accept)
    }

    /// The closest point of the triangles that `accept` takes, if there is one nearer than `max_distance`.
    pub fn find(&self, query: &Point3<f64>, max_distance: f64, accept: impl Fn(u32) -> bool) -> Option<OnSurface> {
        let query = Vector::new(query.x, query.y, query.z);
        let found = self.mesh.bvh().find_best(
            max_distance,
            |node: &BvhNode, _| node.aabb().distance_to_local_point(query, true),
            |triangle, _| {
                if !accept(triangle) {
                    return None;
                }
                let (projection, location) =
                    self.mesh.triangle(triangle).project_local_point_and_get_location(query, true);
                let barycentric = location.barycentric_coordinates().unwrap_or([1.0, 0.0, 0.0]);
                Some(((projection.point - query).length(), (projection.point, barycentric)))
            },
        );
        found.map(|(triangle, (distance, (point, barycentric)))| OnSurface {
            triangle,
            barycentric,
            point: Point3::new(point.x, point.y, point.z),
            distance,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    type Soup = (Vec<Point3<f64>>, Vec<[u32; 3]>, Vec<Point3<f64>>);

    /// Positions, triangles and queries with the given coordinates.
    fn soup_of<S: Strategy<Value = f64> + Clone + 'static>(coordinate: S) -> impl Strategy<Value = Soup> {
        let point = [coordinate.clone(), coordinate.clone(), coordinate];
        let point = point.prop_map(|[x, y, z]| Point3::new(x, y, z)).boxed();
        (
            prop::collection::vec(point.clone(), 6..12),
            prop::collection::vec([0..6_u32, 0..6_u32, 0..6_u32], 1..40),
            prop::collection::vec(point, 12),
        )
    }

    fn soup() -> impl Strategy<Value = Soup> {
        // Of few values, so that triangles are often degenerate, coplanar or coincident and distances often equal.
        let coarse = || (-6..=6_i32).prop_map(|x| f64::from(x) / 3.0).boxed();
        let flat = soup_of(coarse()).prop_map(|(mut positions, triangles, queries)| {
            positions.iter_mut().for_each(|p| p.z = 1.0);
            (positions, triangles, queries)
        });
        prop_oneof![soup_of(coarse()), flat, soup_of((-1.0..1.0_f64).boxed())]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn a_guess_changes_nothing((positions, triangles, queries) in soup(), far in 0..4_usize) {
            let search = ClosestPoint::new(&positions, &triangles).unwrap();
            let max_distance = [f64::INFINITY, 1.0, 0.3, 0.0][far];
            for query in &queries {
                for odd in [false, true] {
                    let accept = |t: u32| !odd || t % 2 == 1;
                    let cold = search.find(query, max_distance, accept);
                    for guess in (0..triangles.len() as u32).filter(|&t| accept(t)) {
                        let warm = search.find_near(query, max_distance, guess, accept);
                        let bits = |found: Option<OnSurface>| found.map(|f| {
                            let numbers = [f.point.x, f.point.y, f.point.z, f.distance];
                            (f.triangle, numbers.map(f64::to_bits), f.barycentric.map(f64::to_bits))
                        });
                        prop_assert_eq!(bits(warm), bits(cold));
                    }
                }
            }
        }
    }
}
