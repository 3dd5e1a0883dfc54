use mimesh_core::{mesh::Surface, spatial::Nearest};
use nalgebra::{Matrix3, Point3, Vector3};

/// Vertices that no triangle uses: they go with the nearest vertex that one does.
#[derive(Debug)]
pub struct Unreferenced {
    /// The loose vertex, the nearest used one, a triangle around that, and the way from there at rest.
    vertices: Vec<(u32, u32, u32, Vector3<f64>)>,
}

impl Unreferenced {
    pub fn new(target: &Surface) -> Self {
        let mut triangle = vec![None; target.vertex_count()];
        for (t, corners) in target.triangles.iter().enumerate() {
            for &v in corners {
                triangle[v as usize].get_or_insert(t as u32);
            }
        }
        let used: Vec<usize> = (0..triangle.len()).filter(|&v| triangle[v].is_some()).collect();
        let places: Vec<Point3<f64>> = used.iter().map(|&v| target.positions[v]).collect();
        let loose = (0..triangle.len()).filter(|&v| triangle[v].is_none());
        let vertices = match Nearest::new(&places) {
            Ok(nearest) => loose
                .filter_map(|v| {
                    let by = used[nearest.find(&target.positions[v]).0 as usize];
                    Some((v as u32, by as u32, triangle[by]?, target.positions[v] - target.positions[by]))
                })
                .collect(),
            Err(_) => vec![],
        };
        Self { vertices }
    }

    /// Number of loose vertices.
    pub fn count(&self) -> usize {
        self.vertices.len()
    }

    /// Puts them where the deformation gradients of the triangles by them carry them.
    pub fn place(&self, gradient: impl Fn(usize) -> Matrix3<f64>, positions: &mut [Point3<f64>]) {
        for &(v, by, triangle, way) in &self.vertices {
            positions[v as usize] = positions[by as usize] + gradient(triangle as usize) * way;
        }
    }
}
