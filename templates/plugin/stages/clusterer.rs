//! A region a handle: the vertices that follow it more than any other.

use mimesh_core::{
    Error, Figures, Result,
    mesh::Surface,
    register,
    stage::{BoundClusterer, Clusterer, Regions},
};
use nalgebra::{DMatrix, Point3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Clusterer: MyStage);

/// A region a handle: the vertices that follow it more than any other.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MyStage {}

#[typetag::serde(name = "my_stage")]
impl Clusterer for MyStage {
    // What depends on the surface and its poses is done here, once. This method needs no more of them than their size.
    fn bind(&self, surface: &Surface, poses: &[Vec<Point3<f64>>]) -> Result<Box<dyn BoundClusterer>> {
        for pose in poses {
            Error::check_shape("vertices of a pose (#V)", surface.vertex_count(), pose.len())?;
        }
        Ok(Box::new(Bound { vertices: surface.vertex_count() }))
    }
}

#[derive(Debug)]
struct Bound {
    vertices: usize,
}

impl BoundClusterer for Bound {
    fn cluster(&self, weights: &DMatrix<f64>) -> Result<Regions> {
        Error::check_shape("rows of W (#V)", self.vertices, weights.nrows())?;
        Error::check_shape("columns of W, one handle at least", weights.ncols().max(1), weights.ncols())?;
        // The first of equal ones.
        let strongest =
            |v: usize| (1..weights.ncols()).fold(0, |k, j| if weights[(v, j)] > weights[(v, k)] { j } else { k });
        let of_vertex: Vec<usize> = (0..self.vertices).map(strongest).collect();
        // Handles that are nowhere strongest have no region.
        let mut number = vec![None; weights.ncols()];
        let mut count = 0;
        for &handle in &of_vertex {
            number[handle].get_or_insert_with(|| {
                count += 1;
                count as u32 - 1
            });
        }
        let of_vertex = of_vertex.into_iter().map(|handle| number[handle].unwrap_or_default()).collect();
        Ok(Regions { of_vertex, count, figures: Figures::default() })
    }
}

#[cfg(test)]
mod tests {
    use mimesh_core::testkit::meshes;

    use super::*;

    #[test]
    fn a_vertex_is_where_its_weight_is_greatest() {
        let surface = meshes::tetrahedron();
        let weights = DMatrix::from_row_slice(4, 3, &[0.2, 0.8, 0.0, 0.9, 0.1, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0, 0.0]);
        let regions = MyStage::default().bind(&surface, &[]).unwrap().cluster(&weights).unwrap();
        assert_eq!((regions.count, regions.of_vertex), (2, vec![0, 1, 1, 0]));
    }
}
